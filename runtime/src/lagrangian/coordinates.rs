//! The kinetic coordinates `y(q)` of (B.3), laid out for their derivatives.
//!
//! All that a step needs of them follows from `D = dy/dq` and its rate on the path: with the products `p` of one and two amplitudes
//! that `D` is made of, `D = A + E p`, `D_dot = E p_dot`, `y = (A + E p/(order + 1)) q`. One pass over the entries of `E` gives the three,
//! for four columns of `D` at a time.

use alloc::{collections::BTreeMap, vec, vec::Vec};

use crate::data::{LagrangianData, PolynomialData};
use crate::dense::{rows, rows_mut};
use crate::four::{self, Four};
use crate::products::Products;

/// `y(q)` by rows.
#[derive(Clone, Debug)]
pub(super) struct Coordinates {
    n: usize,
    modes: usize,
    products: Products,
    /// Four columns of a row: `A`, and where their terms end - (n rows).
    cells: Vec<(Four, usize)>,
    /// Product, and its factors in the four columns.
    terms: Vec<(u32, Four)>,
    /// Number of terms in `y` beyond the linear ones.
    n_terms: usize,
}

/// The coordinates on a path.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    /// `p`, `p_dot`, `p/(order + 1)` of each product, each four times: what an entry is multiplied with is read, not spread.
    products: Vec<[Four; 3]>,
    /// Amplitudes and rates, padded.
    pub(super) q: Vec<Four>,
    pub(super) q_dot: Vec<Four>,
    /// What is summed up to `y`, its rate and its second derivative - (n).
    parts: Vec<[Four; 3]>,
    /// `(y, y, y_dot, y_dot)` - (n).
    pub(super) y: Vec<Four>,
    /// Second derivatives along the rates - (n).
    pub(super) second: Vec<f64>,
    /// `D` and its rate - (n rows).
    pub(super) d: Vec<Four>,
    pub(super) d_dot: Vec<Four>,
}

impl Coordinates {
    pub(super) fn new(modes: usize, data: &LagrangianData) -> Self {
        let n = data.fields as usize;
        let derivatives = derivatives(&data.curve);
        let products = Products::new(modes, derivatives.iter().map(|(_, _, rest, _)| &rest[..]));
        let linear = |row: usize, column: usize| data.linear.get(row * modes + column).copied();
        let linear = four::padded(n, modes, |row, column| linear(row, column).unwrap_or(0.0));
        let (mut cells, mut terms) = (Vec::new(), Vec::new());
        let blocks = modes.div_ceil(4).max(1);
        for (at, linear) in linear.into_iter().enumerate() {
            let (row, block) = (at / blocks, at % blocks);
            let mut of_cell: BTreeMap<u32, Four> = BTreeMap::new();
            let first = derivatives.partition_point(|it| (it.0 as usize) < row);
            for (_, column, rest, factor) in
                derivatives.iter().skip(first).take_while(|it| it.0 as usize == row)
            {
                let lane = (*column as usize).checked_sub(4 * block).filter(|lane| *lane < 4);
                if let (Some(lane), Some(product)) = (lane, products.place(rest))
                    && let Some(place) = of_cell.entry(product as u32).or_default().get_mut(lane)
                {
                    *place = *factor;
                }
            }
            terms.extend(of_cell);
            cells.push((linear, terms.len()));
        }
        let n_terms = data.curve.quadratic.len() + data.curve.cubic.len();
        Coordinates { n, modes, products, cells, terms, n_terms }
    }

    pub(super) fn n_terms(&self) -> usize {
        self.n_terms
    }

    pub(super) fn path(&self) -> Path {
        let (n, blocks) = (self.n, self.modes.div_ceil(4));
        Path {
            products: vec![[[0.0; 4]; 3]; self.products.len_quadratic()],
            q: vec![[0.0; 4]; blocks],
            q_dot: vec![[0.0; 4]; blocks],
            parts: vec![[[0.0; 4]; 3]; n],
            y: vec![[0.0; 4]; n],
            second: vec![0.0; n],
            d: vec![[0.0; 4]; n * blocks],
            d_dot: vec![[0.0; 4]; n * blocks],
        }
    }

    /// `y`, its rate, its second derivative along the rates, and `D`.
    #[inline(always)]
    pub(super) fn evaluate(&self, q: &[f64], q_dot: &[f64], at: &mut Path) {
        self.prepare(q, q_dot, at);
        let blocks = at.q.len().max(1);
        let Path { products, q, q_dot, parts, y, second, d, d_dot } = at;
        let mut start = 0;
        let lines = rows_mut(d, blocks).zip(rows_mut(d_dot, blocks));
        for (((d, d_dot), cells), parts) in lines.zip(rows(&self.cells, blocks)).zip(parts.iter_mut()) {
            *parts = [[0.0; 4]; 3];
            let columns = d.iter_mut().zip(d_dot).zip(q.iter().zip(q_dot.iter()));
            for (((d, d_dot), (&q, &q_dot)), &(linear, end)) in columns.zip(cells) {
                let (mut derivative, mut rate, mut mean) = (linear, [0.0; 4], linear);
                for &(product, factors) in self.terms.get(start..end).unwrap_or(&[]) {
                    if let Some(&[p, p_dot, p_mean]) = products.get(product as usize) {
                        derivative = four::plus_product(derivative, p, factors);
                        rate = four::plus_product(rate, p_dot, factors);
                        mean = four::plus_product(mean, p_mean, factors);
                    }
                }
                start = end;
                (*d, *d_dot) = (derivative, rate);
                let [values, rates, seconds] = *parts;
                *parts = [
                    four::plus_product(values, mean, q),
                    four::plus_product(rates, derivative, q_dot),
                    four::plus_product(seconds, rate, q_dot),
                ];
            }
        }
        // Apart, or the compiler mixes the sums of the three with those of the four.
        for (parts, (y, second)) in parts.iter().zip(y.iter_mut().zip(second)) {
            let [value, rate, along] = [&parts[0], &parts[1], &parts[2]].map(four::sum);
            *y = [value, value, rate, rate];
            *second = along;
        }
    }

    #[inline(always)]
    fn prepare(&self, q: &[f64], q_dot: &[f64], at: &mut Path) {
        four::fill(&mut at.q, q);
        four::fill(&mut at.q_dot, q_dot);
        let Some((linear, quadratic)) = at.products.split_at_mut_checked(self.modes) else { return };
        for (product, (q, q_dot)) in linear.iter_mut().zip(q.iter().zip(q_dot)) {
            *product = [[*q; 4], [*q_dot; 4], [0.5 * q; 4]];
        }
        for (product, &[i, j]) in quadratic.iter_mut().zip(self.products.pairs()) {
            if let (Some(&[[x, ..], [dx, ..], _]), Some(&[[y, ..], [dy, ..], _])) =
                (linear.get(i), linear.get(j))
            {
                *product = [[x * y; 4], [dx * y + x * dy; 4], [x * y * (1.0 / 3.0); 4]];
            }
        }
    }
}

/// The terms of `D`: row, column, the factors left, coefficient; sorted.
fn derivatives(curve: &PolynomialData) -> Vec<(u32, u32, Vec<u32>, f64)> {
    let quadratic = curve.quadratic.iter().map(|(row, factors, value)| (*row, &factors[..], *value));
    let cubic = curve.cubic.iter().map(|(row, factors, value)| (*row, &factors[..], *value));
    let mut out = Vec::new();
    for (row, factors, value) in quadratic.chain(cubic) {
        let mut last = None;
        for (at, &column) in factors.iter().enumerate() {
            // Factors ascend: equal ones follow each other.
            if last != Some(column) {
                let count = factors.iter().filter(|&&other| other == column).count();
                let rest = factors.iter().enumerate().filter(|(other, _)| *other != at);
                out.push((row, column, rest.map(|(_, i)| *i).collect(), value * count as f64));
            }
            last = Some(column);
        }
    }
    out.sort_by(|a, b| (a.0, a.1, &a.2).cmp(&(b.0, b.1, &b.2)));
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::TensorData;
    use crate::polynomial::Polynomial;
    use alloc::string::String;

    #[test]
    fn values_and_derivatives_are_those_of_the_polynomials() {
        let curve = PolynomialData {
            quadratic: vec![(0, [0, 0], 1.0), (0, [0, 4], 2.0), (6, [1, 3], -0.7)],
            cubic: vec![(2, [0, 0, 4], -1.0), (2, [4, 4, 4], 3.0), (6, [0, 1, 2], 0.3), (6, [1, 1, 3], 0.9)],
        };
        let (m, n) = (5, 7);
        let linear: Vec<f64> =
            (0..m * m).map(|k| if k % m >= k / m { 1.0 / (k + 1) as f64 } else { 0.0 }).collect();
        let none = TensorData {
            i: vec![],
            l: vec![],
            r: vec![],
            value: vec![],
            threshold: 0.0,
            scale: String::new(),
            dropped_norm: 0.0,
            dropped_count: 0,
        };
        let data = LagrangianData {
            geometric: true,
            fields: n as u32,
            linear: linear.clone(),
            curve: curve.clone(),
            first_moment: vec![],
            moment_0: vec![],
            moment: none,
            stiffness: vec![],
            self_stress: vec![],
            self_stress_curve: PolynomialData::default(),
            points: vec![],
            range: vec![],
            tolerance: 0.0,
            dropped_norm: 0.0,
        };
        let coordinates = Coordinates::new(m, &data);
        let mut path = coordinates.path();
        let (q, q_dot) = ([0.5, -0.75, 0.2, 1.1, -0.4], [2.0, 1.25, -0.3, 0.6, 0.9]);
        coordinates.evaluate(&q, &q_dot, &mut path);
        let polynomial = Polynomial::new(n, &curve);
        let (mut y, mut rate, mut second) = ([0.0; 7], [0.0; 7], [0.0; 7]);
        polynomial.along(&q, &q_dot, &mut y, &mut rate, &mut second);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-14;
        for row in 0..n {
            let row_of_a = |i: usize| if row < m { linear[row * m + i] } else { 0.0 };
            let line = |x: &[f64]| (0..m).map(|i| row_of_a(i) * x[i]).sum::<f64>();
            assert!(close(path.y[row][0], y[row] + line(&q)));
            assert!(close(path.y[row][2], rate[row] + line(&q_dot)));
            assert!(close(path.second[row], second[row]));
            for k in 0..m {
                let (mut direction, mut out) = ([0.0; 5], [0.0; 7]);
                direction[k] = 1.0;
                polynomial.derivative(&q, &direction, &mut out);
                let expected = out[row] + line(&direction);
                assert!(close(path.d[2 * row + k / 4][k % 4], expected), "{row} {k}");
            }
        }
    }
}
