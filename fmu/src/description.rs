//! The file modelDescription.xml. The same model gives the same bytes: nothing in it is of the day or of the machine.

use std::fmt::Display;

use rom_runtime::data::ModelData;
use rom_runtime::{Integrator, Method, Model};

use crate::parameters::{DEFAULT_DT, Parameters};
use crate::token::Token;
use crate::variables::{Choice, Role, Variable, Variables};
use crate::xml::Xml;

/// Version of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fmi {
    /// 2.0
    V2,
    /// 3.0
    V3,
}

/// Names and descriptions of the items of an enumeration.
type Items = Vec<(String, String)>;

/// What there is to describe.
struct Description<'a> {
    fmi: Fmi,
    data: &'a ModelData,
    parameters: Parameters,
    variables: Variables,
}

/// The name of the library in an FMU, without its ending: the name of the model as an identifier of C.
pub fn model_identifier(data: &ModelData) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = data.provenance.name.chars().take(60).map(plain).collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) { name } else { format!("model_{name}") }
}

/// The description of the FMU of a model, with the blocks of stations of these indices among the variables
/// ([`crate::variables::check_stations`]).
pub fn model_description(fmi: Fmi, model: &Model, stations: &[usize], token: Token) -> String {
    let data = model.data();
    let variables = Variables::of(data, stations);
    // FMI 2.0 has no arrays.
    let variables = if fmi == Fmi::V2 { variables.scalars() } else { variables };
    let description = Description { fmi, data, parameters: Parameters::of(model), variables };
    let mut xml = Xml::new();
    description.root(&mut xml, token);
    description.interface(&mut xml);
    description.units(&mut xml);
    description.types(&mut xml);
    xml.open("LogCategories", &[]);
    xml.empty("Category", &[("name", &"logStatusError"), ("description", &"why a call failed")]);
    xml.close();
    description.experiment(&mut xml);
    description.model_variables(&mut xml);
    description.structure(&mut xml);
    xml.finish()
}

impl Description<'_> {
    fn root(&self, xml: &mut Xml, token: Token) {
        let provenance = &self.data.provenance;
        let identity = if self.fmi == Fmi::V2 { "guid" } else { "instantiationToken" };
        let version = if self.fmi == Fmi::V2 { "2.0" } else { "3.0" };
        let what = format!(
            "Flexible body {} with {} elastic modes. SI units; frame G is inertial, A the body's",
            provenance.name,
            self.data.modes.omega.len()
        );
        xml.open(
            "fmiModelDescription",
            &[
                ("fmiVersion", &version),
                ("modelName", &provenance.name),
                (identity, &token),
                ("description", &what),
                ("generationTool", &concat!("romgen ", env!("CARGO_PKG_VERSION"))),
                ("variableNamingConvention", &"structured"),
            ],
        );
    }

    fn interface(&self, xml: &mut Xml) {
        let identifier = model_identifier(self.data);
        let state = if self.fmi == Fmi::V2 { "state" } else { "State" };
        let (get_set, serialize) = (format!("canGetAndSetFMU{}", state), format!("canSerializeFMU{}", state));
        let yes: &dyn Display = &"true";
        let derivatives = if self.fmi == Fmi::V2 {
            "providesDirectionalDerivative"
        } else {
            "providesDirectionalDerivatives"
        };
        let common: [(&str, &dyn Display); 5] = [
            ("modelIdentifier", &identifier),
            ("canHandleVariableCommunicationStepSize", yes),
            (&get_set, yes),
            (&serialize, yes),
            (derivatives, yes),
        ];
        xml.empty("CoSimulation", &common);
    }

    fn units(&self, xml: &mut Xml) {
        // Powers of kg, m, s, rad.
        const UNITS: [(&str, [i32; 4]); 15] = [
            ("1", [0, 0, 0, 0]),
            ("1/s", [0, 0, -1, 0]),
            ("1/s2", [0, 0, -2, 0]),
            ("s", [0, 0, 1, 0]),
            ("m", [0, 1, 0, 0]),
            ("m/s", [0, 1, -1, 0]),
            ("m/s2", [0, 1, -2, 0]),
            ("rad", [0, 0, 0, 1]),
            ("rad/s", [0, 0, -1, 1]),
            ("rad/s2", [0, 0, -2, 1]),
            ("N", [1, 1, -2, 0]),
            ("N.m", [1, 2, -2, 0]),
            ("J", [1, 2, -2, 0]),
            ("kg.m/s", [1, 1, -1, 0]),
            ("kg.m2/s", [1, 2, -1, 0]),
        ];
        xml.open("UnitDefinitions", &[]);
        for (name, powers) in UNITS {
            let bases = ["kg", "m", "s", "rad"];
            let used: Vec<(&str, &dyn Display)> = bases
                .into_iter()
                .zip(&powers)
                .filter(|(_, power)| **power != 0)
                .map(|(base, power)| (base, power as &dyn Display))
                .collect();
            xml.open("Unit", &[("name", &name)]);
            xml.empty("BaseUnit", &used);
            xml.close();
        }
        xml.close();
    }

    fn types(&self, xml: &mut Xml) {
        let cases = std::iter::once(("none".to_owned(), "no load case".to_owned()));
        let cases = cases
            .chain(self.data.load_cases.iter().map(|case| (case.name.clone(), case.description.clone())));
        let methods = Method::ALL.map(|method| (method.name().to_owned(), String::new()));
        let integrators = Integrator::ALL.map(|integrator| (integrator.name().to_owned(), String::new()));
        let types: [(&str, i64, Items); 3] = [
            ("LoadCase", 0, cases.collect()),
            ("Method", 1, methods.to_vec()),
            ("Integrator", 1, integrators.to_vec()),
        ];
        xml.open("TypeDefinitions", &[]);
        for (name, first, items) in types {
            if self.fmi == Fmi::V2 {
                xml.open("SimpleType", &[("name", &name)]);
                xml.open("Enumeration", &[]);
            } else {
                xml.open("EnumerationType", &[("name", &name)]);
            }
            for (value, (item, what)) in (first..).zip(&items) {
                let all: [(&str, &dyn Display); 3] =
                    [("name", item), ("value", &value), ("description", what)];
                xml.empty("Item", if what.is_empty() { &all[..2] } else { &all });
            }
            xml.close();
            if self.fmi == Fmi::V2 {
                xml.close();
            }
        }
        xml.close();
    }

    /// Until the last load case ends, in the steps of the finest.
    fn experiment(&self, xml: &mut Xml) {
        let cases = &self.data.load_cases;
        let step = cases.iter().map(|case| case.dt).fold(f64::INFINITY, f64::min);
        let step = if step.is_finite() { step } else { DEFAULT_DT };
        let stop = cases.iter().map(|case| case.t_end).fold(0.0, f64::max);
        let stop = if stop > 0.0 { stop } else { 10.0 };
        xml.empty("DefaultExperiment", &[("startTime", &"0"), ("stopTime", &stop), ("stepSize", &step)]);
    }

    fn model_variables(&self, xml: &mut Xml) {
        xml.open("ModelVariables", &[]);
        for variable in &self.variables.all {
            self.variable(xml, variable);
        }
        xml.close();
    }

    fn variable(&self, xml: &mut Xml, variable: &Variable) {
        let (causality, variability) = match variable.role {
            Role::Time => ("independent", "continuous"),
            Role::Choice(_) | Role::EquilibriumLoads | Role::Real(_) => ("parameter", "fixed"),
            Role::Input(_) => ("input", "continuous"),
            Role::Acceleration(_) | Role::FrameRate(_) => ("local", "continuous"),
            _ => ("output", "continuous"),
        };
        let mut parameters = self.parameters;
        let start: Option<String> = match variable.role {
            Role::Choice(Choice::LoadCase) => Some(parameters.load_case.to_string()),
            Role::Choice(Choice::Method) => Some(parameters.method.to_string()),
            Role::Choice(Choice::Integrator) => Some(parameters.integrator.to_string()),
            Role::EquilibriumLoads => Some(parameters.equilibrium_loads.to_string()),
            Role::Real(place) => parameters.real(place).map(|value| value.to_string()),
            Role::Input(_) => Some(vec!["0"; variable.size()].join(" ")),
            _ => None,
        };
        let declared = match variable.role {
            Role::Choice(Choice::LoadCase) => Some("LoadCase"),
            Role::Choice(Choice::Method) => Some("Method"),
            Role::Choice(Choice::Integrator) => Some("Integrator"),
            _ => None,
        };
        let mut own: Vec<(&str, &dyn Display)> = Vec::new();
        if let Some(declared) = &declared {
            own.push(("declaredType", declared));
        }
        if !variable.unit.is_empty() {
            own.push(("unit", &variable.unit));
        }
        if let Some(start) = &start {
            own.push(("start", start));
        }
        // By index in FMI 2.0, by reference in FMI 3.0.
        let state =
            variable.derivative.map(|state| if self.fmi == Fmi::V2 { self.index(state) } else { state });
        if let Some(state) = &state {
            own.push(("derivative", state));
        }
        let mut common: Vec<(&str, &dyn Display)> = vec![
            ("name", &variable.name),
            ("valueReference", &variable.reference),
            ("description", &variable.description),
            ("causality", &causality),
            ("variability", &variability),
        ];
        let kind = match (variable.role, self.fmi) {
            (Role::Choice(_), _) => "Enumeration",
            (Role::EquilibriumLoads, _) => "Boolean",
            (_, Fmi::V2) => "Real",
            (_, Fmi::V3) => "Float64",
        };
        if self.fmi == Fmi::V2 {
            xml.open("ScalarVariable", &common);
            xml.empty(kind, &own);
            xml.close();
            return;
        }
        common.extend(own);
        match variable.shape {
            None => xml.empty(kind, &common),
            Some(shape) => {
                xml.open(kind, &common);
                for length in shape {
                    xml.empty("Dimension", &[("start", &length)]);
                }
                xml.close();
            }
        }
    }

    /// Place of a variable in the list, from 1.
    fn index(&self, reference: u32) -> u32 {
        let place = self.variables.all.binary_search_by_key(&reference, |variable| variable.reference);
        place.map_or(0, |place| place as u32 + 1)
    }

    /// The equations of motion as they are between communication points: what follows from the state alone, and what inputs change at
    /// once (no list of dependencies: all). At the start everything may depend on everything.
    fn structure(&self, xml: &mut Xml) {
        let named = |reference: u32| if self.fmi == Fmi::V2 { self.index(reference) } else { reference };
        let pairs = self.variables.states();
        let states: Vec<String> = pairs.iter().map(|(state, _)| named(*state).to_string()).collect();
        let states = states.join(" ");
        let label = if self.fmi == Fmi::V2 { "index" } else { "valueReference" };
        let unknown = |xml: &mut Xml, element: &str, variable: &Variable| {
            let reference = named(variable.reference);
            let all: [(&str, &dyn Display); 2] = [(label, &reference), ("dependencies", &states)];
            xml.empty(element, if variable.role.follows_loads() { &all[..1] } else { &all });
        };
        let [output, rate, start] = match self.fmi {
            Fmi::V2 => ["Unknown"; 3],
            Fmi::V3 => ["Output", "ContinuousStateDerivative", "InitialUnknown"],
        };
        let group = |xml: &mut Xml, name: &'static str| {
            if self.fmi == Fmi::V2 {
                xml.open(name, &[]);
            }
        };
        let end = |xml: &mut Xml| {
            if self.fmi == Fmi::V2 {
                xml.close();
            }
        };
        let outputs = || self.variables.all.iter().filter(|variable| variable.role.is_output());
        xml.open("ModelStructure", &[]);
        group(xml, "Outputs");
        outputs().for_each(|variable| unknown(xml, output, variable));
        end(xml);
        group(xml, "Derivatives");
        let rates = pairs.iter().filter_map(|(_, reference)| self.variables.find(*reference));
        rates.for_each(|(variable, _)| unknown(xml, rate, variable));
        end(xml);
        group(xml, "InitialUnknowns");
        for variable in &self.variables.all {
            if variable.role.is_output() || variable.derivative.is_some() {
                xml.empty(start, &[(label, &named(variable.reference))]);
            }
        }
        end(xml);
        xml.close();
    }
}
