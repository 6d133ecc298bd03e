//! Rotation matrices and matrix functions of a rotation vector, with exact derivatives.
//!
//! Every function of the rotation group used here has the form `F(phi) = I + c1(sigma) phi~ + c2(sigma) phi~ phi~`,
//! `sigma = |phi|^2`. [`MatrixFunction`] holds the two coefficients and their derivatives in `sigma`, and gives the
//! products and derivatives that elements need. All of them are closed forms without a singularity at `phi = 0`.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

use super::stumpff::stumpff;

/// Skew matrix: `skew(a) b = a x b`.
#[inline]
pub fn skew(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// `a~ b~ + b~ a~ = a b^t + b a^t - 2 (a.b) I`.
#[inline]
fn skew_products(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    let ab = a * b.transpose();
    ab + ab.transpose() - Matrix3::from_diagonal_element(2.0 * a.dot(b))
}

/// `a~ a~ = a a^t - (a.a) I`.
#[inline]
fn skew_square(a: &Vector3<f64>) -> Matrix3<f64> {
    a * a.transpose() - Matrix3::from_diagonal_element(a.norm_squared())
}

/// `a~ b~ = b a^t - (a.b) I`.
#[inline]
fn skew_product(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    b * a.transpose() - Matrix3::from_diagonal_element(a.dot(b))
}

/// Rotation vector of a rotation matrix, `|phi| <= pi`.
pub fn log(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    log_quaternion(&q)
}

/// Rotation vector of a unit quaternion, `|phi| <= pi`, accurate to round-off near zero.
pub fn log_quaternion(q: &UnitQuaternion<f64>) -> Vector3<f64> {
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    let v = q.imag() * sign;
    let s = v.norm();
    // atan2(s, w)/s -> 1/w as s -> 0; the quotient itself is accurate down to the smallest normal number.
    let factor = if s > 1e-150 { 2.0 * s.atan2(q.w * sign) / s } else { 2.0 };
    v * factor
}

/// A quaternion as the runtime and the files have it.
pub fn scalar_first(q: &UnitQuaternion<f64>) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}

/// Rotation matrix of a rotation vector, `exp(phi~)`.
pub fn exp(phi: &Vector3<f64>) -> Matrix3<f64> {
    MatrixFunction::exponential(phi).matrix()
}

/// Unit quaternion of a rotation vector.
pub fn exp_quaternion(phi: &Vector3<f64>) -> UnitQuaternion<f64> {
    let half = 0.5 * phi;
    let c = stumpff(half.norm_squared());
    UnitQuaternion::from_quaternion(Quaternion::from_parts(c[0], half * c[1]))
}

/// `F(phi) = I + c1 phi~ + c2 phi~ phi~` at one `phi`, with the derivatives of the coefficients.
#[derive(Clone, Copy, Debug)]
pub struct MatrixFunction {
    phi: Vector3<f64>,
    /// `c1, c2`, their first and their second derivatives in `sigma`.
    c: [f64; 2],
    d: [f64; 2],
    e: [f64; 2],
}

impl MatrixFunction {
    /// `exp(phi~)`: `c1 = C_1`, `c2 = C_2`.
    pub fn exponential(phi: &Vector3<f64>) -> Self {
        let c = stumpff(phi.norm_squared());
        Self::from_stumpff_pair(phi, &c, 1, 1.0)
    }

    /// Material tangential operator `T` (theory section 1): `c1 = -C_2`, `c2 = C_3`; `T phidot` is the angular velocity in
    /// the rotated frame.
    pub fn tangential(phi: &Vector3<f64>) -> Self {
        let c = stumpff(phi.norm_squared());
        Self::from_stumpff_pair(phi, &c, 2, -1.0)
    }

    /// Exponential and tangential operator of the same vector.
    pub fn exponential_and_tangential(phi: &Vector3<f64>) -> (Self, Self) {
        let c = stumpff(phi.norm_squared());
        (Self::from_stumpff_pair(phi, &c, 1, 1.0), Self::from_stumpff_pair(phi, &c, 2, -1.0))
    }

    /// Inverse of the tangential operator: `c1 = 1/2`, `c2 = (C_3 - 2 C_4) / (2 C_2)`. Regular for `|phi| < 2 pi`.
    pub fn inverse_tangential(phi: &Vector3<f64>) -> Self {
        let c = stumpff(phi.norm_squared());
        // c2 = n / d with d = 2 C_2, and dd/dsigma = -n.
        let (n, d) = (c[3] - 2.0 * c[4], 2.0 * c[2]);
        let n1 = 2.5 * c[5] - 0.5 * c[4] - 4.0 * c[6];
        let derivative = |k: usize| 0.5 * (k as f64 * c[k + 2] - c[k + 1]);
        let n2 = 2.5 * derivative(5) - 0.5 * derivative(4) - 4.0 * derivative(6);
        let c2 = n / d;
        let d2 = (n1 + c2 * n) / d;
        let e2 = (n2 + 2.0 * d2 * n + c2 * n1) / d;
        Self { phi: *phi, c: [0.5, c2], d: [0.0, d2], e: [0.0, e2] }
    }

    /// Coefficients `sign C_k` and `C_{k+1}`.
    fn from_stumpff_pair(phi: &Vector3<f64>, c: &[f64; 9], k: usize, sign: f64) -> Self {
        let first = |k: usize| 0.5 * (k as f64 * c[k + 2] - c[k + 1]);
        let second = |k: usize| 0.5 * (k as f64 * first(k + 2) - first(k + 1));
        Self {
            phi: *phi,
            c: [sign * c[k], c[k + 1]],
            d: [sign * first(k), first(k + 1)],
            e: [sign * second(k), second(k + 1)],
        }
    }

    /// The transposed function: `F(phi)^t = F(-phi)`.
    pub fn transposed(&self) -> Self {
        let mut t = *self;
        t.c[0] = -t.c[0];
        t.d[0] = -t.d[0];
        t.e[0] = -t.e[0];
        t
    }

    /// The matrix `F`.
    pub fn matrix(&self) -> Matrix3<f64> {
        Matrix3::identity() + skew(&self.phi) * self.c[0] + skew_square(&self.phi) * self.c[1]
    }

    /// Derivative of the matrix along `phi' = rate`.
    pub fn rate(&self, rate: &Vector3<f64>) -> Matrix3<f64> {
        let (s, r) = (skew(&self.phi), skew(rate));
        let sigma1 = 2.0 * self.phi.dot(rate);
        r * self.c[0] + s * (self.d[0] * sigma1) + (r * s + s * r) * self.c[1] + s * s * (self.d[1] * sigma1)
    }

    /// Second derivative of the matrix along a path with `phi' = rate`, `phi'' = second`.
    pub fn second_rate(&self, rate: &Vector3<f64>, second: &Vector3<f64>) -> Matrix3<f64> {
        let phi = &self.phi;
        let sigma1 = 2.0 * phi.dot(rate);
        let sigma2 = 2.0 * (phi.dot(second) + rate.dot(rate));
        let [d, e] = [0, 1].map(|k| self.d[k] * sigma2 + self.e[k] * sigma1 * sigma1);
        skew(&(second * self.c[0] + rate * (2.0 * self.d[0] * sigma1) + phi * d))
            + (skew_products(second, phi) + skew_square(rate) * 2.0) * self.c[1]
            + skew_products(rate, phi) * (2.0 * self.d[1] * sigma1)
            + skew_square(phi) * e
    }

    /// `d(F f)/dphi` at fixed `f`.
    pub fn derivative_times(&self, f: &Vector3<f64>) -> Matrix3<f64> {
        let phi = &self.phi;
        let once = phi.cross(f);
        let twice = phi.cross(&once);
        skew(f) * (-self.c[0]) - (skew(&once) + skew_product(phi, f)) * self.c[1]
            + (once * self.d[0] + twice * self.d[1]) * (2.0 * phi).transpose()
    }

    /// Derivative of [`Self::derivative_times`] along `phi' = rate`, `f` fixed.
    pub fn derivative_times_rate(&self, f: &Vector3<f64>, rate: &Vector3<f64>) -> Matrix3<f64> {
        let phi = &self.phi;
        let sigma1 = 2.0 * phi.dot(rate);
        let once = phi.cross(f);
        let once1 = rate.cross(f);
        let twice = phi.cross(&once);
        let twice1 = rate.cross(&once) + phi.cross(&once1);
        skew(f) * (-self.d[0] * sigma1)
            - (skew(&once) + skew_product(phi, f)) * (self.d[1] * sigma1)
            - (skew(&once1) + skew_product(rate, f)) * self.c[1]
            + (once * (self.e[0] * sigma1)
                + once1 * self.d[0]
                + twice * (self.e[1] * sigma1)
                + twice1 * self.d[1])
                * (2.0 * phi).transpose()
            + (once * self.d[0] + twice * self.d[1]) * (2.0 * rate).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Vec<Vector3<f64>> {
        let directions = [Vector3::new(0.3, -0.5, 0.8), Vector3::new(-0.9, 0.1, 0.2)];
        [0.0, 1e-9, 1e-3, 0.4, 1.3, 2.9, 4.5]
            .iter()
            .flat_map(|&t| directions.map(|d| d.normalize() * t))
            .collect()
    }

    /// Central differences of step h: error about h^2/6 times the third derivative (order 1) plus eps/h.
    const H: f64 = 1e-5;
    const TOLERANCE: f64 = 1e-9;

    #[test]
    fn exponential_is_a_rotation_and_log_inverts_it() {
        for phi in sample().into_iter().filter(|p| p.norm() < 3.1) {
            let r = exp(&phi);
            assert!((r.transpose() * r - Matrix3::identity()).norm() < 1e-14);
            assert!((log(&r) - phi).norm() < 1e-14, "{phi}");
            assert!((log_quaternion(&exp_quaternion(&phi)) - phi).norm() < 1e-14);
        }
    }

    #[test]
    fn tangential_operator_gives_the_material_angular_velocity() {
        let rate = Vector3::new(0.7, -0.2, 0.4);
        for phi in sample() {
            let d = (exp(&(phi + rate * H)) - exp(&(phi - rate * H))) / (2.0 * H);
            let omega = exp(&phi).transpose() * d;
            let exact = MatrixFunction::tangential(&phi).matrix() * rate;
            assert!((omega - skew(&exact)).norm() < TOLERANCE);
        }
    }

    #[test]
    fn inverse_tangential_inverts() {
        for phi in sample() {
            let t = MatrixFunction::tangential(&phi).matrix();
            let g = MatrixFunction::inverse_tangential(&phi).matrix();
            assert!((t * g - Matrix3::identity()).norm() < 2e-14 * (1.0 + g.norm()), "{phi}");
        }
    }

    #[test]
    fn derivatives_match_differences() {
        let (rate, second) = (Vector3::new(0.7, -0.2, 0.4), Vector3::new(-0.3, 0.9, 0.5));
        let f = Vector3::new(1.1, 0.6, -0.4);
        type Make = fn(&Vector3<f64>) -> MatrixFunction;
        let makes: [Make; 3] =
            [MatrixFunction::exponential, MatrixFunction::tangential, MatrixFunction::inverse_tangential];
        for make in makes {
            for transposed in [false, true] {
                let at = |p: &Vector3<f64>| if transposed { make(p).transposed() } else { make(p) };
                for phi in sample() {
                    let m = at(&phi);
                    let path = |h: f64| phi + rate * h + second * (0.5 * h * h);
                    let d = (at(&path(H)).matrix() - at(&path(-H)).matrix()) / (2.0 * H);
                    assert!((m.rate(&rate) - d).norm() < TOLERANCE);
                    let velocity = |h: f64| rate + second * h;
                    let dd =
                        (at(&path(H)).rate(&velocity(H)) - at(&path(-H)).rate(&velocity(-H))) / (2.0 * H);
                    assert!((m.second_rate(&rate, &second) - dd).norm() < TOLERANCE);
                    assert!((m.derivative_times(&f) * rate - m.rate(&rate) * f).norm() < 1e-13);
                    let a = at(&(phi + rate * H)).derivative_times(&f);
                    let b = at(&(phi - rate * H)).derivative_times(&f);
                    let exact = m.derivative_times_rate(&f, &rate);
                    assert!((exact - (a - b) / (2.0 * H)).norm() < TOLERANCE);
                }
            }
        }
    }
}
