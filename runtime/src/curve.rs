//! What bends displacements and self-stress off the plane of the modes: polynomials of second and third order laid out for values and
//! for the work of forces on them (docs/beyond.md).

use alloc::{vec, vec::Vec};

use crate::data::PolynomialData;
use crate::four::{self, Four, Kernel, Machine};
use crate::products::Products;
use crate::tensor::row_blocks;

/// Rows in blocks of four that share as many products as possible.
#[derive(Clone, Debug, Default)]
pub(crate) struct Curve {
    products: Products,
    /// The rows of each block; `u32::MAX` where there is none.
    rows: Vec<[u32; 4]>,
    /// Where the terms of each block end.
    ends: Vec<usize>,
    /// Product, and its coefficient in each of the four rows.
    terms: Vec<(u32, Four)>,
    /// The same by products.
    transposed: Transposed,
}

/// Products in blocks of four that share as many rows as possible.
#[derive(Clone, Debug, Default)]
struct Transposed {
    products: Vec<[u32; 4]>,
    ends: Vec<usize>,
    /// Row, and its coefficient of each of the four products.
    terms: Vec<(u32, Four)>,
}

/// Scratch for curves.
#[derive(Clone, Debug, Default)]
pub(crate) struct CurveScratch {
    values: Vec<f64>,
    weights: Vec<f64>,
}

impl CurveScratch {
    /// For curves of up to so many products.
    pub(crate) fn new(products: &Products) -> Self {
        CurveScratch { values: vec![0.0; products.len()], weights: vec![0.0; products.len()] }
    }
}

impl Curve {
    /// Rows picked from several polynomials, in that order: (polynomial, row).
    pub(crate) fn gather<'a>(
        modes: usize,
        rows: impl Iterator<Item = (&'a PolynomialData, usize)> + Clone,
    ) -> Self {
        let terms = |data: &'a PolynomialData, row: usize| {
            let quadratic = data.quadratic.iter().map(|(r, factors, value)| (*r, &factors[..], *value));
            let cubic = data.cubic.iter().map(|(r, factors, value)| (*r, &factors[..], *value));
            quadratic.chain(cubic).filter(move |term| term.0 as usize == row)
        };
        let factors = rows.clone().flat_map(|(data, row)| terms(data, row)).map(|term| term.1);
        let products = Products::new(modes, factors);
        let term = |term: (u32, &[u32], f64)| Some((products.place(term.1)? as u32, term.2));
        let rows: Vec<Vec<(u32, f64)>> =
            rows.map(|(data, row)| terms(data, row).filter_map(term).collect()).collect();
        let (blocks, ends, terms) = blocks(&rows, products.len());
        let mut of_product: Vec<Vec<(u32, f64)>> = vec![Vec::new(); products.len()];
        for (row, of_row) in rows.iter().enumerate() {
            for &(product, value) in of_row {
                if let Some(list) = of_product.get_mut(product as usize) {
                    list.push((row as u32, value));
                }
            }
        }
        let (of_products, back_ends, back) = self::blocks(&of_product, rows.len());
        let transposed = Transposed { products: of_products, ends: back_ends, terms: back };
        Curve { products, rows: blocks, ends, terms, transposed }
    }

    /// All rows of one polynomial.
    pub(crate) fn of(modes: usize, rows: usize, data: &PolynomialData) -> Self {
        Curve::gather(modes, (0..rows).map(|row| (data, row)))
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    pub(crate) fn products(&self) -> &Products {
        &self.products
    }

    /// Adds the values at amplitudes to the rows.
    #[inline]
    pub(crate) fn add_values(&self, q: &[f64], scratch: &mut CurveScratch, out: &mut [f64]) {
        four::run(AddValues { curve: self, q, scratch, out });
    }

    /// Adds `sum over rows of force drow/dq_i`, at the amplitudes of [`Self::add_values`].
    #[inline]
    pub(crate) fn pull_back(&self, force: &[f64], scratch: &mut CurveScratch, out: &mut [f64]) {
        four::run(PullBack { curve: self, force, scratch, out });
    }
}

/// A call of [`Curve::add_values`].
struct AddValues<'a> {
    curve: &'a Curve,
    q: &'a [f64],
    scratch: &'a mut CurveScratch,
    out: &'a mut [f64],
}

impl Kernel for AddValues<'_> {
    type Output = ();

    #[inline(always)]
    fn on<M: Machine>(self, m: M) {
        let AddValues { curve, q, scratch, out } = self;
        curve.products.values(q, &mut scratch.values);
        let mut start = 0;
        for (rows, &end) in curve.rows.iter().zip(&curve.ends) {
            let sums = sums(m, curve.terms.get(start..end), &scratch.values);
            start = end;
            for (&row, sum) in rows.iter().zip(sums) {
                if let Some(out) = out.get_mut(row as usize) {
                    *out += sum;
                }
            }
        }
    }
}

/// A call of [`Curve::pull_back`].
struct PullBack<'a> {
    curve: &'a Curve,
    force: &'a [f64],
    scratch: &'a mut CurveScratch,
    out: &'a mut [f64],
}

impl Kernel for PullBack<'_> {
    type Output = ();

    #[inline(always)]
    fn on<M: Machine>(self, m: M) {
        let PullBack { curve, force, scratch, out } = self;
        let CurveScratch { values, weights } = scratch;
        weights.fill(0.0);
        let Transposed { products, ends, terms } = &curve.transposed;
        let mut start = 0;
        for (products, &end) in products.iter().zip(ends) {
            let sums = sums(m, terms.get(start..end), force);
            start = end;
            for (&product, sum) in products.iter().zip(sums) {
                if let Some(weight) = weights.get_mut(product as usize) {
                    *weight = sum;
                }
            }
        }
        curve.products.pull_back(values, weights, out);
    }
}

/// `sum value_k c_k`.
#[inline(always)]
fn sums<M: Machine>(m: M, terms: Option<&[(u32, Four)]>, values: &[f64]) -> Four {
    let mut sums = m.zero();
    for (place, coefficients) in terms.unwrap_or(&[]) {
        if let Some(&value) = values.get(*place as usize) {
            sums = sums + m.splat(value) * m.load(coefficients);
        }
    }
    m.store(sums)
}

/// A sparse matrix in blocks of four rows that share as many columns as possible: the rows of each block, where its terms end, and these.
fn blocks(rows: &[Vec<(u32, f64)>], n_columns: usize) -> (Vec<[u32; 4]>, Vec<usize>, Vec<(u32, Four)>) {
    let (mut kept, mut ends, mut terms) = (Vec::new(), Vec::new(), Vec::new());
    for block in row_blocks(rows, n_columns) {
        let mut of_column: Vec<Option<Four>> = vec![None; n_columns];
        for (lane, &row) in block.iter().enumerate() {
            for &(column, value) in rows.get(row as usize).map_or(&[][..], Vec::as_slice) {
                let values = of_column.get_mut(column as usize).map(|it| it.get_or_insert([0.0; 4]));
                if let Some(place) = values.and_then(|values| values.get_mut(lane)) {
                    *place = value;
                }
            }
        }
        let before = terms.len();
        let columns = of_column.into_iter().enumerate();
        terms.extend(columns.filter_map(|(column, values)| Some((column as u32, values?))));
        if terms.len() > before {
            ends.push(terms.len());
            kept.push(block);
        }
    }
    (kept, ends, terms)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_their_pull_back() {
        // y_0 = 2 q_0 q_1 + q_0^2, y_1 = 0, y_2 = -q_0^2 q_1 + 3 q_1^3.
        let data = PolynomialData {
            quadratic: vec![(0, [0, 0], 1.0), (0, [0, 1], 2.0)],
            cubic: vec![(2, [0, 0, 1], -1.0), (2, [1, 1, 1], 3.0)],
        };
        let q = [0.5, -0.75];
        let [x, y] = q;
        let value = [2.0 * x * y + x * x, 0.0, -x * x * y + 3.0 * y * y * y];
        let gradient = [[2.0 * y + 2.0 * x, 2.0 * x], [0.0; 2], [-2.0 * x * y, -x * x + 9.0 * y * y]];
        let close = |a: f64, b: f64| (a - b).abs() < 1e-14;
        let curve = Curve::of(2, 3, &data);
        let mut scratch = CurveScratch::new(curve.products());
        let mut v = [1.0; 3];
        curve.add_values(&q, &mut scratch, &mut v);
        assert!((0..3).all(|row| close(v[row], 1.0 + value[row])), "{v:?}");
        let (force, mut back) = ([0.3, 7.0, -1.1], [0.5; 2]);
        curve.pull_back(&force, &mut scratch, &mut back);
        for i in 0..2 {
            let expected: f64 = (0..3).map(|row| force[row] * gradient[row][i]).sum();
            assert!(close(back[i], 0.5 + expected), "{back:?}");
        }
        let picked = Curve::gather(2, [(&data, 2), (&data, 0)].into_iter());
        let mut v = [0.0; 2];
        picked.add_values(&q, &mut CurveScratch::new(picked.products()), &mut v);
        assert!(close(v[0], value[2]) && close(v[1], value[0]));
    }
}
