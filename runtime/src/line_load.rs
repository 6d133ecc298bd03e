//! Forces distributed along a member that are constant in G or in A: projected once, so that their cost does not depend on the number of
//! stations (theory section 6).
//!
//! Stations move by `R_g = R0_g + phi_gj q_j` and carry `C p_g`, with `C = C^{AG}` (dead) or the identity (body). With
//!
//! ```text
//! W(q) = sum_g R_g p_g^t = W_0 + W_j q_j        P = sum_g p_g
//! Q_i = W_i : C        Q_R = (C P, axial of W(q) C^t)
//! ```
//!
//! which is exact: positions are linear in the amplitudes.

use alloc::vec::Vec;

use crate::internal_loads;
use crate::loads::{DistributedFrame, DistributedLoad};
use crate::math::{IDENTITY, Mat3, Vec3, Vec6, axpy, constant, dot, join, mul, split};
use crate::model::Model;
use crate::real::Real;
use crate::time::TimeFunction;

/// A distributed force in the modes.
#[derive(Clone, Debug)]
pub(crate) struct LineLoad {
    dead: bool,
    total: Vec3,
    /// `W_0`, N m.
    rest: Mat3,
    /// `W_j` - (m).
    modal: Vec<Mat3>,
    time: TimeFunction,
    /// `sum_g y_g p_g^t` for the section forces at every place - (places of 6).
    cuts: Vec<[Mat3; 6]>,
}

impl LineLoad {
    /// None where the load follows the sections, has a moment or the shapes are curved: those need their stations.
    pub(crate) fn new(model: &Model, load: &DistributedLoad) -> Option<Self> {
        let dead = match load.frame {
            DistributedFrame::Dead => true,
            DistributedFrame::Body => false,
            DistributedFrame::Follower => return None,
        };
        // On a curved manifold positions are not linear in the amplitudes.
        let curved = model.data().lagrangian.as_ref().is_some_and(|it| it.geometric);
        if curved || load.moment.iter().any(|m| *m != 0.0) {
            return None;
        }
        let mut out = LineLoad {
            dead,
            total: [0.0; 3],
            rest: [[0.0; 3]; 3],
            modal: alloc::vec![[[0.0; 3]; 3]; model.n_modes()],
            time: load.time.clone(),
            cuts: Vec::new(),
        };
        let first = model.first_station(load.member as usize);
        out.cuts = internal_loads::of_line(model, first, load.force.as_chunks::<3>().0);
        for (n, p) in load.force.as_chunks::<3>().0.iter().enumerate() {
            let station = model.carrier(first + n)?;
            out.total = axpy(out.total, 1.0, *p);
            add_dyad(&mut out.rest, station.position, p);
            for (sum, phi) in out.modal.iter_mut().zip(&station.phi) {
                add_dyad(sum, split(phi).0, p);
            }
        }
        Some(out)
    }

    /// The factor on it over time.
    #[inline]
    pub(crate) fn time(&self) -> &TimeFunction {
        &self.time
    }

    /// `C` times the factor.
    #[inline]
    fn turn<R: Real>(&self, factor: R, attitude: &Mat3<R>) -> Mat3<R> {
        let [[a, b, c], [d, e, f], [g, h, i]] = *attitude;
        // C^{AG}, the transposed attitude.
        let c = if self.dead { [[a, d, g], [b, e, h], [c, f, i]] } else { constant(&IDENTITY) };
        c.map(|row| row.map(|x| x * factor))
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
        for (out, y) in out.iter_mut().zip(self.cuts.get(cut).into_iter().flatten()) {
            *out += y.iter().zip(&c).fold(R::of(0.0), |sum, (y, c)| sum + dot(y.map(R::of), *c));
        }
    }

    /// Force and moment about the origin of A, in A, at a factor.
    #[inline]
    pub(crate) fn resultant<R: Real>(
        &self,
        factor: R,
        attitude: &Mat3<R>,
        q: impl Iterator<Item = R>,
    ) -> Vec6<R> {
        let c = self.turn(factor, attitude);
        let mut w = constant(&self.rest);
        for (of_mode, q) in self.modal.iter().zip(q) {
            for (row, of_mode) in w.iter_mut().zip(of_mode) {
                *row = axpy(*row, q, of_mode.map(R::of));
            }
        }
        // sum_g R_g x (C p_g): component a is eps_abc (W C^t)_bc.
        let [x, y, z] = w.map(|row| mul(&c, row));
        join(mul(&c, self.total.map(R::of)), [y[2] - z[1], z[0] - x[2], x[1] - y[0]])
    }

    /// `W_i : C` of the elastic rows.
    #[inline]
    pub(crate) fn elastic<R: Real>(&self, factor: R, attitude: &Mat3<R>) -> impl Iterator<Item = R> {
        let c = self.turn(factor, attitude);
        self.modal
            .iter()
            .map(move |w| w.iter().zip(&c).fold(R::of(0.0), |sum, (w, c)| sum + dot(w.map(R::of), *c)))
    }
}

/// Adds `r p^t`.
fn add_dyad(sum: &mut Mat3, r: Vec3, p: &Vec3) {
    for (row, r) in sum.iter_mut().zip(r) {
        *row = axpy(*row, r, *p);
    }
}
