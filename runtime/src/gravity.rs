//! Uniform gravity on the whole body (theory section 6).
//!
//! With the first moment of mass in A, `mu(q) = m c_0 + S_j q_j + 1/2 H_jk q_j q_k`, and the field `g_A = C^{AG} g`, the potential
//! is `-g_A . mu - m g . r_G`, and
//!
//! ```text
//! Q_i = g_A . (S_i + H_ij q_j) + Phi_R,i^t Q_R        Q_R = (m g_A, mu x g_A)
//! ```
//!
//! An elastic mode of a free body carries no momentum: what is constant in its row, `g_A . (S_i + m phi_v,i + phi_w,i x m c_0)`,
//! vanishes. It is not computed, so that free fall excites nothing at all.

use alloc::vec::Vec;

use crate::data::ModelData;
use crate::math::{Vec3, Vec6, add, axpy, constant_vector, cross, dot, scale, split};
use crate::real::Real;

/// Momentum of a mode, relative to `sqrt(mass generalised_mass)`, that is round-off.
const NO_MOMENTUM: f64 = 1e-9;

/// How a body responds to a uniform field.
#[derive(Clone, Debug)]
pub(crate) struct Weight {
    mass: f64,
    /// `m c_0`, kg m.
    first_moment: Vec3,
    /// `S_j` - (m).
    shift: Vec<Vec3>,
    /// Turn of A in the modes, `phi_w` - (m).
    turn: Vec<Vec3>,
    /// Momentum of the modes where they have any - (m).
    momentum: Vec<Vec3>,
    /// `H_ij`, row by row, empty where it is zero - (m x m).
    second: Vec<Vec3>,
}

impl Weight {
    pub(crate) fn new(data: &ModelData, phi_r: &[Vec6]) -> Self {
        let m = phi_r.len();
        let mass = data.rigid.mass;
        let first_moment = scale(mass, data.rigid.centre_of_mass);
        let component = |values: &[f64], k: usize, index: usize, stride: usize| {
            values.get(k * stride + index).copied().unwrap_or(0.0)
        };
        let vectors = |values: &[f64], n: usize| -> Vec<Vec3> {
            (0..n).map(|index| core::array::from_fn(|k| component(values, k, index, n))).collect()
        };
        let shift = vectors(&data.modes.first_moment, m);
        let momentum = shift.iter().zip(phi_r).zip(&data.modes.mass).map(|((s, phi), modal_mass)| {
            let (v, w) = split(phi);
            let p = add(axpy(*s, mass, v), cross(w, first_moment));
            let floor = NO_MOMENTUM * libm::sqrt(mass * modal_mass);
            if dot(p, p) > floor * floor { p } else { [0.0; 3] }
        });
        let second = data.gravity.as_ref().map_or(&[][..], |gravity| &gravity.second_moment);
        Weight {
            mass,
            first_moment,
            momentum: momentum.collect(),
            turn: phi_r.iter().map(|phi| split(phi).1).collect(),
            second: vectors(second, second.len() / 3),
            shift,
        }
    }

    /// Adds the generalised forces of the field `g_a`, components in A, to `external` - (m + 6).
    #[inline(always)]
    pub(crate) fn add<R: Real>(&self, g_a: Vec3<R>, q: &[R], external: &mut [R]) {
        let Some((elastic, rigid)) = external.split_at_mut_checked(q.len()) else { return };
        let mut moved = [R::of(0.0); 3];
        let modes = self.shift.iter().zip(&self.momentum).zip(q).zip(elastic.iter_mut());
        for (i, (((shift, momentum), q_i), force)) in modes.enumerate() {
            let bend = self.bend(i, q);
            *force += dot(g_a, add(constant_vector(momentum), bend));
            moved = axpy(moved, *q_i, axpy(constant_vector(shift), R::of(0.5), bend));
        }
        let moment = cross(moved, g_a);
        for (force, turn) in elastic.iter_mut().zip(&self.turn) {
            *force += dot(constant_vector(turn), moment);
        }
        let moment = add(moment, cross(constant_vector(&self.first_moment), g_a));
        let resultant = scale(R::of(self.mass), g_a).into_iter().chain(moment);
        for (force, value) in rigid.iter_mut().zip(resultant) {
            *force += value;
        }
    }

    /// Momentum of every mode per unit modal rate, in A, kg m: zero to round-off in a free-free mode, and then exactly zero - (m).
    pub(crate) fn momentum(&self) -> &[Vec3] {
        &self.momentum
    }

    /// First moment of mass in A, kg m.
    pub(crate) fn first_moment(&self, q: &[f64]) -> Vec3 {
        let modes = self.shift.iter().zip(q).enumerate();
        modes.fold(self.first_moment, |sum, (i, (shift, q_i))| {
            axpy(sum, *q_i, axpy(*shift, 0.5, self.bend(i, q)))
        })
    }

    /// `H_ij q_j`.
    #[inline(always)]
    fn bend<R: Real>(&self, i: usize, q: &[R]) -> Vec3<R> {
        let m = q.len();
        let row = self.second.get(i * m..(i + 1) * m).unwrap_or(&[]);
        row.iter().zip(q).fold([R::of(0.0); 3], |sum, (h, q_j)| axpy(sum, *q_j, constant_vector(h)))
    }
}
