//! The generator's main job: from a mesh to everything a model file holds.

mod options;
mod places;

use nalgebra::{Matrix3, Matrix6, Vector6};
use rom_runtime::data::{
    CheckData, ClampedData, DampingData, GravityData, ModelData, ModesData, PictureData, Provenance,
    RigidData, SensorData, TrimData,
};
use sha2::{Digest, Sha256};

pub use self::options::{BuildOptions, Elastic, Inertia, MAX_MODES, ModeSelection, Reduction};
pub(crate) use self::options::{frequency, mode_list};
use self::places::{block_data, carried_places, equilibrium_loads, lines, point_data};
use crate::assembly::{Assembly, MassMatrix};
use crate::carrier::Carrier;
use crate::configuration::Configuration;
use crate::element::internal_force::stack;
use crate::equilibrium::trim::{self, WhenUnbalanced};
use crate::equilibrium::{Equilibrium, EquilibriumError, SELF_BALANCED};
use crate::input::Structure;
use crate::math::so3::scalar_first;
use crate::mesh::{InertiaQuadrature, Mesh, Support};
use crate::picture::{self, Outline};
use crate::reduce::damping::modal_damping;
use crate::reduce::internal_loads::Sections;
use crate::reduce::lagrangian::{LagrangianError, lagrangian};
use crate::reduce::modes::{Modes, modes_of};
use crate::reduce::residual::{ResidualSelection, residual_data, with_residual_modes};
use crate::reduce::sections::{SectionSums, section_sums};
use crate::reduce::tensors::{DROP, Tensors, project};
use crate::reduce::validity::validity;
use crate::reduce::weight::second_moment;
use crate::solve::eigen::{EigenError, FreeBody};

/// Stages of a build, for progress displays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Static equilibrium.
    Equilibrium,
    /// Matrices of the structure.
    Assembly,
    /// Free-free modes.
    Modes,
    /// Constant tensors.
    Tensors,
    /// Lagrangian of a consistent model.
    Lagrangian,
    /// Done.
    Done,
}

/// A model could not be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The mode selection asks for something impossible.
    #[error("modes: {0}")]
    Selection(String),
    /// Residual modes cannot be made for what was asked.
    #[error("residual modes: {0}")]
    Residual(String),
    /// An element is bent too much for its interpolation.
    #[error(
        "member `{member}`, element {element}: its nodes are turned {degrees:.0} degrees against each other; use more elements"
    )]
    CoarseElement {
        /// Member name.
        member: String,
        /// Element number within the member, from 1.
        element: usize,
        /// Relative rotation, degrees.
        degrees: f64,
    },
    /// The equilibrium is that of a body in a steady turn.
    #[error(
        "the equilibrium turns with ({:.4}, {:.4}, {:.4}) rad/s: a reduced model is made about a body at rest in its frame", .0[0], .0[1], .0[2]
    )]
    Turning([f64; 3]),
    /// There is no equilibrium to build about.
    #[error(transparent)]
    Equilibrium(#[from] EquilibriumError),
    /// Options that do not go together, or not with the structure.
    #[error("{0}")]
    Dynamics(String),
    /// The Lagrangian of a consistent model could not be had.
    #[error("consistent inertia: {0}")]
    Lagrangian(#[from] LagrangianError),
    /// The modes could not be computed.
    #[error("modes: {0}")]
    Modes(#[from] EigenError),
}

/// Builds the reduced model of a structure file, about the equilibrium it asks for or else about its drawing.
pub fn build(
    structure: &Structure,
    options: &BuildOptions,
    progress: &mut dyn FnMut(Stage),
) -> Result<ModelData, BuildError> {
    let mesh = structure.mesh();
    build_mesh(&mesh, provenance(structure, options, &mesh), options, progress)
}

/// Enough to build the model again: the text, its hash, the options and the parameters they led to.
pub fn provenance(structure: &Structure, options: &BuildOptions, mesh: &Mesh) -> Provenance {
    let mut settings: Vec<(String, String)> =
        structure.sets().iter().map(|(name, value)| ("--set".into(), format!("{name}={value}"))).collect();
    settings.push(("--modes".into(), options.modes.to_string()));
    // What the structure file says otherwise, or may say otherwise, has to be named.
    let file = structure.reduction();
    if options.residual != ResidualSelection::None || file.residual.is_some() {
        settings.push(("--residual".into(), options.residual.to_string()));
    }
    if options.all_nodes {
        settings.push(("--all-nodes".into(), String::new()));
    }
    if options.inertia != Inertia::default() || file.inertia.is_some() {
        settings.push(("--inertia".into(), options.inertia.to_string()));
    }
    if options.elastic != Elastic::default() || file.elastic.is_some() {
        settings.push(("--elastic".into(), options.elastic.to_string()));
    }
    let hash = Sha256::digest(structure.text().as_bytes());
    Provenance {
        name: structure.name().into(),
        generator: concat!("romgen ", env!("CARGO_PKG_VERSION")).into(),
        input_text: structure.text().into(),
        input_sha256: hash.iter().map(|byte| format!("{byte:02x}")).collect(),
        options: settings,
        parameters: structure.parameters().to_vec(),
        n_elements: mesh.elements.len() as u64,
        n_dof: 6 * mesh.nodes.len() as u64,
    }
}

/// Builds the reduced model of a mesh, about the equilibrium it asks for or else about its drawing.
///
/// # Errors
/// No such equilibrium, elements bent too far, modes that cannot be had.
pub fn build_mesh(
    mesh: &Mesh,
    provenance: Provenance,
    options: &BuildOptions,
    progress: &mut dyn FnMut(Stage),
) -> Result<ModelData, BuildError> {
    if mesh.trim.is_some() {
        progress(Stage::Equilibrium);
    }
    match trim::of_mesh(mesh)? {
        Some(found) => build_about(mesh, &found, provenance, options, progress),
        None => build_configuration(mesh, Configuration::drawing(mesh), None, provenance, options, progress),
    }
}

/// Builds the reduced model of a mesh about a loaded equilibrium. The loads of the equilibrium act in every run of the model, so that it
/// rests in balance where nothing else acts; a reaction that the body cannot have in free flight is among the model's checks.
///
/// # Errors
/// As [`build_mesh`], and an equilibrium in a steady turn.
pub fn build_about(
    mesh: &Mesh,
    equilibrium: &Equilibrium,
    provenance: Provenance,
    options: &BuildOptions,
    progress: &mut dyn FnMut(Stage),
) -> Result<ModelData, BuildError> {
    if equilibrium.beta.fixed_rows::<3>(3).amax() > 0.0 {
        return Err(BuildError::Turning([3, 4, 5].map(|k| equilibrium.beta[k])));
    }
    let at = equilibrium.configuration.clone();
    build_configuration(mesh, at, Some(equilibrium), provenance, options, progress)
}

fn build_configuration(
    mesh: &Mesh,
    at: Configuration,
    equilibrium: Option<&Equilibrium>,
    provenance: Provenance,
    options: &BuildOptions,
    progress: &mut dyn FnMut(Stage),
) -> Result<ModelData, BuildError> {
    check_dynamics(mesh, options)?;
    progress(Stage::Assembly);
    check_relative_rotations(mesh)?;
    let assembly = Assembly::new(mesh);
    let mass = assembly.mass(&at);
    let stiffness = assembly.stiffness(&at);

    progress(Stage::Modes);
    let available = 6 * assembly.n_blocks();
    let factorised = || FreeBody::new(&assembly, &at, &stiffness, &mass);
    let mut body = None;
    let (numbers, count) = match &options.modes {
        ModeSelection::Count(n) => ((1..=*n).collect::<Vec<_>>(), *n),
        ModeSelection::List(list) => (checked_list(list)?, list.iter().copied().max().unwrap_or(0)),
        ModeSelection::Below(omega) => {
            if !(omega.is_finite() && *omega > 0.0) {
                return Err(BuildError::Selection(format!("frequency limit {omega} rad/s is not positive")));
            }
            let n = body.insert(factorised()?).count_below(*omega)?;
            ((1..=n).collect(), n)
        }
    };
    if numbers.len() > MAX_MODES {
        let found = numbers.len();
        return Err(BuildError::Selection(format!(
            "{found} modes selected; a reduced model keeps at most {MAX_MODES}"
        )));
    }
    if count > available {
        return Err(BuildError::Selection(format!(
            "mode {count} was asked for, but the structure has {available} elastic degrees of freedom; refine the mesh or ask for fewer"
        )));
    }
    let body = body.map_or_else(factorised, Ok)?;
    let mut modes = modes_of(&body, &assembly, &at, &mass, count)?.select(&numbers);
    let points = options.residual.points(mesh).map_err(BuildError::Residual)?;
    let mut numbers = numbers;
    let mut residual = None;
    if !points.is_empty() {
        let (all, loads) = with_residual_modes(mesh, &assembly, &at, &mass, &body, modes, &points)?;
        numbers.extend((1..=all.residual).map(|k| available + k));
        residual = (all.residual > 0).then(|| residual_data(all.residual, &loads));
        modes = all;
    }

    progress(Stage::Tensors);
    let tensors = project(&assembly, &at, &modes);
    let distributed = equilibrium.map_or(&[][..], |found| &found.distributed);
    // What a held body leaves out is not looked at.
    let mut limits = (modes.m() > 0 && mesh.support == Support::Free)
        .then(|| validity(mesh, &assembly, &at, &mass, &body, &modes, &tensors, distributed))
        .transpose()?;
    let places = carried_places(mesh, &at, options.all_nodes);
    let (lagrangian, picture_curve) = match options.inertia {
        Inertia::Constant => (None, None),
        Inertia::Consistent => {
            progress(Stage::Lagrangian);
            let drawn = outline(mesh, options.all_nodes).nodes;
            let geometric = options.elastic == Elastic::Geometric;
            let loads = equilibrium.map(|found| equilibrium_loads(mesh, found, options.all_nodes));
            let loads = loads.as_ref();
            let found = lagrangian(&assembly, &at, &modes, &places, &drawn, geometric, loads, &mass.rr)?;
            found.map_or((None, None), |found| {
                if let Some(limits) = &mut limits {
                    // Of the places the points come first.
                    limits.curve = found.validity.map(|mut curve| {
                        curve.points.truncate(mesh.points.len());
                        curve
                    });
                }
                (Some(found.data), found.picture)
            })
        }
    };
    let sections = Sections {
        mesh,
        assembly: &assembly,
        at: &at,
        mass: &mass,
        body: &body,
        modes: &modes,
        numbers: &numbers,
        elastic_force: equilibrium.map(|found| &found.elastic_force[..]),
    };
    // Consistent models bend their shapes: statics of the equilibrium alone would be less than what their modes tell.
    let cuts = sections.cuts(&places, options.inertia == Inertia::Constant);
    progress(Stage::Done);
    let trim = equilibrium.map(|equilibrium| trim_data(mesh, equilibrium, &modes));
    let gravity = (mesh.gravity.amax() > 0.0).then(|| GravityData {
        acceleration: mesh.gravity.into(),
        second_moment: second_moment(&assembly, &at, &modes),
    });
    let mut data =
        model_data(mesh, provenance, options, Parts { assembly, at, mass, modes, tensors, numbers });
    data.trim = trim;
    data.lagrangian = lagrangian;
    data.picture_curve = picture_curve;
    data.cuts = cuts;
    data.gravity = gravity;
    data.residual = residual;
    data.validity = limits;
    let flies = mesh.support == Support::Free;
    let expected =
        flies && mesh.trim.as_ref().is_none_or(|trim| trim.when_unbalanced == WhenUnbalanced::Refuse);
    data.checks.extend(equilibrium.filter(|_| expected).into_iter().flat_map(trim_checks));
    Ok(data)
}

/// Results of the stages on their way into the file.
struct Parts {
    assembly: Assembly,
    at: Configuration,
    mass: MassMatrix,
    modes: Modes,
    tensors: Tensors,
    numbers: Vec<usize>,
}

fn model_data(mesh: &Mesh, provenance: Provenance, options: &BuildOptions, parts: Parts) -> ModelData {
    let Parts { assembly, at, mass, modes, tensors, numbers } = parts;
    let (c, k) = tensors.to_sparse(&mass.rr, DROP);
    let (total, centre) = Assembly::centre_of_mass(&mass.rr);
    let damping = modal_damping(&assembly, &at, &mesh.damping, &modes, &numbers);
    let sums = section_sums(&assembly, &at, &modes);
    let clamped = mesh.support == Support::Clamped;
    ModelData {
        provenance,
        rigid: RigidData {
            mass: total,
            centre_of_mass: centre.into(),
            mass_matrix: row_major(&mass.rr),
            initial_position: mesh.reference_position.into(),
        },
        checks: checks(&modes, &sums, total, clamped),
        clamped: clamped.then(|| clamped_data(&assembly, &mass, &modes)),
        modes: modes_data(&assembly, &mass, &modes, &numbers, damping.ratio, sums.kinetic_share),
        c,
        k,
        points: mesh.points.iter().map(|p| point_data(mesh, p, &at, &modes)).collect(),
        load_cases: mesh.load_cases.clone(),
        picture: Some(picture_data(&outline(mesh, options.all_nodes), &at, &modes)),
        picture_curve: None,
        trim: None,
        sensors: mesh.sensors.iter().map(sensor_data).collect(),
        gravity: None,
        residual: None,
        validity: None,
        selection: None,
        lines: lines(mesh, &at, &modes, options.all_nodes),
        lagrangian: None,
        cuts: Vec::new(),
        stations: mesh.stations.iter().map(|block| block_data(mesh, block, &at, &modes)).collect(),
        damping: damping.coupling.map(|coupling| DampingData { coupling }),
    }
}

/// `M_RS phi_S` of every mode.
fn modal_momenta(assembly: &Assembly, mass: &MassMatrix, modes: &Modes) -> Vec<Vector6<f64>> {
    let mut momenta = vec![Vector6::zeros(); modes.m()];
    for (node, unknown) in assembly.unknown.iter().enumerate() {
        let Some(i) = unknown else { continue };
        for (momentum, phi) in momenta.iter_mut().zip(modes.at_node(node)) {
            *momentum += mass.sr[*i].tr_mul(phi);
        }
    }
    momenta
}

fn clamped_data(assembly: &Assembly, mass: &MassMatrix, modes: &Modes) -> ClampedData {
    let momenta = modal_momenta(assembly, mass, modes);
    ClampedData { participation: (0..6).flat_map(|r| momenta.iter().map(move |p| p[r])).collect() }
}

fn modes_data(
    assembly: &Assembly,
    mass: &MassMatrix,
    modes: &Modes,
    numbers: &[usize],
    damping_ratio: Vec<f64>,
    kinetic_share: Vec<f64>,
) -> ModesData {
    let m = modes.m();
    // The first rows of M_RS phi_S are the first moment of the displacements; a free mode has M_RS phi_S = -M_RR phi_R.
    let momentum: Vec<Vector6<f64>> = match assembly.support {
        Support::Free => modes.phi_r.iter().map(|phi| -(mass.rr * phi)).collect(),
        Support::Clamped => modal_momenta(assembly, mass, modes),
    };
    ModesData {
        number: numbers.iter().map(|&n| n as u32).collect(),
        omega: modes.omega.clone(),
        mass: vec![1.0; m],
        damping_ratio,
        phi_r: (0..6).flat_map(|r| modes.phi_r.iter().map(move |phi| phi[r])).collect(),
        first_moment: (0..3).flat_map(|r| momentum.iter().map(move |p| p[r])).collect(),
        kinetic_share,
        next_omega: modes.next_omega,
    }
}

fn trim_data(mesh: &Mesh, equilibrium: &Equilibrium, modes: &Modes) -> TrimData {
    let mut elastic_force = vec![0.0; modes.m()];
    for (node, force) in equilibrium.elastic_force.iter().enumerate() {
        for (sum, phi) in elastic_force.iter_mut().zip(modes.at_node(node)) {
            *sum += phi.dot(force);
        }
    }
    let at = &equilibrium.configuration;
    let drawing = Configuration::drawing(mesh);
    let displacement = |p: &crate::mesh::Point| {
        let carrier = Carrier::new(mesh, p.place);
        let (r, q) = carrier.at(at);
        r - carrier.at(&drawing).0 + q * p.offset - p.offset
    };
    let all = equilibrium.loads.len() + equilibrium.distributed.len();
    let names = mesh.trim.as_ref().map_or(Vec::new(), |trim| trim.names.clone());
    // An equilibrium that is not the file's has loads of its own.
    let names = if names.len() == all { names } else { Vec::new() };
    let reaction = stack(&equilibrium.reaction_force, &equilibrium.reaction_moment);
    TrimData {
        loads: equilibrium.loads.clone(),
        distributed: equilibrium.distributed.clone(),
        elastic_force,
        elastic_energy: equilibrium.energy,
        attitude: scalar_first(&equilibrium.attitude),
        factors: equilibrium.factors.clone(),
        load_names: names,
        reaction: reaction.into(),
        scales: [equilibrium.force_scale, equilibrium.moment_scale],
        displacements: mesh.points.iter().map(|p| displacement(p).into()).collect(),
        effort: [equilibrium.load_steps as u64, equilibrium.iterations as u64],
    }
}

fn trim_checks(equilibrium: &Equilibrium) -> [CheckData; 2] {
    let balance = equilibrium.self_balance();
    let check = |name: &str, value: f64| CheckData { name: name.into(), value, limit: SELF_BALANCED };
    [
        check(
            "equilibrium: force missing to the balance of a free body, over the sum of all forces",
            balance.force,
        ),
        check(
            "equilibrium: moment missing to the balance of a free body, over the sum of all moments",
            balance.moment,
        ),
    ]
}

fn sensor_data(sensor: &crate::mesh::Sensor) -> SensorData {
    SensorData {
        name: sensor.name.clone(),
        point: sensor.point as u32,
        axes: matrix_rows(&sensor.axes),
        gravity: sensor.gravity,
    }
}

fn matrix_rows(e: &Matrix3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| e[(i, j)]))
}

/// What is drawn.
fn outline(mesh: &Mesh, all_nodes: bool) -> Outline {
    if all_nodes { Outline::whole(mesh) } else { Outline::thinned(mesh, picture::NODES) }
}

fn picture_data(outline: &Outline, at: &Configuration, modes: &Modes) -> PictureData {
    let place = |&node: &usize| [at.positions[node].x, at.positions[node].y, at.positions[node].z];
    let rows = |&node: &usize| (0..3).flat_map(move |k| modes.at_node(node).iter().map(move |phi| phi[k]));
    PictureData {
        positions: outline.nodes.iter().flat_map(place).collect(),
        phi_translation: outline.nodes.iter().flat_map(rows).collect(),
        lines: outline.lines.clone(),
    }
}

fn checks(modes: &Modes, sums: &SectionSums, total_mass: f64, clamped: bool) -> Vec<CheckData> {
    let check = |name: &str, value: f64, limit: f64| CheckData { name: name.into(), value, limit };
    // A mode of unit generalised mass has velocities of the order 1/sqrt(m), momenta of the order sqrt(m).
    let drift = sums.momentum.iter().map(|p| p.norm()).fold(0.0, f64::max) / total_mass.sqrt();
    let mut checks = vec![
        check(
            "modes orthonormal in the full mass matrix: largest entry of Phi^t M Phi - I",
            modes.orthogonality_error,
            1e-9,
        ),
        check(
            "omega^2 of the iteration against that of the strain energy: largest relative difference",
            modes.frequency_error,
            1e-4,
        ),
    ];
    if !clamped {
        let name = "linear momentum of an elastic mode (drift of the centre of mass), over sqrt(mass)";
        checks.push(check(name, drift, 1e-8));
    }
    if let Some(count) = modes.sturm {
        let name = format!("modes missed below {:.6} rad/s by the inertia of K - omega^2 M", count.omega);
        checks.push(check(&name, count.counted as f64 - count.found as f64, 0.0));
    }
    checks
}

/// Combinations that would give wrong results are refused.
fn check_dynamics(mesh: &Mesh, options: &BuildOptions) -> Result<(), BuildError> {
    if options.inertia == Inertia::Constant {
        return match options.elastic {
            Elastic::Linear => Ok(()),
            Elastic::Geometric => Err(BuildError::Dynamics(
                "elastic forces of large deflections (geometric) ask for consistent inertia: on a curved manifold of shapes \
                 the mass matrix is not constant"
                    .into(),
            )),
        };
    }
    match mesh.inertia_quadrature {
        InertiaQuadrature::Consistent => Ok(()),
        InertiaQuadrature::ReducedCoupling => Err(BuildError::Dynamics(
            "consistent inertia is one kinetic energy for all blocks of the mass matrix: the structure has \
             inertia_quadrature = \"reduced-coupling\", it needs \"consistent\""
                .into(),
        )),
    }
}

fn checked_list(list: &[usize]) -> Result<Vec<usize>, BuildError> {
    let mut sorted = list.to_vec();
    sorted.sort_unstable();
    if sorted.first() == Some(&0) {
        return Err(BuildError::Selection("mode numbers start at 1".into()));
    }
    if let Some(pair) = sorted.windows(2).find(|w| w[0] == w[1]) {
        return Err(BuildError::Selection(format!("mode {} is listed twice", pair[0])));
    }
    Ok(sorted)
}

fn check_relative_rotations(mesh: &Mesh) -> Result<(), BuildError> {
    use crate::element::rotation_field::{MAX_RELATIVE_ROTATION, relative_rotation};
    for e in &mesh.elements {
        let angle = relative_rotation(&e.frames[..e.n_nodes]);
        if angle > MAX_RELATIVE_ROTATION {
            let member = &mesh.members[e.member];
            let element = mesh.elements[member.elements.clone()].iter().position(|x| std::ptr::eq(x, e));
            return Err(BuildError::CoarseElement {
                member: member.name.clone(),
                element: element.map_or(0, |k| k + 1),
                degrees: angle.to_degrees(),
            });
        }
    }
    Ok(())
}

fn row_major(m: &Matrix6<f64>) -> Vec<f64> {
    m.transpose().iter().copied().collect()
}
