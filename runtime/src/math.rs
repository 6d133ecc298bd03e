//! Small fixed-size algebra: 3-vectors, rotations and the tangential operator.
//!
//! Plain arrays and the `libm` crate, so that the same input gives the same bits with and without `std` and on every
//! machine. Matrices are row-major.

use crate::real::{Real, Smooth};

/// Three components.
pub(crate) type Vec3<R = f64> = [R; 3];
/// Six components, (translation, rotation).
pub(crate) type Vec6<R = f64> = [R; 6];
/// Row-major 3 x 3 matrix.
pub(crate) type Mat3<R = f64> = [Vec3<R>; 3];

/// The identity.
pub(crate) const IDENTITY: Mat3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[inline(always)]
pub(crate) fn add<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn sub<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + s b`.
#[inline(always)]
pub(crate) fn axpy<R: Real>(a: Vec3<R>, s: R, b: Vec3<R>) -> Vec3<R> {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

#[inline(always)]
pub(crate) fn scale<R: Real>(s: R, a: Vec3<R>) -> Vec3<R> {
    [s * a[0], s * a[1], s * a[2]]
}

#[inline(always)]
pub(crate) fn dot<R: Real>(a: Vec3<R>, b: Vec3<R>) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn cross<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `A b`.
#[inline(always)]
pub(crate) fn mul<R: Real>(a: &Mat3<R>, b: Vec3<R>) -> Vec3<R> {
    [dot(a[0], b), dot(a[1], b), dot(a[2], b)]
}

/// `A^t b`.
#[inline(always)]
pub(crate) fn mul_t<R: Real>(a: &Mat3<R>, b: Vec3<R>) -> Vec3<R> {
    axpy(axpy(scale(b[0], a[0]), b[1], a[1]), b[2], a[2])
}

/// `a^t` times both vectors of a pair.
#[inline(always)]
pub(crate) fn mul_t_6<R: Real>(a: &Mat3<R>, b: &Vec6<R>) -> Vec6<R> {
    let (u, v) = split(b);
    join(mul_t(a, u), mul_t(a, v))
}

/// `A B`.
#[inline(always)]
pub(crate) fn mat_mul<R: Real>(a: &Mat3<R>, b: &Mat3<R>) -> Mat3<R> {
    [mul_t(b, a[0]), mul_t(b, a[1]), mul_t(b, a[2])]
}

/// `A^t`.
#[inline(always)]
pub(crate) fn transposed<R: Real>(a: &Mat3<R>) -> Mat3<R> {
    let [[a, b, c], [d, e, f], [g, h, i]] = *a;
    [[a, d, g], [b, e, h], [c, f, i]]
}

/// Adds `r p^t`.
pub(crate) fn add_dyad(sum: &mut Mat3, r: Vec3, p: Vec3) {
    for (row, r) in sum.iter_mut().zip(r) {
        *row = axpy(*row, r, p);
    }
}

/// Axial vector of `sum r f^t`: `sum r x f`.
#[inline(always)]
pub(crate) fn axial<R: Real>(w: &Mat3<R>) -> Vec3<R> {
    let [x, y, z] = *w;
    [y[2] - z[1], z[0] - x[2], x[1] - y[0]]
}

/// `W A^t`: of `sum r f^t`, `sum r (A f)^t`.
#[inline(always)]
pub(crate) fn turn_second<R: Real>(w: &Mat3<R>, a: &Mat3<R>) -> Mat3<R> {
    let [x, y, z] = *w;
    [mul(a, x), mul(a, y), mul(a, z)]
}

/// Translation and rotation part of a six-vector.
#[inline(always)]
pub(crate) fn split<R: Real>(a: &Vec6<R>) -> (Vec3<R>, Vec3<R>) {
    ([a[0], a[1], a[2]], [a[3], a[4], a[5]])
}

/// Six-vector from its translation and rotation part.
#[inline(always)]
pub(crate) fn join<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec6<R> {
    [a[0], a[1], a[2], b[0], b[1], b[2]]
}

#[inline(always)]
pub(crate) fn dot_6<R: Real>(a: &Vec6<R>, b: &Vec6<R>) -> R {
    let ((a_v, a_w), (b_v, b_w)) = (split(a), split(b));
    dot(a_v, b_v) + dot(a_w, b_w)
}

/// `a + b`.
#[inline]
pub(crate) fn add_6(a: &Vec6, b: &Vec6) -> Vec6 {
    let ((a_v, a_w), (b_v, b_w)) = (split(a), split(b));
    join(add(a_v, b_v), add(a_w, b_w))
}

/// `a - b`.
#[inline(always)]
pub(crate) fn sub_6<R: Real>(a: &Vec6<R>, b: &Vec6<R>) -> Vec6<R> {
    let ((a_v, a_w), (b_v, b_w)) = (split(a), split(b));
    join(sub(a_v, b_v), sub(a_w, b_w))
}

/// `A b` for a row-major 6 x 6 matrix that is **symmetric**: summed by columns, which keeps the six sums independent.
#[inline(always)]
pub(crate) fn mul6_symmetric<R: Real>(a: &[Vec6; 6], b: &Vec6<R>) -> Vec6<R> {
    let mut y = [R::of(0.0); 6];
    for (column, x) in a.iter().zip(b) {
        for (y, a) in y.iter_mut().zip(column) {
            *y += R::of(*a) * *x;
        }
    }
    y
}

/// A constant matrix for every instance.
#[inline(always)]
pub(crate) fn constant<R: Real>(a: &Mat3) -> Mat3<R> {
    // Not by `map`, which is not inlined for numbers as long as those of a batch.
    let [x, y, z] = a;
    [constant_vector(x), constant_vector(y), constant_vector(z)]
}

/// A constant vector for every instance.
#[inline(always)]
pub(crate) fn constant_vector<R: Real>(a: &Vec3) -> Vec3<R> {
    let [x, y, z] = *a;
    [R::of(x), R::of(y), R::of(z)]
}

/// The three scalars of rotation by `theta`, from `t2 = |theta|^2`:
/// `sin t / t`, `(1 - cos t)/t^2` and `(t - sin t)/t^3`.
///
/// Below one radian by their power series (relative truncation error below 1e-17 after nine terms, no cancellation);
/// above, the closed forms lose at most a factor 6 of round-off to cancellation, so both sides meet to round-off.
#[inline(always)]
pub(crate) fn rotation_scalars<R: Real>(t2: R) -> (R, R, R) {
    t2.rotation_scalars()
}

/// Below this square of an angle the series are taken.
pub(crate) const SERIES: f64 = 1.0;

/// `(-1)^k / (first + 2 k)!`, k from 0.
#[allow(clippy::indexing_slicing)] // evaluated by the compiler
const fn alternating_factorials(first: u32) -> [f64; 9] {
    let mut coefficients = [0.0; 9];
    let (mut factorial, mut n, mut k) = (1.0, 1, 0);
    while k < 9 {
        while n < first + 2 * k as u32 {
            n += 1;
            factorial *= n as f64;
        }
        coefficients[k] = if k % 2 == 0 { 1.0 / factorial } else { -1.0 / factorial };
        k += 1;
    }
    coefficients
}

#[inline(always)]
pub(crate) fn rotation_series<R: Real>(t2: R) -> (R, R, R) {
    const SINE: [f64; 9] = alternating_factorials(1);
    const COSINE: [f64; 9] = alternating_factorials(2);
    const REST: [f64; 9] = alternating_factorials(3);
    // Estrin's scheme: a third of the dependent operations of Horner's.
    let (t4, t8) = (t2 * t2, t2 * t2 * t2 * t2);
    let sum = |c: &[f64; 9]| {
        let [a, b, c, d, e, f, g, h, last] = *c;
        let pair = |a, b| R::of(a) + R::of(b) * t2;
        let (low, high) = (pair(a, b) + pair(c, d) * t4, pair(e, f) + pair(g, h) * t4);
        low + (high + R::of(last) * t8) * t8
    };
    (sum(&SINE), sum(&COSINE), sum(&REST))
}

pub(crate) fn rotation_closed(t2: f64) -> (f64, f64, f64) {
    let t = libm::sqrt(t2);
    let sin = libm::sin(t);
    let half = libm::sin(0.5 * t);
    (sin / t, 2.0 * half * half / t2, (t - sin) / (t2 * t))
}

/// Derivatives of the last two of [`rotation_scalars`] by `t2`: of `c = (1 - cos t)/t^2` and `d = (t - sin t)/t^3`.
///
/// Above one radian the closed forms `(s - 2 c)/(2 t^2)` and `(c - 3 d)/(2 t^2)` lose a factor of 30 of round-off at most.
pub(crate) fn rotation_scalar_slopes(t2: f64) -> (f64, f64) {
    if t2 < SERIES {
        const COSINE: [f64; 9] = alternating_factorials(2);
        const REST: [f64; 9] = alternating_factorials(3);
        let slope = |c: &[f64; 9]| {
            c.iter().enumerate().skip(1).rev().fold(0.0, |sum, (k, c)| sum * t2 + k as f64 * c)
        };
        return (slope(&COSINE), slope(&REST));
    }
    let (s, c, d) = rotation_closed(t2);
    (0.5 * (s - 2.0 * c) / t2, 0.5 * (c - 3.0 * d) / t2)
}

/// Second derivatives of the same by `t2`: `(s' - 4 c')/(2 t^2)` and `(c' - 5 d')/(2 t^2)`, with `s' = (d - c)/2`, above one radian.
pub(crate) fn rotation_scalar_curvatures(t2: f64) -> (f64, f64) {
    if t2 < SERIES {
        const COSINE: [f64; 9] = alternating_factorials(2);
        const REST: [f64; 9] = alternating_factorials(3);
        let curvature = |c: &[f64; 9]| {
            let terms = c.iter().enumerate().skip(2).rev();
            terms.fold(0.0, |sum, (k, c)| sum * t2 + (k * (k - 1)) as f64 * c)
        };
        return (curvature(&COSINE), curvature(&REST));
    }
    let (_, c, d) = rotation_closed(t2);
    let (c_slope, d_slope) = rotation_scalar_slopes(t2);
    (0.5 * (0.5 * (d - c) - 4.0 * c_slope) / t2, 0.5 * (c_slope - 5.0 * d_slope) / t2)
}

/// `T_dot theta_dot`: what the angular velocity `T theta_dot` gains at constant `theta_dot`, per unit of time.
pub(crate) fn tangential_rate<R: Smooth>(theta: Vec3<R>, theta_dot: Vec3<R>) -> Vec3<R> {
    let t2 = dot(theta, theta);
    let (_, _, d) = rotation_scalars(t2);
    let (c_slope, d_slope) = t2.rotation_scalar_slopes();
    let t2_dot = R::of(2.0) * dot(theta, theta_dot);
    let turned = cross(theta, theta_dot);
    let rest = axpy(scale(d_slope * t2_dot, cross(theta, turned)), d, cross(theta_dot, turned));
    axpy(rest, -c_slope * t2_dot, turned)
}

/// `exp(theta~)`: rotation matrix of a Cartesian rotation vector.
#[inline(always)]
pub(crate) fn rotation<R: Real>(theta: Vec3<R>) -> Mat3<R> {
    let (s, c, _) = rotation_scalars(dot(theta, theta));
    quadratic(theta, s, c)
}

/// Tangential operator `T(theta) = I - (1-cos t)/t^2 theta~ + (t - sin t)/t^3 theta~ theta~` (THEORY section 1).
#[inline(always)]
pub(crate) fn tangential<R: Real>(theta: Vec3<R>) -> Mat3<R> {
    let (_, c, d) = rotation_scalars(dot(theta, theta));
    quadratic(theta, -c, d)
}

/// `exp(theta~)` and `T(theta)` together.
#[inline(always)]
pub(crate) fn rotation_and_tangential<R: Real>(theta: Vec3<R>) -> (Mat3<R>, Mat3<R>) {
    let (s, c, d) = rotation_scalars(dot(theta, theta));
    (quadratic(theta, s, c), quadratic(theta, -c, d))
}

/// `I + a theta~ + b theta~ theta~`.
#[inline(always)]
fn quadratic<R: Real>(theta: Vec3<R>, a: R, b: R) -> Mat3<R> {
    let ([x, y, z], one) = (theta, R::of(1.0));
    let (xy, xz, yz) = (b * x * y, b * x * z, b * y * z);
    let (xx, yy, zz) = (b * x * x, b * y * y, b * z * z);
    [
        [one - (yy + zz), xy - a * z, xz + a * y],
        [xy + a * z, one - (xx + zz), yz - a * x],
        [xz - a * y, yz + a * x, one - (xx + yy)],
    ]
}

/// Unit quaternion (scalar first) of a Cartesian rotation vector.
#[inline(always)]
pub(crate) fn quaternion<R: Real>(theta: Vec3<R>) -> [R; 4] {
    let half = scale(R::of(0.5), theta);
    let t2 = dot(half, half);
    // cos t = 1 - t^2 (1 - cos t)/t^2 keeps one set of scalars for all.
    let (s, c, _) = rotation_scalars(t2);
    [R::of(1.0) - t2 * c, s * half[0], s * half[1], s * half[2]]
}

/// Quaternion product.
#[inline(always)]
pub(crate) fn quaternion_product<R: Real>(a: [R; 4], b: [R; 4]) -> [R; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The quaternion scaled to unit length.
#[inline(always)]
pub(crate) fn normalised<R: Real>(a: [R; 4]) -> [R; 4] {
    let r = R::of(1.0) / (a[0] * a[0] + a[1] * a[1] + a[2] * a[2] + a[3] * a[3]).sqrt();
    [r * a[0], r * a[1], r * a[2], r * a[3]]
}

/// Rotation matrix of a quaternion of any length: `C^{GA}` from `zeta`.
#[inline(always)]
pub(crate) fn matrix<R: Real>(zeta: [R; 4]) -> Mat3<R> {
    let [s, x, y, z] = zeta;
    let one = R::of(1.0);
    let f = R::of(2.0) / (s * s + x * x + y * y + z * z);
    let (fx, fy, fz) = (f * x, f * y, f * z);
    let (xy, xz, yz) = (fx * y, fx * z, fy * z);
    let (sx, sy, sz) = (s * fx, s * fy, s * fz);
    let (fxx, fyy, fzz) = (fx * x, fy * y, fz * z);
    [
        [one - (fyy + fzz), xy - sz, xz + sy],
        [xy + sz, one - (fxx + fzz), yz - sx],
        [xz - sy, yz + sx, one - (fxx + fyy)],
    ]
}

/// `Phi q`, the six-vectors of `phi` weighted by `q`.
#[inline(always)]
pub(crate) fn combine<R: Real>(phi: &[Vec6], q: &[R]) -> Vec6<R> {
    let mut sum = [R::of(0.0); 6];
    for (phi, q) in phi.iter().zip(q) {
        for (sum, phi) in sum.iter_mut().zip(phi) {
            *sum += *q * R::of(*phi);
        }
    }
    sum
}

/// `a += s b`.
#[inline(always)]
pub(crate) fn add_scaled(a: &mut [f64], s: f64, b: &[f64]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += s * b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const THETA: Vec3 = [0.3, -0.7, 0.4];

    fn largest(a: &Mat3, b: &Mat3) -> f64 {
        a.as_flattened().iter().zip(b.as_flattened()).fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()))
    }

    #[test]
    fn series_and_closed_forms_agree_where_they_meet() {
        for t2 in [0.9, 0.99, 1.0 - f64::EPSILON, 1.0, 1.01, 1.1] {
            let (series, closed) = (rotation_series(t2), rotation_closed(t2));
            for (a, b) in [(series.0, closed.0), (series.1, closed.1), (series.2, closed.2)] {
                // The third closed form loses a factor 6 of round-off.
                assert!((a - b).abs() <= 12.0 * f64::EPSILON * b, "{a} and {b} at {t2}");
            }
        }
        assert_eq!(rotation_scalars(0.0), (1.0, 0.5, 1.0 / 6.0));
    }

    #[test]
    fn rotations_are_those_of_nalgebra() {
        for size in [0.0, 1e-9, 1e-3, 0.5, 1.2, 3.0, 6.0] {
            let theta = scale(size, THETA);
            let expected = nalgebra::UnitQuaternion::from_scaled_axis(nalgebra::Vector3::from(theta));
            let matrix_expected = expected.to_rotation_matrix();
            let expected_rows: Mat3 =
                core::array::from_fn(|i| core::array::from_fn(|j| matrix_expected[(i, j)]));
            assert!(largest(&rotation(theta), &expected_rows) < 4e-15);
            // A quaternion of any length gives the same matrix.
            let longer = quaternion(theta).map(|x| 1.7 * x);
            assert!(largest(&matrix(longer), &expected_rows) < 4e-15);
        }
    }

    #[test]
    fn quaternions_compose_as_rotations() {
        let (a, b) = ([0.3, 0.1, -0.9], [1.4, -0.2, 0.6]);
        let product = matrix(quaternion_product(quaternion(a), quaternion(b)));
        assert!(largest(&product, &mat_mul(&rotation(a), &rotation(b))) < 4e-15);
        assert_eq!(normalised([2.0, 0.0, 0.0, 0.0]), [1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn slopes_of_the_rotation_scalars_agree_where_their_forms_meet_and_are_derivatives() {
        for t2 in [0.0, 1e-6, 0.3, 0.999, 1.0, 1.5, 9.0, 30.0] {
            let h = 1e-4 * f64::max(t2, 1e-2);
            let (after, before) = (rotation_scalars(t2 + h), rotation_scalars((t2 - h).abs()));
            let width = t2 + h - (t2 - h).abs();
            let (c, d) = rotation_scalar_slopes(t2);
            if width > 0.0 {
                // Central differences: h^2 times a third derivative below 1/100, round-off over h.
                assert!((c - (after.1 - before.1) / width).abs() < 1e-9, "{t2}");
                assert!((d - (after.2 - before.2) / width).abs() < 1e-9, "{t2}");
            }
        }
        let (series, closed) = (rotation_scalar_slopes(1.0 - f64::EPSILON), rotation_scalar_slopes(1.0));
        assert!((series.0 - closed.0).abs() < 30.0 * f64::EPSILON * closed.0.abs());
        assert!((series.1 - closed.1).abs() < 60.0 * f64::EPSILON * closed.1.abs());
        assert_eq!(rotation_scalar_slopes(0.0), (-1.0 / 24.0, -1.0 / 120.0));
    }

    #[test]
    fn curvatures_of_the_rotation_scalars_are_slopes_of_their_slopes() {
        for t2 in [1e-3, 0.3, 0.9, 1.5, 9.0, 30.0] {
            let h = 1e-4 * t2;
            let (after, before) = (rotation_scalar_slopes(t2 + h), rotation_scalar_slopes(t2 - h));
            let (c, d) = rotation_scalar_curvatures(t2);
            // Central differences: (h^2)/6 of fourth derivatives below 1/1000, round-off below 1e-16 over h.
            assert!((c - (after.0 - before.0) / (2.0 * h)).abs() < 1e-10, "{t2}");
            assert!((d - (after.1 - before.1) / (2.0 * h)).abs() < 1e-10, "{t2}");
        }
        let (series, closed) =
            (rotation_scalar_curvatures(SERIES - 1e-15), rotation_scalar_curvatures(SERIES));
        // The closed forms lose a factor of some hundred of round-off.
        assert!((series.0 - closed.0).abs() < 1e3 * f64::EPSILON * closed.0.abs());
        assert!((series.1 - closed.1).abs() < 1e3 * f64::EPSILON * closed.1.abs());
        assert_eq!(rotation_scalar_curvatures(0.0), (2.0 / 720.0, 2.0 / 5040.0));
    }

    #[test]
    fn the_rate_of_the_tangential_operator_is_its_derivative() {
        let rate: Vec3 = [-0.4, 1.1, 0.6];
        for size in [0.0, 1e-4, 0.5, 1.3, 3.0] {
            let (theta, h) = (scale(size, THETA), 1e-5);
            let spin = |h: f64| mul(&tangential(axpy(theta, h, rate)), rate);
            let slope = scale(0.5 / h, sub(spin(h), spin(-h)));
            let error = sub(tangential_rate(theta, rate), slope);
            assert!(dot(error, error) < 1e-18, "{error:?} at {size}");
        }
    }

    #[test]
    fn tangential_operator_turns_rates_of_the_vector_into_angular_velocity() {
        // exp(theta~)^t d exp(theta~) = (T dtheta)~, by central differences along three directions.
        for size in [0.0, 1e-4, 0.5, 1.3, 3.0] {
            let theta = scale(size, THETA);
            let t = tangential(theta);
            assert!(largest(&rotation_and_tangential(theta).1, &t) == 0.0);
            for direction in IDENTITY {
                let h = 1e-5;
                let (after, before) =
                    (rotation(axpy(theta, h, direction)), rotation(axpy(theta, -h, direction)));
                let here = rotation(theta);
                // Vee of R^t dR/dtheta.
                let column = |i: usize| {
                    let slope: Vec3 =
                        core::array::from_fn(|row| (after[row][i] - before[row][i]) / (2.0 * h));
                    mul_t(&here, slope)
                };
                let spin = [column(1)[2], column(2)[0], column(0)[1]];
                let error = sub(spin, mul(&t, direction));
                assert!(dot(error, error) < 1e-18, "{error:?} at {size}");
            }
        }
    }
}
