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

mod coordinates;
mod energy;
mod evaluate;
mod gradient;
mod moments;
mod solve;
mod system;

use alloc::{vec, vec::Vec};

use self::coordinates::{Coordinates, Path};
use self::moments::Moments;
use crate::curve::{Curve, CurveScratch};
use crate::data::ModelData;
use crate::four::{self, Four};
use crate::math::{Mat3, Vec3, Vec6, dot, scale};
use crate::polynomial::Polynomial;

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
    /// What `y` has beyond, for outputs.
    curve: Polynomial,
    coordinates: Coordinates,
    first_moment_0: Vec3,
    /// `int X_0 X_0^t`.
    second_moment_0: Mat3,
    fields: Vec<Field>,
    moments: Moments,
    /// `K` - (m rows).
    stiffness: Vec<Four>,
    self_stress: Vec<f64>,
    self_stress_curve: Curve,
    /// The same, for outputs.
    self_stress_rows: Polynomial,
}

/// Moments of a field.
#[derive(Clone, Copy, Debug)]
struct Field {
    /// `S_a`.
    first: Vec3,
    /// `P_a0`, by rows.
    moment_0: [f64; 9],
}

/// What an evaluation finds and needs.
#[derive(Clone, Debug)]
pub(crate) struct Scratch {
    path: Path,
    stress_curve: CurveScratch,
    stress: Vec<f64>,
    /// `(S_a, N_a)`, padded - (n).
    maps: Vec<[Four; 2]>,
    /// `S_a D_a` and `N_a D_a` - (6 rows).
    coupling: Vec<Four>,
    /// `S`, its rate, `int X X^t`.
    pub(crate) first_moment: Vec3,
    second_moment: Mat3,
    /// Momentum `dT/dbeta`.
    pub(crate) momentum: Vec6,
    /// `h` of the rigid rows.
    pub(crate) rigid: Vec6,
    /// `h` and the elastic forces of the relative elastic rows, padded.
    elastic: Vec<Four>,
    system: system::System,
    /// Right-hand side and solution of the system, blocks of `v`, `w`, `q`.
    solution: Vec<Four>,
}

impl Scratch {
    /// For a model; empty without a Lagrangian.
    pub(crate) fn new(lagrangian: Option<&Lagrangian>) -> Self {
        let (m, n, l) = lagrangian.map_or((0, 0, 0), |it| (it.modes, it.fields.len(), it.self_stress.len()));
        let blocks = m.div_ceil(4);
        Scratch {
            path: lagrangian.map_or_else(Path::default, |it| it.coordinates.path()),
            stress_curve: lagrangian
                .map_or_else(CurveScratch::default, |it| CurveScratch::new(it.self_stress_curve.products())),
            stress: vec![0.0; l],
            maps: vec![[[0.0; 4]; 2]; n],
            coupling: vec![[0.0; 4]; 6 * blocks],
            first_moment: [0.0; 3],
            second_moment: [[0.0; 3]; 3],
            momentum: [0.0; 6],
            rigid: [0.0; 6],
            elastic: vec![[0.0; 4]; blocks],
            system: solve::system(m),
            solution: vec![[0.0; 4]; solve::RIGID + blocks],
        }
    }

    /// `h` and the elastic forces of the relative elastic rows; zeros follow.
    pub(crate) fn elastic(&self) -> &[f64] {
        self.elastic.as_flattened()
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
        let inertia: Mat3 = core::array::from_fn(|i| {
            core::array::from_fn(|j| component(&data.rigid.mass_matrix, 6 * (i + 3) + j + 3))
        });
        let self_stress = lagrangian.self_stress.clone();
        Some(Lagrangian {
            modes: m,
            mass: data.rigid.mass,
            linear: lagrangian.linear.clone(),
            curve: Polynomial::new(n, &lagrangian.curve),
            coordinates: Coordinates::new(m, lagrangian),
            first_moment_0: scale(data.rigid.mass, data.rigid.centre_of_mass),
            // I = tr(J) 1 - J, and so J = tr(I)/2 1 - I.
            second_moment_0: traced(&inertia, 0.5),
            fields: (0..n).map(field).collect(),
            moments: Moments::new(n, &lagrangian.moment),
            stiffness: four::padded(m, m, |i, j| component(&lagrangian.stiffness, m * i + j)),
            self_stress_rows: Polynomial::new(self_stress.len(), &lagrangian.self_stress_curve),
            self_stress_curve: Curve::of(m, self_stress.len(), &lagrangian.self_stress_curve),
            self_stress,
        })
    }

    /// Number of kinetic coordinates, and of terms in them and in their moments.
    pub(crate) fn size(&self) -> [usize; 3] {
        [self.fields.len(), self.coordinates.n_terms(), self.moments.len()]
    }

    /// `g_v C + g_x K` - (m rows), with the diagonal of C.
    pub(crate) fn gains(&self, damping: impl Fn(usize) -> f64, g_v: f64, g_x: f64) -> Vec<Four> {
        let blocks = self.modes.div_ceil(4);
        four::padded(self.modes, self.modes, |i, j| {
            let stiffness = self.stiffness.get(i * blocks + j / 4).and_then(|four| four.get(j % 4)).copied();
            g_x * stiffness.unwrap_or(0.0) + if i == j { g_v * damping(i) } else { 0.0 }
        })
    }
}

/// `factor tr(a) 1 - a`.
#[inline(always)]
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
#[inline(always)]
fn turned(p: &[f64; 9]) -> Vec3 {
    [p[7] - p[5], p[2] - p[6], p[3] - p[1]]
}

#[inline(always)]
fn transposed(p: &[f64; 9]) -> [f64; 9] {
    [p[0], p[3], p[6], p[1], p[4], p[7], p[2], p[5], p[8]]
}

#[inline(always)]
fn trace(p: &[f64; 9]) -> f64 {
    p[0] + p[4] + p[8]
}

#[inline(always)]
fn product(p: &[f64; 9], w: Vec3) -> Vec3 {
    [dot([p[0], p[1], p[2]], w), dot([p[3], p[4], p[5]], w), dot([p[6], p[7], p[8]], w)]
}
