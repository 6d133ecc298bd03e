//! The moments `P_a = P_a0 + P_ab y_b` of (B.3) and the rate of `N_a = int X x F_a`, of four fields a side by side.

use super::arrangement::Arrangement;
use super::lanes::P;
use crate::data::LagrangianData;
use crate::four::{Four, Machine};
use crate::sparse::{Sparse, Terms};

/// The moments as sparse matrices times `(y, 1)` and `y_dot`.
#[derive(Clone, Debug, Default)]
pub(super) struct Moments {
    /// `P_a`, component by component - (blocks x 9).
    moment: Sparse,
    /// The rate of `N_a` - (blocks x 3).
    turning: Sparse,
    n_entries: usize,
}

/// Components `3 row + column` of `P` that make those of `N`, the second with a minus.
const TURNED: [[usize; 2]; 3] = [[7, 5], [2, 6], [3, 1]];
/// Entries of `P_a0` below this times the largest are round-off of what symmetry makes zero.
const ROUND_OFF: f64 = 1e-12;

impl Moments {
    pub(super) fn new(arrangement: &Arrangement, data: &LagrangianData) -> Self {
        let (mut moment, mut turning) = (Terms::default(), Terms::default());
        let entries = data.moment.i.iter().zip(&data.moment.l).zip(&data.moment.r).zip(&data.moment.value);
        for (((a, b), component), value) in entries {
            let (a, b, component) = (arrangement.place(*a), arrangement.place(*b), *component as usize);
            moment.add(a / 4 * 9 + component, a % 4, b, *value);
            for (k, [plus, minus]) in TURNED.into_iter().enumerate() {
                if component == plus {
                    turning.add(a / 4 * 3 + k, a % 4, b, *value);
                } else if component == minus {
                    turning.add(a / 4 * 3 + k, a % 4, b, -*value);
                }
            }
        }
        let one = 4 * arrangement.blocks();
        let largest = data.moment_0.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        for (at, value) in data.moment_0.iter().enumerate().filter(|(_, it)| it.abs() > ROUND_OFF * largest) {
            let a = arrangement.place((at / 9) as u32);
            moment.add(a / 4 * 9 + at % 9, a % 4, one, *value);
        }
        Moments {
            moment: Sparse::new(moment),
            turning: Sparse::new(turning),
            n_entries: data.moment.value.len(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.n_entries
    }

    /// `P_a` - (blocks x 9) - and the rate of `N_a` - (blocks x 3) -, by `(y, 1)` and `y_dot`.
    #[inline(always)]
    pub(super) fn evaluate<M: Machine>(
        &self,
        m: M,
        y: &[Four],
        y_dot: &[Four],
        moment: &mut [Four],
        turning: &mut [Four],
    ) {
        self.moment.apply(m, y, moment);
        self.turning.apply(m, y_dot, turning);
    }

    /// `weight_a P_a` of two sets of weights, by `(y, 1)`: without scratch, for outputs.
    pub(super) fn weighted<M: Machine>(&self, m: M, y: &[Four], weights: [&[Four]; 2]) -> [P<M>; 2] {
        let mut sums = [[m.zero(); 9]; 2];
        self.moment.for_each(m, [y], |target, _, [moment]| {
            for (sums, weights) in sums.iter_mut().zip(weights) {
                if let (Some(sum), Some(weight)) = (sums.get_mut(target % 9), weights.get(target / 9)) {
                    *sum = *sum + m.load(weight) * moment;
                }
            }
        });
        sums
    }
}
