//! Sparse matrices of 6 x 6 blocks, one block row per node with unknowns.

use std::sync::Arc;

use nalgebra::{Matrix6, Vector6};

/// Which blocks exist: compressed rows, columns sorted, symmetric, diagonal present.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockPattern {
    row_start: Vec<usize>,
    column: Vec<u32>,
}

impl BlockPattern {
    /// From groups of block rows that are coupled with each other (the nodes of each element).
    pub fn from_groups<'a>(n: usize, groups: impl Iterator<Item = &'a [usize]> + Clone) -> Self {
        let mut rows: Vec<Vec<u32>> = (0..n).map(|i| vec![i as u32]).collect();
        for group in groups {
            for &i in group {
                rows[i].extend(group.iter().map(|&j| j as u32));
            }
        }
        let (mut row_start, mut column) = (Vec::with_capacity(n + 1), Vec::new());
        row_start.push(0);
        for mut row in rows {
            row.sort_unstable();
            row.dedup();
            column.extend(row);
            row_start.push(column.len());
        }
        Self { row_start, column }
    }

    /// Number of block rows.
    pub fn n(&self) -> usize {
        self.row_start.len() - 1
    }

    /// Number of stored blocks.
    pub fn n_blocks(&self) -> usize {
        self.column.len()
    }

    /// Block columns of a row, ascending, with the slot of each.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        (self.row_start[i]..self.row_start[i + 1]).map(|slot| (self.column[slot] as usize, slot))
    }

    /// Slot of block `(i, j)`, if stored.
    pub fn slot(&self, i: usize, j: usize) -> Option<usize> {
        let row = &self.column[self.row_start[i]..self.row_start[i + 1]];
        row.binary_search(&(j as u32)).ok().map(|k| self.row_start[i] + k)
    }
}

/// Values on a pattern.
#[derive(Clone, Debug)]
pub struct BlockMatrix {
    /// The pattern, shared by all matrices of a structure.
    pub pattern: Arc<BlockPattern>,
    /// Blocks in pattern order.
    pub values: Vec<Matrix6<f64>>,
}

impl BlockMatrix {
    /// All blocks zero.
    pub fn zeros(pattern: Arc<BlockPattern>) -> Self {
        let values = vec![Matrix6::zeros(); pattern.n_blocks()];
        Self { pattern, values }
    }

    /// `self + factor * other`, on the same pattern.
    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        let values = self.values.iter().zip(&other.values).map(|(a, b)| a + b * factor).collect();
        Self { pattern: self.pattern.clone(), values }
    }

    /// `y = A x` over six-vectors of block rows.
    pub fn multiply(&self, x: &[Vector6<f64>], y: &mut [Vector6<f64>]) {
        for (i, yi) in y.iter_mut().enumerate() {
            *yi = self.pattern.row(i).map(|(j, slot)| self.values[slot] * x[j]).sum();
        }
    }

    /// Largest absolute entry.
    pub fn amax(&self) -> f64 {
        self.values.iter().map(|b| b.amax()).fold(0.0, f64::max)
    }

    /// Largest absolute difference from the transpose.
    pub fn asymmetry(&self) -> f64 {
        let mut worst: f64 = 0.0;
        for i in 0..self.pattern.n() {
            for (j, slot) in self.pattern.row(i) {
                let mirrored = self.pattern.slot(j, i).map_or_else(Matrix6::zeros, |s| self.values[s]);
                worst = worst.max((self.values[slot] - mirrored.transpose()).amax());
            }
        }
        worst
    }
}
