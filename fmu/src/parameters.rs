//! What is chosen before a simulation begins.

use rom_runtime::{Integrator, Method, Model, State};

/// The parameters of an instance. Enumerations are numbered as the description lists them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Load case: 0 for none, from 1 in the order of the model.
    pub load_case: i64,
    /// Method, from 1 in the order of [`Method::ALL`].
    pub method: i64,
    /// Integrator, from 1 in the order of [`Integrator::ALL`].
    pub integrator: i64,
    /// Time step, s; 0 for that of the load case.
    pub dt: f64,
    /// Numerical damping; negative for that of the load case.
    pub numerical_damping: f64,
    /// Whether the loads of a loaded equilibrium act besides.
    pub equilibrium_loads: bool,
    /// Acceleration of free fall in G, m/s^2.
    pub gravity: [f64; 3],
    /// Motion of A at the start: position in G, velocity and angular velocity in A, attitude quaternion.
    pub initial: Initial,
}

/// Motion of A at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Initial {
    /// Position of the origin of A in G, m.
    pub r_g: [f64; 3],
    /// Velocity of the origin of A in A, m/s.
    pub v_a: [f64; 3],
    /// Angular velocity of A in A, rad/s.
    pub w_a: [f64; 3],
    /// Attitude quaternion, scalar first; need not be of unit length.
    pub zeta: [f64; 4],
}

/// Time step where neither a parameter nor a load case says one, s.
pub const DEFAULT_DT: f64 = 0.01;

/// Numbers of the parameters that are real numbers, in the order of the variables.
pub const REALS: usize = 18;

impl Parameters {
    /// What an instance starts with.
    pub fn of(model: &Model) -> Self {
        let rest = State::at_rest(model);
        Parameters {
            load_case: 0,
            method: 1,
            integrator: 1,
            dt: 0.0,
            numerical_damping: -1.0,
            equilibrium_loads: true,
            gravity: model.gravity(),
            initial: Initial { r_g: rest.position, v_a: [0.0; 3], w_a: [0.0; 3], zeta: rest.attitude },
        }
    }

    /// The method chosen.
    ///
    /// # Errors
    /// A number that stands for none.
    pub fn method(&self) -> Result<Method, String> {
        choice("method", &Method::ALL, self.method)
    }

    /// The integrator chosen.
    ///
    /// # Errors
    /// A number that stands for none.
    pub fn integrator(&self) -> Result<Integrator, String> {
        choice("integrator", &Integrator::ALL, self.integrator)
    }

    /// A real parameter by its place among them: dt, numerical damping, gravity, initial motion.
    pub fn real(&mut self, place: usize) -> Option<&mut f64> {
        let Initial { r_g, v_a, w_a, zeta } = &mut self.initial;
        let all = [&mut self.dt, &mut self.numerical_damping];
        let rest = self.gravity.iter_mut().chain(r_g).chain(v_a).chain(w_a).chain(zeta);
        all.into_iter().chain(rest).nth(place)
    }
}

fn choice<T: Copy>(what: &str, all: &[T], number: i64) -> Result<T, String> {
    let place = number.checked_sub(1).and_then(|place| usize::try_from(place).ok());
    place
        .and_then(|place| all.get(place).copied())
        .ok_or_else(|| format!("parameter {what} is {number}, expected 1 to {}", all.len()))
}
