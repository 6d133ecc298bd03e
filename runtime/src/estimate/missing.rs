//! What the modes miss of the motion under the loads. Deflections are those of modes that answer statically; how they move A is told as if all
//! of them had the frequency of the first that is missing, so that loads that begin suddenly are seen.

use alloc::{vec, vec::Vec};

use super::Body;
use super::instant::Instant;
use super::lines::Line;
use super::propagate::Oscillator;
use crate::data::MissingData;
use crate::dense::Dense;
use crate::expression::Variables;
use crate::four::Vectors;
use crate::loading::sealed::Acts;
use crate::loads::{DistributedFrame, LoadCase};
use crate::math::{
    Mat3, Vec3, Vec6, add, add_6, axial, axpy, cross, dot_6, join, matrix, mul, mul_t, split, sub_6,
    turn_second,
};
use crate::model::Model;

/// Residual flexibility under points and declared loads per length, and what drives it: the loads over those that the shape of a loaded
/// equilibrium has in it.
#[derive(Clone, Debug)]
pub(super) struct Missing {
    /// Index among the loaded ones of the model - (points).
    slots: Vec<Option<usize>>,
    lines: Vec<Line>,
    /// Force in A and moment in the node frame on each loaded point, then the factors on the columns of each line; at this instant over those
    /// of the equilibrium, and of the equilibrium.
    sources: Vec<f64>,
    rest: Vec<f64>,
    /// Motion of the node of every point, then of A, per unit source, and at this instant - (points + 1).
    flexibility: Dense,
    vectors: Vectors,
    motions: Vec<Vec6>,
    /// Work of forces in A and moments in the node frame of all nodes on the modes - (m x 6 points) -, and these at an instant - (points).
    work: Dense,
    on_nodes: Vec<Vec6>,
    /// How many of them are of points.
    of_points: usize,
    /// Square of the frequency of the first mode that is missing, and the oscillator of it; none where none is.
    oscillator: Option<(f64, Oscillator)>,
    interval: f64,
    /// Integral of the velocity of A, and that velocity: `(v, w)` in A.
    moved: [f64; 6],
    velocity: [f64; 6],
    /// What drives it at the last instant.
    source: Option<Vec6>,
}

impl Missing {
    /// Looked at in such intervals. `coupled`: the lines are asked for what a simplified method leaves out.
    pub(super) fn new(full: &Model, interval: f64, coupled: bool) -> Self {
        let n = full.n_points();
        let mut slots = vec![None; n];
        let data = data(full);
        for (slot, &point) in data.iter().flat_map(|it| &it.loaded).enumerate() {
            if let Some(place) = slots.get_mut(point as usize) {
                *place = Some(slot);
            }
        }
        let modes = &full.data().modes;
        // Of the same damping as the last that is there.
        let ratio = modes.damping_ratio.last().copied().unwrap_or(0.0);
        let oscillator =
            modes.next_omega.map(|omega| (omega * omega, Oscillator::new(omega, ratio, interval)));
        let n_sources = data.map_or(0, MissingData::n_sources);
        let mut this = Missing {
            slots,
            lines: data.iter().flat_map(|it| &it.lines).map(|line| Line::new(full, line, coupled)).collect(),
            sources: vec![0.0; n_sources],
            rest: vec![0.0; n_sources],
            flexibility: Dense::new(6 * (n + 1), n_sources, |row, source| {
                data.map_or(0.0, |it| flexibility(it, n, row / 6, row % 6, source))
            }),
            vectors: Vectors::of_machine(),
            motions: vec![[0.0; 6]; n + 1],
            work: Dense::new(full.n_modes(), 6 * n, |mode, at| {
                let phi = full.points.get(at / 6).and_then(|point| point.phi.get(mode));
                phi.and_then(|phi| phi.get(at % 6)).copied().unwrap_or(0.0)
            }),
            on_nodes: vec![[0.0; 6]; n],
            of_points: data.map_or(0, |it| 6 * it.loaded.len()),
            oscillator,
            interval,
            moved: [0.0; 6],
            velocity: [0.0; 6],
            source: None,
        };
        if let Some(instant) = this.equilibrium(full) {
            this.look(&instant);
            this.rest.copy_from_slice(&this.sources);
        }
        this
    }

    /// Declared loads per length.
    pub(super) fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// Begins again.
    pub(super) fn reset(&mut self) {
        (self.moved, self.velocity, self.source) = ([0.0; 6], [0.0; 6], None);
    }

    /// The loads of the equilibrium alone, undeformed from it; none where there is no equilibrium.
    fn equilibrium(&self, full: &Model) -> Option<Instant> {
        let trim = full.data().trim.as_ref()?;
        let loads = full.prepare(&LoadCase::empty("equilibrium")).ok()?;
        let mut instant = Instant::new(full, self.lines.len());
        let attitude = matrix(trim.attitude);
        let q = vec![0.0; full.n_modes()];
        let (acting, variables) = (loads.acting(), Variables::default());
        instant.gather(full, &self.lines, acting, &variables, &attitude, &q, &mut Body::default());
        Some(instant)
    }

    /// Takes in what acts.
    pub(super) fn look(&mut self, now: &Instant) {
        self.sources.iter_mut().zip(&self.rest).for_each(|(source, rest)| *source = -rest);
        let Some((points, columns)) = self.sources.split_at_mut_checked(self.of_points) else { return };
        for load in now.nodes() {
            let Some(&Some(slot)) = self.slots.get(load.point) else { continue };
            let to = points.iter_mut().skip(6 * slot);
            to.zip(join(load.force, load.moment)).for_each(|(to, value)| *to += value);
        }
        let factors = self.lines.iter().zip(now.lines()).flat_map(|(line, acting)| line.columns(acting));
        columns.iter_mut().zip(factors).for_each(|(to, factor)| *to += factor);
        self.vectors.run(
            (&self.flexibility, &self.sources, self.motions.as_flattened_mut()),
            #[inline(always)]
            |(flexibility, sources, motions)| flexibility.apply(sources, motions),
        );
    }

    /// Velocity of A in the missing motion, in A, at the next instant under the loads looked at.
    pub(super) fn advance(&mut self) -> Vec6 {
        let Some((omega2, oscillator)) = self.oscillator else { return [0.0; 6] };
        let source = self.moving_a().map(|x| omega2 * x);
        if let Some(before) = self.source {
            let ends = before.into_iter().zip(source);
            for ((moved, velocity), (s_0, s_1)) in self.moved.iter_mut().zip(&mut self.velocity).zip(ends) {
                oscillator.advance(self.interval, [s_0, s_1], moved, velocity);
            }
        }
        self.source = Some(source);
        self.velocity
    }

    /// What the loads lack, as a defect: on the missing deflection their points are elsewhere, and those that turn with the body or its
    /// nodes turn on. Rows of the elastic modes, then force and moment about the origin of A, in A - (m + 6).
    pub(super) fn defect(&mut self, full: &Model, now: &Instant, r: &mut [f64]) {
        r.fill(0.0);
        self.on_nodes.fill([0.0; 6]);
        let Some((rows, rigid)) = r.split_last_chunk_mut::<6>() else { return };
        // A, against the axes in which momentum is that of the model.
        let (shift, turn) = split(&self.moving_a());
        let mut wrench = [0.0; 6];
        for load in now.nodes() {
            let Some(point) = full.points.get(load.point) else { continue };
            let (t, theta) = split(&self.at(load.point));
            let node_turn = add(turn, mul(&point.node_rotation, theta));
            let arm = mul(&point.node_rotation, point.offset);
            let place = add(point.node_position, arm);
            let arm_turned = cross(node_turn, arm);
            let moved = add(add(t, shift), add(cross(turn, point.node_position), arm_turned));
            let mut on_node = [0.0; 6];
            let acting = load.applied.iter().zip([[0.0; 3], turn, node_turn]);
            for ((f, m), turn) in acting.filter(|(load, _)| **load != ([0.0; 3], [0.0; 3])) {
                let (turned, own) = (cross(turn, *f), cross(turn, *m));
                let moment = add(add(cross(moved, *f), cross(place, turned)), own);
                wrench = add_6(&wrench, &join(turned, moment));
                let moment = add(add(cross(arm_turned, *f), cross(arm, turned)), own);
                on_node = add_6(&on_node, &join(turned, moment));
            }
            // Rotation vectors add up, rotations do not: a virtual one of the shapes acts through the tangential operator.
            let (f, m) = split(&on_node);
            let m = axpy(mul_t(&point.node_rotation, m), -0.5, cross(theta, load.moment));
            if let Some(to) = self.on_nodes.get_mut(load.point) {
                *to = sub_6(to, &join(f, m));
            }
        }
        self.vectors.run(
            (&self.work, self.on_nodes.as_flattened(), &mut *rows),
            #[inline(always)]
            |(work, on_nodes, rows)| work.add(on_nodes, rows),
        );
        for ((index, line), acting) in self.lines.iter().enumerate().zip(now.lines()) {
            wrench = add_6(&wrench, &line.moved(acting, shift, turn));
            let elastic = rows.iter_mut().zip(line.turned_elastic(acting, turn));
            elastic.for_each(|(row, force)| *row -= force);
            wrench = add_6(&wrench, &self.line_moves(full, index, line, acting, rows));
        }
        *rigid = wrench.map(|x| -x);
        for (row, phi) in rows.iter_mut().zip(&full.phi_r) {
            *row += dot_6(phi, rigid);
        }
    }

    /// Change of force and moment of a load per length as its stations move and turn relative to A; takes what it does to the shapes
    /// relative to A off their rows.
    fn line_moves(&self, full: &Model, index: usize, line: &Line, acting: &Mat3, rows: &mut [f64]) -> Vec6 {
        let [[factor, ..], ..] = *acting;
        let readings = data(full).and_then(|it| it.lines.get(index)).map_or(&[][..], |line| &line.readings);
        if *acting == [[0.0; 3]; 3] {
            return [0.0; 6];
        }
        let mut readings = readings.chunks_exact(self.sources.len().max(1)).map(|row| {
            row.iter()
                .zip(&self.sources)
                .filter(|(_, source)| **source != 0.0)
                .map(|(a, b)| a * b)
                .sum::<f64>()
        });
        let mut vector = || -> Vec3 { core::array::from_fn(|_| readings.next().unwrap_or(0.0)) };
        match line.frame {
            DistributedFrame::Dead => {
                let dyad = [vector(), vector(), vector()];
                join([0.0; 3], axial(&turn_second(&dyad, acting)))
            }
            DistributedFrame::Body => join([0.0; 3], vector().map(|x| factor * x)),
            DistributedFrame::Follower => {
                let change = join(vector(), vector()).map(|x| factor * x);
                rows.iter_mut().zip(readings).for_each(|(row, force)| *row -= factor * force);
                change
            }
        }
    }

    /// Missing motion of the node of a point, over that in the equilibrium: translation in A, rotation in the node frame.
    pub(super) fn at(&self, index: usize) -> Vec6 {
        self.motions.get(index).copied().unwrap_or_default()
    }

    /// Integral of the velocity of A that goes with the static response.
    fn moving_a(&self) -> Vec6 {
        self.motions.last().copied().unwrap_or_default()
    }
}

/// A component of the motion of the node of a point, or of A, which comes after them, per unit source.
fn flexibility(data: &MissingData, points: usize, node: usize, component: usize, source: usize) -> f64 {
    let of_points = 6 * data.loaded.len();
    let (list, index) = match source.checked_sub(of_points) {
        None if node < points => {
            (&data.flexibility, 36 * (source / 6 * points + node) + 6 * component + source % 6)
        }
        None => (&data.rigid, 36 * (source / 6) + 6 * component + source % 6),
        Some(mut column) => {
            // The columns of the lines before come first.
            let line = data.lines.iter().find(|line| {
                let own = column < line.columns();
                column -= if own { 0 } else { line.columns() };
                own
            });
            let Some(line) = line else { return 0.0 };
            if node < points {
                (&line.flexibility, 6 * (column * points + node) + component)
            } else {
                (&line.rigid, 6 * column + component)
            }
        }
    };
    list.get(index).copied().unwrap_or(0.0)
}

fn data(full: &Model) -> Option<&MissingData> {
    full.data().validity.as_ref().map(|validity| &validity.missing)
}
