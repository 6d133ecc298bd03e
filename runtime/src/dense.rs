//! A small dense matrix laid out for `y = A x`.

use alloc::{vec, vec::Vec};
use core::slice::{ChunksExact, ChunksExactMut};

use crate::real::Real;

const BLOCK: usize = 4;

/// Rows of a matrix stored row by row; none where it has no columns. `chunks_exact` panics there, and the step must be seen by the
/// compiler not to (`.ci/no_panic`).
#[inline(always)]
pub(crate) fn rows<T>(matrix: &[T], columns: usize) -> ChunksExact<'_, T> {
    matrix.chunks_exact(columns.max(1))
}

/// As [`rows`], to be written to.
#[inline(always)]
pub(crate) fn rows_mut<T>(matrix: &mut [T], columns: usize) -> ChunksExactMut<'_, T> {
    matrix.chunks_exact_mut(columns.max(1))
}

/// Rows in blocks of four, each block column by column: four sums stay in registers, and nothing is scattered.
#[derive(Clone, Debug)]
pub(crate) struct Dense {
    n_columns: usize,
    /// (blocks x n_columns), the last block padded with zeros.
    blocks: Vec<[f64; BLOCK]>,
}

impl Dense {
    /// From its entries.
    pub(crate) fn new(n_rows: usize, n_columns: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let mut blocks = vec![[0.0; BLOCK]; n_rows.div_ceil(BLOCK) * n_columns];
        for (at, values) in blocks.iter_mut().enumerate() {
            let (block, column) = (at / n_columns, at % n_columns);
            for (lane, value) in values.iter_mut().enumerate() {
                let row = block * BLOCK + lane;
                if row < n_rows {
                    *value = entry(row, column);
                }
            }
        }
        Dense { n_columns, blocks }
    }

    /// `y = A x`; as many entries as `y` has.
    #[inline(always)]
    pub(crate) fn apply<R: Real>(&self, x: &[R], y: &mut [R]) {
        if self.n_columns == 0 {
            y.fill(R::of(0.0));
            return;
        }
        let (fours, rest) = y.as_chunks_mut::<BLOCK>();
        let mut blocks = rows(&self.blocks, self.n_columns);
        for (y, block) in fours.iter_mut().zip(blocks.by_ref()) {
            *y = product(block, x);
        }
        if let (Some(block), false) = (blocks.next(), rest.is_empty()) {
            for (y, sum) in rest.iter_mut().zip(product(block, x)) {
                *y = sum;
            }
        }
    }
}

/// Four rows times `x`. Even and odd columns have sums of their own, so that no addition waits for the one before.
#[inline(always)]
fn product<R: Real>(block: &[[f64; BLOCK]], x: &[R]) -> [R; BLOCK] {
    let (mut even, mut odd) = ([R::of(0.0); BLOCK], [R::of(0.0); BLOCK]);
    let (pairs, last) = block.as_chunks::<2>();
    let (x_pairs, last_x) = x.as_chunks::<2>();
    for ([v0, v1], [x0, x1]) in pairs.iter().zip(x_pairs) {
        accumulate(&mut even, v0, *x0);
        accumulate(&mut odd, v1, *x1);
    }
    if let ([values], [x]) = (last, last_x) {
        accumulate(&mut even, values, *x);
    }
    for (even, odd) in even.iter_mut().zip(odd) {
        *even += odd;
    }
    even
}

#[inline(always)]
fn accumulate<R: Real>(sums: &mut [R; BLOCK], values: &[f64; BLOCK], x: R) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += R::of(*value) * x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_any_shape() {
        for (rows, columns) in [(0, 3), (1, 1), (4, 2), (5, 3), (11, 0), (8, 7)] {
            let entry = |i: usize, j: usize| (3 * i + 5 * j + 1) as f64;
            let x: Vec<f64> = (0..columns).map(|j| j as f64 - 1.5).collect();
            let mut y = vec![f64::NAN; rows];
            Dense::new(rows, columns, entry).apply(&x, &mut y);
            for (i, y) in y.iter().enumerate() {
                assert_eq!(*y, x.iter().enumerate().map(|(j, x)| entry(i, j) * x).sum::<f64>());
            }
        }
    }
}
