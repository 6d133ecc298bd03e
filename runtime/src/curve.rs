//! What bends displacements and self-stress off the plane of the modes: polynomials of second and third order laid out for values and
//! for the work of forces on them (docs/beyond.md).

use alloc::{vec, vec::Vec};

use crate::data::PolynomialData;
use crate::four::{self, Four};
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
        let mut curve = Curve { products: Products::default(), ..Curve::default() };
        for block in row_blocks(&rows, products.len()) {
            curve.push(block, &rows, products.len());
        }
        curve.products = products;
        curve
    }

    fn push(&mut self, block: [u32; 4], rows: &[Vec<(u32, f64)>], n_products: usize) {
        let mut of_product: Vec<Option<Four>> = vec![None; n_products];
        for (lane, &row) in block.iter().enumerate() {
            for &(product, value) in rows.get(row as usize).map_or(&[][..], Vec::as_slice) {
                let values = of_product.get_mut(product as usize).map(|it| it.get_or_insert([0.0; 4]));
                if let Some(place) = values.and_then(|values| values.get_mut(lane)) {
                    *place = value;
                }
            }
        }
        let terms = of_product.into_iter().enumerate();
        self.terms.extend(terms.filter_map(|(product, values)| Some((product as u32, values?))));
        self.ends.push(self.terms.len());
        self.rows.push(block);
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

    /// Rows and terms of each block.
    #[inline(always)]
    fn blocks(&self) -> impl Iterator<Item = (&[u32; 4], &[(u32, Four)])> {
        let starts = core::iter::once(0).chain(self.ends.iter().copied());
        let terms = starts.zip(&self.ends).map(|(start, &end)| self.terms.get(start..end).unwrap_or(&[]));
        self.rows.iter().zip(terms)
    }

    /// Adds the values at amplitudes to the rows.
    #[inline(always)]
    pub(crate) fn add_values(&self, q: &[f64], scratch: &mut CurveScratch, out: &mut [f64]) {
        self.products.values(q, &mut scratch.values);
        let values = scratch.values.as_slice();
        for (rows, terms) in self.blocks() {
            let mut sums = [0.0; 4];
            for &(product, coefficients) in terms {
                let value = values.get(product as usize).copied().unwrap_or(0.0);
                sums = four::plus(sums, value, coefficients);
            }
            for (&row, sum) in rows.iter().zip(sums) {
                if let Some(out) = out.get_mut(row as usize) {
                    *out += sum;
                }
            }
        }
    }

    /// Adds `sum over rows of force drow/dq_i`, at the amplitudes of [`Self::add_values`].
    #[inline(always)]
    pub(crate) fn pull_back(&self, force: &[f64], scratch: &mut CurveScratch, out: &mut [f64]) {
        let CurveScratch { values, weights } = scratch;
        weights.fill(0.0);
        for (rows, terms) in self.blocks() {
            let forces = rows.map(|row| force.get(row as usize).copied().unwrap_or(0.0));
            for &(product, coefficients) in terms {
                if let Some(weight) = weights.get_mut(product as usize) {
                    *weight += four::sum(&four::plus_product([0.0; 4], coefficients, forces));
                }
            }
        }
        self.products.pull_back(values, weights, out);
    }
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
