//! Published and closed-form answers, one source a file. Tolerances: half a unit of the last digit quoted, unless the file says
//! otherwise.

mod argyris_right_angle_frame;
mod bathe_bolourchi;
mod beamdyn;
mod bisshopp_drucker_elastica;
mod clamped_free_modes;
mod distributed_loads;
mod geradin_cardona;
mod hale;
mod hesse_palacios;
mod joined_wing;
mod kane_spin_up;
mod princeton_beam;
mod rings_and_portals;
mod roll_up;
mod t_tail;
mod wright_rotating_beam;

use nalgebra::Vector3;
use rom_generator::equilibrium::{Equilibrium, EquilibriumError, EquilibriumSettings, solve};
use rom_generator::input::Structure;
use rom_generator::mesh::Mesh;

/// The mesh of a structure file.
fn mesh(text: &str) -> Mesh {
    Structure::from_toml_str(text, "test.toml", &[]).unwrap_or_else(|e| panic!("{e}")).mesh()
}

/// A cantilever along x from the origin, clamped there, with one load case `tip` of one load at its free end `tip`.
struct Cantilever<'a> {
    length: f64,
    /// Keys of a section of shape `constants`.
    section: &'a str,
    elements: usize,
    element_nodes: usize,
    load: &'a str,
}

impl Cantilever<'_> {
    fn mesh(&self) -> Mesh {
        let Self { length, section, elements, element_nodes, load } = self;
        mesh(&format!(
            r#"
            [structure]
            name = "cantilever"
            reference = "root"
            element_nodes = {element_nodes}
            [sections.beam]
            shape = "constants"
            {section}
            [points]
            root = [0, 0, 0]
            tip = [{length}, 0, 0]
            [[members]]
            name = "beam"
            path = ["root", "tip"]
            section = "beam"
            elements = {elements}
            local_y = [0, 1, 0]
            [load_cases.tip]
            t_end = 1
            dt = 1
            loads = [{{ point = "tip", {load} }}]
            "#
        ))
    }
}

/// Static equilibrium of the structure under its first load case.
fn try_equilibrium(mesh: &Mesh) -> Result<Equilibrium, EquilibriumError> {
    solve(mesh, &mesh.load_cases[0], &EquilibriumSettings::default())
}

fn equilibrium(mesh: &Mesh) -> Equilibrium {
    try_equilibrium(mesh).unwrap_or_else(|e| panic!("{e}"))
}

/// Node of a named point.
fn node(mesh: &Mesh, point: &str) -> usize {
    let point = mesh.points.iter().find(|p| p.name == point).expect("the point is in the file");
    point.node().expect("the point is at a node")
}

/// Displacement of a named point.
fn displacement(mesh: &Mesh, state: &Equilibrium, point: &str) -> Vector3<f64> {
    let node = node(mesh, point);
    state.configuration.positions[node] - mesh.nodes[node]
}

fn assert_near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found}, expected {expected} within {tolerance}");
}
