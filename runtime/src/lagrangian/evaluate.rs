//! Moments, momentum and forces at a state: everything of (B.7) but the mass matrix of the amplitudes.

use super::{Lagrangian, Scratch, product, trace, traced, turned};
use crate::dense::{rows, rows_mut};
use crate::four::{self, Four};
use crate::math::{Vec3, Vec6, add, axpy, cross, dot, join, mul, scale, split};

impl Lagrangian {
    /// Inertia and elastic forces at amplitudes `q`, rates `q_dot` and true velocity `beta` of A, into the scratch.
    #[inline]
    pub(crate) fn evaluate(&self, q: &[f64], q_dot: &[f64], beta: &Vec6, at: &mut Scratch) {
        four::wide(
            at,
            #[inline(always)]
            |at| self.evaluate_wide(q, q_dot, beta, at),
        );
    }

    #[inline(always)]
    fn evaluate_wide(&self, q: &[f64], q_dot: &[f64], beta: &Vec6, at: &mut Scratch) {
        self.coordinates.evaluate(q, q_dot, &mut at.path);
        at.elastic.fill([0.0; 4]);
        let sums = self.visit_fields(beta, at);
        at.couple();
        self.assemble_rigid(beta, &sums, at);
        self.add_elastic(q, at);
    }

    /// Rows of the maps, forces on the amplitudes, and what the rigid rows collect.
    #[inline(always)]
    fn visit_fields(&self, beta: &Vec6, at: &mut Scratch) -> Sums {
        let (v, w) = split(beta);
        let (whirl, w2) = (cross(w, v), dot(w, w));
        let mut sums = Sums { first: self.first_moment_0, ..Sums::default() };
        let blocks = at.elastic.len().max(1);
        let path = &at.path;
        let of_field = |b: u32| path.y.get(b as usize).copied().unwrap_or_default();
        let constants = self.fields.iter().zip(self.moments.rows());
        let fields = constants.zip(at.maps.iter_mut().zip(rows(&path.d, blocks)));
        for (((field, moments), (map, d)), (&[y, _, y_dot, _], &second)) in
            fields.zip(path.y.iter().zip(&path.second))
        {
            let moment = self.moments.moment(moments, of_field);
            let p = moment.matrix(&field.moment_0);
            let (n, s) = (turned(&p), field.first);
            *map = [[s[0], s[1], s[2], n[0]], [n[1], n[2], 0.0, 0.0]];
            sums.first = axpy(sums.first, y, s);
            for (sum, map) in sums.seconds.iter_mut().zip(*map) {
                *sum = four::plus(*sum, second, map);
            }
            // int X X^t = J_0 + y_a (P_a0^t + P_a), which is symmetric.
            let p_0 = &field.moment_0;
            let diagonal = [p[0] + p_0[0], p[4] + p_0[4], p[8] + p_0[8]];
            let mixed =
                [p[1] + p[3] + p_0[1] + p_0[3], p[2] + p[6] + p_0[2] + p_0[6], p[5] + p[7] + p_0[5] + p_0[7]];
            sums.diagonal = axpy(sums.diagonal, y, diagonal);
            sums.mixed = axpy(sums.mixed, 0.5 * y, mixed);
            // int X x (w x F_a y_dot) = y_dot (w tr P_a - P_a w)
            let (turning, tr) = (product(&p, w), trace(&p));
            sums.coriolis = axpy(sums.coriolis, y_dot, axpy(scale(tr, w), -1.0, turning));
            let force =
                second + dot(s, whirl) + 2.0 * dot(w, moment.turned_rate()) + dot(w, turning) - w2 * tr;
            four::add_scaled(&mut at.elastic, force, d);
        }
        sums
    }

    /// `h` of the rigid rows, momentum, moments.
    #[inline(always)]
    fn assemble_rigid(&self, beta: &Vec6, sums: &Sums, at: &mut Scratch) {
        let (v, w) = split(beta);
        let whirl = cross(w, v);
        let s = sums.first;
        let [s_dot, n_rate] = at.relative_momentum();
        let mut second_moment = self.second_moment_0;
        let ([x, y, z], [xy, xz, yz]) = (sums.diagonal, sums.mixed);
        let added = [x, xy, xz, xy, y, yz, xz, yz, z];
        second_moment.as_flattened_mut().iter_mut().zip(added).for_each(|(to, from)| *to += from);
        let angular = mul(&traced(&second_moment, 1.0), w);
        let [[x, y, z, a], [b, c, ..]] = sums.seconds;
        let turning = add(axpy([x, y, z], 2.0, cross(w, s_dot)), cross(w, cross(w, s)));
        let h_v = axpy(turning, self.mass, whirl);
        let h_w = add(axpy(add(cross(s, whirl), cross(w, angular)), 2.0, sums.coriolis), [a, b, c]);
        at.rigid = join(h_v, h_w);
        at.momentum =
            join(add(axpy(s_dot, self.mass, v), cross(w, s)), add(add(cross(s, v), angular), n_rate));
        at.first_moment = s;
        at.second_moment = second_moment;
    }

    /// Adds the elastic forces but those of the equilibrium: `K q + e de/dq`.
    #[inline(always)]
    pub(super) fn add_elastic(&self, q: &[f64], at: &mut Scratch) {
        let blocks = at.elastic.len().max(1);
        let forces = at.elastic.as_flattened_mut();
        for (force, row) in forces.iter_mut().zip(rows(&self.stiffness, blocks)) {
            *force += four::dot(row, &at.path.q);
        }
        if !self.self_stress_curve.is_empty() {
            for (to, from) in at.stress.iter_mut().zip(&self.self_stress) {
                *to = *from;
            }
            self.self_stress_curve.add_values(q, &mut at.stress_curve, &mut at.stress);
            self.self_stress_curve.pull_back(&at.stress, &mut at.stress_curve, forces);
        }
    }

    /// Adds the weight in the field `g` (components in A) at the evaluated state: relative elastic rows and rigid ones.
    #[inline]
    pub(crate) fn weight(&self, g: Vec3, at: &Scratch, elastic: &mut [f64]) -> Vec6 {
        for (row, g) in rows(&at.coupling, at.elastic.len().max(1)).zip(g) {
            for (force, s) in elastic.iter_mut().zip(row.as_flattened()) {
                *force += g * s;
            }
        }
        join(scale(self.mass, g), cross(at.first_moment, g))
    }
}

/// What the rigid rows collect from the fields.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// `S`.
    first: Vec3,
    /// `S_a s_a` and `N_a s_a`.
    seconds: [Four; 2],
    /// `int X X^t` less its constant part: xx, yy, zz and xy, xz, yz.
    diagonal: Vec3,
    mixed: Vec3,
    /// `int X x (w x X_dot)`.
    coriolis: Vec3,
}

impl Scratch {
    /// `S_a D_a` and `N_a D_a`.
    #[inline(always)]
    fn couple(&mut self) {
        let blocks = self.elastic.len();
        for column in 0..blocks {
            let [mut a, mut b, mut c, mut d, mut e, mut f] = [[0.0; 4]; 6];
            for ([s, n], row) in self.maps.iter().zip(rows(&self.path.d, blocks)) {
                let Some(&row) = row.get(column) else { break };
                (a, b, c) = (four::plus(a, s[0], row), four::plus(b, s[1], row), four::plus(c, s[2], row));
                (d, e, f) = (four::plus(d, s[3], row), four::plus(e, n[0], row), four::plus(f, n[1], row));
            }
            for (row, sum) in rows_mut(&mut self.coupling, blocks).zip([a, b, c, d, e, f]) {
                if let Some(to) = row.get_mut(column) {
                    *to = sum;
                }
            }
        }
    }

    /// Momenta of the amplitudes' rates in A.
    #[inline(always)]
    fn relative_momentum(&self) -> [Vec3; 2] {
        let mut out = [0.0; 6];
        for (out, row) in out.iter_mut().zip(rows(&self.coupling, self.elastic.len().max(1))) {
            *out = four::dot(row, &self.path.q_dot);
        }
        let (linear, angular) = split(&out);
        [linear, angular]
    }
}
