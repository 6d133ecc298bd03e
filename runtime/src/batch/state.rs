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
    pub(super) q: Vec<Lanes>,
    pub(super) q_dot: Vec<Lanes>,
    pub(super) beta_star: Vec6<Lanes>,
    pub(super) attitude: [Lanes; 4],
    pub(super) position: Vec3<Lanes>,
    pub(super) u_dot: Vec<Lanes>,
    pub(super) algorithmic: Vec<Lanes>,
    pub(super) accelerations_known: [bool; LANES],
}

impl LaneState {
    /// All instances in one state.
    pub(super) fn new(state: &State) -> Self {
        let m = state.q.len();
        let zero = Lanes::default();
        let mut lanes = LaneState {
            time: zero,
            time_carry: zero,
            q: vec![zero; m],
            q_dot: vec![zero; m],
            beta_star: [zero; 6],
            attitude: [zero; 4],
            position: [zero; 3],
            u_dot: vec![zero; m + 6],
            algorithmic: vec![zero; state.algorithmic.len()],
            accelerations_known: [false; LANES],
        };
        for lane in 0..LANES {
            lanes.set(lane, state);
        }
        lanes
    }

    /// All numbers, in a fixed order.
    #[inline(always)]
    fn numbers_mut(&mut self) -> impl Iterator<Item = &mut Lanes> {
        let LaneState {
            time,
            time_carry,
            q,
            q_dot,
            beta_star,
            attitude,
            position,
            u_dot,
            algorithmic,
            accelerations_known: _,
        } = self;
        let rigid = beta_star.iter_mut().chain(attitude).chain(position);
        [time, time_carry].into_iter().chain(q).chain(q_dot).chain(rigid).chain(u_dot).chain(algorithmic)
    }

    #[inline(always)]
    fn numbers(&self) -> impl Iterator<Item = &Lanes> {
        let rigid = self.beta_star.iter().chain(&self.attitude).chain(&self.position);
        let modal = self.q.iter().chain(&self.q_dot);
        let accelerations = self.u_dot.iter().chain(&self.algorithmic);
        [&self.time, &self.time_carry].into_iter().chain(modal).chain(rigid).chain(accelerations)
    }

    /// Copies without allocating.
    #[inline(always)]
    pub(super) fn copy_from(&mut self, other: &LaneState) {
        for (to, from) in self.numbers_mut().zip(other.numbers()) {
            *to = *from;
        }
        self.accelerations_known = other.accelerations_known;
    }

    /// Takes over the lanes chosen.
    #[inline(always)]
    pub(super) fn take(&mut self, chosen: &[bool; LANES], other: &LaneState) {
        for (to, from) in self.numbers_mut().zip(other.numbers()) {
            to.take(chosen, from);
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
        let rigid = beta_star.iter().chain(attitude).chain(position);
        let values = [time, time_carry].into_iter().chain(q).chain(q_dot).chain(rigid);
        for (to, from) in self.numbers_mut().zip(values.chain(u_dot).chain(algorithmic)) {
            to.set(lane, *from);
        }
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
        let rigid = beta_star.iter_mut().chain(attitude).chain(position);
        let values = [time, time_carry].into_iter().chain(q).chain(q_dot).chain(rigid);
        for (to, from) in values.chain(u_dot).chain(algorithmic).zip(self.numbers()) {
            *to = from.get(lane);
        }
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
        let mut sum = Lanes::default();
        let rigid = self.beta_star.iter().chain(&self.attitude).chain(&self.position);
        for x in self.q.iter().chain(&self.q_dot).chain(rigid) {
            sum += *x * *x * Lanes::default();
        }
        let mut turned = Lanes::default();
        for x in &self.attitude {
            turned += *x * *x;
        }
        core::array::from_fn(|lane| sum.get(lane) == 0.0 && turned.get(lane) > 0.5)
    }
}
