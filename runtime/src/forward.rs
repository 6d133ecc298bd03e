//! Forward differentiation: numbers that carry their slopes along several directions at once.
//!
//! What is written for any [`Real`] gives exact derivatives when it is evaluated with these: no step, no rule of differences.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use crate::expression::Variables;
use crate::math::{Vec3, rotation_scalar_curvatures, rotation_scalar_slopes};
use crate::real::{LANES, Real, Smooth, by_lane};

/// Directions differentiated along together: one register of the widest machines.
pub(crate) const DIRECTIONS: usize = LANES;

/// A value and its slopes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Forward {
    pub(crate) value: f64,
    pub(crate) slopes: [f64; DIRECTIONS],
}

impl Forward {
    /// A function with the value and the derivative given, of this number. A derivative that is not finite (of a root at zero)
    /// counts only where there is something to multiply.
    #[inline(always)]
    pub(crate) fn mapped(&self, value: f64, derivative: f64) -> Self {
        let by = |slope: f64| if slope == 0.0 { 0.0 } else { derivative * slope };
        Forward { value, slopes: by_lane(&self.slopes, &self.slopes, |x, _| by(x)) }
    }

    /// Slopes from those of two.
    #[inline(always)]
    fn combined(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> [f64; DIRECTIONS] {
        by_lane(&self.slopes, &other.slopes, f)
    }

    /// Slope along a direction; NaN where there is no such direction.
    #[inline(always)]
    pub(crate) fn slope(&self, direction: usize) -> f64 {
        self.slopes.get(direction).copied().unwrap_or(f64::NAN)
    }

    /// Adds one to the slope along a direction.
    #[inline(always)]
    pub(crate) fn seed(&mut self, direction: usize, slope: f64) {
        if let Some(place) = self.slopes.get_mut(direction) {
            *place += slope;
        }
    }
}

/// Numbers as they are, without slopes, into numbers with slopes.
pub(crate) fn take_values(to: &mut [Forward], from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = Forward::of(*from);
    }
}

/// What expressions see, with slopes; the time has none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ForwardVariables {
    pub(crate) t: f64,
    pub(crate) v_a: Vec3<Forward>,
    pub(crate) w_a: Vec3<Forward>,
    pub(crate) r_g: Vec3<Forward>,
}

impl ForwardVariables {
    /// The values alone.
    pub(crate) fn values(&self) -> Variables {
        let of = |x: Vec3<Forward>| x.map(|x| x.value);
        Variables { t: self.t, v_a: of(self.v_a), w_a: of(self.w_a), r_g: of(self.r_g) }
    }
}

impl Add for Forward {
    type Output = Self;

    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl AddAssign for Forward {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        self.slopes = self.combined(&other, |a, b| a + b);
    }
}

impl Sub for Forward {
    type Output = Self;

    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        self -= other;
        self
    }
}

impl SubAssign for Forward {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        self.value -= other.value;
        self.slopes = self.combined(&other, |a, b| a - b);
    }
}

impl Mul for Forward {
    type Output = Self;

    // The rule of products.
    #[allow(clippy::suspicious_arithmetic_impl)]
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let value = self.value * other.value;
        Forward { value, slopes: self.combined(&other, |a, b| a * other.value + self.value * b) }
    }
}

impl Div for Forward {
    type Output = Self;

    // The rule of quotients.
    #[allow(clippy::suspicious_arithmetic_impl)]
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Forward { value, slopes: self.combined(&other, |a, b| (a - value * b) / other.value) }
    }
}

impl Neg for Forward {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Forward { value: -self.value, slopes: by_lane(&self.slopes, &self.slopes, |x, _| -x) }
    }
}

impl Real for Forward {
    const IS_WIDE: bool = true;

    #[inline(always)]
    fn of(x: f64) -> Self {
        Forward { value: x, slopes: [0.0; DIRECTIONS] }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = libm::sqrt(self.value);
        self.mapped(root, 0.5 / root)
    }

    #[inline(always)]
    fn rotation_scalars(self) -> (Self, Self, Self) {
        let (s, c, d) = self.value.rotation_scalars();
        let (c_slope, d_slope) = rotation_scalar_slopes(self.value);
        (self.mapped(s, 0.5 * (d - c)), self.mapped(c, c_slope), self.mapped(d, d_slope))
    }
}

impl Smooth for Forward {
    fn rotation_scalar_slopes(self) -> (Self, Self) {
        let (c, d) = rotation_scalar_slopes(self.value);
        let (c_slope, d_slope) = rotation_scalar_curvatures(self.value);
        (self.mapped(c, c_slope), self.mapped(d, d_slope))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{axpy, dot, mul, normalised, rotation_and_tangential, tangential_rate};

    /// Slopes of rotations, tangential operators and their rates against central differences of sixth order.
    #[test]
    fn kernels_give_their_derivatives() {
        let direction: Vec3 = [0.4, -0.9, 0.3];
        let rate: Vec3 = [-0.4, 1.1, 0.6];
        fn kernel<R: Smooth>(theta: Vec3<R>, rate: Vec3<R>) -> [R; 12] {
            let (turn, tangential) = rotation_and_tangential(theta);
            let [a, b, c] = mul(&turn, rate);
            let [d, e, f] = mul(&tangential, rate);
            let [g, h, i] = tangential_rate(theta, rate);
            let [j, k, l, _] = normalised([theta[0], theta[1], theta[2], R::of(10.0) / dot(rate, rate)]);
            [a, b, c, d, e, f, g, h, i, j, k, l]
        }
        for size in [0.0, 1e-3, 0.6, 1.3, 2.8] {
            let theta: Vec3 = [0.3 * size, -0.7 * size, 0.4 * size];
            let forward: Vec3<Forward> = core::array::from_fn(|i| {
                let mut x = Forward::of(theta[i]);
                x.seed(3, direction[i]);
                x
            });
            let found = kernel(forward, rate.map(Forward::of));
            let at = |h: f64| kernel(axpy(theta, h, direction), rate);
            let h = 0.02;
            let (a, b, c) = ((at(h), at(-h)), (at(2.0 * h), at(-2.0 * h)), (at(3.0 * h), at(-3.0 * h)));
            for i in 0..12 {
                let rule = 0.75 * (a.0[i] - a.1[i]) - 0.15 * (b.0[i] - b.1[i]) + (c.0[i] - c.1[i]) / 60.0;
                // h^6/140 of seventh derivatives, which are below a hundred here; round-off 1e-16 over h.
                assert!((found[i].slope(3) - rule / h).abs() < 1e-10, "{i} at {size}: {:?} {rule}", found[i]);
                assert!(found[i].slope(2) == 0.0 && (found[i].value - at(0.0)[i]).abs() < 1e-15);
            }
        }
    }
}
