//! The curved manifold of a geometric model at an instant: how far the points are off the straight lines of the modes, and what the terms that
//! were dropped would add to the motion of the points and to the equations (docs/validity.md).
//!
//! With `y + c(q)` for the kinetic coordinates `y`, of which `y = A q` to first order, the kinetic energy has the terms `c_dot . (A q_dot)`
//! more, and `c_dot_a (S_a . v + L_a . w)` with the rigid motion, `L_a = int X_0 x F_a dm`:
//!
//! ```text
//! r_v = S_a c_ddot_a,   r_w = L_a c_ddot_a
//! r_i = A_ai c_ddot_a + dc_a/dq_i ((A q_ddot)_a + S_a . (v_dot + w x v - g) + L_a . w_dot)                                   (1e)
//! ```

use alloc::{vec, vec::Vec};

use super::defect::Sample;
use super::forms::{Entry, Forms};
use crate::data::{CurveValidityData, LagrangianData};
use crate::math::{Vec3, Vec6, add, axpy, cross, dot, dot_6, join, split, sub};
use crate::model::Model;

/// Kept and dropped terms of the motion of the points, dropped ones `c` of the first m kinetic coordinates.
#[derive(Clone, Debug)]
pub(super) struct Manifold {
    /// Of the coordinates (m), of the points the terms that are kept and those that were dropped (six each, point after point).
    forms: Forms,
    /// `A` - (m x m).
    linear: Vec<f64>,
    /// `S_a`, `L_a` - (m).
    fields: Vec<[Vec3; 2]>,
    /// Kept and dropped of the motion of the node of every point: translation in A, rotation in the node frame.
    points: [Vec<Vec6>; 2],
    /// `c_ddot` and the forces on `c` - (m).
    values: [Vec<f64>; 2],
}

impl Manifold {
    /// None of a model without.
    pub(super) fn of(model: &Model) -> Option<Self> {
        let lagrangian = model.data().lagrangian.as_ref().filter(|it| it.geometric)?;
        let validity = model.data().validity.as_ref().and_then(|it| it.curve.as_ref());
        Some(Self::new(validity, lagrangian, model.n_modes(), model.n_points()))
    }

    pub(super) fn new(
        validity: Option<&CurveValidityData>,
        lagrangian: &LagrangianData,
        m: usize,
        points: usize,
    ) -> Self {
        let kept = lagrangian.points.iter().take(points);
        let dropped = validity.iter().flat_map(|it| it.points.iter().take(points));
        let of_points = kept.zip((m..).step_by(6)).chain(dropped.zip((m + 6 * points..).step_by(6)));
        let mut entries: Vec<Entry> = of_points.flat_map(|(data, first)| Entry::of(first, data)).collect();
        entries.extend(validity.iter().flat_map(|it| Entry::of(0, &it.dropped)));
        let n = lagrangian.fields as usize;
        let at = |list: &[f64], k: usize| list.get(k).copied().unwrap_or(0.0);
        let field = |a: usize| {
            let p = |k: usize| at(&lagrangian.moment_0, 9 * a + k);
            // Of `int F_a X_0^t`, by rows.
            let lever = [p(7) - p(5), p(2) - p(6), p(3) - p(1)];
            [core::array::from_fn(|k| at(&lagrangian.first_moment, k * n + a)), lever]
        };
        Manifold {
            forms: Forms::new(m, m + 12 * points, &entries),
            linear: lagrangian.linear.clone(),
            fields: (0..m).map(field).collect(),
            points: [(); 2].map(|()| vec![[0.0; 6]; points]),
            values: [(); 2].map(|()| vec![0.0; m]),
        }
    }

    /// Takes in a motion.
    pub(super) fn look(&mut self, q: &[f64], q_dot: &[f64], q_ddot: &[f64]) {
        self.forms.look(q, q_dot, q_ddot);
        let [kept, dropped] = &mut self.points;
        self.forms.values(self.fields.len(), kept.as_flattened_mut());
        self.forms.values(self.fields.len() + 6 * kept.len(), dropped.as_flattened_mut());
    }

    /// Motion of the node of a point beyond that of the modes: translation in A, rotation in the node frame.
    pub(super) fn beyond(&self, point: usize) -> Vec6 {
        self.points[0].get(point).copied().unwrap_or_default()
    }

    /// What was dropped of it.
    pub(super) fn dropped(&self, point: usize) -> Vec6 {
        self.points[1].get(point).copied().unwrap_or_default()
    }

    /// Adds what the dropped terms do to the rows of the elastic modes and of the rigid motion, as in the equations of motion - (m + 6); `at`
    /// is the motion that was looked at.
    pub(super) fn add(&mut self, model: &Model, at: &Sample, r: &mut [f64]) {
        let Some((rows, rigid)) = r.split_last_chunk_mut::<6>() else { return };
        let m = self.fields.len();
        let ((v, w), (v_dot, w_dot)) = (split(&at.beta), split(&at.beta_dot));
        let felt = sub(add(v_dot, cross(w, v)), at.gravity);
        let [second, force] = &mut self.values;
        let of_fields = self.linear.chunks_exact(m.max(1)).zip(&self.fields);
        for ((linear, [s, lever]), force) in of_fields.zip(force.iter_mut()) {
            let own: f64 = linear.iter().zip(at.q_ddot).map(|(a, q)| a * q).sum();
            *force = own + dot(*s, felt) + dot(*lever, w_dot);
        }
        self.forms.weigh(0, force);
        self.forms.pull_back(rows);
        self.forms.seconds(0, second);
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
