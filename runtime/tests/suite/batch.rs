//! Instances of a batch have the bits of single simulations: every integrator, method, frame of loads, and mishap.

use std::sync::Arc;

use crate::common::{Lumped, Random, rotation_rows};
use rom_runtime::data::{DampingData, GravityData, LineData, StationSet, TrimData};
use rom_runtime::expression::{Binary, Instruction, Program, Variable};
use rom_runtime::time::TimeFunction;
use rom_runtime::{
    Batch, DistributedFrame, DistributedLoad, Integrator, Load, LoadCase, LoadFrame, LoadSet, Loads, Method,
    Model, Settings, Simulation, State, StepError,
};

/// Gravity, a trim, dampers: every term there is.
fn model(m: usize) -> Model {
    let mut lumped = Lumped::random(m, 9);
    lumped.damping_ratio = 0.02;
    let mut data = lumped.data(9);
    let mut random = Random::new(2);
    data.gravity =
        Some(GravityData { acceleration: [0.1, -0.2, -9.0], second_moment: symmetric(m, &mut random) });
    data.trim = Some(TrimData {
        distributed: Vec::new(),
        loads: vec![],
        elastic_force: (0..m).map(|_| random.next()).collect(),
        elastic_energy: 1.0,
        attitude: [1.0, 0.0, 0.0, 0.0],
        factors: vec![],
        load_names: Vec::new(),
        reaction: [0.0; 6],
        scales: [1.0; 2],
        displacements: vec![[0.0; 3]; data.points.len()],
        effort: [1; 2],
    });
    let mut coupling = vec![0.0; m * m];
    for (i, j) in (0..m).flat_map(|i| (0..m).map(move |j| (i, j))) {
        coupling[i * m + j] = if i == j { 0.0 } else { 0.01 };
    }
    data.damping = Some(DampingData { coupling });
    Model::new(data).unwrap()
}

/// Three symmetric matrices - (3 x m x m).
fn symmetric(m: usize, random: &mut Random) -> Vec<f64> {
    let mut values = vec![0.0; 3 * m * m];
    for k in 0..3 {
        for i in 0..m {
            for j in 0..=i {
                let value = 0.1 * random.next();
                values[(k * m + i) * m + j] = value;
                values[(k * m + j) * m + i] = value;
            }
        }
    }
    values
}

fn case(random: &mut Random) -> LoadCase {
    let program = Program {
        source: "vx * t".into(),
        code: vec![
            Instruction::Variable(Variable::Vx),
            Instruction::Variable(Variable::T),
            Instruction::Binary(Binary::Mul),
        ],
    };
    let frames =
        [LoadFrame::Dead, LoadFrame::Body, LoadFrame::Follower { section: rotation_rows(&random.vector()) }];
    let times = [
        TimeFunction::Step { value: 1.0, start: 0.05, end: 1.0 },
        TimeFunction::Sine { amplitude: 1.0, omega: 3.0, phase: 0.2, start: 0.0, end: 9.0 },
        TimeFunction::Expression { program },
    ];
    let loads = frames.into_iter().zip(times).enumerate().map(|(i, (frame, time))| Load {
        point: i as u32,
        frame,
        force: random.array(4.0),
        moment: random.array(2.0),
        time,
    });
    LoadCase { dt: 0.01, loads: loads.collect(), ..LoadCase::empty("all frames") }
}

fn start(model: &Model, random: &mut Random) -> State {
    let mut state = State::at_rest(model);
    state.q.iter_mut().for_each(|q| *q = 0.2 * random.next());
    state.q_dot.iter_mut().for_each(|q| *q = 0.5 * random.next());
    state.beta_star = random.array(1.0);
    state.position = random.array(3.0);
    state.time = 0.01 * random.next().abs();
    state
}

/// Steps a batch and single simulations side by side, and compares all bits of their states. Returns how many steps of instances were
/// made one by one.
fn compare<L: Loads>(model: &Arc<Model>, settings: Settings, loads: &[L], steps: usize) -> u64 {
    let mut random = Random::new(31);
    let starts: Vec<State> = loads.iter().map(|_| start(model, &mut random)).collect();
    compare_from(model, settings, loads, &starts, steps)
}

fn compare_from<L: Loads>(
    model: &Arc<Model>,
    settings: Settings,
    loads: &[L],
    starts: &[State],
    steps: usize,
) -> u64 {
    let mut batch = Batch::new(model.clone(), settings, loads.len()).unwrap();
    let mut singles = Vec::new();
    for (index, state) in starts.iter().enumerate() {
        let mut single = Simulation::new(model.clone(), settings).unwrap();
        single.restore(state).unwrap();
        batch.restore(index, state).unwrap();
        singles.push(single);
    }
    for step in 0..steps {
        assert_eq!(batch.step(loads).unwrap(), loads.len());
        for (index, (single, loads)) in singles.iter_mut().zip(loads).enumerate() {
            single.step(loads).unwrap();
            let state = batch.state(index).unwrap();
            let what = format!("{:?}, instance {index}, step {step}", settings.integrator);
            assert_eq!(&state, single.state(), "{what}");
            // Equal numbers may differ in the sign of zero.
            for (a, b) in
                state.q.iter().chain(&state.u_dot).zip(single.state().q.iter().chain(&single.state().u_dot))
            {
                assert_eq!(a.to_bits(), b.to_bits(), "{what}");
            }
        }
    }
    batch.steps_alone()
}

fn settings(integrator: Integrator, dt: f64) -> Settings {
    let numerical_damping = if integrator == Integrator::Rk4 { 0.0 } else { 0.05 };
    Settings { dt, integrator, numerical_damping, ..Settings::default() }
}

#[test]
fn lanes_have_the_bits_of_single_runs() {
    for m in [0, 5] {
        for method in Method::ALL {
            let model = Arc::new(model(m).with_method(method).unwrap());
            let case = case(&mut Random::new(4));
            // More than a chunk, less than two.
            let loads: Vec<_> = (0..11)
                .map(|i| {
                    let mut case = case.clone();
                    for load in &mut case.loads {
                        load.force = load.force.map(|f| f * (1.0 + 0.1 * f64::from(i)));
                    }
                    model.prepare(&case).unwrap()
                })
                .collect();
            for integrator in Integrator::of(&model) {
                let alone = compare(&model, settings(integrator, 0.01), &loads, 12);
                assert_eq!(alone, 0, "{integrator:?}: side by side they cost less");
            }
        }
    }
}

/// A body that rests in balance with large forces: the errors of a step are measured against what those forces do, in a batch too. How
/// fast it moves is what differs from instance to instance, from round-off upwards.
#[test]
fn bodies_at_rest_under_large_forces_have_the_bits_of_single_runs() {
    let m = 5;
    let mut data = model(m).data().clone();
    let gravity = [0.3, -0.4, -9.7];
    let weight = gravity.map(|g| -data.rigid.mass * g);
    data.gravity = Some(GravityData { acceleration: gravity, second_moment: vec![] });
    // A force on a point, and the moment that takes it to the centre of mass.
    let arm: [f64; 3] =
        std::array::from_fn(|k| data.points[2].node_position[k] - data.rigid.centre_of_mass[k]);
    let moment = std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        -(arm[i] * weight[j] - arm[j] * weight[i])
    });
    data.points[2].offset = [0.0; 3];
    let time = TimeFunction::Constant { value: 1.0 };
    let load = Load { point: 2, frame: LoadFrame::Dead, force: weight, moment, time };
    let trim = data.trim.as_mut().unwrap();
    trim.loads = vec![load];
    trim.elastic_force = vec![0.0; m];
    trim.scales = [1e2, 1e3];
    // What accelerates the modes without it is the elastic force of the equilibrium.
    let unbalanced = Model::new(data.clone()).unwrap();
    let loads = unbalanced.prepare(&LoadCase::empty("none")).unwrap();
    let mut rate = rom_runtime::StateRate::new(&unbalanced);
    let rest = State::at_rest(&unbalanced);
    unbalanced.derivatives(&rest, &loads, &mut rom_runtime::Workspace::new(&unbalanced), &mut rate).unwrap();
    let force = rate.u_dot.iter().zip(&data.modes.mass).map(|(q_ddot, mass)| q_ddot * mass);
    data.trim.as_mut().unwrap().elastic_force = force.collect();
    let model = Arc::new(Model::new(data).unwrap());

    let loads = vec![model.prepare(&LoadCase::empty("none")).unwrap(); 16];
    let mut random = Random::new(5);
    let starts = (0..16).map(|index| {
        let mut state = State::at_rest(&model);
        let size = if index == 0 { 0.0 } else { 10_f64.powi(-index) };
        state.q_dot.iter_mut().for_each(|q| *q = size * random.next());
        state.beta_star = random.array(size);
        state
    });
    let starts: Vec<State> = starts.collect();
    for integrator in [Integrator::Newmark, Integrator::GeneralizedAlpha] {
        let settings = settings(integrator, 0.01);
        let mut single = Simulation::new(model.clone(), settings).unwrap();
        single.step(&loads[0]).unwrap();
        assert!(single.state().q_dot.iter().all(|q| q.abs() < 1e-12), "it rests");
        // Without the floor that the forces set, round-off would never count as converged, and every step be handed to a simulation.
        assert_eq!(compare_from(&model, settings, &loads, &starts, 10), 0);
    }
}

/// Long steps take some instances through Newton's corrections.
#[test]
fn steps_that_need_newton_have_the_bits_of_single_runs() {
    let model = Arc::new(model(4));
    let loads = vec![model.prepare(&case(&mut Random::new(4))).unwrap(); 8];
    for integrator in [Integrator::Newmark, Integrator::GeneralizedAlpha] {
        assert!(compare(&model, settings(integrator, 0.2), &loads, 6) > 0, "none needed it");
    }
}

#[test]
fn loads_of_hosts_have_the_bits_of_single_runs() {
    for method in Method::ALL {
        let model = Arc::new(model(5).with_method(method).unwrap());
        let mut random = Random::new(8);
        let case = case(&mut random);
        let mut loads = vec![LoadSet::with_case(&model, &[1, 3], &case).unwrap(); 9];
        for (index, loads) in loads.iter_mut().enumerate() {
            for frame in [LoadFrame::Dead, LoadFrame::Body] {
                assert!(loads.add(index % 2, &frame, random.array(3.0), random.array(1.0)));
                loads.add_wrench(&frame, random.array(2.0), random.array(2.0));
            }
            assert!(loads.add_modal(&random.array::<5>(1.0)[..model.n_modes()]));
        }
        for integrator in Integrator::of(&model) {
            let alone = compare(&model, settings(integrator, 0.01), &loads, 8);
            // The origin of A moves in mean axes: a wrench on it has no lanes.
            assert_eq!(alone, if method == Method::MeanAxes { 9 * 8 } else { 0 });
        }
    }
}

#[test]
fn forces_projected_together_have_the_bits_of_single_runs() {
    let lumped = Lumped { plain_points: true, ..Lumped::random(5, 9) };
    let model = Arc::new(Model::new(lumped.data(9)).unwrap());
    let mut random = Random::new(12);
    let time = TimeFunction::Sine { amplitude: 1.0, omega: 3.0, phase: 0.2, start: 0.0, end: 9.0 };
    let mut case = |points: u32| {
        let loads = (0..2 * points).map(|n| Load {
            point: n / 2,
            frame: if n % 2 == 0 { LoadFrame::Dead } else { LoadFrame::Body },
            force: random.array(3.0),
            moment: [0.0; 3],
            time: time.clone(),
        });
        model.prepare(&LoadCase { dt: 0.01, loads: loads.collect(), ..LoadCase::empty("pushes") }).unwrap()
    };
    // Equal forces, others on the same points, on other points: all of them together, in lanes.
    let same = vec![case(4); 9];
    let different: Vec<_> = (0..9).map(|_| case(4)).collect();
    let elsewhere: Vec<_> = (0..9).map(|n| case(2 + n % 3)).collect();
    for integrator in Integrator::of(&model) {
        for loads in [&same, &different, &elsewhere] {
            assert_eq!(compare(&model, settings(integrator, 0.01), loads, 6), 0);
        }
    }
}

#[test]
fn loads_on_more_stations_than_there_are_points_have_the_bits_of_single_runs() {
    let mut data = Lumped::random(3, 9).data(9);
    let mut stations = StationSet::default();
    // An element a point, three stations an element.
    let elements = data.points.len();
    for point in data.points.iter().cycle().take(3 * elements) {
        stations.position.extend(point.node_position);
        stations.rotation.extend(point.node_rotation);
        stations.phi_translation.extend(&point.phi_translation);
        stations.phi_rotation.extend(&point.phi_rotation);
    }
    let knots = (0..=elements).map(|k| k as f64 / elements as f64).collect();
    data.lines = vec![LineData { name: "wing".into(), length: 2.0, knots, stations }];
    let model = Arc::new(Model::new(data).unwrap());
    let mut random = Random::new(14);
    let distributed = vec![DistributedLoad {
        member: 0,
        frame: DistributedFrame::Follower,
        force: (0..9 * elements).map(|_| random.next()).collect(),
        moment: (0..9 * elements).map(|_| random.next()).collect(),
        time: TimeFunction::Constant { value: 0.3 },
    }];
    let case = LoadCase { dt: 0.01, distributed, ..LoadCase::empty("follower") };
    let loads = vec![model.prepare(&case).unwrap(); 3];
    for integrator in Integrator::of(&model) {
        assert_eq!(compare(&model, settings(integrator, 0.01), &loads, 4), 0, "they have room");
    }
}

#[test]
fn instances_loaded_at_different_points_have_the_bits_of_single_runs() {
    let model = Arc::new(model(3));
    let loads: Vec<_> = (0..5).map(|i| LoadSet::new(&model, &[i]).unwrap()).collect();
    assert_eq!(compare(&model, settings(Integrator::Rk4, 0.01), &loads, 3), 5 * 3);
}

#[test]
fn one_instance_fails_and_the_others_go_on() {
    let model = Arc::new(model(3));
    for integrator in Integrator::of(&model) {
        let settings = settings(integrator, 0.01);
        let mut loads = vec![LoadSet::new(&model, &[0]).unwrap(); 10];
        let mut batch = Batch::new(model.clone(), settings, 10).unwrap();
        let mut single = Simulation::new(model.clone(), settings).unwrap();
        assert_eq!(batch.step(&loads).unwrap(), 10);
        single.step(&loads[0]).unwrap();
        let before = batch.state(4).unwrap();
        assert!(loads[4].add(0, &LoadFrame::Dead, [f64::INFINITY, 0.0, 0.0], [0.0; 3]));
        for _ in 0..3 {
            assert_eq!(batch.step(&loads).unwrap(), 9);
            single.step(&loads[0]).unwrap();
        }
        assert!(matches!(batch.error(4), Some(StepError::Diverged { .. })), "{:?}", batch.error(4));
        assert!(batch.error(5).is_none());
        let stopped = batch.state(4).unwrap();
        assert_eq!((stopped.time, &stopped.q, stopped.position), (before.time, &before.q, before.position));
        assert_eq!(&batch.state(9).unwrap(), single.state());
        // It can be taken up again.
        loads[4].clear();
        batch.restore(4, &before).unwrap();
        assert_eq!(batch.step(&loads).unwrap(), 10);
    }
}

#[test]
fn loads_have_to_be_those_of_the_batch() {
    let model = Arc::new(model(3));
    let mut batch = Batch::new(model.clone(), settings(Integrator::Rk4, 0.01), 2).unwrap();
    let error = batch.step(&[model.no_loads()]).unwrap_err();
    assert_eq!(error, StepError::LoadCount { found: 1, expected: 2 });
    let other = Lumped::random(2, 1).data(1);
    let foreign = Model::new(other).unwrap().no_loads();
    assert_eq!(batch.step(&[foreign, model.no_loads()]).unwrap(), 1);
    assert!(matches!(batch.error(0), Some(StepError::ForeignLoads { .. })));
    assert!(batch.state(2).is_none() && batch.error(2).is_none());
    assert!(batch.restore(2, &State::at_rest(&model)).is_err());
    assert!(Batch::new(model, settings(Integrator::Rk4, 0.01), 0).unwrap().is_empty());
}
