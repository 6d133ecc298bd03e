//! Straight and circular pieces of a member's axis, by arc length.

use core::f64::consts::TAU;
use nalgebra::Vector3;

/// Sine of the angle below which three points count as lying on one line, so that no circle goes through them.
const COLLINEAR: f64 = 1e-6;

/// One smooth piece of a member's axis.
#[derive(Clone, Debug)]
pub(crate) enum Piece {
    /// From a point along a unit direction.
    Line {
        /// Start, m.
        start: Vector3<f64>,
        /// Unit tangent.
        direction: Vector3<f64>,
        /// Length, m.
        length: f64,
    },
    /// `start + radius ((cos(phi) - 1) e1 + sin(phi) e2)`, `phi` from 0 to `angle`: taken from the start, not from the
    /// centre, so that flat arcs lose no digits to a large radius.
    Arc {
        /// Start, m.
        start: Vector3<f64>,
        /// Unit vector from the centre to the start.
        e1: Vector3<f64>,
        /// Unit tangent at the start.
        e2: Vector3<f64>,
        /// Radius, m.
        radius: f64,
        /// Angle swept, rad, in (0, 2 pi).
        angle: f64,
    },
}

impl Piece {
    /// Straight line between two different points; `None` if they coincide.
    pub(crate) fn line(from: Vector3<f64>, to: Vector3<f64>) -> Option<Self> {
        let length = (to - from).norm();
        (length > 0.0).then(|| Self::Line { start: from, direction: (to - from) / length, length })
    }

    /// Arc from a point through another to a third; `None` if no circle goes through them.
    pub(crate) fn arc_through(from: Vector3<f64>, through: Vector3<f64>, to: Vector3<f64>) -> Option<Self> {
        let (u, v) = (through - from, to - from);
        let w = u.cross(&v);
        // The third side counts too: with `through` close to `to` the sine at `from` alone says nothing.
        if w.norm() <= COLLINEAR * u.norm() * v.norm()
            || w.norm() <= COLLINEAR * (to - through).norm() * v.norm()
        {
            return None;
        }
        // Circumcentre relative to `from`.
        let c = (v * u.norm_squared() - u * v.norm_squared()).cross(&w) / (2.0 * w.norm_squared());
        let radius = c.norm();
        let e1 = -c / radius;
        let e2 = w.normalize().cross(&e1);
        // tan(phi/2) = (1 - cos(phi)) / sin(phi).
        let angle = 2.0 * (-v.dot(&e1)).atan2(v.dot(&e2));
        Some(Self::Arc { start: from, e1, e2, radius, angle })
    }

    /// The shorter arc between two points about a centre; `None` if the three lie on one line. The radius is that of
    /// the start: the caller has checked that the end has the same.
    pub(crate) fn arc_about(from: Vector3<f64>, centre: Vector3<f64>, to: Vector3<f64>) -> Option<Self> {
        let (a, b) = (from - centre, to - centre);
        let normal = a.cross(&b);
        if normal.norm() <= COLLINEAR * a.norm() * b.norm() {
            return None;
        }
        let radius = a.norm();
        let e1 = a / radius;
        let e2 = normal.normalize().cross(&e1);
        Some(Self::Arc { start: from, e1, e2, radius, angle: normal.norm().atan2(a.dot(&b)) })
    }

    /// Length along the axis, m.
    pub(crate) fn length(&self) -> f64 {
        match self {
            Self::Line { length, .. } => *length,
            Self::Arc { radius, angle, .. } => radius * angle,
        }
    }

    /// Position at arc length `s` from the start, m.
    pub(crate) fn position(&self, s: f64) -> Vector3<f64> {
        match self {
            Self::Line { start, direction, .. } => start + direction * s,
            Self::Arc { start, e1, e2, radius, .. } => {
                let (sin, cos) = (0.5 * s / radius).sin_cos();
                start + (e2 * cos - e1 * sin) * (2.0 * radius * sin)
            }
        }
    }

    /// Unit tangent at arc length `s` from the start.
    pub(crate) fn tangent(&self, s: f64) -> Vector3<f64> {
        match self {
            Self::Line { direction, .. } => *direction,
            Self::Arc { e1, e2, radius, .. } => {
                let (sin, cos) = (s / radius).sin_cos();
                e2 * cos - e1 * sin
            }
        }
    }

    /// Arc length of the place nearest to `p` and the distance to it, m.
    pub(crate) fn nearest(&self, p: &Vector3<f64>) -> (f64, f64) {
        let s = match self {
            Self::Line { start, direction, length } => (p - start).dot(direction).clamp(0.0, *length),
            Self::Arc { start, e1, e2, radius, angle } => {
                let r = p - start;
                let phi = r.dot(e2).atan2(r.dot(e1) + radius).rem_euclid(TAU);
                // Beyond the end, the nearer end point is nearest.
                let beyond = if phi - angle < TAU - phi { *angle } else { 0.0 };
                radius * if phi <= *angle { phi } else { beyond }
            }
        };
        (s, (p - self.position(s)).norm())
    }

    /// Largest `|tangent . direction|` anywhere on the piece, and the arc length where it occurs. `direction` is a
    /// unit vector: 1 means parallel.
    pub(crate) fn alignment(&self, direction: &Vector3<f64>) -> (f64, f64) {
        let at = |s: f64| (self.tangent(s).dot(direction).abs(), s);
        let Self::Arc { e1, e2, radius, angle, .. } = self else { return at(0.0) };
        // tangent . direction = a cos(phi) - b sin(phi) is extreme at atan2(-b, a) + k pi, or at an end.
        let (a, b) = (e2.dot(direction), e1.dot(direction));
        let extreme = (-b).atan2(a);
        let inside = (0..4).map(|k| extreme + f64::from(k - 1) * core::f64::consts::PI);
        inside
            .filter(|phi| (0.0..=*angle).contains(phi))
            .chain([0.0, *angle])
            .map(|phi| at(radius * phi))
            .fold((0.0, 0.0), |best, next| if next.0 > best.0 { next } else { best })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use core::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};
    use proptest::prelude::*;

    fn v(x: f64, y: f64, z: f64) -> Vector3<f64> {
        Vector3::new(x, y, z)
    }

    #[test]
    fn quarter_circle_through_and_about_agree() {
        let through =
            Piece::arc_through(v(1.0, 0.0, 2.0), v(FRAC_1_SQRT_2, FRAC_1_SQRT_2, 2.0), v(0.0, 1.0, 2.0))
                .unwrap();
        let about = Piece::arc_about(v(1.0, 0.0, 2.0), v(0.0, 0.0, 2.0), v(0.0, 1.0, 2.0)).unwrap();
        for arc in [through, about] {
            assert_relative_eq!(arc.length(), FRAC_PI_2, epsilon = 1e-14);
            assert_relative_eq!(arc.tangent(0.0), v(0.0, 1.0, 0.0), epsilon = 1e-14);
            assert_relative_eq!(arc.tangent(FRAC_PI_2), v(-1.0, 0.0, 0.0), epsilon = 1e-14);
            assert_relative_eq!(arc.position(FRAC_PI_2), v(0.0, 1.0, 2.0), epsilon = 1e-14);
        }
    }

    #[test]
    fn three_quarter_circle_goes_the_way_of_its_third_point() {
        let arc = Piece::arc_through(v(1.0, 0.0, 0.0), v(-1.0, 0.0, 0.0), v(0.0, -1.0, 0.0)).unwrap();
        assert_relative_eq!(arc.length(), 1.5 * PI, epsilon = 1e-14);
        assert_relative_eq!(arc.position(FRAC_PI_2), v(0.0, 1.0, 0.0), epsilon = 1e-14);
    }

    #[test]
    fn flat_arcs_end_where_they_should() {
        for rise in [1e-1, 1e-3, 1e-5, 3e-6] {
            let (from, to) = (v(1.0, 2.0, 3.0), v(11.0, 2.0, 3.0));
            let arc = Piece::arc_through(from, v(6.0, 2.0, 3.0 + 10.0 * rise), to).unwrap();
            assert!((arc.position(arc.length()) - to).norm() < 1e-13, "rise {rise}");
            // Sagitta of a flat arc: s = c (1 + 8/3 (h/c)^2 - ...).
            let expected = 10.0 * (1.0 + 8.0 / 3.0 * rise * rise);
            assert!((arc.length() - expected).abs() < 10.0 * 4.0 * rise.powi(4) + 1e-13, "rise {rise}");
        }
    }

    #[test]
    fn points_on_a_line_have_no_arc() {
        let [a, b, c] = [v(0.0, 0.0, 0.0), v(1.0, 1.0, 0.0), v(2.0, 2.0, 0.0)];
        assert!(Piece::arc_through(a, b, c).is_none());
        assert!(Piece::arc_through(a, a, c).is_none());
        assert!(Piece::arc_through(a, c, c).is_none());
        assert!(Piece::arc_about(a, b, c).is_none());
        assert!(Piece::line(a, a).is_none());
    }

    proptest! {
        /// Against a dense scan of the curve, which misses the optimum by at most half its spacing.
        #[test]
        fn nearest_and_alignment_match_a_scan(
            a in prop::array::uniform3(-1.0..1.0f64), m in prop::array::uniform3(-1.0..1.0f64),
            b in prop::array::uniform3(-1.0..1.0f64), p in prop::array::uniform3(-2.0..2.0f64),
        ) {
            let [a, m, b, p] = [a, m, b, p].map(Vector3::from);
            let Some(arc) = Piece::arc_through(a, m, b) else { return Ok(()) };
            prop_assume!(arc.length() < 20.0 && p.norm() > 0.1);
            let n = 4000;
            let stations = (0..=n).map(|i| arc.length() * f64::from(i) / f64::from(n));
            let spacing = arc.length() / f64::from(n);
            let direction = p.normalize();
            let scan = stations.clone().map(|s| (arc.position(s) - p).norm()).fold(f64::MAX, f64::min);
            let aligned = stations.map(|s| arc.tangent(s).dot(&direction).abs()).fold(0.0, f64::max);
            let (s, distance) = arc.nearest(&p);
            prop_assert!((0.0..=arc.length() * (1.0 + 1e-12)).contains(&s));
            prop_assert!(distance <= scan + 1e-9 && distance >= scan - spacing);
            let best = arc.alignment(&direction).0;
            prop_assert!(best >= aligned - 1e-9 && best <= aligned + spacing);
            prop_assert!((arc.position(arc.length()) - b).norm() < 1e-6);
        }
    }
}
