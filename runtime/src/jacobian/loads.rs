//! Generalised loads and their slopes: [`crate::loading::generalised_loads`] in numbers that carry slopes.

use alloc::{vec, vec::Vec};

use crate::forward::{Forward, ForwardVariables};
use crate::loading::{Acting, Wrench, nodal_forces, whole_curve};
use crate::math::Mat3;
use crate::model::Model;
use crate::polynomial::Jet;

/// Scratch for the loads of one evaluation.
#[derive(Clone, Debug)]
pub(super) struct ForwardLoads {
    wrenches: Vec<Wrench<Forward>>,
    displacement: Vec<Forward>,
    force: Vec<Forward>,
    jets: Vec<Jet<Forward>>,
}

impl ForwardLoads {
    pub(super) fn new(model: &Model) -> Self {
        let n = model.n_carriers();
        ForwardLoads {
            wrenches: vec![Wrench::default(); n],
            displacement: vec![Forward::default(); 6 * n],
            force: vec![Forward::default(); 6 * n + 6],
            jets: whole_curve(model).jets(),
        }
    }

    /// Elastic and rigid rows into `external` - (m + 6).
    pub(super) fn evaluate(
        &mut self,
        loads: &Acting,
        variables: &ForwardVariables,
        q: &[Forward],
        attitude: &Mat3<Forward>,
        external: &mut [Forward],
    ) {
        let map = loads.map();
        let (Some(wrenches), Some(displacement), Some(force), Some((elastic, rigid))) = (
            self.wrenches.get_mut(..map.slots.len()),
            self.displacement.get_mut(..map.n_dof),
            self.force.get_mut(..map.n_dof + 6),
            external.split_at_mut_checked(q.len()),
        ) else {
            return;
        };
        wrenches.fill(Wrench::default());
        loads.gather_forward(variables, wrenches);
        map.displacement.apply(q, displacement);
        if !map.polynomial.is_empty() {
            map.polynomial.prepare(q, q, &mut self.jets);
            map.polynomial.values(&self.jets, displacement);
        }
        let mut resultant = nodal_forces(&map.slots, wrenches, attitude, displacement, force);
        elastic.fill(Forward::default());
        for forces in loads.projected() {
            forces.add(forces.time().along(variables), attitude, q, elastic, &mut resultant);
        }
        let direct = loads.direct().map(|direct| (direct, direct.on_frame_a(attitude, q)));
        if let Some((_, on_a)) = &direct {
            resultant.iter_mut().zip(on_a.resultant).for_each(|(sum, x)| *sum += x);
        }
        if let Some(last) = force.last_chunk_mut::<6>() {
            *last = resultant;
        }
        map.projection.add(force, elastic);
        if !map.polynomial.is_empty() {
            map.polynomial.pull_back(&mut self.jets, force, elastic);
        }
        if let Some((direct, on_a)) = &direct {
            direct.add_to_modes(on_a, elastic);
        }
        for (rigid, resultant) in rigid.iter_mut().zip(resultant) {
            *rigid = resultant;
        }
    }
}
