//! The mass matrix of (B.7), and its solution by elimination: rigid rows first, so that their block can be had alone.
//!
//! A block of four rows holds those of `v`, one those of `w`, as many as it takes those of `q`.

use super::system::{System, Tile};
use super::{Lagrangian, Scratch, traced};
use crate::dense::rows;
use crate::four::{self, Four, Kernel, Machine};
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
        let job = Job::Solve { elastic, rigid, q_ddot };
        four::run(Solve { lagrangian: self, at, gains, job }).unwrap_or_default()
    }

    /// Factors of the mass matrix, with the rows `gains` on its elastic block, at the state of [`Self::inertia`]; these are for
    /// [`Self::correct`].
    #[inline]
    pub(crate) fn factorise(&self, at: &mut Scratch, gains: &[Four]) {
        four::run(Solve { lagrangian: self, at, gains, job: Job::Factorise });
    }

    /// Accelerations under forces by the factors made last.
    #[inline]
    pub(crate) fn correct(
        &self,
        at: &mut Scratch,
        elastic: &[f64],
        rigid: &Vec6,
        q_ddot: &mut [f64],
    ) -> Vec6 {
        let job = Job::Correct { elastic, rigid, q_ddot };
        four::run(Solve { lagrangian: self, at, gains: &[], job }).unwrap_or_default()
    }

    /// As [`Self::factorise`], of the elastic block alone.
    #[inline]
    pub(crate) fn factorise_held(&self, at: &mut Scratch, gains: &[Four]) {
        four::run(Solve { lagrangian: self, at, gains, job: Job::FactoriseHeld });
    }

    /// Forces on the modes become accelerations, by the factors of [`Self::factorise_held`].
    #[inline]
    pub(crate) fn correct_held(&self, at: &mut Scratch, forces: &mut [f64]) {
        four::run(Solve { lagrangian: self, at, gains: &[], job: Job::CorrectHeld { forces } });
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
        self.factorise_held(at, gains);
        self.correct_held(at, q_ddot);
    }

    /// `M_Rq q_ddot + M_RR beta_dot + h_R` after [`Self::evaluate`]: what the rigid rows ask of the loads.
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

    /// The upper triangle of the mass matrix.
    #[inline(always)]
    fn assemble<M: Machine>(&self, m: M, at: &mut Scratch, gains: &[Four]) {
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
        }
        self.assemble_elastic(m, at, gains);
    }

    /// The upper triangle of its elastic block.
    #[inline(always)]
    fn assemble_elastic<M: Machine>(&self, m: M, at: &mut Scratch, gains: &[Four]) {
        let (blocks, n) = (at.elastic.len(), self.fields.len());
        for column in 0..blocks {
            for row in 0..=column {
                let tile = added(m, squares(m, &at.path.d, n, row, column), gains, blocks, row, column);
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

/// A tile of `D^t D`, of columns of `n` blocks; of those on the diagonal the upper triangle counts.
#[inline(always)]
fn squares<M: Machine>(machine: M, d: &[Four], n: usize, row: usize, column: usize) -> Tile {
    let upper_right = products(machine, d, n, 4 * row, 4 * column + 2);
    let lower_right = products(machine, d, n, 4 * row + 2, 4 * column + 2);
    let upper_left = products(machine, d, n, 4 * row, 4 * column);
    let lower_left = if row == column { [0.0; 4] } else { products(machine, d, n, 4 * row + 2, 4 * column) };
    let ([a, b, c, d], [e, f, g, h]) = (upper_left, upper_right);
    let ([i, j, k, l], [m, n, o, p]) = (lower_left, lower_right);
    [[a, b, e, f], [c, d, g, h], [i, j, m, n], [k, l, o, p]]
}

/// Products of two columns with two others, zero where there are none.
#[inline(always)]
fn products<M: Machine>(m: M, d: &[Four], n: usize, row: usize, column: usize) -> Four {
    let pair = |first: usize| d.get(first * n..(first + 2) * n).and_then(|pair| pair.split_at_checked(n));
    let (Some((a, b)), Some((x, y))) = (pair(row), pair(column)) else { return [0.0; 4] };
    let [mut ax, mut ay, mut bx, mut by] = [m.zero(); 4];
    for ((a, b), (x, y)) in a.iter().zip(b).zip(x.iter().zip(y)) {
        let (a, b, x, y) = (m.load(a), m.load(b), m.load(x), m.load(y));
        (ax, ay, bx, by) = (ax + a * x, ay + a * y, bx + b * x, by + b * y);
    }
    m.sums([ax, ay, bx, by])
}

/// The tile with the gains on it.
#[inline(always)]
fn added<M: Machine>(m: M, mut tile: Tile, gains: &[Four], blocks: usize, row: usize, column: usize) -> Tile {
    for (k, line) in tile.iter_mut().enumerate() {
        if let Some(gain) = gains.get((4 * row + k) * blocks + column) {
            *line = m.store(m.load(line) + m.load(gain));
        }
    }
    tile
}

/// What is done with the mass matrix at the state evaluated last.
struct Solve<'a> {
    lagrangian: &'a Lagrangian,
    at: &'a mut Scratch,
    gains: &'a [Four],
    job: Job<'a>,
}

enum Job<'a> {
    /// After [`Lagrangian::evaluate`].
    Solve {
        elastic: &'a [f64],
        rigid: &'a Vec6,
        q_ddot: &'a mut [f64],
    },
    /// After [`Lagrangian::inertia`].
    Factorise,
    Correct {
        elastic: &'a [f64],
        rigid: &'a Vec6,
        q_ddot: &'a mut [f64],
    },
    FactoriseHeld,
    CorrectHeld {
        forces: &'a mut [f64],
    },
}

impl Kernel for Solve<'_> {
    /// Accelerations of A where they are asked for.
    type Output = Option<Vec6>;

    #[inline(always)]
    fn on<M: Machine>(self, m: M) -> Option<Vec6> {
        let Solve { lagrangian, at, gains, job } = self;
        match job {
            Job::Solve { elastic, rigid, q_ddot } => {
                lagrangian.assemble(m, at, gains);
                at.system.factorise(m, 0);
                return Some(at.solve_factorised(m, elastic, rigid, q_ddot));
            }
            Job::Factorise => {
                at.couple(m, &lagrangian.first);
                lagrangian.assemble(m, at, gains);
                at.system.factorise(m, 0);
            }
            Job::Correct { elastic, rigid, q_ddot } => {
                return Some(at.solve_factorised(m, elastic, rigid, q_ddot));
            }
            Job::FactoriseHeld => {
                lagrangian.assemble_elastic(m, at, gains);
                at.system.factorise(m, RIGID);
            }
            Job::CorrectHeld { forces } => at.solve_elastic(m, forces),
        }
        None
    }
}

impl Scratch {
    /// Accelerations by the factors of [`Lagrangian::solve`].
    #[inline(always)]
    fn solve_factorised<M: Machine>(
        &mut self,
        m: M,
        elastic: &[f64],
        rigid: &Vec6,
        q_ddot: &mut [f64],
    ) -> Vec6 {
        let (v, w) = split(rigid);
        if let Some((heads, x)) = self.solution.split_first_chunk_mut::<RIGID>() {
            *heads = [[v[0], v[1], v[2], 0.0], [w[0], w[1], w[2], 0.0]];
            four::fill(x, elastic);
            if let Some(last) = x.as_flattened_mut().get_mut(elastic.len()..) {
                last.fill(0.0);
            }
        }
        self.system.substitute(m, 0, &mut self.solution);
        let Some((&[v, w], x)) = self.solution.split_first_chunk::<RIGID>() else { return [0.0; 6] };
        for (to, from) in q_ddot.iter_mut().zip(x.as_flattened()) {
            *to = *from;
        }
        [v[0], v[1], v[2], w[0], w[1], w[2]]
    }

    /// Solves with the elastic block in place.
    #[inline(always)]
    fn solve_elastic<M: Machine>(&mut self, m: M, values: &mut [f64]) {
        let Some(x) = self.solution.get_mut(RIGID..) else { return };
        four::fill(x, values);
        if let Some(last) = x.as_flattened_mut().get_mut(values.len()..) {
            last.fill(0.0);
        }
        self.system.substitute(m, RIGID, x);
        for (to, from) in values.iter_mut().zip(x.as_flattened()) {
            *to = *from;
        }
    }

    /// `beta` for a momentum, with the rates of the amplitudes given: `M_RR^-1 (momentum - M_Rq q_dot)`. After
    /// [`Lagrangian::solve`], whose first factors are those of `M_RR`.
    #[inline]
    pub(crate) fn velocity(&self, momentum: &Vec6, q_dot: &[f64]) -> Vec6 {
        let (v, w) = split(&crate::math::sub_6(momentum, &self.coupled(q_dot)));
        let mut x = [[v[0], v[1], v[2], 0.0], [w[0], w[1], w[2], 0.0]];
        self.system.substitute(four::Plain, 0, &mut x);
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
