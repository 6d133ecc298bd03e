//! Lumped masses whose places are polynomials of the amplitudes, and the Lagrangian of a model file for them: the fields by factors of
//! Cholesky, nothing left out.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rom_runtime::ModelData;
use rom_runtime::data::{ClampedData, LagrangianData, PictureCurveData, PolynomialData, TensorData};

use super::{Lumped, Random};

/// Masses at `X_0 + phi_i q_i + psi q_0 q_1 + chi q_0^2 q_2`, in A.
pub struct Bent {
    pub mass: Vec<f64>,
    pub rest: Vec<Vector3<f64>>,
    /// Shapes relative to A - (masses of m).
    pub phi: Vec<Vec<Vector3<f64>>>,
    pub psi: Vec<Vector3<f64>>,
    pub chi: Vec<Vector3<f64>>,
}

/// Three modes, or more, and the model file of them: flying, or clamped with the same shapes.
pub fn bent(clamped: bool) -> (Bent, ModelData) {
    let lumped = Lumped::random(3, 11);
    let mut data = lumped.data(11);
    let (_, phi_s, _) = lumped.modes();
    let shape = |shapes: &[Vector3<f64>]| -> Vec<Vector3<f64>> {
        (0..3).map(|mode| (0..3).map(|j| shapes[j] * phi_s[(j, mode)]).sum()).collect()
    };
    let mut random = Random::new(5);
    let mut vectors = |size: f64| lumped.masses.iter().map(|_| size * random.vector()).collect::<Vec<_>>();
    let bent = Bent {
        mass: lumped.masses.iter().map(|it| it.mass).collect(),
        rest: lumped.masses.iter().map(|it| it.position).collect(),
        phi: lumped.masses.iter().map(|it| shape(&it.shapes)).collect(),
        psi: vectors(0.2),
        chi: vectors(0.1),
    };
    let momentum = |column: usize| {
        let mut sums = [Vector3::zeros(); 2];
        for ((mass, place), phi) in bent.mass.iter().zip(&bent.rest).zip(&bent.phi) {
            sums[0] += *mass * phi[column];
            sums[1] += *mass * place.cross(&phi[column]);
        }
        sums
    };
    if clamped {
        let columns: Vec<_> = (0..3).map(momentum).collect();
        let entry = |row: usize, column: usize| columns[column][row / 3][row % 3];
        data.modes.phi_r.fill(0.0);
        let participation = (0..6).flat_map(|row| (0..3).map(move |column| (row, column)));
        data.clamped = Some(ClampedData {
            participation: participation.map(|(row, column)| entry(row, column)).collect(),
        });
    }
    data.lagrangian = Some(bent.lagrangian(&data));
    let nodes = data.picture.as_ref().unwrap().positions.len() / 3;
    data.picture_curve = Some(PictureCurveData {
        shapes: (0..6 * nodes).map(|k| 0.01 * k as f64).collect(),
        curve: PolynomialData { quadratic: vec![(0, [0, 1], 1.0)], cubic: vec![(1, [0, 0, 2], 1.0)] },
    });
    (bent, data)
}

impl Bent {
    /// `X`, `D_i = dX/dq_i` and the second derivative along the rates, of one mass.
    pub fn at(&self, k: usize, q: &[f64], rate: &[f64]) -> (Vector3<f64>, [Vector3<f64>; 3], Vector3<f64>) {
        let (phi, psi, chi) = (&self.phi[k], self.psi[k], self.chi[k]);
        let straight: Vector3<f64> = (0..3).map(|i| phi[i] * q[i]).sum();
        let place = self.rest[k] + straight + psi * q[0] * q[1] + chi * q[0] * q[0] * q[2];
        let d =
            [phi[0] + psi * q[1] + 2.0 * chi * q[0] * q[2], phi[1] + psi * q[0], phi[2] + chi * q[0] * q[0]];
        let second = 2.0 * psi * rate[0] * rate[1]
            + chi * (2.0 * rate[0] * rate[0] * q[2] + 4.0 * q[0] * rate[0] * rate[2]);
        (place, d, second)
    }

    fn lagrangian(&self, data: &ModelData) -> LagrangianData {
        let (m, n, masses) = (3, 5, self.mass.len());
        // Columns scaled by the roots of the masses: their products are those of the kinetic energy.
        let column = |k: usize, a: usize| match a {
            0..3 => self.phi[k][a],
            3 => self.psi[k],
            _ => self.chi[k],
        };
        let columns =
            DMatrix::from_fn(3 * masses, n, |row, a| self.mass[row / 3].sqrt() * column(row / 3, a)[row % 3]);
        let upper = (columns.transpose() * &columns).cholesky().unwrap().l().transpose();
        let unit = &columns * upper.clone().try_inverse().unwrap();
        let field =
            |k: usize, a: usize| Vector3::from_fn(|row, _| unit[(3 * k + row, a)]) / self.mass[k].sqrt();
        let sum = |f: &dyn Fn(usize) -> Matrix3<f64>| {
            (0..masses).map(|k| self.mass[k] * f(k)).sum::<Matrix3<f64>>()
        };
        let first: Vec<Vector3<f64>> =
            (0..n).map(|a| (0..masses).map(|k| self.mass[k] * field(k, a)).sum()).collect();
        let by_rows = |it: Matrix3<f64>| it.transpose().as_slice().to_vec();
        let mut moment = TensorData {
            i: vec![],
            l: vec![],
            r: vec![],
            value: vec![],
            threshold: 0.0,
            scale: "largest".into(),
            dropped_norm: 0.0,
            dropped_count: 0,
        };
        for a in 0..n {
            for b in 0..n {
                // The same products in either order, so that mirror images are the same to the bit.
                let p = sum(&|k| field(k, a.min(b)) * field(k, a.max(b)).transpose());
                let p = if a <= b { p } else { p.transpose() };
                let p = if a == b { 0.5 * (p + p.transpose()) } else { p };
                for (component, value) in by_rows(p).into_iter().enumerate() {
                    moment.i.push(a as u32);
                    moment.l.push(b as u32);
                    moment.r.push(component as u32);
                    moment.value.push(value);
                }
            }
        }
        let omega: DVector<f64> = data.modes.omega.iter().map(|w| w * w).collect::<Vec<_>>().into();
        let of_point = |k: usize| PolynomialData {
            quadratic: (0..3).map(|row| (row as u32, [0, 1], self.psi[k][row])).collect(),
            cubic: (0..3).map(|row| (row as u32, [0, 0, 2], self.chi[k][row])).collect(),
        };
        LagrangianData {
            geometric: true,
            fields: n as u32,
            linear: (0..m).flat_map(|a| (0..m).map(move |i| (a, i))).map(|at| upper[at]).collect(),
            curve: PolynomialData {
                quadratic: (0..4).map(|a| (a as u32, [0, 1], upper[(a, 3)])).collect(),
                cubic: (0..5).map(|a| (a as u32, [0, 0, 2], upper[(a, 4)])).collect(),
            },
            first_moment: (0..3).flat_map(|row| first.iter().map(move |s| s[row])).collect(),
            moment_0: (0..n)
                .flat_map(|a| by_rows(sum(&|k| field(k, a) * self.rest[k].transpose())))
                .collect(),
            moment,
            stiffness: DMatrix::from_diagonal(&omega).as_slice().to_vec(),
            self_stress: vec![0.3],
            self_stress_curve: PolynomialData {
                quadratic: vec![(0, [1, 1], 2.0), (0, [1, 2], -1.0)],
                cubic: vec![(0, [0, 0, 1], 1.5)],
            },
            points: (0..masses).map(of_point).collect(),
            range: vec![0.5; m],
            tolerance: 0.0,
            dropped_norm: 0.0,
        }
    }
}
