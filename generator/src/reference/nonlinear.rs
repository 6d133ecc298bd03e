//! Nonlinear dynamics of the free-flying structure, theory section 2 without any simplification.
//!
//! The equations are those of theory (8) written for the absolute motion of the nodes: with frame A on the reference node
//! both describe the same discrete body (strains and velocities of an element do not depend on the frame), but here
//! there is no border of rigid columns and no gyroscopic coupling between frames: momentum and angular momentum are sums
//! over nodes, and the tangent is as sparse as the structure. The motion of A is read off the reference node.

use std::sync::Arc;

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use rom_runtime::Reaction;
use rom_runtime::loads::LoadCase;

use super::base::{Base, Moved};
use super::damping::Damper;
use super::external::{ExternalLoads, spin_block};
use super::motion::Motion;
use super::nodal_system::System;
pub use super::nonlinear_error::NonlinearError;
use super::scheme::Scheme;
use crate::assembly::{AnyBeam, Assembly, BlockMatrix, BlockPattern};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::inertia::mass;
use crate::element::inertia_force::{Momentum, RateFactors, momentum, section_first_moment};
use crate::element::internal_force::{internal_force, split, stack};
use crate::element::rotation_field::{MAX_RELATIVE_ROTATION, relative_rotation};
use crate::math::so3::{MatrixFunction, exp_quaternion};
use crate::mesh::{LumpedMass, Mesh};
use crate::solve::block_ldu::{Factor, SingularPivot, Symbolic};

/// Correction of a converged iteration, relative to the size of the structure (rotations: rad).
const TOLERANCE: f64 = 1e-10;
/// Iterations of one step before it is halved.
const MAX_ITERATIONS: usize = 25;
/// A correction that shrinks by less than this gets a new tangent.
const SLOW: f64 = 0.1;
/// Halvings of a step before it is given up.
const MAX_HALVINGS: u32 = 8;

/// Momenta and energies of the whole body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Total mass, kg.
    pub mass: f64,
    /// Centre of mass in G, m.
    pub centre_of_mass: Vector3<f64>,
    /// Linear momentum in G, kg m/s.
    pub linear_momentum: Vector3<f64>,
    /// Angular momentum about the origin of G, kg m^2/s.
    pub angular_momentum: Vector3<f64>,
    /// Kinetic energy, J.
    pub kinetic_energy: f64,
    /// Elastic energy, J.
    pub elastic_energy: f64,
    /// Potential energy in the field of gravity, zero with the centre of mass at the origin of G, J.
    pub gravity_energy: f64,
}

/// Damping in proportion to mass and modes; that of the strains is the elements' own.
pub struct Damping<'a> {
    /// What is damped.
    pub damper: Damper,
    /// The structure about the equilibrium of the damper.
    pub assembly: &'a Assembly,
}

/// A nonlinear simulation of one load case.
pub struct Nonlinear<'a> {
    mesh: &'a Mesh,
    beams: Vec<AnyBeam>,
    loads: ExternalLoads,
    scheme: Scheme,
    /// Size of the structure, m: scale of displacement corrections.
    size: f64,
    total_mass: f64,
    motion: Motion,
    trial: Motion,
    damping: Option<Damping<'a>>,
    /// What moves A, and what the body does to it; none in free flight.
    base: Option<Base>,
    reaction: Option<Reaction>,
    increment: Vec<[Vector3<f64>; 2]>,
    system: System,
    factor: Factor,
    /// Newton iterations and factorisations so far: what a run cost.
    pub iterations: usize,
    /// Factorisations so far.
    pub factorisations: usize,
}

impl<'a> Nonlinear<'a> {
    /// A body at rest in `at` under the loads of `case`, with accelerations in balance at t = 0.
    pub fn new(
        mesh: &'a Mesh,
        at: &Configuration,
        case: &LoadCase,
        scheme: Scheme,
    ) -> Result<Self, NonlinearError> {
        Self::from_motion(mesh, Motion::at_rest(mesh, at), case, scheme)
    }

    /// Starts from a given motion; its accelerations are computed.
    pub fn from_motion(
        mesh: &'a Mesh,
        motion: Motion,
        case: &LoadCase,
        scheme: Scheme,
    ) -> Result<Self, NonlinearError> {
        Self::started(mesh, motion, case, scheme, None, None)
    }

    /// The same with damping in proportion to mass and modes, and with something that moves frame A.
    pub fn started(
        mesh: &'a Mesh,
        motion: Motion,
        case: &LoadCase,
        scheme: Scheme,
        damping: Option<Damping<'a>>,
        base: Option<Base>,
    ) -> Result<Self, NonlinearError> {
        let n = mesh.nodes.len();
        let loads = ExternalLoads::new(mesh, case);
        let extra: Vec<[usize; 2]> = loads.coupled_nodes().collect();
        let groups =
            mesh.elements.iter().map(|e| &e.nodes[..e.n_nodes]).chain(extra.iter().map(|pair| &pair[..]));
        let pattern = Arc::new(BlockPattern::from_groups(n, groups));
        let factor = Factor::new(Arc::new(Symbolic::new(pattern.clone())));
        let size = mesh.nodes.iter().map(|r| r.norm()).fold(0.0, f64::max);
        let mut simulation = Self {
            mesh,
            beams: crate::assembly::beams(mesh),
            loads,
            scheme,
            size,
            total_mass: 0.0,
            trial: motion.clone(),
            motion,
            damping: damping.filter(|damping| damping.damper.acts()),
            base,
            reaction: None,
            increment: vec![[Vector3::zeros(); 2]; n],
            system: System { residual: vec![Vector6::zeros(); n], tangent: BlockMatrix::zeros(pattern) },
            factor,
            iterations: 0,
            factorisations: 0,
        };
        simulation.total_mass = simulation.sum_mass();
        simulation.start_accelerations()?;
        Ok(simulation)
    }

    /// The motion reached.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// What the body does to what moves or holds frame A; none in free flight.
    pub fn reaction(&self) -> Option<Reaction> {
        self.reaction
    }

    /// Advances by the scheme's step, halving it where Newton does not converge.
    pub fn step(&mut self) -> Result<(), NonlinearError> {
        self.advance(self.scheme.dt, 0)
    }

    fn advance(&mut self, dt: f64, halvings: u32) -> Result<(), NonlinearError> {
        match self.try_step(dt) {
            Err(NonlinearError::NotConverged { .. } | NonlinearError::Singular { .. })
                if halvings < MAX_HALVINGS =>
            {
                self.advance(0.5 * dt, halvings + 1)?;
                self.advance(0.5 * dt, halvings + 1)
            }
            other => other,
        }
    }

    /// One step of Newton's method with the tangent of the predictor, renewed when convergence is slow.
    fn try_step(&mut self, dt: f64) -> Result<(), NonlinearError> {
        let scheme = self.scheme.with_dt(dt);
        self.trial.time = self.motion.time + dt;
        for (node, u) in self.increment.iter_mut().enumerate() {
            let [a, b] = &self.motion.auxiliary[node];
            *u = [scheme.predict(&self.motion.velocity[node], a), scheme.predict(&self.motion.spin[node], b)];
        }
        if let Some(base) = &self.base {
            let frame = self.motion.frame(self.mesh.reference);
            let moved = base.advance(&frame, self.motion.time, self.trial.time);
            self.trial.set_frame(self.mesh.reference, &moved);
        }
        self.update_trial(&scheme);
        let mut last = f64::INFINITY;
        let mut renew = true;
        for iteration in 1..=MAX_ITERATIONS {
            self.iterations += 1;
            if renew {
                self.assemble(Some(scheme.factors()));
                self.hold();
                self.factorisations += 1;
                self.factor.refactor(&self.system.tangent).map_err(|e| self.singular(e))?;
            } else {
                self.assemble(None);
                self.hold();
            }
            let correction = self.correct();
            let failed = !correction.is_finite() || (iteration > 3 && correction > 1e3 * self.size);
            if failed || iteration == MAX_ITERATIONS {
                return Err(self.not_converged(dt, iteration));
            }
            self.update_trial(&scheme);
            if correction < TOLERANCE {
                self.check_elements()?;
                self.reaction = self.find_reaction();
                std::mem::swap(&mut self.motion, &mut self.trial);
                return Ok(());
            }
            renew = correction > SLOW * last;
            last = correction;
        }
        unreachable!("the last iteration returns")
    }

    /// Solves for the correction, applies it, and returns its size relative to the structure.
    fn correct(&mut self) -> f64 {
        self.factor.solve(&mut self.system.residual);
        let mut largest: f64 = 0.0;
        for (u, delta) in self.increment.iter_mut().zip(&self.system.residual) {
            let (x, theta) = split(delta);
            u[0] -= x;
            u[1] -= theta;
            let size = (x.amax() / self.size).max(theta.amax());
            // `max` would hide a NaN.
            largest = if size.is_nan() { f64::NAN } else { largest.max(size) };
        }
        largest
    }

    /// Positions, rotations and rates of the trial from the increments of the step.
    fn update_trial(&mut self, scheme: &Scheme) {
        let (from, to) = (&self.motion, &mut self.trial);
        let moved = self.base.as_ref().map(|_| self.mesh.reference);
        for (node, [u, theta]) in self.increment.iter().enumerate() {
            if Some(node) == moved {
                continue;
            }
            let [a, b] = &from.auxiliary[node];
            to.position[node] = from.position[node] + u;
            to.rotation[node] = from.rotation[node] * exp_quaternion(theta);
            to.rotation[node].renormalize_fast();
            let (v, a1, acceleration) = scheme.rates(u, &from.velocity[node], a, &from.acceleration[node]);
            let (w, b1, spin_rate) = scheme.rates(theta, &from.spin[node], b, &from.spin_rate[node]);
            to.velocity[node] = v;
            to.spin[node] = w;
            to.acceleration[node] = acceleration;
            to.spin_rate[node] = spin_rate;
            to.auxiliary[node] = [a1, b1];
        }
    }

    /// Where A is moved, its node has no correction.
    fn hold(&mut self) {
        if self.base.is_some() {
            self.system.hold(self.mesh.reference);
        }
    }

    /// What the body does to the base in the trial: the opposite of what its node is out of balance by.
    fn find_reaction(&mut self) -> Option<Reaction> {
        self.base.as_ref()?;
        self.assemble(None);
        let (trial, reference) = (&self.trial, self.mesh.reference);
        let frame = trial.frame(reference);
        let to_a = frame.rotation.inverse();
        let (force, moment) = split(&-self.system.residual[reference]);
        let mut loads = Vector6::zeros();
        for load in self.loads.at(trial, false) {
            for (node, force) in load.forces() {
                let (force, moment) = split(&force);
                let arm = trial.position[node] - frame.position;
                let moment = arm.cross(&force) + trial.rotation[node] * moment;
                loads += stack(&(to_a * force), &(to_a * moment));
            }
        }
        let gravity = self.mesh.gravity;
        let first_moment = self.first_moment(trial) - frame.position * self.total_mass;
        loads += stack(&(to_a * gravity * self.total_mass), &(to_a * first_moment.cross(&gravity)));
        let moved = Moved {
            frame,
            acceleration: trial.acceleration[reference],
            spin_rate: trial.spin_rate[reference],
        };
        Some(self.base.as_ref()?.reaction(&stack(&(to_a * force), &moment), &loads, &moved))
    }

    /// First moment of mass about the origin of G, kg m.
    fn first_moment(&self, motion: &Motion) -> Vector3<f64> {
        let of_beam = |beam: &AnyBeam| match beam {
            AnyBeam::Two(b) => {
                let state = motion.of(b);
                momentum(b, &state, &motion.rates_of(b, &state)).first_moment
            }
            AnyBeam::Three(b) => {
                let state = motion.of(b);
                momentum(b, &state, &motion.rates_of(b, &state)).first_moment
            }
        };
        let lumps = self.mesh.lumped.iter().map(|lump| {
            section_first_moment(&lump.mass, &motion.rotation_matrix(lump.node), &motion.position[lump.node])
        });
        self.beams.iter().map(of_beam).sum::<Vector3<f64>>() + lumps.sum::<Vector3<f64>>()
    }

    /// Residual of the trial, and its tangent in the increments where the factors of the scheme are given.
    fn assemble(&mut self, factors: Option<RateFactors>) {
        let Self { system, trial, increment, beams, mesh, loads, damping, .. } = self;
        system.residual.fill(Vector6::zeros());
        if factors.is_some() {
            system.tangent.values.fill(Matrix6::zeros());
        }
        let tangential: Vec<Matrix3<f64>> = match factors {
            Some(_) => increment.iter().map(|u| MatrixFunction::tangential(&u[1]).matrix()).collect(),
            None => Vec::new(),
        };
        for beam in beams.iter() {
            match beam {
                AnyBeam::Two(b) => system.add_beam(b, trial, &mesh.gravity, factors, &tangential),
                AnyBeam::Three(b) => system.add_beam(b, trial, &mesh.gravity, factors, &tangential),
            }
        }
        for lump in &mesh.lumped {
            system.add_lump(lump, trial, &mesh.gravity, factors, &tangential);
        }
        if let Some(Damping { damper, assembly }) = damping {
            damper.add_absolute(assembly, mesh.reference, trial, &mut system.residual);
        }
        for load in loads.at(trial, factors.is_some()) {
            load.forces().for_each(|(node, force)| system.residual[node] -= force);
            if factors.is_some() {
                for (row, column, by_spin) in load.derivatives(mesh.reference) {
                    system.add(row, column, &-spin_block(by_spin, &tangential[column]));
                }
            }
        }
    }

    /// Accelerations that balance loads, elastic and gyroscopic forces at the start.
    fn start_accelerations(&mut self) -> Result<(), NonlinearError> {
        let zero = Vector3::zeros();
        self.motion.acceleration.fill(zero);
        self.motion.spin_rate.fill(zero);
        let reference = self.mesh.reference;
        if let Some(base) = &self.base {
            let moved = base.at(&self.motion.frame(reference), self.motion.time);
            self.motion.set_frame(reference, &moved);
        }
        self.trial = self.motion.clone();
        self.assemble(None);
        self.system.tangent.values.fill(Matrix6::zeros());
        for beam in &self.beams {
            match beam {
                AnyBeam::Two(b) => self.system.add_blocks(&b.nodes, &mass(b, &self.motion.of(b)).ss),
                AnyBeam::Three(b) => self.system.add_blocks(&b.nodes, &mass(b, &self.motion.of(b)).ss),
            }
        }
        for lump in &self.mesh.lumped {
            let mut j = Matrix6::identity();
            let q = self.motion.rotation_matrix(lump.node);
            j.fixed_view_mut::<3, 3>(0, 0).copy_from(&q.transpose());
            self.system.add(lump.node, lump.node, &(j.transpose() * lump.mass * j));
        }
        self.hold();
        self.factor.refactor(&self.system.tangent).map_err(|e| self.singular(e))?;
        self.factor.solve(&mut self.system.residual);
        for (node, residual) in self.system.residual.iter().enumerate() {
            if self.base.is_some() && node == reference {
                continue;
            }
            let (a, b) = split(residual);
            self.motion.acceleration[node] = -a;
            self.motion.spin_rate[node] = -b;
            self.motion.auxiliary[node] = [-a, -b];
        }
        self.trial = self.motion.clone();
        self.reaction = self.find_reaction();
        Ok(())
    }

    /// Momenta and energies of the motion reached.
    pub fn totals(&self) -> Totals {
        let mut sum = Momentum::default();
        let mut elastic = 0.0;
        let mut add = |part: Momentum, energy: f64| {
            sum.first_moment += part.first_moment;
            sum.linear += part.linear;
            sum.angular += part.angular;
            sum.kinetic += part.kinetic;
            elastic += energy;
        };
        for beam in &self.beams {
            match beam {
                AnyBeam::Two(b) => {
                    let state = self.motion.of(b);
                    add(
                        momentum(b, &state, &self.motion.rates_of(b, &state)),
                        internal_force(b, &state).energy,
                    );
                }
                AnyBeam::Three(b) => {
                    let state = self.motion.of(b);
                    add(
                        momentum(b, &state, &self.motion.rates_of(b, &state)),
                        internal_force(b, &state).energy,
                    );
                }
            }
        }
        for lump in &self.mesh.lumped {
            add(self.lump_momentum(lump), 0.0);
        }
        Totals {
            mass: self.total_mass,
            centre_of_mass: sum.first_moment / self.total_mass,
            linear_momentum: sum.linear,
            angular_momentum: sum.angular,
            kinetic_energy: sum.kinetic,
            elastic_energy: elastic,
            gravity_energy: -self.mesh.gravity.dot(&sum.first_moment),
        }
    }

    fn lump_momentum(&self, lump: &LumpedMass) -> Momentum {
        let q = self.motion.rotation_matrix(lump.node);
        let r = self.motion.position[lump.node];
        let velocity = stack(&q.tr_mul(&self.motion.velocity[lump.node]), &self.motion.spin[lump.node]);
        let local = lump.mass * velocity;
        let (p, h) = split(&local);
        let linear = q * p;
        Momentum {
            first_moment: section_first_moment(&lump.mass, &q, &r),
            linear,
            angular: r.cross(&linear) + q * h,
            kinetic: 0.5 * velocity.dot(&local),
        }
    }

    fn sum_mass(&self) -> f64 {
        fn of<const N: usize>(b: &Beam<N>) -> f64 {
            b.inertia_points().iter().map(|p| p.weight * p.mass.fixed_view::<3, 3>(0, 0).trace() / 3.0).sum()
        }
        let beams: f64 = self
            .beams
            .iter()
            .map(|b| match b {
                AnyBeam::Two(b) => of(b),
                AnyBeam::Three(b) => of(b),
            })
            .sum();
        let lumps: f64 = self.mesh.lumped.iter().map(|l| l.mass.fixed_view::<3, 3>(0, 0).trace() / 3.0).sum();
        beams + lumps
    }

    fn check_elements(&self) -> Result<(), NonlinearError> {
        for (index, element) in self.mesh.elements.iter().enumerate() {
            let triads: [Matrix3<f64>; 3] = std::array::from_fn(|a| {
                let a = a.min(element.n_nodes - 1);
                self.trial.rotation_matrix(element.nodes[a]) * element.frames[a]
            });
            let angle = relative_rotation(&triads[..element.n_nodes]);
            if angle > MAX_RELATIVE_ROTATION {
                let member = &self.mesh.members[element.member];
                return Err(NonlinearError::CoarseElement {
                    time: self.trial.time,
                    member: member.name.clone(),
                    element: index - member.elements.start + 1,
                    degrees: angle.to_degrees(),
                });
            }
        }
        Ok(())
    }

    fn not_converged(&mut self, dt: f64, iterations: usize) -> NonlinearError {
        self.assemble(None);
        let size = |r: &Vector6<f64>| if r.iter().any(|x| !x.is_finite()) { f64::INFINITY } else { r.amax() };
        let worst = (0..self.system.residual.len())
            .max_by(|&a, &b| size(&self.system.residual[a]).total_cmp(&size(&self.system.residual[b])))
            .unwrap_or(0);
        NonlinearError::NotConverged {
            time: self.trial.time,
            dt,
            iterations,
            residual: size(&self.system.residual[worst]),
            place: self.mesh.place(worst),
        }
    }

    fn singular(&self, pivot: SingularPivot) -> NonlinearError {
        NonlinearError::Singular { time: self.trial.time, place: self.mesh.place(pivot.row) }
    }
}
