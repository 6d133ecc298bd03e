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

mod arrangement;
mod coordinates;
mod energy;
mod evaluate;
mod gradient;
mod lanes;
mod moments;
mod solve;
mod system;

use alloc::{vec, vec::Vec};

use self::arrangement::Arrangement;
use self::coordinates::{Coordinates, Path};
use self::lanes::{Symmetric, Vectors};
use self::moments::Moments;
use crate::curve::{Curve, CurveScratch};
use crate::data::ModelData;
use crate::four::{self, Four};
use crate::math::{Mat3, Vec3, Vec6, scale};
use crate::model::Model;
use crate::polynomial::Polynomial;

pub(crate) use energy::Energies;
pub(crate) use evaluate::Accelerations;

/// Components `3 row + column` of a symmetric matrix: xx, yy, zz and xy, xz, yz with their mirror images.
const SYMMETRIC: [[usize; 2]; 6] = [[0, 0], [4, 4], [8, 8], [1, 3], [2, 6], [5, 7]];

/// Most kinetic coordinates a model may have: outputs hold them on the stack.
pub(crate) const MAX_FIELDS: usize = 512;

/// Constants of the Lagrangian.
#[derive(Clone, Debug)]
pub(crate) struct Lagrangian {
    modes: usize,
    mass: f64,
    /// `A` by places of the fields, for outputs - (places x m).
    linear: Vec<f64>,
    /// What `y` has beyond, for outputs.
    curve: Polynomial,
    coordinates: Coordinates,
    first_moment_0: Vec3,
    /// `int X_0 X_0^t`.
    second_moment_0: Mat3,
    /// Four by four.
    fields: Vec<Fields>,
    /// `S_a` once more, component by component - (3 x blocks).
    first: Vec<Four>,
    n_fields: usize,
    moments: Moments,
    /// `K` - (m rows).
    stiffness: Vec<Four>,
    self_stress: Vec<f64>,
    self_stress_curve: Curve,
    /// The same, for outputs.
    self_stress_rows: Polynomial,
}

/// Moments of four fields.
#[derive(Clone, Copy, Debug)]
struct Fields {
    /// `S_a`.
    first: Vectors,
    /// `P_a0 + P_a0^t`, of its diagonal one half.
    moment_0: Symmetric,
}

/// What an evaluation finds and needs.
#[derive(Clone, Debug)]
pub(crate) struct Scratch {
    path: Path,
    stress_curve: CurveScratch,
    stress: Vec<f64>,
    modes: usize,
    /// Amplitudes, padded.
    q: Vec<Four>,
    /// `P_a` - (blocks of fields x 9) - and the rate of `N_a` - (blocks of fields x 3).
    moment: Vec<Four>,
    turning_rate: Vec<Four>,
    /// Forces on the coordinates, and what multiplies the rates of `D` - (blocks of fields).
    forces: Vec<Four>,
    along: Vec<Four>,
    /// `N_a`, component by component - (3 x blocks of fields).
    turning: Vec<Four>,
    /// `S_a D_a` and `N_a D_a` - (6 rows).
    coupling: Vec<Four>,
    /// `S` and `int X X^t`.
    pub(crate) first_moment: Vec3,
    second_moment: Mat3,
    /// Momentum `dT/dbeta`.
    pub(crate) momentum: Vec6,
    /// `h` of the rigid rows.
    pub(crate) rigid: Vec6,
    /// `h` and the elastic forces of the relative elastic rows, padded.
    elastic: Vec<Four>,
    system: system::System,
    /// Right-hand side and solution of the system: `v`, `w`, `q`.
    solution: Vec<Four>,
}

impl Scratch {
    /// For a model; empty where it has no Lagrangian.
    pub(crate) fn new(model: &Model) -> Self {
        let lagrangian = model.lagrangian.as_ref();
        let data = model.data().lagrangian.as_ref();
        let (modes, n, l) =
            lagrangian.map_or((0, 0, 0), |it| (it.modes, it.fields.len(), it.self_stress.len()));
        let blocks = modes.div_ceil(4);
        Scratch {
            path: lagrangian.zip(data).map_or_else(Path::default, |(it, data)| it.coordinates.path(data)),
            stress_curve: CurveScratch::new(modes, l, data.iter().map(|it| &it.self_stress_curve)),
            stress: vec![0.0; l],
            modes,
            q: vec![[0.0; 4]; blocks],
            moment: vec![[0.0; 4]; 9 * n],
            turning_rate: vec![[0.0; 4]; 3 * n],
            forces: vec![[0.0; 4]; n],
            along: vec![[0.0; 4]; n],
            turning: vec![[0.0; 4]; 3 * n],
            coupling: vec![[0.0; 4]; 6 * blocks],
            first_moment: [0.0; 3],
            second_moment: [[0.0; 3]; 3],
            momentum: [0.0; 6],
            rigid: [0.0; 6],
            elastic: vec![[0.0; 4]; blocks],
            system: solve::system(modes),
            solution: vec![[0.0; 4]; (6 + modes).div_ceil(4)],
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
        let arrangement = Arrangement::new(m, lagrangian);
        let four = |block: usize, at: usize, values: &[f64], of: &dyn Fn(usize, usize) -> usize| {
            arrangement.four(block, |field| component(values, of(field, at)))
        };
        let first = |block: usize, k: usize| four(block, k, &lagrangian.first_moment, &|a, k| k * n + a);
        let fields = |block: usize| Fields {
            first: core::array::from_fn(|k| first(block, k)),
            moment_0: SYMMETRIC.map(|pair| {
                let [once, other] = pair.map(|k| four(block, k, &lagrangian.moment_0, &|a, k| 9 * a + k));
                if pair[0] == pair[1] { once } else { four::plus(once, 1.0, other) }
            }),
        };
        let blocks = arrangement.blocks();
        let places = 4 * blocks;
        let mut linear = vec![0.0; places * m];
        for (at, value) in lagrangian.linear.iter().enumerate() {
            let (field, mode) = (at / m.max(1), at % m.max(1));
            if let Some(to) = linear.get_mut(arrangement.place(field as u32) * m + mode) {
                *to = *value;
            }
        }
        let inertia: Mat3 = core::array::from_fn(|i| {
            core::array::from_fn(|j| component(&data.rigid.mass_matrix, 6 * (i + 3) + j + 3))
        });
        let self_stress = lagrangian.self_stress.clone();
        Some(Lagrangian {
            modes: m,
            mass: data.rigid.mass,
            linear,
            curve: Polynomial::new(places, &arrangement.placed(&lagrangian.curve)),
            coordinates: Coordinates::new(m, &arrangement, lagrangian),
            first_moment_0: scale(data.rigid.mass, data.rigid.centre_of_mass),
            // I = tr(J) 1 - J, and so J = tr(I)/2 1 - I.
            second_moment_0: traced(&inertia, 0.5),
            fields: (0..blocks).map(fields).collect(),
            first: (0..3)
                .flat_map(|k| (0..blocks).map(move |block| (k, block)))
                .map(|(k, b)| first(b, k))
                .collect(),
            n_fields: n,
            moments: Moments::new(&arrangement, lagrangian),
            stiffness: four::padded(m, m, |i, j| component(&lagrangian.stiffness, m * i + j)),
            self_stress_rows: Polynomial::new(self_stress.len(), &lagrangian.self_stress_curve),
            self_stress_curve: Curve::of(m, self_stress.len(), &lagrangian.self_stress_curve),
            self_stress,
        })
    }

    /// Number of kinetic coordinates, and of terms in them and in their moments.
    pub(crate) fn size(&self) -> [usize; 3] {
        [self.n_fields, self.coordinates.n_terms(), self.moments.len()]
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
