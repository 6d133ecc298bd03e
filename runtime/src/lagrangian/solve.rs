//! The mass matrix of (B.7), and its solution by elimination: rigid rows first, so that their block can be had alone.
//!
//! Rows and columns are filled in by pairs: three pairs are those of `v` and `w`, those of `q` follow.

use super::system::{Pairs, System};
use super::{Lagrangian, Scratch, traced};
use crate::dense::rows;
use crate::four::{self, Four, Kernel, Machine};
use crate::math::Vec6;

/// Pairs of rows before those of `q`.
const RIGID: usize = 3;

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
        let rigid = self.rigid_block(at);
        let entry = |row: usize, column: usize| rigid.get(row).and_then(|row| row.get(column)).copied();
        let (elastic, coupling) = (self.modes.div_ceil(2), 2 * at.elastic.len());
        for (row, lines) in rows(&at.coupling, coupling).enumerate() {
            for column in row..RIGID {
                at.system.set(row, column, pairs(row, column, entry));
            }
            let Some((first, second)) = lines.as_flattened().split_at_checked(2 * coupling) else { return };
            let modes = first.as_chunks::<2>().0.iter().zip(second.as_chunks::<2>().0);
            for (column, (&[a, b], &[c, d])) in modes.take(elastic).enumerate() {
                at.system.set(row, RIGID + column, [a, b, c, d]);
            }
        }
        self.assemble_elastic(m, RIGID, at, gains);
    }

    /// The upper triangle of its elastic block, after so many pairs of rows.
    #[inline(always)]
    fn assemble_elastic<M: Machine>(&self, m: M, first: usize, at: &mut Scratch, gains: &[Four]) {
        let (n, width) = (self.fields.len(), 4 * at.elastic.len());
        let gain = |row: usize, column: usize| gains.as_flattened().get(row * width + column).copied();
        for column in 0..self.modes.div_ceil(2) {
            for row in 0..=column {
                let mut products = products(m, &at.path.d, n, row, column);
                if !gains.is_empty() {
                    let gained = pairs(row, column, gain);
                    products.iter_mut().zip(gained).for_each(|(to, gain)| *to += gain);
                }
                at.system.set(first + row, first + column, products);
            }
        }
        at.system.close(2 * first + self.modes);
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

/// Two rows of two columns of a matrix, zero where it has no entry.
#[inline(always)]
fn pairs(row: usize, column: usize, entry: impl Fn(usize, usize) -> Option<f64>) -> Pairs {
    let at = |i: usize, j: usize| entry(2 * row + i, 2 * column + j).unwrap_or(0.0);
    [at(0, 0), at(0, 1), at(1, 0), at(1, 1)]
}

/// Products of a pair of columns of `n` blocks with another, zero where there are none.
#[inline(always)]
fn products<M: Machine>(m: M, d: &[Four], n: usize, row: usize, column: usize) -> Pairs {
    let pair = |at: usize| d.get(2 * at * n..2 * (at + 1) * n).and_then(|pair| pair.split_at_checked(n));
    let (Some((a, b)), Some((x, y))) = (pair(row), pair(column)) else { return [0.0; 4] };
    let [mut ax, mut ay, mut bx, mut by] = [m.zero(); 4];
    for ((a, b), (x, y)) in a.iter().zip(b).zip(x.iter().zip(y)) {
        let (a, b, x, y) = (m.load(a), m.load(b), m.load(x), m.load(y));
        (ax, ay, bx, by) = (ax + a * x, ay + a * y, bx + b * x, by + b * y);
    }
    m.sums([ax, ay, bx, by])
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
                at.system.factorise(m, at.solution.len());
                return Some(at.solve_factorised(m, elastic, rigid, q_ddot));
            }
            Job::Factorise => {
                at.couple(m, &lagrangian.first);
                lagrangian.assemble(m, at, gains);
                at.system.factorise(m, at.solution.len());
            }
            Job::Correct { elastic, rigid, q_ddot } => {
                return Some(at.solve_factorised(m, elastic, rigid, q_ddot));
            }
            Job::FactoriseHeld => {
                lagrangian.assemble_elastic(m, 0, at, gains);
                at.system.factorise(m, at.elastic.len());
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
        let x = self.solution.as_flattened_mut();
        x.fill(0.0);
        for (to, from) in x.iter_mut().zip(rigid.iter().chain(elastic)) {
            *to = *from;
        }
        self.system.substitute(m, false, &mut self.solution);
        let Some((&beta_dot, x)) = self.solution.as_flattened().split_first_chunk::<6>() else {
            return [0.0; 6];
        };
        for (to, from) in q_ddot.iter_mut().zip(x) {
            *to = *from;
        }
        beta_dot
    }

    /// Solves with the elastic block in place.
    #[inline(always)]
    fn solve_elastic<M: Machine>(&mut self, m: M, values: &mut [f64]) {
        let Some(x) = self.solution.get_mut(..self.elastic.len()) else { return };
        x.fill([0.0; 4]);
        four::fill(x, values);
        self.system.substitute(m, false, x);
        for (to, from) in values.iter_mut().zip(x.as_flattened()) {
            *to = *from;
        }
    }

    /// `beta` for a momentum, with the rates of the amplitudes given: `M_RR^-1 (momentum - M_Rq q_dot)`. By the factors of
    /// [`Lagrangian::solve`], whose first ones are those of `M_RR`.
    #[inline]
    pub(crate) fn velocity(&self, momentum: &Vec6, q_dot: &[f64]) -> Vec6 {
        let [a, b, c, d, e, f] = crate::math::sub_6(momentum, &self.coupled(q_dot));
        let mut x = [[a, b, c, d], [e, f, 0.0, 0.0]];
        self.system.substitute(four::Plain, true, &mut x);
        let [[a, b, c, d], [e, f, ..]] = x;
        [a, b, c, d, e, f]
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
}

/// The system of a model with so many modes.
pub(super) fn system(modes: usize) -> System {
    System::new((2 * RIGID + modes).div_ceil(4))
}
