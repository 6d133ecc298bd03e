//! The curved manifold of shapes on which the strains are linear in the amplitudes (docs/beyond.md).
//!
//! ```text
//! x(q) = Phi q + Theta_ij q_i q_j + Psi_ijk q_i q_j q_k        K_mat Theta_ij = -B^t S eps_ij,   K_mat Psi_ijk = -B^t S eps_ijk   (B.4)
//! ```
//!
//! with `eps_ij`, `eps_ijk` the coefficients of the strains along the path without the term that is sought. On a tree of members the
//! strains are then linear to third order; in closed loops what is left is a self-stress, orthogonal to all strains of small motions.

use nalgebra::{DMatrix, Matrix6, Vector6};
use num_dual::Dual3_64;

use super::monomials::Monomials;
use crate::assembly::{AnyBeam, Assembly, BlockMatrix};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::internal_force::strain_maps;
use crate::element::kinematics;
use crate::reduce::modes::Modes;
use crate::solve::block_ldu::{Factor, SingularPivot, Symbolic};

/// Shapes as polynomials of the scaled amplitudes `q_i / range_i`.
#[derive(Clone, Debug)]
pub(super) struct Manifold {
    pub(super) monomials: Monomials,
    /// Amplitudes that the shapes are scaled with - (m).
    pub(super) range: Vec<f64>,
    /// Coefficients of nodal `(R, theta)` - (nodes x monomials).
    nodes: Vec<Vector6<f64>>,
}

/// Strain energy that the manifold leaves in closed loops.
#[derive(Clone, Debug)]
pub(super) struct SelfStress {
    /// Scalar products of what is left of the strains, over the monomials, J - (monomials x monomials).
    pub(super) products: DMatrix<f64>,
    /// Products with the strains of the equilibrium, J - (monomials).
    pub(super) with_equilibrium: Vec<f64>,
}

impl Manifold {
    /// The plane of the modes.
    pub(super) fn flat(assembly: &Assembly, modes: &Modes, range: &[f64], cubic: usize) -> Self {
        let monomials = Monomials::new(modes.m(), cubic);
        let (n, all) = (assembly.unknown.len(), monomials.len());
        let mut nodes = vec![Vector6::zeros(); n * all];
        for node in 0..n {
            for (i, phi) in modes.at_node(node).iter().enumerate() {
                nodes[node * all + i] = phi * range[i];
            }
        }
        Self { monomials, range: range.to_vec(), nodes }
    }

    /// The manifold of linear strains.
    ///
    /// # Errors
    /// A structure that is a mechanism at this configuration.
    pub(super) fn curved(
        assembly: &Assembly,
        at: &Configuration,
        modes: &Modes,
        range: &[f64],
        cubic: usize,
    ) -> Result<Self, SingularPivot> {
        let mut manifold = Self::flat(assembly, modes, range, cubic);
        let mut factor = Factor::new(std::sync::Arc::new(Symbolic::new(assembly.pattern.clone())));
        factor.refactor(&material_stiffness(assembly, at))?;
        for order in 2..=3 {
            manifold.bend(assembly, at, &factor, order);
        }
        Ok(manifold)
    }

    /// Coefficients of a node - (monomials).
    pub(super) fn at_node(&self, node: usize) -> &[Vector6<f64>] {
        &self.nodes[node * self.monomials.len()..(node + 1) * self.monomials.len()]
    }

    /// Terms of one order, all lower ones being known.
    fn bend(&mut self, assembly: &Assembly, at: &Configuration, factor: &Factor, order: usize) {
        let range = self.monomials.of_order(order);
        if range.is_empty() {
            return;
        }
        let mut forces = vec![vec![Vector6::zeros(); assembly.n_blocks()]; range.len()];
        let mut add = |node: usize, monomial: usize, force: Vector6<f64>| {
            if let Some(row) = assembly.unknown[node] {
                forces[monomial - range.start][row] -= force;
            }
        };
        for beam in &assembly.beams {
            match beam {
                AnyBeam::Two(b) => self.add_forces(b, at, order, &mut add),
                AnyBeam::Three(b) => self.add_forces(b, at, order, &mut add),
            }
        }
        let all = self.monomials.len();
        for (monomial, mut x) in range.zip(forces) {
            factor.solve(&mut x);
            for (node, unknown) in assembly.unknown.iter().enumerate() {
                if let Some(row) = unknown {
                    self.nodes[node * all + monomial] = x[*row];
                }
            }
        }
    }

    /// `B^t S eps` of one order.
    fn add_forces<const N: usize>(
        &self,
        beam: &Beam<N>,
        at: &Configuration,
        order: usize,
        add: &mut impl FnMut(usize, usize, Vector6<f64>),
    ) {
        let maps = strain_maps(beam, &at.of(beam));
        for ((point, maps), strains) in
            beam.stiffness_points().iter().zip(&maps).zip(self.strains(beam, at, order))
        {
            for monomial in self.monomials.of_order(order) {
                let strain = Vector6::from_column_slice(&strains[6 * monomial..6 * monomial + 6]);
                let stress = point.stiffness * strain * point.weight;
                for (map, node) in maps.iter().zip(beam.nodes) {
                    add(node, monomial, map.tr_mul(&stress));
                }
            }
        }
    }

    /// Coefficients of one order of the strains at every stiffness point of an element - (monomials x 6).
    fn strains<const N: usize>(&self, beam: &Beam<N>, at: &Configuration, order: usize) -> Vec<Vec<f64>> {
        let state = at.of(beam);
        let lines = &self.monomials.lines;
        let paths: Vec<_> = lines.iter().map(|line| beam.nodes.map(|node| self.path(node, line))).collect();
        let at_point = |point| {
            let mut values = Vec::with_capacity(6 * lines.len());
            for path in &paths {
                let strain = kinematics::strain(beam, &state, path, point);
                values.extend(strain.map(|s| coefficient(&s, order)));
            }
            let mut coefficients = vec![0.0; 6 * self.monomials.len()];
            self.monomials.polarise(order, 6, &values, &mut coefficients);
            coefficients
        };
        beam.stiffness_points().iter().map(at_point).collect()
    }

    /// Motion of a node along a line, as a series in its parameter.
    pub(super) fn path(&self, node: usize, line: &[(usize, f64)]) -> [Dual3_64; 6] {
        let coefficients = self.at_node(node);
        let along = |order| -> Vector6<f64> {
            self.monomials.along(line, order).iter().map(|&(index, x)| coefficients[index] * x).sum()
        };
        let (first, second, third) = (along(1), along(2), along(3));
        std::array::from_fn(|k| Dual3_64::new(0.0, first[k], 2.0 * second[k], 6.0 * third[k]))
    }

    /// What the manifold leaves of the strains of second and third order.
    pub(super) fn self_stress(&self, assembly: &Assembly, at: &Configuration) -> SelfStress {
        let all = self.monomials.len();
        let mut out = SelfStress { products: DMatrix::zeros(all, all), with_equilibrium: vec![0.0; all] };
        for beam in &assembly.beams {
            match beam {
                AnyBeam::Two(b) => self.add_self_stress(b, at, &mut out),
                AnyBeam::Three(b) => self.add_self_stress(b, at, &mut out),
            }
        }
        out
    }

    fn add_self_stress<const N: usize>(&self, beam: &Beam<N>, at: &Configuration, out: &mut SelfStress) {
        let state = at.of(beam);
        let rest = [[0.0; 6]; N];
        let orders = [2, 3].map(|order| self.strains(beam, at, order));
        for (index, point) in beam.stiffness_points().iter().enumerate() {
            let weighted = point.stiffness * point.weight;
            let equilibrium = Vector6::from(kinematics::strain(beam, &state, &rest, point));
            let first = self.monomials.of_order(2).start;
            let strains: Vec<Vector6<f64>> = (first..self.monomials.len())
                .map(|monomial| {
                    let of_order = |k: usize| {
                        Vector6::from_column_slice(&orders[k][index][6 * monomial..6 * monomial + 6])
                    };
                    of_order(0) + of_order(1)
                })
                .collect();
            for (i, a) in strains.iter().enumerate() {
                let stress = weighted * a;
                out.with_equilibrium[first + i] += equilibrium.dot(&stress);
                for (j, b) in strains.iter().enumerate() {
                    out.products[(first + i, first + j)] += b.dot(&stress);
                }
            }
        }
    }
}

/// Coefficient of a power of the parameter.
pub(super) fn coefficient(series: &Dual3_64, order: usize) -> f64 {
    match order {
        1 => series.v1,
        2 => series.v2 / 2.0,
        _ => series.v3 / 6.0,
    }
}

/// `B^t S B`.
pub(super) fn material_stiffness(assembly: &Assembly, at: &Configuration) -> BlockMatrix {
    fn blocks<const N: usize>(beam: &Beam<N>, at: &Configuration) -> [[Matrix6<f64>; N]; N] {
        let mut k = [[Matrix6::zeros(); N]; N];
        for (point, maps) in beam.stiffness_points().iter().zip(strain_maps(beam, &at.of(beam))) {
            for (row, left) in k.iter_mut().zip(&maps) {
                for (block, right) in row.iter_mut().zip(&maps) {
                    *block += left.tr_mul(&(point.stiffness * right)) * point.weight;
                }
            }
        }
        k
    }
    let mut k = BlockMatrix::zeros(assembly.pattern.clone());
    for beam in &assembly.beams {
        match beam {
            AnyBeam::Two(b) => assembly.add(&mut k, &b.nodes, &blocks(b, at)),
            AnyBeam::Three(b) => assembly.add(&mut k, &b.nodes, &blocks(b, at)),
        }
    }
    k
}

/// `Phi^t B^t S B Phi`, J per squared amplitude - (m x m).
pub(super) fn modal_stiffness(assembly: &Assembly, at: &Configuration, modes: &Modes) -> DMatrix<f64> {
    fn add<const N: usize>(k: &mut DMatrix<f64>, beam: &Beam<N>, at: &Configuration, modes: &Modes) {
        let m = k.nrows();
        for (point, maps) in beam.stiffness_points().iter().zip(strain_maps(beam, &at.of(beam))) {
            let strain = |j: usize| -> Vector6<f64> {
                (0..N).map(|a| maps[a] * modes.at_node(beam.nodes[a])[j]).sum()
            };
            let strains: Vec<Vector6<f64>> = (0..m).map(strain).collect();
            for j in 0..m {
                let stress = point.stiffness * strains[j] * point.weight;
                (0..m).for_each(|i| k[(i, j)] += strains[i].dot(&stress));
            }
        }
    }
    let mut k = DMatrix::zeros(modes.m(), modes.m());
    for beam in &assembly.beams {
        match beam {
            AnyBeam::Two(b) => add(&mut k, b, at, modes),
            AnyBeam::Three(b) => add(&mut k, b, at, modes),
        }
    }
    (&k + k.transpose()) * 0.5
}
