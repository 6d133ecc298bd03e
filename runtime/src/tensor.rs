//! The constant tensors in the form the step contracts.
//!
//! Both tensors of theory (25) act on products of the state, `u_l beta_r` and `q_l beta_r beta_s`. The products are
//! formed once per evaluation (a few hundred multiplications), and what remains is one sparse matrix times one vector.
//! Rows are gathered in blocks of four that share as many columns as possible (the modes of a symmetric structure fall
//! into symmetry classes, whose rows have the same columns), and each block keeps, per column that any of its rows
//! uses, the four values side by side: straight loads, no scatter. Every fourth column has sums of its own, so that no addition
//! waits for the one before. Products lie in windows of 256: a byte names a column in its window and cannot lead out of it, so that the
//! sums run without checks.

use alloc::{vec, vec::Vec};

use crate::data::TensorData;
use crate::math::Vec6;
use crate::real::{Real, one_by_one};

/// Pairs (r, s), r <= s, in the order of their products: those with a rotation first. Only they occur in a mechanical
/// model (a uniform velocity deforms nothing), so the others are formed only if an entry asks for them.
#[rustfmt::skip]
const PAIRS: [(usize, usize); 21] = [
    (3, 3), (3, 4), (3, 5), (4, 4), (4, 5), (5, 5),
    (0, 3), (0, 4), (0, 5), (1, 3), (1, 4), (1, 5), (2, 3), (2, 4), (2, 5),
    (0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2),
];
/// Fours of products per mode, padded: 15 pairs with a rotation, or all 21.
const WITH_ROTATION: usize = 4;
const ALL: usize = 6;
pub(crate) const BLOCK: usize = 4;
/// Columns taken together, each with sums of its own.
pub(crate) const GROUP: usize = 4;
/// Room for the velocities and their products two by two, a power of two: places in it need no check.
pub(crate) const VELOCITIES: usize = 32;
/// Products that a byte can name.
const WINDOW: usize = 1 << u8::BITS;

/// Scratch for the products of an evaluation.
pub(crate) type Windows<R> = Vec<[R; WINDOW]>;

/// A column of a block of rows.
pub(crate) struct Column {
    /// Which of the sums of every row it belongs to.
    pub(crate) sum: usize,
    /// The factors of its product: place in `(q, u)`, and among [`velocities`].
    pub(crate) factors: [u32; 2],
    pub(crate) values: [f64; BLOCK],
}

/// Columns of one window that a block uses.
#[derive(Clone, Debug)]
struct Segment {
    window: usize,
    /// Number of groups of columns.
    groups: usize,
}

/// Four rows.
#[derive(Clone, Debug)]
struct Block {
    /// Row of the model for each row; `u32::MAX` for padding.
    rows: [u32; BLOCK],
    /// Number of its groups of columns.
    groups: usize,
    /// Its segments among all - (start, end).
    segments: (usize, usize),
}

/// `y_i = c_ilr u_l beta_r + k_ilrs q_l beta_r beta_s` for constant c, k.
#[derive(Clone, Debug)]
pub(crate) struct Contraction {
    blocks: Vec<Block>,
    segments: Vec<Segment>,
    /// Place in its window of every column, padded with any column - (groups).
    columns: Vec<[u8; GROUP]>,
    /// Values of the four rows in every column, zero in the padding - (groups).
    values: Vec<[[f64; BLOCK]; GROUP]>,
    n_modes: usize,
    /// Fours of products of velocities per mode, [`WITH_ROTATION`] or [`ALL`].
    n_fours: usize,
    n_products: usize,
    n_entries: usize,
}

impl Contraction {
    /// From the coordinate form of a model with `m` elastic modes. Indices must have been checked.
    #[allow(clippy::indexing_slicing)] // made once, from checked indices
    pub(crate) fn new(m: usize, c: &TensorData, k: &TensorData) -> Self {
        let n = m + 6;
        let n_fours =
            if k.r.iter().all(|&rs| pair_index(rs) < 4 * WITH_ROTATION - 1) { WITH_ROTATION } else { ALL };
        // The last are the squares that the others are made with.
        let n_products = n * 6 + (m + 1) * 4 * n_fours;
        let mut dense_rows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); n];
        for (((&i, &l), &r), &value) in c.i.iter().zip(&c.l).zip(&c.r).zip(&c.value) {
            dense_rows[i as usize].push((l * 6 + r, value));
        }
        for (((&i, &l), &rs), &value) in k.i.iter().zip(&k.l).zip(&k.r).zip(&k.value) {
            let product = n * 6 + l as usize * 4 * n_fours + pair_index(rs);
            dense_rows[i as usize].push((product as u32, value));
        }
        for row in &mut dense_rows {
            row.sort_unstable_by_key(|&(column, _)| column);
        }
        let mut contraction = Contraction {
            blocks: Vec::new(),
            segments: Vec::new(),
            columns: Vec::new(),
            values: Vec::new(),
            n_modes: m,
            n_fours,
            n_products,
            n_entries: c.value.len() + k.value.len(),
        };
        for block in row_blocks(&dense_rows, n_products) {
            contraction.push_block(block, &dense_rows, n_products);
        }
        contraction
    }

    #[allow(clippy::indexing_slicing)] // made once, from checked indices
    fn push_block(&mut self, block: [u32; BLOCK], dense_rows: &[Vec<(u32, f64)>], n_products: usize) {
        let mut by_column = vec![None; n_products];
        for (lane, &row) in block.iter().enumerate() {
            for &(column, value) in dense_rows.get(row as usize).map_or(&[][..], Vec::as_slice) {
                by_column[column as usize].get_or_insert([0.0; BLOCK])[lane] = value;
            }
        }
        let (start, first_group) = (self.segments.len(), self.columns.len());
        for (window, by_column) in by_column.chunks(WINDOW).enumerate() {
            let used = by_column.iter().enumerate().filter_map(|(column, values)| Some((column, (*values)?)));
            let used: Vec<(usize, [f64; BLOCK])> = used.collect();
            for group in used.chunks(GROUP) {
                let at = |slot: usize| group.get(slot).copied().unwrap_or((group[0].0, [0.0; BLOCK]));
                self.columns.push(core::array::from_fn(|slot| at(slot).0 as u8));
                self.values.push(core::array::from_fn(|slot| at(slot).1));
            }
            if !used.is_empty() {
                self.segments.push(Segment { window, groups: used.len().div_ceil(GROUP) });
            }
        }
        let groups = self.columns.len() - first_group;
        self.blocks.push(Block { rows: block, groups, segments: (start, self.segments.len()) });
    }

    /// Scratch for [`Contraction::apply`].
    pub(crate) fn products<R: Real>(&self) -> Windows<R> {
        vec![[R::of(0.0); WINDOW]; self.n_products.div_ceil(WINDOW)]
    }

    /// Rows of every block (`u32::MAX` for padding), and its columns in the order of the sums.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = ([u32; BLOCK], Vec<Column>)> + '_ {
        let mut groups = self.columns.iter().zip(&self.values);
        self.blocks.iter().map(move |block| {
            let (start, end) = block.segments;
            let mut columns = Vec::with_capacity(block.groups * GROUP);
            for segment in self.segments.get(start..end).unwrap_or_default() {
                for (places, values) in groups.by_ref().take(segment.groups) {
                    let [first, ..] = *places;
                    for (sum, (place, values)) in places.iter().zip(values).enumerate() {
                        // A column is there once; padding repeats the first of its group.
                        if sum == 0 || *place != first {
                            let factors = self.factors(segment.window * WINDOW + usize::from(*place));
                            columns.push(Column { sum, factors, values: *values });
                        }
                    }
                }
            }
            (block.rows, columns)
        })
    }

    /// See [`Column::factors`].
    fn factors(&self, product: usize) -> [u32; 2] {
        let (m, linear) = (self.n_modes, (self.n_modes + 6) * 6);
        let [a, b] = match product.checked_sub(linear) {
            None => [m + product / 6, product % 6],
            Some(quadratic) => [quadratic / (4 * self.n_fours), 6 + quadratic % (4 * self.n_fours)],
        };
        [a as u32, b as u32]
    }

    /// Stored tensor entries, and values held by the blocks (padding included).
    pub(crate) fn fill(&self) -> (usize, usize) {
        (self.n_entries, self.values.len() * GROUP * BLOCK)
    }

    /// `y = c u beta + k q beta beta`; `products` is scratch.
    #[inline(always)]
    pub(crate) fn apply<R: Real>(
        &self,
        u: &[R],
        q: &[R],
        beta: &Vec6<R>,
        products: &mut [[R; WINDOW]],
        y: &mut [R],
    ) {
        let flat = products.as_flattened_mut();
        if self.n_fours == WITH_ROTATION {
            form_products::<R, WITH_ROTATION>(u, q, beta, flat);
        } else {
            form_products::<R, ALL>(u, q, beta, flat);
        }
        let (mut columns, mut values) = (self.columns.as_slice(), self.values.as_slice());
        for block in &self.blocks {
            let (Some((of_columns, rest)), Some((of_values, rest_of_values))) =
                (columns.split_at_checked(block.groups), values.split_at_checked(block.groups))
            else {
                return;
            };
            (columns, values) = (rest, rest_of_values);
            let (start, end) = block.segments;
            let segments = self.segments.get(start..end).unwrap_or_default();
            let sums = row_sums(segments, of_columns, of_values, products);
            for (&row, sum) in block.rows.iter().zip(sums) {
                if let Some(y) = y.get_mut(row as usize) {
                    *y = sum;
                }
            }
        }
    }
}

/// Sums of the rows of a block.
#[inline(always)]
fn row_sums<R: Real>(
    segments: &[Segment],
    mut columns: &[[u8; GROUP]],
    mut values: &[[[f64; BLOCK]; GROUP]],
    products: &[[R; WINDOW]],
) -> [R; BLOCK] {
    let mut sums = [[R::of(0.0); BLOCK]; GROUP];
    for segment in segments {
        let (Some(window), Some((of_columns, rest)), Some((of_values, rest_of_values))) = (
            products.get(segment.window),
            columns.split_at_checked(segment.groups),
            values.split_at_checked(segment.groups),
        ) else {
            break;
        };
        (columns, values) = (rest, rest_of_values);
        for (columns, values) in of_columns.iter().zip(of_values) {
            for ((sums, column), values) in sums.iter_mut().zip(columns).zip(values) {
                if let Some(x) = window.get(usize::from(*column)) {
                    accumulate(sums, values, *x);
                }
            }
        }
    }
    sum_of_sums(sums)
}

/// Of the sums of every row, in the order that all have to keep.
#[inline(always)]
pub(crate) fn sum_of_sums<R: Real, const N: usize>(sums: [[R; N]; GROUP]) -> [R; N] {
    let [mut a, b, mut c, d] = sums;
    add_to(&mut a, &b);
    add_to(&mut c, &d);
    add_to(&mut a, &c);
    a
}

#[inline(always)]
fn add_to<R: Real, const N: usize>(sums: &mut [R; N], others: &[R; N]) {
    for (sum, other) in sums.iter_mut().zip(others) {
        *sum += *other;
    }
}

#[inline(always)]
pub(crate) fn accumulate<R: Real, const N: usize>(sums: &mut [R; N], values: &[f64; N], x: R) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += R::of(*value) * x;
    }
}

/// `beta_r`, then `beta_r beta_s` in the order of [`PAIRS`], then zeros; written out, for no loop over numbers as long as those of a batch
/// is taken apart.
#[rustfmt::skip]
#[inline(always)]
pub(crate) fn velocities<R: Real>(beta: &Vec6<R>) -> [R; VELOCITIES] {
    let ([x, y, z, u, v, w], zero) = (*beta, R::of(0.0));
    [
        x, y, z, u, v, w,
        u * u, u * v, u * w, v * v, v * w, w * w,
        x * u, x * v, x * w, y * u, y * v, y * w, z * u, z * v, z * w,
        x * x, x * y, x * z, y * y, y * z, z * z,
        zero, zero, zero, zero, zero,
    ]
}

/// Products in the order of the columns: `u_l beta_r` (l major), then `q_l beta_r beta_s`, r <= s, in `N` fours, then `beta_r beta_s`.
#[inline(always)]
fn form_products<R: Real, const N: usize>(u: &[R], q: &[R], beta: &Vec6<R>, products: &mut [R]) {
    let (linear, rest) = products.split_at_mut((u.len() * 6).min(products.len()));
    let (quadratic, squares) = rest.split_at_mut((q.len() * 4 * N).min(rest.len()));
    let beta_r = *beta;
    for (products, u) in linear.as_chunks_mut::<6>().0.iter_mut().zip(u) {
        // By value: the compiler need not ask whether the operands overlap.
        let u = *u;
        *products = beta_r.map(|beta| u * beta);
        one_by_one();
    }
    let Some(squares) = squares.as_chunks_mut::<4>().0.first_chunk_mut::<N>() else { return };
    for (square, value) in squares.as_flattened_mut().iter_mut().zip(velocities(beta).iter().skip(6)) {
        *square = *value;
    }
    for (products, q) in quadratic.as_chunks_mut::<4>().0.as_chunks_mut::<N>().0.iter_mut().zip(q) {
        let q = *q;
        for (product, [a, b, c, d]) in products.iter_mut().zip(squares.iter()) {
            *product = [q * *a, q * *b, q * *c, q * *d];
        }
        one_by_one();
    }
}

/// Place of the pair coded `6 r + s` among [`PAIRS`].
fn pair_index(rs: u32) -> usize {
    let pair = (rs as usize / 6, rs as usize % 6);
    PAIRS.iter().position(|&known| known == pair).unwrap_or(PAIRS.len())
}

/// Rows in groups of four: each group starts with the row left over that has the most entries and takes the three
/// that share most columns with it (ties by row number, so that the result depends on nothing else).
#[allow(clippy::indexing_slicing)] // made once, from checked indices
pub(crate) fn row_blocks(rows: &[Vec<(u32, f64)>], n_products: usize) -> Vec<[u32; BLOCK]> {
    let mut left: Vec<usize> = (0..rows.len()).collect();
    let mut blocks = Vec::with_capacity(rows.len().div_ceil(BLOCK));
    let mut used = vec![false; n_products];
    while let Some((at, _)) =
        left.iter().enumerate().max_by_key(|&(at, &row)| (rows[row].len(), core::cmp::Reverse(at)))
    {
        let first = left.remove(at);
        let mut block = [first as u32, u32::MAX, u32::MAX, u32::MAX];
        used.fill(false);
        for &(column, _) in &rows[first] {
            used[column as usize] = true;
        }
        for slot in block.iter_mut().skip(1) {
            let shared = |row: usize| rows[row].iter().filter(|&&(c, _)| used[c as usize]).count() as isize;
            // Columns in common count for, columns the block would have to pad count against.
            let gain = |row: usize| 2 * shared(row) - rows[row].len() as isize;
            let Some((at, _)) =
                left.iter().enumerate().max_by_key(|&(at, &row)| (gain(row), core::cmp::Reverse(at)))
            else {
                break;
            };
            let row = left.remove(at);
            *slot = row as u32;
            for &(column, _) in &rows[row] {
                used[column as usize] = true;
            }
        }
        blocks.push(block);
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::String;

    /// Entries for which `keep` holds, in order, with values that depend on their place only.
    fn tensor(rows: u32, columns: u32, codes: u32, keep: impl Fn(u32, u32, u32) -> bool) -> TensorData {
        let mut t = TensorData {
            i: vec![],
            l: vec![],
            r: vec![],
            value: vec![],
            threshold: 0.0,
            scale: String::new(),
            dropped_norm: 0.0,
            dropped_count: 0,
        };
        for (i, l, r) in
            (0..rows).flat_map(|i| (0..columns).flat_map(move |l| (0..codes).map(move |r| (i, l, r))))
        {
            if keep(i, l, r) {
                t.i.push(i);
                t.l.push(l);
                t.r.push(r);
                t.value.push(libm::sin(f64::from(7 * i + 13 * l + 29 * r + 1)));
            }
        }
        t
    }

    fn check(m: u32, velocities_alone: bool) {
        let ordered = |rs: u32| rs / 6 <= rs % 6 && (velocities_alone || rs % 6 >= 3);
        let c = tensor(m + 6, m + 6, 6, |i, l, r| (i + 2 * l + 3 * r) % 4 == 0);
        let k = tensor(m + 6, m, 36, |i, l, rs| ordered(rs) && (i + l + rs) % 3 != 1);
        let contraction = Contraction::new(m as usize, &c, &k);
        let (stored, held) = contraction.fill();
        assert!(stored == c.value.len() + k.value.len() && held >= stored);
        let number = |i: usize| libm::cos(i as f64);
        let u: Vec<f64> = (0..m as usize + 6).map(number).collect();
        let q: Vec<f64> = (0..m as usize).map(|i| number(i + 20)).collect();
        let beta: Vec6 = core::array::from_fn(|i| number(i + 40));
        let mut expected = vec![0.0; u.len()];
        for entry in 0..c.value.len() {
            let (l, r) = (c.l[entry] as usize, c.r[entry] as usize);
            expected[c.i[entry] as usize] += c.value[entry] * u[l] * beta[r];
        }
        for entry in 0..k.value.len() {
            let (l, rs) = (k.l[entry] as usize, k.r[entry] as usize);
            expected[k.i[entry] as usize] += k.value[entry] * q[l] * beta[rs / 6] * beta[rs % 6];
        }
        let (mut products, mut y) = (contraction.products(), vec![f64::NAN; u.len()]);
        contraction.apply(&u, &q, &beta, &mut products, &mut y);
        for (found, expected) in y.iter().zip(&expected) {
            assert!(
                (found - expected).abs() < 1e-13 * k.value.len().max(10) as f64,
                "{found} instead of {expected}"
            );
        }
    }

    #[test]
    fn contraction_is_the_sum_over_all_entries() {
        // From 11 modes on there is more than one window.
        for m in [0, 1, 3, 6, 10, 11, 40] {
            check(m, false);
            check(m, true);
        }
    }

    #[test]
    fn products_of_velocities_are_in_the_order_of_their_pairs() {
        let beta = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0];
        let all = velocities(&beta);
        assert_eq!(all[..6], beta);
        for (square, (r, s)) in all[6..].iter().zip(PAIRS) {
            assert_eq!(*square, beta[r] * beta[s]);
        }
    }

    #[test]
    fn every_pair_has_its_own_place() {
        let mut seen = [false; 21];
        for rs in (0..36).filter(|rs| rs / 6 <= rs % 6) {
            let place = &mut seen[pair_index(rs)];
            assert!(!*place);
            *place = true;
        }
    }

    #[test]
    fn rows_with_the_same_columns_share_a_block() {
        // Two classes of rows, interleaved: no padding is left.
        let c = tensor(8, 8, 6, |i, l, _| i % 2 == l % 2);
        let k = tensor(8, 2, 36, |_, _, _| false);
        let (stored, held) = Contraction::new(2, &c, &k).fill();
        assert_eq!(stored, held);
    }
}
