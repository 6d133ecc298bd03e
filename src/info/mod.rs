//! What is in a model file, for people and for machines.

mod couplings;
mod equilibrium;
mod lagrangian;
mod limits;
mod report;
mod text;

pub use couplings::{Coupling, couplings};
pub use equilibrium::EquilibriumInfo;
pub use lagrangian::LagrangianInfo;
pub use limits::{AmplitudeLimit, Limits, RateLimit};
pub(crate) use text::shares;

use rom_runtime::data::{CutData, ModelData, PointData, SelectionData, TensorData};
use rom_runtime::loads::LoadCase;
use rom_runtime::{Integrator, Model};
use serde::Serialize;

use crate::describe;

/// Everything `romgen info` says; `--json` prints it as it is here.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// Name of the structure.
    pub name: String,
    /// Where the model comes from.
    pub provenance: ProvenanceInfo,
    /// Elastic modes, ascending frequency.
    pub modes: Vec<ModeInfo>,
    /// Unit loads whose static response the residual modes complete; none without such modes.
    pub residual_loads: Vec<ResidualLoadInfo>,
    /// Next elastic frequency above the kept ones, rad/s, if known.
    pub next_omega: Option<f64>,
    /// Rigid-body properties.
    pub rigid: RigidInfo,
    /// The loaded equilibrium; none about the drawing.
    pub equilibrium: Option<EquilibriumInfo>,
    /// Acceleration of free fall in G, m/s^2; none in weightlessness.
    pub gravity: Option<[f64; 3]>,
    /// How far the model holds; none for a rigid body.
    pub limits: Option<Limits>,
    /// The Lagrangian of a consistent model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lagrangian: Option<LagrangianInfo>,
    /// Longest stable time step of each integrator.
    pub stable_time_step: StableTimeStep,
    /// Constant tensors.
    pub tensors: Tensors,
    /// The largest couplings, in words.
    pub couplings: Vec<Coupling>,
    /// Named points.
    pub points: Vec<PointInfo>,
    /// Places of internal loads.
    pub internal_loads: Vec<PlaceInfo>,
    /// Load cases.
    pub load_cases: Vec<LoadCaseInfo>,
    /// How modes and options were selected; none where they were given.
    pub selection: Option<SelectionData>,
    /// Checks the generator made.
    pub checks: Vec<CheckInfo>,
}

/// Where a model comes from.
#[derive(Clone, Debug, Serialize)]
pub struct ProvenanceInfo {
    /// Tool and version.
    pub generator: String,
    /// SHA-256 of the structure file.
    pub input_sha256: String,
    /// Build options: (option, value).
    pub options: Vec<(String, String)>,
    /// Parameters of the structure: (name, value).
    pub parameters: Vec<(String, f64)>,
    /// Finite elements.
    pub n_elements: u64,
    /// Degrees of freedom of the finite-element model.
    pub n_dof: u64,
}

/// One elastic mode.
#[derive(Clone, Debug, Serialize)]
pub struct ModeInfo {
    /// Number among the structure's elastic modes, from 1; residual modes are numbered on from the last of them.
    pub number: u32,
    /// Whether it is a residual mode, which completes the static response to loads, and not a mode of the structure.
    pub residual: bool,
    /// Circular frequency, rad/s.
    pub omega: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Generalised mass, kg m^2.
    pub generalised_mass: f64,
    /// Critical damping ratio.
    pub damping_ratio: f64,
    /// Share of the kinetic energy: translation along and rotation about x, y, z of A; they add up to one.
    pub kinetic_energy_share: [f64; 6],
    /// Generalised force per unit load, for each named point.
    pub participation: Vec<Participation>,
    /// Of a clamped structure: effective mass along (kg) and inertia about (kg m^2) x, y, z of A at its origin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_mass: Option<[f64; 6]>,
}

/// A unit load whose static response residual modes complete.
#[derive(Clone, Debug, Serialize)]
pub struct ResidualLoadInfo {
    /// Point.
    pub point: String,
    /// `force` or `moment`, along `x`, `y` or `z` of A.
    pub load: &'static str,
    /// Axis of A.
    pub axis: &'static str,
    /// Share of the static strain energy that the other modes of the model miss, 0 to 1.
    pub missed: f64,
}

/// Work a unit load at a point does in a mode of unit amplitude, rigid motion of the mode included.
#[derive(Clone, Debug, Serialize)]
pub struct Participation {
    /// Point.
    pub point: String,
    /// Per N along x, y, z of A.
    pub force: [f64; 3],
    /// Per N m about x, y, z of A.
    pub moment: [f64; 3],
}

/// Rigid-body properties at the equilibrium.
#[derive(Clone, Debug, Serialize)]
pub struct RigidInfo {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in A, m.
    pub centre_of_mass: [f64; 3],
    /// Inertia tensor about the origin of A, axes of A, kg m^2.
    pub inertia_about_a: [[f64; 3]; 3],
    /// `M_RR`, rows and columns v then w.
    pub mass_matrix: Vec<f64>,
    /// Position of the origin of A in G at t = 0, m.
    pub initial_position: [f64; 3],
}

/// Longest time step that is stable for the linear oscillators of the model, s; none: any.
#[derive(Clone, Debug, Serialize)]
pub struct StableTimeStep {
    /// Explicit Runge-Kutta of order four.
    pub rk4: Option<f64>,
    /// Newmark.
    pub newmark: Option<f64>,
    /// Generalised-alpha.
    #[serde(rename = "gen-alpha")]
    pub gen_alpha: Option<f64>,
}

/// Both tensors.
#[derive(Clone, Debug, Serialize)]
pub struct Tensors {
    /// `c_ilr`.
    pub c: TensorInfo,
    /// `kgyr_ilrs`.
    pub k: TensorInfo,
}

/// Size and sparsity of a tensor.
#[derive(Clone, Debug, Serialize)]
pub struct TensorInfo {
    /// Entries stored.
    pub stored: usize,
    /// Entries it would have if it were full; symmetric ones counted once.
    pub possible: usize,
    /// Largest magnitude.
    pub largest: f64,
    /// Entries below this were dropped.
    pub threshold: f64,
    /// What the threshold is relative to.
    pub scale: String,
    /// Entries dropped that were not zero.
    pub dropped_count: u64,
    /// Their Euclidean norm.
    pub dropped_norm: f64,
}

/// A named point.
#[derive(Clone, Debug, Serialize)]
pub struct PointInfo {
    /// Name.
    pub name: String,
    /// Position in A at the equilibrium, m.
    pub position: [f64; 3],
    /// Members that meet there.
    pub members: Vec<String>,
}

/// A place of internal loads.
#[derive(Clone, Debug, Serialize)]
pub struct PlaceInfo {
    /// Name.
    pub name: String,
    /// Member it is on.
    pub member: String,
    /// Fraction of the member's length.
    pub fraction: f64,
    /// Force (N) on the positive face of the section at the equilibrium, section axes.
    pub force: [f64; 3],
    /// Moment (N m) there.
    pub moment: [f64; 3],
    /// Whether a run sums forces there, besides the strains of the modes.
    pub summation: bool,
}

/// A load case.
#[derive(Clone, Debug, Serialize)]
pub struct LoadCaseInfo {
    /// Name.
    pub name: String,
    /// One line on it.
    pub description: String,
    /// End, s.
    pub t_end: f64,
    /// Time step, s.
    pub dt: f64,
    /// Numerical damping.
    pub numerical_damping: f64,
    /// Loads in words: point, frame, force, moment, function of time.
    pub loads: Vec<[String; 5]>,
}

/// A check of the generator.
#[derive(Clone, Debug, Serialize)]
pub struct CheckInfo {
    /// What was checked.
    pub name: String,
    /// What came out.
    pub value: f64,
    /// What is acceptable.
    pub limit: f64,
    /// Whether it is.
    pub passed: bool,
}

impl Info {
    /// What is in a model.
    pub fn new(model: &Model) -> Self {
        let data = model.data();
        let m = data.modes.omega.len();
        let stable = |integrator: Integrator| integrator.stable_dt(model).map(|limit| limit.dt);
        Self {
            name: data.provenance.name.clone(),
            provenance: ProvenanceInfo {
                generator: data.provenance.generator.clone(),
                input_sha256: data.provenance.input_sha256.clone(),
                options: data.provenance.options.clone(),
                parameters: data.provenance.parameters.clone(),
                n_elements: data.provenance.n_elements,
                n_dof: data.provenance.n_dof,
            },
            modes: (0..m).map(|j| mode(data, j)).collect(),
            residual_loads: residual_loads(data),
            next_omega: data.modes.next_omega,
            rigid: rigid(data),
            equilibrium: data.trim.as_ref().map(|trim| EquilibriumInfo::new(data, trim)),
            gravity: data.gravity.as_ref().map(|gravity| gravity.acceleration),
            limits: data.validity.as_ref().map(|_| Limits::new(data)),
            lagrangian: data.lagrangian.as_ref().map(LagrangianInfo::new),
            stable_time_step: StableTimeStep {
                rk4: stable(Integrator::Rk4),
                newmark: stable(Integrator::Newmark),
                gen_alpha: stable(Integrator::GeneralizedAlpha),
            },
            tensors: Tensors {
                c: tensor(&data.c, (m + 6) * (m + 6) * 6),
                k: tensor(&data.k, (m + 6) * m * 21),
            },
            couplings: couplings(data),
            points: data.points.iter().map(point).collect(),
            internal_loads: data.cuts.iter().map(place).collect(),
            load_cases: data.load_cases.iter().map(|case| load_case(case, data)).collect(),
            selection: data.selection.clone(),
            checks: data
                .checks
                .iter()
                .map(|c| CheckInfo {
                    name: c.name.clone(),
                    value: c.value,
                    limit: c.limit,
                    passed: c.value <= c.limit,
                })
                .collect(),
        }
    }
}

fn mode(data: &ModelData, j: usize) -> ModeInfo {
    let modes = &data.modes;
    ModeInfo {
        number: modes.number[j],
        residual: j + data.residual.as_ref().map_or(0, |r| r.count as usize) >= modes.omega.len(),
        omega: modes.omega[j],
        frequency_hz: modes.omega[j] / std::f64::consts::TAU,
        generalised_mass: modes.mass[j],
        damping_ratio: modes.damping_ratio[j],
        kinetic_energy_share: std::array::from_fn(|d| modes.kinetic_share[6 * j + d]),
        participation: data.points.iter().map(|p| participation(data, p, j)).collect(),
        effective_mass: data.clamped.as_ref().map(|clamped| {
            std::array::from_fn(|r| clamped.participation[r * modes.omega.len() + j].powi(2) / modes.mass[j])
        }),
    }
}

fn residual_loads(data: &ModelData) -> Vec<ResidualLoadInfo> {
    let loads = data.residual.iter().flat_map(|residual| &residual.loads);
    loads
        .map(|load| ResidualLoadInfo {
            point: data.points[load.point as usize].name.clone(),
            load: if load.moment { "moment" } else { "force" },
            axis: ["x", "y", "z"][load.axis as usize],
            missed: load.missed,
        })
        .collect()
}

/// Displacement and rotation of a point in a mode, relative to A and with A: the work of unit loads.
fn participation(data: &ModelData, point: &PointData, j: usize) -> Participation {
    let m = data.modes.omega.len();
    let column = |matrix: &[f64], first: usize| [0, 1, 2].map(|row| matrix[(first + row) * m + j]);
    let (v, w) = (column(&data.modes.phi_r, 0), column(&data.modes.phi_r, 3));
    let theta = column(&point.phi_rotation, 0);
    let lever = rotated(point.node_rotation, cross(theta, point.offset));
    let position = position(point);
    let swept = cross(w, position);
    let translation = column(&point.phi_translation, 0);
    let turned = rotated(point.node_rotation, theta);
    Participation {
        point: point.name.clone(),
        force: [0, 1, 2].map(|i| translation[i] + lever[i] + v[i] + swept[i]),
        moment: [0, 1, 2].map(|i| turned[i] + w[i]),
    }
}

fn rigid(data: &ModelData) -> RigidInfo {
    let matrix = &data.rigid.mass_matrix;
    RigidInfo {
        mass: data.rigid.mass,
        centre_of_mass: data.rigid.centre_of_mass,
        inertia_about_a: [0, 1, 2].map(|i| [0, 1, 2].map(|j| matrix[6 * (3 + i) + 3 + j])),
        mass_matrix: matrix.clone(),
        initial_position: data.rigid.initial_position,
    }
}

fn tensor(tensor: &TensorData, possible: usize) -> TensorInfo {
    TensorInfo {
        stored: tensor.value.len(),
        possible,
        largest: tensor.value.iter().fold(0.0, |max, v| f64::max(max, v.abs())),
        threshold: tensor.threshold,
        scale: tensor.scale.clone(),
        dropped_count: tensor.dropped_count,
        dropped_norm: tensor.dropped_norm,
    }
}

fn point(point: &PointData) -> PointInfo {
    PointInfo {
        name: point.name.clone(),
        position: position(point),
        members: point.sections.iter().map(|(name, _)| name.clone()).collect(),
    }
}

fn place(cut: &CutData) -> PlaceInfo {
    let [fx, fy, fz, mx, my, mz] = cut.rest;
    PlaceInfo {
        name: cut.name.clone(),
        member: cut.member.clone(),
        fraction: cut.fraction,
        force: [fx, fy, fz],
        moment: [mx, my, mz],
        summation: cut.summation.is_some(),
    }
}

fn load_case(case: &LoadCase, data: &ModelData) -> LoadCaseInfo {
    let spread = case.distributed.iter().map(|load| {
        let line = data.lines.get(load.member as usize);
        describe::distributed(load, line.map(|line| line.name.as_str()))
    });
    LoadCaseInfo {
        name: case.name.clone(),
        description: case.description.clone(),
        t_end: case.t_end,
        dt: case.dt,
        numerical_damping: case.numerical_damping,
        loads: case.loads.iter().map(|l| describe::load(l, &data.points)).chain(spread).collect(),
    }
}

/// Where a point is in A at the equilibrium, m.
pub(crate) fn position(point: &PointData) -> [f64; 3] {
    let arm = rotated(point.node_rotation, point.offset);
    [0, 1, 2].map(|i| point.node_position[i] + arm[i])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `x` turned by a unit quaternion, scalar first.
fn rotated([s, x, y, z]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let u = [x, y, z];
    let t = cross(u, v).map(|c| 2.0 * c);
    let c = cross(u, t);
    [0, 1, 2].map(|i| v[i] + s * t[i] + c[i])
}

#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) use tests::sample;
