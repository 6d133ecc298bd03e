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
    Mat3, Vec3, Vec6, add, axpy, combine, constant, cross, dot, dot_6, join, mat_mul, matrix, mul, mul_t,
    rotation_and_tangential, split,
};
use crate::model::{Model, Point, unknown};
use crate::projected::Projected;
use crate::real::Real;
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
    scratch: Scratch<f64>,
    u: Vec<f64>,
    found: Vec<SectionForces>,
}

/// What acts on the loaded points, in numbers of a kind.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch<R> {
    pub(crate) wrenches: Vec<Wrench<R>>,
    /// On the point of every slot: force in A, and moment about the rotation vector of its node.
    forces: Vec<Vec6<R>>,
}

impl<R: Real> Scratch<R> {
    /// For any loads of a model; empty where the model sums no forces.
    pub(crate) fn new(model: &Model) -> Self {
        let n = if sums(model) { model.n_carriers() } else { 0 };
        Scratch { wrenches: vec![Wrench::default(); n], forces: vec![[R::of(0.0); 6]; n] }
    }

    /// Zeroed wrenches of the slots of some loads.
    pub(crate) fn slots(&mut self, loads: &Acting) -> Option<&mut [Wrench<R>]> {
        let slots = self.wrenches.get_mut(..loads.map().points().len())?;
        slots.fill(Wrench::default());
        Some(slots)
    }

    /// Forces on the nodes from the wrenches on the points.
    pub(crate) fn place(&mut self, model: &Model, loads: &Acting, attitude: &Mat3<R>, q: &[R]) {
        let each = loads.map().points().zip(&self.wrenches).zip(&mut self.forces);
        for ((index, wrench), force) in each {
            let point = model.carrier(index);
            *force = point.map_or([R::of(0.0); 6], |point| on_carrier(point, wrench, attitude, q));
        }
    }
}

/// Whether a model sums forces at any place.
fn sums(model: &Model) -> bool {
    model.data().cuts.iter().any(|cut| cut.summation.is_some())
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
        InternalLoads {
            scratch: Scratch::new(model),
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
        if let Some(slots) = self.scratch.slots(loads) {
            loads.gather(&variables, slots);
        }
        self.scratch.place(model, loads, &attitude, &state.q);
        for (u, value) in self.u.iter_mut().zip(state.q_dot.iter().chain(&state.beta_star)) {
            *u = *value;
        }
        let at = At {
            q: &state.q,
            q_dot: &state.q_dot,
            u: &self.u,
            u_dot,
            beta,
            gravity: mul_t(&attitude, gravity),
            attitude,
        };
        let factor = |forces: &Projected| forces.time().value(&variables);
        for (index, (cut, found)) in model.data().cuts.iter().zip(&mut self.found).enumerate() {
            found.by_modes = by_modes(cut, at.q, at.q_dot);
            found.best = match &cut.summation {
                None => found.by_modes,
                Some(summation) => by_summation(summation, index, &at, loads, &self.scratch, factor),
            };
        }
        Ok(&self.found)
    }
}

/// The instant.
pub(crate) struct At<'a, R> {
    pub(crate) q: &'a [R],
    pub(crate) q_dot: &'a [R],
    pub(crate) u: &'a [R],
    pub(crate) u_dot: &'a [R],
    pub(crate) beta: Vec6<R>,
    /// In A.
    pub(crate) gravity: Vec3<R>,
    pub(crate) attitude: Mat3<R>,
}

/// Force in A, and moment on the rotation vector of the node, of a wrench on a point.
fn on_carrier<R: Real>(point: &Point, wrench: &Wrench<R>, attitude: &Mat3<R>, q: &[R]) -> Vec6<R> {
    let theta = split(&combine(&point.phi, q)).1;
    let (turn, tangential) = rotation_and_tangential(theta);
    let node = mat_mul(&constant(&point.node_rotation), &turn);
    let [dead, own] = wrench.in_a(attitude, &node);
    let (f, m) = (add(dead.0, own.0), add(dead.1, own.1));
    let arm = mul(&node, point.offset.map(R::of));
    join(f, mul_t(&tangential, mul_t(&node, add(m, cross(arm, f)))))
}

/// Row `a` of a row-major (6 x width) array against a vector.
fn row<R: Real>(values: &[f64], a: usize, x: &[R]) -> R {
    let width = x.len();
    let row = values.get(a * width..(a + 1) * width).unwrap_or(&[]);
    row.iter().zip(x).fold(R::of(0.0), |sum, (v, x)| sum + R::of(*v) * *x)
}

/// By the strains of the modes.
pub(crate) fn by_modes<R: Real>(cut: &CutData, q: &[R], q_dot: &[R]) -> Vec6<R> {
    let mut out = cut.rest.map(R::of);
    for (a, out) in out.iter_mut().enumerate() {
        *out += row(&cut.modal, a, q) + row(&cut.modal_rate, a, q_dot);
    }
    out
}

/// By summation of forces, at one of the model's places; `factor` is that of projected forces at the instant.
pub(crate) fn by_summation<R: Real>(
    summation: &SummationData,
    index: usize,
    at: &At<'_, R>,
    loads: &Acting,
    scratch: &Scratch<R>,
    factor: impl Fn(&Projected) -> R,
) -> Vec6<R> {
    let m = at.q.len();
    let mut out = summation.constant.map(R::of);
    for (a, out) in out.iter_mut().enumerate() {
        *out -= row(&summation.inertia, a, at.u_dot) + row(&summation.damping, a, at.q_dot);
        *out += weight(summation, a, at);
        let velocities = summation.c.get(a * 6 * (m + 6)..(a + 1) * 6 * (m + 6)).unwrap_or(&[]);
        for (c, u) in velocities.as_chunks::<6>().0.iter().zip(at.u) {
            *out -= dot_6(&c.map(R::of), &at.beta) * *u;
        }
        let turning = summation.k.get(a * 21 * m..(a + 1) * 21 * m).unwrap_or(&[]);
        for (k, q) in turning.as_chunks::<21>().0.iter().zip(at.q) {
            *out -= centrifugal(k, &at.beta) * *q;
        }
    }
    let of_loads = by_loads(summation, index, &at.attitude, loads, scratch, factor);
    out.iter_mut().zip(of_loads).for_each(|(out, x)| *out += x);
    out
}

/// What the loads alone add to the sum.
pub(crate) fn by_loads<R: Real>(
    summation: &SummationData,
    index: usize,
    attitude: &Mat3<R>,
    loads: &Acting,
    scratch: &Scratch<R>,
    factor: impl Fn(&Projected) -> R,
) -> Vec6<R> {
    let mut out = [R::of(0.0); 6];
    if let Some(direct) = loads.direct() {
        let width = summation.inertia.len() / 6;
        for (a, out) in out.iter_mut().enumerate() {
            // Generalised forces are those of forces distributed as the momenta of the modes.
            let inertia = summation.inertia.get(a * width..).unwrap_or(&[]);
            *out += R::of(direct.modal_work(inertia));
        }
    }
    for (place, force) in loads.map().points().zip(&scratch.forces) {
        let influence = summation.places.get(place * 36..(place + 1) * 36).unwrap_or(&[]);
        for (out, influence) in out.iter_mut().zip(influence.as_chunks::<6>().0) {
            *out += dot_6(&influence.map(R::of), force);
        }
    }
    for forces in loads.projected() {
        forces.add_section_forces(index, factor(forces), attitude, &mut out);
    }
    out
}

/// `N_r g_A + g_A . H_al q_l`.
fn weight<R: Real>(summation: &SummationData, a: usize, at: &At<'_, R>) -> R {
    let m = at.q.len();
    let rigid = summation.inertia.get(a * (m + 6) + m..).and_then(|row| row.first_chunk::<3>());
    let mut sum = rigid.map_or(R::of(0.0), |row| dot(row.map(R::of), at.gravity));
    let second = summation.gravity.get(a * 3 * m..(a + 1) * 3 * m).unwrap_or(&[]);
    let none = [R::of(0.0); 3];
    let each = second.as_chunks::<3>().0.iter().zip(at.q);
    let moved = each.fold(none, |sum, (h, q)| axpy(sum, *q, h.map(R::of)));
    sum += dot(moved, at.gravity);
    sum
}

/// `k_rs beta_r beta_s` over the pairs r <= s.
fn centrifugal<R: Real>(k: &[f64; 21], beta: &Vec6<R>) -> R {
    let pairs = beta.iter().enumerate().flat_map(|(r, x)| beta.iter().skip(r).map(move |y| *x * *y));
    k.iter().zip(pairs).fold(R::of(0.0), |sum, (k, pair)| sum + R::of(*k) * pair)
}

/// Influence of forces on carriers of the model on the section forces: `sum_g y_g p_g^t`, a matrix for each component.
pub(crate) fn of_forces(model: &Model, forces: &[(usize, Vec3)]) -> Vec<[Mat3; 6]> {
    let of_cut = |cut: &CutData| {
        let mut out = [[[0.0; 3]; 3]; 6];
        let places = cut.summation.as_ref().map_or(&[][..], |summation| &summation.places);
        for (carrier, p) in forces {
            let influence = places.get(36 * carrier..36 * carrier + 36).unwrap_or(&[]);
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
