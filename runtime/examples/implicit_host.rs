//! A host with an implicit integrator of its own: the implicit midpoint rule, solved by Newton's method with the exact Jacobian.
//!
//! ```sh
//! romgen build models/fmb.toml -o fmb.rom
//! cargo run --package rom-runtime --example implicit_host -- fmb.rom
//! ```

use std::error::Error;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Matrix3, Quaternion, UnitQuaternion, Vector3};
use rom_runtime::{
    Integrator, Jacobian, LoadFrame, LoadSet, Model, Settings, Simulation, State, StateRate, Workspace,
};

/// Moves a state along the coordinates of the Jacobian: amplitudes, rates, `beta*`, a turn of A in its own axes, position.
fn moved(state: &State, change: &DVector<f64>) -> State {
    let (m, mut next) = (state.q.len(), state.clone());
    (0..m).for_each(|i| next.q[i] += change[i]);
    (0..m).for_each(|i| next.q_dot[i] += change[m + i]);
    (0..6).for_each(|k| next.beta_star[k] += change[2 * m + k]);
    let theta = Vector3::new(change[2 * m + 6], change[2 * m + 7], change[2 * m + 8]);
    let [w, x, y, z] = state.attitude;
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    let turn = turn * UnitQuaternion::from_scaled_axis(theta);
    next.attitude = [turn.w, turn.i, turn.j, turn.k];
    (0..3).for_each(|k| next.position[k] += change[2 * m + 9 + k]);
    next
}

/// `x_1 = x_0 + dt f(x_0 + y)` with `y = dt/2 f(x_0 + y)`; a turn by `phi = dt/2 w` is undone by no commutator at the midpoint.
struct Midpoint {
    jacobian: Jacobian,
    work: Workspace,
    rate: StateRate,
    iterations: usize,
}

impl Midpoint {
    fn step(
        &mut self,
        model: &Model,
        state: &State,
        loads: &LoadSet,
        dt: f64,
    ) -> Result<State, Box<dyn Error>> {
        let (n, m) = (self.jacobian.size(), model.n_modes());
        let mut half = DVector::zeros(n);
        for _ in 0..20 {
            let mut middle = moved(state, &half);
            middle.time = state.time + 0.5 * dt;
            model.derivatives(&middle, loads, &mut self.work, &mut self.rate)?;
            let beta = model.velocity(&middle);
            let rates = self.rate.q_dot.iter().chain(&self.rate.u_dot);
            let rates = rates.chain(&beta[3..]).chain(&self.rate.position_dot);
            let residual = &half - DVector::from_iterator(n, rates.copied()) * (0.5 * dt);
            self.iterations += 1;
            if residual.amax() < 1e-12 {
                let mut end = moved(state, &(&half * 2.0));
                end.time = state.time + dt;
                return Ok(end);
            }
            self.jacobian.evaluate(&middle, loads)?;
            // A small turn at the midpoint changes the vector phi that led there by T(phi)^-1, and the rate w not at all.
            let mut a =
                DMatrix::identity(n, n) - DMatrix::from_row_slice(n, n, self.jacobian.matrix()) * (0.5 * dt);
            let phi = Vector3::new(half[2 * m + 6], half[2 * m + 7], half[2 * m + 8]);
            let tangential = tangential(&phi);
            let inverse = tangential.try_inverse().ok_or("a turn of 2 pi in a step: take shorter ones")?;
            a.view_mut((2 * m + 6, 2 * m + 6), (3, 3)).copy_from(&inverse);
            let mut step = a.lu().solve(&-residual).ok_or("the Jacobian of the step is singular")?;
            // From the turn at the midpoint to the vector.
            let theta = inverse * Vector3::new(step[2 * m + 6], step[2 * m + 7], step[2 * m + 8]);
            (0..3).for_each(|k| step[2 * m + 6 + k] = theta[k]);
            half += step;
        }
        Err("the step did not converge".into())
    }
}

/// `T(phi)`: angular velocity from the rate of a rotation vector, to fourth order of an angle that is small in a step.
fn tangential(phi: &Vector3<f64>) -> Matrix3<f64> {
    let cross = phi.cross_matrix();
    let square = cross * cross;
    Matrix3::identity() - cross * 0.5 + square / 6.0 - square * cross / 24.0 + square * square / 120.0
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("name a model file: fmb.rom")?;
    let model = Arc::new(Model::read_path(path)?);
    let mut loads = LoadSet::new(&model, &[model.point("P")?])?;
    if !loads.add(0, &LoadFrame::Dead, [0.0, 40.0, 20.0], [0.0; 3]) {
        return Err("the set has no such slot".into());
    }
    let t_end = 1.0;
    let settings = Settings { dt: 2e-4, integrator: Integrator::Rk4, ..Settings::default() };
    let mut reference = Simulation::new(model.clone(), settings)?;
    for _ in 0..(t_end / settings.dt).round() as usize {
        reference.step(&loads)?;
    }
    let mut errors = Vec::new();
    for dt in [0.02, 0.01] {
        let mut host = Midpoint {
            jacobian: Jacobian::new(model.clone()),
            work: Workspace::new(&model),
            rate: StateRate::new(&model),
            iterations: 0,
        };
        let steps = (t_end / dt).round() as usize;
        let mut state = State::at_rest(&model);
        for _ in 0..steps {
            state = host.step(&model, &state, &loads, dt)?;
        }
        let pairs = model.velocity(&state).into_iter().zip(model.velocity(reference.state()));
        let error = pairs.fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
        let each = host.iterations as f64 / steps as f64;
        println!("steps of {dt} s: error of v, w {error:.2e}, {each:.1} evaluations a step");
        errors.push(error);
    }
    // The rule is of second order.
    match errors.as_slice() {
        [coarse, fine] if *fine < coarse / 3.0 => Ok(()),
        _ => Err("the error does not fall with the square of the step".into()),
    }
}
