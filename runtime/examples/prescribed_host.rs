//! A host that owns the rigid body: it integrates the six degrees of freedom of the aircraft with the inertia of the undeformed body,
//! moves frame A of the elastic body, and gets back what elasticity adds.
//!
//! ```sh
//! romgen build models/fmb.toml -o fmb.rom
//! cargo run --package rom-runtime --example prescribed_host -- fmb.rom
//! ```
//!
//! Ends with an error where the shared body does not fly as the whole one.

use std::error::Error;
use std::sync::Arc;

use nalgebra::{Matrix6, Vector6};
use rom_runtime::{
    Integrator, LoadFrame, LoadSet, Method, Model, PrescribedMotion, Settings, Simulation, State, StateRate,
    Workspace,
};

/// A flight-dynamics code with a rigid aircraft: here the rigid method of the same model stands for it.
struct Host {
    body: State,
    rigid: Model,
    inverse: Matrix6<f64>,
    work: Workspace,
    rate: StateRate,
    beta_dot: [f64; 6],
}

impl Host {
    fn new(model: &Model) -> Result<Self, Box<dyn Error>> {
        let rigid = model.with_method(Method::Rigid)?;
        let inverse = Matrix6::from_fn(|i, j| rigid.rigid_mass_inverse()[i][j]);
        let (work, rate) = (Workspace::new(&rigid), StateRate::new(&rigid));
        Ok(Host { body: State::at_rest(&rigid), inverse, work, rate, beta_dot: [0.0; 6], rigid })
    }

    /// What the elastic body is told.
    fn motion(&self) -> PrescribedMotion {
        PrescribedMotion {
            velocity: self.body.beta_star,
            rate: self.beta_dot,
            attitude: self.body.attitude,
            position: self.body.position,
        }
    }

    /// One step of the host's own integrator under the wrench (force, moment) about the origin of A, in A.
    fn advance(&mut self, wrench: [f64; 6], dt: f64) -> Result<(), Box<dyn Error>> {
        let none = self.rigid.no_loads();
        self.rigid.derivatives(&self.body, &none, &mut self.work, &mut self.rate)?;
        // M beta_dot + C(beta) beta = wrench
        let added = self.inverse * Vector6::from(wrench);
        for (k, beta_dot) in self.beta_dot.iter_mut().enumerate() {
            *beta_dot = self.rate.u_dot[k] + added[k];
            self.body.beta_star[k] += dt * *beta_dot;
        }
        for (zeta, zeta_dot) in self.body.attitude.iter_mut().zip(self.rate.attitude_dot) {
            *zeta += dt * zeta_dot;
        }
        let length = self.body.attitude.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.body.attitude.iter_mut().for_each(|x| *x /= length);
        for (r, r_dot) in self.body.position.iter_mut().zip(self.rate.position_dot) {
            *r += dt * r_dot;
        }
        Ok(())
    }
}

/// Largest difference of v and w of A between the shared body and the whole one after a second.
fn difference(model: &Arc<Model>, dt: f64) -> Result<f64, Box<dyn Error>> {
    let steps = (1.0 / dt).round() as usize;
    let settings = Settings { dt, integrator: Integrator::Rk4, ..Settings::default() };
    let points = [model.point("P")?, model.point("Q")?];
    // A push on both tips, constant in A.
    let mut loads = LoadSet::new(model, &points)?;
    for (slot, force) in [[0.0, 30.0, 0.0], [0.0, 20.0, 10.0]].into_iter().enumerate() {
        if !loads.add(slot, &LoadFrame::Body, force, [0.0; 3]) {
            return Err("the set has no such slot".into());
        }
    }

    let mut host = Host::new(model)?;
    let mut elastic = Simulation::new(model.clone(), settings)?;
    elastic.prescribe(&loads, &host.motion())?;
    for _ in 0..steps {
        // The host carries the inertia of the undeformed body, so it takes the loads and what elasticity adds.
        let reaction = elastic.reaction().ok_or("no step with a prescribed motion yet")?;
        let wrench = std::array::from_fn(|k| reaction.loads[k] + reaction.increment[k]);
        host.advance(wrench, dt)?;
        elastic.step_prescribed(&loads, &host.motion())?;
    }

    let mut whole = Simulation::new(model.clone(), settings)?;
    for _ in 0..steps {
        whole.step(&loads)?;
    }
    let pairs = model.velocity(elastic.state()).into_iter().zip(model.velocity(whole.state()));
    Ok(pairs.fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs())))
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("name a model file: fmb.rom")?;
    let model = Arc::new(Model::read_path(path)?);
    let mut errors = Vec::new();
    for dt in [2e-4, 1e-4] {
        let error = difference(&model, dt)?;
        println!(
            "steps of {dt} s: host and elastic body are {error:.1e} (m/s, rad/s) from the whole body after 1 s"
        );
        errors.push(error);
    }
    // The host, and the wrench one step late, are of first order.
    match errors.as_slice() {
        [coarse, fine] if *fine < coarse / 1.6 => Ok(()),
        _ => Err("the shared body does not come closer to the whole one with the step".into()),
    }
}
