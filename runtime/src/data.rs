//! The contents of a model file, as plain arrays. [`crate::Model`] is made from it and checks it.
//!
//! Modal order everywhere: elastic modes `0..m`, then the six rigid ones (`beta*`: v then w). Matrices are row-major.

use alloc::{string::String, vec::Vec};
use serde::{Deserialize, Serialize};

use crate::loads::{DistributedLoad, Load, LoadCase};

/// Everything a model file holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelData {
    /// Where the model comes from.
    pub provenance: Provenance,
    /// Rigid-body properties at the equilibrium.
    pub rigid: RigidData,
    /// Elastic free-free modes, ascending frequency.
    pub modes: ModesData,
    /// `c_ilr` of theory (25): row i gains `c_ilr u_l beta_r`. Indices i, l in `0..m+6`, r in `0..6`.
    pub c: TensorData,
    /// `kgyr_ilrs` of theory (25), stored for r <= s with both halves added: row i gains `k_ilrs q_l beta_r beta_s`.
    /// Indices i in `0..m+6`, l in `0..m`, r, s in `0..6`.
    pub k: TensorData,
    /// Named points.
    pub points: Vec<PointData>,
    /// Load cases of the structure file.
    pub load_cases: Vec<LoadCase>,
    /// Lines for pictures, optional.
    pub picture: Option<PictureData>,
    /// The loaded equilibrium that the model is about; none about the unloaded structure.
    pub trim: Option<TrimData>,
    /// Inertial sensors.
    pub sensors: Vec<SensorData>,
    /// Uniform gravity; none in weightlessness.
    pub gravity: Option<GravityData>,
    /// Axes of the members, in the order of the structure file, for loads distributed along them.
    pub lines: Vec<LineData>,
    /// Blocks of stations for aerodynamic codes.
    pub stations: Vec<StationsData>,
    /// Damping that couples modes; none where it is that of the ratios alone.
    pub damping: Option<DampingData>,
    /// Checks made by the generator when it built the model.
    pub checks: Vec<CheckData>,
}

/// Where a model comes from; enough to build it again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the structure.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub name: String,
    /// Tool and version that wrote the model.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub generator: String,
    /// The structure file, verbatim.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub input_text: String,
    /// SHA-256 of the text, lower-case hexadecimal.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub input_sha256: String,
    /// `--set` values and other build options, in the order given: (option, value).
    #[serde(deserialize_with = "crate::format::text::string_pairs")]
    pub options: Vec<(String, String)>,
    /// Parameters of the structure after `--set`: (name, value).
    #[serde(deserialize_with = "crate::format::text::named")]
    pub parameters: Vec<(String, f64)>,
    /// Number of finite elements.
    pub n_elements: u64,
    /// Number of degrees of freedom of the finite-element model, rigid ones included.
    pub n_dof: u64,
}

/// Rigid-body properties at the equilibrium.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RigidData {
    /// Total mass, kg.
    pub mass: f64,
    /// Centre of mass in A, m - (3).
    pub centre_of_mass: [f64; 3],
    /// `M_RR` about the origin of A: kg, kg m, kg m^2 - (6 x 6), rows and columns v then w.
    pub mass_matrix: Vec<f64>,
    /// Position of the origin of A in G at t = 0, m - (3).
    pub initial_position: [f64; 3],
}

/// Elastic modes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModesData {
    /// Number in the ascending list of the structure's elastic modes, from 1 - (m).
    pub number: Vec<u32>,
    /// Circular frequency, rad/s - (m).
    pub omega: Vec<f64>,
    /// Generalised mass `phi^t M phi`, kg m^2 - (m); 1 by construction.
    pub mass: Vec<f64>,
    /// Critical damping ratio, 1 - (m).
    pub damping_ratio: Vec<f64>,
    /// `Phi_R`: rate of A per unit modal rate - (6 x m).
    pub phi_r: Vec<f64>,
    /// `int rho A dR_A` per unit modal amplitude, kg m - (3 x m): the centre of mass in A moves by this over the mass.
    pub first_moment: Vec<f64>,
    /// Share of the kinetic energy by direction: translation along and rotation about x, y, z of A, 1 - (m x 6).
    pub kinetic_share: Vec<f64>,
    /// Next elastic frequency above the kept ones, if known, rad/s.
    pub next_omega: Option<f64>,
}

/// A loaded equilibrium `Qstif_S(eta0) = Qext_S(eta0)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrimData {
    /// Loads in balance with the elastic forces, constant in time. [`crate::Model::prepare`] adds them to every load case.
    pub loads: Vec<Load>,
    /// Distributed loads in balance, constant in time.
    pub distributed: Vec<DistributedLoad>,
    /// `Phi_S^t Qstif_S(eta0)`: constant on the left-hand side of the elastic rows, N m per unit amplitude - (m).
    pub elastic_force: Vec<f64>,
    /// Elastic energy of the equilibrium, J.
    pub elastic_energy: f64,
    /// Attitude of A: unit quaternion, scalar first, components in A to components in G - (4).
    pub attitude: [f64; 4],
    /// Factors that were solved for so that the body is in balance: (name of the loads, factor), contained in `loads`.
    #[serde(deserialize_with = "crate::format::text::named")]
    pub factors: Vec<(String, f64)>,
    /// Force (N) and moment about the origin of A (N m) that hold the reference node, in A: zero in free flight - (6).
    pub reaction: [f64; 6],
    /// Sums of the magnitudes of all forces (N) and of all moments (N m), which the reaction is to be measured against - (2).
    pub scales: [f64; 2],
    /// Displacement of every named point from the drawing, in A, m - (points).
    pub displacements: Vec<[f64; 3]>,
    /// Load steps and Newton iterations that it took - (2).
    pub effort: [u64; 2],
}

/// A uniform gravity field, which acts on the whole body in every run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GravityData {
    /// Acceleration of free fall in G, m/s^2 - (3).
    pub acceleration: [f64; 3],
    /// `H`: second derivatives of the first moment of mass in A by the modal amplitudes, kg m - (3 x m x m), symmetric in the modes.
    /// Only masses beside the axis of their section have any; empty where there are none.
    pub second_moment: Vec<f64>,
}

/// Damping that couples the modes: of strains that are not damped everywhere alike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DampingData {
    /// `C` of `C q_dot` off its diagonal, which the damping ratios hold: symmetric, zero on the diagonal, kg m^2/s - (m x m).
    pub coupling: Vec<f64>,
}

/// A sparse constant tensor in coordinate form, sorted by index, without duplicates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TensorData {
    /// Row `i` of each entry - (nnz).
    pub i: Vec<u32>,
    /// Column `l` of each entry - (nnz).
    pub l: Vec<u32>,
    /// Velocity index `r`; for `k` the pair is coded `r * 6 + s` with r <= s - (nnz).
    pub r: Vec<u32>,
    /// Values - (nnz).
    pub value: Vec<f64>,
    /// Entries below this magnitude were dropped as round-off. The scale is named in `scale`.
    pub threshold: f64,
    /// What the threshold is relative to, in words.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub scale: String,
    /// Euclidean norm of what was dropped.
    pub dropped_norm: f64,
    /// Number of non-zero entries dropped.
    pub dropped_count: u64,
}

/// A named point, rigidly linked to a node of the structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointData {
    /// Name.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub name: String,
    /// Node position in A at the equilibrium, m - (3).
    pub node_position: [f64; 3],
    /// Node rotation at the equilibrium, node frame to A, unit quaternion scalar first - (4).
    pub node_rotation: [f64; 4],
    /// Point relative to its node, node frame, m - (3).
    pub offset: [f64; 3],
    /// Node displacement in A per unit modal amplitude - (3 x m).
    pub phi_translation: Vec<f64>,
    /// Node rotation `theta` (node frame, `Q = Q0 exp(theta~)`) per unit modal amplitude - (3 x m).
    pub phi_rotation: Vec<f64>,
    /// Members that meet at the node: name and section frame `E` (node frame from section frame).
    #[serde(deserialize_with = "crate::format::text::named")]
    pub sections: Vec<(String, [[f64; 3]; 3])>,
}

/// The axis of a member and the stations that carry loads distributed along it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LineData {
    /// Name of the member.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub name: String,
    /// Length, m.
    pub length: f64,
    /// Ends of its elements as fractions of the length, ascending from 0 to 1 - (elements + 1).
    pub knots: Vec<f64>,
    /// Three stations an element at the Gauss points of its length; none where the model was built without them.
    pub stations: StationSet,
}

/// A block of stations: places on members that a host reads and loads all at once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StationsData {
    /// Name.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub name: String,
    /// Members it goes along, in order, with the number of stations on each.
    #[serde(deserialize_with = "crate::format::text::named")]
    pub members: Vec<(String, u32)>,
    /// Fraction of the member's length of every station - (n).
    pub fraction: Vec<f64>,
    /// From the axis to the station, section axes, m - (n x 3).
    pub offset: Vec<f64>,
    /// Their sections.
    pub sections: StationSet,
}

/// Sections of members, in arrays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StationSet {
    /// Positions in A at the equilibrium, m - (n x 3).
    pub position: Vec<f64>,
    /// Section axes to A at the equilibrium: unit quaternions, scalar first - (n x 4).
    pub rotation: Vec<f64>,
    /// Displacement in A per unit modal amplitude - (n x 3 x m).
    pub phi_translation: Vec<f64>,
    /// Rotation in section axes per unit modal amplitude - (n x 3 x m).
    pub phi_rotation: Vec<f64>,
}

impl StationSet {
    /// Number of stations.
    pub fn len(&self) -> usize {
        self.position.len() / 3
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }
}

/// An inertial sensor on a named point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorData {
    /// Name.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub name: String,
    /// Index into the model's points.
    pub point: u32,
    /// Axes of the sensor (node frame from sensor axes, rotation matrix, row-major).
    pub axes: [[f64; 3]; 3],
    /// Whether it feels gravity: it then reads the acceleration less that of free fall, as accelerometers do.
    pub gravity: bool,
}

/// Nodes for pictures: as many as a drawing needs, or all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureData {
    /// Node positions in A at the equilibrium, m - (n x 3).
    pub positions: Vec<f64>,
    /// Displacement of every node per unit modal amplitude - (n x 3 x m).
    pub phi_translation: Vec<f64>,
    /// Node indices along each member.
    pub lines: Vec<Vec<u32>>,
}

/// A check the generator made: `value` should not exceed `limit`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CheckData {
    /// What was checked, in words.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub name: String,
    /// What came out.
    pub value: f64,
    /// What is acceptable.
    pub limit: f64,
}
