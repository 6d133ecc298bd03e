//! The generator's main job: from a mesh to everything a model file holds.

use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};
use rom_runtime::data::{CheckData, ModelData, ModesData, PictureData, PointData, Provenance, RigidData};

use crate::assembly::{Assembly, MassMatrix};
use crate::configuration::Configuration;
use crate::mesh::Mesh;
use crate::reduce::modes::{Modes, count_below, elastic_modes, kinetic_share};
use crate::reduce::tensors::{DROP, Tensors, project};
use crate::solve::eigen::EigenError;

/// Most modes a reduced model may keep: its tensors grow with the square of the number.
pub const MAX_MODES: usize = 300;

/// Which elastic modes to keep.
#[derive(Clone, Debug, PartialEq)]
pub enum ModeSelection {
    /// The lowest so many.
    Count(usize),
    /// By number in the ascending list, from 1.
    List(Vec<usize>),
    /// All below a circular frequency, rad/s.
    Below(f64),
}

/// Options of a build.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildOptions {
    /// Modes to keep.
    pub modes: ModeSelection,
    /// Store every node for pictures.
    pub all_nodes: bool,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { modes: ModeSelection::Count(10), all_nodes: true }
    }
}

/// Stages of a build, for progress displays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Matrices of the structure.
    Assembly,
    /// Free-free modes.
    Modes,
    /// Constant tensors.
    Tensors,
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
    /// The modes could not be computed.
    #[error("modes: {0}")]
    Modes(#[from] EigenError),
}

/// Builds the reduced model of a structure about its drawing.
pub fn build(
    mesh: &Mesh,
    provenance: Provenance,
    options: &BuildOptions,
    progress: &mut dyn FnMut(Stage),
) -> Result<ModelData, BuildError> {
    progress(Stage::Assembly);
    check_relative_rotations(mesh)?;
    let assembly = Assembly::new(mesh);
    let at = Configuration::drawing(mesh);
    let mass = assembly.mass(&at);
    let stiffness = assembly.stiffness(&at);

    progress(Stage::Modes);
    let available = 6 * assembly.n_blocks();
    let (numbers, count) = match &options.modes {
        ModeSelection::Count(n) => ((1..=*n).collect::<Vec<_>>(), *n),
        ModeSelection::List(list) => (checked_list(list)?, list.iter().copied().max().unwrap_or(0)),
        ModeSelection::Below(omega) => {
            if !(omega.is_finite() && *omega > 0.0) {
                return Err(BuildError::Selection(format!("frequency limit {omega} rad/s is not positive")));
            }
            let n = count_below(&mass, &stiffness, *omega)?;
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
    let modes = elastic_modes(&assembly, &at, &mass, &stiffness, count)?.select(&numbers);

    progress(Stage::Tensors);
    let tensors = project(&assembly, &at, &modes);
    progress(Stage::Done);
    Ok(model_data(mesh, provenance, options, Parts { assembly, at, mass, modes, tensors, numbers }))
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

fn model_data(mesh: &Mesh, mut provenance: Provenance, options: &BuildOptions, parts: Parts) -> ModelData {
    let Parts { assembly, at, mass, modes, tensors, numbers } = parts;
    provenance.n_elements = mesh.elements.len() as u64;
    provenance.n_dof = 6 * mesh.nodes.len() as u64;
    let (c, k) = tensors.to_sparse(&mass.rr, DROP);
    let (total, centre) = Assembly::centre_of_mass(&mass.rr);
    ModelData {
        provenance,
        rigid: RigidData {
            mass: total,
            centre_of_mass: centre.into(),
            mass_matrix: row_major(&mass.rr),
            initial_position: mesh.reference_position.into(),
        },
        checks: checks(&modes, &mass),
        modes: modes_data(mesh, &assembly, &at, &mass, &modes, &numbers),
        c,
        k,
        points: mesh.points.iter().map(|p| point_data(p, &at, &modes)).collect(),
        load_cases: mesh.load_cases.clone(),
        picture: options.all_nodes.then(|| picture(mesh, &at, &modes)),
    }
}

fn modes_data(
    mesh: &Mesh,
    assembly: &Assembly,
    at: &Configuration,
    mass: &MassMatrix,
    modes: &Modes,
    numbers: &[usize],
) -> ModesData {
    let m = modes.m();
    // M_RS phi_S = -M_RR phi_R, whose first rows are the first moment of the displacements.
    let momentum: Vec<Vector6<f64>> = modes.phi_r.iter().map(|phi| -(mass.rr * phi)).collect();
    ModesData {
        number: numbers.iter().map(|&n| n as u32).collect(),
        omega: modes.omega.clone(),
        mass: vec![1.0; m],
        damping_ratio: vec![mesh.modal_damping; m],
        phi_r: (0..6).flat_map(|r| modes.phi_r.iter().map(move |phi| phi[r])).collect(),
        first_moment: (0..3).flat_map(|r| momentum.iter().map(move |p| p[r])).collect(),
        kinetic_share: kinetic_share(assembly, at, modes),
        next_omega: modes.next_omega,
    }
}

fn point_data(point: &crate::mesh::Point, at: &Configuration, modes: &Modes) -> PointData {
    let phi = modes.at_node(point.node);
    let rows = |first: usize| (first..first + 3).flat_map(|k| phi.iter().map(move |v| v[k])).collect();
    PointData {
        name: point.name.clone(),
        node_position: at.positions[point.node].into(),
        node_rotation: scalar_first(&at.rotations[point.node]),
        offset: point.offset.into(),
        phi_translation: rows(0),
        phi_rotation: rows(3),
        sections: point
            .sections
            .iter()
            .map(|(name, e)| (name.clone(), std::array::from_fn(|i| std::array::from_fn(|j| e[(i, j)]))))
            .collect(),
    }
}

fn picture(mesh: &Mesh, at: &Configuration, modes: &Modes) -> PictureData {
    let flat = |r: &Vector3<f64>| [r.x, r.y, r.z];
    PictureData {
        positions: at.positions.iter().flat_map(flat).collect(),
        phi_translation: (0..mesh.nodes.len())
            .flat_map(|node| (0..3).flat_map(move |k| modes.at_node(node).iter().map(move |phi| phi[k])))
            .collect(),
        lines: mesh.members.iter().map(|m| m.nodes.iter().map(|&n| n as u32).collect()).collect(),
    }
}

fn checks(modes: &Modes, mass: &MassMatrix) -> Vec<CheckData> {
    let check = |name: &str, value: f64, limit: f64| CheckData { name: name.into(), value, limit };
    // Centre of mass in a mode: first moment of the elastic part plus that of A's own motion.
    let drift = modes
        .phi_r
        .iter()
        .map(|phi| {
            let momentum = mass.rr * phi;
            let by_parts: Vector3<f64> = mass.rr.fixed_view::<3, 3>(0, 0) * phi.fixed_rows::<3>(0)
                + mass.rr.fixed_view::<3, 3>(0, 3) * phi.fixed_rows::<3>(3);
            (by_parts - momentum.fixed_rows::<3>(0)).amax() / mass.rr[(0, 0)].sqrt()
        })
        .fold(0.0, f64::max);
    vec![
        check(
            "orthogonality of the modes in the full mass matrix, largest entry of Phi^t M Phi - I",
            modes.orthogonality_error,
            1e-9,
        ),
        check(
            "frequencies by iteration against energies, largest relative difference of omega^2",
            modes.frequency_error,
            1e-4,
        ),
        check(
            "drift of the centre of mass in an elastic mode, relative",
            drift.max(modes.orthogonality_error),
            1e-9,
        ),
        check("modes counted below the highest kept one by inertia, missing", 0.0, 0.0),
    ]
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

fn scalar_first(q: &UnitQuaternion<f64>) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}
