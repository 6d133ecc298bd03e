//! Momenta about the centre of mass, and the derivative of the kinetic energy by the amplitudes: what an integrator needs that works on
//! the Lagrangian instead of the accelerations.

use super::{Lagrangian, Scratch, product, trace};
use crate::dense::rows;
use crate::math::{Vec3, Vec6, add, add_scaled, cross, dot, scale, split};

impl Lagrangian {
    pub(crate) fn mass(&self) -> f64 {
        self.mass
    }

    /// Evaluates with the centre of mass at rest: `v = -(w x c + c_dot)`, the velocity of A then.
    #[inline]
    pub(crate) fn evaluate_centred(&self, q: &[f64], q_dot: &[f64], w: Vec3, at: &mut Scratch) -> Vec3 {
        self.evaluate(q, q_dot, &[0.0, 0.0, 0.0, w[0], w[1], w[2]], at);
        let (p, _) = split(&at.momentum);
        scale(-1.0 / self.mass, p)
    }

    /// `K q + e de/dq` into the forces of the scratch, in place of the forces of inertia. At the amplitudes evaluated last.
    #[inline]
    pub(crate) fn elastic_forces(&self, q: &[f64], at: &mut Scratch) {
        at.elastic.fill([0.0; 4]);
        self.add_elastic(q, at);
    }

    /// Adds `factor dT/dq` at the rates and the angular velocity evaluated last, for a velocity `v` of A:
    ///
    /// ```text
    /// dT/dq = D_dot_a^t (y_dot_a + w . N_a + v . S_a) + D_a^t (w^2 tr P_a - w . P_a w - w . N_dot_a + S_a . (v x w))       (B.10)
    /// ```
    pub(crate) fn add_kinetic_gradient(&self, factor: f64, v: Vec3, w: Vec3, at: &Scratch, out: &mut [f64]) {
        let (whirl, w2) = (cross(v, w), dot(w, w));
        let path = &at.path;
        let blocks = at.elastic.len().max(1);
        let of_field = |b: u32| path.y.get(b as usize).copied().unwrap_or_default();
        let constants = self.fields.iter().zip(self.moments.rows());
        let fields = constants.zip(rows(&path.d, blocks).zip(rows(&path.d_dot, blocks)));
        for (((field, moments), (d, d_dot)), ([_, _, y_dot, _], [head, tail])) in
            fields.zip(path.y.iter().zip(&at.maps))
        {
            let moment = self.moments.moment(moments, of_field);
            let p = moment.matrix(&field.moment_0);
            let n = [head[3], tail[0], tail[1]];
            let along = y_dot + dot(w, n) + dot(v, field.first);
            let across = w2 * trace(&p) - dot(w, product(&p, w)) - dot(w, moment.turned_rate())
                + dot(field.first, whirl);
            add_scaled(out, factor * along, d_dot.as_flattened());
            add_scaled(out, factor * across, d.as_flattened());
        }
    }
}

impl Scratch {
    /// Moment of momentum about the centre of mass, for the velocity `v` of A that
    /// [`Lagrangian::evaluate_centred`] gave; `dT/dq_dot` into `modal`.
    pub(crate) fn centred_momenta(&self, v: Vec3, w: Vec3, modal: &mut [f64]) -> Vec3 {
        modal.fill(0.0);
        let blocks = self.elastic.len().max(1);
        for (d, [_, _, y_dot, _]) in rows(&self.path.d, blocks).zip(&self.path.y) {
            add_scaled(modal, *y_dot, d.as_flattened());
        }
        self.add_coupled(&[v[0], v[1], v[2], w[0], w[1], w[2]], modal);
        let (_, h) = split(&self.momentum);
        add(h, cross(self.first_moment, v))
    }

    /// Adds `M_qR beta`, or what a wrench on A does to the amplitudes.
    pub(crate) fn add_coupled(&self, beta: &Vec6, modal: &mut [f64]) {
        for (row, beta) in rows(&self.coupling, self.elastic.len().max(1)).zip(beta) {
            add_scaled(modal, *beta, row.as_flattened());
        }
    }

    /// Centre of mass in A, m.
    pub(crate) fn centre(&self, mass: f64) -> Vec3 {
        scale(1.0 / mass, self.first_moment)
    }
}
