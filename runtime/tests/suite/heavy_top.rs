//! Heavy top of Geradin & Cardona (Flexible Multibody Dynamics, 2001; also Bruels, Cardona & Arnold 2012): m = 15 kg with its
//! centre at (0, 1, 0) m, inertia diag(0.234375, 0.46875, 0.234375) kg m^2 about it, spinning at (0, 150, -4.61538) rad/s under
//! gravity of 9.81 m/s^2 along -z.
//!
//! A free body has no pinned point. But the rotation of a free body about its centre of mass is that of a top about its
//! pivot when the inertia and the moment of the weight are those about the pivot: masses spread evenly around the pivot give
//! that inertia, and the weight acts at the top's centre.

use std::sync::Arc;

use crate::common::{Lumped, Mass};
use nalgebra::{DMatrix, Matrix3, UnitQuaternion, Vector3};
use rom_runtime::data::PointData;
use rom_runtime::time::TimeFunction;
use rom_runtime::{Integrator, Load, LoadCase, LoadFrame, Model, Settings, Simulation};

const WEIGHT: f64 = 15.0 * 9.81;
const SPIN: [f64; 3] = [0.0, 150.0, -4.61538];
const T_END: f64 = 0.5;

/// Inertia about the pivot, as point masses on the axes: J_xx = s_y + s_z and so on.
fn inertia() -> Vector3<f64> {
    Vector3::new(0.234375 + 15.0, 0.46875, 0.234375 + 15.0)
}

fn model() -> Arc<Model> {
    let j = inertia();
    let second = Vector3::new(j.y + j.z - j.x, j.x + j.z - j.y, j.x + j.y - j.z) * 0.5;
    let mut masses = Vec::new();
    for (axis, s) in [(Vector3::x(), second.x), (Vector3::y(), second.y), (Vector3::z(), second.z)] {
        for sign in [-1.0, 1.0] {
            masses.push(Mass { mass: 0.5 * s, position: sign * axis, shapes: vec![] });
        }
    }
    let lumped = Lumped { masses, stiffness: DMatrix::zeros(0, 0), damping_ratio: 0.0, plain_points: true };
    let mut data = lumped.data(1);
    data.points = vec![PointData {
        name: "centre".into(),
        node_position: [0.0, 1.0, 0.0],
        node_rotation: [1.0, 0.0, 0.0, 0.0],
        offset: [0.0; 3],
        phi_translation: vec![],
        phi_rotation: vec![],
        sections: vec![],
    }];
    Arc::new(Model::new(data).unwrap())
}

/// Centre of the top by Euler's equations with a fixed point, classical Runge-Kutta with steps of 2e-6 s.
fn exact() -> Vector3<f64> {
    let (j, steps) = (Matrix3::from_diagonal(&inertia()), 250_000);
    let j_inverse = j.try_inverse().unwrap();
    let h = T_END / f64::from(steps);
    let rate = |q: &nalgebra::Quaternion<f64>, w: &Vector3<f64>| {
        let attitude = UnitQuaternion::new_unchecked(*q);
        let moment = Vector3::y().cross(&(attitude.inverse() * Vector3::new(0.0, 0.0, -WEIGHT)));
        let w_dot = j_inverse * (moment - w.cross(&(j * w)));
        (*q * nalgebra::Quaternion::from_imag(*w) * 0.5, w_dot)
    };
    let (mut q, mut w) = (nalgebra::Quaternion::identity(), Vector3::from(SPIN));
    for _ in 0..steps {
        let (q1, w1) = rate(&q, &w);
        let (q2, w2) = rate(&(q + q1 * (0.5 * h)), &(w + w1 * (0.5 * h)));
        let (q3, w3) = rate(&(q + q2 * (0.5 * h)), &(w + w2 * (0.5 * h)));
        let (q4, w4) = rate(&(q + q3 * h), &(w + w3 * h));
        q += (q1 + (q2 + q3) * 2.0 + q4) * (h / 6.0);
        w += (w1 + (w2 + w3) * 2.0 + w4) * (h / 6.0);
        q /= q.norm();
    }
    UnitQuaternion::new_unchecked(q) * Vector3::y()
}

fn centre(model: &Arc<Model>, integrator: Integrator, dt: f64) -> Vector3<f64> {
    let case = LoadCase {
        t_end: T_END,
        dt,
        loads: vec![Load {
            point: 0,
            frame: LoadFrame::Dead,
            force: [0.0, 0.0, -WEIGHT],
            moment: [0.0; 3],
            time: TimeFunction::Constant { value: 1.0 },
        }],
        ..LoadCase::empty("gravity")
    };
    let loads = model.prepare(&case).unwrap();
    let settings = Settings { dt, integrator, ..Settings::default() };
    let mut simulation = Simulation::new(Arc::clone(model), settings).unwrap();
    let mut state = simulation.state().clone();
    state.beta_star[3..].copy_from_slice(&SPIN);
    simulation.restore(&state).unwrap();
    for _ in 0..(T_END / dt).round() as usize {
        simulation.step(&loads).unwrap();
    }
    let [w, i, j, k] = simulation.rigid_output().zeta;
    UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, i, j, k)) * Vector3::y()
}

#[test]
fn the_heavy_top_precesses() {
    let (model, exact) = (model(), exact());
    for (integrator, order) in
        [(Integrator::Newmark, 2.0), (Integrator::GeneralizedAlpha, 2.0), (Integrator::Rk4, 4.0)]
    {
        let error = |dt| (centre(&model, integrator, dt) - exact).norm();
        let (coarse, fine) = (error(5e-4), error(2.5e-4));
        let observed = (coarse / fine).log2();
        // 150 rad/s make 0.04 rad a step; the arm is 1 m.
        assert!(fine < 3e-3, "{integrator}: {fine}");
        assert!((observed - order).abs() < 0.3, "{integrator}: order {observed}, {coarse} {fine}");
    }
}
