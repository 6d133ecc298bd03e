//! The kinetic coordinates `y(q)` of (B.3) with their derivatives, four coordinates side by side.

use alloc::{vec, vec::Vec};

use super::arrangement::Arrangement;
use crate::data::LagrangianData;
use crate::dense::rows;
use crate::four::{Four, Machine};
use crate::products::{Products, Rows};
use crate::sparse::windows;

/// Linear terms below this times the largest are round-off of what symmetry makes zero.
const ROUND_OFF: f64 = 1e-12;

/// `y(q)` by blocks of four.
#[derive(Clone, Debug)]
pub(super) struct Coordinates {
    modes: usize,
    blocks: usize,
    curve: Rows,
    n_terms: usize,
}

/// The coordinates on a path.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    products: Products,
    /// `y` and its rate, followed by one and by zero - (blocks + 1, padded).
    pub(super) y: Vec<Four>,
    pub(super) y_dot: Vec<Four>,
    /// Second derivative of `y` along the rates - (blocks).
    pub(super) second: Vec<Four>,
    /// `D = dy/dq`, column by column; a column of zeros last where there are odd many - (columns x blocks).
    pub(super) d: Vec<Four>,
    /// Its rate, where it is asked for - (columns x blocks).
    d_dot: Vec<Four>,
}

impl Coordinates {
    pub(super) fn new(modes: usize, arrangement: &Arrangement, data: &LagrangianData) -> Self {
        let blocks = arrangement.blocks();
        let largest = data.linear.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let linear = data.linear.iter().enumerate().filter(|(_, value)| value.abs() > ROUND_OFF * largest);
        let linear = linear.map(|(at, value)| (arrangement.place((at / modes) as u32), at % modes, *value));
        Coordinates {
            modes,
            blocks,
            curve: Rows::new(modes, blocks, linear, &arrangement.placed(&data.curve)),
            n_terms: data.curve.quadratic.len() + data.curve.cubic.len(),
        }
    }

    pub(super) fn n_terms(&self) -> usize {
        self.n_terms
    }

    pub(super) fn path(&self, data: &LagrangianData) -> Path {
        let Coordinates { modes, blocks, .. } = *self;
        let zeros = |n: usize| vec![[0.0; 4]; n];
        let mut y = windows(blocks + 1);
        if let Some(last) = y.get_mut(blocks) {
            *last = [1.0, 0.0, 0.0, 0.0];
        }
        Path {
            products: Products::of(modes, core::iter::once(&data.curve)),
            y,
            y_dot: windows(blocks + 1),
            second: zeros(blocks),
            d: zeros(modes.next_multiple_of(2) * blocks),
            d_dot: zeros(modes.next_multiple_of(2) * blocks),
        }
    }

    /// `y`, its rate, its second derivative along the rates, and `D`.
    #[inline(always)]
    pub(super) fn evaluate<M: Machine>(&self, m: M, q: &[f64], q_dot: &[f64], at: &mut Path) {
        let Path { products, y, y_dot, second, d, .. } = at;
        self.curve.along(m, q, q_dot, products);
        self.curve.evaluate_along(m, products, y, second, d);
        for (block, y_dot) in y_dot.iter_mut().take(self.blocks).enumerate() {
            let (mut even, mut odd) = (m.zero(), m.zero());
            let column = |columns: &[Four], at: usize| columns.get(at).map(|column| m.load(column));
            let (pairs, last) = q_dot.as_chunks::<2>();
            let (of_pairs, rest) = d.split_at_checked(2 * pairs.len() * self.blocks).unwrap_or_default();
            for ([a, b], columns) in pairs.iter().zip(rows(of_pairs, 2 * self.blocks)) {
                if let (Some(x), Some(y)) = (column(columns, block), column(columns, self.blocks + block)) {
                    (even, odd) = (even + m.splat(*a) * x, odd + m.splat(*b) * y);
                }
            }
            if let ([a], Some(x)) = (last, column(rest, block)) {
                even = even + m.splat(*a) * x;
            }
            *y_dot = m.store(even + odd);
        }
    }

    /// Adds `factor D_dot^t along` at the amplitudes and rates evaluated last.
    #[inline(always)]
    pub(super) fn add_rate_pull_back<M: Machine>(
        &self,
        m: M,
        factor: f64,
        along: &[Four],
        at: &mut Path,
        out: &mut [f64],
    ) {
        self.curve.slope_rates(m, &mut at.products, &mut at.d_dot);
        for (out, column) in out.iter_mut().zip(rows(&at.d_dot, self.blocks)) {
            *out += factor * m.dot(column, along);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{PolynomialData, TensorData};
    use crate::four::Plain;
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
        let arrangement = Arrangement::new(m, &data);
        let coordinates = Coordinates::new(m, &arrangement, &data);
        let mut path = coordinates.path(&data);
        let (q, q_dot) = ([0.5, -0.75, 0.2, 1.1, -0.4], [2.0, 1.25, -0.3, 0.6, 0.9]);
        coordinates.evaluate(Plain, &q, &q_dot, &mut path);
        let polynomial = Polynomial::new(n, &curve);
        let (mut y, mut rate, mut second) = ([0.0; 7], [0.0; 7], [0.0; 7]);
        polynomial.along(&q, &q_dot, &mut y, &mut rate, &mut second);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-14;
        // `D_dot` of one row at a time, by its definition: differences of `D` along the rates are exact to second degree.
        let derivative = |q: &[f64], row: usize, k: usize| {
            let (mut direction, mut out) = ([0.0; 5], [0.0; 7]);
            direction[k] = 1.0;
            polynomial.derivative(q, &direction, &mut out);
            out[row]
        };
        let moved = |h: f64| -> Vec<f64> { q.iter().zip(&q_dot).map(|(q, rate)| q + h * rate).collect() };
        let (before, after) = (moved(-0.5), moved(0.5));
        for row in 0..n {
            let place = arrangement.place(row as u32);
            let (block, lane) = (place / 4, place % 4);
            let row_of_a = |i: usize| if row < m { linear[row * m + i] } else { 0.0 };
            let line = |x: &[f64]| (0..m).map(|i| row_of_a(i) * x[i]).sum::<f64>();
            assert!(close(path.y[block][lane], y[row] + line(&q)));
            assert!(close(path.y_dot[block][lane], rate[row] + line(&q_dot)));
            assert!(close(path.second[block][lane], second[row]));
            let mut along = vec![[0.0; 4]; arrangement.blocks()];
            along[block][lane] = 1.5;
            let mut rates = vec![0.25; m];
            coordinates.add_rate_pull_back(Plain, 2.0, &along, &mut path, &mut rates);
            for k in 0..m {
                let expected = derivative(&q, row, k) + row_of_a(k);
                assert!(close(path.d[k * arrangement.blocks() + block][lane], expected), "{row} {k}");
                let expected = 0.25 + 3.0 * (derivative(&after, row, k) - derivative(&before, row, k));
                assert!((rates[k] - expected).abs() < 1e-13, "{row} {k}: {} {expected}", rates[k]);
            }
        }
    }
}
