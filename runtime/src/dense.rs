//! A small dense matrix laid out for `y = A x`.

use alloc::vec::Vec;
use core::slice::{ChunksExact, ChunksExactMut};

use crate::real::Real;

const BLOCK: usize = 4;
/// Blocks whose sums fit into the registers together.
const PANEL: usize = 4;

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

/// Rows in blocks of four, and these in panels of at most four, each panel column by column: all its sums stay in registers, a number is
/// read once for all of them, and nothing is scattered.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Dense {
    n_columns: usize,
    /// Panel by panel (columns x blocks), the last block padded with zeros.
    values: Vec<[f64; BLOCK]>,
}

impl Dense {
    /// From its entries.
    pub(crate) fn new(n_rows: usize, n_columns: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let blocks: Vec<usize> = (0..n_rows.div_ceil(BLOCK)).collect();
        let at = |block: usize, column: usize| {
            core::array::from_fn(|lane| {
                let row = block * BLOCK + lane;
                if row < n_rows { entry(row, column) } else { 0.0 }
            })
        };
        let mut values = Vec::with_capacity(blocks.len() * n_columns);
        for panel in blocks.chunks(PANEL) {
            values
                .extend((0..n_columns).flat_map(|column| panel.iter().map(move |&block| at(block, column))));
        }
        Dense { n_columns, values }
    }

    /// `y = A x`; as many entries as `y` has.
    #[inline(always)]
    pub(crate) fn apply<R: Real>(&self, x: &[R], y: &mut [R]) {
        y.fill(R::of(0.0));
        self.add(x, y);
    }

    /// `y += A x`.
    #[inline(always)]
    pub(crate) fn add<R: Real>(&self, x: &[R], y: &mut [R]) {
        let mut values = self.values.as_slice();
        for y in y.chunks_mut(PANEL * BLOCK) {
            let blocks = y.len().div_ceil(BLOCK);
            let Some((panel, rest)) = values.split_at_checked(blocks * self.n_columns) else { return };
            values = rest;
            match blocks {
                1 => add_panel::<R, 1>(panel, x, y),
                2 => add_panel::<R, 2>(panel, x, y),
                3 => add_panel::<R, 3>(panel, x, y),
                _ => add_panel::<R, PANEL>(panel, x, y),
            }
        }
    }
}

/// The rows of a panel of `N` blocks.
#[inline(always)]
fn add_panel<R: Real, const N: usize>(values: &[[f64; BLOCK]], x: &[R], y: &mut [R]) {
    let columns = values.as_chunks::<N>().0;
    if R::IS_WIDE {
        // Block after block: the sums of several would not stay in the registers; and no rows of zeros, where each is a register.
        for (block, y) in y.chunks_mut(BLOCK).enumerate() {
            match y.len() {
                1 => add_rows::<R, N, 1>(columns, block, x, y),
                2 => add_rows::<R, N, 2>(columns, block, x, y),
                3 => add_rows::<R, N, 3>(columns, block, x, y),
                _ => add_rows::<R, N, BLOCK>(columns, block, x, y),
            }
        }
        return;
    }
    let mut sums = [[R::of(0.0); BLOCK]; N];
    for (column, x) in columns.iter().zip(x) {
        for (sums, values) in sums.iter_mut().zip(column) {
            accumulate(sums, values, *x);
        }
    }
    let (fours, rest) = y.as_chunks_mut::<BLOCK>();
    for (y, sums) in fours.iter_mut().zip(&sums) {
        y.iter_mut().zip(sums).for_each(|(y, sum)| *y += *sum);
    }
    let last = sums.get(fours.len()).into_iter().flatten();
    rest.iter_mut().zip(last).for_each(|(y, sum)| *y += *sum);
}

/// The first `ROWS` rows of a block of a panel.
#[inline(always)]
fn add_rows<R: Real, const N: usize, const ROWS: usize>(
    columns: &[[[f64; BLOCK]; N]],
    block: usize,
    x: &[R],
    y: &mut [R],
) {
    let mut sums = [R::of(0.0); ROWS];
    for (column, x) in columns.iter().zip(x) {
        if let Some(values) = column.get(block) {
            accumulate(&mut sums, values, *x);
        }
    }
    y.iter_mut().zip(&sums).for_each(|(y, sum)| *y += *sum);
}

#[inline(always)]
fn accumulate<R: Real, const ROWS: usize>(sums: &mut [R; ROWS], values: &[f64; BLOCK], x: R) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += R::of(*value) * x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    #[test]
    fn products_of_any_shape() {
        for (rows, columns) in
            [(0, 3), (1, 1), (4, 2), (5, 3), (11, 0), (8, 7), (12, 2), (15, 4), (16, 3), (18, 5), (33, 2)]
        {
            let entry = |i: usize, j: usize| (3 * i + 5 * j + 1) as f64;
            let x: Vec<f64> = (0..columns).map(|j| j as f64 - 1.5).collect();
            let mut y = vec![f64::NAN; rows];
            Dense::new(rows, columns, entry).apply(&x, &mut y);
            for (i, y) in y.iter().enumerate() {
                assert_eq!(*y, x.iter().enumerate().map(|(j, x)| entry(i, j) * x).sum::<f64>());
            }
            let once = y.clone();
            Dense::new(rows, columns, entry).add(&x, &mut y);
            assert!(y.iter().zip(&once).all(|(twice, once)| *twice == 2.0 * once));
        }
    }
}
