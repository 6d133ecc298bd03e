//! A structure under a load case, ready to be run by any method.

use std::sync::Arc;

use rom_generator::ResidualSelection;
use rom_generator::build::{BuildOptions, Elastic, Inertia, ModeSelection, build_mesh, provenance};
use rom_generator::equilibrium::trim::{self, About};
use rom_generator::input::Structure;
use rom_generator::mesh::{Mesh, Support};
use rom_generator::reference::method::{Method, Prepared, RunSettings, start_reduced};
use rom_runtime::data::ModelData;
use rom_runtime::loads::{DistributedLoad, Load, LoadCase};
use rom_runtime::{Integrator, Model};
use serde_json::{Map, Value, json};

use crate::describe;
use crate::march::{AnyMethod, HELP_REDUCED, Outcome, Recording, record};
use crate::run::{RunFacts, TimeGrid};
use crate::scene::{self, Scene, film};
use crate::text::{significant, thousands};

/// What to do when a finite-element method fails.
const HELP_STRUCTURAL: &str = "The results until then are written. Look at them for what grows; take a shorter --dt, a finer mesh or smaller loads.";

/// A structure, a load case and how to march it.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The structure.
    pub structure: Structure,
    /// Its mesh; points may have been added to those of the structure.
    pub mesh: Mesh,
    /// Loads.
    pub case: LoadCase,
    /// Instants. Every one of them is recorded; `every` says which are to be written to files.
    pub grid: TimeGrid,
    /// Integrator.
    pub integrator: Integrator,
    /// Its numerical damping.
    pub numerical_damping: f64,
    /// Points to record: index in the mesh, and name.
    pub points: Vec<(usize, String)>,
    /// Points that the reduced methods have residual modes for; the rigid body has none.
    pub residual: ResidualSelection,
    /// The shape that linearised methods are about, where the structure has an equilibrium.
    pub about: About,
    /// Mass matrix and elastic forces of the reduced method.
    pub dynamics: (Inertia, Elastic),
}

impl Setup {
    /// A load case as its author ran it, all points recorded.
    ///
    /// # Errors
    /// Time settings of the load case that make no grid, in words.
    pub fn new(structure: Structure, mesh: Mesh, case: LoadCase) -> Result<Self, String> {
        let grid = TimeGrid::new(case.dt, case.t_end, 1).map_err(|e| format!("{}: {}", e.message, e.help))?;
        let points = mesh.points.iter().map(|p| p.name.clone()).enumerate().collect();
        let numerical_damping = case.numerical_damping;
        Ok(Self {
            structure,
            mesh,
            case,
            grid,
            integrator: Integrator::Newmark,
            numerical_damping,
            points,
            residual: ResidualSelection::None,
            about: About::default(),
            dynamics: Default::default(),
        })
    }

    /// Runs the load case by one method. `modes` is for the reduced methods; the rigid one has none whatever it says.
    /// `progress` is told the number of steps made.
    ///
    /// # Errors
    /// When the method cannot start, in words. A run that fails later is an outcome with the reason in it.
    pub fn run(
        &self,
        method: Method,
        modes: &ModeSelection,
        tool: &str,
        progress: impl FnMut(u64),
    ) -> Result<Outcome, String> {
        Ok(self.run_filmed(method, modes, tool, false, progress)?.0)
    }

    /// As [`Self::run`]; where the run is to be filmed its motion in space comes with it.
    ///
    /// # Errors
    /// Those of [`Self::run`].
    pub fn run_filmed(
        &self,
        method: Method,
        modes: &ModeSelection,
        tool: &str,
        film: bool,
        progress: impl FnMut(u64),
    ) -> Result<(Outcome, Option<Scene>), String> {
        if method.is_reduced() {
            self.run_reduced(method, modes, tool, film, progress)
        } else {
            self.run_full(method, tool, film, progress)
        }
    }

    fn run_full(
        &self,
        method: Method,
        tool: &str,
        film: bool,
        mut progress: impl FnMut(u64),
    ) -> Result<(Outcome, Option<Scene>), String> {
        let mesh = self.mesh_for(method);
        let equilibrium = trim::of_mesh(&mesh).map_err(|e| e.to_string())?;
        let prepared = Prepared::about(mesh, equilibrium);
        let mut run = AnyMethod::new(prepared.start(method, &self.case, &self.run_settings())?);
        let recording = self.recording(Vec::new(), HELP_STRUCTURAL);
        let metadata = self.metadata(method, tool);
        if !film {
            return Ok((record(&mut run, &recording, metadata, |n, _| progress(n)), None));
        }
        let trim = prepared.equilibrium.iter().flat_map(|found| &found.loads);
        let loads: Vec<Load> = trim.chain(&self.case.loads).cloned().collect();
        let recorded: Vec<usize> = self.points.iter().map(|(index, _)| *index).collect();
        let grid = &self.grid;
        let mut filmed = film::Filmed::new(run, &self.mesh, &loads, &recorded, grid.steps, grid.dt);
        let outcome = record(&mut filmed, &recording, metadata, |n, _| progress(n));
        let scene = film::structure(&self.mesh, |node| prepared.at.positions[node].into());
        Ok((outcome, Some(Scene { bodies: vec![filmed.into_body(method.name())], ..scene })))
    }

    /// The mesh with the shape that a method is about; those with nonlinear elastic forces are about the equilibrium.
    fn mesh_for(&self, method: Method) -> Mesh {
        let mut mesh = self.mesh.clone();
        if let Some(trim) = &mut mesh.trim {
            let linearised = !matches!(method, Method::Nonlinear | Method::ConstantMass);
            trim.about = if linearised { self.about } else { About::Equilibrium };
        }
        mesh
    }

    fn run_reduced(
        &self,
        method: Method,
        modes: &ModeSelection,
        tool: &str,
        film: bool,
        progress: impl FnMut(u64),
    ) -> Result<(Outcome, Option<Scene>), String> {
        let data = self.model_data(modes)?;
        let model = Arc::new(Model::new(data).map_err(|e| e.to_string())?);
        self.run_model(&model, method, tool, film, progress)
    }

    /// Runs the load case on a reduced model of the structure.
    ///
    /// # Errors
    /// As [`Setup::run`].
    pub fn run_model(
        &self,
        model: &Arc<Model>,
        method: Method,
        tool: &str,
        film: bool,
        mut progress: impl FnMut(u64),
    ) -> Result<(Outcome, Option<Scene>), String> {
        // The rigid body is made from the model with modes, which knows what the body leaves out.
        let none = method == Method::Rigid;
        let numbers = if none { Vec::new() } else { model.data().modes.number.clone() };
        let run = start_reduced(model, method, &self.case, &self.run_settings())?;
        let recording = self.recording(numbers, HELP_REDUCED);
        let outcome =
            record(&mut AnyMethod::new(run), &recording, self.metadata(method, tool), |n, _| progress(n));
        let scene = if film {
            scene::of_run(model.data(), &self.case, &outcome.results, method.name())
        } else {
            None
        };
        Ok((outcome, scene))
    }

    /// The reduced model of the structure.
    ///
    /// # Errors
    /// Why it cannot be built, in words.
    pub fn model_data(&self, modes: &ModeSelection) -> Result<ModelData, String> {
        let (inertia, elastic) = self.dynamics;
        let options = BuildOptions {
            modes: modes.clone(),
            residual: self.residual.clone(),
            // Loads along members need the members.
            all_nodes: !self.case.distributed.is_empty(),
            inertia,
            elastic,
        };
        let provenance = provenance(&self.structure, &options, &self.mesh);
        build_mesh(&self.mesh_for(Method::Rom), provenance, &options, &mut |_| ()).map_err(|e| e.to_string())
    }

    fn run_settings(&self) -> RunSettings {
        RunSettings {
            dt: self.grid.dt,
            integrator: self.integrator,
            numerical_damping: self.numerical_damping,
        }
    }

    fn recording(&self, modes: Vec<u32>, help: &'static str) -> Recording {
        Recording {
            grid: TimeGrid { every: 1, ..self.grid },
            points: self.points.clone(),
            point_motion: false,
            rates: true,
            sensors: Vec::new(),
            sections: self.mesh.cuts.iter().map(|cut| cut.name.clone()).collect(),
            modes,
            reaction: self.case.motion.is_some() || self.mesh.support == Support::Clamped,
            help,
        }
    }

    /// Facts for the result file: nothing that differs when the same run is made again.
    fn metadata(&self, method: Method, tool: &str) -> Map<String, Value> {
        let facts = json!({
            "tool": tool,
            "structure": self.structure.name(),
            "parameters": self.structure.parameters(),
            "load_case": self.case.name,
            "method": method.name(),
            "integrator": self.integrator.name(),
            "dt": self.grid.dt,
            "t_end": self.grid.t_end,
            "every": self.grid.every,
            "numerical_damping": self.numerical_damping,
        });
        match facts {
            Value::Object(map) => map,
            _ => Map::new(),
        }
    }

    /// What the report and the summary of a run say about it.
    pub fn facts(&self, method: Method, modes: &str, command: &str, tool: &str) -> RunFacts {
        let load = |load: &Load| {
            let point = self.mesh.points.get(load.point as usize);
            let sections = point.into_iter().flat_map(|p| &p.sections);
            let frames = sections
                .map(|(member, e)| (member.as_str(), [0, 1, 2].map(|i| [0, 1, 2].map(|j| e[(i, j)]))));
            describe::load_at(load, point.map(|p| p.name.as_str()), frames)
        };
        let spread = |load: &DistributedLoad| {
            let member = self.mesh.members.get(load.member as usize);
            describe::distributed(load, member.map(|m| m.name.as_str()))
        };
        RunFacts {
            structure: self.structure.name().to_owned(),
            file: self.structure.file_name().to_owned(),
            load_case: self.case.name.clone(),
            description: self.case.description.clone(),
            method: method.name().to_owned(),
            integrator: self.integrator.name().to_owned(),
            numerical_damping: self.numerical_damping,
            grid: self.grid,
            command: command.to_owned(),
            tool: tool.to_owned(),
            model: self.model_facts(method, modes),
            loads: self.case.loads.iter().map(load).chain(self.case.distributed.iter().map(spread)).collect(),
            input_text: self.structure.text().to_owned(),
        }
    }

    fn model_facts(&self, method: Method, modes: &str) -> Vec<(String, String)> {
        let nodes = self.mesh.nodes.len() as f64;
        let list = |items: Vec<String>| if items.is_empty() { "none".to_owned() } else { items.join(", ") };
        let parameters =
            self.structure.parameters().iter().map(|(n, v)| format!("{n} = {}", significant(*v, 12)));
        let mut facts = vec![
            ("structure", self.structure.name().to_owned()),
            (
                "finite elements",
                format!(
                    "{}, with {} degrees of freedom",
                    thousands(self.mesh.elements.len() as f64),
                    thousands(6.0 * nodes)
                ),
            ),
            ("parameters", list(parameters.collect())),
        ];
        match method {
            Method::Rigid => facts.push(("elastic modes", "none: a rigid body".to_owned())),
            _ if method.is_reduced() => facts.push(("elastic modes", modes.to_owned())),
            _ => facts.push(("unknowns", "all of the finite elements".to_owned())),
        }
        facts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }
}
