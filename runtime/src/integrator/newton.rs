//! Newton corrections for the implicit integrators, for steps so long that substitution no longer contracts.
//!
//! The Jacobian holds the elastic and damping terms, the full derivative of the gyroscopic forces and the rotation of the
//! step. The stiffness of the loads (lever arms, turning of dead loads) is left out: it enters with `dt^2` and the
//! iteration corrects for it.

use alloc::{vec, vec::Vec};

use super::implicit::{Evaluation, RigidEvaluation};
use super::parameters::Parameters;
use crate::data::TensorData;
use crate::dense::{rows, rows_mut};
use crate::equations::about_centre;
use crate::math::{Vec6, add, add_scaled, cross, dot_6, join, mul, mul6_symmetric, scale, split, tangential};
use crate::model::Model;

/// Jacobian, its factors and scratch.
#[derive(Clone, Debug)]
pub(crate) struct Newton {
    n: usize,
    /// `dN/du`, later the Jacobian and its factors - (n x n).
    matrix: Vec<f64>,
    /// `dN/dq` - (n x m).
    by_q: Vec<f64>,
    /// `dN/dbeta` with `u` held - (n x 6).
    by_beta: Vec<Vec6>,
    /// Row exchanged with at every pivot - (n).
    pivots: Vec<usize>,
    right: Vec<f64>,
    regular: bool,
}

impl Newton {
    pub(crate) fn new(model: &Model) -> Self {
        let m = model.n_modes();
        let n = m + 6;
        Newton {
            n,
            matrix: vec![0.0; n * n],
            by_q: vec![0.0; n * m],
            by_beta: vec![[0.0; 6]; n],
            pivots: vec![0; n],
            right: vec![0.0; n],
            regular: false,
        }
    }

    /// Factorises the Jacobian of the step's equations with respect to `(q_ddot_1, beta*_1)` at an iterate.
    pub(crate) fn factorise(
        &mut self,
        model: &Model,
        parameters: &Parameters,
        diagonal: &[f64],
        q: &[f64],
        u: &[f64],
        at: &Evaluation,
    ) {
        self.differentiate(model, q, u, &at.beta);
        let (n, m) = (self.n, diagonal.len());
        // Prescribed, the velocity of A does not change with the unknowns.
        if at.rigid.is_some() {
            self.add_by_beta(model);
        }
        let Parameters { velocity_gain, position_gain, .. } = *parameters;
        for (row, (values, by_q)) in
            rows_mut(&mut self.matrix, n).zip(rows_or_nothing(&self.by_q, m)).enumerate()
        {
            for value in values.iter_mut().take(m) {
                *value *= velocity_gain;
            }
            add_scaled(values, position_gain, by_q);
            if let (Some(value), Some(diagonal)) = (values.get_mut(row), diagonal.get(row)) {
                *value += diagonal;
            }
        }
        match &at.rigid {
            Some(rigid) => {
                for column in 0..n {
                    self.rigid_column(model, parameters, column, &at.beta, rigid);
                }
            }
            None => self.hold(model, velocity_gain),
        }
        self.regular = factorise(&mut self.matrix, &mut self.pivots, n);
    }

    /// `dN/du` with `beta` held, `dN/dbeta` and `dN/dq` of `N_i = c_ilr u_l beta_r + k_ilrs q_l beta_r beta_s`.
    fn differentiate(&mut self, model: &Model, q: &[f64], u: &[f64], beta: &Vec6) {
        let (n, m) = (self.n, q.len());
        self.matrix.fill(0.0);
        self.by_q.fill(0.0);
        self.by_beta.fill([0.0; 6]);
        let at = |values: &[f64], i: usize| values.get(i).copied().unwrap_or(0.0);
        for (i, l, r, c) in entries(&model.data().c) {
            add_to(self.matrix.get_mut(i * n + l), c * at(beta, r));
            add_to(self.by_beta.get_mut(i).and_then(|row| row.get_mut(r)), c * at(u, l));
        }
        if let Some(damping) = &model.data().damping {
            for (row, coupling) in rows_mut(&mut self.matrix, n).zip(rows_or_nothing(&damping.coupling, m)) {
                add_scaled(row, 1.0, coupling);
            }
        }
        for (i, l, rs, k) in entries(&model.data().k) {
            let (r, s) = (rs / 6, rs % 6);
            let (beta_r, beta_s, q_l) = (at(beta, r), at(beta, s), at(q, l));
            add_to(self.by_q.get_mut(i * m + l), k * beta_r * beta_s);
            if let Some(row) = self.by_beta.get_mut(i) {
                add_to(row.get_mut(r), k * q_l * beta_s);
                add_to(row.get_mut(s), k * q_l * beta_r);
            }
        }
    }

    /// Adds to `dN/du` what comes by way of `beta = Phi_R q_dot + beta*`.
    fn add_by_beta(&mut self, model: &Model) {
        let (n, m) = (self.n, self.n - 6);
        for (row, by_beta) in rows_mut(&mut self.matrix, n).zip(&self.by_beta) {
            let Some((elastic, rigid)) = row.split_at_mut_checked(m) else { return };
            for (value, phi) in elastic.iter_mut().zip(&model.phi_r) {
                *value += by_beta.iter().zip(phi).map(|(b, phi)| b * phi).sum::<f64>();
            }
            for (value, by_beta) in rigid.iter_mut().zip(by_beta) {
                *value += by_beta;
            }
        }
    }

    /// Derivative of the rigid rows, `momentum - turned known momentum - g_v rate`, by one unknown. On entry the rows hold
    /// the derivative of the gyroscopic forces.
    fn rigid_column(
        &mut self,
        model: &Model,
        parameters: &Parameters,
        column: usize,
        beta: &Vec6,
        at: &RigidEvaluation,
    ) {
        let (n, m) = (self.n, self.n - 6);
        let gain = parameters.velocity_gain;
        let mut net = [0.0; 6];
        for (net, row) in net.iter_mut().zip(rows(&self.matrix, n).skip(m)) {
            *net = -row.get(column).copied().unwrap_or(0.0);
        }
        let mut beta_star = [0.0; 6];
        add_to(column.checked_sub(m).and_then(|s| beta_star.get_mut(s)), 1.0);
        let (_, w) = split(beta);
        let dw = match model.phi_r.get(column) {
            Some(phi) => scale(gain, split(phi).1),
            None => split(&beta_star).1,
        };
        let momentum = about_centre(model.centre_of_mass, &mul6_symmetric(&model.rigid_mass, &beta_star));
        let ((p, h), (dp, dh)) = (split(&at.momentum), split(&momentum));
        let (p_dot, h_dot) = split(&about_centre(model.centre_of_mass, &net));
        let rate =
            join(add(p_dot, add(cross(dw, p), cross(w, dp))), add(h_dot, add(cross(dw, h), cross(w, dh))));
        // d(exp(theta~)^t P) = P x T(theta) dtheta, P turned already.
        let turn = mul(&tangential(at.theta), scale(0.5 * parameters.dt, dw));
        let (known_p, known_h) = split(&at.momentum_known);
        let turned = join(cross(known_p, turn), cross(known_h, turn));
        let derivative = momentum
            .iter()
            .zip(&turned)
            .zip(&rate)
            .map(|((momentum, turned), rate)| momentum - turned - gain * rate);
        for (row, value) in rows_mut(&mut self.matrix, n).skip(m).zip(derivative) {
            if let Some(entry) = row.get_mut(column) {
                *entry = value;
            }
        }
    }

    /// Rows of a prescribed motion of A: the elastic ones lose `Phi_R^t` times the rigid ones, whose momentum changes by
    /// `-M_RR Phi_R q_ddot`; the rigid ones say `Phi_R q_dot + beta* = beta`.
    fn hold(&mut self, model: &Model, gain: f64) {
        let (n, m) = (self.n, self.n - 6);
        let Some((elastic, rigid)) = self.matrix.split_at_mut_checked(m * n) else { return };
        for (row, phi) in rows_mut(elastic, n).zip(&model.phi_r) {
            for (rigid, phi) in rows(rigid, n).zip(phi) {
                add_scaled(row, -phi, rigid);
            }
            let momentum = mul6_symmetric(&model.rigid_mass, phi);
            for (entry, other) in row.iter_mut().zip(&model.phi_r) {
                *entry += dot_6(&momentum, other);
            }
        }
        for (component, row) in rows_mut(rigid, n).enumerate() {
            row.fill(0.0);
            for (entry, phi) in row.iter_mut().zip(&model.phi_r) {
                *entry = gain * phi.get(component).copied().unwrap_or(0.0);
            }
            add_to(row.get_mut(m + component), 1.0);
        }
    }

    /// `image = iterate + correction`; returns the squared norm of the correction of velocities (kinetic energy), or
    /// none when the Jacobian is singular.
    pub(crate) fn solve(
        &mut self,
        model: &Model,
        parameters: &Parameters,
        diagonal: &[f64],
        iterate: &[f64],
        at: &Evaluation,
        image: &mut [f64],
    ) -> Option<f64> {
        if !self.regular {
            return None;
        }
        let gain = parameters.velocity_gain;
        let elastic = image.iter().zip(iterate).zip(diagonal).zip(&model.phi_r);
        let mut moved = [0.0; 6];
        for (right, (((image, iterate), diagonal), phi)) in self.right.iter_mut().zip(elastic) {
            *right = diagonal * (image - iterate);
            add_scaled(&mut moved, image - iterate, phi);
        }
        let (modal, rigid) = self.right.split_last_chunk_mut::<6>()?;
        if let Some(at) = &at.rigid {
            for (((right, known), rate), momentum) in
                rigid.iter_mut().zip(&at.momentum_known).zip(&at.rate).zip(&at.momentum)
            {
                *right = known + gain * rate - momentum;
            }
        } else {
            let momentum = mul6_symmetric(&model.rigid_mass, &moved);
            for (right, phi) in modal.iter_mut().zip(&model.phi_r) {
                *right += dot_6(phi, &momentum);
            }
            rigid.fill(0.0);
        }
        substitute(&self.matrix, &self.pivots, self.n, &mut self.right);
        for ((image, iterate), correction) in image.iter_mut().zip(iterate).zip(&self.right) {
            *image = iterate + correction;
        }
        let (modal, rigid) = self.right.split_last_chunk::<6>()?;
        let modal: f64 =
            modal.iter().zip(&model.elastic).map(|(x, mode)| mode.mass * (gain * x) * (gain * x)).sum();
        let momentum = mul6_symmetric(&model.rigid_mass, rigid);
        Some(modal + rigid.iter().zip(&momentum).map(|(x, y)| x * y).sum::<f64>().abs())
    }
}

/// Entries (i, l, r, value) of a tensor.
fn entries(tensor: &TensorData) -> impl Iterator<Item = (usize, usize, usize, f64)> + '_ {
    let indices = tensor.i.iter().zip(&tensor.l).zip(&tensor.r);
    indices.zip(&tensor.value).map(|(((&i, &l), &r), &value)| (i as usize, l as usize, r as usize, value))
}

fn add_to(place: Option<&mut f64>, value: f64) {
    if let Some(place) = place {
        *place += value;
    }
}

/// As many rows as are asked for, of a matrix that may have no columns.
fn rows_or_nothing(matrix: &[f64], columns: usize) -> impl Iterator<Item = &[f64]> {
    (0..).map(move |row| matrix.get(row * columns..(row + 1) * columns).unwrap_or(&[]))
}

/// LU factors in place by rows, with partial pivoting; false when singular or not finite.
pub(crate) fn factorise(a: &mut [f64], pivots: &mut [usize], n: usize) -> bool {
    for (k, pivot) in pivots.iter_mut().enumerate().take(n) {
        let column = |row: &[f64]| row.get(k).copied().unwrap_or(0.0).abs();
        let largest = rows(a, n).map(column).enumerate().skip(k).max_by(|x, y| x.1.total_cmp(&y.1));
        let Some((row, size)) = largest else { return false };
        if !(size > 0.0 && size.is_finite()) {
            return false;
        }
        *pivot = row;
        exchange_rows(a, k, row, n);
        let Some((above, below)) = a.split_at_mut_checked((k + 1) * n) else { return false };
        let Some((_, upper)) = above.get(k * n..).and_then(|row| row.split_at_checked(k)) else {
            return false;
        };
        let Some((&diagonal, upper)) = upper.split_first() else { return false };
        for row in rows_mut(below, n) {
            if let Some((first, rest)) = row.get_mut(k..).and_then(<[f64]>::split_first_mut) {
                *first /= diagonal;
                add_scaled(rest, -*first, upper);
            }
        }
    }
    true
}

fn exchange_rows(a: &mut [f64], i: usize, j: usize, n: usize) {
    let (i, j) = (i.min(j), i.max(j));
    if i == j {
        return;
    }
    if let Some((above, below)) = a.split_at_mut_checked(j * n) {
        for (x, y) in above.iter_mut().skip(i * n).zip(below).take(n) {
            core::mem::swap(x, y);
        }
    }
}

/// Solves with the factors, in place.
pub(crate) fn substitute(lu: &[f64], pivots: &[usize], n: usize, x: &mut [f64]) {
    for (k, &row) in pivots.iter().enumerate() {
        if k < x.len() && row < x.len() {
            x.swap(k, row);
        }
    }
    let product = |row: &[f64], x: &[f64]| row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
    for (k, row) in rows(lu, n).enumerate() {
        if let Some((known, [value, ..])) = x.split_at_mut_checked(k) {
            *value -= product(row, known);
        }
    }
    for (k, row) in rows(lu, n).enumerate().rev() {
        if let (Some((value, known)), Some((diagonal, upper))) =
            (x.get_mut(k..).and_then(<[f64]>::split_first_mut), row.get(k..).and_then(<[f64]>::split_first))
        {
            *value = (*value - product(upper, known)) / diagonal;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_solve_a_system_that_needs_pivoting() {
        let a = [0.0, 2.0, 1.0, 4.0, 0.5, -1.0, 2.0, -3.0, 5.0];
        let x = [1.0, -2.0, 3.0];
        let mut b: Vec<f64> = a.chunks(3).map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum()).collect();
        let (mut lu, mut pivots) = (a, [0; 3]);
        assert!(factorise(&mut lu, &mut pivots, 3));
        substitute(&lu, &pivots, 3, &mut b);
        for (found, expected) in b.iter().zip(&x) {
            assert!((found - expected).abs() < 1e-14, "{found} instead of {expected}");
        }
        assert!(!factorise(&mut [1.0, 2.0, 2.0, 4.0], &mut [0; 2], 2));
    }
}
