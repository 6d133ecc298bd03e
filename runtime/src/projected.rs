//! Forces that are constant in G or in A, on points that only move: projected once, so that their cost does not depend on how many there
//! are (theory section 6). Loads along members are such, on their stations.
//!
//! Points move by `R_g = R0_g + phi_gj q_j` and carry `C p_g`, with `C = C^{AG}` (dead) or the identity (body), times a function of time.
//! With
//!
//! ```text
//! W(q) = sum_g R_g p_g^t = W_0 + W_j q_j        P = sum_g p_g
//! Q_i = W_i : C        Q_R = (C P, axial of W(q) C^t)
//! ```
//!
//! which is exact: positions are linear in the amplitudes.

use alloc::{sync::Arc, vec, vec::Vec};

use crate::dense::Dense;
use crate::expression::Variables;
use crate::internal_loads;
use crate::loading::{Axes, Wrench};
use crate::math::{
    Mat3, Vec3, Vec6, add_dyad, axial, axpy, constant, constant_vector, dot, join, mul, scale, split,
    transposed, turn_second,
};
use crate::model::Model;
use crate::real::Real;
use crate::time::TimeFunction;

/// Forces with one function of time and in one kind of axes.
#[derive(Clone, Debug)]
pub(crate) struct Projected {
    dead: bool,
    time: Arc<TimeFunction>,
    forces: Arc<Forces>,
    /// Place among the loaded points, and force, of those on named points.
    pub(crate) points: Vec<(usize, Vec3)>,
}

/// The forces in the modes.
#[derive(Debug, PartialEq)]
struct Forces {
    /// `P`.
    total: Vec3,
    /// `W_0`, N m.
    rest: Mat3,
    /// `W_j`, a column for each mode - (9 x m).
    lever: Dense,
    /// The same transposed - (m x 9).
    work: Dense,
    /// `sum_g y_g p_g^t` for the section forces at every place - (places of 6).
    cuts: Vec<[Mat3; 6]>,
}

impl Projected {
    /// `forces`: carriers of the model and the force on each; `points` of them by their place among the loaded points.
    pub(crate) fn new(
        model: &Model,
        dead: bool,
        time: Arc<TimeFunction>,
        forces: &[(usize, Vec3)],
        points: Vec<(usize, Vec3)>,
    ) -> Self {
        let (mut total, mut rest) = ([0.0; 3], [[0.0; 3]; 3]);
        let mut modal = vec![[[0.0; 3]; 3]; model.n_modes()];
        for (carrier, p) in forces {
            let Some(point) = model.carrier(*carrier) else { continue };
            total = axpy(total, 1.0, *p);
            add_dyad(&mut rest, point.position, *p);
            for (sum, phi) in modal.iter_mut().zip(&point.phi) {
                add_dyad(sum, split(phi).0, *p);
            }
        }
        let entry = |at: usize, mode: usize| {
            modal.get(mode).and_then(|w| w.as_flattened().get(at)).copied().unwrap_or(0.0)
        };
        let forces = Forces {
            total,
            rest,
            lever: Dense::new(9, model.n_modes(), entry),
            work: Dense::new(model.n_modes(), 9, |mode, at| entry(at, mode)),
            cuts: internal_loads::of_forces(model, forces),
        };
        Projected { dead, time, forces: Arc::new(forces), points }
    }

    /// Whether `other` differs in nothing but the function of time.
    pub(crate) fn acts_as(&self, other: &Self) -> bool {
        self.dead == other.dead && (Arc::ptr_eq(&self.forces, &other.forces) || self.forces == other.forces)
    }

    /// The factor on it over time.
    #[inline]
    pub(crate) fn time(&self) -> &TimeFunction {
        &self.time
    }

    /// `C` times the factor.
    #[inline(always)]
    fn turn<R: Real>(&self, factor: R, attitude: &Mat3<R>) -> Mat3<R> {
        if !self.dead {
            let zero = R::of(0.0);
            return [[factor, zero, zero], [zero, factor, zero], [zero, zero, factor]];
        }
        // C^{AG}.
        let [x, y, z] = transposed(attitude);
        [scale(factor, x), scale(factor, y), scale(factor, z)]
    }

    /// Adds to the elastic rows, and force and moment about the origin of A, in A, to the resultant.
    #[inline(always)]
    pub(crate) fn add<R: Real>(
        &self,
        factor: R,
        attitude: &Mat3<R>,
        q: &[R],
        elastic: &mut [R],
        resultant: &mut Vec6<R>,
    ) {
        let Forces { total, rest, lever, work, cuts: _ } = &*self.forces;
        let c = self.turn(factor, attitude);
        let mut w = constant(rest);
        lever.add(q, w.as_flattened_mut());
        // sum_g R_g x (C p_g).
        let of_these = join(mul(&c, constant_vector(total)), axial(&turn_second(&w, &c)));
        resultant.iter_mut().zip(&of_these).for_each(|(sum, of_these)| *sum += *of_these);
        work.add(c.as_flattened(), elastic);
    }

    /// Adds to the section forces at one of the model's places.
    pub(crate) fn add_section_forces<R: Real>(
        &self,
        cut: usize,
        factor: R,
        attitude: &Mat3<R>,
        out: &mut Vec6<R>,
    ) {
        let c = self.turn(factor, attitude);
        for (out, y) in out.iter_mut().zip(self.forces.cuts.get(cut).into_iter().flatten()) {
            *out += y.iter().zip(&c).fold(R::of(0.0), |sum, (y, c)| sum + dot(y.map(R::of), *c));
        }
    }

    /// Adds the wrenches on named points to those of the loaded points.
    pub(crate) fn add_to_points(&self, variables: &Variables, wrenches: &mut [Wrench]) {
        let factor = self.time.value(variables);
        let axes = if self.dead { Axes::Inertial } else { Axes::Body };
        for (place, force) in &self.points {
            if let Some(wrench) = wrenches.get_mut(*place) {
                wrench.add(axes, factor, *force, [0.0; 3]);
            }
        }
    }
}
