//! Slopes of the inertia, elastic forces and weight of a consistent model at given accelerations.
//!
//! With `y` of third order in the amplitudes these forces are polynomials of sixth degree at most along an amplitude (the inertia
//! `P_ab y_a y_b`), and of second degree along a rate or a velocity. Central differences over three steps to either side, and over one,
//! are exact for these degrees whatever the step, which is taken as large as the range of the model: no digits cancel.

use alloc::{vec, vec::Vec};

use super::relative_rows;
use crate::equations::Workspace;
use crate::lagrangian::{Accelerations, Lagrangian, Scratch};
use crate::math::{Vec3, Vec6, add_scaled, matrix, mul_t, sub_6};
use crate::model::Model;
use crate::state::{State, true_velocity};

/// Steps to either side and their weights: exact to sixth and to second degree.
pub(super) const SIXTH: [(f64, f64); 3] = [(1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0)];
const SECOND: [(f64, f64); 1] = [(1.0, 0.5)];

/// Where the forces are differentiated, and scratch.
#[derive(Clone, Debug)]
pub(super) struct Consistent {
    at: Scratch,
    q: Vec<f64>,
    q_dot: Vec<f64>,
    beta: Vec6,
    q_ddot: Vec<f64>,
    beta_dot: Vec6,
    /// In A.
    gravity: Vec3,
    /// Forces at one place: relative elastic rows - (m).
    elastic: Vec<f64>,
    /// Step along each amplitude - (m).
    steps: Vec<f64>,
}

impl Consistent {
    pub(super) fn new(model: &Model) -> Self {
        let m = if model.lagrangian.is_some() { model.n_modes() } else { 0 };
        let range = model.data().lagrangian.as_ref().map_or(&[][..], |it| &it.range);
        let step = |range: &f64| if *range > 0.0 && range.is_finite() { range / 3.0 } else { 1.0 };
        Consistent {
            at: Scratch::new(model),
            q: vec![0.0; m],
            q_dot: vec![0.0; m],
            beta: [0.0; 6],
            q_ddot: vec![0.0; m],
            beta_dot: [0.0; 6],
            gravity: [0.0; 3],
            elastic: vec![0.0; m],
            steps: range.iter().map(step).collect(),
        }
    }

    /// Step along each amplitude; none where the mass matrix is constant.
    pub(super) fn steps(&self) -> &[f64] {
        &self.steps
    }

    /// At a state and its accelerations `(q_ddot, beta*_dot)`.
    pub(super) fn start(&mut self, model: &Model, state: &State, u_dot: &[f64], gravity: Vec3) {
        let copies =
            [(&mut self.q, &state.q[..]), (&mut self.q_dot, &state.q_dot), (&mut self.q_ddot, u_dot)];
        for (to, from) in copies {
            for (to, from) in to.iter_mut().zip(from) {
                *to = *from;
            }
        }
        self.beta = model.velocity(state);
        let rate = u_dot.last_chunk::<6>().copied().unwrap_or_default();
        self.beta_dot = true_velocity(&model.phi_r, u_dot, &rate);
        self.gravity = mul_t(&matrix(state.attitude), gravity);
    }

    /// Turns the slopes of the loads in `work` into those of all forces on the relative elastic rows and the rigid ones, along the
    /// state `column` of the Jacobian; `g` is the slope of the acceleration of free fall in A. `work.lagrangian` holds the state.
    pub(super) fn add_slopes(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        column: usize,
        g: Vec3,
        work: &mut Workspace,
    ) {
        relative_rows(model, work);
        let weight = lagrangian.weight(g, &work.lagrangian, &mut work.relative);
        if let Some(rigid) = work.external.last_chunk_mut::<6>() {
            add_scaled(rigid, 1.0, &weight);
        }
        let rule: &[(f64, f64)] = if column < model.n_modes() { &SIXTH } else { &SECOND };
        let step = self.step(model, column);
        let mut rigid = [0.0; 6];
        for (steps, weight) in rule {
            for sign in [1.0, -1.0] {
                let Some(at_step) = self.forces_at(model, lagrangian, column, sign * steps * step) else {
                    // Turned or moved, the body has the same inertia and elastic forces.
                    break;
                };
                add_scaled(&mut work.relative, -sign * weight / step, &self.elastic);
                add_scaled(&mut rigid, sign * weight / step, &at_step);
            }
        }
        work.lagrangian.rigid = rigid;
    }

    /// A step of the size of what is there: an amplitude at its range, a rate that goes through it at the frequency of the mode, a
    /// velocity at its own size.
    fn step(&self, model: &Model, column: usize) -> f64 {
        let m = model.n_modes();
        let of = |values: &[f64], mode: usize| values.get(mode).copied().unwrap_or(1.0);
        match column.checked_sub(m) {
            None => of(&self.steps, column),
            Some(mode) if mode < m => of(&self.steps, mode) * of(&model.data().modes.omega, mode).max(1e-3),
            Some(_) => self.beta.iter().fold(1.0, |size: f64, x| size.max(x.abs())),
        }
    }

    /// The forces with one state moved by `h`: relative elastic rows in `self.elastic`, rigid ones returned; none along states that
    /// they do not depend on.
    fn forces_at(&mut self, model: &Model, lagrangian: &Lagrangian, column: usize, h: f64) -> Option<Vec6> {
        let m = model.n_modes();
        let beta = self.beta;
        let values = self.q.iter_mut().chain(&mut self.q_dot).chain(&mut self.beta);
        let place = values.into_iter().nth(column)?;
        let value = *place;
        *place += h;
        if let Some(phi) = column.checked_sub(m).and_then(|mode| model.phi_r.get(mode)) {
            add_scaled(&mut self.beta, h, phi);
        }
        let rigid = self.residual(lagrangian);
        self.beta = beta;
        if let Some(place) = self.q.iter_mut().chain(&mut self.q_dot).nth(column) {
            *place = value;
        }
        Some(rigid)
    }

    /// `M u_dot + h - weight`: relative elastic rows into `self.elastic`, rigid ones returned.
    fn residual(&mut self, lagrangian: &Lagrangian) -> Vec6 {
        let Consistent { at, q, q_dot, beta, q_ddot, beta_dot, gravity, elastic, .. } = self;
        let accelerations = Accelerations { q_ddot, beta_dot, fall: *gravity };
        lagrangian.inertia(q, q_dot, beta, &accelerations, at);
        for (to, inertia) in elastic.iter_mut().zip(at.elastic()) {
            *to = *inertia;
        }
        sub_6(&at.rigid, &lagrangian.rigid_weight(*gravity, at))
    }
}
