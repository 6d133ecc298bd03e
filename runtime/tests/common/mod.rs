//! Reduced models of lumped masses, derived here from Newton's law, independently of the generator.
//!
//! Masses sit at `r_a = r0_a + phi_a x` in frame A, with `x` the amplitudes of arbitrary shapes and a stiffness matrix
//! between them. The inertial acceleration of a mass, in A, is
//! `a = v_dot + w x v + w_dot x r + w x (w x r) + 2 w x r_dot + r_ddot`; its virtual work in the shapes, translations and
//! rotations of A gives the equations of theory (21), and their free-free modes the reduced ones.
#![allow(dead_code, unreachable_pub)] // every test binary uses a part of it

pub mod lagrangian;

use nalgebra::{DMatrix, DVector, Matrix3, UnitQuaternion, Vector3};
use rom_runtime::data::{
    CheckData, ModesData, PictureData, PointData, Provenance, RigidData, StationSet, TensorData,
};
use rom_runtime::{Load, LoadCase, Model, ModelData, State};

/// A point mass: kg, position in A (m), displacement per unit amplitude of every shape.
#[derive(Clone)]
pub struct Mass {
    pub mass: f64,
    pub position: Vector3<f64>,
    pub shapes: Vec<Vector3<f64>>,
}

/// Masses on shapes.
pub struct Lumped {
    pub masses: Vec<Mass>,
    /// Stiffness between shape amplitudes, N/m.
    pub stiffness: DMatrix<f64>,
    /// Critical damping ratio of every mode.
    pub damping_ratio: f64,
    /// Points on their nodes, in the axes of A, as in most structures; else all terms of the load projection act.
    pub plain_points: bool,
}

/// Reproducible numbers in (-1, 1).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.next(), self.next(), self.next())
    }

    pub fn array<const N: usize>(&mut self, scale: f64) -> [f64; N] {
        std::array::from_fn(|_| scale * self.next())
    }
}

impl Lumped {
    /// A cloud of masses on `m` random shapes, frequencies of some rad/s.
    pub fn random(m: usize, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let masses = (0..m + 5)
            .map(|_| Mass {
                mass: 1.5 + random.next(),
                position: 2.0 * random.vector() + Vector3::new(0.3, -0.2, 0.5),
                shapes: (0..m).map(|_| random.vector()).collect(),
            })
            .collect();
        let root = DMatrix::from_fn(m, m, |_, _| 3.0 * random.next());
        let stiffness = &root * root.transpose() + DMatrix::identity(m, m) * 20.0;
        Lumped { masses, stiffness, damping_ratio: 0.0, plain_points: false }
    }

    /// A rigid body of four dumbbells: mass, asymmetric inertia, centre of mass off the origin.
    pub fn rigid_body() -> Self {
        let mut masses = Vec::new();
        let centre = Vector3::new(0.2, -0.1, 0.3);
        for (axis, arm) in [(Vector3::x(), 1.0), (Vector3::y(), 2.0), (Vector3::z(), 3.0)] {
            for sign in [-1.0, 1.0] {
                masses.push(Mass { mass: 2.0, position: centre + sign * arm * axis, shapes: vec![] });
            }
        }
        Lumped { masses, stiffness: DMatrix::zeros(0, 0), damping_ratio: 0.0, plain_points: false }
    }

    /// Two-mass spring of theory: a rigid body (mass `m1`, centred on the origin) and a mass `m2` on the x axis that
    /// moves along it on a spring.
    pub fn spring(m1: f64, m2: f64, stiffness: f64) -> Self {
        let mut masses = Vec::new();
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            for sign in [-1.0, 1.0] {
                masses.push(Mass { mass: m1 / 6.0, position: sign * axis, shapes: vec![Vector3::zeros()] });
            }
        }
        masses.push(Mass { mass: m2, position: Vector3::new(3.0, 0.0, 0.0), shapes: vec![Vector3::x()] });
        Lumped {
            masses,
            stiffness: DMatrix::from_element(1, 1, stiffness),
            damping_ratio: 0.0,
            plain_points: false,
        }
    }

    /// The published U-shaped frame as a chain of masses on `m` smooth shapes, a quarter of them in each of its four
    /// symmetry classes: tensors as sparse as those of the real one.
    pub fn frame(m: usize) -> Self {
        let n = 121;
        let mut masses = Vec::new();
        for i in 0..n {
            let s = 30.0 * i as f64 / (n - 1) as f64 - 15.0;
            let position = if s.abs() <= 10.0 {
                Vector3::new(s, 0.0, 0.0)
            } else {
                Vector3::new(10.0 * s.signum(), 0.0, s.abs() - 10.0)
            };
            let shapes = (0..m).map(|shape| frame_shape(shape, s)).collect();
            masses.push(Mass { mass: 405.0 / n as f64, position, shapes });
        }
        let stiffness = DMatrix::from_fn(m, m, |i, j| {
            let order = (i / 4 + 1) as f64;
            if i == j { 405.0 * 40.0 * order.powi(4) * (1.0 + 0.3 * (i % 4) as f64) } else { 0.0 }
        });
        Lumped { masses, stiffness, damping_ratio: 0.0, plain_points: true }
    }

    pub fn n_shapes(&self) -> usize {
        self.stiffness.nrows()
    }

    /// `M_RR`, rows v then w.
    pub fn rigid_mass(&self) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(6, 6);
        for mass in &self.masses {
            let jacobian = rigid_jacobian(&mass.position);
            matrix += mass.mass * jacobian.transpose() * jacobian;
        }
        matrix
    }

    /// Modes: omega, `Phi_S`, `Phi_R`.
    pub fn modes(&self) -> (Vec<f64>, DMatrix<f64>, DMatrix<f64>) {
        let m = self.n_shapes();
        if m == 0 {
            return (Vec::new(), DMatrix::zeros(0, 0), DMatrix::zeros(6, 0));
        }
        let (mut mss, mut mrs) = (DMatrix::zeros(m, m), DMatrix::zeros(6, m));
        for mass in &self.masses {
            let shapes = DMatrix::from_fn(3, m, |row, column| mass.shapes[column][row]);
            mss += mass.mass * shapes.transpose() * &shapes;
            mrs += mass.mass * rigid_jacobian(&mass.position).transpose() * shapes;
        }
        // Free-free: the rigid motions follow so that their momenta vanish.
        let follow = -self.rigid_mass().lu().solve(&mrs).unwrap();
        let effective = &mss + mrs.transpose() * &follow;
        let effective = 0.5 * (&effective + effective.transpose());
        let lower = effective.cholesky().unwrap().l();
        let half = lower.clone().lu().solve(&self.stiffness).unwrap();
        let reduced = lower.clone().lu().solve(&half.transpose()).unwrap();
        let eigen = (0.5 * (&reduced + reduced.transpose())).symmetric_eigen();
        let mut order: Vec<usize> = (0..m).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let vectors = DMatrix::from_fn(m, m, |row, column| eigen.eigenvectors[(row, order[column])]);
        let phi_s = lower.transpose().lu().solve(&vectors).unwrap();
        let phi_r = follow * &phi_s;
        (order.iter().map(|&i| eigen.eigenvalues[i].sqrt()).collect(), phi_s, phi_r)
    }

    /// Everything a model file holds. Every mass becomes a point ("P0", "P1", ...) with a made-up rotation.
    pub fn data(&self, seed: u64) -> ModelData {
        let m = self.n_shapes();
        let (omega, phi_s, phi_r) = self.modes();
        let rigid_mass = self.rigid_mass();
        let mass: f64 = rigid_mass[(0, 0)];
        let centre = self.masses.iter().map(|a| a.mass * a.position).sum::<Vector3<f64>>() / mass;
        let shape =
            |a: &Mass, mode: usize| -> Vector3<f64> { (0..m).map(|j| a.shapes[j] * phi_s[(j, mode)]).sum() };
        let first_moment = (0..m)
            .map(|mode| self.masses.iter().map(|a| a.mass * shape(a, mode)).sum::<Vector3<f64>>())
            .collect::<Vec<_>>();
        let mut random = Random::new(seed);
        let points = self.masses.iter().enumerate().map(|(index, a)| {
            let translation: Vec<_> = (0..m).map(|mode| shape(a, mode)).collect();
            let rotation: Vec<_> = (0..m).map(|_| 0.3 * random.vector()).collect();
            let plain = if self.plain_points { 0.0 } else { 1.0 };
            let turn = nalgebra::UnitQuaternion::from_scaled_axis(plain * random.vector());
            PointData {
                name: format!("P{index}"),
                node_position: a.position.into(),
                node_rotation: [turn.w, turn.i, turn.j, turn.k],
                offset: random.array(0.5 * plain),
                phi_translation: row_major(&translation),
                phi_rotation: row_major(&rotation),
                sections: vec![("member".into(), rotation_rows(&random.vector()))],
            }
        });
        let points = points.collect();
        let (c, k) = self.tensors(&phi_s, &phi_r);
        ModelData {
            provenance: Provenance {
                name: "lumped".into(),
                generator: "test".into(),
                input_text: "masses = [1, 2]\n".into(),
                input_sha256: "0".repeat(64),
                options: vec![("--modes".into(), m.to_string())],
                parameters: vec![("sigma".into(), 10.0)],
                n_elements: self.masses.len() as u64,
                n_dof: (m + 6) as u64,
            },
            rigid: RigidData {
                mass,
                centre_of_mass: centre.into(),
                mass_matrix: rigid_mass.transpose().as_slice().to_vec(),
                initial_position: [0.0; 3],
            },
            modes: ModesData {
                number: (1..=m as u32).collect(),
                mass: vec![1.0; m],
                damping_ratio: vec![self.damping_ratio; m],
                phi_r: phi_r.transpose().as_slice().to_vec(),
                first_moment: row_major(&first_moment),
                kinetic_share: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0].repeat(m),
                next_omega: omega.last().map(|last| 2.0 * last),
                omega,
            },
            c,
            k,
            points,
            load_cases: vec![],
            trim: None,
            sensors: vec![],
            lines: vec![],
            stations: vec![],
            cuts: vec![],
            gravity: None,
            residual: None,
            validity: None,
            selection: None,
            lagrangian: None,
            damping: None,
            clamped: None,
            picture_curve: None,
            picture: Some(PictureData {
                positions: self.masses.iter().flat_map(|a| a.position.iter().copied()).collect(),
                phi_translation: self
                    .masses
                    .iter()
                    .flat_map(|a| row_major(&(0..m).map(|mode| shape(a, mode)).collect::<Vec<_>>()))
                    .collect(),
                lines: vec![(0..self.masses.len() as u32).collect()],
            }),
            checks: vec![CheckData { name: "mass".into(), value: 0.0, limit: 1e-12 }],
        }
    }

    fn tensors(&self, phi_s: &DMatrix<f64>, phi_r: &DMatrix<f64>) -> (TensorData, TensorData) {
        let m = self.n_shapes();
        let unit = |r: usize| {
            let mut e = [0.0; 6];
            e[r] = 1.0;
            (Vector3::new(e[0], e[1], e[2]), Vector3::new(e[3], e[4], e[5]))
        };
        let project = |structural: DVector<f64>, rigid: DVector<f64>| -> DVector<f64> {
            let elastic = phi_s.transpose() * structural + phi_r.transpose() * &rigid;
            DVector::from_iterator(m + 6, elastic.iter().chain(rigid.iter()).copied())
        };
        let mut c = Entries::default();
        for l in 0..m + 6 {
            let (x_dot, beta_l) = if l < m {
                let beta = phi_r.column(l);
                (
                    phi_s.column(l).into_owned(),
                    (beta.fixed_rows::<3>(0).into(), beta.fixed_rows::<3>(3).into()),
                )
            } else {
                (DVector::zeros(m), unit(l - m))
            };
            for r in 0..6 {
                let (structural, rigid) = self.gyroscopic(&x_dot, beta_l, unit(r));
                c.add(&project(structural, rigid), l, r);
            }
        }
        let mut k = Entries::default();
        for l in 0..m {
            let x = phi_s.column(l).into_owned();
            for r in 0..6 {
                for s in r..6 {
                    let one = |r, s| {
                        let (structural, rigid) = self.gyroscopic_stiffness(&x, unit(r), unit(s));
                        project(structural, rigid)
                    };
                    let both = if r == s { one(r, r) } else { one(r, s) + one(s, r) };
                    k.add(&both, l, 6 * r + s);
                }
            }
        }
        (c.tensor(), k.tensor())
    }

    /// Terms with a velocity `(x_dot, beta_l)` and the velocity `beta_r`, structural and rigid rows.
    fn gyroscopic(
        &self,
        x_dot: &DVector<f64>,
        (v_l, w_l): (Vector3<f64>, Vector3<f64>),
        (_, w_r): (Vector3<f64>, Vector3<f64>),
    ) -> (DVector<f64>, DVector<f64>) {
        self.sum(|mass, r0| {
            let d_dot: Vector3<f64> = mass.shapes.iter().zip(x_dot.iter()).map(|(phi, x)| phi * *x).sum();
            let a = w_r.cross(&w_l.cross(r0)) + w_r.cross(&v_l) + 2.0 * w_r.cross(&d_dot);
            (a, r0.cross(&a))
        })
    }

    /// Terms with a displacement `x` and the velocities `beta_r`, `beta_s`.
    fn gyroscopic_stiffness(
        &self,
        x: &DVector<f64>,
        (_, w_r): (Vector3<f64>, Vector3<f64>),
        (v_s, w_s): (Vector3<f64>, Vector3<f64>),
    ) -> (DVector<f64>, DVector<f64>) {
        self.sum(|mass, r0| {
            let d: Vector3<f64> = mass.shapes.iter().zip(x.iter()).map(|(phi, x)| phi * *x).sum();
            let a = w_r.cross(&w_s.cross(&d));
            let undeformed = w_r.cross(&w_s.cross(r0)) + w_r.cross(&v_s);
            (a, r0.cross(&a) + d.cross(&undeformed))
        })
    }

    fn sum(
        &self,
        terms: impl Fn(&Mass, &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>),
    ) -> (DVector<f64>, DVector<f64>) {
        let (mut structural, mut rigid) = (DVector::zeros(self.n_shapes()), DVector::zeros(6));
        for mass in &self.masses {
            let (a, moment) = terms(mass, &mass.position);
            for (row, phi) in structural.iter_mut().zip(&mass.shapes) {
                *row += mass.mass * phi.dot(&a);
            }
            for row in 0..3 {
                rigid[row] += mass.mass * a[row];
                rigid[3 + row] += mass.mass * moment[row];
            }
        }
        (structural, rigid)
    }
}

/// In-plane symmetric, in-plane antisymmetric, out-of-plane symmetric and antisymmetric shapes along the arc length:
/// even and odd Legendre polynomials, which stay independent however many there are.
fn frame_shape(shape: usize, s: f64) -> Vector3<f64> {
    let order = shape / 4 + 1;
    let (even, odd) = (legendre(2 * order, s / 15.0), legendre(2 * order + 1, s / 15.0));
    // On the arms the in-plane bending is along x.
    let across = |value: f64| {
        if s.abs() <= 10.0 {
            Vector3::new(0.0, 0.0, value)
        } else {
            Vector3::new(value * s.signum(), 0.0, 0.3 * value)
        }
    };
    match shape % 4 {
        0 => across(even),
        1 => across(odd),
        2 => Vector3::new(0.0, even, 0.0),
        _ => Vector3::new(0.0, odd, 0.0),
    }
}

fn legendre(degree: usize, x: f64) -> f64 {
    let (mut before, mut now) = (1.0, x);
    for n in 1..degree {
        (before, now) = (now, ((2 * n + 1) as f64 * x * now - n as f64 * before) / (n + 1) as f64);
    }
    now
}

/// Velocity of a point of A per unit (v, w).
fn rigid_jacobian(position: &Vector3<f64>) -> DMatrix<f64> {
    let mut jacobian = DMatrix::zeros(3, 6);
    jacobian.view_mut((0, 0), (3, 3)).copy_from(&Matrix3::identity());
    jacobian.view_mut((0, 3), (3, 3)).copy_from(&-position.cross_matrix());
    jacobian
}

/// Row-major (3 x m) from columns.
fn row_major(columns: &[Vector3<f64>]) -> Vec<f64> {
    (0..3).flat_map(|row| columns.iter().map(move |column| column[row])).collect()
}

/// Sections that move as points do.
pub fn sections_at(points: &[PointData]) -> StationSet {
    let mut sections = StationSet::default();
    for point in points {
        sections.position.extend(point.node_position);
        sections.rotation.extend(point.node_rotation);
        sections.phi_translation.extend(&point.phi_translation);
        sections.phi_rotation.extend(&point.phi_rotation);
    }
    sections
}

/// Loads for a second.
pub fn case(loads: Vec<Load>) -> LoadCase {
    LoadCase { dt: 0.01, loads, ..LoadCase::empty("test") }
}

/// Deformed, turned, displaced and in motion.
pub fn random_state(model: &Model, random: &mut Random) -> State {
    let mut state = State::at_rest(model);
    state.q.iter_mut().for_each(|q| *q = 0.4 * random.next());
    state.q_dot.iter_mut().for_each(|q| *q = random.next());
    state.beta_star = random.array(1.5);
    let attitude = UnitQuaternion::from_scaled_axis(2.0 * random.vector());
    state.attitude = [attitude.w, attitude.i, attitude.j, attitude.k];
    state.position = random.array(10.0);
    state
}

/// Rows of a rotation matrix.
pub fn rotation_rows(axis: &Vector3<f64>) -> [[f64; 3]; 3] {
    let matrix = nalgebra::Rotation3::from_scaled_axis(*axis);
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]))
}

#[derive(Default)]
struct Entries(Vec<(u32, u32, u32, f64)>);

impl Entries {
    fn add(&mut self, rows: &DVector<f64>, l: usize, r: usize) {
        self.0.extend(rows.iter().enumerate().map(|(i, &value)| (i as u32, l as u32, r as u32, value)));
    }

    fn tensor(mut self) -> TensorData {
        let largest = self.0.iter().fold(0.0_f64, |largest, entry| largest.max(entry.3.abs()));
        let threshold = 1e-11 * largest;
        let before = self.0.len();
        self.0.retain(|entry| entry.3.abs() > threshold);
        self.0.sort_by_key(|&(i, l, r, _)| (i, l, r));
        TensorData {
            i: self.0.iter().map(|entry| entry.0).collect(),
            l: self.0.iter().map(|entry| entry.1).collect(),
            r: self.0.iter().map(|entry| entry.2).collect(),
            value: self.0.iter().map(|entry| entry.3).collect(),
            threshold,
            scale: "1e-11 of the largest entry".into(),
            dropped_norm: 0.0,
            dropped_count: (before - self.0.len()) as u64,
        }
    }
}
