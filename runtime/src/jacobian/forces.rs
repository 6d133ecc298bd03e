//! Forces on all rows with their slopes: [`crate::equations::forces`] in numbers that carry slopes.

use alloc::{vec, vec::Vec};

use super::Coordinates;
use super::loads::ForwardLoads;
use crate::base_motion::BaseMotion;
use crate::equations::Workspace;
use crate::forward::{DIRECTIONS, Forward, ForwardVariables, take_values};
use crate::loading::Acting;
use crate::math::{Vec3, Vec6, matrix, mul_t, quaternion, quaternion_product, split};
use crate::model::Model;
use crate::point_motion::Moving;
use crate::real::Real;
use crate::state::{State, true_velocity};
use crate::tensor::Windows;

/// A state with slopes along some directions, and the forces there.
#[derive(Clone, Debug)]
pub(super) struct ForwardForces {
    t: f64,
    q: Vec<Forward>,
    u: Vec<Forward>,
    q_ddot: Vec<Forward>,
    beta: Vec6<Forward>,
    theta: Vec3<Forward>,
    attitude: [Forward; 4],
    position: Vec3<Forward>,
    products: Windows<Forward>,
    gyroscopic: Vec<Forward>,
    damped: Vec<Forward>,
    external: Vec<Forward>,
    /// Acceleration of free fall in A.
    gravity: Vec3<Forward>,
    loads: ForwardLoads,
}

impl ForwardForces {
    pub(super) fn new(model: &Model) -> Self {
        let m = model.n_modes();
        let zero = Forward::default();
        ForwardForces {
            t: 0.0,
            q: vec![zero; m],
            u: vec![zero; m + 6],
            q_ddot: vec![zero; m],
            beta: [zero; 6],
            theta: [zero; 3],
            attitude: [zero; 4],
            position: [zero; 3],
            products: if model.lagrangian.is_some() { Vec::new() } else { model.contraction.products() },
            gyroscopic: vec![zero; m + 6],
            damped: vec![zero; m],
            external: vec![zero; m + 6],
            gravity: [zero; 3],
            loads: ForwardLoads::new(model),
        }
    }

    /// The state, with the states from `first` on as directions.
    pub(super) fn seed(&mut self, model: &Model, state: &State, first: usize) {
        let directions = (0..DIRECTIONS).map(|direction| (first + direction, direction, 1.0));
        self.place(model, state, directions);
    }

    /// The state, with slopes (coordinate, direction, slope).
    pub(super) fn place(
        &mut self,
        model: &Model,
        state: &State,
        slopes: impl Iterator<Item = (usize, usize, f64)>,
    ) {
        self.t = state.time;
        take_values(&mut self.q, &state.q);
        if let Some((rates, rigid)) = self.u.split_last_chunk_mut::<6>() {
            take_values(rates, &state.q_dot);
            take_values(rigid, &state.beta_star);
        }
        self.theta = [Forward::default(); 3];
        self.position = state.position.map(Forward::of);
        for (coordinate, direction, slope) in slopes {
            let places =
                self.q.iter_mut().chain(&mut self.u).chain(&mut self.theta).chain(&mut self.position);
            if let Some(place) = places.into_iter().nth(coordinate) {
                place.seed(direction, slope);
            }
        }
        if let Some((rates, rigid)) = self.u.split_last_chunk::<6>() {
            self.beta = true_velocity(&model.phi_r, rates, rigid);
        }
        self.attitude = quaternion_product(state.attitude.map(Forward::of), quaternion(self.theta));
    }

    /// Gyroscopic forces, loads and weight; of a consistent model the loads alone.
    pub(super) fn evaluate(&mut self, model: &Model, loads: &Acting, gravity: Vec3) {
        let attitude = matrix(self.attitude);
        let (v_a, w_a) = split(&self.beta);
        let variables = ForwardVariables { t: self.t, v_a, w_a, r_g: self.position };
        self.loads.evaluate(loads, &variables, &self.q, &attitude, &mut self.external);
        self.gravity = mul_t(&attitude, gravity.map(Forward::of));
        if model.lagrangian.is_some() {
            return;
        }
        model.contraction.apply(&self.u, &self.q, &self.beta, &mut self.products, &mut self.gyroscopic);
        if let Some(damping) = &model.damping {
            damping.apply(&self.u, &mut self.damped);
            for (force, damped) in self.gyroscopic.iter_mut().zip(&self.damped) {
                *force += *damped;
            }
        }
        if gravity != [0.0; 3] {
            model.weight.add(self.gravity, &self.q, &mut self.external);
        }
    }

    /// Rate of the true velocity of A in a load case that moves it.
    pub(super) fn base_rate(&self, base: &BaseMotion) -> Vec6<Forward> {
        base.rate(&self.beta, &matrix(self.attitude), self.t)
    }

    /// Slope of the acceleration of free fall in A.
    pub(super) fn gravity_slope(&self, direction: usize) -> Vec3 {
        self.gravity.map(|x| x.slope(direction))
    }

    /// Slopes along one direction: of the state into `q` and `u`, of the forces into `work`.
    pub(super) fn slopes(
        &self,
        direction: usize,
        q: &mut [f64],
        u: &mut [f64],
        work: &mut Workspace,
    ) -> Coordinates {
        let copy = |to: &mut [f64], from: &[Forward]| {
            for (to, from) in to.iter_mut().zip(from) {
                *to = from.slope(direction);
            }
        };
        copy(q, &self.q);
        copy(u, &self.u);
        copy(&mut work.external, &self.external);
        copy(&mut work.gyroscopic, &self.gyroscopic);
        Coordinates {
            theta: self.theta.map(|x| x.slope(direction)),
            beta: self.beta.map(|x| x.slope(direction)),
        }
    }

    /// What outputs follow from, with the accelerations of the modes; those of A are for the caller to fill in.
    pub(super) fn moving(&mut self, accelerations: impl Iterator<Item = Forward>) -> Moving<'_, Forward> {
        for (to, from) in self.q_ddot.iter_mut().zip(accelerations) {
            *to = from;
        }
        let m = self.q.len();
        Moving {
            q: &self.q,
            q_dot: self.u.get(..m).unwrap_or(&[]),
            q_ddot: &self.q_ddot,
            beta: self.beta,
            beta_dot: [Forward::default(); 6],
            attitude: self.attitude,
            position: self.position,
        }
    }
}
