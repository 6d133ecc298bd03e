//! The moments `P_ab = int F_a F_b^t` of (B.3), laid out for `P_a = P_a0 + P_ab y_b` and its rate.
//!
//! In a structure with planes of symmetry two fields have either moments on the diagonal or those of one pair of axes. The entries of a
//! field are kept by these four kinds.

use alloc::vec::Vec;

use crate::data::TensorData;
use crate::four::{self, Four};
use crate::math::Vec3;

/// Rows of the moments.
#[derive(Clone, Debug, Default)]
pub(super) struct Moments {
    /// Field b and (xx, yy, zz, 0).
    diagonal: Vec<(u32, Four)>,
    /// Field b and (ij, ji, ij, ji) of one pair of axes.
    mixed: Vec<(u32, Four)>,
    rows: Vec<Row>,
    n_entries: usize,
}

/// Where the entries of a field are: first and one after the last.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Row {
    diagonal: (usize, usize),
    /// xy, xz, yz.
    mixed: [(usize, usize); 3],
}

/// What the moments add to `P_a0`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moment {
    /// xx, yy, zz.
    pub(super) diagonal: Vec3,
    /// ij, ji and their rates, of xy, xz, yz.
    pub(super) mixed: [Four; 3],
}

/// Components `3 row + column` of the pairs xy, xz, yz.
const PAIRS: [(u32, u32); 3] = [(1, 3), (2, 6), (5, 7)];

impl Moments {
    pub(super) fn new(n: usize, data: &TensorData) -> Self {
        let mut moments = Moments { n_entries: data.value.len(), ..Moments::default() };
        let mut first = 0;
        for a in 0..n {
            let end = data.i.partition_point(|&i| i as usize <= a);
            let entries: Vec<(u32, u32, f64)> = (first..end)
                .filter_map(|at| Some((*data.l.get(at)?, *data.r.get(at)?, *data.value.get(at)?)))
                .collect();
            let value = |b: u32, component: u32| {
                entries.iter().find(|it| it.0 == b && it.1 == component).map_or(0.0, |it| it.2)
            };
            let fields = |kind: &[u32]| {
                let mut fields: Vec<u32> =
                    entries.iter().filter(|it| kind.contains(&it.1)).map(|it| it.0).collect();
                fields.dedup();
                fields
            };
            let start = moments.diagonal.len();
            for b in fields(&[0, 4, 8]) {
                moments.diagonal.push((b, [value(b, 0), value(b, 4), value(b, 8), 0.0]));
            }
            let mixed = PAIRS.map(|(ij, ji)| {
                let start = moments.mixed.len();
                for b in fields(&[ij, ji]) {
                    let (x, y) = (value(b, ij), value(b, ji));
                    moments.mixed.push((b, [x, y, x, y]));
                }
                (start, moments.mixed.len())
            });
            moments.rows.push(Row { diagonal: (start, moments.diagonal.len()), mixed });
            first = end;
        }
        moments
    }

    pub(super) fn len(&self) -> usize {
        self.n_entries
    }

    /// One for each field.
    pub(super) fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// `P_ab y_b` of a field; `y` gives `(y, y, y_dot, y_dot)` of field b.
    #[inline(always)]
    pub(super) fn moment(&self, row: &Row, y: impl Fn(u32) -> Four) -> Moment {
        let mut moment = Moment::default();
        let mut sums = [0.0; 4];
        for (b, value) in self.diagonal.get(row.diagonal.0..row.diagonal.1).unwrap_or(&[]) {
            sums = four::plus(sums, y(*b)[0], *value);
        }
        moment.diagonal = [sums[0], sums[1], sums[2]];
        for (to, (start, end)) in moment.mixed.iter_mut().zip(row.mixed) {
            let mut sums = [0.0; 4];
            for (b, value) in self.mixed.get(start..end).unwrap_or(&[]) {
                sums = four::plus_product(sums, *value, y(*b));
            }
            *to = sums;
        }
        moment
    }
}

impl Moment {
    /// `P_a`, by rows.
    #[inline(always)]
    pub(super) fn matrix(&self, moment_0: &[f64; 9]) -> [f64; 9] {
        let ([x, y, z], [xy, xz, yz]) = (self.diagonal, self.mixed);
        let added = [x, xy[0], xz[0], xy[1], y, yz[0], xz[1], yz[1], z];
        let mut p = *moment_0;
        p.iter_mut().zip(added).for_each(|(p, added)| *p += added);
        p
    }

    /// Rate of `N_a = int X x F_a`.
    #[inline(always)]
    pub(super) fn turned_rate(&self) -> Vec3 {
        let [xy, xz, yz] = self.mixed;
        [yz[3] - yz[2], xz[2] - xz[3], xy[3] - xy[2]]
    }
}
