//! What the modes of a model miss of the static response to the loads per length that its structure declares (docs/validity.md).
//!
//! A load has columns, unit loads that it is made of: with the vectors `(p_g, m_g)` of its stations `g`,
//!
//! ```text
//! dead        e_a p_gb, e_a m_gb                  9 columns (a, b), with the factors C_ab, C = C^{AG}
//! body        p_g, m_g                            one
//! follower    N_g p_g, N_g m_g                    one, to first order: N_g turns section axes into those of A
//! ```
//!
//! and it reads, of the missed motion `(t_g, theta_g)` of its stations under any column and under unit loads on the points, what turns and
//! moves it: with `F_g = N_g p_g`, `M_g = N_g m_g`, `d_g = N_g theta_g`,
//!
//! ```text
//! dead        sum t_g p_g^t                                                                    (9)
//! body        sum t_g x p_g                                                                    (3)
//! follower    sum d_g x F_g,  sum t_g x F_g + R_g x (d_g x F_g) + d_g x M_g,
//!             sum phi_gi . (d_g x F_g)                                                         (6 + m)
//! ```
//!
//! Of the second derivatives `(T_g, K_g)` of the shapes along a pair of modes, position and rotation, it reads its work and its moment by them,
//!
//! ```text
//! dead        sum T_g p_g^t + (N_g K_g) m_g^t,  sum T_g p_g^t                                  (18)
//! others      sum T_g . F_g + (N_g K_g) . M_g,  sum T_g x F_g                                  (4)
//! ```

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use rom_runtime::data::MissingLine;
use rom_runtime::loads::{DistributedFrame, DistributedLoad};

use super::modes::Modes;
use crate::carrier::{Carrier, SharedBeam};
use crate::configuration::Configuration;
use crate::element::internal_force::{split, stack};
use crate::element::shape::gauss;
use crate::mesh::Mesh;

/// Most columns that are kept: looking at them is to cost a fraction of a step.
const MOST_COLUMNS: usize = 96;

/// The loads per length that act in a load case or in the equilibrium, each vector field once; the first of them where there are many.
pub(super) fn declared(mesh: &Mesh, equilibrium: &[DistributedLoad]) -> Vec<MissingLine> {
    let mut lines: Vec<MissingLine> = Vec::new();
    let mut columns = 0;
    for load in equilibrium.iter().chain(mesh.load_cases.iter().flat_map(|case| &case.distributed)) {
        let line = MissingLine {
            member: load.member,
            frame: load.frame,
            force: load.force.clone(),
            moment: load.moment.clone(),
            ..MissingLine::default()
        };
        let acts = line.force.iter().chain(&line.moment).any(|x| *x != 0.0);
        if !acts || lines.contains(&line) {
            continue;
        }
        columns += line.columns();
        if columns > MOST_COLUMNS {
            break;
        }
        lines.push(line);
    }
    lines
}

/// A load per length on its stations.
pub(super) struct LineStations {
    frame: DistributedFrame,
    /// Number of its columns.
    columns: usize,
    stations: Vec<Station>,
}

struct Station {
    /// Nodes that carry it, with the maps of their motion into that of the section, rotations in section axes.
    placed: Vec<(usize, Matrix6<f64>)>,
    position: Vector3<f64>,
    /// `N_g`.
    axes: Matrix3<f64>,
    force: Vector3<f64>,
    moment: Vector3<f64>,
}

/// Forces on the nodes, and their resultant about the origin of A.
pub(super) struct Column {
    pub(super) nodal: Vec<Vector6<f64>>,
    pub(super) resultant: Vector6<f64>,
}

impl LineStations {
    pub(super) fn new(mesh: &Mesh, at: &Configuration, line: &MissingLine) -> Self {
        let vector = |list: &[f64], n: usize| {
            list.get(3 * n..3 * n + 3).map_or_else(Vector3::zeros, Vector3::from_column_slice)
        };
        let mut stations = Vec::new();
        for (k, element) in mesh.members[line.member as usize].elements.clone().enumerate() {
            let beam = SharedBeam::new(mesh, element);
            for (g, (x, _)) in gauss(3).iter().enumerate() {
                let (force, moment) = (vector(&line.force, 3 * k + g), vector(&line.moment, 3 * k + g));
                if force == Vector3::zeros() && moment == Vector3::zeros() {
                    continue;
                }
                let carrier = Carrier::inside(&beam, *x);
                let (position, rotation) = carrier.at(at);
                stations.push(Station {
                    placed: carrier.placed_in_section(at),
                    position,
                    axes: rotation.to_rotation_matrix().into_inner() * carrier.drawing_frame(),
                    force,
                    moment,
                });
            }
        }
        Self { frame: line.frame, columns: line.columns(), stations }
    }

    /// Every column; none where it is zero.
    pub(super) fn loads(&self, n_nodes: usize) -> Vec<Option<Column>> {
        (0..self.columns).map(|column| self.load(column, n_nodes)).collect()
    }

    fn load(&self, column: usize, n_nodes: usize) -> Option<Column> {
        let (mut nodal, mut resultant) = (vec![Vector6::zeros(); n_nodes], Vector6::zeros());
        let mut acts = false;
        for station in &self.stations {
            let (force, moment) = station.column(self.frame, column);
            if force == Vector3::zeros() && moment == Vector3::zeros() {
                continue;
            }
            acts = true;
            let on_section = stack(&force, &station.axes.tr_mul(&moment));
            for (node, map) in &station.placed {
                nodal[*node] += map.tr_mul(&on_section);
            }
            resultant += stack(&force, &(station.position.cross(&force) + moment));
        }
        acts.then_some(Column { nodal, resultant })
    }

    /// What the load reads of a motion of the nodes relative to A.
    pub(super) fn read(&self, modes: &Modes, motion: impl Fn(usize) -> Vector6<f64>) -> Vec<f64> {
        let mut dyad = Matrix3::zeros();
        let mut wrench = Vector6::zeros();
        let mut rows = vec![0.0; if self.frame == DistributedFrame::Follower { modes.m() } else { 0 }];
        for station in &self.stations {
            let (t, theta) =
                split(&station.placed.iter().map(|(node, map)| map * motion(*node)).sum::<Vector6<f64>>());
            match self.frame {
                DistributedFrame::Dead => dyad += t * station.force.transpose(),
                DistributedFrame::Body => wrench += stack(&Vector3::zeros(), &t.cross(&station.force)),
                DistributedFrame::Follower => {
                    let (force, moment) = station.column(self.frame, 0);
                    let turn = station.axes * theta;
                    let turned = turn.cross(&force);
                    let moved = t.cross(&force) + station.position.cross(&turned) + turn.cross(&moment);
                    wrench += stack(&turned, &moved);
                    for (node, map) in &station.placed {
                        let on_node = map.tr_mul(&stack(&turned, &Vector3::zeros()));
                        rows.iter_mut()
                            .zip(modes.at_node(*node))
                            .for_each(|(row, phi)| *row += phi.dot(&on_node));
                    }
                }
            }
        }
        match self.frame {
            DistributedFrame::Dead => dyad.transpose().iter().copied().collect(),
            DistributedFrame::Body => wrench.iter().skip(3).copied().collect(),
            DistributedFrame::Follower => wrench.iter().copied().chain(rows).collect(),
        }
    }
}

impl LineStations {
    /// What the load reads of second derivatives of the shapes.
    pub(super) fn read_curvature(&self, of_node: impl Fn(usize) -> Vector6<f64>) -> Vec<f64> {
        let (mut work, mut lever) = (Matrix3::zeros(), Matrix3::zeros());
        for station in &self.stations {
            let (t, k) =
                split(&station.placed.iter().map(|(node, map)| map * of_node(*node)).sum::<Vector6<f64>>());
            let (force, moment) = match self.frame {
                DistributedFrame::Dead => (station.force, station.moment),
                _ => station.column(self.frame, 0),
            };
            lever += t * force.transpose();
            work += station.axes * k * moment.transpose();
        }
        work += lever;
        match self.frame {
            DistributedFrame::Dead => {
                work.transpose().iter().chain(lever.transpose().iter()).copied().collect()
            }
            _ => {
                let axial = |i: usize, j: usize| lever[(i, j)] - lever[(j, i)];
                vec![work.trace(), axial(1, 2), axial(2, 0), axial(0, 1)]
            }
        }
    }
}

impl Station {
    /// Force and moment of a column, in A.
    fn column(&self, frame: DistributedFrame, column: usize) -> (Vector3<f64>, Vector3<f64>) {
        match frame {
            DistributedFrame::Dead => {
                let along = Vector3::ith(column / 3, 1.0);
                (along * self.force[column % 3], along * self.moment[column % 3])
            }
            DistributedFrame::Body => (self.force, self.moment),
            DistributedFrame::Follower => (self.axes * self.force, self.axes * self.moment),
        }
    }
}
