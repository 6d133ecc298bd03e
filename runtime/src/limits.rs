//! Amplitudes and rates up to which a model holds, from what is stored of the terms that it leaves out (docs/validity.md).

use crate::data::ModelData;

/// Fourth-order displacement that a manifold of third order misses, over the first-order one and the cube of the ratio of second to first
/// order: 0.45 on a beam bent to a circle, 0.39 on the elastica of a force at the tip.
pub(crate) const FOURTH_ORDER: f64 = 0.45;

/// What a model leaves out first as an amplitude grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LeftOut {
    /// The change of the mass matrix.
    Inertia,
    /// The curvature of the shapes: displacements of second order.
    Curvature,
    /// Displacements of fourth order, on the curved manifold of large deflections.
    FourthOrder,
}

impl ModelData {
    /// Amplitude of a mode (index among those kept) at which what the model leaves out reaches a fraction of what it keeps, and what that
    /// is; none without such data.
    pub fn amplitude_limit(&self, mode: usize, fraction: f64) -> Option<(f64, LeftOut)> {
        let ratios = &self.validity.as_ref()?.amplitude;
        let inertia = ratios.get(2 * mode)?.max(f64::MIN_POSITIVE);
        let curvature = ratios.get(2 * mode + 1)?.max(f64::MIN_POSITIVE);
        Some(match &self.lagrangian {
            Some(it) if it.geometric => {
                (libm::cbrt(fraction / FOURTH_ORDER) / curvature, LeftOut::FourthOrder)
            }
            Some(_) => (fraction / curvature, LeftOut::Curvature),
            None if inertia >= curvature => (fraction / inertia, LeftOut::Inertia),
            None => (fraction / curvature, LeftOut::Curvature),
        })
    }

    /// Angular rate about an axis of A (0 to 2), rad/s, at which the centrifugal stiffness that the model leaves out reaches a fraction of the
    /// stiffness of a mode (index among those kept); none where it leaves none out.
    pub fn rate_limit(&self, axis: usize, mode: usize, fraction: f64) -> Option<f64> {
        if self.lagrangian.as_ref().is_some_and(|it| it.geometric) {
            return None;
        }
        let stiffening = *self.validity.as_ref()?.stiffening.get(3 * mode + axis)?;
        // Below this a spin of 1000 rad/s changes nothing: round-off.
        (stiffening > 1e-9).then(|| libm::sqrt(fraction / stiffening))
    }
}
