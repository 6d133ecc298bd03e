//! Rows of numbers in blocks of four, padded with zeros: what the compiler turns into vector instructions without remainders.

use alloc::vec::Vec;

/// Four numbers side by side.
pub(crate) type Four = [f64; 4];

/// Calls `work` compiled for the widest vector instructions of the machine, where the standard library can tell which it has. They
/// round as the narrow ones do.
///
/// `work` and what it calls must be inlined always. It takes its mutable state as an argument: a closure that captures it is called by
/// way of a function which is not inlined, and is then compiled for the narrowest instructions.
#[inline(always)]
pub(crate) fn wide<A, R>(state: A, work: impl Fn(A) -> R) -> R {
    #[cfg(feature = "std")]
    return pulp::Arch::new().dispatch(Wide(state, work));
    #[cfg(not(feature = "std"))]
    work(state)
}

#[cfg(feature = "std")]
struct Wide<A, F>(A, F);

#[cfg(feature = "std")]
impl<A, R, F: Fn(A) -> R> pulp::WithSimd for Wide<A, F> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> R {
        (self.1)(self.0)
    }
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

/// `a + x y`, number by number.
#[inline(always)]
pub(crate) fn plus_product(a: Four, x: Four, y: Four) -> Four {
    [a[0] + x[0] * y[0], a[1] + x[1] * y[1], a[2] + x[2] * y[2], a[3] + x[3] * y[3]]
}

/// `to + s x`, block by block.
#[inline(always)]
pub(crate) fn add_scaled(to: &mut [Four], s: f64, x: &[Four]) {
    for (to, x) in to.iter_mut().zip(x) {
        *to = plus(*to, s, *x);
    }
}

/// Sum of the products of two rows.
#[inline(always)]
pub(crate) fn dot(a: &[Four], b: &[Four]) -> f64 {
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        sums = plus_product(sums, *a, *b);
    }
    sum(&sums)
}

/// Sum of the products of a padded row and numbers.
#[inline(always)]
pub(crate) fn dot_numbers(a: &[Four], b: &[f64]) -> f64 {
    let (fours, rest) = b.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(fours) {
        sums = plus_product(sums, *a, *b);
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
        assert_eq!(dot(&a[2..], &x), 10.0 + 22.0 + 36.0 + 52.0 + 70.0);
        add_scaled(&mut x, 2.0, &a[..2]);
        assert_eq!(x, [[1.0, 4.0, 7.0, 10.0], [13.0, 0.0, 0.0, 0.0]]);
        assert!(padded(3, 0, |_, _| 1.0).is_empty());
    }
}
