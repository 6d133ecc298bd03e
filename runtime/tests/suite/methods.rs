//! Mean axes and the rigid body as simplifications of a reduced model.

use std::sync::Arc;

use rom_runtime::loads::{Load, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;
use rom_runtime::{Method, Model, ModelError, Settings, Simulation};

fn case(amplitude: f64) -> LoadCase {
    LoadCase {
        dt: 0.01,
        loads: vec![Load {
            point: 0,
            frame: LoadFrame::Dead,
            force: [0.3 * amplitude, -0.5 * amplitude, amplitude],
            moment: [0.0; 3],
            time: TimeFunction::OneMinusCosine { amplitude: 1.0, start: 0.0, duration: 1.0 },
        }],
        ..LoadCase::empty("pull")
    }
}

fn run(model: &Arc<Model>, case: &LoadCase) -> Simulation {
    let loads = model.prepare(case).unwrap();
    let settings = Settings { dt: 0.005, ..Settings::default() };
    let mut simulation = Simulation::new(Arc::clone(model), settings).unwrap();
    for _ in 0..200 {
        simulation.step(&loads).unwrap();
    }
    simulation
}

/// Gyroscopic forces are of second order in the motion: as the loads shrink, mean axes and the reduced model agree, the
/// difference falling with the square of the load (the motion itself with its first power).
#[test]
fn mean_axes_is_the_limit_of_small_rates() {
    let rom = Arc::new(Model::new(crate::common::Lumped::random(4, 3).data(3)).unwrap());
    let mean = Arc::new(rom.with_method(Method::MeanAxes).unwrap());
    assert_eq!(mean.method(), Method::MeanAxes);
    let difference = |amplitude: f64| {
        let (a, b) = (run(&rom, &case(amplitude)), run(&mean, &case(amplitude)));
        let q: f64 = a.state().q.iter().zip(&b.state().q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let (a, b) = (a.rigid_output(), b.rigid_output());
        let v: f64 = a.v_g.iter().zip(&b.v_g).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let r: f64 = a.r_g.iter().zip(&b.r_g).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        [q, v, r]
    };
    let (large, small) = (difference(1e-2), difference(1e-3));
    for (large, small) in large.iter().zip(&small) {
        assert!(*small > 0.0 && (large / small).log10() > 1.8, "{large} {small}");
    }
}

/// The momentum of the rigid body follows the loads exactly in both.
#[test]
fn rigid_body_and_mean_axes_move_their_centre_of_mass_alike() {
    let rom = Model::new(crate::common::Lumped::random(4, 3).data(3)).unwrap();
    let case = case(1.0);
    let at = |method| {
        let simulation = run(&Arc::new(rom.with_method(method).unwrap()), &case);
        (simulation.ledger(), simulation.rigid_output(), simulation.state().q.len())
    };
    let (rigid, _, none) = at(Method::Rigid);
    let (mean, _, m) = at(Method::MeanAxes);
    assert!(none == 0 && m > 0);
    for k in 0..3 {
        assert!((rigid.r_cm_g[k] - mean.r_cm_g[k]).abs() < 1e-12);
        assert!((rigid.linear_momentum_g[k] - mean.linear_momentum_g[k]).abs() < 1e-11);
    }
}

#[test]
fn a_simplified_model_does_not_come_back() {
    let rom = Model::new(crate::common::Lumped::random(4, 3).data(3)).unwrap();
    let rigid = rom.with_method(Method::Rigid).unwrap();
    assert!(matches!(rigid.with_method(Method::Rom), Err(ModelError::Method { .. })));
    assert!(rom.with_method(Method::Rom).is_ok());
}
