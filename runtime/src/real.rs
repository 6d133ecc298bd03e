//! What the kernels compute with: one number, or the numbers of several instances side by side.
//!
//! The kernels of a step are written once for both, so that an instance of a batch goes through the same operations in the same
//! order as one alone and has the same bits.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use crate::math::{SERIES, rotation_closed, rotation_scalar_slopes, rotation_series};

/// A number or several.
pub(crate) trait Real:
    Copy
    + Debug
    + Default
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// Whether one fills the widest registers by itself.
    const IS_WIDE: bool;

    /// The same number for all.
    fn of(x: f64) -> Self;

    /// Square root.
    fn sqrt(self) -> Self;

    /// `sin t / t`, `(1 - cos t)/t^2` and `(t - sin t)/t^3` of `t^2`, see [`crate::math::rotation_scalars`].
    fn rotation_scalars(self) -> (Self, Self, Self);
}

/// A number that derivatives of the rotation scalars are known of.
pub(crate) trait Smooth: Real {
    /// Derivatives by `t^2` of the last two of [`Real::rotation_scalars`].
    fn rotation_scalar_slopes(self) -> (Self, Self);
}

impl Smooth for f64 {
    fn rotation_scalar_slopes(self) -> (f64, f64) {
        rotation_scalar_slopes(self)
    }
}

impl Real for f64 {
    const IS_WIDE: bool = false;

    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        libm::sqrt(self)
    }

    #[inline(always)]
    fn rotation_scalars(self) -> (f64, f64, f64) {
        if self < SERIES { rotation_series(self) } else { rotation_closed(self) }
    }
}

/// Instances that a batch steps together: one register of the widest machines.
pub(crate) const LANES: usize = 8;

/// One number of each of [`LANES`] instances.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub(crate) struct Lanes(pub(crate) [f64; LANES]);

impl Default for Lanes {
    /// As one register; that of the array would be set number by number.
    #[inline(always)]
    fn default() -> Self {
        Lanes([0.0; LANES])
    }
}

impl Lanes {
    /// That of one instance; NaN where there is no such lane.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> f64 {
        self.0.get(lane).copied().unwrap_or(f64::NAN)
    }

    /// Each by a function of one number.
    #[inline(always)]
    pub(crate) fn each(self, f: impl Fn(f64) -> f64) -> Self {
        Lanes(by_lane(&self.0, &self.0, |x, _| f(x)))
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, x: f64) {
        if let Some(place) = self.0.get_mut(lane) {
            *place = x;
        }
    }

    /// Vectors, one of each instance.
    #[inline(always)]
    pub(crate) fn side_by_side<const N: usize>(each: &[[f64; N]; LANES]) -> [Lanes; N] {
        let mut lanes = [Lanes::default(); N];
        for (lane, vector) in each.iter().enumerate() {
            for (to, from) in lanes.iter_mut().zip(vector) {
                to.set(lane, *from);
            }
        }
        lanes
    }

    /// Takes over the numbers of the lanes chosen.
    #[inline(always)]
    pub(crate) fn take(&mut self, chosen: &[bool; LANES], from: &Lanes) {
        for ((to, from), chosen) in self.0.iter_mut().zip(&from.0).zip(chosen) {
            *to = if *chosen { *from } else { *to };
        }
    }
}

/// At the end of the body of a loop, or of an operation on lanes: keeps the compiler from making vectors of several passes of the loop
/// (whose numbers lie far apart, so that it gathers and scatters them) where one pass has enough numbers side by side. No instruction.
#[inline(always)]
pub(crate) fn one_by_one() {
    core::hint::black_box(());
}

/// Number by number. Written out: a step has thousands of these in one function, and the compiler takes minutes to unroll as many loops.
#[inline(always)]
pub(crate) fn by_lane(a: &[f64; LANES], b: &[f64; LANES], f: impl Fn(f64, f64) -> f64) -> [f64; LANES] {
    [
        f(a[0], b[0]),
        f(a[1], b[1]),
        f(a[2], b[2]),
        f(a[3], b[3]),
        f(a[4], b[4]),
        f(a[5], b[5]),
        f(a[6], b[6]),
        f(a[7], b[7]),
    ]
}

macro_rules! operation {
    ($operation:ident, $function:ident, $assign:ident, $assign_function:ident, $op:tt) => {
        impl $operation for Lanes {
            type Output = Lanes;

            #[inline(always)]
            fn $function(self, other: Lanes) -> Lanes {
                let result = Lanes(by_lane(&self.0, &other.0, |a, b| a $op b));
                one_by_one();
                result
            }
        }

        impl $assign for Lanes {
            #[inline(always)]
            fn $assign_function(&mut self, other: Lanes) {
                *self = *self $op other;
            }
        }
    };
}

use core::ops::{DivAssign, MulAssign};
operation!(Add, add, AddAssign, add_assign, +);
operation!(Sub, sub, SubAssign, sub_assign, -);
operation!(Mul, mul, MulAssign, mul_assign, *);
operation!(Div, div, DivAssign, div_assign, /);

impl Neg for Lanes {
    type Output = Lanes;

    #[inline(always)]
    fn neg(self) -> Lanes {
        Lanes(by_lane(&self.0, &self.0, |x, _| -x))
    }
}

impl Real for Lanes {
    const IS_WIDE: bool = true;

    #[inline(always)]
    fn of(x: f64) -> Self {
        Lanes([x; LANES])
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.each(libm::sqrt)
    }

    #[inline(always)]
    fn rotation_scalars(self) -> (Lanes, Lanes, Lanes) {
        let mut out = rotation_series(self);
        for (lane, &x) in self.0.iter().enumerate() {
            // Spelt so that a NaN goes where it goes alone.
            let is_small = x < SERIES;
            if !is_small {
                let (a, b, c) = rotation_closed(x);
                out.0.set(lane, a);
                out.1.set(lane, b);
                out.2.set(lane, c);
            }
        }
        out
    }
}
