//! Out-of-balance forces of a configuration and their exact derivative.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use rom_runtime::expression::Variables;
use rom_runtime::loads::{Load, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;

use super::EquilibriumSettings;
use super::error::EquilibriumError;
use super::steady_motion::SteadyMotion;
use crate::assembly::{AnyBeam, Assembly, BlockMatrix};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::internal_force::{
    Stresses, force_of_stresses, internal_force, spin_tangent, split, stack, stiffness_of_stresses,
    strain_maps, stresses,
};
use crate::element::rotation_field::{MAX_RELATIVE_ROTATION, relative_rotation};
use crate::mesh::Mesh;
use crate::reference::external::{ExternalLoads, NodalForce, spin_block};

/// `Qstif + Qgyr - Qext` at a configuration.
#[derive(Clone, Debug)]
pub(crate) struct OutOfBalance {
    /// Force in A and moment in the node frame on every node, the reference node included - (nodes).
    pub(crate) nodal: Vec<Vector6<f64>>,
    /// Elastic energy, J.
    pub(crate) energy: f64,
}

/// A structure with its reference node held, under the loads of a case at an instant.
pub(crate) struct Balance<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) assembly: Assembly,
    loads: ExternalLoads,
    case_loads: Vec<Load>,
    /// Factor on each load of the case.
    pub(crate) factors: Vec<f64>,
    /// `C^{GA}`.
    pub(crate) attitude: Matrix3<f64>,
    /// Acceleration of free fall in A, m/s^2.
    gravity: Vector3<f64>,
    variables: Variables,
    motion: SteadyMotion,
    /// Whether the loads have a potential while A is held: forces constant in G or A, and no moments.
    pub(crate) have_potential: bool,
}

/// An element beyond the range of its interpolation: index and relative rotation of its nodes, rad.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TooBent {
    pub(crate) element: usize,
    pub(crate) angle: f64,
}

impl<'a> Balance<'a> {
    pub(crate) fn new(
        mesh: &'a Mesh,
        case: &LoadCase,
        settings: &EquilibriumSettings,
    ) -> Result<Self, EquilibriumError> {
        let EquilibriumSettings { time, beta, attitude, .. } = *settings;
        let (v, w) = split(&beta);
        let variables =
            Variables { t: time, v_a: v.into(), w_a: w.into(), r_g: mesh.reference_position.into() };
        let motion = SteadyMotion { beta };
        let attitude = attitude.to_rotation_matrix().into_inner();
        let follows = |l: &Load| {
            let on_reference = mesh.points[l.point as usize].node == mesh.reference;
            let turns = matches!(l.frame, LoadFrame::Follower { .. });
            !on_reference && (turns || l.moment != [0.0; 3])
        };
        let balance = Self {
            mesh,
            assembly: Assembly::new(mesh),
            loads: ExternalLoads::new(mesh, case),
            case_loads: case.loads.clone(),
            factors: vec![1.0; case.loads.len()],
            attitude,
            gravity: attitude.tr_mul(&mesh.gravity),
            variables,
            motion,
            have_potential: !case.loads.iter().any(follows),
        };
        let dead = |l: &&Load| l.frame == LoadFrame::Dead;
        if let Some(load) = case.loads.iter().find(dead).filter(|_| motion.turns()) {
            return Err(EquilibriumError::DeadLoadInTurn {
                case: case.name.clone(),
                point: mesh.points[load.point as usize].name.clone(),
            });
        }
        if motion.turns() && mesh.gravity.amax() > 0.0 {
            return Err(EquilibriumError::GravityInTurn);
        }
        let drawing = Configuration::drawing(mesh);
        let bad = balance.loads_at(&drawing).position(|l| l.force.iter().any(|x| !x.is_finite()));
        match bad {
            None => Ok(balance),
            Some(k) => Err(EquilibriumError::Load {
                load: k + 1,
                case: case.name.clone(),
                point: mesh.points[case.loads[k].point as usize].name.clone(),
                time,
            }),
        }
    }

    /// Loads at full strength, forces in A.
    fn loads_at<'b>(&'b self, at: &'b Configuration) -> impl Iterator<Item = NodalForce> + 'b {
        let one = Matrix3::identity();
        self.unit_loads_at(at).zip(&self.factors).map(move |(load, &factor)| load.seen(&one, factor))
    }

    /// Loads of the case as they are given, without the factors on them.
    fn unit_loads_at<'b>(&'b self, at: &'b Configuration) -> impl Iterator<Item = NodalForce> + 'b {
        let to_axes = self.attitude.transpose();
        self.loads
            .evaluate(self.variables, self.attitude, |node| self.attitude * at.rotation_matrix(node))
            .map(move |load| load.seen(&to_axes, 1.0))
    }

    /// Forces in A and moments in node frames of the loads, each times its `share` instead of its factor - (nodes).
    pub(crate) fn loads_of(&self, at: &Configuration, share: &[f64]) -> Vec<Vector6<f64>> {
        let mut nodal = vec![Vector6::zeros(); at.positions.len()];
        for (load, share) in self.unit_loads_at(at).zip(share) {
            nodal[load.node] += load.force * *share;
        }
        nodal
    }

    /// The loads as they are now, as constants.
    pub(crate) fn frozen_loads(&self, factor: f64) -> Vec<Load> {
        let now = |(load, own): (&Load, &f64)| {
            let value = load.time.value(&self.variables) * own * factor;
            Load { time: TimeFunction::Constant { value }, ..load.clone() }
        };
        self.case_loads.iter().zip(&self.factors).map(now).collect()
    }

    /// `Qstif + factor (Qgyr - Qext)`.
    pub(crate) fn residual(&self, at: &Configuration, factor: f64) -> OutOfBalance {
        let mut out = OutOfBalance { nodal: vec![Vector6::zeros(); at.positions.len()], energy: 0.0 };
        for beam in &self.assembly.beams {
            match beam {
                AnyBeam::Two(b) => out.add_beam(b, at),
                AnyBeam::Three(b) => out.add_beam(b, at),
            }
        }
        self.add_external(at, factor, &mut out.nodal);
        out
    }

    /// Force (N) and moment about the origin (N m), in A, that hold the reference node of a body in balance: the opposite of the sum of
    /// all that acts on it.
    pub(crate) fn reaction(&self, at: &Configuration, factor: f64) -> Vector6<f64> {
        let mut nodal = vec![Vector6::zeros(); at.positions.len()];
        self.add_external(at, factor, &mut nodal);
        let mut sum = Vector6::zeros();
        for ((applied, r), q) in nodal.iter().zip(&at.positions).zip(&at.rotations) {
            let (f, m) = split(applied);
            sum += stack(&f, &(r.cross(&f) + q * m));
        }
        sum
    }

    /// Loads and weight less the inertia forces of the steady motion on every node - (nodes).
    pub(crate) fn applied(&self, at: &Configuration) -> Vec<Vector6<f64>> {
        let mut nodal = vec![Vector6::zeros(); at.positions.len()];
        self.add_external(at, 1.0, &mut nodal);
        nodal.iter_mut().for_each(|force| *force = -*force);
        nodal
    }

    /// Inertia forces of the steady motion less weight and loads.
    fn add_external(&self, at: &Configuration, factor: f64, nodal: &mut [Vector6<f64>]) {
        self.motion.add_force(&self.assembly, at, factor, nodal);
        if self.gravity.amax() > 0.0 {
            self.assembly.visit_weight(at, &self.gravity, &mut |node, weight| nodal[node] -= weight * factor);
        }
        for load in self.loads_at(at) {
            nodal[load.node] -= load.force * factor;
        }
    }

    /// Derivative of the residual in the increments `(R, theta)` of the unknowns, `Q -> Q exp(theta~)` at `theta = 0`: material,
    /// geometric, load and centrifugal stiffness. A held frame leaves the load stiffness on the diagonal.
    pub(crate) fn tangent(&self, at: &Configuration, factor: f64, k: &mut BlockMatrix) {
        let one = Matrix3::identity();
        k.values.fill(Matrix6::zeros());
        for beam in &self.assembly.beams {
            match beam {
                AnyBeam::Two(b) => self.assembly.add(k, &b.nodes, &spin_tangent(b, &at.of(b), &[one; 2]).1),
                AnyBeam::Three(b) => self.assembly.add(k, &b.nodes, &spin_tangent(b, &at.of(b), &[one; 3]).1),
            }
        }
        self.add_external_stiffness(at, factor, k);
    }

    /// As [`Self::tangent`], with the geometric stiffness of given section forces.
    pub(crate) fn mixed_tangent(
        &self,
        at: &Configuration,
        given: &[Stresses],
        factor: f64,
        k: &mut BlockMatrix,
    ) {
        k.values.fill(Matrix6::zeros());
        for (beam, given) in self.assembly.beams.iter().zip(given) {
            match beam {
                AnyBeam::Two(b) => {
                    self.assembly.add(k, &b.nodes, &stiffness_of_stresses(b, &at.of(b), given));
                }
                AnyBeam::Three(b) => {
                    self.assembly.add(k, &b.nodes, &stiffness_of_stresses(b, &at.of(b), given));
                }
            }
        }
        self.add_external_stiffness(at, factor, k);
    }

    fn add_external_stiffness(&self, at: &Configuration, factor: f64, k: &mut BlockMatrix) {
        self.motion.add_stiffness(&self.assembly, at, factor, k);
        if self.gravity.amax() > 0.0 {
            self.assembly.add_weight_tangent(at, &self.gravity, -factor, k);
        }
        let one = Matrix3::identity();
        for load in self.loads_at(at) {
            self.assembly.add(k, &[load.node], &[[spin_block(&load.by_node_spin, &one) * -factor]]);
        }
    }

    /// Section forces that the strains make, per element.
    pub(crate) fn stresses(&self, at: &Configuration) -> Vec<Stresses> {
        let of = |beam: &AnyBeam| match beam {
            AnyBeam::Two(b) => stresses(b, &at.of(b)),
            AnyBeam::Three(b) => stresses(b, &at.of(b)),
        };
        self.assembly.beams.iter().map(of).collect()
    }

    /// Section forces that a small displacement of the unknowns adds, per element.
    pub(crate) fn stress_increments(&self, at: &Configuration, step: &[Vector6<f64>]) -> Vec<Stresses> {
        let of = |beam: &AnyBeam| match beam {
            AnyBeam::Two(b) => self.stress_increment(b, at, step),
            AnyBeam::Three(b) => self.stress_increment(b, at, step),
        };
        self.assembly.beams.iter().map(of).collect()
    }

    fn stress_increment<const N: usize>(
        &self,
        beam: &Beam<N>,
        at: &Configuration,
        step: &[Vector6<f64>],
    ) -> Stresses {
        let mut out = [Vector6::zeros(); 2];
        let maps = strain_maps(beam, &at.of(beam));
        for ((stress, map), point) in out.iter_mut().zip(&maps).zip(beam.stiffness_points()) {
            for (b, node) in map.iter().zip(beam.nodes) {
                if let Some(row) = self.assembly.unknown[node] {
                    *stress += point.stiffness * (b * step[row]);
                }
            }
        }
        out
    }

    /// Out-of-balance forces of given section forces at `to`, and of what the strains at `to` make beyond them, carried by the
    /// lever arms at `from`.
    pub(crate) fn mixed_residual(
        &self,
        from: &Configuration,
        to: &Configuration,
        given: &[Stresses],
        factor: f64,
    ) -> Vec<Vector6<f64>> {
        let mut out = vec![Vector6::zeros(); to.positions.len()];
        for (beam, given) in self.assembly.beams.iter().zip(given) {
            match beam {
                AnyBeam::Two(b) => add_mixed(&mut out, b, from, to, given),
                AnyBeam::Three(b) => add_mixed(&mut out, b, from, to, given),
            }
        }
        self.add_external(to, factor, &mut out);
        out
    }

    /// Sum of the magnitudes of all forces (N), and of all moments and forces times their distance from A's origin (N m).
    pub(crate) fn scales(&self, at: &Configuration, factor: f64) -> (f64, f64) {
        let mut nodal = vec![Vector6::zeros(); at.positions.len()];
        let (mut forces, mut moments) = self.motion.add_force(&self.assembly, at, factor, &mut nodal);
        let mut add = |node: usize, load: Vector6<f64>| {
            let (f, m) = split(&(load * factor));
            forces += f.norm();
            moments += m.norm() + at.positions[node].norm() * f.norm();
        };
        if self.gravity.amax() > 0.0 {
            self.assembly.visit_weight(at, &self.gravity, &mut add);
        }
        self.loads_at(at).for_each(|load| add(load.node, load.force));
        (forces, moments)
    }

    /// The first element beyond the range of its interpolation.
    pub(crate) fn too_bent(&self, at: &Configuration) -> Option<TooBent> {
        self.mesh.elements.iter().enumerate().find_map(|(element, e)| {
            let triads: [Matrix3<f64>; 3] = std::array::from_fn(|a| {
                let a = a.min(e.n_nodes - 1);
                at.rotation_matrix(e.nodes[a]) * e.frames[a]
            });
            let angle = relative_rotation(&triads[..e.n_nodes]);
            (angle > MAX_RELATIVE_ROTATION).then_some(TooBent { element, angle })
        })
    }

    /// Distance of the farthest node from the reference node in the drawing, m.
    pub(crate) fn size(&self) -> f64 {
        self.mesh.nodes.iter().map(Vector3::norm).fold(0.0, f64::max)
    }

    /// Node of a block row.
    pub(crate) fn node_of(&self, row: usize) -> usize {
        self.assembly.unknown.iter().position(|u| *u == Some(row)).unwrap_or(self.mesh.reference)
    }
}

fn add_mixed<const N: usize>(
    out: &mut [Vector6<f64>],
    beam: &Beam<N>,
    from: &Configuration,
    to: &Configuration,
    given: &Stresses,
) {
    let (from, to) = (from.of(beam), to.of(beam));
    let mut beyond = stresses(beam, &to);
    beyond.iter_mut().zip(given).for_each(|(b, g)| *b -= g);
    let (carried, defect) = (force_of_stresses(beam, &to, given), force_of_stresses(beam, &from, &beyond));
    for a in 0..N {
        out[beam.nodes[a]] += carried[a] + defect[a];
    }
}

impl OutOfBalance {
    fn add_beam<const N: usize>(&mut self, beam: &Beam<N>, at: &Configuration) {
        let elastic = internal_force(beam, &at.of(beam));
        self.energy += elastic.energy;
        for a in 0..N {
            self.nodal[beam.nodes[a]] += elastic.force[a];
        }
    }

    /// Largest entry over the nodes other than `held`, and its node. Infinite where it is not a number.
    pub(crate) fn worst(&self, held: usize) -> (f64, usize) {
        let size = |r: &Vector6<f64>| if r.iter().all(|x| x.is_finite()) { r.amax() } else { f64::INFINITY };
        self.nodal
            .iter()
            .enumerate()
            .filter(|(node, _)| *node != held)
            .map(|(node, r)| (size(r), node))
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((0.0, held))
    }
}
