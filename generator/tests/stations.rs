//! Blocks of stations of structures: their places, and that forces on them do the work of the generalised loads in every kind of model.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rom_generator::input::Structure;
use rom_generator::{BuildOptions, Elastic, Inertia, ModeSelection, build::build};

use rom_runtime::{
    BaseMotion, DistributedFrame, LoadCase, LoadSet, Loads, Method, Model, State, StateRate, StationAxes,
    Stations, Workspace,
};

/// A bent wing on a body, its stations beside the axis; `about` is added at the top of the file's tables.
const WING: &str = r#"
[structure]
name = "wing"
reference = "root"
support = "SUPPORT"

[sections.spar]
shape = "constants"
EA = 1e5
GAy = 1e5
GAz = 1e5
GJ = 40
EIy = 60
EIz = 900
rhoA = 0.5
rhoJ = [0.02, 0.002, 0.018]

[points]
root = [0, 0, 0]
kink = [0, 1.5, 0]
tip = [0.3, 3, 0.4]
other = [0, -2.5, 0]

[[members]]
name = "left"
path = ["root", "kink", "tip"]
section = "spar"
elements = 8
local_y = [-1, 0, 0]

[[members]]
name = "right"
path = ["root", "other"]
section = "spar"
elements = 5
local_y = [-1, 0, 0]

[[masses]]
point = "root"
mass = 4
inertia = [0.2, 0.5, 0.6]

[stations.wing]
members = ["right", "left"]
fractions = [0, 0.21, 0.5, 0.83, 1]
offset = [[0, 0.2, 0.01], [0, 0.1, -0.02]]

[stations.tip]
members = ["left"]
count = 2
"#;

fn structure(support: &str) -> Structure {
    let text = WING.replace("SUPPORT", support);
    Structure::from_toml_str(&text, "wing.toml", &[]).unwrap_or_else(|e| panic!("{e}"))
}

fn model(support: &str, inertia: Inertia, elastic: Elastic) -> Model {
    let options = BuildOptions {
        modes: ModeSelection::Count(6),
        all_nodes: false,
        inertia,
        elastic,
        ..BuildOptions::default()
    };
    Model::new(build(&structure(support), &options, &mut |_| ()).unwrap()).unwrap()
}

/// Numbers between -1 and 1 that look random.
fn noise(seed: usize) -> impl FnMut() -> f64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(seed as u64 + 1);
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Tips move by tenths of the span.
fn random_state(model: &Model, next: &mut impl FnMut() -> f64) -> State {
    let mut state = State::at_rest(model);
    for (q, omega) in state.q.iter_mut().zip(&model.data().modes.omega) {
        *q = 5.0 * next() / omega;
    }
    state.q_dot.iter_mut().for_each(|q| *q = next());
    state.beta_star = std::array::from_fn(|_| next());
    let attitude = UnitQuaternion::from_scaled_axis(Vector3::new(next(), next(), next()) * 2.0);
    state.attitude = [attitude.w, attitude.i, attitude.j, attitude.k];
    state.position = std::array::from_fn(|_| 10.0 * next());
    state
}

fn acceleration(model: &Model, state: &State, loads: &impl Loads) -> Vec<f64> {
    let mut rate = StateRate::new(model);
    model.derivatives(state, loads, &mut Workspace::new(model), &mut rate).unwrap();
    rate.u_dot
}

/// Kinetic energy at the shape of `state` with other velocities: the mass matrix of any kind of model.
fn kinetic(model: &Model, state: &State, u: &[f64]) -> f64 {
    let mut at = state.clone();
    let (q_dot, beta) = u.split_at(model.n_modes());
    at.q_dot.copy_from_slice(q_dot);
    at.beta_star.copy_from_slice(beta);
    model.ledger(&at).kinetic_energy
}

const FRAMES: [(DistributedFrame, StationAxes); 3] = [
    (DistributedFrame::Dead, StationAxes::Inertial),
    (DistributedFrame::Body, StationAxes::Body),
    (DistributedFrame::Follower, StationAxes::Section),
];

/// `u^t M (u_dot with the loads - u_dot without)` against the power of the forces and moments in the velocities of the stations.
fn works(model: &Model, case: Option<&LoadCase>, held: bool) {
    let mut next = noise(model.n_modes() + 7);
    let block = model.station_block("wing").unwrap();
    let mut stations = Stations::new(model, block).unwrap();
    let n = stations.len();
    for (frame, axes) in FRAMES.into_iter().cycle().take(9) {
        let mut state = random_state(model, &mut next);
        if held {
            // A does not move: what the modes move it by is taken back.
            state.beta_star = [0.0; 6];
            let moved = model.velocity(&state);
            state.beta_star = moved.map(|x| -x);
        }
        let wrenches: Vec<f64> = (0..6 * n).map(|_| next()).collect();
        let mut set = LoadSet::with_stations(model, &[], &[block], case).unwrap();
        let without = acceleration(model, &state, &set);
        assert!(set.set_stations(0, frame, &wrenches));
        let with = acceleration(model, &state, &set);
        let motion = stations.read(model, &state, axes).unwrap();
        let rates = motion.velocity.as_chunks::<3>().0.iter().zip(motion.angular_velocity.as_chunks::<3>().0);
        let each = wrenches.as_chunks::<6>().0.iter().zip(rates);
        let power = each.map(|(f, (v, w))| f.iter().zip(v.iter().chain(w)).map(|(f, v)| f * v).sum::<f64>());
        let power: f64 = power.sum();
        let u: Vec<f64> = state.q_dot.iter().chain(&state.beta_star).copied().collect();
        let jump: Vec<f64> = with.iter().zip(&without).map(|(a, b)| a - b).collect();
        let both: Vec<f64> = u.iter().zip(&jump).map(|(a, b)| a + b).collect();
        let parts = [both, u, jump].map(|x| kinetic(model, &state, &x));
        let work = parts[0] - parts[1] - parts[2];
        // Differences of energies lose the digits of their size, and those of what else accelerates the body.
        let lost = without.iter().chain(&with).fold(1.0_f64, |worst, x| worst.max(x.abs()));
        let scale = parts[0] + parts[1] + parts[2] + lost * model.data().rigid.mass;
        assert!((power - work).abs() < 1e-12 * scale, "{frame:?}: {power} {work}, of {scale}");
        assert!(power.abs() > 1e-6 * scale, "nothing was compared: {power} of {scale}");
    }
}

#[test]
fn power_on_stations_is_that_of_the_generalised_loads_in_every_kind_of_model() {
    let free = model("free", Inertia::Constant, Elastic::Linear);
    works(&free, None, false);
    works(&free.with_method(Method::MeanAxes).unwrap(), None, false);
    works(&free.with_method(Method::Rigid).unwrap(), None, false);
    works(&model("free", Inertia::Consistent, Elastic::Linear), None, false);
    works(&model("free", Inertia::Consistent, Elastic::Geometric), None, false);
}

#[test]
fn power_on_stations_is_that_of_the_generalised_loads_where_frame_a_is_held() {
    let mut case = LoadCase { dt: 0.01, motion: Some(BaseMotion::default()), ..LoadCase::empty("held") };
    works(&model("free", Inertia::Constant, Elastic::Linear), Some(&case), true);
    case.name = "clamped".into();
    works(&model("clamped", Inertia::Constant, Elastic::Linear), Some(&case), true);
}

/// Velocities are the derivatives of positions and attitudes along the motion, on the curved manifold too.
#[test]
fn velocities_are_the_rates_of_positions() {
    for (inertia, elastic) in
        [(Inertia::Constant, Elastic::Linear), (Inertia::Consistent, Elastic::Geometric)]
    {
        let model = model("free", inertia, elastic);
        let mut next = noise(3);
        let state = random_state(&model, &mut next);
        let mut rate = StateRate::new(&model);
        model.derivatives(&state, &model.no_loads(), &mut Workspace::new(&model), &mut rate).unwrap();
        let h = 1e-5;
        let at = |sign: f64| {
            let mut moved = state.clone();
            for (q, q_dot) in moved.q.iter_mut().zip(&state.q_dot) {
                *q += sign * h * q_dot;
            }
            let velocity = model.velocity(&state);
            let [w, x, y, z] = state.attitude;
            let turn = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
            let v = turn * Vector3::new(velocity[0], velocity[1], velocity[2]);
            let spin = Vector3::new(velocity[3], velocity[4], velocity[5]);
            let turned = turn * UnitQuaternion::from_scaled_axis(spin * (sign * h));
            moved.attitude = [turned.w, turned.i, turned.j, turned.k];
            for k in 0..3 {
                moved.position[k] += sign * h * v[k];
            }
            let mut stations = Stations::new(&model, 0).unwrap();
            stations.read(&model, &moved, StationAxes::Inertial).unwrap().clone()
        };
        let (before, after) = (at(-1.0), at(1.0));
        let now =
            Stations::new(&model, 0).unwrap().read(&model, &state, StationAxes::Inertial).unwrap().clone();
        for (k, v) in now.velocity.iter().enumerate() {
            // Central differences: h^2 times third derivatives of order 100.
            let found = (after.position[k] - before.position[k]) / (2.0 * h);
            assert!((found - v).abs() < 1e-7, "{k}: {found} {v}");
        }
        for n in 0..now.attitude.len() / 4 {
            let at = |list: &[f64]| {
                let [w, x, y, z] = list.as_chunks::<4>().0[n];
                UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
            };
            let spin = (at(&after.attitude) * at(&before.attitude).inverse()).scaled_axis() / (2.0 * h);
            let expected = Vector3::from(now.angular_velocity.as_chunks::<3>().0[n]);
            assert!((spin - expected).norm() < 1e-7, "{n}: {spin} {expected}");
        }
    }
}

#[test]
fn stations_are_where_the_file_says() {
    let model = model("free", Inertia::Constant, Elastic::Linear);
    let block = &model.data().stations[0];
    assert_eq!(block.members, [("right".to_owned(), 5), ("left".to_owned(), 5)]);
    let mut stations = Stations::new(&model, 0).unwrap();
    let at_rest = State::at_rest(&model);
    let motion = stations.read(&model, &at_rest, StationAxes::Body).unwrap();
    // The right wing goes along -y of the file with its local y along -x: local z is x cross y, downwards.
    for (n, fraction) in [0.0, 0.21, 0.5, 0.83, 1.0].into_iter().enumerate() {
        let (y, z) = (0.2 - 0.1 * fraction, 0.01 - 0.03 * fraction);
        let expected = Vector3::new(-y, -2.5 * fraction, -z);
        let found = Vector3::from(motion.position.as_chunks::<3>().0[n]);
        assert!((found - expected).norm() < 1e-12, "{found} {expected}");
    }
    // In the middles of halves of the left one, which has a kink: lengths 1.5 and sqrt(0.09 + 2.25 + 0.16) m.
    let length = 1.5 + 2.5_f64.sqrt();
    let mut tip = Stations::new(&model, 1).unwrap();
    let motion = tip.read(&model, &at_rest, StationAxes::Body).unwrap();
    let found = Vector3::from(motion.position.as_chunks::<3>().0[1]);
    let beyond = (0.75 * length - 1.5) / 2.5_f64.sqrt();
    assert!((found - Vector3::new(0.3 * beyond, 1.5 + 1.5 * beyond, 0.4 * beyond)).norm() < 1e-12);
}

#[test]
fn mistakes_in_blocks_are_told_where_they_are() {
    let wrong = [
        ("members = [\"right\", \"left\"]", "members = [\"wright\"]", "there is no member `wright`"),
        ("count = 2", "", "either `count` or `fractions`"),
        ("count = 2", "count = 2\nfractions = [0.5]", "either `count` or `fractions`"),
        ("0.83, 1]", "0.83, 1.2]", "expected a number from 0 to 1"),
        ("0.21, 0.5", "0.21, 0.2", "expected a larger one"),
        ("count = 2", "count = 200000", "at most 100000"),
        ("members = [\"left\"]", "members = []", "expected one or more"),
        ("offset = [[0, 0.2, 0.01], [0, 0.1, -0.02]]", "offset = [[0, 0.2], [0, 0.1]]", "offset"),
    ];
    for (from, to, words) in wrong {
        let text = WING.replace("SUPPORT", "free").replacen(from, to, 1);
        assert!(text != WING.replace("SUPPORT", "free"), "{from}");
        let error = Structure::from_toml_str(&text, "wing.toml", &[]).unwrap_err().to_string();
        assert!(error.contains("wing.toml:") && error.contains(words), "{from}: {error}");
    }
}
