//! Moments, momentum and forces at a state: everything of (B.7) but the mass matrix of the amplitudes.

use super::lanes::{self, SecondMoment};
use super::{Lagrangian, Scratch, traced};
use crate::dense::{rows, rows_mut};
use crate::four::{self, Four, Kernel, Machine};
use crate::math::{Vec3, Vec6, add, axpy, cross, dot, join, mul, scale, split, sub};

/// Accelerations whose inertia forces are asked for besides.
#[derive(Clone, Copy)]
pub(crate) struct Accelerations<'a> {
    pub(crate) q_ddot: &'a [f64],
    pub(crate) beta_dot: &'a Vec6,
    /// Of free fall, components in A: its weight comes off the elastic rows.
    pub(crate) fall: Vec3,
}

impl Accelerations<'_> {
    const NONE: Accelerations<'static> = Accelerations { q_ddot: &[], beta_dot: &[0.0; 6], fall: [0.0; 3] };
}

/// An evaluation at amplitudes, rates and true velocity of A.
struct Evaluate<'a> {
    lagrangian: &'a Lagrangian,
    q: &'a [f64],
    q_dot: &'a [f64],
    beta: &'a Vec6,
    accelerations: &'a Accelerations<'a>,
    couple: bool,
    at: &'a mut Scratch,
}

impl Kernel for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn on<M: Machine>(self, m: M) {
        let Evaluate { lagrangian, q, q_dot, beta, accelerations, couple, at } = self;
        lagrangian.coordinates.evaluate(m, q, q_dot, &mut at.path);
        at.accelerate(m, accelerations.q_ddot);
        lagrangian.visit_fields(m, beta, accelerations, at);
        at.project(m);
        lagrangian.add_elastic(m, q, at);
        if couple {
            at.couple(m, &lagrangian.first);
        }
    }
}

impl Lagrangian {
    /// Inertia and elastic forces at amplitudes `q`, rates `q_dot` and true velocity `beta` of A but for those of the accelerations, and
    /// the coupling of the amplitudes with the rigid motion, into the scratch.
    #[inline]
    pub(crate) fn evaluate(&self, q: &[f64], q_dot: &[f64], beta: &Vec6, at: &mut Scratch) {
        let accelerations = &Accelerations::NONE;
        four::run(Evaluate { lagrangian: self, q, q_dot, beta, accelerations, couple: true, at });
    }

    /// As [`Self::evaluate`] with the inertia of accelerations, without the coupling.
    #[inline]
    pub(crate) fn inertia(
        &self,
        q: &[f64],
        q_dot: &[f64],
        beta: &Vec6,
        accelerations: &Accelerations,
        at: &mut Scratch,
    ) {
        four::run(Evaluate { lagrangian: self, q, q_dot, beta, accelerations, couple: false, at });
    }

    /// Forces on the coordinates, `N_a`, and the rigid rows.
    #[inline(always)]
    fn visit_fields<M: Machine>(&self, m: M, beta: &Vec6, accelerations: &Accelerations, at: &mut Scratch) {
        let (v, w) = split(beta);
        let (v_dot, w_dot) = split(accelerations.beta_dot);
        let push = lanes::splat(m, sub(add(cross(w, v), v_dot), accelerations.fall));
        let (w_lanes, w_dot_lanes) = (lanes::splat(m, w), lanes::splat(m, w_dot));
        let (w2, twice) = (m.splat(dot(w, w)), lanes::splat(m, scale(2.0, w)));
        let mut first = lanes::zero(m);
        let (mut momentum, mut accelerated, mut coriolis) = ([first; 2], [first; 2], first);
        let mut second_moment = SecondMoment::zero(m);
        let Scratch { path, moment, turning_rate, forces, turning, .. } = at;
        self.moments.evaluate(m, &path.y, &path.y_dot, moment, turning_rate);
        let moments = moment.as_chunks::<9>().0.iter().zip(turning_rate.as_chunks::<3>().0);
        let coordinates = path.y.iter().zip(&path.y_dot).zip(&path.second);
        let found = forces.iter_mut().zip(columns(turning, self.fields.len()));
        for (((field, (p, n_rate)), ((y, y_dot), second)), (force, [n_x, n_y, n_z])) in
            self.fields.iter().zip(moments).zip(coordinates).zip(found)
        {
            let (y, y_dot, second) = (m.load(y), m.load(y_dot), m.load(second));
            let (p, turned_rate) = (lanes::matrices(m, p), lanes::dot::<M>(twice, lanes::load(m, n_rate)));
            let (n, s) = (lanes::turned::<M>(&p), lanes::load(m, &field.first));
            let [x, y_, z] = n;
            (*n_x, *n_y, *n_z) = (m.store(x), m.store(y_), m.store(z));
            let (turned, tr) = (lanes::product::<M>(&p, w_lanes), lanes::trace::<M>(&p));
            let inward = lanes::dot::<M>(w_lanes, turned) - w2 * tr;
            let pushed = lanes::dot::<M>(push, s) + lanes::dot::<M>(w_dot_lanes, n);
            *force = m.store((second + pushed) + (turned_rate + inward));
            second_moment.add(m, y, &p, &field.moment_0);
            first = lanes::plus::<M>(first, y, s);
            let ([s_rate, n_rate], [s_second, n_second]) = (momentum, accelerated);
            momentum = [lanes::plus::<M>(s_rate, y_dot, s), lanes::plus::<M>(n_rate, y_dot, n)];
            accelerated = [lanes::plus::<M>(s_second, second, s), lanes::plus::<M>(n_second, second, n)];
            // int X x (w x F_a y_dot) = y_dot (w tr P_a - P_a w)
            let ([w_x, w_y, w_z], [t_x, t_y, t_z]) = (w_lanes, turned);
            let around = [w_x * tr - t_x, w_y * tr - t_y, w_z * tr - t_z];
            coriolis = lanes::plus::<M>(coriolis, y_dot, around);
        }
        at.second_moment = self.second_moment_0;
        second_moment.add_to(m, &mut at.second_moment);
        let ([s_dot, n_rate], [s_second, n_second]) = (momentum, accelerated);
        let (s_dot, n_rate) = (lanes::sums(m, s_dot), lanes::sums(m, n_rate));
        let (s_second, n_second) = (lanes::sums(m, s_second), lanes::sums(m, n_second));
        at.first_moment = add(self.first_moment_0, lanes::sums(m, first));
        let sums = Sums { s_dot, n_rate, s_second, n_second, coriolis: lanes::sums(m, coriolis) };
        self.assemble_rigid(beta, accelerations.beta_dot, &sums, at);
    }

    /// `h` of the rigid rows with the inertia of the accelerations, and the momentum.
    #[inline(always)]
    fn assemble_rigid(&self, beta: &Vec6, beta_dot: &Vec6, sums: &Sums, at: &mut Scratch) {
        let ((v, w), (v_dot, w_dot)) = (split(beta), split(beta_dot));
        let Sums { s_dot, n_rate, s_second, n_second, coriolis } = *sums;
        let (push, s) = (add(cross(w, v), v_dot), at.first_moment);
        let inertia = traced(&at.second_moment, 1.0);
        let angular = mul(&inertia, w);
        let turning = add(axpy(s_second, 2.0, cross(w, s_dot)), cross(w, cross(w, s)));
        let h_v = add(axpy(turning, self.mass, push), cross(w_dot, s));
        let gyroscopic = axpy(add(cross(s, push), cross(w, angular)), 2.0, coriolis);
        let h_w = add(add(gyroscopic, n_second), mul(&inertia, w_dot));
        at.rigid = join(h_v, h_w);
        at.momentum =
            join(add(axpy(s_dot, self.mass, v), cross(w, s)), add(add(cross(s, v), angular), n_rate));
    }

    /// Adds the elastic forces but those of the equilibrium: `K q + e de/dq`.
    #[inline(always)]
    pub(super) fn add_elastic<M: Machine>(&self, m: M, q: &[f64], at: &mut Scratch) {
        let blocks = at.elastic.len();
        four::fill(&mut at.q, q);
        let forces = at.elastic.as_flattened_mut();
        for (force, row) in forces.iter_mut().zip(rows(&self.stiffness, blocks)) {
            *force += m.dot(row, &at.q);
        }
        if !self.self_stress_curve.is_empty() {
            for (to, from) in at.stress.iter_mut().zip(&self.self_stress) {
                *to = *from;
            }
            self.self_stress_curve.add_values(q, &mut at.stress_curve, &mut at.stress);
            self.self_stress_curve.pull_back(&at.stress, &mut at.stress_curve, forces);
        }
    }

    /// Adds the weight in the field `g` (components in A) at the state of [`Self::evaluate`]: relative elastic rows and rigid ones.
    #[inline]
    pub(crate) fn weight(&self, g: Vec3, at: &Scratch, elastic: &mut [f64]) -> Vec6 {
        for (row, g) in rows(&at.coupling, at.elastic.len().max(1)).zip(g) {
            for (force, s) in elastic.iter_mut().zip(row.as_flattened()) {
                *force += g * s;
            }
        }
        self.rigid_weight(g, at)
    }

    /// The rigid rows of the weight.
    #[inline]
    pub(crate) fn rigid_weight(&self, g: Vec3, at: &Scratch) -> Vec6 {
        join(scale(self.mass, g), cross(at.first_moment, g))
    }
}

/// The three columns of `N_a`, row by row.
#[inline(always)]
fn columns(turning: &mut [Four], blocks: usize) -> impl Iterator<Item = [&mut Four; 3]> {
    let (x, rest) = turning.split_at_mut_checked(blocks).unwrap_or_default();
    let (y, z) = rest.split_at_mut_checked(blocks).unwrap_or_default();
    x.iter_mut().zip(y).zip(z).map(|((x, y), z)| [x, y, z])
}

/// What the rigid rows collect from the fields.
#[derive(Clone, Copy, Debug)]
struct Sums {
    /// `S_a` and `N_a` times the rates and times the second derivatives.
    s_dot: Vec3,
    n_rate: Vec3,
    s_second: Vec3,
    n_second: Vec3,
    /// `int X x (w x X_dot)`.
    coriolis: Vec3,
}

impl Scratch {
    /// Adds `D q_ddot` to the second derivatives.
    #[inline(always)]
    fn accelerate<M: Machine>(&mut self, m: M, q_ddot: &[f64]) {
        let path = &mut self.path;
        for (column, q_ddot) in rows(&path.d, path.second.len()).zip(q_ddot) {
            let q_ddot = m.splat(*q_ddot);
            for (second, d) in path.second.iter_mut().zip(column) {
                *second = m.store(m.load(second) + q_ddot * m.load(d));
            }
        }
    }

    /// Forces on the amplitudes from those on the coordinates.
    #[inline(always)]
    fn project<M: Machine>(&mut self, m: M) {
        let Scratch { path, forces, elastic, .. } = self;
        for (force, column) in elastic.as_flattened_mut().iter_mut().zip(rows(&path.d, forces.len())) {
            *force = m.dot(column, forces);
        }
    }

    /// `S_a D_a` and `N_a D_a`, with the three columns of `S_a`.
    #[inline(always)]
    pub(super) fn couple<M: Machine>(&mut self, m: M, first: &[Four]) {
        let n = self.forces.len();
        let [s_x, s_y, s_z] = thirds(first, n);
        let [n_x, n_y, n_z] = thirds(&self.turning, n);
        for (column, d) in rows(&self.path.d, n).take(self.modes).enumerate() {
            let [mut x, mut y, mut z, mut p, mut q, mut r] = [m.zero(); 6];
            let maps = s_x.iter().zip(s_y).zip(s_z).zip(n_x.iter().zip(n_y).zip(n_z));
            for (d, (((s_x, s_y), s_z), ((n_x, n_y), n_z))) in d.iter().zip(maps) {
                let d = m.load(d);
                (x, y, z) = (x + d * m.load(s_x), y + d * m.load(s_y), z + d * m.load(s_z));
                (p, q, r) = (p + d * m.load(n_x), q + d * m.load(n_y), r + d * m.load(n_z));
            }
            let ([x, y, z, p], [q, r, ..]) = (m.sums([x, y, z, p]), m.sums([q, r, r, r]));
            for (row, sum) in rows_mut(&mut self.coupling, self.elastic.len()).zip([x, y, z, p, q, r]) {
                if let Some(to) = row.as_flattened_mut().get_mut(column) {
                    *to = sum;
                }
            }
        }
    }
}

/// Three columns after each other.
#[inline(always)]
fn thirds(columns: &[Four], n: usize) -> [&[Four]; 3] {
    let (x, rest) = columns.split_at_checked(n).unwrap_or_default();
    let (y, z) = rest.split_at_checked(n).unwrap_or_default();
    [x, y, z]
}
