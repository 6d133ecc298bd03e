//! Cantilevers under loads per length: Timoshenko's linear answers, and large deflections under a load that keeps its direction (a problem
//! that F. V. Rohde treated, Quart. Appl. Math. 11 (1953)) and under one that stays normal to the axis (among those of J. H. Argyris and
//! S. Symeonidis, Comput. Methods Appl. Mech. Engrg. 26 (1981)). No figure of these papers is used, they were not at hand: the answers are
//! those of the differential equations of the elastica, integrated to 1e-10.

use super::{assert_near, displacement, equilibrium, mesh, node};
use rom_generator::equilibrium::Equilibrium;
use rom_generator::mesh::Mesh;

const SLENDER: &str = "EA = 1e8\nGAy = 1e8\nGAz = 1e8\nGJ = 1\nEIy = 1\nEIz = 1\nrhoA = 1\nrhoJ = [2, 1, 1]";
const STOCKY: &str = "EA = 100\nGAy = 20\nGAz = 20\nGJ = 1\nEIy = 1\nEIz = 1\nrhoA = 3\nrhoJ = [2, 1, 1]";

/// A cantilever of unit length along x, with keys of a distributed load on it.
fn cantilever(section: &str, elements: usize, element_nodes: usize, rest: &str) -> Mesh {
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
        tip = [1, 0, 0]
        inside = {{ member = "beam", fraction = 0.63 }}
        [[members]]
        name = "beam"
        path = ["root", "tip"]
        section = "beam"
        elements = {elements}
        local_y = [0, 1, 0]
        {rest}
        "#
    ))
}

fn loaded(section: &str, elements: usize, element_nodes: usize, load: &str) -> (Mesh, Equilibrium) {
    let case =
        format!("[load_cases.q]\nt_end = 1\ndt = 1\ndistributed_loads = [{{ member = \"beam\", {load} }}]");
    let mesh = cantilever(section, elements, element_nodes, &case);
    let found = equilibrium(&mesh);
    (mesh, found)
}

#[test]
fn small_deflections_are_timoshenkos() {
    let q = 1e-4;
    // Uniform, triangular with its peak at the root, a couple per length; bending and shear with EI = 1, GA = 20.
    for (load, tip) in [
        (format!(r#"frame = "dead", force = [0, 0, {q}]"#), q * (1.0 / 8.0 + 0.5 / 20.0)),
        (
            format!(r#"frame = "body", force = [0, 0, {q}], along = [[0, 1], [1, 0]]"#),
            q * (1.0 / 30.0 + 1.0 / 6.0 / 20.0),
        ),
        (
            format!(r#"frame = "follower", force = [0, 0, {q}], along = "1 - s""#),
            q * (1.0 / 30.0 + 1.0 / 120.0),
        ),
        (format!(r#"frame = "dead", moment = [0, {}, 0]"#, -q), q / 3.0),
    ] {
        let (mesh, found) = loaded(STOCKY, 30, 3, &load);
        // Fourth order in the element length, 1e-6, and second in the deflection, 1e-10.
        assert_near(displacement(&mesh, &found, "tip").z / tip, 1.0, 1e-5, &load);
    }
}

#[test]
fn the_reaction_is_the_resultant_whatever_the_elements() {
    // Corners of the load inside elements; the couple of the shifted resultant is exact too.
    let load = r#"frame = "body", force = [0, 0, 1e-6], along = [[0.1, 0], [0.37, 3], [0.8, 1]], from = 0.2"#;
    let (_, found) = loaded(STOCKY, 7, 2, load);
    let segment = |a: f64, b: f64, fa: f64, fb: f64| {
        let total = 0.5 * (fa + fb) * (b - a);
        (total, total * a + (b - a) * (b - a) * (fa + 2.0 * fb) / 6.0)
    };
    let start = 3.0 * 0.1 / 0.27;
    let (first, second) = (segment(0.2, 0.37, start, 3.0), segment(0.37, 0.8, 3.0, 1.0));
    let (force, moment) = ((first.0 + second.0) * 1e-6, (first.1 + second.1) * 1e-6);
    assert_near(found.reaction_force.z / force, -1.0, 1e-12, "force");
    // The lever arm shortens with the square of a deflection of 1e-7.
    assert_near(found.reaction_moment.y / moment, 1.0, 1e-11, "moment");
}

/// Fourth-order Runge-Kutta over unit length.
fn march<const N: usize>(mut y: [f64; N], rate: impl Fn(f64, &[f64; N]) -> [f64; N]) -> [f64; N] {
    let n = 2000;
    let h = 1.0 / f64::from(n);
    let moved = |y: &[f64; N], k: &[f64; N], f: f64| std::array::from_fn(|i| y[i] + f * k[i]);
    for step in 0..n {
        let s = f64::from(step) * h;
        let k1 = rate(s, &y);
        let k2 = rate(s + 0.5 * h, &moved(&y, &k1, 0.5 * h));
        let k3 = rate(s + 0.5 * h, &moved(&y, &k2, 0.5 * h));
        let k4 = rate(s + h, &moved(&y, &k3, h));
        for i in 0..N {
            y[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
    y
}

/// Tip (w, u, angle) under a uniform load that keeps its direction: `phi'' = -q (1 - s) cos phi`, `phi(0) = phi'(1) = 0`.
fn dead(q: f64) -> [f64; 3] {
    let shot = |curvature: f64| {
        let rate = |s: f64, y: &[f64; 4]| [y[1], -q * (1.0 - s) * y[0].cos(), y[0].sin(), y[0].cos() - 1.0];
        march([0.0, curvature, 0.0, 0.0], rate)
    };
    let (mut low, mut high) = (0.0, q);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if shot(middle)[1] < 0.0 { low = middle } else { high = middle }
    }
    let [phi, _, w, u] = shot(0.5 * (low + high));
    [w, -u, phi]
}

/// The same under a load normal to the axis, marched from the free end in its own axes: forces along and across the section, moment.
fn following(q: f64) -> [f64; 3] {
    // (angle, x, z, axial force, shear force, moment) at s from the tip; the part cut off is in balance with its load q across.
    let rate = |_: f64, y: &[f64; 6]| {
        let [phi, _, _, n, v, m] = *y;
        [-m, -phi.cos(), -phi.sin(), -m * v, m * n + q, v]
    };
    let [phi, x, z, ..] = march([0.0; 6], rate);
    // The root at (x, z) with the angle phi, the tip at the origin with none; turned so that the root is clamped along x.
    let (sin, cos) = phi.sin_cos();
    let (dx, dz) = (-x * cos - z * sin, x * sin - z * cos);
    [dz, 1.0 - dx, -phi]
}

fn tip(q: f64, frame: &str, elements: usize, element_nodes: usize) -> [f64; 3] {
    let (mesh, found) =
        loaded(SLENDER, elements, element_nodes, &format!(r#"frame = "{frame}", force = [0, 0, {q}]"#));
    let u = displacement(&mesh, &found, "tip");
    [u.z, -u.x, -found.configuration.rotations[node(&mesh, "tip")].scaled_axis().y]
}

#[test]
fn large_deflections_are_those_of_the_elastica() {
    for q in [2.0, 8.0] {
        for (frame, exact) in [("dead", dead(q)), ("follower", following(q))] {
            let found = tip(q, frame, 30, 3);
            for k in 0..3 {
                // Fourth order: (1/30)^4 = 1e-6 times derivatives of the order of the load; shear and stretch 1e-7.
                assert_near(found[k], exact[k], 5e-6, &format!("{frame}, q = {q}, component {k}"));
            }
        }
    }
    let error = |frame: &str, exact: [f64; 3], elements: usize| {
        let found = tip(4.0, frame, elements, 2);
        (0..3).map(|k| (found[k] - exact[k]).abs()).fold(0.0, f64::max)
    };
    for (frame, exact) in [("dead", dead(4.0)), ("follower", following(4.0))] {
        let slope = (error(frame, exact, 16) / error(frame, exact, 32)).log2();
        assert_near(slope, 2.0, 0.15, &format!("order of linear elements, {frame}"));
    }
}

#[test]
fn weight_is_a_dead_load_of_the_mass_per_length() {
    let by_gravity = cantilever(
        STOCKY,
        9,
        3,
        "[gravity]\nacceleration = [0.2, 0.3, -0.5]\n[load_cases.none]\nt_end = 1\ndt = 1\nloads = []",
    );
    let heavy = equilibrium(&by_gravity);
    let (_, loaded) = loaded(STOCKY, 9, 3, r#"frame = "dead", force = [0.6, 0.9, -1.5]"#);
    let positions = |found: &Equilibrium| found.configuration.positions.clone();
    let moved =
        positions(&heavy).iter().zip(&by_gravity.nodes).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(moved > 0.1);
    for (a, b) in positions(&heavy).iter().zip(&positions(&loaded)) {
        // Newton's tolerance, squared.
        assert!((a - b).norm() < 1e-12, "{a} {b}");
    }
}

/// A point between nodes goes with the axis, and a load there bends the beam as statics says.
#[test]
fn loads_between_nodes() {
    let rest = r#"
        [load_cases.q]
        t_end = 1
        dt = 1
        loads = [{ point = "inside", frame = "dead", force = [0, 0, 1e-4] }]
        "#;
    for (elements, element_nodes) in [(41, 2), (11, 3)] {
        let mesh = cantilever(STOCKY, elements, element_nodes, rest);
        let found = equilibrium(&mesh);
        let a: f64 = 0.63;
        // Tip: a^2 (3 - a)/6 EI of bending and a/GA of shear.
        let tip = 1e-4 * (a * a * (3.0 - a) / 6.0 + a / 20.0);
        let u = displacement(&mesh, &found, "tip");
        // The kink inside an element: second order, (1/41)^2 and (1/22)^2 times a number below one.
        assert_near(u.z / tip, 1.0, 2e-3, &format!("{elements} elements"));
        assert_near(found.reaction_moment.y, 1e-4 * a, 1e-13, "the moment of the lever arm");
    }
}
