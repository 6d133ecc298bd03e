//! The defect against Newton's law of a cloud of masses, its propagation against exact answers.

use std::sync::Arc;

use nalgebra::Vector3;

use super::defect::NodeLoad;
use super::*;
use crate::common::{Lumped, Random};
use crate::data::{MissingData, ModelData, ValidityData};
use crate::{Settings, Simulation};

/// Masses whose shapes bend: second derivatives `theta[mass][pair]` of their positions.
struct Bent {
    masses: Vec<(f64, Vector3<f64>)>,
    /// Modal shapes - (masses of m).
    phi: Vec<Vec<Vector3<f64>>>,
    theta: Vec<Vec<Vector3<f64>>>,
    m: usize,
}

impl Bent {
    fn new(lumped: &Lumped, data: &ModelData, random: &mut Random) -> Self {
        let m = data.modes.omega.len();
        let column = |rows: &[f64], j: usize| Vector3::new(rows[j], rows[m + j], rows[2 * m + j]);
        let phi = data.points.iter().map(|p| (0..m).map(|j| column(&p.phi_translation, j)).collect());
        let pairs = m * (m + 1) / 2;
        Self {
            masses: lumped.masses.iter().map(|a| (a.mass, a.position)).collect(),
            phi: phi.collect(),
            theta: lumped.masses.iter().map(|_| (0..pairs).map(|_| random.vector()).collect()).collect(),
            m,
        }
    }

    fn validity(&self) -> ValidityData {
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let mut fields = Vec::new();
        for pair in 0..self.theta[0].len() {
            let sum = |field: &dyn Fn(usize) -> Vector3<f64>| -> f64 {
                (0..self.masses.len()).map(|a| self.masses[a].0 * self.theta[a][pair].dot(&field(a))).sum()
            };
            fields.push(0.0);
            fields.extend(axes.map(|e| sum(&|_| e)));
            fields.extend(axes.map(|e| sum(&|a| e.cross(&self.masses[a].1))));
            for (r, s) in [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)] {
                let spin = |r: usize, s: usize, a: usize| axes[r].cross(&axes[s].cross(&self.masses[a].1));
                fields.push(sum(&|a| if r == s { spin(r, r, a) } else { spin(r, s, a) + spin(s, r, a) }));
            }
            fields.extend((0..self.m).map(|k| sum(&|a| self.phi[a][k])));
        }
        let points = self.theta.iter().map(|theta| {
            (0..6).flat_map(|k| theta.iter().map(move |t| if k < 3 { t[k] } else { 0.0 })).collect()
        });
        ValidityData {
            modes: self.m as u32,
            fields,
            points: points.collect(),
            amplitude: vec![0.1; 2 * self.m],
            stiffening: vec![0.0; 3 * self.m],
            missing: MissingData::default(),
        }
    }

    fn pair(&self, i: usize, j: usize) -> usize {
        let (i, j) = (i.min(j), i.max(j));
        (0..i).map(|k| self.m - k).sum::<usize>() + j - i
    }
}

fn vector(a: Vec3) -> Vector3<f64> {
    Vector3::from(a)
}

/// What is left out, mass by mass from its acceleration: `w_dot x d` everywhere, the lever `d` of the inertia forces, and everything
/// that works on the curvature of the shapes.
#[test]
fn the_defect_is_what_the_masses_feel() {
    let mut random = Random::new(5);
    let lumped = Lumped::random(3, 8);
    let mut data = lumped.data(3);
    let bent = Bent::new(&lumped, &data, &mut random);
    data.validity = Some(bent.validity());
    let model = Model::new(data).unwrap();
    let m = bent.m;
    let [q, q_dot, q_ddot]: [[f64; 3]; 3] = [random.array(0.3), random.array(1.0), random.array(2.0)];
    let at = Sample {
        q: &q,
        q_dot: &q_dot,
        q_ddot: &q_ddot,
        beta: random.array(1.0),
        beta_dot: random.array(1.0),
        gravity: random.array(3.0),
    };
    let load = NodeLoad { point: 2, force: random.array(4.0), moment: [0.0; 3], applied: Default::default() };
    let mut found = vec![0.0; m + 6];
    Defect::new(&model).add(&at, &[load], &[], true, &mut found);

    let ((v, w), (v_dot, w_dot)) = (split(&at.beta), split(&at.beta_dot));
    let (v, w, v_dot, w_dot, g) = (vector(v), vector(w), vector(v_dot), vector(w_dot), vector(at.gravity));
    let (mut force, mut moment, mut rows) = (Vector3::zeros(), Vector3::zeros(), vec![0.0; m]);
    let mut relative = Vector3::zeros();
    for (a, (mass, r0)) in bent.masses.iter().enumerate() {
        let combine =
            |x: &[f64]| -> Vector3<f64> { bent.phi[a].iter().zip(x).map(|(phi, x)| phi * *x).sum() };
        let (d, d_dot, d_ddot) = (combine(&q), combine(&q_dot), combine(&q_ddot));
        let mut bend_ddot = Vector3::zeros();
        for i in 0..m {
            for j in 0..m {
                bend_ddot += bent.theta[a][bent.pair(i, j)] * (q_dot[i] * q_dot[j] + q[i] * q_ddot[j]);
            }
        }
        force += (w_dot.cross(&d) + bend_ddot) * *mass;
        moment += (r0.cross(&w_dot.cross(&d))
            + d.cross(&(v_dot + w_dot.cross(r0)))
            + d.cross(&d_ddot)
            + r0.cross(&bend_ddot))
            * *mass;
        relative += d.cross(&d_dot) * *mass;
        // Kstif phi_k = omega^2 m (phi_k + phi_v + phi_w x r0) of a free-free mode.
        let elastic: Vector3<f64> = (0..m)
            .map(|k| {
                let (t, turn) = split(&model.phi_r[k]);
                (bent.phi[a][k] + vector(t) + vector(turn).cross(r0)) * (model.elastic[k].stiffness * q[k])
            })
            .sum();
        let felt = v_dot + w.cross(&v) - g + w_dot.cross(r0) + w.cross(&w.cross(r0)) + d_ddot + elastic;
        for i in 0..m {
            rows[i] += mass * bent.phi[a][i].dot(&w_dot.cross(&d));
            for j in 0..m {
                rows[i] += q[j] * mass * bent.theta[a][bent.pair(i, j)].dot(&felt);
            }
        }
    }
    moment += w.cross(&relative);
    let f = vector(load.force);
    for i in 0..m {
        for j in 0..m {
            let theta = bent.theta[2][bent.pair(i, j)];
            rows[i] -= q[j] * theta.dot(&f);
            moment -= (theta * (0.5 * q[i] * q[j])).cross(&f);
        }
    }
    for i in 0..m {
        let (t, turn) = split(&model.phi_r[i]);
        rows[i] += vector(t).dot(&force) + vector(turn).dot(&moment);
    }
    let expected: Vec<f64> =
        rows.into_iter().chain(force.iter().copied()).chain(moment.iter().copied()).collect();
    let scale = expected.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    for (row, (found, expected)) in found.iter().zip(&expected).enumerate() {
        assert!((found - expected).abs() < 1e-11 * scale, "row {row}: {found} {expected}");
    }
}

/// The equations of a rigid body leave nothing out, whatever its motion.
#[test]
fn a_rigid_body_has_no_error() {
    let model = Arc::new(Model::new(Lumped::rigid_body().data(1)).unwrap());
    let mut simulation =
        Simulation::new(model.clone(), Settings { dt: 0.01, ..Settings::default() }).unwrap();
    simulation.watch_errors(4);
    let mut state = simulation.state().clone();
    state.beta_star = [1.0, 0.2, -0.3, 0.5, -1.0, 0.7];
    simulation.restore(&state).unwrap();
    let loads = model.no_loads();
    for _ in 0..100 {
        simulation.step(&loads).unwrap();
    }
    let estimate = simulation.error_estimate().unwrap();
    assert!(estimate.indicator() < 1e-12 && !estimate.out_of_range(), "{estimate:?}");
}

/// Looking on changes nothing: the same bits with and without, for every integrator.
#[test]
fn watching_does_not_disturb() {
    let model = Arc::new(Model::new(Lumped::random(4, 3).data(2)).unwrap());
    for integrator in crate::Integrator::of(&model) {
        let settings = Settings { dt: 0.01, integrator, ..Settings::default() };
        let mut watched = Simulation::new(model.clone(), settings).unwrap();
        let mut plain = watched.clone();
        watched.watch_errors(3);
        let mut state = plain.state().clone();
        state.q.fill(0.1);
        state.beta_star = [0.3, 0.2, -0.3, 0.5, -1.0, 0.7];
        state.accelerations_known = false;
        watched.restore(&state).unwrap();
        plain.restore(&state).unwrap();
        let loads = model.no_loads();
        for _ in 0..50 {
            watched.step(&loads).unwrap();
            plain.step(&loads).unwrap();
        }
        assert_eq!(watched.state().q, plain.state().q, "{integrator}");
        assert_eq!(watched.state().attitude, plain.state().attitude, "{integrator}");
        assert!(watched.error_estimate().unwrap().indicator() > 0.0);
        assert!(plain.error_estimate().is_none());
    }
}
