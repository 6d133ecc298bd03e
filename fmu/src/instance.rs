//! One FMU in a co-simulation: parameters, inputs and a simulation, without the conventions of either standard.

use std::sync::Arc;

use rom_runtime::{Method, Model};

use crate::parameters::Parameters;
use crate::run::{Group, Run, WHOLE};
use crate::token::Token;
use crate::variables::{Choice, Role, Variables, check_stations};

/// Where an instance is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Made, or set back: parameters and inputs may be set.
    Instantiated,
    /// Between entering and leaving the initialisation: outputs may be read besides.
    Initialization,
    /// Steps are made.
    Step,
    /// Over: outputs may still be read.
    Terminated,
}

/// How a step ended that was not made to its end.
#[derive(Clone, Debug, PartialEq)]
pub enum StepFailure {
    /// Nothing was done.
    Refused(String),
    /// The numbers failed; the state is that at [`Instance::time`].
    Stopped(String),
}

/// An instance.
pub struct Instance {
    model: Arc<Model>,
    token: Token,
    variables: Variables,
    /// Indices of the blocks of stations that are variables.
    stations: Vec<usize>,
    pub(crate) phase: Phase,
    pub(crate) parameters: Parameters,
    /// Six of every block of [`Variables::inputs`].
    pub(crate) inputs: Vec<f64>,
    pub(crate) start_time: f64,
    /// Made when it is needed first; gone when a parameter changes.
    pub(crate) run: Option<Run>,
}

impl Instance {
    /// Of a model file, with the blocks of stations of these indices.
    ///
    /// # Errors
    /// When the bytes hold no model, or none with such blocks.
    pub fn new(bytes: &[u8], stations: &[usize]) -> Result<Self, String> {
        let model = Arc::new(Model::from_bytes(bytes).map_err(|e| e.to_string())?);
        check_stations(model.data(), stations)?;
        let variables = Variables::of(model.data(), stations);
        Ok(Instance {
            token: Token::of_model(bytes, stations),
            stations: stations.to_vec(),
            phase: Phase::Instantiated,
            parameters: Parameters::of(&model),
            inputs: vec![0.0; 6 * variables.inputs.len()],
            start_time: 0.0,
            run: None,
            variables,
            model,
        })
    }

    /// The identity of the FMU.
    pub fn token(&self) -> Token {
        self.token
    }

    /// Where the instance is in its life.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Time reached, s.
    pub fn time(&self) -> f64 {
        self.run.as_ref().map_or(self.start_time, |run| run.simulation.state().time)
    }

    /// Begins the initialisation at a time.
    ///
    /// # Errors
    /// Out of turn, or for a time that is not finite.
    pub fn enter_initialization(&mut self, start_time: f64) -> Result<(), String> {
        self.expect(Phase::Instantiated, "the initialisation cannot begin")?;
        if !start_time.is_finite() {
            return Err(format!("the start time is {start_time}, expected a finite number of seconds"));
        }
        self.start_time = start_time;
        self.run = None;
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// Ends the initialisation: the parameters are final.
    ///
    /// # Errors
    /// Out of turn, or parameters that fit neither each other nor the model.
    pub fn exit_initialization(&mut self) -> Result<(), String> {
        self.expect(Phase::Initialization, "the initialisation cannot end")?;
        self.run()?;
        self.phase = Phase::Step;
        Ok(())
    }

    /// Ends the simulation.
    ///
    /// # Errors
    /// Out of turn.
    pub fn terminate(&mut self) -> Result<(), String> {
        self.expect(Phase::Step, "the simulation cannot be terminated")?;
        self.phase = Phase::Terminated;
        Ok(())
    }

    /// Back to where it was when it was made.
    pub fn reset(&mut self) {
        self.phase = Phase::Instantiated;
        self.parameters = Parameters::of(&self.model);
        self.inputs.fill(0.0);
        self.start_time = 0.0;
        self.run = None;
    }

    fn expect(&self, phase: Phase, what: &str) -> Result<(), String> {
        if self.phase == phase {
            return Ok(());
        }
        Err(format!("{what} in the phase {:?}, only in {phase:?}", self.phase))
    }

    /// Sets a real variable: an input, or a parameter before the steps begin.
    ///
    /// # Errors
    /// For other variables, out of turn, and for numbers that are not finite.
    pub fn set_real(&mut self, reference: u32, value: f64) -> Result<(), String> {
        let (role, name) = self.role(reference)?;
        if !value.is_finite() {
            return Err(format!("{name} is set to {value}, expected a finite number"));
        }
        match role {
            Role::Input(place) => {
                if let Some(input) = self.inputs.get_mut(place)
                    && *input != value
                {
                    *input = value;
                    if let Some(run) = &mut self.run {
                        run.inputs_changed()?;
                    }
                }
                Ok(())
            }
            Role::Real(place) => {
                self.may_choose(reference)?;
                if let Some(parameter) = self.parameters.real(place)
                    && *parameter != value
                {
                    *parameter = value;
                    self.run = None;
                }
                Ok(())
            }
            Role::Choice(_) | Role::EquilibriumLoads => Err(format!("{name} is no real number")),
            _ => Err(format!("{name} is an output and cannot be set")),
        }
    }

    /// Sets an enumeration before the steps begin.
    ///
    /// # Errors
    /// For other variables, out of turn, and for numbers that stand for nothing.
    pub fn set_choice(&mut self, reference: u32, value: i64) -> Result<(), String> {
        let (role, name) = self.role(reference)?;
        let Role::Choice(choice) = role else { return Err(format!("{name} is no enumeration")) };
        let name = name.to_owned();
        self.may_choose(reference)?;
        let old = self.parameters;
        match choice {
            Choice::LoadCase => {
                let cases = self.model.data().load_cases.len() as i64;
                if !(0..=cases).contains(&value) {
                    return Err(format!("{name} is set to {value}, expected 0 (none) to {cases}"));
                }
                self.parameters.load_case = value;
            }
            Choice::Method => self.parameters.method = value,
            Choice::Integrator => self.parameters.integrator = value,
        }
        let found = self.parameters.method().and(self.parameters.integrator().map(|_| Method::Rom));
        found.inspect_err(|_| self.parameters = old)?;
        if old != self.parameters {
            self.run = None;
        }
        Ok(())
    }

    /// Sets a truth value before the steps begin.
    ///
    /// # Errors
    /// For other variables, and out of turn.
    pub fn set_truth(&mut self, reference: u32, value: bool) -> Result<(), String> {
        let (role, name) = self.role(reference)?;
        if role != Role::EquilibriumLoads {
            return Err(format!("{name} is no truth value"));
        }
        self.may_choose(reference)?;
        self.parameters.equilibrium_loads = value;
        self.run = None;
        Ok(())
    }

    fn may_choose(&self, reference: u32) -> Result<(), String> {
        match self.phase {
            Phase::Instantiated | Phase::Initialization => Ok(()),
            _ => Err(format!(
                "{} is fixed once the initialisation has ended",
                self.role(reference).map_or("the parameter", |(_, name)| name)
            )),
        }
    }

    fn role(&self, reference: u32) -> Result<(Role, &str), String> {
        match self.variables.find(reference) {
            Some((variable, role)) => Ok((role, &variable.name)),
            None => Err(format!("there is no variable with the reference {reference}")),
        }
    }

    /// Number of elements of a variable: 1 for a scalar.
    ///
    /// # Errors
    /// For a reference that is that of none.
    pub fn size(&self, reference: u32) -> Result<usize, String> {
        match self.variables.find(reference) {
            Some((variable, _)) if variable.reference == reference => Ok(variable.size()),
            _ => Err(format!("there is no variable with the reference {reference}")),
        }
    }

    /// An enumeration.
    ///
    /// # Errors
    /// For other variables.
    pub fn choice(&self, reference: u32) -> Result<i64, String> {
        match self.role(reference)? {
            (Role::Choice(Choice::LoadCase), _) => Ok(self.parameters.load_case),
            (Role::Choice(Choice::Method), _) => Ok(self.parameters.method),
            (Role::Choice(Choice::Integrator), _) => Ok(self.parameters.integrator),
            (_, name) => Err(format!("{name} is no enumeration")),
        }
    }

    /// A truth value.
    ///
    /// # Errors
    /// For other variables.
    pub fn truth(&self, reference: u32) -> Result<bool, String> {
        match self.role(reference)? {
            (Role::EquilibriumLoads, _) => Ok(self.parameters.equilibrium_loads),
            (_, name) => Err(format!("{name} is no truth value")),
        }
    }

    /// A real variable.
    ///
    /// # Errors
    /// For other variables, and where parameters fit neither each other nor the model.
    pub fn real(&mut self, reference: u32) -> Result<f64, String> {
        let role = self.role(reference)?.0;
        let nothing = || format!("the variable {reference} has no value");
        match role {
            Role::Input(place) => return self.inputs.get(place).copied().ok_or_else(nothing),
            Role::Real(place) => return self.parameters.real(place).copied().ok_or_else(nothing),
            Role::Choice(_) | Role::EquilibriumLoads => {
                return Err(format!("{} is no real number", self.role(reference)?.1));
            }
            Role::Time => return Ok(self.time()),
            _ => {}
        }
        if self.run.is_none() {
            self.run()?;
        }
        let Some(run) = &mut self.run else { return Err(nothing()) };
        let (group, place) = match role {
            Role::Frame(place) => (Group::Frame, place),
            Role::Ledger(place) => (Group::Ledger, place),
            Role::Point(point, place @ 0..6) => (Group::Point(point), place),
            Role::Point(point, place) => (Group::PointMotion(point), place - 6),
            Role::Sensor(sensor, place) => (Group::Sensor(sensor), place),
            Role::Section(section, place) => (Group::Section(section), place),
            Role::FrameRate(place) => (Group::FrameRates, place),
            Role::Reaction(place) => (Group::Reaction, place),
            // The simpler methods have fewer.
            Role::Amplitude(mode) => {
                return Ok(run.simulation.state().q.get(mode).copied().unwrap_or(0.0));
            }
            Role::Rate(mode) => return Ok(run.simulation.state().q_dot.get(mode).copied().unwrap_or(0.0)),
            Role::Station(slot, place) => return run.station(slot, place),
            Role::Acceleration(mode) => {
                return run.modal_acceleration(mode, &self.variables.inputs, &self.inputs);
            }
            _ => return Err(nothing()),
        };
        let values = run.outputs(group, &self.variables.inputs, &self.inputs)?;
        values.get(place).copied().ok_or_else(nothing)
    }

    /// How outputs and rates of states, `unknowns`, change where inputs and continuous states, `knowns`, change by `seeds`: the equations of
    /// motion at the present state and under the present inputs, to first order. Everything else is held.
    ///
    /// # Errors
    /// Out of turn, for other variables, for another number of seeds than knowns, and for numbers that are not finite.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seeds: &[f64],
    ) -> Result<Vec<f64>, String> {
        if !matches!(self.phase, Phase::Initialization | Phase::Step) {
            return Err(format!("there are no derivatives in the phase {:?}", self.phase));
        }
        if seeds.len() != knowns.len() {
            return Err(format!("there are {} seeds for {} variables", seeds.len(), knowns.len()));
        }
        let states: Vec<u32> = self.variables.states().into_iter().map(|(state, _)| state).collect();
        let (mut along, mut of) = (Vec::with_capacity(knowns.len()), Vec::with_capacity(unknowns.len()));
        for (reference, seed) in knowns.iter().zip(seeds) {
            let (role, name) = self.role(*reference)?;
            if !(matches!(role, Role::Input(_)) || states.contains(reference)) {
                return Err(format!(
                    "a derivative by {name} is asked for; there are those by inputs and continuous states"
                ));
            }
            if !seed.is_finite() {
                return Err(format!("the seed of {name} is {seed}, expected a finite number"));
            }
            along.push((role, *seed));
        }
        for reference in unknowns {
            let (role, name) = self.role(*reference)?;
            if !(role.is_output()
                || self.variables.find(*reference).is_some_and(|(v, _)| v.derivative.is_some()))
            {
                return Err(format!(
                    "a derivative of {name} is asked for; there are those of outputs and of rates of states"
                ));
            }
            of.push(role);
        }
        self.run()?;
        let Some(run) = &mut self.run else { return Err("the simulation has not begun".to_owned()) };
        let (blocks, inputs) = (&self.variables.inputs, &self.inputs);
        run.directional_derivative(along.into_iter(), of.into_iter(), blocks, inputs)
    }

    /// From the present communication point over `size` seconds, in steps of `dt`; where that does not fit, in the fewest equal
    /// ones that are not longer.
    ///
    /// # Errors
    /// See [`StepFailure`].
    pub fn step(&mut self, from: f64, size: f64) -> Result<(), StepFailure> {
        self.expect(Phase::Step, "there are no steps").map_err(StepFailure::Refused)?;
        let here = self.time();
        let blocks = &self.variables.inputs;
        let Some(run) = &mut self.run else {
            return Err(StepFailure::Refused("the simulation has not begun".to_owned()));
        };
        let forgiven = (WHOLE * run.dt()).max(8.0 * f64::EPSILON * here.abs());
        if !(from - here).is_finite() || (from - here).abs() > forgiven {
            let message = format!(
                "the step should begin at {from} s, but the FMU is at {here} s; set a state saved there to go back"
            );
            return Err(StepFailure::Refused(message));
        }
        if !(size > 0.0 && size.is_finite()) {
            let message = format!("the communication step is {size} s, expected a positive number");
            return Err(StepFailure::Refused(message));
        }
        run.advance(from + size, blocks, &self.inputs).map_err(StepFailure::Stopped)
    }

    /// The simulation under the present parameters.
    pub(crate) fn run(&mut self) -> Result<&mut Run, String> {
        let run = match self.run.take() {
            Some(run) => run,
            None => Run::new(&self.model, &self.parameters, &self.stations, self.start_time)?,
        };
        Ok(self.run.insert(run))
    }
}
