//! Steps with the motion of frame A prescribed by a host: the rigid rows are known, the modal ones solved.

use super::implicit::{Evaluation, Implicit, start_algorithmic_rigid};
use crate::equations::{Motion, Workspace, forces};
use crate::error::StepError;
use crate::loading::Acting;
use crate::math::{Vec6, add, axpy, dot_6, matrix, mul, mul6_symmetric, normalised, scale, split, sub};
use crate::model::Model;
use crate::prescribed::PrescribedMotion;
use crate::state::State;

impl Implicit {
    /// As [`Implicit::evaluate`], at the prescribed motion of A; `fresh` where a consistent model is to make its matrix anew.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn evaluate_prescribed(
        &mut self,
        model: &Model,
        motion: &PrescribedMotion,
        loads: &Acting,
        time: f64,
        fresh: bool,
        work: &mut Workspace,
    ) -> Result<Evaluation, StepError> {
        if let Some(lagrangian) = &model.lagrangian {
            return Ok(
                self.evaluate_prescribed_consistent(model, lagrangian, motion, loads, time, fresh, work)
            );
        }
        self.update_modes();
        let q_dot = self.u.split_last_chunk::<6>().map_or(&[][..], |u| u.0);
        let beta_star = model.own_velocity(&motion.velocity, q_dot);
        if let Some(u) = self.u.last_chunk_mut::<6>() {
            *u = beta_star;
        }
        let here = Motion {
            t: time,
            q: &self.q,
            u: &self.u,
            attitude: matrix(normalised(motion.attitude)),
            position: motion.position,
            beta: motion.velocity,
        };
        forces(model, loads, &here, work);
        let mut at = Evaluation { beta: motion.velocity, rigid: None, correction: 0.0, size: self.floor };
        self.substitute_prescribed(model, work, &motion.rate, &beta_star, &mut at)?;
        Ok(at)
    }

    /// `(diagonal + Phi_R^t M_RR Phi_R) q_ddot = Q - N - known + Phi_R^t (M_RR beta_dot + N_R - Q_R)`, and the norms of
    /// the change.
    fn substitute_prescribed(
        &mut self,
        model: &Model,
        work: &Workspace,
        rate: &Vec6,
        beta_star: &Vec6,
        at: &mut Evaluation,
    ) -> Result<(), StepError> {
        model.held()?;
        let Some(held) = &self.held else { return Ok(()) };
        let shaken = model.base_force(rate, work);
        let Some((image, _)) = self.image.split_last_chunk_mut::<6>() else { return Ok(()) };
        let forces = work.external.iter().zip(&work.gyroscopic).zip(&self.force_known);
        for ((image, ((external, gyroscopic), known)), phi) in image.iter_mut().zip(forces).zip(&model.phi_r)
        {
            *image = external - gyroscopic - known + dot_6(phi, &shaken);
        }
        model.shake(rate, image);
        held.solve(&model.phi_r, image);

        let gain = self.parameters.velocity_gain;
        let mut moved = [0.0; 6];
        let modes = image.iter().zip(&self.iterate).zip(&self.u).zip(model.elastic.iter().zip(&model.phi_r));
        for (((image, old), q_dot), (mode, phi)) in modes {
            let change = gain * (image - old);
            at.correction += mode.mass * change * change;
            at.size += mode.mass * q_dot * q_dot;
            for (moved, phi) in moved.iter_mut().zip(phi) {
                *moved += phi * change;
            }
        }
        at.correction += dot_6(&moved, &mul6_symmetric(&model.rigid_mass, &moved));
        at.size += dot_6(beta_star, &mul6_symmetric(&model.rigid_mass, beta_star));
        Ok(())
    }
}

/// Writes the prescribed motion into `next`, whose modes are there already.
pub(super) fn finish_prescribed(
    model: &Model,
    motion: &PrescribedMotion,
    work: &mut Workspace,
    next: &mut State,
) {
    model.set_motion(next, motion);
    if let Some((q_ddot, beta_star_dot)) = next.u_dot.split_last_chunk_mut::<6>() {
        *beta_star_dot = model.own_velocity(&motion.rate, q_ddot);
    }
    start_algorithmic_rigid(model, next, work);
}

/// Motion of A at a fraction of a step, between the motions at its ends: cubic in the velocities, the attitude and the
/// position, with an error of fourth order.
pub(super) fn between(
    start: &PrescribedMotion,
    end: &PrescribedMotion,
    dt: f64,
    fraction: f64,
) -> PrescribedMotion {
    if fraction == 0.0 {
        return *start;
    }
    if fraction == 1.0 {
        return *end;
    }
    // Hermite's cubic: values and slopes at both ends.
    let (x, y) = (fraction, 1.0 - fraction);
    let value = [y * y * (1.0 + 2.0 * x), x * y * y * dt, x * x * (1.0 + 2.0 * y), -x * x * y * dt];
    let slope = [-6.0 * x * y / dt, y * (y - 2.0 * x), 6.0 * x * y / dt, x * (x - 2.0 * y)];
    let six = |w: [f64; 4]| -> Vec6 {
        let ends = start.velocity.iter().zip(&start.rate).zip(end.velocity.iter().zip(&end.rate));
        let mut out = [0.0; 6];
        for (out, ((v0, a0), (v1, a1))) in out.iter_mut().zip(ends) {
            *out = w[0] * v0 + w[1] * a0 + w[2] * v1 + w[3] * a1;
        }
        out
    };
    PrescribedMotion {
        velocity: six(value),
        rate: six(slope),
        attitude: attitude_between(start, end, &value),
        position: position_between(start, end, &value),
    }
}

fn attitude_between(start: &PrescribedMotion, end: &PrescribedMotion, weight: &[f64; 4]) -> [f64; 4] {
    let rate = |m: &PrescribedMotion| crate::equations::attitude_rate(m.attitude, split(&m.velocity).1);
    let (rate_0, rate_1) = (rate(start), rate(end));
    // A quaternion and its opposite are the same attitude.
    let same: f64 = start.attitude.iter().zip(&end.attitude).map(|(a, b)| a * b).sum();
    let sign = if same < 0.0 { -1.0 } else { 1.0 };
    let mut out = [0.0; 4];
    let ends = start.attitude.iter().zip(&rate_0).zip(end.attitude.iter().zip(&rate_1));
    for (out, ((a0, r0), (a1, r1))) in out.iter_mut().zip(ends) {
        *out = weight[0] * a0 + weight[1] * r0 + sign * (weight[2] * a1 + weight[3] * r1);
    }
    normalised(out)
}

fn position_between(start: &PrescribedMotion, end: &PrescribedMotion, weight: &[f64; 4]) -> [f64; 3] {
    let velocity = |m: &PrescribedMotion| mul(&matrix(normalised(m.attitude)), split(&m.velocity).0);
    let travelled = add(
        scale(weight[2], sub(end.position, start.position)),
        add(scale(weight[1], velocity(start)), scale(weight[3], velocity(end))),
    );
    axpy(start.position, 1.0, travelled)
}
