//! What the terms that were dropped of the kinetic coordinates would add to the equations of a geometric model (docs/validity.md).
//!
//! With `y + c(q)` for `y`, of which `y = A q` to first order, the kinetic energy has the terms `c_dot . (A q_dot)` more, and
//! `c_dot_a (S_a . v + L_a . w)` with the rigid motion, `L_a = int X_0 x F_a dm`:
//!
//! ```text
//! r_v = S_a c_ddot_a,   r_w = L_a c_ddot_a
//! r_i = A_ai c_ddot_a + dc_a/dq_i ((A q_ddot)_a + S_a . (v_dot + w x v - g) + L_a . w_dot)                                   (1e)
//! ```

use alloc::{vec, vec::Vec};

use super::defect::Sample;
use crate::data::{CurveValidityData, LagrangianData};
use crate::math::{Vec3, Vec6, add, axpy, cross, dot, dot_6, join, split, sub};
use crate::model::Model;
use crate::polynomial::{Jet, Polynomial};

/// The dropped terms `c` of the first m kinetic coordinates.
#[derive(Clone, Debug)]
pub(super) struct Dropped {
    terms: Polynomial,
    jets: Vec<Jet>,
    /// `A` - (m x m).
    linear: Vec<f64>,
    /// `S_a`, `L_a` - (m).
    fields: Vec<[Vec3; 2]>,
    /// Dropped of the motion of the named points.
    points: Vec<Polynomial>,
    /// `c`, `c_dot`, `c_ddot`, and the forces on `c` - (m).
    values: [Vec<f64>; 4],
}

impl Dropped {
    /// None of a model without a curved manifold.
    pub(super) fn of(model: &Model) -> Option<Self> {
        let validity = model.data().validity.as_ref()?.curve.as_ref()?;
        Some(Self::new(validity, model.data().lagrangian.as_ref()?, model.n_modes()))
    }

    pub(super) fn new(validity: &CurveValidityData, lagrangian: &LagrangianData, m: usize) -> Self {
        let terms = Polynomial::new(m, &validity.dropped);
        let n = lagrangian.fields as usize;
        let at = |list: &[f64], k: usize| list.get(k).copied().unwrap_or(0.0);
        let field = |a: usize| {
            let p = |k: usize| at(&lagrangian.moment_0, 9 * a + k);
            // Of `int F_a X_0^t`, by rows.
            let lever = [p(7) - p(5), p(2) - p(6), p(3) - p(1)];
            [core::array::from_fn(|k| at(&lagrangian.first_moment, k * n + a)), lever]
        };
        Dropped {
            jets: terms.jets(),
            terms,
            linear: lagrangian.linear.clone(),
            fields: (0..m).map(field).collect(),
            points: validity.points.iter().map(|point| Polynomial::new(6, point)).collect(),
            values: core::array::from_fn(|_| vec![0.0; m]),
        }
    }

    /// Dropped of the motion of the node of a point: translation in A, rotation in the node frame.
    pub(super) fn displacement(&self, point: usize, q: &[f64]) -> Vec6 {
        let mut out = [0.0; 6];
        if let Some(point) = self.points.get(point) {
            point.at(q, &mut out);
        }
        out
    }

    /// Adds them to the rows of the elastic modes and of the rigid motion, as in the equations of motion - (m + 6).
    pub(super) fn add(&mut self, model: &Model, at: &Sample, r: &mut [f64]) {
        let Some((rows, rigid)) = r.split_last_chunk_mut::<6>() else { return };
        let m = self.fields.len();
        let ((v, w), (v_dot, w_dot)) = (split(&at.beta), split(&at.beta_dot));
        let felt = sub(add(v_dot, cross(w, v)), at.gravity);
        self.values.iter_mut().for_each(|values| values.fill(0.0));
        let [value, rate, second, force] = &mut self.values;
        self.terms.along(at.q, at.q_dot, value, rate, second);
        self.terms.derivative(at.q, at.q_ddot, second);
        let of_fields = self.linear.chunks_exact(m.max(1)).zip(&self.fields);
        for ((linear, [s, lever]), force) in of_fields.zip(force.iter_mut()) {
            let own: f64 = linear.iter().zip(at.q_ddot).map(|(a, q)| a * q).sum();
            *force = own + dot(*s, felt) + dot(*lever, w_dot);
        }
        self.terms.prepare(at.q, at.q_dot, &mut self.jets);
        self.terms.pull_back(&mut self.jets, force, rows);
        let (mut momentum, mut moment) = ([0.0; 3], [0.0; 3]);
        let of_fields = self.linear.chunks_exact(m.max(1)).zip(&self.fields);
        for ((linear, [s, lever]), second) in of_fields.zip(second.iter()) {
            rows.iter_mut().zip(linear).for_each(|(row, a)| *row += a * second);
            momentum = axpy(momentum, *second, *s);
            moment = axpy(moment, *second, *lever);
        }
        let total = join(momentum, moment);
        rows.iter_mut().zip(&model.phi_r).for_each(|(row, phi)| *row += dot_6(phi, &total));
        rigid.iter_mut().zip(total).for_each(|(to, value)| *to += value);
    }
}
