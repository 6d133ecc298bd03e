//! Momenta about the centre of mass, and the derivative of the kinetic energy by the amplitudes: what an integrator needs that works on
//! the Lagrangian instead of the accelerations.

use super::{Lagrangian, Scratch, lanes};
use crate::dense::rows;
use crate::four::{self, Kernel, Machine, Plain};
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
        self.add_elastic(Plain, q, at);
    }

    /// Adds `factor dT/dq` at the rates and the angular velocity evaluated last, for a velocity `v` of A:
    ///
    /// ```text
    /// dT/dq = D_dot_a^t (y_dot_a + w . N_a + v . S_a) + D_a^t (w^2 tr P_a - w . P_a w - w . N_dot_a + S_a . (v x w))       (B.10)
    /// ```
    #[inline]
    pub(crate) fn add_kinetic_gradient(
        &self,
        factor: f64,
        v: Vec3,
        w: Vec3,
        at: &mut Scratch,
        out: &mut [f64],
    ) {
        four::run(Gradient { lagrangian: self, factor, v, w, at, out });
    }

    /// What `D_dot` and `D` are multiplied with in (B.10), into `along` and `forces`.
    #[inline(always)]
    fn visit_gradient<M: Machine>(&self, m: M, v: Vec3, w: Vec3, at: &mut Scratch) {
        let (whirl, w2) = (lanes::splat(m, cross(v, w)), m.splat(dot(w, w)));
        let (v, w) = (lanes::splat(m, v), lanes::splat(m, w));
        let Scratch { path, moment, turning_rate, along, forces, .. } = at;
        let moments = moment.as_chunks::<9>().0.iter().zip(turning_rate.as_chunks::<3>().0);
        for (((field, (p, n_rate)), y_dot), (along, across)) in
            self.fields.iter().zip(moments).zip(&path.y_dot).zip(along.iter_mut().zip(forces.iter_mut()))
        {
            let (p, turned_rate) = (lanes::matrices(m, p), lanes::dot::<M>(w, lanes::load(m, n_rate)));
            let (n, s) = (lanes::turned::<M>(&p), lanes::load(m, &field.first));
            *along = m.store(m.load(y_dot) + (lanes::dot::<M>(w, n) + lanes::dot::<M>(v, s)));
            let outward = w2 * lanes::trace::<M>(&p) - lanes::dot::<M>(w, lanes::product::<M>(&p, w));
            *across = m.store(outward + (lanes::dot::<M>(whirl, s) - turned_rate));
        }
    }
}

/// A call of [`Lagrangian::add_kinetic_gradient`].
struct Gradient<'a> {
    lagrangian: &'a Lagrangian,
    factor: f64,
    v: Vec3,
    w: Vec3,
    at: &'a mut Scratch,
    out: &'a mut [f64],
}

impl Kernel for Gradient<'_> {
    type Output = ();

    #[inline(always)]
    fn on<M: Machine>(self, m: M) {
        let Gradient { lagrangian, factor, v, w, at, out } = self;
        lagrangian.visit_gradient(m, v, w, at);
        let Scratch { path, along, forces, .. } = at;
        lagrangian.coordinates.add_rate_pull_back(m, factor, along, path, out);
        for (out, column) in out.iter_mut().zip(rows(&path.d, forces.len())) {
            *out += factor * m.dot(column, forces);
        }
    }
}

impl Scratch {
    /// Moment of momentum about the centre of mass, for the velocity `v` of A that
    /// [`Lagrangian::evaluate_centred`] gave; `dT/dq_dot` into `modal`.
    pub(crate) fn centred_momenta(&self, v: Vec3, w: Vec3, modal: &mut [f64]) -> Vec3 {
        for (to, d) in modal.iter_mut().zip(rows(&self.path.d, self.forces.len())) {
            *to = Plain.dot(d, &self.path.y_dot);
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
