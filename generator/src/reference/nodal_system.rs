//! Residual and tangent of the nonlinear method, added up element by element.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::motion::Motion;
use crate::assembly::BlockMatrix;
use crate::element::beam::{Beam, BeamState};
use crate::element::inertia_force::{
    NodeAction, RateFactors, SectionMotion, inertia_force, inertia_force_and_tangent,
};
use crate::element::internal_force::{
    ElementMatrix, Stresses, force_of_stresses, internal_force, spin_tangent, stack, stiffness_of_stresses,
    stresses, to_increments,
};
use crate::element::viscous::{viscous_matrix, viscous_stresses};
use crate::mesh::LumpedMass;

/// Residual and, where asked, tangent of all nodes.
pub(super) struct System {
    pub(super) residual: Vec<Vector6<f64>>,
    pub(super) tangent: BlockMatrix,
}

/// Section forces of the strains and, where these are damped, of their rates.
fn damped_stresses<const N: usize>(beam: &Beam<N>, state: &BeamState<N>, motion: &Motion) -> Stresses {
    let origin = motion.velocity[beam.nodes[0]];
    let rates = beam.nodes.map(|n| stack(&(motion.velocity[n] - origin), &motion.spin[n]));
    let [a, b] = stresses(beam, state);
    let [c, d] = viscous_stresses(beam, state, &rates);
    [a + c, b + d]
}

/// Elastic and viscous forces on the nodes of an element.
fn elastic_force<const N: usize>(beam: &Beam<N>, state: &BeamState<N>, motion: &Motion) -> [Vector6<f64>; N] {
    if beam.is_viscous() {
        return force_of_stresses(beam, state, &damped_stresses(beam, state, motion));
    }
    internal_force(beam, state).force
}

/// The same with their tangent in the increments of the step. The turning of the strain operator under the rates is left out: it
/// is smaller than what is there by the rotation of a step, and Newton's iteration corrects for it.
fn elastic_tangent<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    motion: &Motion,
    factors: RateFactors,
    tangential: &[Matrix3<f64>; N],
) -> ([Vector6<f64>; N], ElementMatrix<N>) {
    if !beam.is_viscous() {
        let (elastic, k) = spin_tangent(beam, state, tangential);
        return (elastic.force, k);
    }
    let total = damped_stresses(beam, state, motion);
    let mut k = stiffness_of_stresses(beam, state, &total);
    to_increments(&mut k, tangential);
    for (row, viscous) in k.iter_mut().zip(viscous_matrix(beam, state)) {
        row.iter_mut().zip(viscous).for_each(|(block, d)| *block += d * factors.velocity);
    }
    (force_of_stresses(beam, state, &total), k)
}

impl System {
    /// Takes a node out of the equations: its row says that it has no correction.
    pub(super) fn hold(&mut self, node: usize) {
        self.residual[node] = Vector6::zeros();
        let pattern = self.tangent.pattern.clone();
        for (column, slot) in pattern.row(node) {
            let diagonal = column == node;
            self.tangent.values[slot] = if diagonal { Matrix6::identity() } else { Matrix6::zeros() };
        }
    }

    pub(super) fn add(&mut self, row: usize, column: usize, block: &Matrix6<f64>) {
        let slot = self.tangent.pattern.slot(row, column).expect("coupled nodes are in the pattern");
        self.tangent.values[slot] += block;
    }

    pub(super) fn add_blocks<const N: usize>(&mut self, nodes: &[usize; N], blocks: &ElementMatrix<N>) {
        for a in 0..N {
            for b in 0..N {
                self.add(nodes[a], nodes[b], &blocks[a][b]);
            }
        }
    }

    pub(super) fn add_beam<const N: usize>(
        &mut self,
        beam: &Beam<N>,
        motion: &Motion,
        gravity: &Vector3<f64>,
        factors: Option<RateFactors>,
        tangential: &[Matrix3<f64>],
    ) {
        let state = motion.of(beam);
        let mut rates = motion.rates_of(beam, &state);
        // A uniform field is the inertia force of the opposite acceleration.
        rates.acceleration.iter_mut().for_each(|a| *a -= gravity);
        let (elastic, inertia) = match factors {
            None => (elastic_force(beam, &state, motion), inertia_force(beam, &state, &rates)),
            Some(factors) => {
                let t = beam.nodes.map(|n| tangential[n]);
                let (elastic, k) = elastic_tangent(beam, &state, motion, factors, &t);
                let (inertia, m) = inertia_force_and_tangent(beam, &state, &rates, factors, &t);
                self.add_blocks(&beam.nodes, &k);
                self.add_blocks(&beam.nodes, &m);
                (elastic, inertia)
            }
        };
        for a in 0..N {
            self.residual[beam.nodes[a]] += elastic[a] + inertia[a];
        }
    }

    pub(super) fn add_lump(
        &mut self,
        lump: &LumpedMass,
        motion: &Motion,
        gravity: &Vector3<f64>,
        factors: Option<RateFactors>,
        tangential: &[Matrix3<f64>],
    ) {
        let node = lump.node;
        let q = motion.rotation_matrix(node);
        let (w, w1) = (&motion.spin[node], &motion.spin_rate[node]);
        let section = SectionMotion::new(
            &q,
            &lump.mass,
            &motion.velocity[node],
            &(motion.acceleration[node] - gravity),
            w,
            w1,
        );
        self.residual[node] += stack(&(q * section.force), &section.moment);
        let Some(factors) = factors else { return };
        let (one, zero) = (Matrix3::identity(), Matrix3::zeros());
        let action = NodeAction {
            share: 1.0,
            b: [&one, &zero, &zero],
            to_section: one,
            spin: *w,
            spin_rate: *w1,
            lever: None,
        };
        let v = section.variation(&action, factors, &tangential[node]);
        let mut block = Matrix6::zeros();
        block.fixed_view_mut::<3, 3>(0, 0).copy_from(&(q * v.force_position));
        block.fixed_view_mut::<3, 3>(0, 3).copy_from(&(q * v.force_rotation));
        block.fixed_view_mut::<3, 3>(3, 0).copy_from(&v.moment_position);
        block.fixed_view_mut::<3, 3>(3, 3).copy_from(&v.moment_rotation);
        self.add(node, node, &block);
    }
}
