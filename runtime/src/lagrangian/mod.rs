//! The reduced Lagrangian (docs/beyond.md): consistent inertia, and the elastic energy of large deflections.
//!
//! The mass of the body is at `X = X_0 + y_a(q) F_a` in A, with fields `F_a` orthonormal in the metric of the mass; its inertial
//! acceleration, but for the accelerations of the unknowns, is `w x v + y_ddot_a F_a + 2 w x X_dot + w x (w x X)`. With
//! `P_a = int F_a X^t`, `N_a = int X x F_a`, `S_a = int F_a` and `D = dy/dq`,
//!
//! ```text
//! | I m      -S~   S_a D_a  |              | v_dot  |
//! | S~        I    N_a D_a  |              | w_dot  |    + h   =   Q                                                     (B.7)
//! | sym.           D_a D_a  |              | q_ddot |
//!
//! h_v = m w x v + 2 w x S_dot + w x (w x S) + S_a s_a                                   s_a = second derivative of y_a along q_dot
//! h_w = S x (w x v) + 2 int X x (w x X_dot) + w x (I w) + N_a s_a
//! h_q = D_a^t (s_a + S_a . (w x v) + 2 w . int X_dot x F_a + w . P_a w - w^2 tr P_a)
//! ```
//!
//! These are Lagrange's equations of `T` whatever `y(q)` and the tensors are, so that energy and both momenta are kept whatever was
//! truncated. Rows and columns here have the rigid motion first, and the *relative* shapes: A stands still in them.

mod energy;
mod solve;

use alloc::{vec, vec::Vec};

use crate::data::ModelData;
use crate::dense::{rows, rows_mut};
use crate::math::{Mat3, Vec3, Vec6, add, axpy, cross, dot, join, mul, scale, split};
use crate::polynomial::{Jet, Polynomial};

pub(crate) use energy::Energies;

/// Most kinetic coordinates a model may have: outputs hold them on the stack.
pub(crate) const MAX_FIELDS: usize = 512;

/// Constants of the Lagrangian.
#[derive(Clone, Debug)]
pub(crate) struct Lagrangian {
    modes: usize,
    mass: f64,
    /// `A`, upper triangular - (m x m).
    linear: Vec<f64>,
    curve: Polynomial,
    first_moment_0: Vec3,
    /// `int X_0 X_0^t`.
    second_moment_0: Mat3,
    fields: Vec<Field>,
    moments: Vec<Moment>,
    /// Where the moments of each field end - (n).
    moment_ends: Vec<usize>,
    /// `K` - (m x m).
    pub(crate) stiffness: Vec<f64>,
    self_stress: Vec<f64>,
    self_stress_curve: Polynomial,
}

/// Moments of a field.
#[derive(Clone, Copy, Debug)]
struct Field {
    /// `S_a`.
    first: Vec3,
    /// `P_a0`, by rows.
    moment_0: [f64; 9],
}

/// An entry of `P_ab`.
#[derive(Clone, Copy, Debug)]
struct Moment {
    b: usize,
    component: usize,
    value: f64,
}

/// What an evaluation finds and needs.
#[derive(Clone, Debug)]
pub(crate) struct Scratch {
    jets: Vec<Jet>,
    stress_jets: Vec<Jet>,
    y: Vec<f64>,
    y_dot: Vec<f64>,
    second: Vec<f64>,
    /// Rows `(S_a, N_a, D_a)` - (n x (6 + m)).
    maps: Vec<f64>,
    stress: Vec<f64>,
    /// `S`, its rate, `int X X^t`.
    pub(crate) first_moment: Vec3,
    second_moment: Mat3,
    /// Momentum `dT/dbeta`.
    pub(crate) momentum: Vec6,
    /// `h` and the elastic forces: rigid rows, then relative elastic ones.
    pub(crate) rigid: Vec6,
    pub(crate) elastic: Vec<f64>,
    /// The system of equations and its right-hand side - ((6 + m) x (7 + m)).
    system: Vec<f64>,
}

impl Scratch {
    /// For a model; empty without a Lagrangian.
    pub(crate) fn new(lagrangian: Option<&Lagrangian>) -> Self {
        let (m, n, l) = lagrangian.map_or((0, 0, 0), |it| (it.modes, it.fields.len(), it.self_stress.len()));
        let width = if lagrangian.is_some() { m + 6 } else { 0 };
        Scratch {
            jets: lagrangian.map_or_else(Vec::new, |it| it.curve.jets()),
            stress_jets: lagrangian.map_or_else(Vec::new, |it| it.self_stress_curve.jets()),
            y: vec![0.0; n],
            y_dot: vec![0.0; n],
            second: vec![0.0; n],
            maps: vec![0.0; n * width],
            stress: vec![0.0; l],
            first_moment: [0.0; 3],
            second_moment: [[0.0; 3]; 3],
            momentum: [0.0; 6],
            rigid: [0.0; 6],
            elastic: vec![0.0; m],
            system: vec![0.0; width * (width + 1)],
        }
    }
}

impl Lagrangian {
    /// From checked data; none where the model has none.
    pub(crate) fn new(data: &ModelData) -> Option<Self> {
        let lagrangian = data.lagrangian.as_ref()?;
        let (m, n) = (data.modes.omega.len(), lagrangian.fields as usize);
        let component = |values: &[f64], at: usize| values.get(at).copied().unwrap_or(0.0);
        let field = |a: usize| Field {
            first: core::array::from_fn(|k| component(&lagrangian.first_moment, k * n + a)),
            moment_0: core::array::from_fn(|k| component(&lagrangian.moment_0, 9 * a + k)),
        };
        let moment = &lagrangian.moment;
        let entries = moment.l.iter().zip(&moment.r).zip(&moment.value);
        let inertia: Mat3 = core::array::from_fn(|i| {
            core::array::from_fn(|j| component(&data.rigid.mass_matrix, 6 * (i + 3) + j + 3))
        });
        Some(Lagrangian {
            modes: m,
            mass: data.rigid.mass,
            linear: lagrangian.linear.clone(),
            curve: Polynomial::new(n, &lagrangian.curve),
            first_moment_0: scale(data.rigid.mass, data.rigid.centre_of_mass),
            // I = tr(J) 1 - J, and so J = tr(I)/2 1 - I.
            second_moment_0: traced(&inertia, 0.5),
            fields: (0..n).map(field).collect(),
            moments: entries
                .map(|((&b, &component), &value)| Moment {
                    b: b as usize,
                    component: component as usize,
                    value,
                })
                .collect(),
            moment_ends: (0..n).map(|a| moment.i.partition_point(|&i| i as usize <= a)).collect(),
            stiffness: lagrangian.stiffness.clone(),
            self_stress: lagrangian.self_stress.clone(),
            self_stress_curve: Polynomial::new(lagrangian.self_stress.len(), &lagrangian.self_stress_curve),
        })
    }

    /// Number of kinetic coordinates, and of terms in them and in their moments.
    pub(crate) fn size(&self) -> [usize; 3] {
        [self.fields.len(), self.curve.n_terms(), self.moments.len()]
    }

    /// Inertia and elastic forces at amplitudes `q`, rates `q_dot` and true velocity `beta` of A, into the scratch.
    #[inline]
    pub(crate) fn evaluate(&self, q: &[f64], q_dot: &[f64], beta: &Vec6, at: &mut Scratch) {
        self.kinetic_coordinates(q, q_dot, at);
        self.inertia(beta, at);
        self.elastic(q, at);
    }

    /// `y`, its rate, its second derivative along the rates, and `D`.
    #[inline]
    fn kinetic_coordinates(&self, q: &[f64], q_dot: &[f64], at: &mut Scratch) {
        let (m, width) = (self.modes, self.modes + 6);
        at.y.fill(0.0);
        at.second.fill(0.0);
        at.maps.fill(0.0);
        if m > 0 {
            let rows = rows_mut(&mut at.maps, width).zip(rows(&self.linear, m));
            for ((map, linear), y) in rows.zip(&mut at.y) {
                for ((to, a), q) in map.iter_mut().skip(6).zip(linear).zip(q) {
                    *to = *a;
                    *y += a * q;
                }
            }
        }
        self.curve.prepare(q, q_dot, &mut at.jets);
        self.curve.expand(&at.jets, &mut at.y, &mut at.second, &mut at.maps, width, 6);
        for (map, y_dot) in rows(&at.maps, width).zip(&mut at.y_dot) {
            *y_dot = map.iter().skip(6).zip(q_dot).map(|(d, q_dot)| d * q_dot).sum();
        }
    }

    /// Moments of the fields, momentum, and the forces `h` of (B.7).
    #[inline]
    fn inertia(&self, beta: &Vec6, at: &mut Scratch) {
        let (v, w) = split(beta);
        let whirl = cross(w, v);
        let w2 = dot(w, w);
        let (mut s, mut s_dot, mut s_second) = (self.first_moment_0, [0.0; 3], [0.0; 3]);
        let (mut xx, mut xv) = ([0.0; 9], [0.0; 9]);
        let (mut h_elastic, mut n_rate, mut n_second) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        at.elastic.fill(0.0);
        let width = self.modes + 6;
        let rows = self.fields.iter().zip(self.moment_rows()).zip(rows_mut(&mut at.maps, width));
        for (((field, moments), map), ((&y, &y_dot), &second)) in
            rows.zip(at.y.iter().zip(&at.y_dot).zip(&at.second))
        {
            let (mut p, mut p_dot) = (field.moment_0, [0.0; 9]);
            for moment in moments {
                let (y, y_dot) = (get(&at.y, moment.b), get(&at.y_dot, moment.b));
                add_to(&mut p, moment.component, moment.value * y);
                add_to(&mut p_dot, moment.component, moment.value * y_dot);
            }
            let n = turned(&p);
            for (to, from) in map.iter_mut().zip(join(field.first, n)) {
                *to = from;
            }
            s = axpy(s, y, field.first);
            s_dot = axpy(s_dot, y_dot, field.first);
            s_second = axpy(s_second, second, field.first);
            n_rate = axpy(n_rate, y_dot, n);
            n_second = axpy(n_second, second, n);
            // int X X^t = J_0 + y_a (P_a0^t + P_a); int X_dot X^t = y_dot_a P_a.
            let mirrored = transposed(&field.moment_0);
            for ((xx, xv), (p, p_0)) in xx.iter_mut().zip(&mut xv).zip(p.iter().zip(&mirrored)) {
                *xx += y * (p + p_0);
                *xv += y_dot * p;
            }
            let force = second + dot(field.first, whirl) + 2.0 * dot(w, turned(&p_dot)) + quadratic(&p, w)
                - w2 * trace(&p);
            for (h, d) in at.elastic.iter_mut().zip(map.iter().skip(6)) {
                *h += d * force;
            }
        }
        let mut second_moment = self.second_moment_0;
        for (to, from) in second_moment.as_flattened_mut().iter_mut().zip(&xx) {
            *to += from;
        }
        let inertia = traced(&second_moment, 1.0);
        let angular = mul(&inertia, w);
        let h_v = axpy(add(axpy(s_second, 2.0, cross(w, s_dot)), cross(w, cross(w, s))), self.mass, whirl);
        // int X x (w x X_dot) = w tr(xv) - xv w
        let coriolis = axpy(scale(trace(&xv), w), -1.0, product(&xv, w));
        h_elastic = add(h_elastic, add(cross(s, whirl), cross(w, angular)));
        let h_w = add(axpy(h_elastic, 2.0, coriolis), n_second);
        at.rigid = join(h_v, h_w);
        at.momentum =
            join(add(axpy(s_dot, self.mass, v), cross(w, s)), add(add(cross(s, v), angular), n_rate));
        at.first_moment = s;
        at.second_moment = second_moment;
    }

    /// Adds the elastic forces but those of the equilibrium: `K q + e de/dq`.
    #[inline]
    fn elastic(&self, q: &[f64], at: &mut Scratch) {
        if self.modes > 0 {
            for (h, row) in at.elastic.iter_mut().zip(rows(&self.stiffness, self.modes)) {
                *h += row.iter().zip(q).map(|(k, q)| k * q).sum::<f64>();
            }
        }
        if !self.self_stress_curve.is_empty() {
            self.self_stress_curve.prepare(q, q, &mut at.stress_jets);
            for (stress, constant) in at.stress.iter_mut().zip(&self.self_stress) {
                *stress = *constant;
            }
            self.self_stress_curve.values(&at.stress_jets, &mut at.stress);
            self.self_stress_curve.pull_back(&mut at.stress_jets, &at.stress, &mut at.elastic);
        }
    }

    /// Adds the weight in the field `g` (components in A) at the evaluated state: relative elastic rows and rigid ones.
    #[inline]
    pub(crate) fn weight(&self, g: Vec3, at: &Scratch, elastic: &mut [f64]) -> Vec6 {
        for (field, map) in self.fields.iter().zip(rows(&at.maps, self.modes + 6)) {
            let force = dot(g, field.first);
            for (row, d) in elastic.iter_mut().zip(map.iter().skip(6)) {
                *row += d * force;
            }
        }
        join(scale(self.mass, g), cross(at.first_moment, g))
    }

    /// Entries `P_ab` of each field in turn.
    #[inline]
    fn moment_rows(&self) -> impl Iterator<Item = &[Moment]> {
        let starts = core::iter::once(0).chain(self.moment_ends.iter().copied());
        starts.zip(&self.moment_ends).map(|(start, &end)| self.moments.get(start..end).unwrap_or(&[]))
    }
}

/// `factor tr(a) 1 - a`.
#[inline]
fn traced(a: &Mat3, factor: f64) -> Mat3 {
    let mut out = *a;
    let diagonal = factor * (a[0][0] + a[1][1] + a[2][2]);
    for (i, row) in out.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = if i == j { diagonal - *entry } else { -*entry };
        }
    }
    out
}

/// `int X x F` from `int F X^t`, by rows.
#[inline]
fn turned(p: &[f64; 9]) -> Vec3 {
    [p[7] - p[5], p[2] - p[6], p[3] - p[1]]
}

#[inline]
fn transposed(p: &[f64; 9]) -> [f64; 9] {
    [p[0], p[3], p[6], p[1], p[4], p[7], p[2], p[5], p[8]]
}

#[inline]
fn trace(p: &[f64; 9]) -> f64 {
    p[0] + p[4] + p[8]
}

#[inline]
fn product(p: &[f64; 9], w: Vec3) -> Vec3 {
    [dot([p[0], p[1], p[2]], w), dot([p[3], p[4], p[5]], w), dot([p[6], p[7], p[8]], w)]
}

#[inline]
fn quadratic(p: &[f64; 9], w: Vec3) -> f64 {
    dot(w, product(p, w))
}

#[inline]
fn get(values: &[f64], index: usize) -> f64 {
    values.get(index).copied().unwrap_or(0.0)
}

#[inline]
fn add_to(values: &mut [f64], index: usize, value: f64) {
    if let Some(entry) = values.get_mut(index) {
        *entry += value;
    }
}
