//! Mass matrix and momenta of a stored Lagrangian.

use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3};
use rom_runtime::data::{LagrangianData, PolynomialData};

/// A Lagrangian with what it needs of the rigid body.
pub(super) struct Momentum<'a> {
    data: &'a LagrangianData,
    m: usize,
    mass: f64,
    /// First and second moment `int X_0 dm`, `int X_0 X_0^t dm`.
    moment: Vector3<f64>,
    second: Matrix3<f64>,
}

impl<'a> Momentum<'a> {
    /// `rigid`: `M_RR` about the origin.
    pub(super) fn new(data: &'a LagrangianData, rigid: &Matrix6<f64>) -> Self {
        let inertia = rigid.fixed_view::<3, 3>(3, 3).into_owned();
        Self {
            data,
            m: data.range.len(),
            mass: rigid.fixed_view::<3, 3>(0, 0).trace() / 3.0,
            moment: Vector3::new(rigid[(5, 1)], rigid[(3, 2)], rigid[(4, 0)]),
            second: Matrix3::identity() * (0.5 * inertia.trace()) - inertia,
        }
    }

    /// `M(q) u` with `u = (q_dot, beta)`, `beta` the true velocity of A - (m + 6).
    pub(super) fn at(&self, q: &[f64], u: &DVector<f64>) -> DVector<f64> {
        self.mass(q) * u
    }

    /// `M(q)` by the blocks of (B.7), rows and columns those of `q` before those of A - (m + 6 x m + 6).
    pub(super) fn mass(&self, q: &[f64]) -> DMatrix<f64> {
        let (data, m, n) = (self.data, self.m, self.data.fields as usize);
        let (y, jacobian) = self.coordinates(q);
        let jacobian = DMatrix::from_fn(n, m, |a, i| jacobian[a][i]);
        let first = DMatrix::from_fn(n, 3, |a, k| data.first_moment[k * n + a]);
        let mut moments: Vec<Matrix3<f64>> =
            data.moment_0.chunks_exact(9).map(Matrix3::from_row_slice).collect();
        let mut second = self.second;
        for (p, y) in moments.iter().zip(&y) {
            second += (p + p.transpose()) * *y;
        }
        let mut with = vec![Matrix3::zeros(); n];
        let entries = data.moment.i.iter().zip(&data.moment.l).zip(&data.moment.r).zip(&data.moment.value);
        for (((a, b), r), value) in entries {
            with[*a as usize][(*r as usize / 3, *r as usize % 3)] += value * y[*b as usize];
        }
        for ((p, own), y) in moments.iter_mut().zip(&with).zip(&y) {
            *p += own;
            second += own * *y;
        }
        // int X x F_a of P_a = int F_a X^t.
        let lever = |p: &Matrix3<f64>| {
            Vector3::new(p[(2, 1)] - p[(1, 2)], p[(0, 2)] - p[(2, 0)], p[(1, 0)] - p[(0, 1)])
        };
        let levers = DMatrix::from_fn(n, 3, |a, k| lever(&moments[a])[k]);
        let moment = (0..n).fold(self.moment, |sum, a| sum + first.row(a).transpose() * y[a]);
        let mut mass = DMatrix::zeros(m + 6, m + 6);
        mass.view_mut((0, 0), (m, m)).copy_from(&jacobian.tr_mul(&jacobian));
        for (at, columns) in [(m, &first), (m + 3, &levers)] {
            let coupling = jacobian.tr_mul(columns);
            mass.view_mut((0, at), (m, 3)).copy_from(&coupling);
            mass.view_mut((at, 0), (3, m)).copy_from(&coupling.transpose());
        }
        let moment = moment.cross_matrix();
        mass.view_mut((m, m), (3, 3)).copy_from(&(Matrix3::identity() * self.mass));
        mass.view_mut((m, m + 3), (3, 3)).copy_from(&-moment);
        mass.view_mut((m + 3, m), (3, 3)).copy_from(&moment);
        let inertia = Matrix3::identity() * second.trace() - second;
        mass.view_mut((m + 3, m + 3), (3, 3)).copy_from(&inertia);
        mass
    }

    /// `y` and `D = dy/dq` - (n), (n x m).
    fn coordinates(&self, q: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let (m, n) = (self.m, self.data.fields as usize);
        let (mut y, mut d) = (vec![0.0; n], vec![vec![0.0; m]; n]);
        for a in 0..m {
            for i in 0..m {
                let value = self.data.linear[a * m + i];
                y[a] += value * q[i];
                d[a][i] += value;
            }
        }
        let PolynomialData { quadratic, cubic } = &self.data.curve;
        let mut add = |row: u32, factors: &[u32], value: f64| {
            let (row, at) = (row as usize, |k: usize| q[factors[k] as usize]);
            y[row] += value * (0..factors.len()).map(at).product::<f64>();
            for k in 0..factors.len() {
                let others: f64 = (0..factors.len()).filter(|l| *l != k).map(at).product();
                d[row][factors[k] as usize] += value * others;
            }
        };
        quadratic.iter().for_each(|(row, factors, value)| add(*row, factors, *value));
        cubic.iter().for_each(|(row, factors, value)| add(*row, factors, *value));
        (y, d)
    }
}
