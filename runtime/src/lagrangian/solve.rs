//! The mass matrix of (B.7), and its solution by elimination: rigid rows first, so that their block can be had alone.

use super::{Lagrangian, Scratch, traced};
use crate::dense::{rows, rows_mut};
use crate::math::{Vec3, Vec6, add_scaled};

impl Lagrangian {
    /// Accelerations `(q_ddot, beta_dot)` under forces on the relative elastic and the rigid rows, with `added` on the elastic block of
    /// the mass matrix: what an implicit step gains by damping and stiffness. False where the matrix is not positive definite.
    #[inline]
    pub(crate) fn solve(
        &self,
        at: &mut Scratch,
        elastic: &[f64],
        rigid: &Vec6,
        added: impl Fn(usize, &mut [f64]),
        q_ddot: &mut [f64],
    ) -> (bool, Vec6) {
        self.assemble(at, added);
        let width = self.modes + 6;
        let forces = rigid.iter().chain(elastic);
        for (row, force) in rows_mut(&mut at.system, width + 1).zip(forces) {
            if let Some(last) = row.last_mut() {
                *last = *force;
            }
        }
        let definite = eliminate(&mut at.system, width);
        substitute_back(&mut at.system, width);
        let mut solution = rows(&at.system, width + 1).map(|row| row.last().copied().unwrap_or(0.0));
        let mut beta_dot = [0.0; 6];
        for (to, from) in beta_dot.iter_mut().zip(&mut solution) {
            *to = from;
        }
        for (to, from) in q_ddot.iter_mut().zip(solution) {
            *to = from;
        }
        (definite, beta_dot)
    }

    /// `beta` for a momentum, with the rates of the fields given: `M_RR^-1 (momentum - U y_dot)`, `y_dot = D q_dot`. After
    /// [`Self::solve`], whose first six pivots are those of `M_RR`.
    #[inline]
    pub(crate) fn velocity(&self, at: &Scratch, momentum: &Vec6, q_dot: &[f64]) -> Vec6 {
        let width = self.modes + 6;
        let mut right = *momentum;
        for map in rows(&at.maps, width) {
            let Some((fields, d)) = map.split_first_chunk::<6>() else { break };
            let y_dot: f64 = d.iter().zip(q_dot).map(|(d, q_dot)| d * q_dot).sum();
            add_scaled(&mut right, -y_dot, fields);
        }
        // Pivot and upper triangle of row `k`.
        let upper = |k: usize| at.system.get(k * (width + 1) + k..k * (width + 1) + 6)?.split_first();
        for k in 0..6 {
            let Some((&pivot, upper)) = upper(k) else { break };
            let Some((&mut value, rest)) = right.get_mut(k..).and_then(<[f64]>::split_first_mut) else {
                break;
            };
            add_scaled(rest, -value / pivot, upper);
        }
        for k in (0..6).rev() {
            let Some((&pivot, upper)) = upper(k) else { break };
            let Some((value, known)) = right.get_mut(k..).and_then(<[f64]>::split_first_mut) else { break };
            *value = (*value - upper.iter().zip(known.iter()).map(|(a, x)| a * x).sum::<f64>()) / pivot;
        }
        right
    }

    /// Accelerations of the modes where the host gives `beta_dot`; false where the matrix is not positive definite.
    #[inline]
    pub(crate) fn solve_held(
        &self,
        at: &mut Scratch,
        elastic: &[f64],
        beta_dot: &Vec6,
        added: impl Fn(usize, &mut [f64]),
        q_ddot: &mut [f64],
    ) -> bool {
        // The coupling of the elastic rows with the rigid motion goes to the right; then the rigid rows say beta_dot = beta_dot.
        for (to, from) in q_ddot.iter_mut().zip(elastic) {
            *to = *from;
        }
        for map in rows(&at.maps, self.modes + 6) {
            let Some((fields, d)) = map.split_first_chunk::<6>() else { break };
            let shaken: f64 = fields.iter().zip(beta_dot).map(|(u, rate)| u * rate).sum();
            add_scaled(q_ddot, -shaken, d);
        }
        self.assemble(at, added);
        let width = self.modes + 6;
        for (k, row) in rows_mut(&mut at.system, width + 1).enumerate() {
            if k < 6 {
                row.fill(0.0);
                if let Some(pivot) = row.get_mut(k) {
                    *pivot = 1.0;
                }
            }
        }
        for (row, force) in rows_mut(&mut at.system, width + 1).skip(6).zip(q_ddot.iter()) {
            if let Some(last) = row.last_mut() {
                *last = *force;
            }
        }
        let definite = eliminate(&mut at.system, width);
        substitute_back(&mut at.system, width);
        for (to, row) in q_ddot.iter_mut().zip(rows(&at.system, width + 1).skip(6)) {
            *to = row.last().copied().unwrap_or(0.0);
        }
        definite
    }

    /// `M_Rq q_ddot + M_RR beta_dot + h_R`: what the rigid rows ask of the loads.
    pub(crate) fn rigid_rows(&self, at: &Scratch, q_ddot: &[f64], beta_dot: &Vec6) -> Vec6 {
        let mut out = at.rigid;
        for map in rows(&at.maps, self.modes + 6) {
            let Some((fields, d)) = map.split_first_chunk::<6>() else { break };
            let rate: f64 = d.iter().zip(q_ddot).map(|(d, q_ddot)| d * q_ddot).sum();
            add_scaled(&mut out, rate, fields);
        }
        for (out, row) in out.iter_mut().zip(rigid_block(self.mass, at.first_moment, at)) {
            *out += row.iter().zip(beta_dot).map(|(a, x)| a * x).sum::<f64>();
        }
        out
    }

    /// Adds `M_qq q_ddot + M_qR beta_dot`, the inertia of the accelerations on the relative elastic rows.
    pub(crate) fn add_elastic_rows(
        &self,
        at: &Scratch,
        q_ddot: &[f64],
        beta_dot: &Vec6,
        elastic: &mut [f64],
    ) {
        for map in at.maps.chunks_exact(self.modes + 6) {
            let (fields, d) = map.split_at(6);
            let product = |row: &[f64], x: &[f64]| row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
            add_scaled(elastic, product(fields, beta_dot) + product(d, q_ddot), d);
        }
    }

    /// The upper triangle of the mass matrix.
    #[inline]
    fn assemble(&self, at: &mut Scratch, added: impl Fn(usize, &mut [f64])) {
        let width = self.modes + 6;
        let block = rigid_block(self.mass, at.first_moment, at);
        at.system.fill(0.0);
        for (row, values) in rows_mut(&mut at.system, width + 1).zip(&block) {
            for (to, from) in row.iter_mut().zip(values) {
                *to = *from;
            }
        }
        // Four fields at a time: a quarter of the passes over the matrix.
        let blocks = rows(&at.maps, 4 * width);
        let rest = blocks.remainder();
        for block in blocks {
            let mut four = rows(block, width);
            let (Some(a), Some(b), Some(c), Some(d)) = (four.next(), four.next(), four.next(), four.next())
            else {
                break;
            };
            let factors = a.iter().zip(b).zip(c.iter().zip(d));
            for (k, (row, ((fa, fb), (fc, fd)))) in
                rows_mut(&mut at.system, width + 1).zip(factors).enumerate()
            {
                let first = k.max(6);
                let (Some(row), Some(a), Some(b), Some(c), Some(d)) = (
                    row.get_mut(first..width),
                    a.get(first..),
                    b.get(first..),
                    c.get(first..),
                    d.get(first..),
                ) else {
                    break;
                };
                for ((entry, (a, b)), (c, d)) in row.iter_mut().zip(a.iter().zip(b)).zip(c.iter().zip(d)) {
                    *entry += (fa * a + fb * b) + (fc * c + fd * d);
                }
            }
        }
        for map in rows(rest, width) {
            for (k, (row, &factor)) in rows_mut(&mut at.system, width + 1).zip(map).enumerate() {
                let first = k.max(6);
                if let (Some(row), Some(map)) = (row.get_mut(first..width), map.get(first..)) {
                    add_scaled(row, factor, map);
                }
            }
        }
        for (i, row) in rows_mut(&mut at.system, width + 1).skip(6).enumerate() {
            if let Some(row) = row.get_mut(6..width) {
                added(i, row);
            }
        }
    }
}

/// `M_RR` at the deformed shape.
fn rigid_block(mass: f64, s: Vec3, at: &Scratch) -> [Vec6; 6] {
    let i = traced(&at.second_moment, 1.0);
    let [x, y, z] = s;
    [
        [mass, 0.0, 0.0, 0.0, z, -y],
        [0.0, mass, 0.0, -z, 0.0, x],
        [0.0, 0.0, mass, y, -x, 0.0],
        [0.0, -z, y, i[0][0], i[0][1], i[0][2]],
        [z, 0.0, -x, i[1][0], i[1][1], i[1][2]],
        [-y, x, 0.0, i[2][0], i[2][1], i[2][2]],
    ]
}

/// Symmetric elimination of the rows `(upper triangle, right-hand side)` in place; false at a pivot that is not positive.
#[inline]
fn eliminate(system: &mut [f64], width: usize) -> bool {
    let stride = width + 1;
    let mut definite = true;
    for k in 0..width {
        let Some((above, below)) = system.split_at_mut_checked((k + 1) * stride) else { return false };
        let Some(row) = above.get(k * stride..).and_then(|row| row.get(k..)) else { return false };
        let Some((&pivot, upper)) = row.split_first() else { return false };
        definite &= pivot > 0.0;
        let inverse = 1.0 / pivot;
        for (j, (target, &entry)) in rows_mut(below, stride).zip(upper.iter()).enumerate() {
            if let (Some(target), Some(source)) = (target.get_mut(k + 1 + j..), upper.get(j..)) {
                add_scaled(target, -(entry * inverse), source);
            }
        }
    }
    definite
}

/// The solution into the last column.
#[inline]
fn substitute_back(system: &mut [f64], width: usize) {
    let stride = width + 1;
    for k in (0..width).rev() {
        let Some((above, row)) = system.split_at_mut_checked(k * stride) else { return };
        let (Some(&pivot), Some(&right)) = (row.get(k), row.get(width)) else { return };
        let x = right / pivot;
        if let Some(last) = row.get_mut(width) {
            *last = x;
        }
        for other in rows_mut(above, stride) {
            let entry = other.get(k).copied().unwrap_or(0.0);
            if let Some(last) = other.last_mut() {
                *last -= entry * x;
            }
        }
    }
}
