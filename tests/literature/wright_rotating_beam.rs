//! Flapping frequencies of a uniform beam clamped on the axis of rotation: A. D. Wright, C. E. Smith, R. W. Thresher and J. L. C. Wang,
//! "Vibration modes of centrifugally stiffened beams", J. Appl. Mech. 49 (1982), by the power series of the exact equation
//! `w'''' - 1/2 W^2 ((1 - x^2) w')' = w^2 w` (length, EI and rho A one), summed here as well. In the plane of rotation Southwell's relation
//! `w_lag^2 = w_flap^2 - W^2` holds exactly for the equation of a beam that does not stretch.

use std::sync::Arc;

use super::{Cantilever, assert_near};
use crate::clamped_free_modes::dense;
use nalgebra::{DMatrix, Vector6};
use rom_generator::assembly::{AnyBeam, Assembly};
use rom_generator::build::build;
use rom_generator::element::gyroscopic::gyroscopic;
use rom_generator::equilibrium::{EquilibriumSettings, solve};
use rom_generator::input::Structure;
use rom_generator::linearise::{Pole, Request, linearise};
use rom_generator::mesh::Mesh;
use rom_generator::solve::dense::generalised_eigen;
use rom_generator::{BuildOptions, Elastic, Inertia, ModeSelection};
use rom_runtime::{Model, State, StateRate, Workspace};

/// `w''(1) w'''(1)` determinant of the two series that start as `x^2` and `x^3`.
fn characteristic(rate: f64, omega: f64) -> f64 {
    let half = 0.5 * rate * rate;
    let ends = |start: usize| {
        let mut a = [0.0; 90];
        a[start] = 1.0;
        for k in 0..86 {
            let n = k as f64;
            let pull = half * ((n + 2.0) * (n + 1.0) * a[k + 2] - n * (n + 1.0) * a[k]);
            let next = (pull + omega * omega * a[k]) / ((n + 4.0) * (n + 3.0) * (n + 2.0) * (n + 1.0));
            if k + 4 > 3 {
                a[k + 4] = next;
            }
        }
        let sum = |f: fn(f64) -> f64| a.iter().enumerate().map(|(k, a)| a * f(k as f64)).sum::<f64>();
        (sum(|k| k * (k - 1.0)), sum(|k| k * (k - 1.0) * (k - 2.0)))
    };
    let (p, q) = (ends(2), ends(3));
    p.0 * q.1 - p.1 * q.0
}

/// Flapping frequency near `guess`.
fn exact(rate: f64, guess: f64) -> f64 {
    let (mut low, mut high) = (0.995 * guess, 1.005 * guess);
    let sign = characteristic(rate, low) > 0.0;
    assert_ne!(sign, characteristic(rate, high) > 0.0, "the frequency is enclosed");
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (characteristic(rate, middle) > 0.0) == sign { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Frequencies of motion along `axis` (1: in the plane of rotation, 2: across it) about the beam stretched by its rotation.
fn frequencies(mesh: &Mesh, rate: f64, axis: usize) -> Vec<f64> {
    let beta = Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, rate);
    let nothing = rom_runtime::loads::LoadCase { loads: Vec::new(), ..mesh.load_cases[0].clone() };
    let settings = EquilibriumSettings { beta, ..Default::default() };
    let at = solve(mesh, &nothing, &settings).unwrap().configuration;
    let assembly = Assembly::new(mesh);
    let mut k = assembly.stiffness(&at);
    for beam in &assembly.beams {
        match beam {
            AnyBeam::Two(b) => assembly.add(&mut k, &b.nodes, &gyroscopic(b, &at.of(b), &beta).k_s),
            AnyBeam::Three(b) => assembly.add(&mut k, &b.nodes, &gyroscopic(b, &at.of(b), &beta).k_s),
        }
    }
    let (k, m) = (dense(&k), dense(&assembly.mass(&at).ss));
    // Motion across an axis of symmetry separates: displacement along `axis` and the rotation that goes with it.
    let pick: Vec<usize> = (0..k.nrows() / 6).flat_map(|i| [6 * i + axis, 6 * i + 6 - axis]).collect();
    let part = |a: &DMatrix<f64>| DMatrix::from_fn(pick.len(), pick.len(), |i, j| a[(pick[i], pick[j])]);
    let (inverse, _) = generalised_eigen(&part(&m), &part(&k)).unwrap();
    inverse.iter().rev().map(|x| 1.0 / x.sqrt()).collect()
}

#[test]
fn flapping_and_lagging_frequencies() {
    let mesh = Cantilever {
        length: 1.0,
        section: "EA = 1e8\nGAy = 1e8\nGAz = 1e8\nGJ = 1\nEIy = 1\nEIz = 1\nrhoA = 1\nrhoJ = [2e-9, 1e-9, 1e-9]",
        elements: 30,
        element_nodes: 3,
        load: r#"frame = "dead", force = [0, 0, 1]"#,
    }
    .mesh();
    let printed = [
        (0.0, [3.5160, 22.0345]),
        (1.0, [3.6816, 22.1810]),
        (2.0, [4.1373, 22.6149]),
        (4.0, [5.5850, 24.2733]),
        (8.0, [9.2568, 29.9954]),
        (12.0, [13.1702, 37.6031]),
    ];
    for (rate, printed) in printed {
        let (flap, lag) = (frequencies(&mesh, rate, 2), frequencies(&mesh, rate, 1));
        for k in 0..2 {
            let exact = exact(rate, printed[k]);
            let what = format!("mode {} at rate {rate}", k + 1);
            assert_near(exact, printed[k], 1.1e-4, &what);
            // Stretch and shear change the frequencies by some 1e-7 W^2, the elements by (b h)^4/1000.
            assert_near(flap[k], exact, 2e-5 * exact, &what);
            assert_near(lag[k], (exact * exact - rate * rate).sqrt(), 2e-5 * exact, &what);
        }
    }
}

#[test]
fn a_rotating_bar_stretches_as_the_sine() {
    // EA (R' - 1)' = -rho A W^2 R: R = sin(k x)/(k cos k), k^2 = rho A W^2/EA, here one fifth: the bar is 7 % longer.
    let mesh = Cantilever {
        length: 1.0,
        section: "EA = 20\nGAy = 1e4\nGAz = 1e4\nGJ = 1\nEIy = 1\nEIz = 1\nrhoA = 1\nrhoJ = [2e-9, 1e-9, 1e-9]",
        elements: 20,
        element_nodes: 3,
        load: r#"frame = "body", moment = [0, 0, 0]"#,
    }
    .mesh();
    let beta = Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 2.0);
    let settings = EquilibriumSettings { beta, ..Default::default() };
    let state = solve(&mesh, &mesh.load_cases[0], &settings).unwrap();
    let k = 0.2f64.sqrt();
    // Fourth order: (k h)^4 = 2.5e-7 of k^2.
    assert_near(
        state.configuration.positions[super::node(&mesh, "tip")].x,
        k.sin() / (k * k.cos()),
        1e-8,
        "tip",
    );
    // The root pulls with mass times the centre's acceleration, W^2 int R.
    let pull = 4.0 * (1.0 / k.cos() - 1.0) / (k * k);
    assert_near(-state.reaction_force.x, pull, 1e-7, "root force");
}

/// Frequencies about a steady spin of a reduced model built at rest: eigenvalues of the derivative of its accelerations.
fn reduced_frequencies(model: &Model, rate: f64) -> Vec<f64> {
    let m = model.n_modes();
    let (loads, mut work, mut out) = (model.no_loads(), Workspace::new(model), StateRate::new(model));
    let range = &model.data().lagrangian.as_ref().unwrap().range;
    let mut accelerations = |i: usize, h: f64| {
        let mut state = State::at_rest(model);
        state.q[i] = h;
        state.beta_star[5] = rate;
        model.derivatives(&state, &loads, &mut work, &mut out).unwrap();
        out.u_dot[..m].to_vec()
    };
    let mut k = DMatrix::zeros(m, m);
    for j in 0..m {
        let h = 1e-4 * range[j];
        let (after, before) = (accelerations(j, h), accelerations(j, -h));
        (0..m).for_each(|i| k[(i, j)] = (before[i] - after[i]) / (2.0 * h));
    }
    k.complex_eigenvalues().iter().map(|x| x.re.sqrt()).collect()
}

/// Of a blade on a hub so heavy that the modes of the free body are those of the clamped blade.
const FREE: &str = "";
/// Of a blade clamped to the axis, which a load case or a host turns.
const CLAMPED: &str = "support = \"clamped\"";

/// A model built at rest.
fn rotor(support: &str, inertia: Inertia, elastic: Elastic) -> Arc<Model> {
    let text = r#"
        [structure]
        name = "rotor"
        SUPPORT
        reference = "root"
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
        rhoJ = [2e-9, 1e-9, 1e-9]
        [points]
        root = [0, 0, 0]
        tip = [1, 0, 0]
        [[members]]
        name = "blade"
        path = ["root", "tip"]
        section = "beam"
        elements = 12
        local_y = [0, 1, 0]
        [[masses]]
        point = "root"
        mass = 1e5
        inertia = [1e5, 1e5, 1e5]
        "#;
    let structure = Structure::from_toml_str(&text.replace("SUPPORT", support), "rotor", &[])
        .unwrap_or_else(|e| panic!("{e}"));
    let options = BuildOptions {
        modes: ModeSelection::Count(8),
        all_nodes: false,
        inertia,
        elastic,
        ..BuildOptions::default()
    };
    Arc::new(Model::new(build(&structure, &options, &mut |_| ()).unwrap()).unwrap())
}

#[test]
fn a_reduced_model_built_at_rest_stiffens_as_it_turns() {
    let model = rotor(FREE, Inertia::Consistent, Elastic::Geometric);
    // 12 is 3.4 times the first frequency at rest.
    for (rate, printed) in [(0.0, [3.5160, 22.0345]), (4.0, [5.5850, 24.2733]), (12.0, [13.1702, 37.6031])] {
        let found = reduced_frequencies(&model, rate);
        let error =
            |expected: f64| found.iter().map(|f| (f / expected - 1.0).abs()).fold(f64::INFINITY, f64::min);
        for flap in printed {
            // Four modes in each plane, shapes of those at rest, terms of 1e-3 dropped.
            assert!(error(flap) < 5e-3, "rate {rate}: {flap} is missed by {:e}: {found:?}", error(flap));
            // In the plane the spin takes W^2 off the square: the same error of the square is a larger one of the frequency.
            let lag = f64::sqrt(flap * flap - rate * rate);
            assert!(error(lag) < 5e-3, "rate {rate}: {lag} is missed by {:e}: {found:?}", error(lag));
        }
    }
}

/// `docs/linearise.md` has the table that this prints.
#[test]
fn poles_about_a_steady_rotation_are_the_published_frequencies() {
    let (geometric, plain) = (
        rotor(FREE, Inertia::Consistent, Elastic::Geometric),
        rotor(FREE, Inertia::Constant, Elastic::Linear),
    );
    let clamped = rotor(CLAMPED, Inertia::Consistent, Elastic::Geometric);
    let poles = |model: &Arc<Model>, rate: f64| -> Vec<Pole> {
        let request = Request { rate: Some([0.0, 0.0, rate]), ..Request::of_equilibrium() };
        let linear = linearise(model, &request).unwrap_or_else(|e| panic!("{e}"));
        assert_near(linear.steady.velocity[5], rate, 1e-9, "rate of the steady state");
        linear.poles
    };
    let growth = |poles: &[Pole]| poles.iter().map(|pole| pole.re).fold(0.0, f64::max);
    let frequencies =
        |poles: &[Pole]| poles.iter().filter(|pole| pole.im > 0.0).map(|pole| pole.im).collect::<Vec<f64>>();
    let nearest = |poles: &[f64], exact: f64| {
        poles.iter().copied().min_by(|a, b| (a - exact).abs().total_cmp(&(b - exact).abs())).unwrap()
    };
    let printed = [
        (0.0, [3.5160, 22.0345]),
        (1.0, [3.6816, 22.1810]),
        (2.0, [4.1373, 22.6149]),
        (4.0, [5.5850, 24.2733]),
        (8.0, [9.2568, 29.9954]),
        (12.0, [13.1702, 37.6031]),
    ];
    for (rate, printed) in printed {
        let (curved, flat) = (poles(&geometric, rate), poles(&plain, rate));
        // Undamped: nothing grows but round-off of the fastest mode.
        assert!(
            growth(&curved) < 1e-6 * geometric.data().modes.omega[7],
            "{} at rate {rate}",
            growth(&curved)
        );
        // The paper's model knows no stretch: in the plane of rotation the spin softens the blade, w^2 - W^2, until it diverges.
        let rest = plain.data().modes.omega[0];
        assert_near(
            growth(&flat),
            (rate * rate - rest * rest).max(0.0).sqrt(),
            1e-3,
            "growth without stiffening",
        );
        // Along the axis of rotation nothing changes but by the hub, which is not infinitely heavy.
        assert_near(nearest(&frequencies(&flat), rest), rest, 1e-4, "flap without stiffening");
        let (curved, held) = (frequencies(&curved), frequencies(&poles(&clamped, rate)));
        for printed in printed {
            let flap = exact(rate, printed);
            assert_near(flap, printed, 1.1e-4, "flap");
            let lag = (flap * flap - rate * rate).sqrt();
            for (name, exact) in [("flap", flap), ("lag", lag)] {
                let found = nearest(&curved, exact);
                let error = 100.0 * (found / exact - 1.0);
                println!("{rate} {name}: exact {exact:.4}, model {found:.4}, {error:+.3} %");
                // Four modes in each plane, of shapes at rest. Of a square the spin takes most in the plane: an error of it is a larger
                // one of the frequency.
                assert_near(found, exact, 5e-3 * exact, &format!("{name} at rate {rate}"));
                // The same on an axis that is turned: the hub is 1e5 times as heavy as the blade.
                assert_near(
                    nearest(&held, exact),
                    found,
                    1e-4 * exact,
                    &format!("clamped: {name} at rate {rate}"),
                );
            }
        }
    }
}
