//! Section forces and moments at places along the members (theory section 15), by mode displacement and by force summation.
//!
//! With `S = (F, M)` on the positive face of a section, in its own axes,
//!
//! ```text
//! S = S_0 + S_j q_j + V_j q_dot_j                                                                 by the strains of the modes
//! S = S_c + y^t Q_S(q) - N_i u_dot_i + N_r g_A - c_alr u_l beta_r - k_alrs q_l beta_r beta_s
//!         + g_A . H_al q_l - D_l q_dot_l                                                          by summation of forces
//! ```
//!
//! where the six fields `y = K_SS^-1 B^t S` are the displacements that unit dislocations of the section make with A held: what turns any
//! force on the structure into section forces, also in closed loops. The second form sums loads, weight and inertia forces; what the
//! modes miss of the static response to them is in it.

use alloc::{vec, vec::Vec};

use crate::data::{CutData, SummationData};
use crate::equations::check_loads;
use crate::error::{ModelError, StepError};
use crate::expression::Variables;
use crate::loading::{Acting, Loads, Wrench};
use crate::math::{
    Mat3, Vec3, Vec6, add, axpy, combine, cross, dot, dot_6, join, mat_mul, matrix, mul, mul_t,
    rotation_and_tangential, split,
};
use crate::model::{Model, Point, unknown};
use crate::state::State;

/// Force (N) and moment (N m) on the positive face of a section, in the section axes of the deformed member.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SectionForces {
    /// By summation of forces where the model has what that takes, else by the modes: (F, M) - (6).
    pub best: [f64; 6],
    /// By the strains of the modes: (F, M) - (6).
    pub by_modes: [f64; 6],
}

/// Scratch and results for the places of a model; everything is allocated when it is made.
#[derive(Clone, Debug)]
pub struct InternalLoads {
    wrenches: Vec<Wrench>,
    /// On the point of every slot: force in A, and moment about the rotation vector of its node.
    forces: Vec<Vec6>,
    u: Vec<f64>,
    found: Vec<SectionForces>,
}

impl Model {
    /// Names of the places where section forces are told.
    pub fn section_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.data().cuts.iter().map(|cut| cut.name.as_str())
    }

    /// Index of such a place.
    ///
    /// # Errors
    /// [`ModelError::Unknown`], which lists the names there are.
    pub fn section(&self, name: &str) -> Result<usize, ModelError> {
        let cuts = &self.data().cuts;
        let found = cuts.iter().position(|cut| cut.name == name);
        found.ok_or_else(|| unknown("place of internal loads", name, cuts.iter().map(|cut| &cut.name)))
    }
}

impl InternalLoads {
    /// For the places of a model, under any loads.
    pub fn new(model: &Model) -> Self {
        let n = model.n_carriers();
        InternalLoads {
            wrenches: vec![Wrench::default(); n],
            forces: vec![[0.0; 6]; n],
            u: vec![0.0; model.n_modes() + 6],
            found: vec![SectionForces::default(); model.data().cuts.len()],
        }
    }

    /// What was found last, place after place.
    pub fn found(&self) -> &[SectionForces] {
        &self.found
    }

    /// Section forces in a state with the accelerations `u_dot` that belong to it ([`State::u_dot`]) - (m + 6), in a field of gravity in
    /// G, m/s^2 ([`Model::gravity`]). Does not allocate.
    ///
    /// # Errors
    /// Loads that were prepared for another model.
    pub fn find<L: Loads + ?Sized>(
        &mut self,
        model: &Model,
        state: &State,
        u_dot: &[f64],
        gravity: [f64; 3],
        loads: &L,
    ) -> Result<&[SectionForces], StepError> {
        self.find_under(model, state, u_dot, gravity, loads.acting())
    }

    fn find_under(
        &mut self,
        model: &Model,
        state: &State,
        u_dot: &[f64],
        gravity: [f64; 3],
        loads: &Acting,
    ) -> Result<&[SectionForces], StepError> {
        check_loads(model, loads)?;
        let attitude = matrix(state.attitude);
        let beta = model.velocity(state);
        let (v_a, w_a) = split(&beta);
        let variables = Variables { t: state.time, v_a, w_a, r_g: state.position };
        let summed = model.data().cuts.iter().any(|cut| cut.summation.is_some());
        if summed {
            let n = loads.map().points().len();
            if let Some(wrenches) = self.wrenches.get_mut(..n) {
                wrenches.fill(Wrench::default());
                loads.gather(&variables, wrenches);
            }
            let each = loads.map().points().zip(&self.wrenches).zip(&mut self.forces);
            for ((index, wrench), force) in each {
                *force = model
                    .carrier(index)
                    .map_or([0.0; 6], |point| on_carrier(point, wrench, &attitude, &state.q));
            }
            for (u, value) in self.u.iter_mut().zip(state.q_dot.iter().chain(&state.beta_star)) {
                *u = *value;
            }
        }
        let at = At {
            q: &state.q,
            q_dot: &state.q_dot,
            u: &self.u,
            u_dot,
            beta,
            gravity: mul_t(&attitude, gravity),
            attitude,
            variables,
        };
        for (index, (cut, found)) in model.data().cuts.iter().zip(&mut self.found).enumerate() {
            found.by_modes = by_modes(cut, at.q, at.q_dot);
            found.best = match &cut.summation {
                None => found.by_modes,
                Some(summation) => by_summation(summation, index, &at, loads, &self.forces),
            };
        }
        Ok(&self.found)
    }
}

/// The instant.
struct At<'a> {
    q: &'a [f64],
    q_dot: &'a [f64],
    u: &'a [f64],
    u_dot: &'a [f64],
    beta: Vec6,
    /// In A.
    gravity: Vec3,
    attitude: Mat3,
    variables: Variables,
}

/// Force in A, and moment on the rotation vector of the node, of a wrench on a point.
fn on_carrier(point: &Point, wrench: &Wrench, attitude: &Mat3, q: &[f64]) -> Vec6 {
    let theta = split(&combine(&point.phi, q)).1;
    let (turn, tangential) = rotation_and_tangential(theta);
    let node = mat_mul(&point.node_rotation, &turn);
    let [dead, own] = wrench.in_a(attitude, &node);
    let (f, m) = (add(dead.0, own.0), add(dead.1, own.1));
    let arm = mul(&node, point.offset);
    join(f, mul_t(&tangential, mul_t(&node, add(m, cross(arm, f)))))
}

/// Row `a` of a row-major (6 x width) array against a vector.
fn row(values: &[f64], a: usize, x: &[f64]) -> f64 {
    let width = x.len();
    values.get(a * width..(a + 1) * width).map_or(0.0, |row| row.iter().zip(x).map(|(v, x)| v * x).sum())
}

fn by_modes(cut: &CutData, q: &[f64], q_dot: &[f64]) -> Vec6 {
    let mut out = cut.rest;
    for (a, out) in out.iter_mut().enumerate() {
        *out += row(&cut.modal, a, q) + row(&cut.modal_rate, a, q_dot);
    }
    out
}

fn by_summation(
    summation: &SummationData,
    index: usize,
    at: &At<'_>,
    loads: &Acting,
    forces: &[Vec6],
) -> Vec6 {
    let m = at.q.len();
    let mut out = summation.constant;
    for (a, out) in out.iter_mut().enumerate() {
        *out -= row(&summation.inertia, a, at.u_dot) + row(&summation.damping, a, at.q_dot);
        *out += weight(summation, a, at);
        let velocities = summation.c.get(a * 6 * (m + 6)..(a + 1) * 6 * (m + 6)).unwrap_or(&[]);
        for (c, u) in velocities.as_chunks::<6>().0.iter().zip(at.u) {
            *out -= dot_6(c, &at.beta) * u;
        }
        let turning = summation.k.get(a * 21 * m..(a + 1) * 21 * m).unwrap_or(&[]);
        for (k, q) in turning.as_chunks::<21>().0.iter().zip(at.q) {
            *out -= centrifugal(k, &at.beta) * q;
        }
        if let Some(direct) = loads.direct() {
            // Generalised forces are those of forces distributed as the momenta of the modes.
            *out += summation.inertia.get(a * (m + 6)..).map_or(0.0, |inertia| direct.modal_work(inertia));
        }
    }
    for (place, force) in loads.map().points().zip(forces) {
        let influence = summation.places.get(place * 36..(place + 1) * 36).unwrap_or(&[]);
        for (out, influence) in out.iter_mut().zip(influence.as_chunks::<6>().0) {
            *out += dot_6(influence, force);
        }
    }
    for line in loads.lines() {
        line.add_section_forces(index, line.time().value(&at.variables), &at.attitude, &mut out);
    }
    out
}

/// `N_r g_A + g_A . H_al q_l`.
fn weight(summation: &SummationData, a: usize, at: &At<'_>) -> f64 {
    let m = at.q.len();
    let rigid = summation.inertia.get(a * (m + 6) + m..).and_then(|row| row.first_chunk::<3>());
    let mut sum = rigid.map_or(0.0, |row| dot(*row, at.gravity));
    let second = summation.gravity.get(a * 3 * m..(a + 1) * 3 * m).unwrap_or(&[]);
    let moved = second.as_chunks::<3>().0.iter().zip(at.q).fold([0.0; 3], |sum, (h, q)| axpy(sum, *q, *h));
    sum += dot(moved, at.gravity);
    sum
}

/// `k_rs beta_r beta_s` over the pairs r <= s.
fn centrifugal(k: &[f64; 21], beta: &Vec6) -> f64 {
    let pairs = beta.iter().enumerate().flat_map(|(r, x)| beta.iter().skip(r).map(move |y| x * y));
    k.iter().zip(pairs).map(|(k, pair)| k * pair).sum()
}

/// Influence of a force per station of a line load on the section forces: `sum_g y_g p_g^t`, a matrix for each component.
pub(crate) fn of_line(model: &Model, first: usize, force: &[Vec3]) -> Vec<[Mat3; 6]> {
    let of_cut = |cut: &CutData| {
        let mut out = [[[0.0; 3]; 3]; 6];
        let places = cut.summation.as_ref().map_or(&[][..], |summation| &summation.places);
        for (n, p) in force.iter().enumerate() {
            let at = 36 * (first + n);
            let influence = places.get(at..at + 36).unwrap_or(&[]);
            for (sum, influence) in out.iter_mut().zip(influence.as_chunks::<6>().0) {
                for (row, y) in sum.iter_mut().zip(split(influence).0) {
                    *row = axpy(*row, y, *p);
                }
            }
        }
        out
    };
    model.data().cuts.iter().map(of_cut).collect()
}
