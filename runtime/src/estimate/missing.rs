//! What the modes miss of the deflection under the loads: modes that are not in the model answer statically.

use alloc::{vec, vec::Vec};

use super::defect::NodeLoad;
use super::{Body, gather};
use crate::expression::Variables;
use crate::loading::Wrench;
use crate::loading::sealed::Acts;
use crate::loads::LoadCase;
use crate::math::{Vec6, dot_6, join, matrix};
use crate::model::Model;

/// Residual flexibility between points, and what of it is in the shape of a loaded equilibrium.
#[derive(Clone, Debug)]
pub(super) struct Missing {
    /// Index among the loaded ones of the model - (points).
    slots: Vec<Option<usize>>,
    /// Part of the equilibrium's own loads - (points).
    at_rest: Vec<Vec6>,
}

impl Missing {
    pub(super) fn new(full: &Model) -> Self {
        let n = full.n_points();
        let loaded = full.data().validity.iter().flat_map(|validity| &validity.missing.loaded);
        let mut slots = vec![None; n];
        for (slot, &point) in loaded.enumerate() {
            if let Some(place) = slots.get_mut(point as usize) {
                *place = Some(slot);
            }
        }
        let mut this = Missing { slots, at_rest: vec![[0.0; 6]; n] };
        this.at_rest = this.under_the_equilibrium(full).unwrap_or(this.at_rest);
        this
    }

    /// The same under the loads of the equilibrium alone, undeformed from it; none where there is no equilibrium.
    fn under_the_equilibrium(&self, full: &Model) -> Option<Vec<Vec6>> {
        let trim = full.data().trim.as_ref()?;
        let loads = full.prepare(&LoadCase::empty("equilibrium")).ok()?;
        let n = full.n_points();
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
        Some((0..full.n_points()).map(|index| self.under(full, index, nodes)).collect())
    }

    /// Missing motion of the node of a point, over that in the equilibrium: translation in A, rotation in the node frame.
    pub(super) fn at(&self, full: &Model, index: usize, loads: &[NodeLoad]) -> Vec6 {
        let rest = self.at_rest.get(index).copied().unwrap_or_default();
        let now = self.under(full, index, loads);
        core::array::from_fn(|k| now.get(k).unwrap_or(&0.0) - rest.get(k).unwrap_or(&0.0))
    }

    fn under(&self, full: &Model, index: usize, loads: &[NodeLoad]) -> Vec6 {
        let mut sum = [0.0; 6];
        let Some(validity) = &full.data().validity else { return sum };
        for load in loads {
            let Some(&Some(slot)) = self.slots.get(load.point) else { continue };
            let start = 36 * (slot * self.slots.len() + index);
            let Some(block) = validity.missing.flexibility.get(start..start + 36) else { continue };
            let load = join(load.force, load.moment);
            for (sum, row) in sum.iter_mut().zip(block.as_chunks::<6>().0) {
                *sum += dot_6(row, &load);
            }
        }
        sum
    }
}
