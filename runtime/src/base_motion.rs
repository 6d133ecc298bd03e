//! Motion of frame A prescribed by functions of time: a base that is shaken, a manoeuvre, a clamp.
//!
//! The functions give velocities or accelerations of A. What is not given follows by integration from the state at the start of a
//! step, so that nothing has to be carried along: position, attitude, and velocities where accelerations are given.
//!
//! ```text
//! w(t) = f(t)  or  w_0 + int f,      zeta(t) = zeta_0 exp(Om/2),  Om = h/2 (w_1 + w_2) - sqrt(3)/12 h^2 w_1 x w_2    (w in A)
//! v_G(t) = f, C f, v_0 + int f  or  v_0 + int C f,     r_G(t) = r_0 + int v_G
//! ```
//!
//! with two-point Gauss quadrature over a quarter of the step: fourth order, and never taken at an instant at which a function jumps
//! together with the step.

use serde::{Deserialize, Serialize};

use crate::expression::Variables;
use crate::math::{
    Mat3, Vec3, Vec6, add, axpy, cross, join, matrix, mul, mul_t, normalised, quaternion, quaternion_product,
    scale, split, sub,
};
use crate::prescribed::PrescribedMotion;
use crate::real::Real;
use crate::time::TimeFunction;

/// Pieces that a step is integrated in.
const PIECES: u32 = 4;
/// Two-point Gauss rule on 0..1.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_13, 0.788_675_134_594_812_9];
/// `sqrt(3)/12`.
const COMMUTATOR: f64 = 0.144_337_567_297_406_43;

/// What moves frame A. Both parts zero hold it where it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BaseMotion {
    /// Translation of the origin of A, m/s or m/s^2. An acceleration is the inertial one, not the rate of components in A.
    pub translation: Drive,
    /// Rotation of A, rad/s or rad/s^2.
    pub rotation: Drive,
    /// Components in G; else in A.
    pub inertial: bool,
}

/// Three components over time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// Whether they are accelerations, which start from the velocities at hand; else velocities.
    pub acceleration: bool,
    /// Functions of time alone; zero where there is none.
    pub components: [Option<TimeFunction>; 3],
}

impl Drive {
    const NONE: Self = Drive { acceleration: false, components: [None, None, None] };

    fn value(&self, t: f64) -> Vec3 {
        let variables = Variables { t, ..Variables::default() };
        self.components.each_ref().map(|f| f.as_ref().map_or(0.0, |f| f.value(&variables)))
    }

    fn rate(&self, t: f64) -> Vec3 {
        self.components.each_ref().map(|f| f.as_ref().map_or(0.0, |f| f.rate(t)))
    }
}

/// Where a piece of the integration starts.
#[derive(Clone, Copy)]
struct Start {
    t: f64,
    /// In the axes in which the functions are given.
    v: Vec3,
    w: Vec3,
    attitude: [f64; 4],
    position: Vec3,
}

impl BaseMotion {
    /// Holds A where it is.
    pub const HELD: Self = BaseMotion { translation: Drive::NONE, rotation: Drive::NONE, inertial: false };

    /// The motion at `t` of a body that is where `from` says: velocities taken from the functions where these give them, rates always.
    pub fn at(&self, from: &PrescribedMotion, t: f64) -> PrescribedMotion {
        let (v, w) = self.velocities(from, t);
        self.motion(&Start { t, v, w, attitude: from.attitude, position: from.position })
    }

    /// The motion at `t1` of a body that is where `from` says at `t0`. Does not allocate.
    pub fn advance(&self, from: &PrescribedMotion, t0: f64, t1: f64) -> PrescribedMotion {
        let (v, w) = self.velocities(from, t0);
        let mut at = Start { t: t0, v, w, attitude: from.attitude, position: from.position };
        let h = (t1 - t0) / f64::from(PIECES);
        for piece in 1..=PIECES {
            let end = if piece == PIECES { t1 } else { t0 + h * f64::from(piece) };
            at = self.piece(&at, end);
        }
        self.motion(&at)
    }

    /// The rate at `t` of a body with the velocity `beta` and the attitude `c`, `C^{GA}`, that [`BaseMotion::at`] gives it.
    pub(crate) fn rate<R: Real>(&self, beta: &Vec6<R>, c: &Mat3<R>, t: f64) -> Vec6<R> {
        let BaseMotion { translation, rotation, inertial } = self;
        let of = |x: Vec3| x.map(R::of);
        let to_a = |x: Vec3| if *inertial { mul_t(c, of(x)) } else { of(x) };
        let (v, w) = split(beta);
        let (w, w_dot) = if rotation.acceleration {
            (w, to_a(rotation.value(t)))
        } else {
            (to_a(rotation.value(t)), to_a(rotation.rate(t)))
        };
        let v_dot = match (translation.acceleration, *inertial) {
            (true, _) => sub(to_a(translation.value(t)), cross(w, v)),
            (false, true) => sub(to_a(translation.rate(t)), cross(w, to_a(translation.value(t)))),
            (false, false) => of(translation.rate(t)),
        };
        join(v_dot, w_dot)
    }

    /// Velocities in the axes of the functions at the start of a step.
    fn velocities(&self, from: &PrescribedMotion, t: f64) -> (Vec3, Vec3) {
        let to_axes = |x: Vec3| if self.inertial { mul(&matrix(from.attitude), x) } else { x };
        let (v, w) = split(&from.velocity);
        let own =
            |drive: &Drive, known: Vec3| if drive.acceleration { to_axes(known) } else { drive.value(t) };
        // Accelerations of the origin are integrated in G, whatever their axes.
        let in_g = self.translation.acceleration && !self.inertial;
        let v = if in_g { mul(&matrix(from.attitude), v) } else { own(&self.translation, v) };
        (v, own(&self.rotation, w))
    }

    fn piece(&self, at: &Start, end: f64) -> Start {
        let h = end - at.t;
        let mut travelled = [0.0; 3];
        for x in GAUSS {
            travelled = axpy(travelled, 0.5 * h, self.velocity_g(at, at.t + h * x));
        }
        let v = if self.translation.acceleration {
            self.velocity_g(at, end)
        } else {
            self.translation.value(end)
        };
        Start {
            t: end,
            v,
            w: self.spin(at, end),
            attitude: normalised(self.attitude(at, end)),
            position: add(at.position, travelled),
        }
    }

    /// Angular velocity in the axes of the functions.
    fn spin(&self, at: &Start, t: f64) -> Vec3 {
        if !self.rotation.acceleration {
            return self.rotation.value(t);
        }
        let h = t - at.t;
        GAUSS.iter().fold(at.w, |w, x| axpy(w, 0.5 * h, self.rotation.value(at.t + h * x)))
    }

    fn attitude(&self, at: &Start, t: f64) -> [f64; 4] {
        let h = t - at.t;
        let [w1, w2] = GAUSS.map(|x| self.spin(at, at.t + h * x));
        let mean = scale(0.5 * h, add(w1, w2));
        let commutator = scale(COMMUTATOR * h * h, cross(w1, w2));
        if self.inertial {
            quaternion_product(quaternion(sub(mean, commutator)), at.attitude)
        } else {
            quaternion_product(at.attitude, quaternion(add(mean, commutator)))
        }
    }

    /// Velocity of the origin in G.
    fn velocity_g(&self, at: &Start, t: f64) -> Vec3 {
        let to_g = |x: Vec3, t: f64| if self.inertial { x } else { mul(&matrix(self.attitude(at, t)), x) };
        if !self.translation.acceleration {
            return to_g(self.translation.value(t), t);
        }
        let h = t - at.t;
        GAUSS
            .iter()
            .map(|x| at.t + h * x)
            .fold(at.v, |v, t| axpy(v, 0.5 * h, to_g(self.translation.value(t), t)))
    }

    /// What the runtime and the reference methods take.
    fn motion(&self, at: &Start) -> PrescribedMotion {
        let c = matrix(at.attitude);
        let to_a = |x: Vec3| if self.inertial { mul_t(&c, x) } else { x };
        let w = to_a(at.w);
        let rotation = &self.rotation;
        let w_dot = to_a(if rotation.acceleration { rotation.value(at.t) } else { rotation.rate(at.t) });
        let translation = &self.translation;
        let (v, v_dot) = match (translation.acceleration, self.inertial) {
            // The rate of the components is what the acceleration leaves when the axes turn.
            (true, _) => {
                let v = mul_t(&c, at.v);
                (v, sub(to_a(translation.value(at.t)), cross(w, v)))
            }
            (false, true) => {
                let v = to_a(at.v);
                (v, sub(to_a(translation.rate(at.t)), cross(w, v)))
            }
            (false, false) => (at.v, translation.rate(at.t)),
        };
        PrescribedMotion {
            velocity: join(v, w),
            rate: join(v_dot, w_dot),
            attitude: at.attitude,
            position: at.position,
        }
    }
}
