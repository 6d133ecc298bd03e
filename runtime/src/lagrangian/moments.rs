//! The moments `P_ab = int F_a F_b^t` of (B.3), laid out for `P_a = P_a0 + P_ab y_b` and its rate, of four fields a side by side.
//!
//! In a structure with planes of symmetry two fields have either moments on the diagonal or those of one pair of axes. The entries of a
//! block of fields are kept by these four kinds.

use alloc::{collections::BTreeMap, vec::Vec};

use super::arrangement::Arrangement;
use super::lanes::{self, Matrices, P, Vectors};
use crate::data::TensorData;
use crate::four::Machine;

/// Rows of the moments.
#[derive(Clone, Debug, Default)]
pub(super) struct Moments {
    /// Place of field b and xx, yy, zz of four fields.
    diagonal: Vec<(u32, Vectors)>,
    /// Place of field b and ij, ji, ji - ij of four fields and one pair of axes.
    mixed: Vec<(u32, Vectors)>,
    rows: Vec<Row>,
    n_entries: usize,
}

/// Where the entries of a block of fields are: first and one after the last.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Row {
    diagonal: (usize, usize),
    /// xy, xz, yz.
    mixed: [(usize, usize); 3],
}

/// What the moments add to `P_a0` of four fields, in registers.
#[derive(Clone, Copy)]
pub(super) struct Moment<M: Machine> {
    /// xx, yy, zz.
    diagonal: [M::Lanes; 3],
    /// ij, ji and the rate of ji - ij, of xy, xz, yz.
    mixed: [[M::Lanes; 3]; 3],
}

/// Components `3 row + column` of the pairs xy, xz, yz.
const PAIRS: [[u32; 2]; 3] = [[1, 3], [2, 6], [5, 7]];

impl Moments {
    pub(super) fn new(arrangement: &Arrangement, data: &TensorData) -> Self {
        let mut moments = Moments { n_entries: data.value.len(), ..Moments::default() };
        // (block, kind, place of b): components of the four fields.
        let mut found: BTreeMap<(usize, usize, u32), Vectors> = BTreeMap::new();
        for (((a, b), component), value) in data.i.iter().zip(&data.l).zip(&data.r).zip(&data.value) {
            let (place, b) = (arrangement.place(*a), arrangement.place(*b) as u32);
            let (kind, at) = kind(*component);
            let lanes = found.entry((place / 4, kind, b)).or_default().get_mut(at);
            if let Some(to) = lanes.and_then(|lanes| lanes.get_mut(place % 4)) {
                *to = *value;
            }
        }
        let mut found = found.into_iter().peekable();
        for block in 0..arrangement.blocks() {
            let mut of_kind = |wanted: usize, list: &mut Vec<(u32, Vectors)>| {
                let start = list.len();
                while let Some(((_, kind, b), lanes)) =
                    found.next_if(|((at, kind, _), _)| (*at, *kind) == (block, wanted))
                {
                    let [ij, ji, _] = lanes;
                    let turned = core::array::from_fn(|lane| at(&ji, lane) - at(&ij, lane));
                    list.push((b, if kind == 0 { lanes } else { [ij, ji, turned] }));
                }
                (start, list.len())
            };
            let diagonal = of_kind(0, &mut moments.diagonal);
            let mixed = [1, 2, 3].map(|kind| of_kind(kind, &mut moments.mixed));
            moments.rows.push(Row { diagonal, mixed });
        }
        moments
    }

    pub(super) fn len(&self) -> usize {
        self.n_entries
    }

    /// One for each block of fields.
    pub(super) fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// `P_ab y_b` of four fields, by the coordinates and their rates at all places.
    #[inline(always)]
    pub(super) fn moment<M: Machine>(&self, m: M, row: &Row, y: &[f64], y_dot: &[f64]) -> Moment<M> {
        let mut diagonal = lanes::zero(m);
        for (b, values) in self.diagonal.get(row.diagonal.0..row.diagonal.1).unwrap_or(&[]) {
            if let Some(&y) = y.get(*b as usize) {
                diagonal = lanes::plus::<M>(diagonal, m.splat(y), lanes::load(m, values));
            }
        }
        let mut mixed = [lanes::zero(m); 3];
        for (to, (start, end)) in mixed.iter_mut().zip(row.mixed) {
            let [mut first, mut second, mut third] = lanes::zero(m);
            for (b, [ij, ji, turned]) in self.mixed.get(start..end).unwrap_or(&[]) {
                if let (Some(&y), Some(&rate)) = (y.get(*b as usize), y_dot.get(*b as usize)) {
                    let (y, rate) = (m.splat(y), m.splat(rate));
                    first = first + y * m.load(ij);
                    second = second + y * m.load(ji);
                    third = third + rate * m.load(turned);
                }
            }
            *to = [first, second, third];
        }
        Moment { diagonal, mixed }
    }
}

fn at(four: &[f64; 4], lane: usize) -> f64 {
    four.get(lane).copied().unwrap_or(0.0)
}

/// Which of the four kinds a component is of, and which of its kind.
fn kind(component: u32) -> (usize, usize) {
    let pair = PAIRS.iter().enumerate().find_map(|(kind, pair)| {
        let at = pair.iter().position(|it| *it == component)?;
        Some((kind + 1, at))
    });
    pair.unwrap_or((0, component as usize / 4))
}

impl<M: Machine> Moment<M> {
    /// `P_a`.
    #[inline(always)]
    pub(super) fn matrices(&self, m: M, moment_0: &Matrices) -> P<M> {
        let ([x, y, z], [[xy, yx, _], [xz, zx, _], [yz, zy, _]]) = (self.diagonal, self.mixed);
        let [xx_0, xy_0, xz_0, yx_0, yy_0, yz_0, zx_0, zy_0, zz_0] = moment_0;
        [
            m.load(xx_0) + x,
            m.load(xy_0) + xy,
            m.load(xz_0) + xz,
            m.load(yx_0) + yx,
            m.load(yy_0) + y,
            m.load(yz_0) + yz,
            m.load(zx_0) + zx,
            m.load(zy_0) + zy,
            m.load(zz_0) + z,
        ]
    }

    /// `a` times the rate of `N_a = int X x F_a`.
    #[inline(always)]
    pub(super) fn turned_rate(&self, [a, b, c]: [M::Lanes; 3]) -> M::Lanes {
        let [[_, _, xy], [_, _, xz], [_, _, yz]] = self.mixed;
        (a * yz - b * xz) + c * xy
    }
}
