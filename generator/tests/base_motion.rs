//! Structures on a base that is moved or held, and runs that start from something: against closed solutions, in every method.

use std::f64::consts::PI;
use std::sync::Arc;

use rom_generator::build::{BuildOptions, ModeSelection, build_mesh, provenance};
use rom_generator::input::Structure;
use rom_generator::mesh::Mesh;
use rom_generator::reference::method::{Method, Output, Prepared, Run, RunSettings, start_reduced};
use rom_runtime::data::ModelData;
use rom_runtime::loads::LoadCase;
use rom_runtime::{Integrator, Model};

/// Wave numbers times length of a clamped-free beam, and `sigma` of its shapes.
const WAVES: [(f64, f64); 5] = [
    (1.875_104_068_711_961, 0.734_095_513_758),
    (4.694_091_132_974_175, 1.018_467_318_759),
    (7.854_757_438_237_613, 0.999_224_496_517),
    (10.995_540_734_875_467, 1.000_033_553_252),
    (14.137_168_391_046_47, 0.999_998_550_109),
];

fn beam(support: &str, extra: &str) -> Structure {
    let text = format!(
        r#"
        [structure]
        name = "beam"
        reference = "root"
        element_nodes = 3
        support = "{support}"
        [sections.beam]
        shape = "constants"
        EA = 1e6
        GAy = 1e6
        GAz = 1e6
        GJ = 40
        EIy = 10
        EIz = 40
        rhoA = 2
        rhoJ = [2e-5, 1e-5, 1e-5]
        [points]
        root = [0, 0, 0]
        tip = [2, 0, 0]
        [[members]]
        name = "beam"
        path = ["root", "tip"]
        section = "beam"
        elements = 12
        local_y = [0, 1, 0]
        {extra}
        "#
    );
    Structure::from_toml_str(&text, "beam.toml", &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// Bending about y: `omega = (b L)^2 sqrt(EI/(rho A L^4))`.
fn omega(mode: usize) -> f64 {
    WAVES[mode].0.powi(2) * (10.0_f64 / (2.0 * 16.0)).sqrt()
}

/// Effective mass over mass, and tip displacement per base motion, of a bending mode: `(2 sigma/bL)^2`, `+-4 sigma/bL`.
fn effective(mode: usize) -> [f64; 2] {
    let (b, sigma) = WAVES[mode];
    let sign = if mode.is_multiple_of(2) { 1.0 } else { -1.0 };
    [(2.0 * sigma / b).powi(2), sign * 4.0 * sigma / b]
}

fn data(structure: &Structure, modes: usize) -> ModelData {
    let options =
        BuildOptions { modes: ModeSelection::Count(modes), all_nodes: false, ..BuildOptions::default() };
    let mesh = structure.mesh();
    build_mesh(&mesh, provenance(structure, &options, &mesh), &options, &mut |_| ()).unwrap()
}

fn settings(dt: f64) -> RunSettings {
    RunSettings { dt, integrator: Integrator::Newmark, numerical_damping: 0.0 }
}

const FULL: [Method; 3] = [Method::Nonlinear, Method::ConstantMass, Method::Linear];

/// The load case by one method, seen after every step.
fn march(
    structure: &Structure,
    method: Method,
    modes: usize,
    dt: f64,
    steps: usize,
    mut see: impl FnMut(&Output),
) {
    let mesh: Mesh = structure.mesh();
    let case: LoadCase = mesh.load_cases[0].clone();
    let prepared = Prepared::new(mesh);
    let mut run: Box<dyn Run + '_> = if method.is_reduced() {
        let model = Arc::new(Model::new(data(structure, modes)).unwrap());
        start_reduced(&model, method, &case, &settings(dt)).unwrap()
    } else {
        prepared.start(method, &case, &settings(dt)).unwrap()
    };
    see(&run.output());
    for _ in 0..steps {
        run.step().unwrap();
        see(&run.output());
    }
}

/// Frequencies and effective masses of the clamped beam; the latter add up to nearly all of the mass.
#[test]
fn clamped_modes_are_those_of_a_cantilever() {
    let data = data(&beam("clamped", ""), 8);
    let clamped = data.clamped.as_ref().unwrap();
    let m = data.modes.omega.len();
    let mut found = 0.0;
    for mode in 0..3 {
        let at = data.modes.omega.iter().position(|w| (w / omega(mode) - 1.0).abs() < 1e-3).unwrap();
        let share = clamped.participation[2 * m + at].powi(2) / data.rigid.mass;
        // Mesh, rotary inertia and shear: (b h)^4/1000 and (b r)^2.
        assert!((share - effective(mode)[0]).abs() < 1e-3, "{share} {:?}", effective(mode));
        found += share;
    }
    assert!(found > 0.86 && data.modes.phi_r.iter().all(|x| *x == 0.0));
    assert!(data.checks.iter().all(|check| check.value <= check.limit), "{:?}", data.checks);
}

/// `v = V cos(W t)` of the base along z: `q_i = L_i V W/(w_i^2 - W^2) (sin W t - W/w_i sin w_i t)` in every mode. The reaction is the
/// inertia of all of the beam.
#[test]
fn a_shaken_cantilever_follows_the_closed_solution_in_every_method() {
    let (shake, speed) = (12.0, 1e-4);
    let case = format!(
        "[load_cases.shake]\nt_end = 1\ndt = 0.001\nmotion = {{ velocity = {{ z = {{ shape = \"sine\", amplitude = {speed}, omega = {shake}, phase = \"pi/2\" }} }} }}"
    );
    let clamped = beam("clamped", &case);
    let expected = |t: f64| {
        let (mut tip, mut force) = (0.0, 2.0 * 2.0 * speed * shake * (shake * t).sin());
        for mode in 0..5 {
            let w = omega(mode);
            let gain = speed * shake / (w * w - shake * shake);
            let [mass, at_tip] = effective(mode);
            tip += at_tip * gain * ((shake * t).sin() - shake / w * (w * t).sin());
            // -L qddot: L^2 is the effective mass.
            force -= mass * 4.0 * gain * (-shake * shake * (shake * t).sin() + shake * w * (w * t).sin());
        }
        [tip, force]
    };
    for (method, modes) in FULL.map(|m| (m, 0)).into_iter().chain([(Method::Rom, 10)]) {
        let (mut worst, mut largest) = ([0.0_f64; 2], [0.0_f64; 2]);
        march(&clamped, method, modes, 1e-3, 700, |out| {
            let expected = expected(out.time);
            let reaction = out.reaction.unwrap();
            let found = [out.dr_a[1].z, reaction.total()[2]];
            for k in 0..2 {
                worst[k] = worst[k].max((found[k] - expected[k]).abs());
                largest[k] = largest[k].max(expected[k].abs());
            }
            assert!((reaction.inertia[2] - 4.0 * speed * shake * (shake * out.time).sin()).abs() < 1e-9);
        });
        // Period error of Newmark, (w dt)^2/12 of w t: 2e-3 rad for the second mode; in the force also the modes left out.
        assert!(worst[0] < 5e-3 * largest[0], "{method}: {worst:?} of {largest:?}");
        assert!(worst[1] < 4e-2 * largest[1], "{method}: {worst:?} of {largest:?}");
    }
}

/// A free structure whose reference is held is the clamped one, to the last step; with free-free modes it comes close.
#[test]
fn a_held_free_structure_is_the_clamped_one() {
    let case = |motion: &str| {
        format!(
            "[load_cases.pluck]\nt_end = 1\ndt = 0.002\n{motion}\nloads = [{{ point = \"tip\", frame = \"dead\", force = [0, 0.3, 0.5], time = {{ shape = \"one-minus-cosine\", duration = 0.4 }} }}]"
        )
    };
    let (held, clamped) = (beam("free", &case("motion = {}")), beam("clamped", &case("")));
    let run = |structure: &Structure, method, modes| {
        let mut out = Vec::new();
        march(structure, method, modes, 2e-3, 150, |o| {
            out.push((o.dr_a[1], nalgebra_six(&o.reaction.unwrap().total())));
        });
        out
    };
    for method in FULL {
        for ((a, ra), (b, rb)) in run(&held, method, 0).iter().zip(run(&clamped, method, 0)) {
            assert!((a - b).norm() < 1e-12 && (ra - rb).norm() < 1e-9);
        }
    }
    let exact = run(&clamped, Method::Linear, 0);
    let error = |structure: &Structure, modes: usize| {
        let found = run(structure, Method::Rom, modes);
        let worst = found.iter().zip(&exact).map(|(a, b)| (a.0 - b.0).norm()).fold(0.0, f64::max);
        worst / exact.iter().map(|x| x.0.norm()).fold(0.0, f64::max)
    };
    let (by_clamped, by_free) = (error(&clamped, 6), error(&held, 6));
    assert!(by_clamped < 0.02 && by_free < 0.1 && by_free > 2.0 * by_clamped, "{by_clamped} {by_free}");
}

fn nalgebra_six(x: &[f64; 6]) -> nalgebra::Vector6<f64> {
    nalgebra::Vector6::from(*x)
}

/// Velocities, accelerations, in A or in G: four ways to say the same motion of the base, here a turn about a tilted axis with a
/// swing, in every method.
#[test]
fn velocities_and_accelerations_say_the_same() {
    let sine = |a: f64, phase: &str| {
        format!("{{ shape = \"sine\", amplitude = {a}, omega = 4, phase = \"{phase}\" }}")
    };
    let (v, a) = (sine(0.3, "0"), sine(1.2, "pi/2"));
    let cases = [
        format!("motion = {{ velocity = {{ y = {v} }}, angular_velocity = {{ z = {v}, x = 0.2 }} }}"),
        format!(
            "initial = {{ angular_velocity = [0.2, 0, 0] }}\nmotion = {{ velocity = {{ y = {v} }}, angular_acceleration = {{ z = {a} }} }}"
        ),
    ];
    let text = |motion: &str| format!("[load_cases.move]\nt_end = 1\ndt = 0.002\n{motion}");
    for (method, modes) in [(Method::Nonlinear, 0), (Method::Linear, 0), (Method::Rom, 6)] {
        let ends: Vec<_> = cases
            .iter()
            .map(|motion| {
                let (mut end, mut frame) = (nalgebra::Vector3::zeros(), None);
                march(&beam("clamped", &text(motion)), method, modes, 2e-3, 250, |out| {
                    end = out.dr_a[1];
                    frame = Some(out.frame);
                });
                (end, frame.unwrap())
            })
            .collect();
        let [(a, fa), (b, fb)] = &ends[..] else { unreachable!("two") };
        assert!((a - b).norm() < 1e-9 && (fa.position - fb.position).norm() < 1e-10, "{method}: {a} {b}");
        assert!(fa.rotation.angle_to(&fb.rotation) < 1e-9 && a.norm() > 1e-4);
    }
}

/// Shaken in a turned attitude, with components in G, the beam does what it does upright with the components turned.
#[test]
fn a_turned_problem_is_the_same_problem() {
    let shape = "{ shape = \"sine\", amplitude = 0.5, omega = 9 }";
    let upright = format!(
        "[load_cases.a]\nt_end = 1\ndt = 0.002\nmotion = {{ acceleration = {{ z = {shape} }} }}\ninitial = {{ velocity = [0, 0.1, 0], position = [1, 2, 3] }}"
    );
    // Rolled by 90 degrees, y of A is z of G and z of A is -y of G.
    let turned = "[load_cases.a]\nt_end = 1\ndt = 0.002\nmotion = { axes = \"inertial\", acceleration = { y = { shape = \"sine\", amplitude = -0.5, omega = 9 } } }\ninitial = { attitude = { roll = \"pi/2\" }, axes = \"inertial\", velocity = [0, 0, 0.1], position = [0, 0, 0] }";
    for (method, modes) in [(Method::Nonlinear, 0), (Method::ConstantMass, 0), (Method::Rom, 6)] {
        let run = |case: &str| {
            let mut rows = Vec::new();
            march(&beam("clamped", case), method, modes, 2e-3, 200, |out| {
                let to_a = out.frame.rotation.inverse();
                rows.push((
                    out.dr_a[1],
                    to_a * out.frame.velocity,
                    out.frame.position,
                    out.reaction.unwrap().total(),
                ));
            });
            rows
        };
        let (a, b) = (run(&upright), run(turned));
        let mut moved = 0.0_f64;
        for (a, b) in a.iter().zip(&b) {
            assert!((a.0 - b.0).norm() < 1e-9 && (a.1 - b.1).norm() < 1e-12, "{method}");
            assert!((nalgebra_six(&a.3) - nalgebra_six(&b.3)).norm() < 1e-6);
            moved = moved.max(a.0.norm());
        }
        assert!(moved > 1e-4 && (a[0].2 - nalgebra::Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-15);
    }
}

/// Pulled at the tip and let go: `F L^3/(3 EI)` at first, then the first mode at its frequency, whose share of that shape is
/// `3 (bL)^-4 4` = 0.97.
#[test]
fn a_released_static_shape_vibrates_at_the_first_frequency() {
    let case = "[load_cases.pull]\nt_end = 1\ndt = 0.002\nloads = [{ point = \"tip\", frame = \"dead\", force = [0, 0, 1e-3] }]\ninitial = { shape_of = \"pull\" }\n[load_cases.release]\nt_end = 1\ndt = 0.002\ninitial = { shape_loads = [{ point = \"tip\", frame = \"dead\", force = [0, 0, 1e-3] }] }";
    let held = beam("clamped", case);
    let release =
        case.split("[load_cases.release]").nth(1).map(|rest| format!("[load_cases.release]{rest}")).unwrap();
    let release = beam("clamped", &release);
    let rest = 1e-3 * 8.0 / 30.0;
    for (method, modes) in FULL.map(|m| (m, 0)).into_iter().chain([(Method::Rom, 8)]) {
        // Under the same load the shape stays.
        march(&held, method, modes, 2e-3, 20, |out| {
            // Shear of 2e-5; the modes left out of the reduced model, 12 (bL)^-4 each from the fifth on, 5e-4.
            assert!((out.dr_a[1].z / rest - 1.0).abs() < 1e-3, "{method}: {}", out.dr_a[1].z);
        });
        let period = 2.0 * PI / omega(0);
        let steps = 500;
        let mut rows = Vec::new();
        march(&release, method, modes, period / steps as f64, steps, |out| rows.push(out.dr_a[1].z));
        assert!((rows[0] / rest - 1.0).abs() < 1e-3, "{method}");
        // After half a period and a whole one; the second mode has 2.5 % of the shape.
        assert!(
            (rows[steps / 2] / rest + 1.0).abs() < 0.06 && (rows[steps] / rest - 1.0).abs() < 0.06,
            "{method}"
        );
        let first = |k: usize| (2.0 * PI * k as f64 / steps as f64).cos();
        let projection = rows.iter().enumerate().map(|(k, z)| z * first(k)).sum::<f64>() * 2.0 / steps as f64;
        assert!(
            (projection / rest - 12.0 / WAVES[0].0.powi(4)).abs() < 0.02,
            "{method}: {}",
            projection / rest
        );
    }
}

/// Under a load per length, `w L^4/(8 EI)`, with or without a force at the tip besides: the shape stays under the loads it is the shape of.
#[test]
fn a_static_shape_may_be_that_of_distributed_loads() {
    for frame in ["dead", "body", "follower"] {
        let spread = format!("[{{ member = \"beam\", frame = \"{frame}\", force = [0, 0, 1e-3] }}]");
        let pull = "[{ point = \"tip\", frame = \"dead\", force = [0, 0, 1e-3] }]";
        let start = "t_end = 1\ndt = 0.002\n";
        let uniform =
            format!("[load_cases.a]\n{start}distributed_loads = {spread}\ninitial = {{ shape_of = \"a\" }}");
        let both = format!(
            "[load_cases.b]\n{start}loads = {pull}\ndistributed_loads = {spread}\n\
             initial = {{ shape_loads = {pull}, shape_distributed_loads = {spread} }}"
        );
        let bent = 1e-3 * 16.0 / 80.0;
        for (case, rest) in [(uniform, bent), (both, bent + 1e-3 * 8.0 / 30.0)] {
            let structure = beam("clamped", &case);
            for (method, modes) in FULL.map(|m| (m, 0)).into_iter().chain([(Method::Rom, 8)]) {
                march(&structure, method, modes, 2e-3, 20, |out| {
                    // Shear of 2e-5; modes left out of the reduced model, 5e-4 of the response to a force at the tip.
                    assert!(
                        (out.dr_a[1].z / rest - 1.0).abs() < 1e-3,
                        "{method}, {frame}: {}",
                        out.dr_a[1].z
                    );
                });
            }
        }
    }
}

/// Thrown and spinning about its axis of symmetry, an unloaded free body keeps both velocities; amplitudes and rates of a mode are
/// the same shape in every method.
#[test]
fn starts_agree_between_the_methods() {
    let case = "[load_cases.throw]\nt_end = 1\ndt = 0.002\ninitial = { velocity = [3, 0, 1], axes = \"inertial\", attitude = { yaw = 0.3 }, amplitudes = [0, 1e-4], rates = [2e-3, 0, 1e-3] }";
    let structure = beam("free", case);
    let mut first = Vec::new();
    for (method, modes) in FULL.map(|m| (m, 0)).into_iter().chain([(Method::Rom, 6), (Method::MeanAxes, 6)]) {
        let mut at_start = None;
        let mut momenta = Vec::new();
        march(&structure, method, modes, 2e-3, 50, |out| {
            at_start.get_or_insert_with(|| out.clone());
            momenta.push(out.totals.linear_momentum);
        });
        let start = at_start.unwrap();
        assert!((start.frame.velocity - nalgebra::Vector3::new(3.0, 0.0, 1.0)).norm() < 1e-12, "{method}");
        let drift = momenta.iter().map(|p| (p - momenta[0]).norm()).fold(0.0, f64::max);
        assert!(drift < 1e-6 * momenta[0].norm(), "{method}: {drift}");
        first.push((method, start.dr_a[1], start.motion[1].v_g, start.totals.linear_momentum));
    }
    let (_, dr, v, p) = &first[0];
    assert!(dr.norm() > 1e-5);
    for (method, other, velocity, momentum) in &first {
        assert!((dr - other).norm() < 1e-7 * dr.norm(), "{method}: {dr} {other}");
        let v: nalgebra::Vector3<f64> = (*v).into();
        assert!(
            (v - nalgebra::Vector3::from(*velocity)).norm() < 1e-6 && (p - momentum).norm() < 1e-6 * p.norm(),
            "{method}"
        );
    }
}
