//! The defect against Newton's law of a cloud of masses, its propagation against exact answers.

use std::sync::Arc;

use nalgebra::Vector3;

use super::defect::NodeLoad;
use super::instant::Instant;
use super::manifold::Manifold;
use super::missing::Missing;
use super::*;
use crate::common::lagrangian::bent;
use crate::common::{Lumped, Random, random_state};
use crate::data::{
    CurveValidityData, GravityData, LineData, MissingData, MissingLine, ModelData, PolynomialData,
    StationSet, ValidityData,
};
use crate::loading::sealed::Acts;
use crate::loads::{DistributedFrame, DistributedLoad, Load, LoadFrame};
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
            curve: None,
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

/// Terms of the kinetic coordinates that a model has dropped, against Lagrange's equations by differences: of `c_dot . (A q_dot)`, and of the
/// inertia forces of A on the fields.
#[test]
fn dropped_terms_are_those_of_lagrange() {
    let (_, data) = bent(false);
    let model = Model::new(data).unwrap();
    let lagrangian = model.data().lagrangian.as_ref().unwrap();
    let (m, n) = (3, lagrangian.fields as usize);
    let dropped = PolynomialData {
        quadratic: vec![(0, [0, 1], 0.3), (2, [1, 1], -0.2)],
        cubic: vec![(0, [0, 0, 0], 0.4), (1, [0, 1, 2], 0.7), (2, [0, 2, 2], -0.5)],
    };
    let c = |q: &[f64]| {
        [
            0.3 * q[0] * q[1] + 0.4 * q[0].powi(3),
            0.7 * q[0] * q[1] * q[2],
            -0.2 * q[1] * q[1] - 0.5 * q[0] * q[2] * q[2],
        ]
    };
    let mut random = Random::new(8);
    let at = Sample {
        q: &random.array::<3>(0.5),
        q_dot: &random.array::<3>(1.0),
        q_ddot: &random.array::<3>(2.0),
        beta: random.array(1.0),
        beta_dot: random.array(1.0),
        gravity: random.array(3.0),
    };
    let mut found = vec![0.0; m + 6];
    let points = vec![PolynomialData { quadratic: vec![(1, [0, 1], 2.0)], cubic: vec![(4, [0, 2, 2], 3.0)] }];
    let validity = CurveValidityData { limits: vec![], dropped, points };
    let mut manifold = Manifold::new(Some(&validity), lagrangian, m, 1);
    manifold.look(at.q, at.q_dot, at.q_ddot);
    manifold.add(&model, &at, &mut found);
    let [x, y, z] = [at.q[0], at.q[1], at.q[2]];
    let moved = manifold.dropped(0);
    assert!(
        (moved[1] - 2.0 * x * y).abs() < 1e-15 && (moved[4] - 3.0 * x * z * z).abs() < 1e-15,
        "{moved:?}"
    );

    let ((v, w), (v_dot, w_dot)) = (split(&at.beta), split(&at.beta_dot));
    let felt = vector(v_dot) + vector(w).cross(&vector(v)) - vector(at.gravity);
    let s = |a: usize| Vector3::from_fn(|k, _| lagrangian.first_moment[k * n + a]);
    let lever = |a: usize| {
        let p = |r: usize, k: usize| lagrangian.moment_0[9 * a + 3 * r + k];
        Vector3::new(p(2, 1) - p(1, 2), p(0, 2) - p(2, 0), p(1, 0) - p(0, 1))
    };
    let step = 1e-4;
    let linear = |a: usize, x: &[f64]| -> f64 { (0..m).map(|i| lagrangian.linear[a * m + i] * x[i]).sum() };
    let moved = |x: &[f64], along: &[f64], h: f64| -> Vec<f64> {
        x.iter().zip(along).map(|(x, d)| x + h * d).collect()
    };
    // c_dot by a central difference: exact but for a term of second order in the step.
    let rate = |q: &[f64], q_dot: &[f64]| -> Vec<f64> {
        let (a, b) = (c(&moved(q, q_dot, step)), c(&moved(q, q_dot, -step)));
        (0..m).map(|k| (a[k] - b[k]) / (2.0 * step)).collect()
    };
    let kinetic = |q: &[f64], q_dot: &[f64]| -> f64 {
        rate(q, q_dot).iter().enumerate().map(|(a, c)| c * linear(a, q_dot)).sum()
    };
    let unit = |j: usize| -> Vec<f64> { (0..m).map(|i| f64::from(u8::from(i == j))).collect() };
    // Quadratic in the rates: a difference is exact.
    let momentum = |j: usize, q: &[f64], q_dot: &[f64]| {
        (kinetic(q, &moved(q_dot, &unit(j), 0.5)) - kinetic(q, &moved(q_dot, &unit(j), -0.5))) / 1.0
    };
    let later = |h: f64| {
        let q: Vec<f64> = (0..m).map(|i| at.q[i] + h * at.q_dot[i] + 0.5 * h * h * at.q_ddot[i]).collect();
        (q, moved(at.q_dot, at.q_ddot, h))
    };
    let h = 1e-3;
    let second: Vec<f64> =
        (0..m).map(|a| (c(&later(h).0)[a] - 2.0 * c(at.q)[a] + c(&later(-h).0)[a]) / (h * h)).collect();
    let force: Vector3<f64> = (0..m).map(|a| s(a) * second[a]).sum();
    let moment: Vector3<f64> = (0..m).map(|a| lever(a) * second[a]).sum();
    for j in 0..m {
        let (after, before) = (later(h), later(-h));
        let impulse = (momentum(j, &after.0, &after.1) - momentum(j, &before.0, &before.1)) / (2.0 * h);
        let potential = |q: &[f64]| -> f64 {
            (0..m).map(|a| c(q)[a] * (s(a).dot(&felt) + lever(a).dot(&vector(w_dot)))).sum::<f64>()
        };
        let lagrange = |q: &[f64]| kinetic(q, at.q_dot) - potential(q);
        let slope = (lagrange(&moved(at.q, &unit(j), h)) - lagrange(&moved(at.q, &unit(j), -h))) / (2.0 * h);
        let (t, turn) = split(&model.phi_r[j]);
        let expected = impulse - slope + vector(t).dot(&force) + vector(turn).dot(&moment);
        // Differences of polynomials of the order one with steps of a thousandth.
        assert!((found[j] - expected).abs() < 1e-4, "row {j}: {} {expected}", found[j]);
    }
    for k in 0..3 {
        assert!((found[m + k] - force[k]).abs() < 1e-4 && (found[m + 3 + k] - moment[k]).abs() < 1e-4);
    }
}

/// Loads on a point that turns with what is missing do other work on the modes: by the virtual work of the forces on the turned node, for a
/// dead load, one that turns with the body, and a follower, each beside its node.
#[test]
fn loads_on_turned_nodes_work_on_the_modes() {
    let mut random = Random::new(6);
    let lumped = Lumped::random(3, 8);
    let mut data = lumped.data(3);
    let mut validity = Bent::new(&lumped, &data, &mut random).validity();
    let n = data.points.len();
    let flexibility = (0..36 * n).map(|_| 1e-6 * random.next()).collect();
    validity.missing = MissingData { loaded: vec![2], flexibility, rigid: vec![0.0; 36], lines: vec![] };
    data.validity = Some(validity);
    let model = Model::new(data).unwrap();
    let m = model.n_modes();
    let point = model.points[2].clone();
    assert!(dot(point.offset, point.offset) > 0.0);
    let follower = LoadFrame::Follower { section: crate::math::IDENTITY };
    for frame in [LoadFrame::Dead, LoadFrame::Body, follower] {
        let (force, moment) = (random.array(4.0), random.array(2.0));
        let load =
            Load { point: 2, frame, force, moment, time: crate::time::TimeFunction::Constant { value: 1.0 } };
        let mut case = crate::LoadCase::empty("one");
        case.loads = vec![load];
        let loads = model.prepare(&case).unwrap();
        let attitude = crate::math::IDENTITY;
        let mut instant = Instant::new(&model, 0);
        let acting = loads.acting();
        instant.gather(
            &model,
            &[],
            acting,
            &Variables::default(),
            &attitude,
            &vec![0.0; m],
            &mut Body::default(),
        );
        let mut missing = Missing::new(&model, 0.1, false);
        missing.look(&instant);
        let mut found = vec![0.0; m + 6];
        missing.defect(&model, &instant, &mut found);

        let theta = split(&missing.at(2)).1;
        assert!(dot(theta, theta) > 0.0);
        let work = |i: usize, scale: f64| {
            let (turn, tangential) = crate::math::rotation_and_tangential(crate::math::scale(scale, theta));
            let node = crate::math::mat_mul(&point.node_rotation, &turn);
            // Followers are told in the axes of the node.
            let on = |x: Vec3| if frame == follower { mul(&node, x) } else { x };
            let (f, arm) = (on(force), mul(&node, point.offset));
            let total = add(cross(arm, f), on(moment));
            let (t, turned) = split(&point.phi[i]);
            dot(t, f) + dot(mul(&node, mul(&tangential, turned)), total)
        };
        let wrench = &found[m..];
        for i in 0..m {
            let expected = -(work(i, 1e3) - work(i, -1e3)) / 2e3;
            let of_rigid: f64 = model.phi_r[i].iter().zip(wrench).map(|(a, b)| a * b).sum();
            // Rotations of 1e-5 times a thousand: of second order a difference leaves out the square.
            let size = 1e-5 * dot(theta, theta).sqrt() * 100.0;
            assert!(
                (found[i] - of_rigid - expected).abs() < size,
                "{frame:?} {i}: {} {expected}",
                found[i] - of_rigid
            );
        }
    }
}

/// What the estimate of a simplified method takes for the equations of the full model: nothing is left of them on the full model's own motion, but
/// for what is of second order in the amplitudes, as followers along members turn to first. With weight, and loads of every kind.
#[test]
fn couplings_are_the_equations_of_the_full_model() {
    let mut random = Random::new(12);
    let lumped = Lumped::random(3, 4);
    let mut data = lumped.data(2);
    let (m, n) = (data.modes.omega.len(), data.points.len());
    let quaternions = (0..3).flat_map(|_| crate::math::normalised(random.array(1.0)));
    let stations = StationSet {
        rotation: quaternions.collect(),
        position: random.array::<9>(1.0).to_vec(),
        phi_translation: random.array::<27>(1.0).to_vec(),
        phi_rotation: random.array::<27>(1.0).to_vec(),
    };
    data.lines = vec![LineData { name: "wing".into(), length: 1.0, knots: vec![0.0, 1.0], stations }];
    let along = DistributedLoad {
        member: 0,
        frame: DistributedFrame::Follower,
        force: random.array::<9>(2.0).to_vec(),
        moment: random.array::<9>(1.0).to_vec(),
        time: crate::time::TimeFunction::Constant { value: 1.5 },
    };
    let declared = MissingLine {
        member: along.member,
        frame: along.frame,
        force: along.force.clone(),
        moment: along.moment.clone(),
        flexibility: vec![0.0; 6 * n],
        rigid: vec![0.0; 6],
        readings: vec![0.0; 6 + m],
        curvature: vec![0.0; 4 * m * (m + 1) / 2],
    };
    let mut validity = Bent::new(&lumped, &data, &mut random).validity();
    validity.missing = MissingData { lines: vec![declared], ..MissingData::default() };
    data.validity = Some(validity);
    data.gravity = Some(GravityData { acceleration: [1.0, -2.0, -9.0], second_moment: vec![] });
    let model = Arc::new(Model::new(data).unwrap());
    let mut case = crate::LoadCase::empty("all");
    let frames = [LoadFrame::Dead, LoadFrame::Body, LoadFrame::Follower { section: crate::math::IDENTITY }];
    case.loads = (1..)
        .zip(frames)
        .map(|(point, frame)| Load {
            point,
            frame,
            force: random.array(4.0),
            moment: random.array(2.0),
            time: crate::time::TimeFunction::Constant { value: 1.0 },
        })
        .collect();
    case.distributed = vec![along];
    let loads = model.prepare(&case).unwrap();
    let mut state = random_state(&model, &mut random);
    state.accelerations_known = false;
    let left = |size: f64| {
        let mut simulation =
            Simulation::new(model.clone(), Settings { dt: 0.01, ..Settings::default() }).unwrap();
        let q = state.q.iter().map(|q| size * q).collect();
        simulation.restore(&State { q, ..state.clone() }).unwrap();
        simulation.solve_accelerations(&loads).unwrap();
        let state = simulation.state();
        let (q_ddot, rate) = state.u_dot.split_last_chunk::<6>().unwrap();
        let attitude = matrix(state.attitude);
        let missing = Missing::new(&model, 0.1, true);
        let mut acting = Instant::new(&model, 1);
        let (variables, body) = (Variables::default(), &mut Body::default());
        acting.gather(&model, missing.lines(), loads.acting(), &variables, &attitude, &state.q, body);
        let at = Sample {
            q: &state.q,
            q_dot: &state.q_dot,
            q_ddot,
            beta: true_velocity(&model.phi_r, &state.q_dot, &state.beta_star),
            beta_dot: true_velocity(&model.phi_r, q_ddot, rate),
            gravity: mul_t(&attitude, [1.0, -2.0, -9.0]),
        };
        let (mut u, mut r) = (vec![0.0; m + 6], vec![0.0; m + 6]);
        let work = &mut Workspace::new(&model);
        couplings(&model, &at, &state.beta_star, rate, &acting, missing.lines(), work, &mut u, &mut r);
        r.iter().fold(0.0_f64, |max, r| max.max(r.abs()))
    };
    let (whole, half) = (left(0.02), left(0.01));
    assert!(whole < 0.02, "{whole}");
    assert!(half < 0.3 * whole, "{whole} {half}");
}

/// A run that goes on far out of the range of its model ends with an estimate, whatever became of its numbers.
#[test]
fn errors_beyond_all_numbers_are_all_of_the_quantity() {
    let mut seen = Largest::default();
    assert_eq!(seen.ratio(), 0.0);
    seen.see([3.0, 0.0, 4.0], [0.0, 0.5, 0.0]);
    assert!((seen.ratio() - 0.5 / 25.25_f64.sqrt()).abs() < 1e-15);
    for error in [[1e200, 0.0, 0.0], [f64::INFINITY; 3], [f64::NAN; 3]] {
        seen.see([3.0, 0.0, 4.0], error);
        assert_eq!(seen.ratio(), 1.0);
    }
    assert_eq!(worst([(f64::INFINITY, f64::INFINITY), (1.0, 2.0)].into_iter()), 1.0);
    assert_eq!(worst([(0.0, 0.0)].into_iter()), 0.0);
    assert_eq!(worst([(0.5, 2.0), (1.0, 0.1)].into_iter()), 0.25);
}
