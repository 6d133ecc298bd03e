//! Vectors and matrices of four fields side by side.

use crate::four::{Four, Machine};
use crate::math::{Mat3, Vec3};

/// A vector of each of four fields.
pub(super) type Vectors = [Four; 3];
/// A symmetric matrix of each: xx, yy, zz and xy, xz, yz.
pub(super) type Symmetric = [Four; 6];

/// The same in registers.
type V<M> = [<M as Machine>::Lanes; 3];
pub(super) type P<M> = [<M as Machine>::Lanes; 9];

#[inline(always)]
pub(super) fn load<M: Machine>(m: M, x: &Vectors) -> V<M> {
    let [a, b, c] = x;
    [m.load(a), m.load(b), m.load(c)]
}

#[inline(always)]
pub(super) fn splat<M: Machine>(m: M, [a, b, c]: Vec3) -> V<M> {
    [m.splat(a), m.splat(b), m.splat(c)]
}

#[inline(always)]
pub(super) fn zero<M: Machine>(m: M) -> V<M> {
    [m.zero(); 3]
}

/// `a . x`.
#[inline(always)]
pub(super) fn dot<M: Machine>([a, b, c]: V<M>, [x, y, z]: V<M>) -> M::Lanes {
    a * x + b * y + c * z
}

/// `P a`.
#[inline(always)]
pub(super) fn product<M: Machine>(p: &P<M>, a: V<M>) -> V<M> {
    let [xx, xy, xz, yx, yy, yz, zx, zy, zz] = *p;
    [dot::<M>(a, [xx, xy, xz]), dot::<M>(a, [yx, yy, yz]), dot::<M>(a, [zx, zy, zz])]
}

/// `int X x F` from `P = int F X^t`.
#[inline(always)]
pub(super) fn turned<M: Machine>(p: &P<M>) -> V<M> {
    let [_, xy, xz, yx, _, yz, zx, zy, _] = *p;
    [zy - yz, xz - zx, yx - xy]
}

#[inline(always)]
pub(super) fn trace<M: Machine>(p: &P<M>) -> M::Lanes {
    let [xx, _, _, _, yy, _, _, _, zz] = *p;
    xx + (yy + zz)
}

/// `sum + s x`, number by number.
#[inline(always)]
pub(super) fn plus<M: Machine>([a, b, c]: V<M>, s: M::Lanes, [x, y, z]: V<M>) -> V<M> {
    [a + s * x, b + s * y, c + s * z]
}

/// Sums over the lanes.
#[inline(always)]
pub(super) fn sums<M: Machine>(m: M, [x, y, z]: V<M>) -> Vec3 {
    let [x, y, z, _] = m.sums([x, y, z, z]);
    [x, y, z]
}

/// Matrices of four fields from memory, by rows.
#[inline(always)]
pub(super) fn matrices<M: Machine>(m: M, p: &[Four; 9]) -> P<M> {
    // One by one: a closure that arrays are mapped with is not inlined.
    let [xx, xy, xz, yx, yy, yz, zx, zy, zz] = p;
    [
        m.load(xx),
        m.load(xy),
        m.load(xz),
        m.load(yx),
        m.load(yy),
        m.load(yz),
        m.load(zx),
        m.load(zy),
        m.load(zz),
    ]
}

/// Sums of `int X X^t - J_0 = y_a (P_a0^t + P_a)`, which is symmetric: xx, yy, zz and twice xy, xz, yz.
pub(super) struct SecondMoment<M: Machine> {
    diagonal: V<M>,
    mixed: V<M>,
}

impl<M: Machine> SecondMoment<M> {
    #[inline(always)]
    pub(super) fn zero(m: M) -> Self {
        SecondMoment { diagonal: zero(m), mixed: zero(m) }
    }

    /// `p_0` is `P_a0 + P_a0^t`, of its diagonal one half.
    #[inline(always)]
    pub(super) fn add(&mut self, m: M, y: M::Lanes, p: &P<M>, p_0: &Symmetric) {
        let [xx, xy, xz, yx, yy, yz, zx, zy, zz] = *p;
        let [xx_0, yy_0, zz_0, xy_0, xz_0, yz_0] = p_0;
        let diagonal = [xx + m.load(xx_0), yy + m.load(yy_0), zz + m.load(zz_0)];
        let mixed = [(xy + yx) + m.load(xy_0), (xz + zx) + m.load(xz_0), (yz + zy) + m.load(yz_0)];
        self.diagonal = plus::<M>(self.diagonal, y, diagonal);
        self.mixed = plus::<M>(self.mixed, y, mixed);
    }

    #[inline(always)]
    pub(super) fn add_to(&self, m: M, to: &mut Mat3) {
        let ([x, y, z], mixed) = (sums(m, self.diagonal), sums(m, self.mixed));
        let [xy, xz, yz] = mixed.map(|twice| 0.5 * twice);
        let added = [x, xy, xz, xy, y, yz, xz, yz, z];
        to.as_flattened_mut().iter_mut().zip(added).for_each(|(to, from)| *to += from);
    }
}
