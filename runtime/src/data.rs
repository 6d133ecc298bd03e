//! The contents of a model file, as plain arrays. [`crate::Model`] is made from it and checks it.
//!
//! Modal order everywhere: elastic modes `0..m`, then the six rigid ones (`beta*`: v then w). Matrices are row-major.

use alloc::{string::String, vec::Vec};
use serde::{Deserialize, Serialize};

use crate::loads::{DistributedFrame, DistributedLoad, Load, LoadCase};

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
    /// How the nodes of the pictures bend off the shapes of the modes; none where shapes are linear in the amplitudes.
    pub picture_curve: Option<PictureCurveData>,
    /// The loaded equilibrium that the model is about; none about the unloaded structure.
    pub trim: Option<TrimData>,
    /// Inertial sensors.
    pub sensors: Vec<SensorData>,
    /// Uniform gravity; none in weightlessness.
    pub gravity: Option<GravityData>,
    /// Which of the elastic modes are residual modes; none where none are.
    pub residual: Option<ResidualData>,
    /// What the model leaves out and how far it holds; none for a rigid body.
    pub validity: Option<ValidityData>,
    /// Why the model has the modes and options it has, where they were selected to meet an error.
    pub selection: Option<SelectionData>,
    /// Axes of the members, in the order of the structure file, for loads distributed along them.
    pub lines: Vec<LineData>,
    /// The Lagrangian of a model with consistent inertia; none where mass matrix and elastic force are the paper's.
    pub lagrangian: Option<LagrangianData>,
    /// Blocks of stations for aerodynamic codes.
    pub stations: Vec<StationsData>,
    /// Places along the members where section forces are told.
    pub cuts: Vec<CutData>,
    /// Damping that couples modes; none where it is that of the ratios alone.
    pub damping: Option<DampingData>,
    /// A structure that is clamped at the reference node; none where it flies.
    pub clamped: Option<ClampedData>,
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
    /// Number in the ascending list of the structure's elastic modes, from 1; residual modes are numbered on from the last mode that the
    /// structure has - (m).
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

/// Residual modes: the last elastic modes of a model that has any. They complete the static response to loads on named points, have
/// unit generalised mass and their own frequencies, and are marched as modes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResidualData {
    /// How many of the last modes they are.
    pub count: u32,
    /// The unit loads they were made for.
    pub loads: Vec<ResidualLoad>,
}

/// A unit load whose static response residual modes complete.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResidualLoad {
    /// Index into the model's points.
    pub point: u32,
    /// A moment, not a force.
    pub moment: bool,
    /// Along this axis of A: 0, 1, 2 for x, y, z.
    pub axis: u32,
    /// Share of the static strain energy under it that the other modes of the model miss, 0 to 1.
    pub missed: f64,
}

/// What the equations leave out for large amplitudes and rates (docs/validity.md), and how far that is small.
///
/// Pairs of the first `modes` elastic modes `i <= j`, `i` the slower index: (0, 0), (0, 1), .., (1, 1), ..
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ValidityData {
    /// Number of leading elastic modes whose pairs are kept.
    pub modes: u32,
    /// What the second derivatives `Theta_ij` of the shape meet, in units of generalised force per product of amplitudes: elastic force of
    /// the equilibrium (1), `M_RS Theta` (6), inertia forces of unit spins xx, yy, zz, yz, xz, xy (6), `Theta^t M_SS phi_k` (m)
    /// - (pairs x (13 + m)).
    pub fields: Vec<f64>,
    /// `Theta_ij` of the node of each point: translation in A, rotation in the node frame - (points of (6 x pairs)).
    pub points: Vec<Vec<f64>>,
    /// Per unit amplitude of each mode: relative change of the mass matrix, and second-order displacement over first-order, in the mass
    /// matrix - (m x 2).
    pub amplitude: Vec<f64>,
    /// Change of `omega_i^2` of each mode, relative, per square of the angular rate about x, y, z that the model does not know of, s^2
    /// - (m x 3).
    pub stiffening: Vec<f64>,
    /// Of the curved manifold of a model with geometric elastic forces; none of others.
    pub curve: Option<CurveValidityData>,
    /// What the modes miss of the static response to loads.
    pub missing: MissingData,
}

/// How far the polynomials of a curved manifold hold.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CurveValidityData {
    /// Amplitude of each mode at which what the model leaves out of inertia, displacements and elastic energy reaches 1, 5 and 10 % of what
    /// it keeps - (m x 3).
    pub limits: Vec<f64>,
    /// The largest of the terms that were dropped of the first m kinetic coordinates - (m rows).
    pub dropped: PolynomialData,
    /// The largest of the terms that were dropped of the motion of the node of every named point, translation in A and rotation - (6 rows each).
    pub points: Vec<PolynomialData>,
}

/// Residual flexibility: the static response to loads on some points and to loads per length, inertia relieved, less what the modes hold of
/// it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MissingData {
    /// Indices of the points that loads act on - (loaded).
    pub loaded: Vec<u32>,
    /// Displacement in A and rotation in the node frame of the node of every point, per unit force in A and moment in the node frame on that
    /// of a loaded one: m/N, m/(N m), 1/N, 1/(N m) - (loaded x points x 6 x 6).
    pub flexibility: Vec<f64>,
    /// Velocity `(v, w)` of A in the missed motion, as `phi_r` in that of a mode, per unit rate of force in A and moment in the node frame:
    /// m/N, m/(N m), 1/N, 1/(N m) - (loaded x 6 x 6).
    pub rigid: Vec<f64>,
    /// Loads per length that the structure declares, in load cases and in the equilibrium.
    pub lines: Vec<MissingLine>,
}

impl MissingData {
    /// Number of unit loads: six on every loaded point, then the columns of every line.
    pub fn n_sources(&self) -> usize {
        6 * self.loaded.len() + self.lines.iter().map(MissingLine::columns).sum::<usize>()
    }
}

/// A load per length, and what the modes miss under it. It is made of unit loads, its columns: of a dead load with `(p_g, m_g)` on its
/// stations nine, `e_a p_gb` and `e_a m_gb`, by which its force in A is `C p_g = C_ab e_a p_gb`; of others one, the load itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissingLine {
    /// Index of the member in the model's lines.
    pub member: u32,
    /// Frame of the components.
    pub frame: DistributedFrame,
    /// Force on every station, N - (stations x 3); empty where there is none.
    pub force: Vec<f64>,
    /// Moment on every station, N m - (stations x 3); empty where there is none.
    pub moment: Vec<f64>,
    /// Displacement in A and rotation in the node frame of the node of every point under each column - (columns x points x 6).
    pub flexibility: Vec<f64>,
    /// Velocity `(v, w)` of A in the missed motion per unit rate of each column - (columns x 6).
    pub rigid: Vec<f64>,
    /// What moves and turns the load in the motion `(t_g, theta_g)` of its stations that is missed under every unit load
    /// ([`MissingData::n_sources`]): dead `sum t_g p_g^t` (9, by rows), body `sum t_g x p_g` (3), follower the changes of its force, of its moment
    /// about the origin of A and of its generalised forces on the shapes relative to A (6 + m) - (readings x sources).
    pub readings: Vec<f64>,
    /// Work and moment of the load in the second derivatives `(T_g, K_g)` of the shapes along every pair of modes, the pairs of
    /// [`ValidityData`]: dead `sum T_g p_g^t + (N_g K_g) m_g^t` and `sum T_g p_g^t` (18, by rows), others their work (1) and `sum T_g x F_g` (3)
    /// with the load in A - (pairs x (18 or 4)).
    pub curvature: Vec<f64>,
}

impl Default for MissingLine {
    fn default() -> Self {
        Self {
            member: 0,
            frame: DistributedFrame::Dead,
            force: Vec::new(),
            moment: Vec::new(),
            flexibility: Vec::new(),
            rigid: Vec::new(),
            readings: Vec::new(),
            curvature: Vec::new(),
        }
    }
}

impl MissingLine {
    /// Number of unit loads it is made of.
    pub fn columns(&self) -> usize {
        if self.frame == DistributedFrame::Dead { 9 } else { 1 }
    }

    /// Number of what it reads of second derivatives.
    pub fn n_curvature(&self) -> usize {
        if self.frame == DistributedFrame::Dead { 18 } else { 4 }
    }

    /// Number of what it reads of a motion, in a model of so many modes.
    pub fn n_readings(&self, n_modes: usize) -> usize {
        match self.frame {
            DistributedFrame::Dead => 9,
            DistributedFrame::Body => 3,
            DistributedFrame::Follower => 6 + n_modes,
        }
    }
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
    /// Name of every load, distributed ones after the others; empty where a load has none, and none at all where they were not given -
    /// (loads + distributed).
    #[serde(deserialize_with = "crate::format::text::strings")]
    pub load_names: Vec<String>,
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

/// A structure clamped at the reference node. Its modes are those of the clamped structure: `phi_r` is zero, frame A does not follow
/// them, and every run moves or holds A.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClampedData {
    /// `L = M_RS Phi_S`: momentum and moment of momentum about the origin of A per unit modal rate, kg m and kg m^2 - (6 x m). The
    /// squares of its entries over the generalised mass are the effective masses.
    pub participation: Vec<f64>,
}

/// The kinetic and elastic energy of the reduced model as functions of the amplitudes (docs/beyond.md).
///
/// With the kinetic coordinates `y(q) = A q + ..` - (n) - of orthonormal fields `F_a` over the mass of the body, the mass is at
/// `X = X_0 + y_a F_a`, and `T = 1/2 |X_dot + v + w x X|^2` in the metric of the mass. Scalar products of the fields are all it needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LagrangianData {
    /// Whether the elastic energy is that of large deflections on the curved manifold; else it is quadratic, the shapes linear.
    pub geometric: bool,
    /// Number of kinetic coordinates `n`, m or more.
    pub fields: u32,
    /// `A`: linear part of the first m kinetic coordinates, upper triangular with a positive diagonal - (m x m).
    pub linear: Vec<f64>,
    /// Second and third order of `y` - (n rows).
    pub curve: PolynomialData,
    /// `S_a = int F_a dm`, kg m - (3 x n).
    pub first_moment: Vec<f64>,
    /// `P_a0 = int F_a X_0^t dm`, kg m^2 - (n x 9), 3 x 3 by rows.
    pub moment_0: Vec<f64>,
    /// `P_ab = int F_a F_b^t dm`: indices a, b and `3 row + column`; with every entry its mirror image (b, a, `3 column + row`).
    pub moment: TensorData,
    /// Elastic energy of second order about the equilibrium, J - (m x m), symmetric.
    pub stiffness: Vec<f64>,
    /// Constant part of the self-stress coordinates `e`, of energy `1/2 |e(q)|^2`; empty but for closed loops - (l).
    pub self_stress: Vec<f64>,
    /// Second and third order of `e` - (l rows).
    pub self_stress_curve: PolynomialData,
    /// Second and third order of the motion of the node of every named point, translation in A and rotation `theta`, and then of every
    /// station of the lines and of the blocks of stations, its rotation in section axes - (6 rows each).
    pub points: Vec<PolynomialData>,
    /// Amplitudes for which terms were kept or dropped - (m).
    pub range: Vec<f64>,
    /// Terms below this part of the largest were dropped, at those amplitudes.
    pub tolerance: f64,
    /// Root of the sum of squares of what was dropped of `y`, over the largest linear term, at those amplitudes.
    pub dropped_norm: f64,
}

/// Sparse polynomials of second and third order in the amplitudes: every term is (row, indices of its factors in ascending order,
/// coefficient); terms are sorted by row and factors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PolynomialData {
    /// `coefficient q_i q_j`.
    pub quadratic: Vec<(u32, [u32; 2], f64)>,
    /// `coefficient q_i q_j q_k`.
    pub cubic: Vec<(u32, [u32; 3], f64)>,
}

/// A place along a member where section forces are told: force (N) and moment (N m) on the positive face, that of the part before it, in
/// the axes of the section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CutData {
    /// Name of the place.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub name: String,
    /// Member.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub member: String,
    /// Fraction of the member's length.
    pub fraction: f64,
    /// At the equilibrium - (6).
    pub rest: [f64; 6],
    /// Per unit modal amplitude, by the strains of the modes - (6 x m).
    pub modal: Vec<f64>,
    /// Per unit modal rate, of damped strains - (6 x m); empty without.
    pub modal_rate: Vec<f64>,
    /// What summation of forces takes; none where the model allows none (consistent inertia, mean axes).
    pub summation: Option<SummationData>,
}

/// Section forces as sums of what acts on the structure (docs/theory.md, section 15).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SummationData {
    /// Without loads, weight and motion - (6).
    pub constant: [f64; 6],
    /// Per unit acceleration `(q_ddot, beta*_dot)`, taken off - (6 x (m + 6)).
    pub inertia: Vec<f64>,
    /// Per unit modal rate, taken off - (6 x m).
    pub damping: Vec<f64>,
    /// Per `u_l beta_r`, taken off - (6 x (m + 6) x 6).
    pub c: Vec<f64>,
    /// Per `q_l beta_r beta_s` with r <= s, both halves added, taken off - (6 x m x 21).
    pub k: Vec<f64>,
    /// Change of the weight per unit field and amplitude - (6 x m x 3); empty where there is none.
    pub gravity: Vec<f64>,
    /// Per unit force in A, and moment about the rotation vector of the node, on every point and then on every station of the lines and
    /// blocks - (places x 6 x 6), rows the components of the section forces.
    pub places: Vec<f64>,
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

/// What a curved manifold adds to the displacements of the nodes for pictures: `U_k p_k(q)`, few shapes with amplitudes that are polynomials of
/// the modal ones ([`crate::PictureCurve`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureCurveData {
    /// `U`: displacement of every node of the pictures in A per unit amplitude, m - (n x 3 x k).
    pub shapes: Vec<f64>,
    /// `p`: amplitudes, of second and third order - (k rows).
    pub curve: PolynomialData,
}

/// How the modes and options of a model were selected, by running it against the nonlinear structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SelectionData {
    /// Largest relative error asked for, as a fraction.
    pub target: f64,
    /// Load cases that it was asked for.
    #[serde(deserialize_with = "crate::format::text::strings")]
    pub cases: Vec<String>,
    /// Relative errors reached: (load case and quantity, error).
    #[serde(deserialize_with = "crate::format::text::named")]
    pub errors: Vec<(String, f64)>,
    /// What was taken and what was left.
    pub choices: Vec<SelectionChoice>,
}

/// A mode or an option that was taken or left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SelectionChoice {
    /// The mode or the option.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub what: String,
    /// Whether it is in the model.
    pub taken: bool,
    /// Why.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub why: String,
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
