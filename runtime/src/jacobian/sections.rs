//! Section forces along a direction, and what loads add to them.

use alloc::{vec, vec::Vec};

use super::outputs::first;
use super::{Direction, Jacobian, Parts};
use crate::equations::check_loads;
use crate::error::StepError;
use crate::expression::Variables;
use crate::forward::{Forward, ForwardVariables};
use crate::internal_loads::{At, Scratch, SectionForces, by_loads, by_modes, by_summation};
use crate::loading::Loads;
use crate::math::{matrix, mul_t, split};
use crate::model::Model;
use crate::point_motion::Moving;
use crate::projected::Projected;
use crate::real::Real;
use crate::state::true_velocity;

/// Scratch for section forces.
#[derive(Clone, Debug)]
pub(super) struct Sections {
    forward: Scratch<Forward>,
    values: Scratch<f64>,
    u: Vec<Forward>,
    u_dot: Vec<Forward>,
}

impl Sections {
    pub(super) fn new(model: &Model) -> Self {
        let n = model.n_modes() + 6;
        Sections {
            forward: Scratch::new(model),
            values: Scratch::new(model),
            u: vec![Forward::default(); n],
            u_dot: vec![Forward::default(); n],
        }
    }
}

impl Jacobian {
    /// Derivative of the section forces at the places of internal loads along a direction at the state evaluated last, under the loads
    /// that act there, into `out` - (places). Does not allocate.
    ///
    /// # Errors
    /// [`StepError::ForeignLoads`] when the loads were prepared for another model.
    pub fn section_forces<L: Loads + ?Sized>(
        &mut self,
        along: Direction<'_>,
        loads: &L,
        out: &mut [SectionForces],
    ) -> Result<(), StepError> {
        let loads = loads.acting();
        let Jacobian { model, parts, sections: work } = self;
        check_loads(model, loads)?;
        let (t, gravity) = (parts.state.time, parts.work.gravity);
        let with_slope = |value: &f64, slope: &f64| {
            let mut x = Forward::of(*value);
            x.seed(0, *slope);
            x
        };
        let slopes = along.u_dot.iter().chain(core::iter::repeat(&0.0));
        for (to, (value, slope)) in work.u_dot.iter_mut().zip(parts.u_dot.iter().zip(slopes)) {
            *to = with_slope(value, slope);
        }
        let moving = parts.moving(model, along);
        let attitude = matrix(moving.attitude);
        let (v_a, w_a) = split(&moving.beta);
        let variables = ForwardVariables { t, v_a, w_a, r_g: moving.position };
        if let Some(slots) = work.forward.slots(loads) {
            loads.gather_forward(&variables, slots);
        }
        work.forward.place(model, loads, &attitude, moving.q);
        rates_of(model, &moving, &mut work.u);
        let at = At {
            q: moving.q,
            q_dot: moving.q_dot,
            u: &work.u,
            u_dot: &work.u_dot,
            beta: moving.beta,
            gravity: mul_t(&attitude, gravity.map(Forward::of)),
            attitude,
        };
        let factor = |forces: &Projected| forces.time().along(&variables);
        for (index, (cut, out)) in model.data().cuts.iter().zip(out).enumerate() {
            let modes = by_modes(cut, at.q, at.q_dot);
            let best = match &cut.summation {
                None => modes,
                Some(summation) => by_summation(summation, index, &at, loads, &work.forward, factor),
            };
            *out = SectionForces { best: best.map(first), by_modes: modes.map(first) };
        }
        Ok(())
    }

    /// What loads add to the section forces at the state evaluated last, its accelerations held, into `out` - (places): they enter
    /// linearly. With the change of the accelerations ([`Jacobian::by_load`]) in [`Jacobian::section_forces`] this is the derivative by
    /// a factor on the loads. Does not allocate.
    ///
    /// # Errors
    /// [`StepError::ForeignLoads`] when the loads were prepared for another model.
    pub fn section_forces_of_load<L: Loads + ?Sized>(
        &mut self,
        loads: &L,
        out: &mut [SectionForces],
    ) -> Result<(), StepError> {
        let loads = loads.acting();
        let Jacobian { model, parts: Parts { state, .. }, sections: Sections { values, .. } } = self;
        check_loads(model, loads)?;
        let (v_a, w_a) = split(&model.velocity(state));
        let variables = Variables { t: state.time, v_a, w_a, r_g: state.position };
        let attitude = matrix(state.attitude);
        if let Some(slots) = values.slots(loads) {
            loads.gather(&variables, slots);
        }
        values.place(model, loads, &attitude, &state.q);
        let factor = |forces: &Projected| forces.time().value(&variables);
        for (index, (cut, out)) in model.data().cuts.iter().zip(out).enumerate() {
            // Strains do not know what loads them.
            *out = SectionForces::default();
            if let Some(summation) = &cut.summation {
                out.best = by_loads(summation, index, &attitude, loads, values, factor);
            }
        }
        Ok(())
    }
}

/// `(q_dot, beta*)` from the true velocity.
fn rates_of(model: &Model, moving: &Moving<'_, Forward>, u: &mut [Forward]) {
    let Some((rates, rigid)) = u.split_last_chunk_mut::<6>() else { return };
    rates.iter_mut().zip(moving.q_dot).for_each(|(to, from)| *to = *from);
    let moved = true_velocity(&model.phi_r, moving.q_dot, &[Forward::default(); 6]);
    for ((to, beta), moved) in rigid.iter_mut().zip(moving.beta).zip(moved) {
        *to = beta - moved;
    }
}
