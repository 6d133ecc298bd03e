//! Elastica of a cantilever under a dead tip force across it: K. E. Bisshopp and D. C. Drucker, "Large deflection of cantilever
//! beams", Quart. Appl. Math. 3 (1945), in elliptic integrals, and their values as printed by K. Mattiasson, "Numerical results from
//! large deflection beam and frame problems analysed by means of elliptic integrals", Int. J. Numer. Methods Engrg. 17 (1981).
//!
//! With `a = P L^2/EI` and the tip's angle `phi`: `k^2 = (1 + sin phi)/2`, `sin t = 1/(k sqrt 2)`,
//! `sqrt a = K(k) - F(t, k)`, `w/L = 1 - 2 (E(k) - E(t, k))/sqrt a`, `1 - u/L = sqrt(2 sin phi/a)`.

use super::{Cantilever, assert_near, displacement, equilibrium, node};
use rom_generator::build::build;
use rom_generator::input::Structure;
use rom_generator::{BuildOptions, Elastic, Inertia, ModeSelection};
use rom_runtime::loads::{InitialState, Load, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;
use rom_runtime::{Model, Simulation};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// Composite Simpson rule, far finer than needed for these smooth integrands.
fn integral(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let n = 20_000;
    let h = (to - from) / f64::from(n);
    let weight = |i: i32| if i == 0 || i == n { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    (0..=n).map(|i| weight(i) * f(from + h * f64::from(i))).sum::<f64>() * h / 3.0
}

/// Tip of the elastica: (w/L, u/L, phi).
fn elastica(a: f64) -> [f64; 3] {
    let modulus = |phi: f64| ((1.0 + phi.sin()) / 2.0).sqrt();
    let start = |k: f64| (1.0 / (k * 2f64.sqrt())).min(1.0).asin();
    let first = |phi: f64| {
        let k = modulus(phi);
        integral(|t| 1.0 / (1.0 - (k * t.sin()).powi(2)).sqrt(), start(k), FRAC_PI_2)
    };
    let (mut low, mut high) = (1e-6, FRAC_PI_2 - 1e-6);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if first(middle) < a.sqrt() { low = middle } else { high = middle }
    }
    let phi = 0.5 * (low + high);
    let k = modulus(phi);
    let second = integral(|t| (1.0 - (k * t.sin()).powi(2)).sqrt(), start(k), FRAC_PI_2);
    [1.0 - 2.0 * second / a.sqrt(), 1.0 - (2.0 * phi.sin() / a).sqrt(), phi]
}

/// Tip of the finite-element cantilever, EI = L = 1, practically without shear and stretch (1e8: changes of the order 1e-7).
fn tip(a: f64, elements: usize, element_nodes: usize) -> [f64; 3] {
    let load = format!(r#"frame = "dead", force = [0, 0, {a}]"#);
    let mesh = Cantilever {
        length: 1.0,
        section: "EA = 1e8\nGAy = 1e8\nGAz = 1e8\nGJ = 1\nEIy = 1\nEIz = 1\nrhoA = 1\nrhoJ = [2, 1, 1]",
        elements,
        element_nodes,
        load: &load,
    }
    .mesh();
    let state = equilibrium(&mesh);
    let u = displacement(&mesh, &state, "tip");
    [u.z, -u.x, -state.configuration.rotations[node(&mesh, "tip")].scaled_axis().y]
}

#[test]
fn tip_against_elliptic_integrals_and_the_printed_table() {
    let table = [
        (1.0, [0.30172, 0.05643, 0.46135]),
        (2.0, [0.49346, 0.16064, 0.78175]),
        (5.0, [0.71379, 0.38763, 1.21537]),
        (10.0, [0.81061, 0.55500, 1.43029]),
    ];
    for (a, printed) in table {
        let (exact, found) = (elastica(a), tip(a, 40, 3));
        for k in 0..3 {
            assert_near(exact[k], printed[k], 5.1e-6, "elliptic integrals against the printed table");
            // Fourth order: (1/40)^4 = 4e-7 times derivatives of the order a; shear and stretch 1e-7.
            assert_near(found[k], exact[k], 1e-6, &format!("a = {a}, component {k}"));
        }
    }
}

#[test]
fn linear_elements_converge_with_order_two_and_quadratic_ones_with_four() {
    let exact = elastica(5.0);
    for (element_nodes, meshes, order) in [(2, [16, 32], 2.0), (3, [6, 12], 4.0)] {
        let error = |elements: usize| {
            let found = tip(5.0, elements, element_nodes);
            (0..3).map(|k| (found[k] - exact[k]).abs()).fold(0.0, f64::max)
        };
        let slope = (error(meshes[0]) / error(meshes[1])).log2();
        assert_near(slope, order, 0.15, &format!("order with {element_nodes} nodes"));
    }
}

/// A reduced model of the clamped beam on the curved manifold, made once without load, held by its static shape under the force.
#[test]
fn a_reduced_model_bends_as_the_elastica_to_the_order_of_its_manifold() {
    let text = r#"
        [structure]
        name = "cantilever"
        reference = "root"
        support = "clamped"
        element_nodes = 3
        [sections.beam]
        shape = "constants"
        EA = 1e8
        GAy = 1e8
        GAz = 1e8
        GJ = 1
        EIy = 1
        EIz = 1
        rhoA = 1
        rhoJ = [2e-6, 1e-6, 1e-6]
        [points]
        root = [0, 0, 0]
        tip = [1, 0, 0]
        [[members]]
        name = "beam"
        path = ["root", "tip"]
        section = "beam"
        elements = 12
        local_y = [0, 1, 0]
        "#;
    let structure = Structure::from_toml_str(text, "cantilever", &[]).unwrap_or_else(|e| panic!("{e}"));
    let options = BuildOptions {
        modes: ModeSelection::Count(12),
        all_nodes: false,
        inertia: Inertia::Consistent,
        elastic: Elastic::Geometric,
        ..BuildOptions::default()
    };
    let model = Arc::new(Model::new(build(&structure, &options, &mut |_| ()).unwrap()).unwrap());
    let point = model.point("tip").unwrap();
    for a in [0.5, 1.0, 2.0, 5.0] {
        let load = Load {
            point: point as u32,
            frame: LoadFrame::Dead,
            force: [0.0, 0.0, a],
            moment: [0.0; 3],
            time: TimeFunction::Constant { value: 1.0 },
        };
        let initial = InitialState { shape: vec![load.clone()], ..InitialState::default() };
        let case = LoadCase { loads: vec![load], initial: Some(initial), ..LoadCase::empty("held") };
        let mut simulation = Simulation::new(model.clone(), rom_runtime::Settings::default()).unwrap();
        simulation.restore(&model.initial_state(&case).unwrap()).unwrap();
        let loads = model.prepare(&case).unwrap();
        let exact = elastica(a);
        // Directions of the third order in their angles miss `theta^4/24` of their cosines. Those of the beam rise about as `2 s - s^2`
        // along it to the angle of the tip, and the fourth power of that has an integral of 0.41. Modes from the seventh of the plane on
        // have `12 (bL)^-4` each, 4e-5 in all, of a straight beam's deflection `a/3`.
        let tolerance = 1.25 * 0.41 * exact[2].powi(4) / 24.0 + 1e-4 * a;
        println!("a = {a}: {exact:.4?}");
        for step in 0..3 {
            let moved = simulation.point_output(point).unwrap().dr_a;
            println!("  {:.4} {:.4}", moved[2], -moved[0]);
            assert_near(moved[2], exact[0], tolerance, &format!("a = {a}, step {step}: deflection"));
            assert_near(-moved[0], exact[1], tolerance, &format!("a = {a}, step {step}: shortening"));
            assert_near(moved[1], 0.0, 1e-9, "out of the plane");
            simulation.step(&loads).unwrap();
            // The clamp is pulled by the force, and twisted by it on its arm, which the rigid rows have to know from the deformed mass.
            let told = simulation.reaction().unwrap().total();
            assert_near(told[2], a, 1e-6 * a, "pull on the clamp");
            assert_near(told[4], -a * (1.0 + moved[0]), 1e-6 * a, "moment on the clamp");
        }
    }
}
