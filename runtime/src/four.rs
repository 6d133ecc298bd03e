//! Four numbers side by side, in the vector registers of the machine: rows of numbers in blocks of four, padded with zeros, so that no
//! remainders are left.
//!
//! Kernels are written once for every [`Machine`] and run on the widest that there is ([`run`]). All of them round alike: nothing is fused,
//! and sums over the four are taken in one order.

use alloc::vec::Vec;
use core::ops::{Add, Mul, Sub};

/// Four numbers in memory.
pub(crate) type Four = [f64; 4];

/// Registers of four numbers, and what fills and empties them.
pub(crate) trait Machine: Copy {
    /// Four numbers in registers.
    type Lanes: Copy + Add<Output = Self::Lanes> + Sub<Output = Self::Lanes> + Mul<Output = Self::Lanes>;

    fn load(self, x: &Four) -> Self::Lanes;

    fn splat(self, x: f64) -> Self::Lanes;

    fn store(self, x: Self::Lanes) -> Four;

    #[inline(always)]
    fn zero(self) -> Self::Lanes {
        self.splat(0.0)
    }

    /// Sum of the four.
    #[inline(always)]
    fn sum(self, x: Self::Lanes) -> f64 {
        sum(&self.store(x))
    }

    /// Sums of four times four.
    #[inline(always)]
    fn sums(self, x: [Self::Lanes; 4]) -> Four {
        let [a, b, c, d] = x;
        [self.sum(a), self.sum(b), self.sum(c), self.sum(d)]
    }

    /// Sum of the products of two rows.
    #[inline(always)]
    fn dot(self, a: &[Four], b: &[Four]) -> f64 {
        let mut sums = self.zero();
        for (a, b) in a.iter().zip(b) {
            sums = sums + self.load(a) * self.load(b);
        }
        self.sum(sums)
    }
}

/// Work that any machine can do.
pub(crate) trait Kernel {
    type Output;

    /// To be inlined, with all that it calls.
    fn on<M: Machine>(self, machine: M) -> Self::Output;
}

/// Runs a kernel on the widest registers of the machine, where the standard library can tell which it has.
#[inline(always)]
pub(crate) fn run<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(all(feature = "std", target_arch = "x86_64"))]
    if let Some(machine) = avx::machine() {
        return avx::run(machine, kernel);
    }
    kernel.on(Plain)
}

/// What every target has: pairs of two where there are such, else one by one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain;

impl Machine for Plain {
    type Lanes = wide::f64x4;

    #[inline(always)]
    fn load(self, x: &Four) -> wide::f64x4 {
        wide::f64x4::new(*x)
    }

    #[inline(always)]
    fn splat(self, x: f64) -> wide::f64x4 {
        wide::f64x4::splat(x)
    }

    #[inline(always)]
    fn store(self, x: wide::f64x4) -> Four {
        x.to_array()
    }
}

#[cfg(all(feature = "std", target_arch = "x86_64"))]
mod avx {
    //! Registers of four numbers (x86-64-v3).

    use core::arch::x86_64::__m256d;
    use core::ops::{Add, Mul, Sub};

    use pulp::x86::V3;

    use super::{Four, Kernel, Machine};

    #[inline(always)]
    pub(super) fn machine() -> Option<V3> {
        V3::try_new()
    }

    /// Compiles a kernel for these registers. Not a closure: those are called by way of a function that is not.
    struct Compiled<K>(V3, K);

    impl<K: Kernel> pulp::NullaryFnOnce for Compiled<K> {
        type Output = K::Output;

        #[inline(always)]
        fn call(self) -> K::Output {
            self.1.on(self.0)
        }
    }

    #[inline(always)]
    pub(super) fn run<K: Kernel>(machine: V3, kernel: K) -> K::Output {
        machine.vectorize(Compiled(machine, kernel))
    }

    #[derive(Clone, Copy)]
    pub(crate) struct Lanes(V3, __m256d);

    impl Machine for V3 {
        type Lanes = Lanes;

        #[inline(always)]
        fn load(self, x: &Four) -> Lanes {
            Lanes(self, pulp::cast(*x))
        }

        #[inline(always)]
        fn splat(self, x: f64) -> Lanes {
            Lanes(self, self.avx._mm256_set1_pd(x))
        }

        #[inline(always)]
        fn store(self, x: Lanes) -> Four {
            pulp::cast(x.1)
        }

        #[inline(always)]
        fn sums(self, [a, b, c, d]: [Lanes; 4]) -> Four {
            let avx = self.avx;
            // (a0 + a1, b0 + b1, a2 + a3, b2 + b3), and the same of the others.
            let (ab, cd) = (avx._mm256_hadd_pd(a.1, b.1), avx._mm256_hadd_pd(c.1, d.1));
            let low = avx._mm256_blend_pd::<0b1100>(ab, cd);
            let high = avx._mm256_permute2f128_pd::<0x21>(ab, cd);
            pulp::cast(avx._mm256_add_pd(low, high))
        }
    }

    impl Add for Lanes {
        type Output = Lanes;

        #[inline(always)]
        fn add(self, other: Lanes) -> Lanes {
            Lanes(self.0, self.0.avx._mm256_add_pd(self.1, other.1))
        }
    }

    impl Sub for Lanes {
        type Output = Lanes;

        #[inline(always)]
        fn sub(self, other: Lanes) -> Lanes {
            Lanes(self.0, self.0.avx._mm256_sub_pd(self.1, other.1))
        }
    }

    impl Mul for Lanes {
        type Output = Lanes;

        #[inline(always)]
        fn mul(self, other: Lanes) -> Lanes {
            Lanes(self.0, self.0.avx._mm256_mul_pd(self.1, other.1))
        }
    }
}

/// Whether [`wide`] has registers of four numbers at least, or cannot tell. Narrower ones gain next to nothing side by side, and one more copy
/// of a step for them takes long to compile.
pub(crate) fn is_wide() -> bool {
    #[cfg(all(feature = "std", target_arch = "x86_64"))]
    return pulp::x86::V3::is_available();
    #[cfg(not(all(feature = "std", target_arch = "x86_64")))]
    true
}

/// Calls `work` compiled for the widest vector instructions of the machine, where the standard library can tell which it has; none where
/// they are not [wide](is_wide). They round as the narrow ones do.
///
/// `work` and what it calls must be inlined always. It takes its mutable state as an argument: a closure that captures it is called by
/// way of a function which is not inlined, and is then compiled for the narrowest instructions.
#[inline(always)]
pub(crate) fn wide<A, R>(state: A, work: impl Fn(A) -> R) -> Option<R> {
    #[cfg(all(feature = "std", target_arch = "x86_64"))]
    {
        if let Some(eight_wide) = pulp::x86::V4::try_new() {
            return Some(eight_wide.vectorize(Call(state, work)));
        }
        Some(pulp::x86::V3::try_new()?.vectorize(Call(state, work)))
    }
    #[cfg(not(all(feature = "std", target_arch = "x86_64")))]
    Some(work(state))
}

/// The vector instructions that a single step is compiled for besides those that every machine has: four numbers wide. Eight at once
/// gain nothing where rows are as short as a step has them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vectors {
    #[cfg(all(feature = "std", target_arch = "x86_64"))]
    four_wide: Option<pulp::x86::V3>,
}

impl Vectors {
    /// Those of the machine.
    pub(crate) fn of_machine() -> Self {
        Vectors {
            #[cfg(all(feature = "std", target_arch = "x86_64"))]
            four_wide: pulp::x86::V3::try_new(),
        }
    }

    /// Calls `work` compiled for them; as with [`wide`], it and what it calls must be inlined always, and it must not capture.
    #[inline(always)]
    pub(crate) fn run<A, R>(self, state: A, work: impl Fn(A) -> R) -> R {
        #[cfg(all(feature = "std", target_arch = "x86_64"))]
        if let Some(four_wide) = self.four_wide {
            return four_wide.vectorize(Call(state, work));
        }
        work(state)
    }
}

#[cfg(all(feature = "std", target_arch = "x86_64"))]
struct Call<A, F>(A, F);

#[cfg(all(feature = "std", target_arch = "x86_64"))]
impl<A, R, F: Fn(A) -> R> pulp::NullaryFnOnce for Call<A, F> {
    type Output = R;

    #[inline(always)]
    fn call(self) -> R {
        (self.1)(self.0)
    }
}

/// `a + s x`. By value: the compiler need not ask whether the operands overlap.
#[inline(always)]
pub(crate) fn plus(a: Four, s: f64, x: Four) -> Four {
    [a[0] + s * x[0], a[1] + s * x[1], a[2] + s * x[2], a[3] + s * x[3]]
}

/// `a - x`.
#[inline(always)]
pub(crate) fn minus(a: Four, x: Four) -> Four {
    [a[0] - x[0], a[1] - x[1], a[2] - x[2], a[3] - x[3]]
}

/// `x y`, number by number.
#[inline(always)]
pub(crate) fn times(x: Four, y: Four) -> Four {
    [x[0] * y[0], x[1] * y[1], x[2] * y[2], x[3] * y[3]]
}

/// `to + s x`, block by block.
#[inline(always)]
pub(crate) fn add_scaled(to: &mut [Four], s: f64, x: &[Four]) {
    for (to, x) in to.iter_mut().zip(x) {
        *to = plus(*to, s, *x);
    }
}

/// Sum of the products of a padded row and numbers.
#[inline(always)]
pub(crate) fn dot_numbers(a: &[Four], b: &[f64]) -> f64 {
    let (fours, rest) = b.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(fours) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    let rest = a.get(fours.len()).map_or(0.0, |a| a.iter().zip(rest).map(|(a, b)| a * b).sum());
    sum(&sums) + rest
}

/// Sum of the four.
#[inline(always)]
pub(crate) fn sum(x: &Four) -> f64 {
    (x[0] + x[1]) + (x[2] + x[3])
}

/// Copies numbers into a padded row.
#[inline(always)]
pub(crate) fn fill(to: &mut [Four], from: &[f64]) {
    for (to, from) in to.as_flattened_mut().iter_mut().zip(from) {
        *to = *from;
    }
}

/// A matrix by rows, every row padded.
pub(crate) fn padded(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> Vec<Four> {
    let blocks = columns.div_ceil(4);
    let at = |row: usize, column: usize| if column < columns { entry(row, column) } else { 0.0 };
    (0..rows * blocks).map(|n| core::array::from_fn(|lane| at(n / blocks, 4 * (n % blocks) + lane))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    #[test]
    fn rows_are_padded_with_zeros() {
        let a = padded(2, 5, |i, j| (10 * i + j) as f64);
        assert_eq!(
            a,
            [[0.0, 1.0, 2.0, 3.0], [4.0, 0.0, 0.0, 0.0], [10.0, 11.0, 12.0, 13.0], [14.0, 0.0, 0.0, 0.0]]
        );
        let mut x = vec![[0.0; 4]; 2];
        fill(&mut x, &[1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(Plain.dot(&a[2..], &x), 10.0 + 22.0 + 36.0 + 52.0 + 70.0);
        assert_eq!(dot_numbers(&a[2..], &[1.0, 2.0, 3.0, 4.0, 5.0]), 190.0);
        assert!(padded(3, 0, |_, _| 1.0).is_empty());
    }

    /// All that a machine can do, to the bit.
    struct All<'a>(&'a [Four; 4]);

    impl Kernel for All<'_> {
        type Output = Vec<Four>;

        #[inline(always)]
        fn on<M: Machine>(self, m: M) -> Vec<Four> {
            let [a, b, c, d] =
                [m.load(&self.0[0]), m.load(&self.0[1]), m.load(&self.0[2]), m.load(&self.0[3])];
            let sums = m.sums([a, b, c, d]);
            let one_by_one = [m.sum(a), m.sum(b), m.sum(c), m.sum(d)];
            let dot = [m.dot(self.0, self.0); 4];
            vec![m.store(a + b * c), m.store(a - m.splat(0.3) * d), m.store(m.zero()), sums, one_by_one, dot]
        }
    }

    #[test]
    fn all_machines_round_alike() {
        let number = |k: usize| libm::sin(1.0 + 7.0 * k as f64) * libm::pow(10.0, (k % 5) as f64 - 2.0);
        let x: [Four; 4] = core::array::from_fn(|i| core::array::from_fn(|j| number(4 * i + j)));
        let (plain, widest) = (All(&x).on(Plain), run(All(&x)));
        assert_eq!(plain, widest);
        let [a, b, c, d] = x;
        let expected: Four = core::array::from_fn(|k| a[k] + b[k] * c[k]);
        assert_eq!(plain[0], expected);
        let expected: Four = core::array::from_fn(|k| a[k] - 0.3 * d[k]);
        assert_eq!(plain[1], expected);
        assert_eq!(plain[3], x.map(|x| sum(&x)));
        assert_eq!(plain[4], plain[3]);
    }
}
