//! What the modes miss of the motion under the loads. Deflections are those of modes that answer statically; how they move A is told as if all
//! of them had the frequency of the first that is missing, so that loads that begin suddenly are seen.

use alloc::{vec, vec::Vec};

use super::defect::NodeLoad;
use super::propagate::Oscillator;
use super::{Body, gather};
use crate::expression::Variables;
use crate::loading::Wrench;
use crate::loading::sealed::Acts;
use crate::loads::LoadCase;
use crate::math::{Vec6, add, cross, dot_6, join, matrix, mul, split, sub, sub_6};
use crate::model::Model;

/// Residual flexibility between points, and what of it is in the shape of a loaded equilibrium.
#[derive(Clone, Debug)]
pub(super) struct Missing {
    /// Index among the loaded ones of the model - (points).
    slots: Vec<Option<usize>>,
    /// Part of the equilibrium's own loads - (points), and of the motion of A.
    at_rest: Vec<Vec6>,
    rigid_at_rest: Vec6,
    /// Square of the frequency of the first mode that is missing, and the oscillator of it; none where none is.
    oscillator: Option<(f64, Oscillator)>,
    interval: f64,
    /// Integral of the velocity of A, and that velocity: `(v, w)` in A.
    moved: [f64; 6],
    velocity: [f64; 6],
    /// What drives it at the last instant.
    source: Option<Vec6>,
}

impl Missing {
    /// Looked at in such intervals.
    pub(super) fn new(full: &Model, interval: f64) -> Self {
        let n = full.n_points();
        let loaded = full.data().validity.iter().flat_map(|validity| &validity.missing.loaded);
        let mut slots = vec![None; n];
        for (slot, &point) in loaded.enumerate() {
            if let Some(place) = slots.get_mut(point as usize) {
                *place = Some(slot);
            }
        }
        let modes = &full.data().modes;
        // Of the same damping as the last that is there.
        let ratio = modes.damping_ratio.last().copied().unwrap_or(0.0);
        let oscillator =
            modes.next_omega.map(|omega| (omega * omega, Oscillator::new(omega, ratio, interval)));
        let mut this = Missing {
            slots,
            at_rest: vec![[0.0; 6]; n],
            rigid_at_rest: [0.0; 6],
            oscillator,
            interval,
            moved: [0.0; 6],
            velocity: [0.0; 6],
            source: None,
        };
        if let Some((at_rest, rigid)) = this.under_the_equilibrium(full) {
            (this.at_rest, this.rigid_at_rest) = (at_rest, rigid);
        }
        this
    }

    /// Begins again.
    pub(super) fn reset(&mut self) {
        (self.moved, self.velocity, self.source) = ([0.0; 6], [0.0; 6], None);
    }

    /// The same under the loads of the equilibrium alone, undeformed from it; none where there is no equilibrium.
    fn under_the_equilibrium(&self, full: &Model) -> Option<(Vec<Vec6>, Vec6)> {
        let trim = full.data().trim.as_ref()?;
        let loads = full.prepare(&LoadCase::empty("equilibrium")).ok()?;
        let n = full.n_carriers();
        let (mut wrenches, mut nodes) = (vec![Wrench::default(); n], vec![NodeLoad::default(); n]);
        let attitude = matrix(trim.attitude);
        let q = vec![0.0; full.n_modes()];
        let n = gather(
            full,
            loads.acting(),
            &Variables::default(),
            &attitude,
            &q,
            &mut wrenches,
            &mut nodes,
            &mut Body::default(),
        );
        let nodes = nodes.get(..n)?;
        let points = (0..full.n_points()).map(|index| self.under(full, index, nodes)).collect();
        Some((points, self.moving_a(full, nodes)))
    }

    /// Velocity of A in the missing motion, in A, at the next instant under these loads.
    pub(super) fn advance(&mut self, full: &Model, loads: &[NodeLoad]) -> Vec6 {
        let Some((omega2, oscillator)) = self.oscillator else { return [0.0; 6] };
        let source = sub_6(&self.moving_a(full, loads), &self.rigid_at_rest).map(|x| omega2 * x);
        if let Some(before) = self.source {
            let ends = before.into_iter().zip(source);
            for ((moved, velocity), (s_0, s_1)) in self.moved.iter_mut().zip(&mut self.velocity).zip(ends) {
                oscillator.advance(self.interval, [s_0, s_1], moved, velocity);
            }
        }
        self.source = Some(source);
        self.velocity
    }

    /// Missing motion of the node of a point, over that in the equilibrium: translation in A, rotation in the node frame.
    pub(super) fn at(&self, full: &Model, index: usize, loads: &[NodeLoad]) -> Vec6 {
        let rest = self.at_rest.get(index).copied().unwrap_or_default();
        let now = self.under(full, index, loads);
        core::array::from_fn(|k| now.get(k).unwrap_or(&0.0) - rest.get(k).unwrap_or(&0.0))
    }

    /// What the loads lack, as a defect: on the missing deflection their points are elsewhere, and those that turn with the body or its
    /// nodes turn on. Force and moment about the origin of A, in A.
    pub(super) fn wrench(&self, full: &Model, loads: &[NodeLoad]) -> Vec6 {
        // A, against the axes in which momentum is that of the model.
        let (shift, turn) = split(&sub_6(&self.moving_a(full, loads), &self.rigid_at_rest));
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        for load in loads {
            let Some(point) = full.points.get(load.point) else { continue };
            let (t, theta) = split(&self.at(full, load.point, loads));
            let node_turn = add(turn, mul(&point.node_rotation, theta));
            let arm = mul(&point.node_rotation, point.offset);
            let place = add(point.node_position, arm);
            let moved = add(add(t, shift), add(cross(turn, point.node_position), cross(node_turn, arm)));
            for ((f, m), turn) in load.applied.iter().zip([[0.0; 3], turn, node_turn]) {
                let turned = cross(turn, *f);
                force = sub(force, turned);
                moment = sub(moment, add(add(cross(moved, *f), cross(place, turned)), cross(turn, *m)));
            }
        }
        join(force, moment)
    }

    fn under(&self, full: &Model, index: usize, loads: &[NodeLoad]) -> Vec6 {
        let blocks = full.data().validity.as_ref().map_or(&[][..], |it| &it.missing.flexibility);
        self.sum(blocks, |slot| slot * self.slots.len() + index, loads)
    }

    /// Integral of the velocity of A that goes with the static response.
    fn moving_a(&self, full: &Model, loads: &[NodeLoad]) -> Vec6 {
        let blocks = full.data().validity.as_ref().map_or(&[][..], |it| &it.missing.rigid);
        self.sum(blocks, |slot| slot, loads)
    }

    /// Sum over the loads of the 6 x 6 block of each.
    fn sum(&self, blocks: &[f64], block: impl Fn(usize) -> usize, loads: &[NodeLoad]) -> Vec6 {
        let mut sum = [0.0; 6];
        for load in loads {
            let Some(&Some(slot)) = self.slots.get(load.point) else { continue };
            let start = 36 * block(slot);
            let Some(block) = blocks.get(start..start + 36) else { continue };
            let load = join(load.force, load.moment);
            for (sum, row) in sum.iter_mut().zip(block.as_chunks::<6>().0) {
                *sum += dot_6(row, &load);
            }
        }
        sum
    }
}
