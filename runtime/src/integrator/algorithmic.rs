//! Layout of [`State::algorithmic`](crate::State::algorithmic): what implicit steps carry from one to the next beside the accelerations.

use crate::model::Model;

/// Numbers of a [`LoadedMomentum`](super::consistent::LoadedMomentum).
pub(super) const LOADED: usize = 15;

/// The parts of it, in their order. The last two are empty unless the inertia of the model is consistent.
pub(crate) struct Algorithmic<T> {
    /// Auxiliary accelerations of the modes - (m).
    pub(crate) modes: T,
    /// Auxiliary inertial rate of momentum and of moment of momentum about the centre of mass, in A - (6).
    pub(crate) rigid: T,
    /// These momenta, their true rates and the centre of mass, in A - (15).
    pub(crate) loaded: T,
    /// Change of `u_dot` in the last step, zero at the start of a motion - (m + 6).
    pub(crate) change: T,
}

/// Length of all parts.
pub(crate) fn length(model: &Model) -> usize {
    let n = model.n_modes() + 6;
    if model.lagrangian.is_some() { n + LOADED + n } else { n }
}

impl<'a, T> Algorithmic<&'a [T]> {
    /// Of a state of `m` modes.
    #[inline(always)]
    pub(crate) fn of(mut numbers: &'a [T], m: usize) -> Self {
        let mut part = |length: usize| numbers.split_off(..length).unwrap_or_default();
        Algorithmic { modes: part(m), rigid: part(6), loaded: part(LOADED), change: part(m + 6) }
    }
}

impl<'a, T> Algorithmic<&'a mut [T]> {
    /// Of a state of `m` modes, to be written.
    #[inline(always)]
    pub(crate) fn of_mut(mut numbers: &'a mut [T], m: usize) -> Self {
        let mut part = |length: usize| numbers.split_off_mut(..length).unwrap_or_default();
        Algorithmic { modes: part(m), rigid: part(6), loaded: part(LOADED), change: part(m + 6) }
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    #[test]
    fn the_parts_follow_each_other_and_leave_nothing() {
        let m = 3;
        let mut numbers: Vec<usize> = (0..2 * m + 27).collect();
        let all = numbers.clone();
        let Algorithmic { modes, rigid, loaded, change } = Algorithmic::of(&numbers, m);
        assert_eq!([modes.len(), rigid.len(), loaded.len(), change.len()], [m, 6, 15, m + 6]);
        assert_eq!([modes, rigid, loaded, change].concat(), all);
        let Algorithmic { modes, rigid, loaded, change } = Algorithmic::of_mut(&mut numbers, m);
        assert_eq!([modes, rigid, loaded, change].concat(), all);
        let constant = Algorithmic::of(&all[..m + 6], m);
        assert_eq!((constant.rigid, constant.loaded.len(), constant.change.len()), (&all[m..m + 6], 0, 0));
    }
}
