//! Structures for unit tests, made by hand so that they do not depend on the input reader.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use rom_runtime::data::Provenance;
use rom_runtime::loads::{Load, LoadCase};

use crate::mesh::{
    Damping, Element, InertiaQuadrature, LumpedMass, Member, Mesh, Place, Point, Section, Support,
};

fn empty(name: &str, section: Section) -> Mesh {
    Mesh {
        name: name.into(),
        nodes: Vec::new(),
        reference: 0,
        reference_position: Vector3::zeros(),
        sections: vec![section],
        elements: Vec::new(),
        members: Vec::new(),
        lumped: Vec::new(),
        points: Vec::new(),
        load_cases: Vec::new(),
        sensors: Vec::new(),
        stations: Vec::new(),
        cuts: Vec::new(),
        gravity: Vector3::zeros(),
        trim: None,
        support: Support::Free,
        damping: Damping::default(),
        inertia_quadrature: InertiaQuadrature::Consistent,
    }
}

/// Section frame with local x along `x` and local y near `y`.
fn frame(x: Vector3<f64>, y: Vector3<f64>) -> Matrix3<f64> {
    let x = x.normalize();
    let z = x.cross(&y).normalize();
    Matrix3::from_columns(&[x, z.cross(&x), z])
}

/// Appends a straight member between two existing nodes.
pub(crate) fn add_line(
    mesh: &mut Mesh,
    from: usize,
    to: usize,
    elements: usize,
    n_nodes: usize,
    y: Vector3<f64>,
) {
    let (a, b) = (mesh.nodes[from], mesh.nodes[to]);
    let steps = elements * (n_nodes - 1);
    let e = frame(b - a, y);
    let mut line = vec![from];
    for k in 1..steps {
        line.push(mesh.nodes.len());
        mesh.nodes.push(a + (b - a) * (k as f64 / steps as f64));
    }
    line.push(to);
    let member = mesh.members.len();
    let first = mesh.elements.len();
    for k in 0..elements {
        let at = |i: usize| line[k * (n_nodes - 1) + i.min(n_nodes - 1)];
        mesh.elements.push(Element {
            member,
            nodes: [at(0), at(1), at(2)],
            n_nodes,
            length: (b - a).norm() / elements as f64,
            frames: [e; 3],
            levers: [Vector3::zeros(); 3],
            sections: [0, 0],
        });
    }
    mesh.members.push(Member {
        name: format!("member {member}"),
        elements: first..first + elements,
        nodes: line,
    });
}

fn point(mesh: &mut Mesh, name: &str, node: usize) {
    let frames = mesh.elements.iter().find(|e| e.nodes[..e.n_nodes].contains(&node));
    let sections = frames.map(|e| (mesh.members[e.member].name.clone(), e.frames[0])).into_iter().collect();
    mesh.points.push(Point {
        name: name.into(),
        place: Place::Node(node),
        offset: Vector3::zeros(),
        sections,
    });
}

/// The published frame FMB (section 4.2 of the paper).
pub(crate) fn fmb(sigma: f64, elements: usize, n_nodes: usize) -> Mesh {
    let (b, h, rho, e) = (0.1_f64, 0.05_f64, 2700.0, sigma * 70e9);
    let (area, g) = (b * h, e / 2.6);
    let (iy, iz) = (b * h.powi(3) / 12.0, h * b.powi(3) / 12.0);
    let gj = 0.22887745119762 * g * b * h.powi(3);
    let stiffness = [e * area, 5.0 / 6.0 * g * area, 5.0 / 6.0 * g * area, gj, e * iy, e * iz];
    let mass = [area, area, area, iy + iz, iy, iz].map(|x| rho * x);
    let section = Section {
        name: "bar".into(),
        stiffness: Matrix6::from_diagonal(&Vector6::from(stiffness)),
        mass: Matrix6::from_diagonal(&Vector6::from(mass)),
        retardation: 0.0,
    };
    let mut mesh = empty("FMB", section);
    let corners = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 0.0, 5.0], [-10.0, 0.0, 0.0], [-10.0, 0.0, 5.0]];
    mesh.nodes = corners.map(Vector3::from).to_vec();
    let y = Vector3::y();
    for (from, to, n) in
        [(0, 1, elements / 3), (1, 2, elements / 6), (0, 3, elements / 3), (3, 4, elements / 6)]
    {
        add_line(&mut mesh, from, to, n, n_nodes, y);
    }
    for (name, node) in [("A", 0), ("right corner", 1), ("P", 2), ("left corner", 3), ("Q", 4)] {
        point(&mut mesh, name, node);
    }
    mesh
}

/// A small tree of curved, tapered beams with full section matrices, skew frames and eccentric masses: nothing cancels.
pub(crate) fn crooked(n_nodes: usize) -> Mesh {
    let mut random = crate::element::tests::Random::new(11);
    let mut section = |name: &str| Section {
        name: name.into(),
        stiffness: random.spd() * 100.0,
        mass: random.spd(),
        retardation: 0.0,
    };
    let (s0, s1) = (section("one"), section("two"));
    let mut mesh = empty("crooked", s0);
    mesh.sections.push(s1);
    mesh.nodes =
        [[0.0, 0.0, 0.0], [2.0, 0.3, 0.1], [-1.0, 1.5, 0.7], [2.5, -1.0, 1.2]].map(Vector3::from).to_vec();
    let y = Vector3::new(0.1, 0.3, 1.0);
    for (from, to, n) in [(0, 1, 3), (0, 2, 2), (1, 3, 2)] {
        add_line(&mut mesh, from, to, n, n_nodes, y);
    }
    for (k, e) in mesh.elements.iter_mut().enumerate() {
        e.sections = [k % 2, 1];
        let bend = crate::math::so3::exp(&Vector3::new(0.1, 0.2, -0.1));
        e.frames = [e.frames[0], bend * e.frames[1], bend * bend * e.frames[2]];
    }
    // The member to node 2 starts at a rigid link from the root, the last one ends at one from its tip.
    let first = mesh.members[1].elements.start;
    mesh.elements[first].levers[0] = Vector3::new(0.1, 0.2, -0.3);
    let last = mesh.members[2].elements.end - 1;
    let n = mesh.elements[last].n_nodes;
    mesh.elements[last].levers[n - 1] = Vector3::new(-0.2, 0.1, 0.4);
    for node in [0, 2, 3] {
        mesh.lumped.push(LumpedMass { node, mass: random.spd() });
    }
    for (name, node) in [("A", 0), ("P", 3)] {
        point(&mut mesh, name, node);
    }
    mesh
}

/// As [`crooked`], with section masses and lumps that are those of bodies, their centres beside the axes.
pub(crate) fn crooked_body(n_nodes: usize) -> Mesh {
    let mut mesh = crooked(n_nodes);
    let mut random = crate::element::tests::Random::new(31);
    mesh.sections.iter_mut().for_each(|section| section.mass = random.body());
    mesh.lumped.iter_mut().for_each(|lump| lump.mass = random.body());
    mesh
}

/// Origin of a model that no file describes.
pub(crate) fn provenance() -> Provenance {
    Provenance {
        name: "test".into(),
        generator: "test".into(),
        input_text: String::new(),
        input_sha256: "0".repeat(64),
        options: Vec::new(),
        parameters: Vec::new(),
        n_elements: 1,
        n_dof: 1,
    }
}

/// Loads for a second.
pub(crate) fn case(loads: Vec<Load>) -> LoadCase {
    LoadCase { dt: 0.01, loads, ..LoadCase::empty("test") }
}
