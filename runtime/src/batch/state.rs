//! The states of the instances of a chunk, number by number.

use alloc::{vec, vec::Vec};

use crate::math::{Vec3, Vec6};
use crate::real::{LANES, Lanes};
use crate::state::State;

/// As [`State`], one lane for each instance.
#[derive(Clone, Debug)]
pub(super) struct LaneState {
    pub(super) time: Lanes,
    pub(super) time_carry: Lanes,
    /// `q`, `u = (q_dot, beta*)`, `zeta`, `r_G` - (2 m + 13).
    pub(super) motion: Vec<Lanes>,
    pub(super) u_dot: Vec<Lanes>,
    pub(super) algorithmic: Vec<Lanes>,
    pub(super) accelerations_known: [bool; LANES],
}

/// A motion, or its rate, by its parts.
#[derive(Clone, Copy)]
pub(super) struct Motion<'a> {
    pub(super) q: &'a [Lanes],
    pub(super) u: &'a [Lanes],
    pub(super) q_dot: &'a [Lanes],
    pub(super) beta_star: &'a Vec6<Lanes>,
    pub(super) attitude: &'a [Lanes; 4],
    pub(super) position: &'a Vec3<Lanes>,
}

/// The same to be written to.
pub(super) struct MotionMut<'a> {
    pub(super) q: &'a mut [Lanes],
    pub(super) u: &'a mut [Lanes],
    pub(super) attitude: &'a mut [Lanes; 4],
    pub(super) position: &'a mut Vec3<Lanes>,
}

impl<'a> Motion<'a> {
    /// None where the length is none that a motion has.
    #[inline(always)]
    pub(super) fn of(values: &'a [Lanes]) -> Option<Self> {
        let m = values.len().checked_sub(13)? / 2;
        let (q, rest) = values.split_at_checked(m)?;
        let (u, rest) = rest.split_at_checked(m + 6)?;
        let (q_dot, beta_star) = u.split_last_chunk::<6>()?;
        let (attitude, rest) = rest.split_first_chunk::<4>()?;
        Some(Motion { q, u, q_dot, beta_star, attitude, position: rest.first_chunk::<3>()? })
    }
}

impl<'a> MotionMut<'a> {
    #[inline(always)]
    pub(super) fn of(values: &'a mut [Lanes]) -> Option<Self> {
        let m = values.len().checked_sub(13)? / 2;
        let (q, rest) = values.split_at_mut_checked(m)?;
        let (u, rest) = rest.split_at_mut_checked(m + 6)?;
        let (attitude, rest) = rest.split_first_chunk_mut::<4>()?;
        Some(MotionMut { q, u, attitude, position: rest.first_chunk_mut::<3>()? })
    }
}

impl LaneState {
    /// The same state in all lanes.
    pub(super) fn new(state: &State) -> Self {
        let (m, zero) = (state.q.len(), Lanes::default());
        let mut lanes = LaneState {
            time: zero,
            time_carry: zero,
            motion: vec![zero; 2 * m + 13],
            u_dot: vec![zero; m + 6],
            algorithmic: vec![zero; state.algorithmic.len()],
            accelerations_known: [false; LANES],
        };
        for lane in 0..LANES {
            lanes.set(lane, state);
        }
        lanes
    }

    /// Begins a step from `other`: its time, and nothing else.
    #[inline(always)]
    pub(super) fn take_time(&mut self, other: &LaneState) {
        (self.time, self.time_carry) = (other.time, other.time_carry);
    }

    /// Takes over the accelerations.
    #[inline(always)]
    pub(super) fn copy_accelerations(&mut self, other: &LaneState) {
        copy(&mut self.u_dot, &other.u_dot);
        copy(&mut self.algorithmic, &other.algorithmic);
    }

    /// Takes over the lanes chosen.
    pub(super) fn take(&mut self, chosen: &[bool; LANES], other: &LaneState) {
        self.time.take(chosen, &other.time);
        self.time_carry.take(chosen, &other.time_carry);
        let parts = [
            (&mut self.motion, &other.motion),
            (&mut self.u_dot, &other.u_dot),
            (&mut self.algorithmic, &other.algorithmic),
        ];
        for (to, from) in parts {
            to.iter_mut().zip(from).for_each(|(to, from)| to.take(chosen, from));
        }
        let known = self.accelerations_known.iter_mut().zip(&other.accelerations_known);
        for ((to, from), chosen) in known.zip(chosen) {
            *to = if *chosen { *from } else { *to };
        }
    }

    /// Puts an instance into its lane.
    pub(super) fn set(&mut self, lane: usize, state: &State) {
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
        } = state;
        self.time.set(lane, *time);
        self.time_carry.set(lane, *time_carry);
        let mut motion = self.motion.as_mut_slice();
        for part in [q.as_slice(), q_dot, beta_star, attitude, position] {
            motion = put(lane, part, motion);
        }
        put(lane, u_dot, &mut self.u_dot);
        put(lane, algorithmic, &mut self.algorithmic);
        if let Some(known) = self.accelerations_known.get_mut(lane) {
            *known = *accelerations_known;
        }
    }

    /// Copies an instance from its lane, into a state of the right lengths.
    pub(super) fn get(&self, lane: usize, state: &mut State) {
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
        } = state;
        *time = self.time.get(lane);
        *time_carry = self.time_carry.get(lane);
        let mut motion = self.motion.as_slice();
        for part in [q.as_mut_slice(), q_dot, beta_star, attitude, position] {
            motion = pick(lane, motion, part);
        }
        pick(lane, &self.u_dot, u_dot);
        pick(lane, &self.algorithmic, algorithmic);
        *accelerations_known = self.accelerations_known.get(lane).copied().unwrap_or(false);
    }

    /// As [`State::advance_time`].
    #[inline(always)]
    pub(super) fn advance_time(&mut self, dt: Lanes) {
        let increment = dt + self.time_carry;
        let time = self.time + increment;
        self.time_carry = increment - (time - self.time);
        self.time = time;
    }

    /// Which instances have a motion that is finite.
    #[inline(always)]
    pub(super) fn finite(&self) -> [bool; LANES] {
        let (mut sum, mut turned) = (Lanes::default(), Lanes::default());
        for x in &self.motion {
            sum += *x * *x * Lanes::default();
        }
        for x in Motion::of(&self.motion).map_or(&[Lanes::default(); 4], |motion| motion.attitude) {
            turned += *x * *x;
        }
        core::array::from_fn(|lane| sum.get(lane) == 0.0 && turned.get(lane) > 0.5)
    }
}

#[inline(always)]
pub(super) fn copy(to: &mut [Lanes], from: &[Lanes]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}

/// Puts numbers into a lane; what is left after them.
fn put<'a>(lane: usize, from: &[f64], to: &'a mut [Lanes]) -> &'a mut [Lanes] {
    let Some((to, rest)) = to.split_at_mut_checked(from.len()) else { return &mut [] };
    to.iter_mut().zip(from).for_each(|(to, from)| to.set(lane, *from));
    rest
}

/// Fills numbers from a lane; what is left after them.
fn pick<'a>(lane: usize, from: &'a [Lanes], to: &mut [f64]) -> &'a [Lanes] {
    let Some((from, rest)) = from.split_at_checked(to.len()) else { return &[] };
    to.iter_mut().zip(from).for_each(|(to, from)| *to = from.get(lane));
    rest
}
