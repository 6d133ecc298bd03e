//! The mass matrix of (B.7), and its solution by elimination: rigid rows first, so that their block can be had alone.
//!
//! A block of four rows holds those of `v`, one those of `w`, as many as it takes those of `q`.

use super::system::{System, Tile};
use super::{Lagrangian, Scratch, traced};
use crate::dense::rows;
use crate::four::{self, Four};
use crate::math::{Vec6, split};

/// Blocks before those of `q`.
pub(super) const RIGID: usize = 2;

impl Lagrangian {
    /// Accelerations `(q_ddot, beta_dot)` under forces on the relative elastic and the rigid rows, with the rows `gains` (or none) on the
    /// elastic block of the mass matrix: what an implicit step gains by damping and stiffness.
    #[inline]
    pub(crate) fn solve(
        &self,
        at: &mut Scratch,
        elastic: &[f64],
        rigid: &Vec6,
        gains: &[Four],
        q_ddot: &mut [f64],
    ) -> Vec6 {
        four::wide(
            (at, q_ddot),
            #[inline(always)]
            |(at, q_ddot)| {
                self.assemble(at, gains);
                at.system.factorise(0);
                at.solve_factorised(elastic, rigid, q_ddot)
            },
        )
    }

    /// Accelerations of the modes where the host gives `beta_dot`.
    #[inline]
    pub(crate) fn solve_held(
        &self,
        at: &mut Scratch,
        elastic: &[f64],
        beta_dot: &Vec6,
        gains: &[Four],
        q_ddot: &mut [f64],
    ) {
        // The coupling of the elastic rows with the rigid motion goes to the right.
        for (to, from) in q_ddot.iter_mut().zip(elastic) {
            *to = *from;
        }
        for (row, rate) in rows(&at.coupling, at.elastic.len().max(1)).zip(beta_dot) {
            for (to, coupling) in q_ddot.iter_mut().zip(row.as_flattened()) {
                *to -= coupling * rate;
            }
        }
        four::wide(
            (at, q_ddot),
            #[inline(always)]
            |(at, q_ddot)| {
                self.assemble(at, gains);
                at.system.factorise(RIGID);
                let Some(x) = at.solution.get_mut(RIGID..) else { return };
                four::fill(x, q_ddot);
                at.system.substitute(RIGID, x);
                for (to, from) in q_ddot.iter_mut().zip(x.as_flattened()) {
                    *to = *from;
                }
            },
        );
    }

    /// `M_Rq q_ddot + M_RR beta_dot + h_R`: what the rigid rows ask of the loads.
    pub(crate) fn rigid_rows(&self, at: &Scratch, q_ddot: &[f64], beta_dot: &Vec6) -> Vec6 {
        let mut out = at.rigid;
        for (out, coupled) in out.iter_mut().zip(at.coupled(q_ddot)) {
            *out += coupled;
        }
        for (out, row) in out.iter_mut().zip(self.rigid_block(at)) {
            *out += row.iter().zip(beta_dot).map(|(a, x)| a * x).sum::<f64>();
        }
        out
    }

    /// Adds `M_qq q_ddot + M_qR beta_dot`, the inertia of the accelerations on the relative elastic rows.
    pub(crate) fn add_elastic_rows(
        &self,
        at: &Scratch,
        q_ddot: &[f64],
        beta_dot: &Vec6,
        elastic: &mut [f64],
    ) {
        for d in rows(&at.path.d, at.elastic.len()) {
            crate::math::add_scaled(elastic, four::dot_numbers(d, q_ddot), d.as_flattened());
        }
        at.add_coupled(beta_dot, elastic);
    }

    /// The upper triangle of the mass matrix.
    #[inline(always)]
    fn assemble(&self, at: &mut Scratch, gains: &[Four]) {
        let [vx, vy, vz, wx, wy, wz] = self.rigid_block(at);
        let first = |row: Vec6| [row[0], row[1], row[2], 0.0];
        let last = |row: Vec6| [row[3], row[4], row[5], 0.0];
        let unit = [0.0, 0.0, 0.0, 1.0];
        at.system.set(0, 0, [first(vx), first(vy), first(vz), unit]);
        at.system.set(0, 1, [last(vx), last(vy), last(vz), [0.0; 4]]);
        at.system.set(1, 1, [last(wx), last(wy), last(wz), unit]);
        let blocks = at.elastic.len();
        for column in 0..blocks {
            let coupling = |row: usize| at.coupling.get(row * blocks + column).copied().unwrap_or_default();
            let rows = [0, 1, 2, 3, 4, 5].map(coupling);
            at.system.set(0, RIGID + column, [rows[0], rows[1], rows[2], [0.0; 4]]);
            at.system.set(1, RIGID + column, [rows[3], rows[4], rows[5], [0.0; 4]]);
            for row in 0..=column {
                let tile = added(squares(&at.path.d, blocks, row, column), gains, blocks, row, column);
                at.system.set(RIGID + row, RIGID + column, tile);
            }
        }
        at.close_diagonal(self.modes);
    }

    /// `M_RR` at the deformed shape.
    #[inline(always)]
    fn rigid_block(&self, at: &Scratch) -> [Vec6; 6] {
        let (i, mass, [x, y, z]) = (traced(&at.second_moment, 1.0), self.mass, at.first_moment);
        [
            [mass, 0.0, 0.0, 0.0, z, -y],
            [0.0, mass, 0.0, -z, 0.0, x],
            [0.0, 0.0, mass, y, -x, 0.0],
            [0.0, -z, y, i[0][0], i[0][1], i[0][2]],
            [z, 0.0, -x, i[1][0], i[1][1], i[1][2]],
            [-y, x, 0.0, i[2][0], i[2][1], i[2][2]],
        ]
    }
}

/// A tile of `D^t D`.
#[inline(always)]
fn squares(d: &[Four], blocks: usize, row: usize, column: usize) -> Tile {
    let [mut a, mut b, mut c, mut e] = [[0.0; 4]; 4];
    for d in rows(d, blocks) {
        if let (Some(left), Some(&right)) = (d.get(row), d.get(column)) {
            (a, b) = (four::plus(a, left[0], right), four::plus(b, left[1], right));
            (c, e) = (four::plus(c, left[2], right), four::plus(e, left[3], right));
        }
    }
    [a, b, c, e]
}

/// The tile with the gains on it.
#[inline(always)]
fn added(mut tile: Tile, gains: &[Four], blocks: usize, row: usize, column: usize) -> Tile {
    for (k, line) in tile.iter_mut().enumerate() {
        if let Some(gain) = gains.get((4 * row + k) * blocks + column) {
            *line = four::plus(*line, 1.0, *gain);
        }
    }
    tile
}

impl Scratch {
    /// Accelerations by the factors of [`Lagrangian::solve`].
    #[inline(always)]
    fn solve_factorised(&mut self, elastic: &[f64], rigid: &Vec6, q_ddot: &mut [f64]) -> Vec6 {
        let (v, w) = split(rigid);
        if let Some((heads, x)) = self.solution.split_first_chunk_mut::<RIGID>() {
            *heads = [[v[0], v[1], v[2], 0.0], [w[0], w[1], w[2], 0.0]];
            four::fill(x, elastic);
            if let Some(last) = x.as_flattened_mut().get_mut(elastic.len()..) {
                last.fill(0.0);
            }
        }
        self.system.substitute(0, &mut self.solution);
        let Some((&[v, w], x)) = self.solution.split_first_chunk::<RIGID>() else { return [0.0; 6] };
        for (to, from) in q_ddot.iter_mut().zip(x.as_flattened()) {
            *to = *from;
        }
        [v[0], v[1], v[2], w[0], w[1], w[2]]
    }

    /// `beta` for a momentum, with the rates of the amplitudes given: `M_RR^-1 (momentum - M_Rq q_dot)`. After
    /// [`Lagrangian::solve`], whose first factors are those of `M_RR`.
    #[inline]
    pub(crate) fn velocity(&self, momentum: &Vec6, q_dot: &[f64]) -> Vec6 {
        let (v, w) = split(&crate::math::sub_6(momentum, &self.coupled(q_dot)));
        let mut x = [[v[0], v[1], v[2], 0.0], [w[0], w[1], w[2], 0.0]];
        self.system.substitute(0, &mut x);
        let [v, w] = x;
        [v[0], v[1], v[2], w[0], w[1], w[2]]
    }

    /// `M_Rq q_dot`.
    #[inline]
    fn coupled(&self, q_dot: &[f64]) -> Vec6 {
        let mut out = [0.0; 6];
        for (out, row) in out.iter_mut().zip(rows(&self.coupling, self.elastic.len().max(1))) {
            *out = four::dot_numbers(row, q_dot);
        }
        out
    }

    /// Ones on the diagonal where the last block has more rows than there are modes.
    #[inline(always)]
    fn close_diagonal(&mut self, modes: usize) {
        let last = RIGID + self.elastic.len() - 1;
        if !modes.is_multiple_of(4) {
            self.system.add_to_diagonal(last, modes % 4);
        }
    }
}

/// The system of a model with so many modes.
pub(super) fn system(modes: usize) -> System {
    System::new(RIGID + modes.div_ceil(4))
}
