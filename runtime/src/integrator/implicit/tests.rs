//! The Jacobian of a step against central differences.

use crate::common::{Lumped, Random};
use crate::loading::sealed::Acts;

use super::*;

/// The step's equations at an iterate: what Newton drives to zero.
fn residual(
    implicit: &mut Implicit,
    model: &Model,
    state: &State,
    rows: &RigidRows,
    work: &mut Workspace,
) -> Vec<f64> {
    let at = implicit
        .evaluate_rows(model, state, rows, model.no_loads().acting(), state.time, true, work)
        .unwrap();
    let gain = implicit.parameters.velocity_gain;
    let change: Vec<f64> = implicit.iterate.iter().zip(&implicit.image).map(|(x, image)| x - image).collect();
    let mut residual: Vec<f64> = change.iter().zip(&implicit.diagonal).map(|(x, d)| d * x).collect();
    match &at.rigid {
        Some(at) => {
            residual.extend((0..6).map(|row| at.momentum[row] - at.momentum_known[row] - gain * at.rate[row]))
        }
        None => {
            // The iteration matrix with A held is diag + Phi_R^t M_RR Phi_R.
            let moved = true_velocity(&model.phi_r, &change[..model.n_modes()], &[0.0; 6]);
            let momentum = mul6_symmetric(&model.rigid_mass, &moved);
            for (residual, phi) in residual.iter_mut().zip(&model.phi_r) {
                *residual += (0..6).map(|k| phi[k] * momentum[k]).sum::<f64>();
            }
        }
    }
    residual
}

/// A Newton correction x solves `J x = -residual`: `J x` by central differences must be `-residual`.
fn check_jacobian(motion: Option<&PrescribedMotion>) {
    let mut lumped = Lumped::random(3, 5);
    lumped.damping_ratio = 0.1;
    let model = Model::new(lumped.data(5)).unwrap();
    let mut random = Random::new(8);
    let mut state = State::at_rest(&model);
    state.q = random.array::<3>(0.3).into();
    state.q_dot = random.array::<3>(1.0).into();
    state.beta_star = random.array(2.0);
    state.u_dot = random.array::<9>(2.0).into();
    state.algorithmic = random.array::<9>(2.0).into();
    let mut work = Workspace::new(&model);
    let mut implicit = Implicit::new(&model, Parameters::generalized_alpha(0.3, 0.2));
    implicit.begin(&model, &state, model.gravity());
    let rows = implicit.rigid_rows(&model, &state, motion);

    let here = residual(&mut implicit, &model, &state, &rows, &mut work);
    let at = implicit
        .evaluate_rows(&model, &state, &rows, model.no_loads().acting(), state.time, true, &mut work)
        .unwrap();
    implicit.newton_correction(&model, &at, true);
    let iterate = implicit.iterate.clone();
    let correction: Vec<f64> =
        implicit.image.iter().zip(&iterate).map(|(image, iterate)| image - iterate).collect();
    let h = 1e-5;
    let mut moved = |h: f64| {
        for ((place, iterate), x) in implicit.iterate.iter_mut().zip(&iterate).zip(&correction) {
            *place = iterate + h * x;
        }
        residual(&mut implicit, &model, &state, &rows, &mut work)
    };
    let (after, before) = (moved(h), moved(-h));
    let size = here.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    assert!(size > 0.1, "the iterate does not solve the equations");
    for ((after, before), here) in after.iter().zip(&before).zip(&here) {
        let slope = (after - before) / (2.0 * h);
        // Central difference: h^2 and round-off over h, both below 1e-9.
        assert!((slope + here).abs() < 1e-8 * size, "{slope} instead of {}", -here);
    }
}

#[test]
fn the_jacobian_is_the_derivative_of_the_equations_of_a_step() {
    check_jacobian(None);
}

#[test]
fn so_it_is_where_the_motion_of_a_is_prescribed() {
    let mut random = Random::new(9);
    let motion =
        PrescribedMotion { velocity: random.array(2.0), rate: random.array(2.0), ..Default::default() };
    check_jacobian(Some(&motion));
}
