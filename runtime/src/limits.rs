//! Amplitudes and rates up to which a model holds, from what is stored of the terms that it leaves out (docs/validity.md).

use crate::data::ModelData;

/// Fourth-order displacement that a manifold of third order misses, over the first-order one and the cube of the ratio of second to first
/// order: at the tip of a beam bent to a circle 0.45, of the elastica of a force there 0.39; 7/5 of it, as the ratio over the length of a beam is
/// the root of 5/7 of that at its tip.
pub(crate) const FOURTH_ORDER: f64 = 0.63;

/// Shares of what is kept that what is left out reaches at the amplitudes that a model file holds.
pub const LIMIT_LEVELS: [f64; 3] = [0.01, 0.05, 0.1];

/// What a model leaves out first as an amplitude grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LeftOut {
    /// The change of the mass matrix.
    Inertia,
    /// The curvature of the shapes: displacements of second order.
    Curvature,
    /// What the polynomials of the curved manifold of large deflections lack: terms that were dropped, and higher orders.
    HigherOrder,
}

impl ModelData {
    /// Amplitude of a mode (index among those kept) at which what the model leaves out reaches a fraction of what it keeps, and what that
    /// is; none without such data.
    pub fn amplitude_limit(&self, mode: usize, fraction: f64) -> Option<(f64, LeftOut)> {
        let validity = self.validity.as_ref()?;
        if let Some(curve) = &validity.curve {
            let limits = curve.limits.get(3 * mode..)?.first_chunk::<3>()?;
            return Some((between_levels(limits, fraction), LeftOut::HigherOrder));
        }
        let ratios = &validity.amplitude;
        let inertia = ratios.get(2 * mode)?.max(f64::MIN_POSITIVE);
        let curvature = ratios.get(2 * mode + 1)?.max(f64::MIN_POSITIVE);
        Some(match &self.lagrangian {
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

/// Amplitude at a fraction, from those at the levels: between them a power of it; below and above, terms that go with the square.
fn between_levels(limits: &[f64; 3], fraction: f64) -> f64 {
    let [a, b, c] = *limits;
    let [first, second, third] = LIMIT_LEVELS;
    let between = |x: f64, y: f64, from: f64, to: f64| {
        x * libm::pow(y / x, libm::log(fraction / from) / libm::log(to / from))
    };
    if fraction <= first {
        a * libm::sqrt(fraction / first)
    } else if fraction <= second {
        between(a, b, first, second)
    } else if fraction <= third {
        between(b, c, second, third)
    } else {
        c * libm::sqrt(fraction / third)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_give_their_own_limits_and_the_order_goes_on() {
        let limits = [0.3, 0.7, 0.9];
        for (level, limit) in LIMIT_LEVELS.iter().zip(limits) {
            assert!((between_levels(&limits, *level) - limit).abs() < 1e-15);
        }
        assert!((between_levels(&limits, 0.0025) - 0.15).abs() < 1e-15);
        assert!((between_levels(&limits, 0.4) - 1.8).abs() < 1e-15);
        // Halfway in the logarithms.
        assert!((between_levels(&limits, f64::sqrt(5e-4)) - f64::sqrt(0.21)).abs() < 1e-14);
    }
}
