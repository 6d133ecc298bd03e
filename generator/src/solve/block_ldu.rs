//! Sparse block LDU factorisation with 6 x 6 blocks, pivoting inside a block only.
//!
//! The symbolic part is made once per structure; a numerical factorisation reuses it and its storage. For a symmetric
//! matrix the pivot blocks give its inertia (Sylvester): the Sturm count of the mode solver.

use std::sync::Arc;

use nalgebra::{Matrix6, SMatrix, Vector6};

use super::ordering::minimum_degree;
use crate::assembly::{BlockMatrix, BlockPattern};

/// A pivot block could not be inverted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("singular pivot block at block row {row}")]
pub struct SingularPivot {
    /// Block row of the matrix.
    pub row: usize,
}

/// Where each block of the matrix and each update of the elimination lands.
#[derive(Debug)]
pub struct Symbolic {
    pattern: Arc<BlockPattern>,
    /// Block row of each elimination step.
    order: Vec<u32>,
    /// Off-diagonal blocks of step k are `start[k]..start[k+1]`.
    start: Vec<u32>,
    /// Elimination step of the neighbour behind each off-diagonal block.
    neighbour: Vec<u32>,
    /// Target of each pattern slot.
    scatter: Vec<Target>,
    /// Targets of the updates, in the order the elimination makes them.
    updates: Vec<Target>,
}

/// A block of the factor.
#[derive(Clone, Copy, Debug)]
enum Target {
    Diagonal(u32),
    Upper(u32),
    Lower(u32),
}

impl Symbolic {
    /// Orders the pattern and lays out the factor.
    pub fn new(pattern: Arc<BlockPattern>) -> Self {
        let elimination = minimum_degree(&pattern);
        let n = pattern.n();
        let mut step_of = vec![0u32; n];
        for (step, &row) in elimination.order.iter().enumerate() {
            step_of[row as usize] = step as u32;
        }
        let mut start = Vec::with_capacity(n + 1);
        let mut neighbour = Vec::new();
        start.push(0u32);
        for list in &elimination.neighbours {
            neighbour.extend(list.iter().map(|&row| step_of[row as usize]));
            start.push(neighbour.len() as u32);
        }
        let locate = |row: u32, column: u32| -> Target {
            if row == column {
                return Target::Diagonal(row);
            }
            let (first, second) = (row.min(column), row.max(column));
            let range = start[first as usize] as usize..start[first as usize + 1] as usize;
            let at = neighbour[range.clone()].binary_search(&second).expect("neighbours hold all fill");
            let slot = (range.start + at) as u32;
            if row < column { Target::Upper(slot) } else { Target::Lower(slot) }
        };
        let mut scatter = Vec::with_capacity(pattern.n_blocks());
        for row in 0..n {
            for (column, _) in pattern.row(row) {
                scatter.push(locate(step_of[row], step_of[column]));
            }
        }
        let mut updates = Vec::new();
        for step in 0..n {
            let around = &neighbour[start[step] as usize..start[step + 1] as usize];
            for &row in around {
                updates.extend(around.iter().map(|&column| locate(row, column)));
            }
        }
        Self { order: elimination.order, start, neighbour, scatter, updates, pattern }
    }

    /// Off-diagonal blocks of the factor, one triangle: a measure of fill.
    pub fn n_off_diagonal(&self) -> usize {
        self.neighbour.len()
    }

    fn range(&self, step: usize) -> std::ops::Range<usize> {
        self.start[step] as usize..self.start[step + 1] as usize
    }
}

/// A numerical factorisation.
#[derive(Clone, Debug)]
pub struct Factor {
    symbolic: Arc<Symbolic>,
    /// Inverted pivot blocks.
    inverse: Vec<Matrix6<f64>>,
    upper: Vec<Matrix6<f64>>,
    lower: Vec<Matrix6<f64>>,
    /// Pivot blocks as they were, kept for the inertia.
    pivots: Vec<Matrix6<f64>>,
}

impl Factor {
    /// Storage for a structure; all values zero until [`Self::refactor`].
    pub fn new(symbolic: Arc<Symbolic>) -> Self {
        let n = symbolic.order.len();
        let m = symbolic.neighbour.len();
        let zero = Matrix6::zeros();
        Self {
            inverse: vec![zero; n],
            pivots: vec![zero; n],
            upper: vec![zero; m],
            lower: vec![zero; m],
            symbolic,
        }
    }

    /// Factorises `matrix`, which must have the pattern of the symbolic part.
    pub fn refactor(&mut self, matrix: &BlockMatrix) -> Result<(), SingularPivot> {
        let symbolic = self.symbolic.clone();
        debug_assert_eq!(*matrix.pattern, *symbolic.pattern);
        for block in self.pivots.iter_mut().chain(&mut self.upper).chain(&mut self.lower) {
            *block = Matrix6::zeros();
        }
        for (value, target) in matrix.values.iter().zip(&symbolic.scatter) {
            *self.block(*target) = *value;
        }
        let mut update = symbolic.updates.iter();
        for step in 0..symbolic.order.len() {
            let inverse = self.pivots[step]
                .try_inverse()
                .filter(|m| m.iter().all(|x| x.is_finite()))
                .ok_or(SingularPivot { row: symbolic.order[step] as usize })?;
            self.inverse[step] = inverse;
            for row in symbolic.range(step) {
                let l = self.lower[row] * inverse;
                for column in symbolic.range(step) {
                    let product = l * self.upper[column];
                    let target = update.next().expect("one target per update");
                    *self.block(*target) -= product;
                }
                self.lower[row] = l;
            }
        }
        Ok(())
    }

    fn block(&mut self, target: Target) -> &mut Matrix6<f64> {
        match target {
            Target::Diagonal(k) => &mut self.pivots[k as usize],
            Target::Upper(k) => &mut self.upper[k as usize],
            Target::Lower(k) => &mut self.lower[k as usize],
        }
    }

    /// Solves `A x = b` in place, for `B` right-hand sides at once (columns of each nodal 6 x B panel).
    pub fn solve_panels<const B: usize>(&self, x: &mut [SMatrix<f64, 6, B>]) {
        let s = &*self.symbolic;
        for (step, &row) in s.order.iter().enumerate() {
            let xk = x[row as usize];
            for slot in s.range(step) {
                let target = s.order[s.neighbour[slot] as usize] as usize;
                x[target] -= self.lower[slot] * xk;
            }
        }
        for (step, &row) in s.order.iter().enumerate().rev() {
            let mut xk = x[row as usize];
            for slot in s.range(step) {
                let source = s.order[s.neighbour[slot] as usize] as usize;
                xk -= self.upper[slot] * x[source];
            }
            x[row as usize] = self.inverse[step] * xk;
        }
    }

    /// Solves `A x = b` in place for one right-hand side.
    pub fn solve(&self, x: &mut [Vector6<f64>]) {
        self.solve_panels::<1>(x);
    }

    /// Number of negative eigenvalues of the factorised matrix, which must be symmetric.
    pub fn negative_eigenvalues(&self) -> usize {
        self.pivots
            .iter()
            .map(|d| {
                let symmetric = (d + d.transpose()) * 0.5;
                symmetric.symmetric_eigenvalues().iter().filter(|&&x| x < 0.0).count()
            })
            .sum()
    }

    /// Whether the determinant of the factorised matrix, symmetric or not, is negative. None where a pivot block is so close to
    /// singular that the digits of the blocks behind it are lost: without pivoting that happens when a part of the structure
    /// becomes a mechanism with its neighbours held, though the whole does not.
    pub fn determinant_is_negative(&self) -> Option<bool> {
        // Skeel's condition number does not depend on the scaling of the rows (forces and moments).
        let lost = |d: &Matrix6<f64>, inverse: &Matrix6<f64>| {
            let product = inverse.abs() * d.abs();
            product.row_iter().map(|row| row.sum()).fold(0.0, f64::max) > 1e11
        };
        if self.pivots.iter().zip(&self.inverse).any(|(d, inverse)| lost(d, inverse)) {
            return None;
        }
        Some(self.pivots.iter().filter(|d| d.determinant() < 0.0).count() % 2 == 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::tests::Random;

    /// A tree with a loop: the general case of a frame.
    fn pattern() -> Arc<BlockPattern> {
        let groups: [&[usize]; 8] =
            [&[0, 1], &[1, 2, 3], &[3, 4], &[4, 5], &[5, 1], &[4, 6], &[6, 7], &[2, 8]];
        Arc::new(BlockPattern::from_groups(9, groups.into_iter()))
    }

    fn random_matrix(random: &mut Random, symmetric: bool, shift: f64) -> BlockMatrix {
        let pattern = pattern();
        let mut a = BlockMatrix::zeros(pattern.clone());
        for i in 0..pattern.n() {
            for (j, slot) in pattern.row(i) {
                let mut block = Matrix6::from_fn(|_, _| random.next());
                if i == j {
                    block += Matrix6::identity() * shift;
                    if symmetric {
                        block = (block + block.transpose()) * 0.5;
                    }
                } else if symmetric && j < i {
                    block = a.values[pattern.slot(j, i).unwrap()].transpose();
                }
                a.values[slot] = block;
            }
        }
        a
    }

    #[test]
    fn solves_unsymmetric_systems() {
        let mut random = Random::new(3);
        let mut factor = Factor::new(Arc::new(Symbolic::new(pattern())));
        for _ in 0..5 {
            let a = random_matrix(&mut random, false, 12.0);
            let x: Vec<Vector6<f64>> = (0..9).map(|_| random.vector6()).collect();
            let mut b = vec![Vector6::zeros(); 9];
            a.multiply(&x, &mut b);
            factor.refactor(&a).unwrap();
            factor.solve(&mut b);
            let error: f64 = x.iter().zip(&b).map(|(x, y)| (x - y).amax()).fold(0.0, f64::max);
            assert!(error < 1e-13, "{error}");
        }
    }

    #[test]
    fn counts_negative_eigenvalues() {
        let mut random = Random::new(7);
        let mut factor = Factor::new(Arc::new(Symbolic::new(pattern())));
        for _ in 0..5 {
            let a = random_matrix(&mut random, true, 0.3);
            factor.refactor(&a).unwrap();
            let mut dense = nalgebra::DMatrix::zeros(54, 54);
            for i in 0..9 {
                for (j, slot) in a.pattern.row(i) {
                    dense.view_mut((6 * i, 6 * j), (6, 6)).copy_from(&a.values[slot]);
                }
            }
            let expected = dense.symmetric_eigenvalues().iter().filter(|&&x| x < 0.0).count();
            assert_eq!(factor.negative_eigenvalues(), expected);
        }
    }

    #[test]
    fn knows_the_sign_of_the_determinant() {
        let mut random = Random::new(5);
        let mut factor = Factor::new(Arc::new(Symbolic::new(pattern())));
        let mut seen = [false; 2];
        for _ in 0..12 {
            let a = random_matrix(&mut random, false, 0.3);
            factor.refactor(&a).unwrap();
            let mut dense = nalgebra::DMatrix::zeros(54, 54);
            for i in 0..9 {
                for (j, slot) in a.pattern.row(i) {
                    dense.view_mut((6 * i, 6 * j), (6, 6)).copy_from(&a.values[slot]);
                }
            }
            let expected = dense.determinant() < 0.0;
            assert_eq!(factor.determinant_is_negative(), Some(expected));
            seen[usize::from(expected)] = true;
        }
        assert_eq!(seen, [true; 2], "both signs met");
    }

    #[test]
    fn a_tree_has_no_fill() {
        let groups: Vec<Vec<usize>> = (1..200).map(|i| vec![i, i / 3]).collect();
        let pattern = BlockPattern::from_groups(200, groups.iter().map(Vec::as_slice));
        assert_eq!(Symbolic::new(Arc::new(pattern)).n_off_diagonal(), 199);
    }

    #[test]
    fn a_singular_block_is_named() {
        let mut random = Random::new(9);
        let mut a = random_matrix(&mut random, false, 12.0);
        for v in &mut a.values {
            *v = Matrix6::zeros();
        }
        let mut factor = Factor::new(Arc::new(Symbolic::new(pattern())));
        assert!(factor.refactor(&a).is_err());
    }
}
