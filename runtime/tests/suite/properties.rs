//! Properties that hold for any input.

use std::sync::Arc;

use crate::common::Lumped;
use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use rom_runtime::expression::{Binary, Instruction, Program, Unary, Variable, Variables};
use rom_runtime::format::MAGIC;
use rom_runtime::time::TimeFunction;
use rom_runtime::{Integrator, Load, LoadCase, LoadFrame, Model, Settings, Simulation, State};

fn instruction() -> impl Strategy<Value = Instruction> {
    prop_oneof![
        (-3.0..3.0_f64).prop_map(Instruction::Constant),
        Just(Instruction::Variable(Variable::T)),
        Just(Instruction::Unary(Unary::Neg)),
        Just(Instruction::Binary(Binary::Add)),
        Just(Instruction::Binary(Binary::Mul)),
    ]
}

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

fn scalar_first(q: UnitQuaternion<f64>) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}

/// A model under one load in each frame; `turn` is applied to the dead one.
fn run(turn: UnitQuaternion<f64>, shift: Vector3<f64>, integrator: Integrator) -> State {
    let model = Arc::new(Model::new(Lumped::random(3, 2).data(2)).unwrap());
    let time = TimeFunction::Constant { value: 1.0 };
    let dead = Load {
        point: 0,
        frame: LoadFrame::Dead,
        force: (turn * Vector3::new(3.0, 1.0, -2.0)).into(),
        moment: (turn * Vector3::new(0.5, -1.0, 2.0)).into(),
        time: time.clone(),
    };
    let body =
        Load { point: 1, frame: LoadFrame::Body, force: [0.5, 1.0, 0.0], moment: [1.0, 0.0, 0.0], time };
    let case = LoadCase { dt: 0.02, loads: vec![dead, body], ..LoadCase::empty("turned") };
    let loads = model.prepare(&case).unwrap();
    let settings = Settings { dt: 0.02, integrator, ..Settings::default() };
    let mut simulation = Simulation::new(model.clone(), settings).unwrap();
    let mut state = State::at_rest(&model);
    state.beta_star = [0.3, -0.2, 0.1, 0.4, 0.8, -0.5];
    state.attitude = scalar_first(turn);
    state.position = shift.into();
    simulation.restore(&state).unwrap();
    for _ in 0..25 {
        simulation.step(&loads).unwrap();
    }
    simulation.state().clone()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(Model::from_bytes(&bytes).is_err());
        let mut with_magic = MAGIC.to_vec();
        with_magic.extend([1, 0, 0, 0]);
        with_magic.extend(bytes);
        prop_assert!(Model::from_bytes(&with_magic).is_err());
    }

    #[test]
    fn a_program_that_passes_its_check_has_a_value(code in prop::collection::vec(instruction(), 0..40)) {
        let program = Program { source: String::new(), code };
        let value = program.value(&Variables { t: 0.5, ..Variables::default() });
        // These instructions make finite numbers of finite numbers (at most 3^32).
        prop_assert!(program.check().is_err() || value.is_finite());
    }

    #[test]
    fn a_turned_and_shifted_world_changes_nothing_but_the_frame(axis in vector(3.0), shift in vector(10.0)) {
        let turn = UnitQuaternion::from_scaled_axis(axis);
        for integrator in [Integrator::Newmark, Integrator::Rk4, Integrator::GeneralizedAlpha] {
            let here = run(UnitQuaternion::identity(), Vector3::zeros(), integrator);
            let there = run(turn, shift, integrator);
            // 25 steps of round-off, times the growth of differences over half a second.
            for (a, b) in here.q.iter().chain(&here.q_dot).chain(&here.beta_star)
                .zip(there.q.iter().chain(&there.q_dot).chain(&there.beta_star)) {
                prop_assert!((a - b).abs() < 1e-11, "{integrator}: {a} and {b}");
            }
            let position = shift + turn * Vector3::from(here.position);
            prop_assert!((position - Vector3::from(there.position)).norm() < 1e-11);
            prop_assert!((turn * here.attitude_quaternion()).angle_to(&there.attitude_quaternion()) < 1e-7);
        }
    }
}
