//! What acts at an instant.

use alloc::{vec, vec::Vec};

use super::defect::NodeLoad;
use super::lines::Line;
use super::propagate::Body;
use crate::expression::Variables;
use crate::loading::{Acting, Wrench};
use crate::math::{Mat3, add, add_dyad, axial, combine, cross, join, mat_mul, mul, mul_t, split, sub};
use crate::model::Model;

/// Loads on the nodes of points and declared loads per length.
#[derive(Clone, Debug)]
pub(super) struct Instant {
    /// Of all carriers that are loaded one by one, stations among them.
    wrenches: Vec<Wrench>,
    nodes: Vec<NodeLoad>,
    n_nodes: usize,
    /// `A` of every declared load, zero where it does not act.
    lines: Vec<Mat3>,
}

impl Instant {
    /// Room for what can act on a model.
    pub(super) fn new(full: &Model, n_lines: usize) -> Self {
        Instant {
            wrenches: vec![Wrench::default(); full.n_carriers()],
            nodes: vec![NodeLoad::default(); full.n_points()],
            n_nodes: 0,
            lines: vec![[[0.0; 3]; 3]; n_lines],
        }
    }

    pub(super) fn nodes(&self) -> &[NodeLoad] {
        self.nodes.get(..self.n_nodes).unwrap_or_default()
    }

    /// `A` of every declared load.
    pub(super) fn lines(&self) -> &[Mat3] {
        &self.lines
    }

    /// Takes in what acts, and tells the body what of it turns with it.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn gather(
        &mut self,
        full: &Model,
        lines: &[Line],
        loads: &Acting,
        variables: &Variables,
        attitude: &Mat3,
        q: &[f64],
        body: &mut Body,
    ) {
        (body.turning_force, body.turning_moment, body.virial) = ([0.0; 3], [0.0; 3], [[0.0; 3]; 3]);
        self.gather_nodes(full, loads, variables, attitude, q, body);
        self.lines.fill([[0.0; 3]; 3]);
        for declared in &loads.estimated.lines {
            let (Some(line), Some(sum)) = (lines.get(declared.line), self.lines.get_mut(declared.line))
            else {
                continue;
            };
            let acting = line.acting(declared.time.value(variables), attitude);
            for (row, acting) in sum.iter_mut().zip(acting) {
                *row = add(*row, acting);
            }
        }
        for (line, acting) in lines.iter().zip(&self.lines) {
            if *acting == [[0.0; 3]; 3] {
                continue;
            }
            let c = full.centre_of_mass;
            let (force, dyad) = line.about(acting, q, c);
            if line.frame == crate::loads::DistributedFrame::Dead {
                // C^{GA} (sum r f^t) C^{AG}.
                let in_g = mat_mul(attitude, &dyad).map(|row| mul(attitude, row));
                add_to(&mut body.virial, &in_g);
            } else {
                let (f, m) = split(&line.turned(acting, q));
                let moment = add(add(axial(&dyad), line.own_moment(acting)), sub(m, cross(c, f)));
                body.turning_force = add(body.turning_force, mul(attitude, add(force, f)));
                body.turning_moment = add(body.turning_moment, mul(attitude, moment));
            }
        }
    }

    /// Loads on the nodes of points.
    fn gather_nodes(
        &mut self,
        full: &Model,
        loads: &Acting,
        variables: &Variables,
        attitude: &Mat3,
        q: &[f64],
        body: &mut Body,
    ) {
        let loaded = loads.loaded();
        let n = loaded.len().min(self.wrenches.len());
        self.n_nodes = 0;
        let Some(wrenches) = self.wrenches.get_mut(..n) else { return };
        wrenches.fill(Wrench::default());
        loads.gather_all(variables, wrenches);
        for (&index, wrench) in loaded.iter().zip(wrenches.iter()) {
            // Stations are no points.
            let (Some(point), Some(node)) = (full.points.get(index), self.nodes.get_mut(self.n_nodes)) else {
                continue;
            };
            self.n_nodes += 1;
            let (translation, theta) = split(&combine(&point.phi, q));
            let (turn, tangential) = crate::math::rotation_and_tangential(theta);
            let rotation = mat_mul(&point.node_rotation, &turn);
            let dead = (mul_t(attitude, wrench.dead.0), mul_t(attitude, wrench.dead.1));
            let turned = (mul(&rotation, wrench.node.0), mul(&rotation, wrench.node.1));
            let own = (add(wrench.body.0, turned.0), add(wrench.body.1, turned.1));
            let arm = mul(&rotation, point.offset);
            let lever = sub(add(add(point.node_position, translation), arm), full.centre_of_mass);
            let force = add(dead.0, own.0);
            let moment = add(add(dead.1, own.1), cross(arm, force));
            let node_moment = mul_t(&tangential, mul_t(&rotation, moment));
            let applied = [dead, wrench.body, turned];
            *node = NodeLoad { point: index, force, moment: node_moment, applied };
            if own != ([0.0; 3], [0.0; 3]) {
                body.turning_force = add(body.turning_force, mul(attitude, own.0));
                body.turning_moment =
                    add(body.turning_moment, mul(attitude, add(own.1, cross(lever, own.0))));
            }
            add_dyad(&mut body.virial, mul(attitude, lever), mul(attitude, dead.0));
        }
    }

    /// Takes the generalised forces off the rows of the shapes relative to A, and gives the resultant about the origin of A.
    pub(super) fn take_off(&self, full: &Model, lines: &[Line], q: &[f64], rows: &mut [f64]) -> [f64; 6] {
        let mut external = [0.0; 6];
        let mut add_wrench = |wrench: [f64; 6]| {
            external.iter_mut().zip(wrench).for_each(|(sum, value)| *sum += value);
        };
        for load in self.nodes() {
            let Some(point) = full.points.get(load.point) else { continue };
            for (row, phi) in rows.iter_mut().zip(&point.phi) {
                *row -= crate::math::dot_6(phi, &join(load.force, load.moment));
            }
            let (translation, theta) = split(&combine(&point.phi, q));
            let rotation = mat_mul(&point.node_rotation, &crate::math::rotation(theta));
            let place = add(add(point.node_position, translation), mul(&rotation, point.offset));
            for (force, moment) in load.applied {
                add_wrench(join(force, add(moment, cross(place, force))));
            }
        }
        for (line, acting) in lines.iter().zip(&self.lines) {
            rows.iter_mut().zip(line.elastic(acting)).for_each(|(row, force)| *row -= force);
            rows.iter_mut().zip(line.turned_on_shapes(acting, q)).for_each(|(row, force)| *row -= force);
            add_wrench(line.wrench(acting, q));
        }
        external
    }
}

fn add_to(sum: &mut Mat3, value: &Mat3) {
    for (row, value) in sum.iter_mut().zip(value) {
        *row = add(*row, *value);
    }
}
