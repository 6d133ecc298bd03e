//! The view of a finite-element run: snapshots of some of its nodes.

use rom_generator::mesh::Mesh;
use rom_generator::picture::{NODES, Outline};
use rom_runtime::expression::Variables;
use rom_runtime::loads::Load;
use rom_runtime::{
    ErrorEstimate, Ledger, PointMotion, PointOutput, Reaction, RigidOutput, SectionForces, SensorReading,
};

use super::arrows::{Instant, arrows, largest, unit, wrench};
use super::basis::basis;
use super::{Body, Scene, Track, Velocity};
use crate::march::{AnyMethod, Marching};

/// Frames kept of a finite-element run.
const FRAMES: u64 = 300;

/// The structure at rest, drawn with as many nodes as a page needs. `positions` are those of all nodes in A at the equilibrium.
pub fn structure(mesh: &Mesh, positions: impl Fn(usize) -> [f64; 3]) -> Scene {
    let outline = Outline::thinned(mesh, NODES);
    Scene {
        title: "The structure in space".to_owned(),
        positions: outline.nodes.iter().flat_map(|&node| positions(node)).collect(),
        lines: outline.lines,
        ..Scene::default()
    }
}

/// A run that is filmed while it goes.
pub struct Filmed<'a> {
    run: AnyMethod<'a>,
    nodes: Vec<usize>,
    points: Vec<Filming>,
    loads: Vec<Load>,
    /// Every so many steps a frame.
    every: u64,
    dt: f64,
    steps: u64,
    frames: Frames,
}

/// A point and its displacements so far.
struct Filming {
    index: usize,
    track: Track,
    /// Attitudes of its node.
    attitudes: Vec<[f64; 4]>,
}

#[derive(Default)]
struct Frames {
    t: Vec<f64>,
    rigid: Vec<RigidOutput>,
    shapes: Vec<Vec<f64>>,
    velocities: Vec<f64>,
}

impl<'a> Filmed<'a> {
    /// Films a run of `steps` steps of `dt` (s) on `mesh` under `loads`, with tracks of the points `recorded`.
    pub fn new(
        run: AnyMethod<'a>,
        mesh: &Mesh,
        loads: &[Load],
        recorded: &[usize],
        steps: u64,
        dt: f64,
    ) -> Self {
        let loaded = |i: usize| loads.iter().any(|load| load.point as usize == i);
        let rest = |run: &AnyMethod, i: usize| {
            // At the start A is at its place: what the point is displaced by is known, so is where it rests.
            let (rigid, point) = (run.rigid(), run.point(i)?);
            let arm = nalgebra::Vector3::from(point.r_g) - nalgebra::Vector3::from(rigid.r_g);
            Some((unit(rigid.zeta).inverse() * arm - nalgebra::Vector3::from(point.dr_a)).into())
        };
        let points =
            (0..mesh.points.len()).filter(|&i| recorded.contains(&i) || loaded(i)).map(|i| Filming {
                index: i,
                track: Track {
                    name: mesh.points[i].name.clone(),
                    rest: rest(&run, i).unwrap_or_default(),
                    displacement: Vec::new(),
                },
                attitudes: Vec::new(),
            });
        let points = points.collect();
        let mut film = Self {
            points,
            nodes: Outline::thinned(mesh, NODES).nodes,
            loads: loads.to_vec(),
            every: steps.div_ceil(FRAMES).max(1),
            dt,
            steps: 0,
            frames: Frames::default(),
            run,
        };
        film.take();
        film
    }

    fn take(&mut self) {
        self.frames.t.push(self.steps as f64 * self.dt);
        self.frames.rigid.push(self.run.rigid());
        self.frames.shapes.push(self.run.node_displacements(&self.nodes));
        self.frames.velocities.extend(self.run.node_velocities(&self.nodes));
        for point in &mut self.points {
            let displacement = self.run.point(point.index).map_or([0.0; 3], |p| p.dr_a);
            point.track.displacement.extend(displacement);
            let attitude = self.run.point_motion(point.index).map_or([1.0, 0.0, 0.0, 0.0], |m| m.attitude);
            point.attitudes.push(attitude);
        }
    }

    /// What was filmed.
    pub fn into_body(self, name: &str) -> Body {
        let Self { points, loads, frames: Frames { t, rigid, shapes, velocities }, .. } = self;
        let mut all = Vec::new();
        for load in &loads {
            let Some(index) = points.iter().position(|p| p.index == load.point as usize) else { continue };
            let at = |i: usize| Instant {
                variables: Variables { t: t[i], v_a: rigid[i].v_a, w_a: rigid[i].w_a, r_g: rigid[i].r_g },
                attitude: unit(rigid[i].zeta),
                node: unit(points[index].attitudes[i]),
            };
            let wrenches: Vec<_> = (0..t.len()).map(|i| wrench(load, &at(i))).collect();
            all.extend(arrows(index, &wrenches));
        }
        let basis = basis(&shapes);
        Body {
            name: name.to_owned(),
            origin: rigid.iter().flat_map(|r| r.r_g).collect(),
            attitude: rigid.iter().flat_map(|r| r.zeta).collect(),
            shapes: basis.shapes,
            amplitudes: basis.amplitudes,
            velocity: Velocity::OfNodes(velocities),
            points: points.into_iter().map(|p| p.track).collect(),
            arrows: largest(all),
            t,
        }
    }
}

impl Marching for Filmed<'_> {
    fn advance(&mut self) -> Result<(), String> {
        self.run.advance()?;
        self.steps += 1;
        if self.steps.is_multiple_of(self.every) {
            self.take();
        }
        Ok(())
    }

    fn rigid(&self) -> RigidOutput {
        self.run.rigid()
    }

    fn amplitudes(&self) -> &[f64] {
        self.run.amplitudes()
    }

    fn point(&self, index: usize) -> Option<PointOutput> {
        self.run.point(index)
    }

    fn point_motion(&self, index: usize) -> Option<PointMotion> {
        self.run.point_motion(index)
    }

    fn sensor(&self, index: usize) -> Option<SensorReading> {
        self.run.sensor(index)
    }

    fn sections(&self) -> &[SectionForces] {
        self.run.sections()
    }

    fn reaction(&self) -> Option<Reaction> {
        self.run.reaction()
    }

    fn ledger(&self) -> Ledger {
        self.run.ledger()
    }

    fn errors(&self) -> Option<ErrorEstimate> {
        self.run.errors()
    }
}
