//! Energies, momenta and centre of mass from a state, without scratch.

use super::lanes::{self, SecondMoment};
use super::{Lagrangian, MAX_FIELDS, traced};
use crate::dense::rows;
use crate::four::{Four, Machine, Plain};
use crate::math::{Mat3, Vec3, Vec6, add, add_6, axpy, cross, dot_6, join, mul, split};
use crate::sparse::WINDOW_BLOCKS;

/// Numbers by places of the fields, and one block after them: whole windows.
type Places = [Four; (MAX_FIELDS / 4 + 1).next_multiple_of(WINDOW_BLOCKS)];

/// What the ledger reads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Energies {
    pub(crate) kinetic: f64,
    /// Of second order about the equilibrium and of the self-stress; without the work of its elastic force.
    pub(crate) elastic: f64,
    /// `dT/dbeta` in A.
    pub(crate) momentum: Vec6,
    /// `int X dm` in A, kg m.
    pub(crate) first_moment: Vec3,
}

impl Lagrangian {
    /// `y`, one after it, and its rate.
    fn coordinates(&self, q: &[f64], q_dot: &[f64]) -> [Places; 2] {
        let zero: Places = [[0.0; 4]; (MAX_FIELDS / 4 + 1).next_multiple_of(WINDOW_BLOCKS)];
        let (mut y, mut y_dot, mut second) = (zero, zero, zero);
        let (values, rates) = (y.as_flattened_mut(), y_dot.as_flattened_mut());
        if self.modes > 0 {
            for ((y, y_dot), row) in
                values.iter_mut().zip(rates.iter_mut()).zip(rows(&self.linear, self.modes))
            {
                *y = row.iter().zip(q).map(|(a, q)| a * q).sum();
                *y_dot = row.iter().zip(q_dot).map(|(a, q_dot)| a * q_dot).sum();
            }
        }
        self.curve.along(q, q_dot, values, rates, second.as_flattened_mut());
        if let Some(after) = y.get_mut(self.fields.len()) {
            *after = [1.0, 0.0, 0.0, 0.0];
        }
        [y, y_dot]
    }

    /// `int X dm` in A, kg m.
    pub(crate) fn first_moment(&self, q: &[f64]) -> Vec3 {
        let [y, _] = self.coordinates(q, q);
        let mut s = lanes::zero(Plain);
        for (field, y) in self.fields.iter().zip(&y) {
            s = lanes::plus::<Plain>(s, Plain.load(y), lanes::load(Plain, &field.first));
        }
        add(self.first_moment_0, lanes::sums(Plain, s))
    }

    /// Energies and momenta (B.2).
    pub(crate) fn energies(&self, q: &[f64], q_dot: &[f64], beta: &Vec6) -> Energies {
        let m = Plain;
        let [y, y_dot] = self.coordinates(q, q_dot);
        let (v, w) = split(beta);
        let [mut s, mut s_dot] = [lanes::zero(m); 2];
        let (mut second_moment, mut squares) = (SecondMoment::zero(m), m.zero());
        for (field, (y_a, rate)) in self.fields.iter().zip(y.iter().zip(&y_dot)) {
            let (y_a, rate, s_a) = (m.load(y_a), m.load(rate), lanes::load(m, &field.first));
            second_moment.add(m, y_a, &[m.zero(); 9], &field.moment_0);
            s = lanes::plus::<Plain>(s, y_a, s_a);
            s_dot = lanes::plus::<Plain>(s_dot, rate, s_a);
            squares += rate * rate;
        }
        let blocks = self.fields.len();
        let [by_y, by_rate] = self.moments.weighted(
            m,
            &y,
            [y.get(..blocks).unwrap_or(&[]), y_dot.get(..blocks).unwrap_or(&[])],
        );
        second_moment.add(m, m.splat(1.0), &by_y, &[[0.0; 4]; 6]);
        let n_rate = lanes::turned::<Plain>(&by_rate);
        let s = add(self.first_moment_0, lanes::sums(m, s));
        let (s_dot, n_rate, squares) = (lanes::sums(m, s_dot), lanes::sums(m, n_rate), m.sum(squares));
        let mut second: Mat3 = self.second_moment_0;
        second_moment.add_to(m, &mut second);
        let rigid = join(
            add(axpy([0.0; 3], self.mass, v), cross(w, s)),
            add(cross(s, v), mul(&traced(&second, 1.0), w)),
        );
        let relative = join(s_dot, n_rate);
        let momentum = add_6(&rigid, &relative);
        Energies {
            kinetic: 0.5 * (squares + dot_6(&rigid, beta)) + dot_6(&relative, beta),
            elastic: self.elastic_energy(q),
            momentum,
            first_moment: s,
        }
    }

    /// `1/2 q K q + 1/2 |e|^2 - 1/2 |e_0|^2` (B.5), J.
    pub(crate) fn elastic_energy(&self, q: &[f64]) -> f64 {
        let mut energy = 0.0;
        for (row, q_i) in rows(&self.stiffness, self.modes.div_ceil(4).max(1)).zip(q) {
            energy += q_i * row.as_flattened().iter().zip(q).map(|(k, q)| k * q).sum::<f64>();
        }
        let mut e = [0.0; MAX_FIELDS];
        self.self_stress_rows.along(q, q, &mut e, &mut [0.0; MAX_FIELDS], &mut [0.0; MAX_FIELDS]);
        for (e, constant) in e.iter().zip(&self.self_stress) {
            energy += e * (e + 2.0 * constant);
        }
        0.5 * energy
    }

    /// `E_1 - E_0 - dE/dq(q_m) . (q_1 - q_0)` of the energy `E = 1/2 |e|^2` of self-stress, J: what the elastic forces in the middle of a
    /// step miss. Their quadratic part misses nothing.
    pub(crate) fn self_stress_defect(&self, q_0: &[f64], q_m: &[f64], q_1: &[f64]) -> f64 {
        if self.self_stress_curve.is_empty() {
            return 0.0;
        }
        let zero = [0.0; MAX_FIELDS];
        let (mut e_0, mut e_m, mut e_1, mut spare) = (zero, zero, zero, zero);
        self.self_stress_rows.at(q_0, &mut e_0);
        self.self_stress_rows.at(q_m, &mut e_m);
        self.self_stress_rows.at(q_1, &mut e_1);
        let (mut forward, mut back) = (zero, zero);
        self.self_stress_rows.derivative(q_m, q_1, &mut forward);
        self.self_stress_rows.derivative(q_m, q_0, &mut back);
        spare.iter_mut().zip(forward.iter().zip(&back)).for_each(|(to, (a, b))| *to = a - b);
        let rows = self.self_stress.iter().zip(e_0.iter().zip(&e_1)).zip(e_m.iter().zip(&spare));
        rows.map(|((constant, (e_0, e_1)), (e_m, along))| {
            // Of the squares the difference is taken as a product, which loses no digits.
            (e_1 - e_0) * (0.5 * (e_0 + e_1) + constant) - (e_m + constant) * along
        })
        .sum()
    }
}
