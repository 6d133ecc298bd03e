//! What a host applies on no point: a wrench on frame A and generalised forces on the modes.

use alloc::{vec, vec::Vec};

use crate::loading::{Axes, Wrench};
use crate::math::{
    Mat3, Vec3, Vec6, add, combine, cross, dot_6, join, mul, mul_t, rotation_and_tangential, split,
};
use crate::model::Model;
use crate::real::Real;

/// A wrench on A and forces on the modes.
#[derive(Clone, Debug)]
pub(crate) struct Direct {
    /// About the origin of A; the axes of its node are those of A.
    wrench: Wrench,
    /// On the elastic modes - (m).
    modal: Vec<f64>,
    /// Where A is, in a model that is not written about it.
    elsewhere: Option<FrameA>,
}

/// Frame A in a mean-axes model, which is written about the centre of mass: a node like any other.
#[derive(Clone, Debug)]
struct FrameA {
    /// Position without deformation, m.
    origin: Vec3,
    /// Its motion per unit modal rate - (m).
    phi: Vec<Vec6>,
}

/// The wrench on A at an instant.
pub(crate) struct OnFrameA<R = f64> {
    /// About the origin of the model's axes, in them.
    pub(crate) resultant: Vec6<R>,
    /// What does work in the motion of A in the modes; none in a model about A, where `Phi_R` of the resultant brings it in.
    modal: Option<Vec6<R>>,
}

impl Direct {
    /// Wrench on A, and forces on the modes - (m); none in a model that is not written about A.
    pub(crate) fn parts(&self) -> Option<(&Wrench, &[f64])> {
        let Direct { wrench, modal, elsewhere } = self;
        elsewhere.is_none().then_some((wrench, modal))
    }

    pub(crate) fn new(model: &Model) -> Self {
        let elsewhere = model.relative.as_ref();
        Direct {
            wrench: Wrench::default(),
            modal: vec![0.0; model.n_modes()],
            elsewhere: elsewhere.map(|a| FrameA { origin: a.origin, phi: a.phi_r.clone() }),
        }
    }

    pub(crate) fn clear(&mut self) {
        self.wrench = Wrench::default();
        self.modal.fill(0.0);
    }

    pub(crate) fn add_wrench(&mut self, axes: Axes, force: Vec3, moment: Vec3) {
        self.wrench.add(axes, 1.0, force, moment);
    }

    /// False, and nothing done, unless there is a force for every mode.
    pub(crate) fn add_modal(&mut self, forces: &[f64]) -> bool {
        let fits = forces.len() == self.modal.len();
        if fits {
            crate::math::add_scaled(&mut self.modal, 1.0, forces);
        }
        fits
    }

    /// Sum of the forces on the modes times factors, one for each.
    pub(crate) fn modal_work(&self, factors: &[f64]) -> f64 {
        self.modal.iter().zip(factors).map(|(force, factor)| force * factor).sum()
    }

    /// The wrench at the deformed state; `attitude` is that of the model's axes.
    #[inline]
    pub(crate) fn on_frame_a<R: Real>(&self, attitude: &Mat3<R>, q: &[R]) -> OnFrameA<R> {
        let Wrench { dead, body, node } = &self.wrench;
        let of = |x: Vec3| x.map(R::of);
        let fixed = |dead: Vec3, body: Vec3| add(mul_t(attitude, of(dead)), of(body));
        let (f, m) = (fixed(dead.0, body.0), fixed(dead.1, body.1));
        let Some(a) = &self.elsewhere else {
            return OnFrameA { resultant: join(add(f, of(node.0)), add(m, of(node.1))), modal: None };
        };
        let (translation, theta) = split(&combine(&a.phi, q));
        let (turn, tangential) = rotation_and_tangential(theta);
        let (f, m) = (add(f, mul(&turn, of(node.0))), add(m, mul(&turn, of(node.1))));
        OnFrameA {
            resultant: join(f, add(m, cross(add(of(a.origin), translation), f))),
            modal: Some(join(f, mul_t(&tangential, mul_t(&turn, m)))),
        }
    }

    /// Adds the forces on the modes and the work of the wrench in them to the elastic rows.
    #[inline]
    pub(crate) fn add_to_modes<R: Real>(&self, on_a: &OnFrameA<R>, elastic: &mut [R]) {
        for (elastic, force) in elastic.iter_mut().zip(&self.modal) {
            *elastic += R::of(*force);
        }
        if let (Some(a), Some(wrench)) = (&self.elsewhere, &on_a.modal) {
            for (elastic, phi) in elastic.iter_mut().zip(&a.phi) {
                *elastic += dot_6(&phi.map(R::of), wrench);
            }
        }
    }
}
