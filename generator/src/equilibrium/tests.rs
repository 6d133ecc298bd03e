//! The static equations against differences, and their solutions against statics.

use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};
use rom_runtime::loads::{Load, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;

use super::balance::Balance;
use super::{EquilibriumError, EquilibriumSettings, LoadPath, Stability, WhenUnstable, solve};
use crate::assembly::BlockMatrix;
use crate::carrier::Carrier;
use crate::configuration::Configuration;
use crate::element::internal_force::split;
use crate::element::tests::Random;
use crate::math::so3::exp_quaternion;
use crate::mesh::{Mesh, Place, Point};
use crate::test_structures::{case, crooked, fmb};

pub(super) fn load(point: u32, frame: LoadFrame, force: Vector3<f64>, moment: Vector3<f64>) -> Load {
    let time = TimeFunction::Constant { value: 1.0 };
    Load { point, frame, force: force.into(), moment: moment.into(), time }
}

/// The crooked tree with a point off its node, and a load of every kind.
fn everything(n_nodes: usize, size: f64) -> (Mesh, LoadCase) {
    let mut mesh = crooked(n_nodes);
    let offset = Vector3::new(0.2, -0.3, 0.1);
    mesh.points.push(Point { name: "off".into(), place: Place::Node(2), offset, sections: Vec::new() });
    // Between nodes, beside rigid links at the reference node and at a tip.
    for (name, element, x) in [("near", 3, 0.6), ("far", 6, 0.37)] {
        let place = Place::Inside { element, x };
        mesh.points.push(Point { name: name.into(), place, offset: offset * 0.7, sections: Vec::new() });
    }
    let mut random = Random::new(21);
    let mut vector = || random.vector3(size);
    let section = [[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];
    let loads = vec![
        load(1, LoadFrame::Dead, vector(), vector()),
        load(1, LoadFrame::Follower { section }, vector(), vector()),
        load(2, LoadFrame::Dead, vector(), vector()),
        load(2, LoadFrame::Body, vector(), vector()),
        load(2, LoadFrame::Follower { section }, vector(), vector()),
        load(0, LoadFrame::Body, vector(), vector()),
        load(3, LoadFrame::Body, vector() * 0.3, vector() * 0.3),
        load(3, LoadFrame::Follower { section }, vector() * 0.3, vector() * 0.3),
        load(4, LoadFrame::Dead, vector() * 0.3, vector() * 0.3),
        load(4, LoadFrame::Follower { section }, vector() * 0.3, vector() * 0.3),
        load(4, LoadFrame::Body, vector() * 0.3, vector() * 0.3),
    ];
    (mesh, case(loads))
}

fn step_node(at: &Configuration, node: usize, direction: usize, h: f64) -> Configuration {
    let mut to = at.clone();
    let mut delta = Vector6::zeros();
    delta[direction] = h;
    let (x, theta) = split(&delta);
    to.positions[node] += x;
    to.rotations[node] *= exp_quaternion(&theta);
    to
}

#[test]
fn tangent_is_the_derivative_of_the_residual_with_every_kind_of_load() {
    for n_nodes in [2, 3] {
        let (mesh, mut case) = everything(n_nodes, 30.0);
        let still = EquilibriumSettings::default();
        tangent_is_the_derivative(&mesh, &case, &still);
        let attitude = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.8, 0.5));
        let heavy = Mesh { gravity: Vector3::new(20.0, -10.0, 30.0), ..mesh.clone() };
        tangent_is_the_derivative(&heavy, &case, &EquilibriumSettings { attitude, ..still });
        case.loads.retain(|l| l.frame != LoadFrame::Dead);
        let beta = Vector6::new(0.5, -0.3, 0.8, 3.1, -2.7, 1.9);
        tangent_is_the_derivative(&mesh, &case, &EquilibriumSettings { beta, ..still });
    }
}

fn tangent_is_the_derivative(mesh: &Mesh, case: &LoadCase, settings: &EquilibriumSettings) {
    let balance = Balance::new(mesh, case, settings).unwrap();
    let mut random = Random::new(5);
    let mut at = Configuration::drawing(mesh);
    for node in (0..mesh.nodes.len()).filter(|&n| n != mesh.reference) {
        at.positions[node] += random.vector3(0.3);
        at.rotations[node] = exp_quaternion(&random.vector3(0.6));
    }
    let factor = 0.7;
    let mut k = BlockMatrix::zeros(balance.assembly.pattern.clone());
    balance.tangent(&at, factor, &mut k);
    let scale = k.amax();
    // Central differences: h^2/6 of the third derivative (some 10 K) and round-off over h, 1e-16/1e-5.
    let h = 1e-5;
    for node in (0..mesh.nodes.len()).filter(|&n| n != mesh.reference) {
        let column = balance.assembly.unknown[node].unwrap();
        for d in 0..6 {
            let plus = balance.residual(&step_node(&at, node, d, h), factor).nodal;
            let minus = balance.residual(&step_node(&at, node, d, -h), factor).nodal;
            let difference: Vec<_> = plus.iter().zip(&minus).map(|(p, m)| (p - m) / (2.0 * h)).collect();
            for (row, expected) in balance.assembly.gather(&difference).iter().enumerate() {
                let block = k.pattern.slot(row, column).map_or_else(Matrix6::zeros, |s| k.values[s]);
                let error = (block.column(d) - expected).amax();
                assert!(error < 1e-9 * scale, "row {row} column {column},{d}: {error:.1e} of {scale:.1e}");
            }
        }
    }
}

/// Resultant of the loads about the origin of A, from the load case and the deformed shape alone.
fn resultant(mesh: &Mesh, case: &LoadCase, at: &Configuration) -> (Vector3<f64>, Vector3<f64>) {
    let (mut total, mut couple) = (Vector3::zeros(), Vector3::zeros());
    for load in &case.loads {
        let point = &mesh.points[load.point as usize];
        let (r, q) = Carrier::new(mesh, point.place).at(at);
        let turn = |v: [f64; 3]| match load.frame {
            LoadFrame::Follower { section } => {
                q * Vector3::from_fn(|i, _| (0..3).map(|j| section[i][j] * v[j]).sum())
            }
            _ => Vector3::from(v),
        };
        let (f, m) = (turn(load.force), turn(load.moment));
        total += f;
        couple += m + (r + q * point.offset).cross(&f);
    }
    (total, couple)
}

#[test]
fn reaction_carries_the_resultant_of_the_loads() {
    for n_nodes in [2, 3] {
        let (mesh, case) = everything(n_nodes, 8.0);
        let found = solve(&mesh, &case, &EquilibriumSettings::default()).unwrap();
        let deflection = (found.configuration.positions[3] - mesh.nodes[3]).norm();
        assert!(deflection > 0.3, "a large deflection, not {deflection}");
        // Round-off of stiffness (about 1e3) times strain, summed over some ten elements.
        assert!(found.residual < 1e-10, "{}", found.residual);
        let (force, moment) = resultant(&mesh, &case, &found.configuration);
        assert!((found.reaction_force + force).norm() < 1e-10);
        assert!((found.reaction_moment + moment).norm() < 1e-10);
        let balance = found.self_balance();
        assert!((balance.force - force.norm() / found.force_scale).abs() < 1e-12);
        assert!(!balance.within(0.1));
    }
}

#[test]
fn self_balanced_loads_need_no_reaction() {
    let mesh = fmb(1.0, 60, 2);
    let f = Vector3::new(0.0, 0.0, 300.0);
    let case = case(vec![
        load(2, LoadFrame::Dead, f, Vector3::zeros()),
        load(4, LoadFrame::Dead, f, Vector3::zeros()),
        load(0, LoadFrame::Body, f * -2.0, Vector3::zeros()),
    ]);
    let found = solve(&mesh, &case, &EquilibriumSettings::default()).unwrap();
    assert!((found.configuration.positions[2] - mesh.nodes[2]).norm() > 1.0);
    // Mirror symmetric loads: force and moment balance at any deflection, up to round-off of EA/l times strain.
    assert!(found.self_balance().within(1e-9), "{:?}", found.self_balance());
}

#[test]
fn the_result_does_not_depend_on_the_load_steps() {
    let (mesh, case) = everything(2, 8.0);
    let with = |load_steps| {
        let settings = EquilibriumSettings { load_steps, ..Default::default() };
        solve(&mesh, &case, &settings).unwrap()
    };
    let once = with(1);
    for steps in [3, 17] {
        let other = with(steps);
        for (a, b) in once.configuration.positions.iter().zip(&other.configuration.positions) {
            assert!((a - b).norm() < 1e-12);
        }
        for (a, b) in once.configuration.rotations.iter().zip(&other.configuration.rotations) {
            assert!(a.angle_to(b) < 1e-12);
        }
    }
}

#[test]
fn newton_converges_quadratically() {
    let (mesh, case) = everything(3, 8.0);
    let mut path = LoadPath::new(&mesh, &case, &EquilibriumSettings::default()).unwrap();
    path.advance_to(0.5).unwrap();
    path.advance_to(1.0).unwrap();
    let c = path.corrections();
    let tail: Vec<f64> = c.iter().copied().filter(|&x| x < 0.1).collect();
    // Within the last three corrections the number of correct digits doubles: e' = C e^2 with one C. The last one may be round-off.
    assert!(tail.len() >= 2, "{c:?}");
    for pair in tail.windows(2) {
        assert!(pair[1] < 10.0 * pair[0] * pair[0] + 1e-14, "{c:?}");
    }
}

#[test]
fn work_of_the_loads_is_stored_as_elastic_energy() {
    let mesh = crooked(3);
    let f = Vector3::new(3.0, -5.0, 4.0);
    let case = case(vec![load(1, LoadFrame::Dead, f, Vector3::zeros())]);
    let at = |factor: f64| {
        let mut path = LoadPath::new(&mesh, &case, &EquilibriumSettings::default()).unwrap();
        path.advance_to(factor).unwrap();
        path.equilibrium()
    };
    // dU/dlambda = lambda F . du/dlambda, by differences whose error is h^2.
    let h = 1e-3;
    let (before, after) = (at(1.0 - h), at(1.0 + h));
    let work = f.dot(&(after.configuration.positions[3] - before.configuration.positions[3]));
    let stored = after.energy - before.energy;
    assert!((work - stored).abs() < 10.0 * h * h * work, "{work} {stored}");
    assert_eq!(after.stability, Stability::Stable);
}

#[test]
fn numbering_and_orientation_change_nothing() {
    let (mesh, case) = everything(2, 8.0);
    let plain = solve(&mesh, &case, &EquilibriumSettings::default()).unwrap();

    let n = mesh.nodes.len();
    let mut reversed = mesh.clone();
    reversed.nodes.reverse();
    reversed.reference = n - 1 - mesh.reference;
    for e in &mut reversed.elements {
        e.nodes = e.nodes.map(|k| n - 1 - k);
    }
    for member in &mut reversed.members {
        member.nodes.iter_mut().for_each(|k| *k = n - 1 - *k);
    }
    for p in &mut reversed.points {
        if let Place::Node(node) = &mut p.place {
            *node = n - 1 - *node;
        }
    }
    reversed.lumped.iter_mut().for_each(|l| l.node = n - 1 - l.node);
    let other = solve(&reversed, &case, &EquilibriumSettings::default()).unwrap();
    for node in 0..n {
        let difference = plain.configuration.positions[node] - other.configuration.positions[n - 1 - node];
        assert!(difference.norm() < 1e-12);
    }

    // The structure, its offsets and its dead and body loads turned together.
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -1.1, 0.7));
    let matrix = turn.to_rotation_matrix().into_inner();
    let (mut turned, mut turned_case) = (mesh.clone(), case.clone());
    turned.nodes.iter_mut().for_each(|r| *r = turn * *r);
    for e in &mut turned.elements {
        e.frames = e.frames.map(|f| matrix * f);
        e.levers = e.levers.map(|r| matrix * r);
    }
    turned.points.iter_mut().for_each(|p| p.offset = turn * p.offset);
    for load in &mut turned_case.loads {
        if let LoadFrame::Follower { section } = &mut load.frame {
            let e = matrix * nalgebra::Matrix3::from_fn(|i, j| section[i][j]);
            *section = std::array::from_fn(|i| std::array::from_fn(|j| e[(i, j)]));
        } else {
            load.force = (turn * Vector3::from(load.force)).into();
            load.moment = (turn * Vector3::from(load.moment)).into();
        }
    }
    let other = solve(&turned, &turned_case, &EquilibriumSettings::default()).unwrap();
    for node in 0..n {
        let difference = turn * plain.configuration.positions[node] - other.configuration.positions[node];
        assert!(difference.norm() < 1e-12);
    }
}

#[test]
fn loads_are_taken_at_the_time_asked_for() {
    let mesh = crooked(2);
    let mut case = case(vec![load(1, LoadFrame::Dead, Vector3::new(0.0, 2.0, 0.0), Vector3::zeros())]);
    case.loads[0].time = TimeFunction::Ramp { rate: 2.0, start: 1.0, end: 9.0 };
    let at = |time| solve(&mesh, &case, &EquilibriumSettings { time, ..Default::default() }).unwrap();
    assert!((at(2.5).reaction_force - Vector3::new(0.0, -6.0, 0.0)).norm() < 1e-10);
    assert_eq!(at(0.5).configuration.positions, mesh.nodes);
    assert_eq!(at(0.5).self_balance().force, 0.0);
}

#[test]
fn refusals_name_the_cause() {
    let (mesh, good) = everything(2, 8.0);
    let settings = EquilibriumSettings::default();
    for (bad, word) in [
        (EquilibriumSettings { load_steps: 0, ..settings }, "load steps"),
        (EquilibriumSettings { tolerance: -1.0, ..settings }, "tolerance"),
        (EquilibriumSettings { tolerance: f64::NAN, ..settings }, "tolerance"),
        (EquilibriumSettings { time: f64::INFINITY, ..settings }, "time"),
    ] {
        let error = solve(&mesh, &good, &bad).unwrap_err();
        assert!(matches!(error, EquilibriumError::Setting { .. }) && error.to_string().contains(word));
    }
    let mut infinite = good.clone();
    infinite.loads[2].force[1] = f64::INFINITY;
    let error = solve(&mesh, &infinite, &settings).unwrap_err().to_string();
    assert!(error.contains("load 3") && error.contains("`off`"), "{error}");

    // One element cannot be rolled up.
    let mesh = fmb(1.0, 6, 2);
    let m = Vector3::new(0.0, 1e6, 0.0);
    let e = mesh.elements[0].frames[0];
    let section = std::array::from_fn(|i| std::array::from_fn(|j| e[(i, j)]));
    let roll = case(vec![load(2, LoadFrame::Follower { section }, Vector3::zeros(), m)]);
    let error = solve(&mesh, &roll, &settings).unwrap_err();
    assert!(matches!(error, EquilibriumError::CoarseElement { .. }), "{error}");
    assert!(error.to_string().contains("use more elements"));
}

#[test]
fn a_column_buckles_at_eulers_load_and_can_be_followed_beyond() {
    // The right half of the main beam as a column of 10 m, pressed from its free end.
    let mesh = fmb(1.0, 60, 2);
    let press = case(vec![load(1, LoadFrame::Dead, Vector3::new(-4e3, 0.0, 0.0), Vector3::zeros())]);
    let error = solve(&mesh, &press, &EquilibriumSettings::default()).unwrap_err();
    let EquilibriumError::Buckling { stable_at, load_factor, negative_eigenvalues } = error else {
        panic!("{error}")
    };
    assert_eq!(negative_eigenvalues, 1);
    assert!(load_factor - stable_at < 2e-4 * load_factor);
    // pi^2 EI/(2 l)^2; shear and shortening change it by P/GA and P/EA, below 1e-5. Linear elements with one stiffness point see the
    // wave number k as 2/h tan(k h/2): the load is too high by (k h)^2/6, here 1e-3. The rest is the width of the enclosure.
    let k = 0.5 * std::f64::consts::PI / 10.0;
    let euler = k * k * mesh.sections[0].stiffness[(4, 4)];
    let discrete = euler * (1.0 + (0.5 * k).powi(2) / 6.0);
    assert!((4e3 * load_factor / discrete - 1.0).abs() < 2e-4, "{} {euler}", 4e3 * load_factor);

    let settings = EquilibriumSettings { when_unstable: WhenUnstable::Accept, ..Default::default() };
    let beyond = solve(&mesh, &press, &settings).unwrap();
    assert_eq!(beyond.stability, Stability::Unstable { negative_eigenvalues: 1 });
}

#[test]
fn a_column_under_a_load_that_follows_it_does_not_diverge() {
    // Beck's column loses its stability by flutter, at eight times Euler's load: statics find nothing at four times.
    let mesh = fmb(1.0, 60, 2);
    let e = mesh.points[1].sections[0].1;
    let section = std::array::from_fn(|i| std::array::from_fn(|j| e[(i, j)]));
    let follow = LoadFrame::Follower { section };
    let press = case(vec![load(1, follow, Vector3::new(-7e3, 0.0, 0.0), Vector3::zeros())]);
    let found = solve(&mesh, &press, &EquilibriumSettings::default()).unwrap();
    assert_eq!(found.stability, Stability::Following { diverged: false });
}

#[test]
fn slender_structures_take_few_iterations_whatever_the_mesh() {
    // EA/(EI/l^2) is 5e5 here and the arms end up under the middle: Newton on displacements alone takes 1100 iterations.
    let cost = |elements| {
        let mesh = fmb(1.0, elements, 2);
        let f = Vector3::new(0.0, 0.0, -4e3);
        let none = Vector3::zeros();
        let hang = case(vec![load(2, LoadFrame::Dead, f, none), load(4, LoadFrame::Dead, f, none)]);
        let found = solve(&mesh, &hang, &EquilibriumSettings::default()).unwrap();
        assert!((found.configuration.positions[2] - mesh.nodes[2]).norm() > 15.0);
        found.iterations
    };
    let (coarse, fine) = (cost(60), cost(240));
    assert!(coarse <= 50 && fine <= coarse + 5, "{coarse} {fine}");
}

#[test]
fn a_steady_turn_is_steady_in_the_nonlinear_dynamics() {
    use crate::reference::motion::Motion;
    use crate::reference::nonlinear::Nonlinear;
    use crate::reference::scheme::{Family, Scheme};
    // The frame turns about its axis of symmetry: no reaction, and every node keeps its circle.
    let mesh = fmb(1.0, 60, 2);
    let w = Vector3::new(0.0, 0.0, 1.5);
    let settings =
        EquilibriumSettings { beta: Vector6::new(0.0, 0.0, 0.0, w.x, w.y, w.z), ..Default::default() };
    let found = solve(&mesh, &case(Vec::new()), &settings).unwrap();
    assert!((found.configuration.positions[2] - mesh.nodes[2]).norm() > 0.3, "a large deflection");
    assert!(found.self_balance().within(1e-9), "{:?}", found.self_balance());
    let mut motion = Motion::at_rest(&mesh, &found.configuration);
    motion.add_rigid_velocity(mesh.reference, &Vector3::zeros(), &w);
    let scheme = Scheme::new(Family::Newmark, 0.01, 0.0);
    let run = Nonlinear::from_motion(&mesh, motion, &case(Vec::new()), scheme).unwrap();
    for (node, r) in found.configuration.positions.iter().enumerate() {
        // Accelerations are out-of-balance forces (1e-9 N) over nodal masses (some kg), or moments over inertias (1e-3 kg m^2).
        assert!((run.motion().acceleration[node] - w.cross(&w.cross(r))).norm() < 1e-6);
        assert!(run.motion().spin_rate[node].norm() < 1e-3);
    }
}

#[test]
fn a_free_body_in_self_balanced_equilibrium_stays_there() {
    use crate::reference::nonlinear::Nonlinear;
    use crate::reference::scheme::{Family, Scheme};
    let mesh = fmb(1.0, 60, 2);
    let (f, none) = (Vector3::new(0.0, 20.0, 300.0), Vector3::zeros());
    let trim = case(vec![
        load(2, LoadFrame::Dead, f, none),
        load(4, LoadFrame::Dead, f, none),
        load(0, LoadFrame::Dead, f * -2.0, none),
    ]);
    let found = solve(&mesh, &trim, &EquilibriumSettings::default()).unwrap();
    // The side loads act above the reference node and turn the body about x: balance that by a moment at the middle.
    let mut trim = trim;
    trim.loads[2].moment = found.reaction_moment.into();
    let found = solve(&mesh, &trim, &EquilibriumSettings::default()).unwrap();
    assert!(found.self_balance().within(1e-12), "{:?}", found.self_balance());
    assert!((found.configuration.positions[2] - mesh.nodes[2]).norm() > 1.0);
    let scheme = Scheme::new(Family::GeneralizedAlpha, 0.01, 0.0);
    let mut run = Nonlinear::new(&mesh, &found.configuration, &trim, scheme).unwrap();
    for _ in 0..100 {
        run.step().unwrap();
    }
    // Round-off out-of-balance of 1e-9 N on nodes of 7 kg for a second, and the same on the whole body.
    for (now, rest) in run.motion().position.iter().zip(&found.configuration.positions) {
        assert!((now - rest).norm() < 1e-9, "{}", (now - rest).norm());
    }
    assert!(run.totals().linear_momentum.norm() < 1e-8);
}

#[test]
fn dead_loads_are_refused_on_a_turning_body() {
    let (mesh, case) = everything(2, 8.0);
    let beta = Vector6::new(0.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    let turning = EquilibriumSettings { beta, ..Default::default() };
    let error = solve(&mesh, &case, &turning).unwrap_err();
    assert!(matches!(error, EquilibriumError::DeadLoadInTurn { .. }) && error.to_string().contains("`P`"));
    // Straight flight is as good as rest.
    let straight =
        EquilibriumSettings { beta: Vector6::new(9.0, 0.0, 0.0, 0.0, 0.0, 0.0), ..Default::default() };
    let (a, b) = (solve(&mesh, &case, &straight), solve(&mesh, &case, &EquilibriumSettings::default()));
    assert_eq!(a.unwrap().configuration.positions, b.unwrap().configuration.positions);
}

#[test]
fn section_forces_of_the_strains_make_the_ordinary_equations() {
    for n_nodes in [2, 3] {
        let (mesh, case) = everything(n_nodes, 8.0);
        let balance = Balance::new(&mesh, &case, &EquilibriumSettings::default()).unwrap();
        let at = solve(&mesh, &case, &EquilibriumSettings::default()).unwrap().configuration;
        let stresses = balance.stresses(&at);
        let [mut k, mut mixed] = [0; 2].map(|_| BlockMatrix::zeros(balance.assembly.pattern.clone()));
        balance.tangent(&at, 0.7, &mut k);
        balance.mixed_tangent(&at, &stresses, 0.7, &mut mixed);
        assert!(k.plus(-1.0, &mixed).amax() < 1e-14 * k.amax());
        let drawing = Configuration::drawing(&mesh);
        let mixed = balance.mixed_residual(&drawing, &at, &stresses, 0.7);
        for (a, b) in balance.residual(&at, 0.7).nodal.iter().zip(&mixed) {
            assert!((a - b).amax() < 1e-11);
        }
    }
}
