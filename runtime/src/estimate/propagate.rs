//! Linear propagation of a defect into the errors of amplitudes, momenta and attitude.

use alloc::{vec, vec::Vec};

use crate::math::{Mat3, Vec3, add, axpy, mul, scale};

/// `e_ddot + 2 zeta omega e_dot + omega^2 e = s(t)` over one interval, exactly for `s` that varies linearly in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Oscillator {
    /// `1/omega^2` and `2 zeta/omega`.
    flexibility: f64,
    lag: f64,
    /// Homogeneous solution after the interval, from displacement and from rate.
    from_e: [f64; 2],
    from_rate: [f64; 2],
}

impl Oscillator {
    pub(super) fn new(omega: f64, ratio: f64, interval: f64) -> Self {
        // What oscillates above critical damping is an estimate of an estimate: treated as just below it.
        let ratio = ratio.min(0.999);
        let damped = omega * libm::sqrt(1.0 - ratio * ratio);
        let (sin, cos) = libm::sincos(damped * interval);
        let decay = libm::exp(-ratio * omega * interval);
        let a = ratio * omega / damped;
        Oscillator {
            flexibility: 1.0 / (omega * omega),
            lag: 2.0 * ratio / omega,
            from_e: [decay * (cos + a * sin), -decay * omega * omega / damped * sin],
            from_rate: [decay * sin / damped, decay * (cos - a * sin)],
        }
    }

    pub(super) fn advance(&self, interval: f64, [s_0, s_1]: [f64; 2], e: &mut f64, rate: &mut f64) {
        let slope = (s_1 - s_0) / interval;
        let particular = |s: f64| (s - self.lag * slope) * self.flexibility;
        let drift = slope * self.flexibility;
        let (x, v) = (*e - particular(s_0), *rate - drift);
        *e = particular(s_1) + self.from_e[0] * x + self.from_rate[0] * v;
        *rate = drift + self.from_e[1] * x + self.from_rate[1] * v;
    }
}

/// Rigid body and loads at an instant, as the error of its momentum needs them; vectors in G.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Body {
    /// `C^{GA}`.
    pub(super) attitude: Mat3,
    /// Inertia about the centre of mass and its inverse, axes of A.
    pub(super) inertia: Mat3,
    pub(super) inertia_inverse: Mat3,
    /// Spin of the rigid motion `w*`, in A.
    pub(super) spin: Vec3,
    /// Moment about the centre of mass and force of the loads that turn with the body.
    pub(super) turning_moment: Vec3,
    pub(super) turning_force: Vec3,
    /// `r F^t` of the loads that do not, `r` from the centre of mass.
    pub(super) virial: Mat3,
}

/// Errors of the state, true less marched.
#[derive(Clone, Debug)]
pub(super) struct Errors {
    oscillators: Vec<Oscillator>,
    interval: f64,
    /// Of amplitudes and rates - (m).
    pub(super) e: Vec<f64>,
    pub(super) e_dot: Vec<f64>,
    /// Of momentum and of moment of momentum about the centre of mass, in G.
    pub(super) momentum: Vec3,
    pub(super) moment: Vec3,
    /// Of the attitude: rotation vector in A.
    pub(super) attitude: Vec3,
    rates: Option<[Vec3; 3]>,
    /// Defect over the generalised masses at the last instant, with its sign turned - (m).
    source: Vec<f64>,
}

impl Errors {
    pub(super) fn new(omega: &[f64], ratio: &[f64], interval: f64) -> Self {
        let m = omega.len();
        let oscillators = omega.iter().zip(ratio).map(|(o, z)| Oscillator::new(*o, *z, interval));
        Errors {
            oscillators: oscillators.collect(),
            interval,
            e: vec![0.0; m],
            e_dot: vec![0.0; m],
            momentum: [0.0; 3],
            moment: [0.0; 3],
            attitude: [0.0; 3],
            rates: None,
            source: vec![0.0; m],
        }
    }

    /// No errors, nothing known of the instant before.
    pub(super) fn reset(&mut self) {
        self.e.fill(0.0);
        self.e_dot.fill(0.0);
        (self.momentum, self.moment, self.attitude) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        self.rates = None;
    }

    /// Error of the spin `w*` of the rigid motion, in A: `J e_w = e_H - theta x J w + J (theta x w)`, less the turn of the axes.
    pub(super) fn spin(&self, body: &Body) -> Vec3 {
        let momentum = mul(&body.inertia, body.spin);
        let moment = crate::math::mul_t(&body.attitude, self.moment);
        mul(&body.inertia_inverse, axpy(moment, -1.0, crate::math::cross(self.attitude, momentum)))
    }

    /// Goes on to the next instant with the defect there: over the generalised masses in the elastic rows, force and moment about
    /// the centre of mass in G.
    pub(super) fn advance(
        &mut self,
        elastic: impl Iterator<Item = f64>,
        force: Vec3,
        moment: Vec3,
        turn_rate: Vec3,
        body: &Body,
    ) {
        let h = self.interval;
        let first = self.rates.is_none();
        let states = self.e.iter_mut().zip(&mut self.e_dot).zip(&self.oscillators);
        for (((e, e_dot), oscillator), (source, defect)) in states.zip(self.source.iter_mut().zip(elastic)) {
            if !first {
                oscillator.advance(h, [*source, -defect], e, e_dot);
            }
            *source = -defect;
        }
        let theta = mul(&body.attitude, self.attitude);
        let trace = body.virial[0][0] + body.virial[1][1] + body.virial[2][2];
        let dead = axpy(mul(&body.virial, theta), -trace, theta);
        let turned = |x: Vec3| crate::math::cross(theta, x);
        let now = [
            axpy(turned(body.turning_force), -1.0, force),
            axpy(add(dead, turned(body.turning_moment)), -1.0, moment),
            turn_rate,
        ];
        if let Some(before) = self.rates {
            let to = [&mut self.momentum, &mut self.moment, &mut self.attitude];
            for (to, (a, b)) in to.into_iter().zip(before.into_iter().zip(now)) {
                *to = axpy(*to, 0.5 * h, add(a, b));
            }
        }
        self.rates = Some(now);
    }
}

/// Inertia about the centre of mass and its inverse, from `M_RR` about the origin.
pub(super) fn central_inertia(rigid_mass: &[crate::math::Vec6; 6], mass: f64, c: Vec3) -> (Mat3, Mat3) {
    let about =
        |i: usize, j: usize| rigid_mass.get(3 + i).and_then(|row| row.get(3 + j)).copied().unwrap_or(0.0);
    let c2 = crate::math::dot(c, c);
    let own: Mat3 = core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            let (c_i, c_j) = (c.get(i).copied().unwrap_or(0.0), c.get(j).copied().unwrap_or(0.0));
            about(i, j) - mass * (if i == j { c2 } else { 0.0 } - c_i * c_j)
        })
    });
    let [a, b, d] = own;
    let columns = [crate::math::cross(b, d), crate::math::cross(d, a), crate::math::cross(a, b)];
    let determinant = crate::math::dot(a, columns[0]);
    let [x, y, z] = columns.map(|column| scale(1.0 / determinant, column));
    (own, [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]])
}
