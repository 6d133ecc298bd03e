//! Section forces at places along the members: both ways to them against each other, against statics and against the nonlinear method.

use std::path::Path;
use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3};
use rom_generator::input::Structure;
use rom_generator::reference::method::{Method, Prepared, RunSettings, start_reduced};
use rom_generator::{BuildOptions, Elastic, Inertia, ModeSelection, build::build};
use rom_runtime::{Integrator, LoadCase, Model, SectionForces, Settings, Simulation, State};

/// A wing with a kink, twist of its inertia, damped unevenly, in a field of gravity, about a loaded equilibrium; and its places.
const WING: &str = r#"
[structure]
name = "wing"
reference = "root"
element_nodes = NODES
support = "SUPPORT"

[sections.spar]
shape = "constants"
EA = 1e4
GAy = 1e4
GAz = 1e4
GJ = 40
EIy = 60
EIz = 900
rhoA = 0.5
rhoJ = [0.02, 0.002, 0.018]

[sections.rod]
shape = "constants"
EA = 2e4
GAy = 1e4
GAz = 1e4
GJ = 60
EIy = 90
EIz = 300
rhoA = 0.3
rhoJ = [0.01, 0.002, 0.008]
retardation_time = 0.002

[points]
root = [0, 0, 0]
tip = [0.3, 2, 0.4]
other = [0, -1.5, 0]
pod = { linked_to = "tip", offset = [0.2, 0.1, -0.3] }

[[members]]
name = "left"
path = ["root", "tip"]
section = "spar"
elements = 2
local_y = [-1, 0, 0]

[[members]]
name = "right"
path = ["root", "other"]
section = "rod"
elements = 2
local_y = [-1, 0, 0]

[[masses]]
point = "root"
mass = 4
inertia = [0.2, 0.5, 0.6]

[[masses]]
point = "pod"
mass = 0.3

[damping]
modal_ratio = [0.02, 0.01, 0.03]
rayleigh = { mass = 0.1, stiffness = 0.001 }

[gravity]
acceleration = [0, 0, -9.81]

[equilibrium]
unbalanced = "warn"
loads = [{ point = "tip", frame = "follower", force = [0, 0, 12] }]

[[equilibrium.distributed_loads]]
member = "right"
frame = "follower"
force = [0, 0, -9]
moment = [0.5, 0, 0]

[internal_loads.inboard]
member = "left"
fractions = [0, 0.3, 1]

[internal_loads.right]
member = "right"
count = 1

[load_cases.mixed]
t_end = 1
dt = 0.01
loads = [
  { point = "pod", frame = "dead", force = [3, -2, 5], moment = [0.3, 0.2, -0.1] },
  { point = "other", frame = "body", force = [1, 2, -4] },
  { point = "tip", frame = "follower", moment = [0.4, 0.1, 0.2] },
]

[[load_cases.mixed.distributed_loads]]
member = "left"
frame = "dead"
force = [1, 0.5, 3]
along = "1 - fraction"

[[load_cases.mixed.distributed_loads]]
member = "right"
frame = "body"
force = [0.5, 1, 2]
"#;

fn wing(nodes: &str, support: &str) -> Structure {
    let text = WING.replace("NODES", nodes).replace("SUPPORT", support);
    Structure::from_toml_str(&text, "wing.toml", &[]).unwrap_or_else(|e| panic!("{e}"))
}

fn reduced(structure: &Structure, modes: usize) -> Arc<Model> {
    let options =
        BuildOptions { modes: ModeSelection::Count(modes), all_nodes: false, ..BuildOptions::default() };
    Arc::new(Model::new(build(structure, &options, &mut |_| ()).unwrap_or_else(|e| panic!("{e}"))).unwrap())
}

/// Numbers between -1 and 1 that look random.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(seed + 1);
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Amplitudes of tenths of the span in the first modes, and all rates and velocities at work.
fn random_state(model: &Model, next: &mut impl FnMut() -> f64) -> State {
    let mut state = State::at_rest(model);
    let omega = &model.data().modes.omega;
    for (i, omega) in omega.iter().enumerate() {
        let first = model.data().modes.omega[0];
        state.q[i] = 0.2 * next() * (first / omega).powi(2);
        state.q_dot[i] = 2.0 * next() * first / omega;
    }
    if !model.is_clamped() {
        state.beta_star = std::array::from_fn(|_| 2.0 * next());
        let attitude = UnitQuaternion::from_scaled_axis(Vector3::new(next(), next(), next()) * 2.0);
        state.attitude = [attitude.w, attitude.i, attitude.j, attitude.k];
    }
    state
}

/// Section forces in a state under a load case.
fn sections(model: &Arc<Model>, case: &LoadCase, state: &State) -> Vec<SectionForces> {
    let loads = model.prepare(case).unwrap();
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    simulation.restore(state).unwrap();
    simulation.find_section_forces(&loads).unwrap().to_vec()
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |worst, (a, b)| worst.max((a - b).abs()))
}

/// With all modes of the finite elements the strains of the modes say all there is to say: summation of forces, from loads of all kinds,
/// weight, inertia with all its gyroscopic terms, and dampings, has to agree in any state.
#[test]
fn with_all_modes_both_ways_agree_in_any_motion() {
    for (nodes, support, modes) in [("2", "free", 24), ("3", "free", 48), ("2", "clamped", 24)] {
        let structure = wing(nodes, support);
        let model = reduced(&structure, modes);
        let case = model.load_case("mixed").unwrap().clone();
        let mut next = noise(modes as u64);
        for _ in 0..3 {
            let state = random_state(&model, &mut next);
            let found = sections(&model, &case, &state);
            assert_eq!(found.len(), 4);
            let scale = found.iter().flat_map(|s| s.by_modes).fold(0.0_f64, |worst, x| worst.max(x.abs()));
            assert!(scale > 10.0, "nothing acts: {scale}");
            for (k, SectionForces { best, by_modes }) in found.iter().enumerate() {
                // The stiffest modes, at 1e5 times the square of the first frequency, lose as many digits.
                let error = difference(best, by_modes);
                assert!(error < 1e-7 * scale, "{nodes} {support} {k}: {best:?} {by_modes:?}");
            }
        }
    }
}

/// A beam that a force at its end accelerates: shear and moment are those of the rigid beam, whose inertia is linear along it.
#[test]
fn a_beam_pushed_at_its_end() {
    let (length, push) = (10.0, 100.0);
    for nodes in [2, 3] {
        let text = format!(
            r#"
[structure]
name = "beam"
reference = "middle"
element_nodes = {nodes}
[sections.bar]
shape = "constants"
EA = 1e6
GAy = 1e6
GAz = 1e6
GJ = 1e3
EIy = 1e3
EIz = 1e3
rhoA = 2
rhoJ = [2e-6, 1e-6, 1e-6]
[points]
start = [-5, 0, 0]
middle = [0, 0, 0]
end = [5, 0, 0]
[[members]]
name = "beam"
path = ["start", "middle", "end"]
section = "bar"
elements = 40
local_y = [0, 1, 0]
[internal_loads.beam]
member = "beam"
fractions = [0.1, 0.3, 0.45, 0.61, 0.9]
[load_cases.push]
t_end = 1
dt = 0.01
loads = [{{ point = "end", frame = "body", force = [20, 0, {push}] }}]
"#
        );
        let structure = Structure::from_toml_str(&text, "beam.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
        let model = Arc::new(reduced(&structure, 4).with_method(rom_runtime::Method::Rigid).unwrap());
        let found = sections(&model, model.load_case("push").unwrap(), &State::at_rest(&model));
        for (cut, SectionForces { best, .. }) in model.data().cuts.iter().zip(&found) {
            // From the middle; acceleration (F/m)(1 + 6 x / L), that of the force's direction.
            let x = (cut.fraction - 0.5) * length;
            let shear = push / length * (x + 5.0 + 3.0 / length * (x * x - 25.0));
            // About y by the inertia of the part before the section: the integral of (x - x') mu a over it.
            let first = (x + 5.0).powi(2) / 2.0;
            let second = x * (x * x - 25.0) / 2.0 - (x * x * x + 125.0) / 3.0;
            let moment = push / length * (first + 6.0 / length * second);
            let expected = [20.0 * cut.fraction, 0.0, shear, 0.0, moment, 0.0];
            // Elements are a fortieth of the length, h: their shear is its mean over them and lies on a chord between their middles,
            // (1/24 + 1/8) h^2 of the second derivative 6 F/L^2, 0.0625 N; moments twice that of up to 34 N/m, 0.53 N m.
            let tolerance = [1e-9, 1e-9, 0.063, 1e-9, 0.54, 1e-9];
            for k in 0..6 {
                let error = (best[k] - expected[k]).abs();
                assert!(error < tolerance[k], "{nodes}, {}: {best:?}, expected {expected:?}", cut.fraction);
            }
        }
    }
}

fn published(name: &str, sets: &[(&str, &str)], places: &str) -> Structure {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models").join(name);
    let text = std::fs::read_to_string(path).unwrap() + places;
    let sets: Vec<_> = sets.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
    Structure::from_toml_str(&text, name, &sets).unwrap_or_else(|e| panic!("{e}"))
}

/// Largest errors of the section forces against a finite-element method over a run, over the largest of the quantity: forces and moments
/// of every place by both ways, (best, by the modes).
fn errors(
    structure: &Structure,
    reference: Method,
    case: &str,
    modes: usize,
    t_end: f64,
) -> Vec<[[f64; 2]; 2]> {
    let prepared = Prepared::about(
        structure.mesh(),
        rom_generator::equilibrium::trim::of_mesh(&structure.mesh()).unwrap(),
    );
    let case = prepared.mesh.load_cases.iter().find(|c| c.name == case).unwrap().clone();
    let model = reduced(structure, modes);
    let dt = case.dt;
    let settings =
        RunSettings { dt, integrator: Integrator::Newmark, numerical_damping: case.numerical_damping };
    let mut exact = prepared.start(reference, &case, &settings).unwrap();
    let mut rom = start_reduced(&model, Method::Rom, &case, &settings).unwrap();
    let n = prepared.mesh.cuts.len();
    let (mut worst, mut size) = (vec![[[0.0_f64; 2]; 2]; n], vec![[0.0_f64; 2]; n]);
    for _ in 0..(t_end / dt).round() as usize {
        exact.step().unwrap();
        rom.step().unwrap();
        let (expected, found) = (exact.output().sections, rom.output().sections);
        for (k, (e, f)) in expected.iter().zip(&found).enumerate() {
            for part in 0..2 {
                let of = |s: &[f64; 6]| Vector3::from_column_slice(&s[3 * part..3 * part + 3]);
                size[k][part] = size[k][part].max(of(&e.best).norm());
                for (way, s) in [&f.best, &f.by_modes].into_iter().enumerate() {
                    worst[k][part][way] = worst[k][part][way].max((of(s) - of(&e.best)).norm());
                }
            }
        }
    }
    let relative = |(worst, size): (&[[f64; 2]; 2], &[f64; 2])| {
        std::array::from_fn(|part| worst[part].map(|error| error / size[part]))
    };
    worst.iter().zip(&size).map(relative).collect()
}

/// The frame under couples: summation of forces with three modes is closer to the nonlinear method than their strains are.
#[test]
fn the_frame_against_the_nonlinear_method() {
    let places = r#"
[internal_loads.arm]
member = "right arm"
fractions = [0]
[internal_loads.beam]
member = "right half beam"
fractions = [0.5]
"#;
    let sets = [("sigma", "10"), ("elements", "60")];
    let structure = published("fmb.toml", &sets, places);
    let few = errors(&structure, Method::Nonlinear, "lc2", 3, 2.0);
    let many = errors(&structure, Method::Nonlinear, "lc2", 10, 2.0);
    println!("frame, three modes: {few:.4?}, ten: {many:.4?}");
    for (few, many) in few.iter().flatten().zip(many.iter().flatten()) {
        assert!(few[0] < 0.05 && few[0] < 0.05 * few[1], "{few:?}");
        assert!(many[0] < 0.04 && many[0] < 0.3 * many[1], "{many:?}");
    }
}

/// Closed loops: the fields are those of the whole structure, so that statics of the loops is in them.
#[test]
fn the_joined_wing_against_the_linear_method() {
    let places = r#"
[internal_loads.front]
member = "FRONT"
fractions = [0.2]
"#;
    let structure = published("joined_wing.toml", &[], "");
    let member =
        structure.mesh().members.iter().map(|m| m.name.clone()).find(|n| n.contains("front")).unwrap();
    let structure = published("joined_wing.toml", &[], &places.replace("FRONT", &member));
    let few = errors(&structure, Method::Linear, "joints", 6, 0.5);
    let many = errors(&structure, Method::Linear, "joints", 15, 0.5);
    println!("joined wing, six modes: {few:.4?}, fifteen: {many:.4?}");
    for (few, many) in few.iter().flatten().zip(many.iter().flatten()) {
        assert!(few[0] < 0.1 && few[0] < 0.2 * few[1], "{few:?}");
        assert!(many[0] < 0.03 && many[0] < 0.5 * many[1], "{many:?}");
    }
}

/// In trimmed flight all ways tell the section forces of the equilibrium.
#[test]
fn trimmed_flight_tells_those_of_the_equilibrium() {
    let places = "\n[internal_loads.wing]\nmember = \"wing\"\nfractions = [0.1, 0.3, 0.49, 0.51, 0.7]\n";
    let structure = published("hale.toml", &[], places);
    let mesh = structure.mesh();
    let trim = rom_generator::equilibrium::trim::of_mesh(&mesh).unwrap();
    let prepared = Prepared::about(mesh, trim);
    let level = LoadCase { loads: vec![], distributed: vec![], ..prepared.mesh.load_cases[0].clone() };
    let settings = RunSettings { dt: 0.01, integrator: Integrator::Newmark, numerical_damping: 0.0 };
    let exact = prepared.start(Method::Nonlinear, &level, &settings).unwrap().output().sections;
    let scale = exact.iter().flat_map(|s| s.best).fold(0.0_f64, |worst, x| worst.max(x.abs()));
    assert!(scale > 500.0, "bending of a wing that carries 40 kg: {scale}");
    let model = reduced(&structure, 6);
    for method in [Method::ConstantMass, Method::Linear, Method::Rom, Method::MeanAxes, Method::Rigid] {
        let output = if method.is_reduced() {
            start_reduced(&model, method, &level, &settings).unwrap().output()
        } else {
            prepared.start(method, &level, &settings).unwrap().output()
        };
        for (e, f) in exact.iter().zip(&output.sections) {
            // Round-off of the balance, and of y = K^-1 b for the softest of shapes.
            let found = difference(&e.best, &f.best).max(difference(&e.best, &f.by_modes));
            assert!(found < 1e-7 * scale, "{method}: {e:?} {f:?}");
        }
    }
    // Consistent inertia about the loaded trim: its modes tell them.
    let options = BuildOptions {
        modes: ModeSelection::Count(4),
        all_nodes: false,
        inertia: Inertia::Consistent,
        elastic: Elastic::Geometric,
        ..BuildOptions::default()
    };
    let model = Arc::new(Model::new(build(&structure, &options, &mut |_| ()).unwrap()).unwrap());
    let found = start_reduced(&model, Method::Rom, &level, &settings).unwrap().output().sections;
    for (e, f) in exact.iter().zip(&found) {
        assert!(difference(&e.best, &f.best) < 1e-7 * scale && f.best == f.by_modes, "{e:?} {f:?}");
    }
}
