//! What bends displacements and self-stress off the plane of the modes: polynomials of second and third order laid out for values and
//! for the work of forces on them (docs/beyond.md).

use alloc::{vec, vec::Vec};

use crate::data::PolynomialData;
use crate::dense::rows;
use crate::four::{self, Four, Kernel, Machine};
use crate::products::{Products, Rows, distinct};
use crate::tensor::row_blocks;

/// Rows in blocks of four that share as many products as possible.
#[derive(Clone, Debug, Default)]
pub(crate) struct Curve {
    /// The rows of each block; `u32::MAX` where there is none.
    rows: Vec<[u32; 4]>,
    polynomials: Rows,
}

/// Scratch for curves.
#[derive(Clone, Debug, Default)]
pub(crate) struct CurveScratch {
    products: Products,
    /// Values, then forces on the rows - (blocks).
    values: Vec<Four>,
    /// Derivatives by the amplitudes, mode by mode - (modes x blocks).
    slopes: Vec<Four>,
}

impl CurveScratch {
    /// For curves of up to so many rows picked from some polynomials.
    pub(crate) fn new<'a>(
        modes: usize,
        rows: usize,
        data: impl Iterator<Item = &'a PolynomialData> + Clone,
    ) -> Self {
        let blocks = if data.clone().next().is_some() { rows.div_ceil(4) } else { 0 };
        CurveScratch {
            products: Products::of(modes, data),
            values: vec![[0.0; 4]; blocks],
            slopes: vec![[0.0; 4]; blocks * modes],
        }
    }
}

impl Curve {
    /// Rows picked from several polynomials, in that order: (polynomial, row).
    pub(crate) fn gather<'a>(
        modes: usize,
        rows: impl Iterator<Item = (&'a PolynomialData, usize)> + Clone,
    ) -> Self {
        // The rows by the order in which they were picked.
        let mut picked = PolynomialData::default();
        for (place, (data, row)) in rows.clone().enumerate() {
            let quadratic = data.quadratic.iter().filter(|term| term.0 as usize == row);
            picked.quadratic.extend(quadratic.map(|term| (place as u32, term.1, term.2)));
            let cubic = data.cubic.iter().filter(|term| term.0 as usize == row);
            picked.cubic.extend(cubic.map(|term| (place as u32, term.1, term.2)));
        }
        let pairs = distinct(picked.quadratic.iter().map(|term| term.1));
        let triples = distinct(picked.cubic.iter().map(|term| term.1));
        let mut columns: Vec<Vec<(u32, f64)>> = vec![Vec::new(); rows.count()];
        for (row, factors, value) in &picked.quadratic {
            if let Some(of_row) = columns.get_mut(*row as usize) {
                of_row.push((pairs.partition_point(|it| it < factors) as u32, *value));
            }
        }
        for (row, factors, value) in &picked.cubic {
            if let Some(of_row) = columns.get_mut(*row as usize) {
                of_row.push(((pairs.len() + triples.partition_point(|it| it < factors)) as u32, *value));
            }
        }
        let blocks = row_blocks(&columns, pairs.len() + triples.len());
        let mut places = vec![0; columns.len()];
        for (place, row) in blocks.as_flattened().iter().enumerate() {
            if let Some(to) = places.get_mut(*row as usize) {
                *to = place as u32;
            }
        }
        let place = |row: u32| places.get(row as usize).copied().unwrap_or(0);
        picked.quadratic.iter_mut().for_each(|term| term.0 = place(term.0));
        picked.cubic.iter_mut().for_each(|term| term.0 = place(term.0));
        Curve { polynomials: Rows::new(modes, blocks.len(), core::iter::empty(), &picked), rows: blocks }
    }

    /// All rows of one polynomial.
    pub(crate) fn of(modes: usize, rows: usize, data: &PolynomialData) -> Self {
        Curve::gather(modes, (0..rows).map(|row| (data, row)))
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.polynomials.is_empty()
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
        let CurveScratch { products, values, slopes } = scratch;
        let blocks = curve.rows.len();
        let (Some(values), Some(slopes)) = (values.get_mut(..blocks), slopes.get_mut(..blocks * q.len()))
        else {
            return;
        };
        // Another curve may have been here.
        values.fill([0.0; 4]);
        slopes.fill([0.0; 4]);
        curve.polynomials.at(m, q, products);
        curve.polynomials.evaluate(m, products, values, slopes);
        for (&row, value) in curve.rows.as_flattened().iter().zip(values.as_flattened()) {
            if let Some(out) = out.get_mut(row as usize) {
                *out += value;
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
        let CurveScratch { values, slopes, .. } = scratch;
        let Some(forces) = values.get_mut(..curve.rows.len()) else { return };
        for (to, &row) in forces.as_flattened_mut().iter_mut().zip(curve.rows.as_flattened()) {
            *to = force.get(row as usize).copied().unwrap_or(0.0);
        }
        for (out, slopes) in out.iter_mut().zip(rows(slopes, forces.len())) {
            *out += m.dot(slopes, forces);
        }
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
        let mut scratch = CurveScratch::new(2, 3, [&data].into_iter());
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
        picked.add_values(&q, &mut CurveScratch::new(2, 2, [&data].into_iter()), &mut v);
        assert!(close(v[0], value[2]) && close(v[1], value[0]));
    }
}
