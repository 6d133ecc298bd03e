//! All methods of theory section 5 behind one interface: the same load case in, the same channels out.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};
use rom_runtime::data::ModelData;
use rom_runtime::loads::LoadCase;
use rom_runtime::{
    BaseMotion, ErrorEstimate, Integrator, Model, PointMotion, PreparedLoads, Reaction, SectionForces,
    Settings, Simulation,
};

use super::base::Base;
use super::constant_mass::NonlinearForces;
use super::damping::Damper;
use super::floating::Floating;
use super::linear::LinearForces;
use super::motion::FrameMotion;
use super::nonlinear::{Damping, Nonlinear, Totals};
use super::scheme::{Family, Scheme};
use super::start::Start;
use crate::assembly::{Assembly, BlockMatrix, MassMatrix};
use crate::carrier::Carrier;
use crate::configuration::Configuration;
use crate::element::internal_force::{split, stack};
use crate::equilibrium::Equilibrium;
use crate::math::so3::exp_quaternion;
use crate::mesh::{Mesh, Support};
use crate::section_probe::SectionProbe;

/// A method to compute the motion of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Method {
    /// Theory section 2, the reference.
    Nonlinear,
    /// Section 2 with the mass matrix of the equilibrium kept constant.
    ConstantMass,
    /// Section 3: all structural degrees of freedom, linear; rigid-body motion nonlinear.
    Linear,
    /// Section 4: the linear method on a few modes.
    Rom,
    /// Mean axes: oscillators and a rigid body, coupled only by the loads.
    MeanAxes,
    /// No elastic modes.
    Rigid,
}

impl Method {
    /// All methods, from the most to the least complete.
    pub const ALL: [Self; 6] =
        [Self::Nonlinear, Self::ConstantMass, Self::Linear, Self::Rom, Self::MeanAxes, Self::Rigid];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nonlinear => "nonlinear",
            Self::ConstantMass => "constant-mass",
            Self::Linear => "linear",
            Self::Rom => "rom",
            Self::MeanAxes => "mean-axes",
            Self::Rigid => "rigid",
        }
    }

    /// Whether the method works on the modes of a reduced model.
    pub fn is_reduced(self) -> bool {
        matches!(self, Self::Rom | Self::MeanAxes | Self::Rigid)
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Method {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let names = || Self::ALL.map(Self::name).join(", ");
        Self::ALL
            .into_iter()
            .find(|m| m.name() == name)
            .ok_or_else(|| format!("no method `{name}`; there are {}", names()))
    }
}

/// What every method tells after a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Time, s.
    pub time: f64,
    /// Motion of frame A.
    pub frame: FrameMotion,
    /// Displacement of the named points in A since the equilibrium, m - (points).
    pub dr_a: Vec<Vector3<f64>>,
    /// Positions of the named points in G, m - (points).
    pub r_g: Vec<Vector3<f64>>,
    /// Attitudes, velocities and accelerations of the named points - (points).
    pub motion: Vec<PointMotion>,
    /// Modal amplitudes; empty for methods without modes - (m).
    pub q: Vec<f64>,
    /// Their rates, 1/s; none for the others.
    pub q_dot: Vec<f64>,
    /// Momenta and energies.
    pub totals: Totals,
    /// Estimated errors so far, of the methods that know what they leave out.
    pub errors: Option<ErrorEstimate>,
    /// What the body does to what moves or holds frame A; none in free flight.
    pub reaction: Option<Reaction>,
    /// Section forces at the places of the structure file - (places).
    pub sections: Vec<SectionForces>,
}

/// A run of one load case by one method.
pub trait Run {
    /// Advances by one step.
    ///
    /// # Errors
    /// When the numbers fail, in words: when, where and what to do.
    fn step(&mut self) -> Result<(), String>;

    /// The state reached.
    fn output(&self) -> Output;

    /// Displacements of these nodes of the mesh in A since the equilibrium, m; empty for the reduced methods, whose amplitudes
    /// say it all.
    fn node_displacements(&self, nodes: &[usize]) -> Vec<Vector3<f64>>;

    /// Velocities of these nodes in G, m/s; as the displacements.
    fn node_velocities(&self, nodes: &[usize]) -> Vec<Vector3<f64>>;
}

/// Time marching settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunSettings {
    /// Time step, s.
    pub dt: f64,
    /// Integrator; the finite-element methods have the implicit ones only.
    pub integrator: Integrator,
    /// Numerical damping of the implicit integrators.
    pub numerical_damping: f64,
}

/// A structure about its equilibrium, ready for every method.
pub struct Prepared {
    /// The mesh.
    pub mesh: Mesh,
    /// Shape at the equilibrium.
    pub at: Configuration,
    /// The equilibrium; none about the drawing.
    pub equilibrium: Option<Equilibrium>,
    /// What carries each named point.
    pub(crate) carriers: Vec<Carrier>,
    pub(crate) assembly: Assembly,
    pub(crate) mass: MassMatrix,
    pub(crate) stiffness: BlockMatrix,
    /// `Qstif_S(eta0)` over the block rows.
    pub(crate) elastic_force: Vec<Vector6<f64>>,
    /// Places where section forces are told.
    pub(crate) probes: Vec<SectionProbe>,
}

impl Prepared {
    /// About the drawing of a mesh.
    pub fn new(mesh: Mesh) -> Self {
        Self::about(mesh, None)
    }

    /// About an equilibrium, whose loads act in every run; none: about the drawing.
    pub fn about(mesh: Mesh, equilibrium: Option<Equilibrium>) -> Self {
        let drawing = || Configuration::drawing(&mesh);
        let at = equilibrium.as_ref().map_or_else(drawing, |found| found.configuration.clone());
        let assembly = Assembly::new(&mesh);
        let (mass, stiffness) = (assembly.mass(&at), assembly.stiffness(&at));
        let unloaded = || vec![Vector6::zeros(); assembly.n_blocks()];
        let elastic_force =
            equilibrium.as_ref().map_or_else(unloaded, |found| assembly.gather(&found.elastic_force));
        let carriers = Carrier::of_points(&mesh);
        let probes = mesh.cuts.iter().map(|cut| SectionProbe::new(&mesh, cut)).collect();
        Self { mesh, at, equilibrium, carriers, assembly, mass, stiffness, elastic_force, probes }
    }

    /// A load case together with the loads of the equilibrium.
    pub(crate) fn with_trim(&self, case: &LoadCase) -> LoadCase {
        let trim = self.equilibrium.iter().flat_map(|found| &found.loads);
        let spread = self.equilibrium.iter().flat_map(|found| &found.distributed);
        LoadCase {
            loads: trim.chain(&case.loads).cloned().collect(),
            distributed: spread.chain(&case.distributed).cloned().collect(),
            ..case.clone()
        }
    }

    /// What moves frame A in a load case, or the clamp that holds it; none in free flight.
    pub(crate) fn base(&self, case: &LoadCase) -> Option<Base> {
        let clamp = || (self.mesh.support == Support::Clamped).then_some(BaseMotion::HELD);
        Some(Base::new(case.motion.clone().or_else(clamp)?, self.mass.rr))
    }

    /// Shape after displacements `(R, theta)` of the block rows from the equilibrium.
    pub(crate) fn displaced(&self, x: &[Vector6<f64>]) -> Configuration {
        let mut out = self.at.clone();
        for (node, unknown) in self.assembly.unknown.iter().enumerate() {
            if let Some(i) = unknown {
                let (r, theta) = split(&x[*i]);
                out.positions[node] += r;
                out.rotations[node] *= exp_quaternion(&theta);
            }
        }
        out
    }

    /// Total mass (kg) and `M_RR`.
    pub fn rigid_mass(&self) -> (f64, Matrix6<f64>) {
        (Assembly::centre_of_mass(&self.mass.rr).0, self.mass.rr)
    }

    /// Starts a finite-element method as the load case says.
    ///
    /// # Errors
    /// A reduced method, an explicit integrator, or a failure of the start, in words.
    pub fn start<'a>(
        &'a self,
        method: Method,
        case: &LoadCase,
        settings: &RunSettings,
    ) -> Result<Box<dyn Run + 'a>, String> {
        let family = match settings.integrator {
            Integrator::Newmark => Family::Newmark,
            Integrator::GeneralizedAlpha => Family::GeneralizedAlpha,
            other => {
                return Err(format!(
                    "method {method} has no integrator `{other}`; take newmark or gen-alpha"
                ));
            }
        };
        let scheme = Scheme::new(family, settings.dt, settings.numerical_damping);
        let (case, start) = (&self.with_trim(case), Start::of_case(self, case, method)?);
        let damper = Damper::new(self)?;
        match method {
            Method::Nonlinear => {
                let damping = Some(Damping { damper, assembly: &self.assembly });
                let run = Nonlinear::started(
                    &self.mesh,
                    start.motion(self),
                    case,
                    scheme,
                    damping,
                    self.base(case),
                )
                .map_err(|e| e.to_string())?;
                Ok(Box::new(NonlinearRun { prepared: self, run }))
            }
            Method::Linear => Ok(Box::new(Floating::new(
                self,
                &start,
                case,
                scheme,
                LinearForces::new(self).with_damper(damper),
            )?)),
            Method::ConstantMass => Ok(Box::new(Floating::new(
                self,
                &start,
                case,
                scheme,
                NonlinearForces::new(self).with_damper(damper),
            )?)),
            _ => Err(format!("method {method} runs on a reduced model")),
        }
    }
}

/// Steps between two looks at what a reduced method leaves out.
const ERRORS_EVERY: u32 = 4;

/// Starts a reduced method as the load case says.
///
/// # Errors
/// A method on finite elements, settings or loads that do not fit the model, in words.
pub fn start_reduced(
    model: &Arc<Model>,
    method: Method,
    case: &LoadCase,
    settings: &RunSettings,
) -> Result<Box<dyn Run>, String> {
    let simpler = |method| model.with_method(method).map(Arc::new).map_err(|e| e.to_string());
    let model = match method {
        Method::Rom => Arc::clone(model),
        Method::MeanAxes => simpler(rom_runtime::Method::MeanAxes)?,
        Method::Rigid => simpler(rom_runtime::Method::Rigid)?,
        _ => return Err(format!("method {method} does not run on a reduced model")),
    };
    let loads = model.prepare(case).map_err(|e| e.to_string())?;
    let settings = Settings {
        dt: settings.dt,
        integrator: settings.integrator,
        numerical_damping: settings.numerical_damping,
        ..Settings::default()
    };
    let start = model.initial_state(case).map_err(|e| e.to_string())?;
    let mut simulation = Simulation::new(model, settings).map_err(|e| e.to_string())?;
    simulation.restore(&start).map_err(|e| e.to_string())?;
    simulation.find_section_forces(&loads).map_err(|e| e.to_string())?;
    simulation.watch_errors(ERRORS_EVERY);
    Ok(Box::new(ReducedRun { simulation, loads }))
}

struct NonlinearRun<'a> {
    prepared: &'a Prepared,
    run: Nonlinear<'a>,
}

impl NonlinearRun<'_> {
    fn sections(&self) -> Vec<SectionForces> {
        let motion = self.run.motion();
        let origin = motion.velocity[self.prepared.mesh.reference];
        let of_probe = |probe: &SectionProbe| {
            probe.stress_moving(
                &self.prepared.assembly.beams,
                |node| motion.position[node],
                |node| motion.rotation[node].to_rotation_matrix().into_inner(),
                |node| stack(&(motion.velocity[node] - origin), &motion.spin[node]),
            )
        };
        self.prepared.probes.iter().map(of_probe).map(told).collect()
    }
}

/// Section forces of a finite-element method, which knows but one way to them.
pub(super) fn told(stress: Vector6<f64>) -> SectionForces {
    SectionForces { best: stress.into(), by_modes: stress.into() }
}

impl Run for NonlinearRun<'_> {
    fn step(&mut self) -> Result<(), String> {
        self.run.step().map_err(|e| e.to_string())
    }

    fn output(&self) -> Output {
        let (mesh, at, motion) = (&self.prepared.mesh, &self.prepared.at, self.run.motion());
        let frame = motion.frame(mesh.reference);
        let mut out = Output {
            time: motion.time,
            frame,
            dr_a: Vec::new(),
            r_g: Vec::new(),
            motion: Vec::new(),
            q: Vec::new(),
            q_dot: Vec::new(),
            totals: self.run.totals(),
            errors: None,
            reaction: self.run.reaction(),
            sections: self.sections(),
        };
        for (p, carrier) in mesh.points.iter().zip(&self.prepared.carriers) {
            let now = carrier.motion(|node| motion.of_node(node));
            let (r0, q0) = carrier.at(at);
            let r = now.position + now.rotation * p.offset;
            out.dr_a.push(frame.rotation.inverse() * (r - frame.position) - (r0 + q0 * p.offset));
            out.r_g.push(r);
            out.motion.push(now.of_point(&p.offset));
        }
        out
    }

    fn node_displacements(&self, nodes: &[usize]) -> Vec<Vector3<f64>> {
        let motion = self.run.motion();
        let frame = motion.frame(self.prepared.mesh.reference);
        let to_a = frame.rotation.inverse();
        let rest = &self.prepared.at.positions;
        nodes.iter().map(|&node| to_a * (motion.position[node] - frame.position) - rest[node]).collect()
    }

    fn node_velocities(&self, nodes: &[usize]) -> Vec<Vector3<f64>> {
        nodes.iter().map(|&node| self.run.motion().velocity[node]).collect()
    }
}

struct ReducedRun {
    simulation: Simulation,
    loads: PreparedLoads,
}

impl Run for ReducedRun {
    fn step(&mut self) -> Result<(), String> {
        self.simulation.step(&self.loads).map_err(|e| e.to_string())?;
        self.simulation.find_section_forces(&self.loads).map(|_| ()).map_err(|e| e.to_string())
    }

    fn output(&self) -> Output {
        let (simulation, state) = (&self.simulation, self.simulation.state());
        let data: &ModelData = simulation.model().data();
        let rigid = simulation.rigid_output();
        let [w, i, j, k] = rigid.zeta;
        let points: Vec<_> = (0..data.points.len()).filter_map(|p| simulation.point_output(p)).collect();
        let ledger = simulation.ledger();
        Output {
            time: state.time,
            frame: FrameMotion {
                position: rigid.r_g.into(),
                rotation: UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, i, j, k)),
                velocity: rigid.v_g.into(),
                spin: rigid.w_a.into(),
            },
            dr_a: points.iter().map(|p| p.dr_a.into()).collect(),
            r_g: points.iter().map(|p| p.r_g.into()).collect(),
            motion: (0..data.points.len()).filter_map(|p| simulation.point_motion(p)).collect(),
            q: state.q.clone(),
            q_dot: state.q_dot.clone(),
            totals: Totals {
                mass: data.rigid.mass,
                centre_of_mass: ledger.r_cm_g.into(),
                linear_momentum: ledger.linear_momentum_g.into(),
                angular_momentum: ledger.angular_momentum_g.into(),
                kinetic_energy: ledger.kinetic_energy,
                elastic_energy: ledger.elastic_energy,
                gravity_energy: ledger.gravity_energy,
            },
            errors: simulation.error_estimate(),
            reaction: simulation.reaction(),
            sections: simulation.section_forces().to_vec(),
        }
    }

    fn node_displacements(&self, _: &[usize]) -> Vec<Vector3<f64>> {
        Vec::new()
    }

    fn node_velocities(&self, _: &[usize]) -> Vec<Vector3<f64>> {
        Vec::new()
    }
}
