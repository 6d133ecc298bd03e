//! Where a load case starts: motion of frame A, modal amplitudes, a static shape.

use alloc::{format, string::String, vec::Vec};

use crate::error::ModelError;
use crate::loading::sealed::Acts;
use crate::loads::{InitialState, LoadCase};
use crate::math::{add, combine, cross, join, matrix, mul, mul_t, normalised, scale, split, sub};
use crate::model::{Model, unknown};
use crate::state::State;
use crate::validate;

impl Model {
    /// The state in which a load case starts ([`LoadCase::initial`], and the velocities that [`LoadCase::motion`] has then): at rest in
    /// the equilibrium where it says nothing else.
    ///
    /// # Errors
    /// What is wrong with the case; amplitudes of modes that this model does not have, unless it has none; loads of a static shape that
    /// the structure cannot carry.
    pub fn initial_state(&self, case: &LoadCase) -> Result<State, ModelError> {
        validate::load_case(case, self.n_points(), &self.data().lines)?;
        let mut state = State::at_rest(self);
        let rest = InitialState::default();
        let initial = case.initial.as_ref().unwrap_or(&rest);
        if let Some(attitude) = initial.attitude {
            state.attitude = normalised(attitude);
        }
        if !initial.shape.is_empty() || !initial.shape_distributed.is_empty() {
            state.q = self.static_shape(initial, &state)?;
        }
        for (values, into) in [(&initial.amplitudes, &mut state.q), (&initial.rates, &mut state.q_dot)] {
            self.set_modal(values, into)?;
        }
        self.start_frame(initial, &mut state);
        if let Some(base) = self.base_of(self.prepare(case)?.acting()) {
            let motion = base.at(&self.motion_of(&state), state.time);
            state.beta_star = self.own_velocity(&motion.velocity, &state.q_dot);
        }
        Ok(state)
    }

    /// Adds values given by mode number to those of the modes kept.
    fn set_modal(&self, values: &[f64], into: &mut [f64]) -> Result<(), ModelError> {
        let numbers = &self.data().modes.number;
        for (index, value) in values.iter().enumerate() {
            let number = index as u32 + 1;
            let place = numbers.iter().position(|n| *n == number).and_then(|i| into.get_mut(i));
            match place {
                Some(place) => *place += value,
                // A rigid body has no amplitudes to start with.
                None if *value == 0.0 || numbers.is_empty() => {}
                None => {
                    let names: Vec<String> = numbers.iter().map(|n| format!("{n}")).collect();
                    return Err(unknown("elastic mode", &format!("{number}"), names.iter()));
                }
            }
        }
        Ok(())
    }

    /// Position and velocity of A.
    fn start_frame(&self, initial: &InitialState, state: &mut State) {
        let attitude = matrix(state.attitude);
        let in_a = |x: Option<[f64; 3]>| {
            let x = x.unwrap_or_default();
            if initial.inertial { mul_t(&attitude, x) } else { x }
        };
        let (v, w) = (in_a(initial.velocity), in_a(initial.angular_velocity));
        let Some(relative) = &self.relative else {
            if let Some(position) = initial.position {
                state.position = position;
            }
            state.beta_star = self.own_velocity(&join(v, w), &state.q_dot);
            return;
        };
        // The state is about the centre of mass; A sits on the reference node, which moves in the modes.
        let (shift, rate) = (combine(&relative.phi_r, &state.q), combine(&relative.phi_r, &state.q_dot));
        // The rigid body turns by what the modes do not.
        let w = sub(w, split(&rate).1);
        let drawn = sub(
            self.data().rigid.initial_position,
            mul(&matrix(self.initial_attitude()), scale(-1.0, relative.origin)),
        );
        let origin = add(relative.origin, split(&shift).0);
        state.position = sub(initial.position.unwrap_or(drawn), mul(&attitude, origin));
        state.beta_star = join(sub(v, add(cross(w, origin), split(&rate).0)), w);
    }
}
