//! Declared loads per length, as the estimate of errors sees them (docs/validity.md).
//!
//! On stations at `R_g(q) = R0_g + phi_gj q_j` act `A p_g` and `A m_g`, with `A` the factor over time times `C^{AG}` (dead) or the identity (body);
//! the vectors of followers are first turned into A, `N_g p_g`, and turn on with their sections to first order. With
//!
//! ```text
//! P = sum p_g    W(q) = sum R_g p_g^t = W_0 + W_j q_j    V_j = sum d_gj m_g^t    d_gj = N_g theta_gj
//! ```
//!
//! the force is `A P`, the moment about the origin `axial(W A^t) + A sum m_g`, and the generalised forces are `(W_j + V_j) : A`.

use alloc::{vec, vec::Vec};

use crate::data::MissingLine;
use crate::loads::{DistributedFrame, DistributedLoad};
use crate::math::{
    IDENTITY, Mat3, Vec3, Vec6, add, add_dyad, axial, axpy, cross, dot, join, mul, mul_t, split, transposed,
    turn_second,
};
use crate::model::Model;
use crate::time::TimeFunction;

/// A load of a case or of the equilibrium that the model file declares.
#[derive(Clone, Debug)]
pub(crate) struct DeclaredLine {
    /// Index among the declared ones.
    pub(crate) line: usize,
    pub(crate) time: TimeFunction,
}

/// Those of some loads that the model file declares.
#[derive(Clone, Debug)]
pub(crate) struct Estimated {
    pub(crate) lines: Vec<DeclaredLine>,
    /// Whether it declares all of them.
    pub(crate) all: bool,
}

impl Default for Estimated {
    fn default() -> Self {
        Estimated { lines: Vec::new(), all: true }
    }
}

impl Estimated {
    pub(crate) fn new<'a>(model: &Model, loads: impl Iterator<Item = &'a DistributedLoad>) -> Self {
        // A simplified model has no estimate of its own.
        let full = model.full.as_deref().unwrap_or(model);
        let declared = full.data().validity.as_ref().map_or(&[][..], |validity| &validity.missing.lines);
        let mut out = Self::default();
        for load in loads {
            let same = |line: &MissingLine| {
                line.member == load.member
                    && line.frame == load.frame
                    && line.force == load.force
                    && line.moment == load.moment
            };
            match declared.iter().position(same) {
                Some(line) => out.lines.push(DeclaredLine { line, time: load.time.clone() }),
                None => out.all &= load.force.iter().chain(&load.moment).all(|x| *x == 0.0),
            }
        }
        out
    }
}

/// Sums over the stations of a declared load.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) frame: DistributedFrame,
    columns: usize,
    force: Vec3,
    moment: Vec3,
    /// `W_0`, `W_j` - (m).
    rest: Mat3,
    modal: Vec<Mat3>,
    /// `W_j + V_j` - (m).
    work: Vec<Mat3>,
    /// Change of force and moment about the origin as the sections turn with the modes; followers - (m).
    turned: Vec<Vec6>,
    /// Work of that change on the shapes, where it is asked for; followers - (m x m).
    turned_work: Vec<f64>,
}

impl Line {
    /// `coupled`: with the work of followers that turn.
    pub(super) fn new(full: &Model, data: &MissingLine, coupled: bool) -> Self {
        let m = full.n_modes();
        let follows = data.frame == DistributedFrame::Follower;
        let zero = [[0.0; 3]; 3];
        let mut out = Line {
            frame: data.frame,
            columns: data.columns(),
            force: [0.0; 3],
            moment: [0.0; 3],
            rest: zero,
            modal: vec![zero; m],
            work: vec![zero; m],
            turned: vec![[0.0; 6]; if follows { m } else { 0 }],
            turned_work: vec![0.0; if follows && coupled { m * m } else { 0 }],
        };
        let (force, moment) = (data.force.as_chunks::<3>().0, data.moment.as_chunks::<3>().0);
        let first = full.first_station(data.member as usize);
        for n in 0..force.len().max(moment.len()) {
            let at = |list: &[Vec3]| list.get(n).copied().unwrap_or([0.0; 3]);
            let Some(station) = full.carrier(first + n) else { continue };
            let in_a = |x: Vec3| if follows { mul(&station.node_rotation, x) } else { x };
            let (p, moment) = (in_a(at(force)), in_a(at(moment)));
            out.force = add(out.force, p);
            out.moment = add(out.moment, moment);
            add_dyad(&mut out.rest, station.position, p);
            for ((to, work), phi) in out.modal.iter_mut().zip(&mut out.work).zip(&station.phi) {
                let (t, theta) = split(phi);
                add_dyad(to, t, p);
                add_dyad(work, t, p);
                add_dyad(work, mul(&station.node_rotation, theta), moment);
            }
            for (row, shape) in out.turned_work.chunks_exact_mut(m.max(1)).zip(&station.phi) {
                let (t, theta) = split(shape);
                for (to, phi) in row.iter_mut().zip(&station.phi) {
                    // A moment is constant in the section, but acts through the tangential operator.
                    let turn = split(phi).1;
                    let moment = cross(turn, mul_t(&station.node_rotation, moment));
                    *to += dot(t, cross(mul(&station.node_rotation, turn), p)) + 0.5 * dot(theta, moment);
                }
            }
            for (to, phi) in out.turned.iter_mut().zip(&station.phi) {
                let turn = mul(&station.node_rotation, split(phi).1);
                let f = cross(turn, p);
                let change = join(f, add(cross(station.position, f), cross(turn, moment)));
                to.iter_mut().zip(change).for_each(|(to, change)| *to += change);
            }
        }
        out
    }

    /// `A` at a factor.
    pub(super) fn acting(&self, factor: f64, attitude: &Mat3) -> Mat3 {
        let axes = if self.frame == DistributedFrame::Dead { transposed(attitude) } else { IDENTITY };
        axes.map(|row| row.map(|x| factor * x))
    }

    /// Factors on the columns of the load.
    pub(super) fn columns<'a>(&self, acting: &'a Mat3) -> impl Iterator<Item = f64> + 'a {
        acting.as_flattened().iter().copied().take(self.columns)
    }

    /// Force, and `sum R_g f_g^t` about a place.
    pub(super) fn about(&self, acting: &Mat3, q: &[f64], place: Vec3) -> (Vec3, Mat3) {
        let mut w = self.rest;
        for (q, of_mode) in q.iter().zip(&self.modal) {
            for (row, of_mode) in w.iter_mut().zip(of_mode) {
                *row = axpy(*row, *q, *of_mode);
            }
        }
        add_dyad(&mut w, place.map(|x| -x), self.force);
        (mul(acting, self.force), turn_second(&w, acting))
    }

    /// Force and moment about the origin, in A.
    pub(super) fn wrench(&self, acting: &Mat3, q: &[f64]) -> Vec6 {
        let (force, dyad) = self.about(acting, q, [0.0; 3]);
        let mut out = join(force, add(axial(&dyad), self.own_moment(acting)));
        let turned = self.turned(acting, q);
        out.iter_mut().zip(turned).for_each(|(out, turned)| *out += turned);
        out
    }

    /// `A sum m_g`.
    pub(super) fn own_moment(&self, acting: &Mat3) -> Vec3 {
        mul(acting, self.moment)
    }

    /// Change of force and of moment about the origin as the sections turn with the modes.
    pub(super) fn turned(&self, acting: &Mat3, q: &[f64]) -> Vec6 {
        let [[factor, ..], ..] = *acting;
        let mut out = [0.0; 6];
        for (q, of_mode) in q.iter().zip(&self.turned) {
            out.iter_mut().zip(of_mode).for_each(|(out, of_mode)| *out += factor * q * of_mode);
        }
        out
    }

    /// Change of the generalised forces on the shapes relative to A as the sections turn with the modes; none where it was not asked for.
    pub(super) fn turned_on_shapes(&self, acting: &Mat3, q: &[f64]) -> impl Iterator<Item = f64> {
        let [[factor, ..], ..] = *acting;
        let rows = self.turned_work.chunks_exact(q.len().max(1));
        rows.map(move |row| factor * row.iter().zip(q).map(|(work, q)| work * q).sum::<f64>())
    }

    /// Generalised forces on the shapes relative to A - (m).
    pub(super) fn elastic(&self, acting: &Mat3) -> impl Iterator<Item = f64> {
        let acting = *acting;
        self.work
            .iter()
            .map(move |work| work.iter().zip(&acting).map(|(work, row)| dot(*work, *row)).sum::<f64>())
    }

    /// Change of force, of moment about the origin as A moves by `(shift, turn)`, loads that are not dead with it.
    pub(super) fn moved(&self, acting: &Mat3, shift: Vec3, turn: Vec3) -> Vec6 {
        let (force, dyad) = self.about(acting, &[], [0.0; 3]);
        let lever = cross(shift, force);
        if self.frame == DistributedFrame::Dead {
            let turned = transposed(&transposed(&dyad).map(|r| cross(turn, r)));
            return join([0.0; 3], add(lever, axial(&turned)));
        }
        let moment = add(axial(&dyad), self.own_moment(acting));
        join(cross(turn, force), add(lever, cross(turn, moment)))
    }

    /// Work on the shapes relative to A of the change of a load that turns with A - (m).
    pub(super) fn turned_elastic(&self, acting: &Mat3, turn: Vec3) -> impl Iterator<Item = f64> {
        let (acting, turns) = (*acting, self.frame != DistributedFrame::Dead);
        self.work
            .iter()
            .map(move |work| if turns { -dot(turn, axial(&turn_second(work, &acting))) } else { 0.0 })
    }
}
