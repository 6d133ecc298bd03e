//! What the equations of the reduced model leave out, evaluated on its own motion (docs/validity.md).
//!
//! With positions `R_0 + phi_i q_i + 1/2 Theta_ij q_i q_j`, rows of A (`v`, `w`) and of the shapes relative to A:
//!
//! ```text
//! r_v = w_dot x S_k q_k + s_ij (q_i q_j)'' / 2
//! r_w = S_k q_k x v_dot + J_k q_k w_dot + n_i q_ddot_i + w x n_i q_dot_i + h_ij (q_i q_j)'' / 2 - 1/2 Theta^P_ij q_i q_j x F_P
//! r_i = n_i . w_dot + q_j (s_ij . (a + b_v) + h_ij . (w_dot + b_w) + G_ij(w, w) + t_ijk f_k + e_ij - Theta^P_ij . F_P)
//!     n_i = N_ki q_k,   f_k = q_ddot_k + omega_k^2 q_k,   a = v_dot + w x v - g,   b = phi_R,k omega_k^2 q_k
//! ```
//!
//! `S`, `J`, `N` are the first derivatives of the mass matrix by the amplitudes; `J` and `N` are read off the tensor `c`, which is
//! made of them. What belongs to `Theta` is in the model file.

use alloc::{vec, vec::Vec};

use super::bending::Bending;
use crate::data::ModelData;
use crate::dense::Dense;
use crate::four::Vectors;
use crate::math::{Mat3, Vec3, Vec6, add, axpy, cross, dot, dot_6, join, mul, split, sub};
use crate::model::Model;

/// Motion of the body at an instant, in A: amplitudes and their rates, true velocity of A and its rate.
#[derive(Clone, Copy)]
pub(super) struct Sample<'a> {
    pub(super) q: &'a [f64],
    pub(super) q_dot: &'a [f64],
    pub(super) q_ddot: &'a [f64],
    pub(super) beta: Vec6,
    pub(super) beta_dot: Vec6,
    /// Acceleration of free fall.
    pub(super) gravity: Vec3,
}

/// Force in A and moment in the node frame on the node of a point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NodeLoad {
    pub(super) point: usize,
    pub(super) force: Vec3,
    pub(super) moment: Vec3,
    /// What acts at the point itself, in A: constant in G, turning with A, turning with the node - (force, moment) each.
    pub(super) applied: [(Vec3, Vec3); 3],
}

/// The constants of the defect.
#[derive(Clone, Debug)]
pub(super) struct Defect {
    phi_r: Vec<Vec6>,
    omega2: Vec<f64>,
    /// `S_k` - (m).
    first_moment: Vec<Vec3>,
    /// `J_k`: xx, yy, zz, yz, xz, xy - (m).
    inertia: Vec<Vec6>,
    /// `N_ki`, three rows for every i - (3 m x m) -, and `n_i` - (m).
    coupling: Dense,
    vectors: Vectors,
    coupled: Vec<Vec3>,
    curved: Option<Bending>,
    /// `f_k`, behind `1`, `a + b_v`, `w_dot + b_w`, `w w` - (13 + m).
    field: Vec<f64>,
}

impl Defect {
    pub(super) fn new(model: &Model) -> Self {
        let data = model.data();
        let m = model.n_modes();
        let c = RelativeTensor::new(data, &model.phi_r);
        let at = |k: usize, i: usize| data.modes.first_moment.get(k * m + i).copied().unwrap_or(0.0);
        Defect {
            phi_r: model.phi_r.clone(),
            omega2: data.modes.omega.iter().map(|omega| omega * omega).collect(),
            first_moment: (0..m).map(|i| [at(0, i), at(1, i), at(2, i)]).collect(),
            inertia: (0..m).map(|i| c.inertia(i)).collect(),
            coupling: Dense::new(3 * m, m, |row, k| {
                c.coupling(row / 3, k).get(row % 3).copied().unwrap_or(0.0)
            }),
            vectors: Vectors::of_machine(),
            coupled: vec![[0.0; 3]; m],
            curved: data.validity.as_ref().map(|validity| Bending::new(validity, m)),
            field: vec![0.0; 13 + m],
        }
    }

    /// Adds the defect to `r`: rows of the elastic modes, then of the rigid motion, as in the equations of motion - (m + 6).
    /// `inertia`: with what a constant mass matrix leaves out.
    /// `lines`: `A` of every declared load per length.
    pub(super) fn add(
        &mut self,
        at: &Sample,
        loads: &[NodeLoad],
        lines: &[Mat3],
        inertia: bool,
        r: &mut [f64],
    ) {
        let Some((rows, rigid)) = r.split_last_chunk_mut::<6>() else { return };
        let (v, w) = split(&at.beta);
        let (v_dot, w_dot) = split(&at.beta_dot);
        let mut total = if inertia { self.add_inertia(at, rows) } else { [0.0; 6] };
        if let Some(curved) = &mut self.curved {
            let mut b = join(sub(add(v_dot, cross(w, v)), at.gravity), w_dot);
            for ((phi, omega2), q) in self.phi_r.iter().zip(&self.omega2).zip(at.q) {
                for (b, phi) in b.iter_mut().zip(phi) {
                    *b += phi * omega2 * q;
                }
            }
            let squares = [w[0] * w[0], w[1] * w[1], w[2] * w[2], w[1] * w[2], w[0] * w[2], w[0] * w[1]];
            let forces = at.q.iter().zip(at.q_ddot).zip(&self.omega2).map(|((q, q_ddot), o)| q_ddot + o * q);
            let field = [1.0].into_iter().chain(b).chain(squares).chain(forces);
            self.field.iter_mut().zip(field).for_each(|(to, value)| *to = value);
            curved.look(at);
            curved.add(&self.field, loads, lines, rows, &mut total);
        }
        for (row, phi) in rows.iter_mut().zip(&self.phi_r) {
            *row += dot_6(phi, &total);
        }
        for (to, value) in rigid.iter_mut().zip(total) {
            *to += value;
        }
    }

    /// Terms of a mass matrix that follows the deformation: adds to the rows of the shapes, returns those of A.
    fn add_inertia(&mut self, at: &Sample, rows: &mut [f64]) -> Vec6 {
        let (_, w) = split(&at.beta);
        let (v_dot, w_dot) = split(&at.beta_dot);
        let (mut moment, mut inertia, mut relative) = ([0.0; 3], [0.0; 6], [0.0; 3]);
        for ((q, s), j) in at.q.iter().zip(&self.first_moment).zip(&self.inertia) {
            moment = axpy(moment, *q, *s);
            for (sum, j) in inertia.iter_mut().zip(j) {
                *sum += q * j;
            }
        }
        let r_v = cross(w_dot, moment);
        let mut r_w = add(cross(moment, v_dot), symmetric(&inertia, w_dot));
        self.vectors.run(
            (&self.coupling, at.q, self.coupled.as_flattened_mut()),
            #[inline(always)]
            |(coupling, q, coupled)| coupling.apply(q, coupled),
        );
        let rates = at.q_dot.iter().zip(at.q_ddot);
        for ((row, n), (q_dot, q_ddot)) in rows.iter_mut().zip(&self.coupled).zip(rates) {
            *row += dot(*n, w_dot);
            r_w = axpy(r_w, *q_ddot, *n);
            relative = axpy(relative, *q_dot, *n);
        }
        r_w = add(r_w, cross(w, relative));
        join(r_v, r_w)
    }

    /// `1/2 Theta^P_ij q_i q_j` of the node of a point at the motion of [`Self::add`]: translation in A and rotation in the node frame.
    pub(super) fn curvature(&self, point: usize) -> Vec6 {
        self.curved.as_ref().map_or([0.0; 6], |curved| curved.displacement(point))
    }
}

/// `c_ilr` of shapes relative to A, without the motion of A in the modes.
struct RelativeTensor<'a> {
    m: usize,
    /// (m + 6) x (m + 6) x 6.
    c: Vec<f64>,
    phi_r: &'a [Vec6],
}

impl<'a> RelativeTensor<'a> {
    fn new(data: &ModelData, phi_r: &'a [Vec6]) -> Self {
        let m = phi_r.len();
        let n = m + 6;
        let mut c = vec![0.0; n * n * 6];
        for (((i, l), r), value) in data.c.i.iter().zip(&data.c.l).zip(&data.c.r).zip(&data.c.value) {
            if let Some(to) = c.get_mut((*i as usize * n + *l as usize) * 6 + *r as usize) {
                *to = *value;
            }
        }
        Self { m, c, phi_r }
    }

    fn c(&self, i: usize, l: usize, r: usize) -> f64 {
        self.c.get((i * (self.m + 6) + l) * 6 + r).copied().unwrap_or(0.0)
    }

    /// Row of the shape `i` relative to A: less what its motion of A does. Columns l as they are.
    fn row(&self, i: usize, l: usize, r: usize) -> f64 {
        let phi = self.phi_r.get(i).copied().unwrap_or_default();
        self.c(i, l, r) - phi.iter().enumerate().map(|(s, phi)| phi * self.c(self.m + s, l, r)).sum::<f64>()
    }

    /// `N_ki`: half the antisymmetric part of `C_SS`, which is `2 N_ki . w`.
    fn coupling(&self, i: usize, k: usize) -> Vec3 {
        let shape = |i: usize, l: usize, r: usize| {
            let phi = self.phi_r.get(l).copied().unwrap_or_default();
            let rigid: f64 = phi.iter().enumerate().map(|(s, phi)| phi * self.row(i, self.m + s, r)).sum();
            self.row(i, l, r) - rigid
        };
        core::array::from_fn(|d| 0.25 * (shape(i, k, 3 + d) - shape(k, i, 3 + d)))
    }

    /// `J_i`: `w^t C_SR w = -1/2 w^t J_i w`.
    fn inertia(&self, i: usize) -> Vec6 {
        let j =
            |d: usize, e: usize| -(self.row(i, self.m + 3 + d, 3 + e) + self.row(i, self.m + 3 + e, 3 + d));
        [j(0, 0), j(1, 1), j(2, 2), j(1, 2), j(0, 2), j(0, 1)]
    }
}

/// Product with the symmetric matrix xx, yy, zz, yz, xz, xy.
fn symmetric(j: &Vec6, x: Vec3) -> Vec3 {
    let [xx, yy, zz, yz, xz, xy] = *j;
    mul(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], x)
}
