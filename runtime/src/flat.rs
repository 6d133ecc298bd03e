//! The state as one row of numbers, for hosts that do not share our types: other languages, files, FMUs.

use core::ops::Range;

use crate::integrator::algorithmic;
use crate::model::Model;
use crate::state::State;

/// Where the parts of a [`State`] are in its flat form.
///
/// All of [`State`] is in it, so that a simulation restored from a flat copy goes on with the same bits. The first
/// `2 m + 15` numbers are the physical state; the rest is what the implicit integrators carry from step to step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlatLayout {
    /// Time, s.
    pub time: usize,
    /// What rounding has taken from the time, s.
    pub time_carry: usize,
    /// Modal amplitudes - (m).
    pub q: Range<usize>,
    /// Modal rates, 1/s - (m).
    pub q_dot: Range<usize>,
    /// Rigid part of the velocity of A, in A, m/s and rad/s - (6).
    pub beta_star: Range<usize>,
    /// Attitude quaternion, scalar first - (4).
    pub attitude: Range<usize>,
    /// Position of the origin of A in G, m - (3).
    pub position: Range<usize>,
    /// 1 when the last two parts belong to the rest, 0 when the next step has to solve them anew.
    pub accelerations_known: usize,
    /// Accelerations - (m + 6).
    pub u_dot: Range<usize>,
    /// Auxiliary variable of the generalised-alpha method - (m + 6), with consistent inertia (2 m + 27): see
    /// [`State::algorithmic`].
    pub algorithmic: Range<usize>,
}

impl FlatLayout {
    /// For states with so many modes and so many auxiliary variables.
    fn new(m: usize, algorithmic: usize) -> Self {
        let mut end = 2;
        let mut part = |length: usize| {
            let start = end;
            end += length;
            start..end
        };
        FlatLayout {
            time: 0,
            time_carry: 1,
            q: part(m),
            q_dot: part(m),
            beta_star: part(6),
            attitude: part(4),
            position: part(3),
            accelerations_known: part(1).start,
            u_dot: part(m + 6),
            algorithmic: part(algorithmic),
        }
    }

    /// Length of the whole row.
    pub fn size(&self) -> usize {
        self.algorithmic.end
    }
}

impl Model {
    /// Layout of the flat form of this model's states.
    pub fn flat_layout(&self) -> FlatLayout {
        FlatLayout::new(self.n_modes(), algorithmic::length(self))
    }
}

impl State {
    /// Layout of the flat form of this state.
    pub fn flat_layout(&self) -> FlatLayout {
        FlatLayout::new(self.q.len(), self.algorithmic.len())
    }

    /// Copies the state into `flat`; false (and nothing done) unless it has the length of [`Model::flat_layout`]. Does
    /// not allocate.
    #[must_use]
    pub fn write_flat(&self, flat: &mut [f64]) -> bool {
        // Every field by name: a new one must find its place here.
        let State {
            time,
            time_carry,
            q,
            q_dot,
            beta_star,
            attitude,
            position,
            u_dot,
            algorithmic,
            accelerations_known,
        } = self;
        if flat.len() != self.flat_layout().size() {
            return false;
        }
        let known = f64::from(u8::from(*accelerations_known));
        let (time, known) = ([*time, *time_carry], [known]);
        let parts: [&[f64]; 9] = [&time, q, q_dot, beta_star, attitude, position, &known, u_dot, algorithmic];
        for (to, from) in flat.iter_mut().zip(parts.into_iter().flatten()) {
            *to = *from;
        }
        true
    }

    /// Copies `flat` into the state, without looking at its numbers ([`State::check`] does, as does
    /// [`crate::Simulation::restore`]); false (and nothing done) unless the length is that of this state. Does not allocate.
    #[must_use]
    pub fn read_flat(&mut self, flat: &[f64]) -> bool {
        if flat.len() != self.flat_layout().size() {
            return false;
        }
        let (mut time, mut known) = ([0.0; 2], [0.0]);
        let parts: [&mut [f64]; 9] = [
            &mut time,
            &mut self.q,
            &mut self.q_dot,
            &mut self.beta_star,
            &mut self.attitude,
            &mut self.position,
            &mut known,
            &mut self.u_dot,
            &mut self.algorithmic,
        ];
        for (to, from) in parts.into_iter().flatten().zip(flat) {
            *to = *from;
        }
        [self.time, self.time_carry] = time;
        self.accelerations_known = known != [0.0];
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_flat_form_holds_the_whole_state_where_the_layout_says() {
        let m = 3;
        let layout = FlatLayout::new(m, m + 6);
        let flat: Vec<f64> = (0..layout.size()).map(|i| i as f64 + 1.0).collect();
        let mut state = State {
            time: 0.0,
            time_carry: 0.0,
            q: vec![0.0; m],
            q_dot: vec![0.0; m],
            beta_star: [0.0; 6],
            attitude: [1.0, 0.0, 0.0, 0.0],
            position: [0.0; 3],
            u_dot: vec![0.0; m + 6],
            algorithmic: vec![0.0; m + 6],
            accelerations_known: false,
        };
        let mut back = flat.clone();
        assert!(!state.read_flat(&flat[1..]) && !state.write_flat(&mut back[1..]));
        assert!(state.read_flat(&flat));
        assert_eq!((state.time, state.time_carry), (flat[layout.time], flat[layout.time_carry]));
        assert_eq!((&state.q[..], &state.q_dot[..]), (&flat[layout.q], &flat[layout.q_dot]));
        assert_eq!(
            (&state.beta_star[..], &state.attitude[..]),
            (&flat[layout.beta_star], &flat[layout.attitude])
        );
        assert_eq!((&state.position[..], &state.u_dot[..]), (&flat[layout.position], &flat[layout.u_dot]));
        assert_eq!((&state.algorithmic[..], state.accelerations_known), (&flat[layout.algorithmic], true));
        assert!(state.write_flat(&mut back));
        let known = layout.accelerations_known;
        assert_eq!(back[known], 1.0);
        back[known] = flat[known];
        assert_eq!(back, flat);
    }
}
