//! Products of the amplitudes of second and third order, and polynomials of them with their derivatives (docs/beyond.md).
//!
//! The products of two amplitudes are formed all of them, row by row of `q q^t`, those of three where they occur. Polynomials and their
//! derivatives by the amplitudes are sparse matrices times these.

use alloc::vec::Vec;

use crate::data::PolynomialData;
use crate::dense::rows_mut;
use crate::four::{self, Four, Machine};
use crate::sparse::{Sparse, Terms, windows};

/// Polynomials, four rows side by side in a block.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    /// Factors of the products of three amplitudes.
    triples: Vec<[u32; 3]>,
    /// The polynomials - (blocks).
    values: Sparse,
    /// Their derivatives, mode by mode - (modes x blocks).
    slopes: Sparse,
}

/// Products on a path: one; the amplitudes; the products of two by rows of `q q^t`; those of three. Each padded.
#[derive(Clone, Debug, Default)]
pub(crate) struct Products {
    modes: usize,
    /// Blocks of the amplitudes.
    width: usize,
    value: Vec<Four>,
    /// Second derivatives along the rates.
    second: Vec<Four>,
    /// Rates, without those of the products of three.
    rate: Vec<Four>,
}

/// Amplitudes, products of two and of three.
type Parts<'a> = [&'a mut [Four]; 3];

/// Where the parts are.
#[inline(always)]
fn parts(products: &mut [Four], width: usize, modes: usize) -> Option<Parts<'_>> {
    let (_, rest) = products.split_first_mut()?;
    let (amplitudes, rest) = rest.split_at_mut_checked(width)?;
    let (pairs, triples) = rest.split_at_mut_checked(width * modes)?;
    Some([amplitudes, pairs, triples])
}

impl Products {
    /// For stored polynomials, or some of them.
    pub(crate) fn of<'a>(modes: usize, data: impl Iterator<Item = &'a PolynomialData>) -> Self {
        let triples = distinct(data.flat_map(|it| it.cubic.iter().map(|term| term.1)));
        let width = modes.div_ceil(4);
        let zero = windows(1 + width * (1 + modes) + triples.len().div_ceil(4));
        let mut value = zero.clone();
        if let Some(first) = value.first_mut() {
            *first = [1.0, 0.0, 0.0, 0.0];
        }
        Products { modes, width, value, second: zero.clone(), rate: zero }
    }
}

/// In order, every one once.
pub(crate) fn distinct<const N: usize>(factors: impl Iterator<Item = [u32; N]>) -> Vec<[u32; N]> {
    let mut distinct: Vec<[u32; N]> = factors.collect();
    distinct.sort_unstable();
    distinct.dedup();
    distinct
}

impl Rows {
    /// So many blocks of rows; the rows of the terms are places in them, `4 block + lane`. With the linear terms (row, mode, value) that
    /// are given.
    pub(crate) fn new(
        modes: usize,
        blocks: usize,
        linear: impl Iterator<Item = (usize, usize, f64)>,
        data: &PolynomialData,
    ) -> Self {
        let triples = distinct(data.cubic.iter().map(|term| term.1));
        let width = 4 * modes.div_ceil(4);
        let one = 0;
        let amplitude = |i: u32| 4 + i as usize;
        let pair = |i: u32, j: u32| 4 + width * (1 + i as usize) + j as usize;
        let first_triple = 4 + width * (1 + modes);
        let (mut values, mut slopes) = (Terms::default(), Terms::default());
        let mut slope = |row: usize, mode: u32, place: usize, value: f64| {
            slopes.add(mode as usize * blocks + row / 4, row % 4, place, value);
        };
        for (row, mode, value) in linear {
            values.add(row / 4, row % 4, amplitude(mode as u32), value);
            slope(row, mode as u32, one, value);
        }
        for &(row, [i, j], value) in &data.quadratic {
            let row = row as usize;
            values.add(row / 4, row % 4, pair(i, j), value);
            slope(row, i, amplitude(j), value);
            slope(row, j, amplitude(i), value);
        }
        for &(row, factors, value) in &data.cubic {
            let row = row as usize;
            let triple = first_triple + triples.partition_point(|it| *it < factors);
            values.add(row / 4, row % 4, triple, value);
            let [i, j, k] = factors;
            slope(row, i, pair(j, k), value);
            slope(row, j, pair(i, k), value);
            slope(row, k, pair(i, j), value);
        }
        Rows { triples, values: Sparse::new(values), slopes: Sparse::new(slopes) }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The products at amplitudes.
    #[inline(always)]
    pub(crate) fn at<M: Machine>(&self, m: M, q: &[f64], products: &mut Products) {
        let Products { modes, width, .. } = *products;
        let Some([amplitudes, pairs, triples]) = parts(&mut products.value, width, modes) else { return };
        four::fill(amplitudes, q);
        for (row, q) in rows_mut(pairs, width).zip(q) {
            let q = m.splat(*q);
            for (to, other) in row.iter_mut().zip(amplitudes.iter()) {
                *to = m.store(q * m.load(other));
            }
        }
        let pairs = pairs.as_flattened();
        for (triple, [i, j, k]) in triples.as_flattened_mut().iter_mut().zip(&self.triples) {
            let pair = pairs.get(*i as usize * 4 * width + *j as usize);
            if let (Some(pair), Some(q)) = (pair, q.get(*k as usize)) {
                *triple = pair * q;
            }
        }
    }

    /// The products at amplitudes and rates.
    #[inline(always)]
    pub(crate) fn along<M: Machine>(&self, m: M, q: &[f64], q_dot: &[f64], products: &mut Products) {
        self.at(m, q, products);
        let Products { modes, width, .. } = *products;
        if let Some(rates) = products.rate.get_mut(1..) {
            four::fill(rates, q_dot);
        }
        let Some([_, pairs, triples]) = parts(&mut products.second, width, modes) else { return };
        let rates = products.rate.get(1..).unwrap_or(&[]);
        for (row, q_dot) in rows_mut(pairs, width).zip(q_dot) {
            let twice = m.splat(2.0 * q_dot);
            for (to, other) in row.iter_mut().zip(rates) {
                *to = m.store(twice * m.load(other));
            }
        }
        let pairs = pairs.as_flattened();
        let pair = |i: u32, j: u32| pairs.get(i as usize * 4 * width + j as usize).copied();
        let amplitude = |i: u32| q.get(i as usize).copied();
        for (triple, &[i, j, k]) in triples.as_flattened_mut().iter_mut().zip(&self.triples) {
            if let (Some(ij), Some(ik), Some(jk), Some(x), Some(y), Some(z)) =
                (pair(i, j), pair(i, k), pair(j, k), amplitude(i), amplitude(j), amplitude(k))
            {
                *triple = ij * z + ik * y + jk * x;
            }
        }
    }

    /// Values and derivatives at the products of [`Self::at`], where the rows have terms.
    #[inline(always)]
    pub(crate) fn evaluate<M: Machine>(&self, m: M, at: &Products, values: &mut [Four], slopes: &mut [Four]) {
        self.slopes.apply(m, &at.value, slopes);
        self.values.apply(m, &at.value, values);
    }

    /// The same and second derivatives along the rates, at the products of [`Self::along`].
    #[inline(always)]
    pub(crate) fn evaluate_along<M: Machine>(
        &self,
        m: M,
        at: &Products,
        values: &mut [Four],
        seconds: &mut [Four],
        slopes: &mut [Four],
    ) {
        self.slopes.apply(m, &at.value, slopes);
        self.values.for_each(m, [&at.value, &at.second], |block, more, [value, second]| {
            if let (Some(to), Some(to_second)) = (values.get_mut(block), seconds.get_mut(block)) {
                let (before, before_second) =
                    if more { (m.load(to), m.load(to_second)) } else { (m.zero(), m.zero()) };
                (*to, *to_second) = (m.store(before + value), m.store(before_second + second));
            }
        });
    }

    /// Rates of the derivatives, at the products of [`Self::along`].
    #[inline(always)]
    pub(crate) fn slope_rates<M: Machine>(&self, m: M, at: &mut Products, slope_rates: &mut [Four]) {
        let Products { width, modes, value, rate, .. } = at;
        let (Some([q, ..]), Some([q_dot, pairs, _])) =
            (parts(value, *width, *modes), parts(rate, *width, *modes))
        else {
            return;
        };
        // (q_i q_j)_dot = q_i_dot q_j + q_i q_j_dot
        let each = q.as_flattened().iter().zip(q_dot.as_flattened());
        for (row, (x, dx)) in rows_mut(pairs, *width).zip(each) {
            let (x, dx) = (m.splat(*x), m.splat(*dx));
            for (to, (q, q_dot)) in row.iter_mut().zip(q.iter().zip(q_dot.iter())) {
                *to = m.store(dx * m.load(q) + x * m.load(q_dot));
            }
        }
        self.slopes.apply(m, &at.rate, slope_rates);
    }
}
