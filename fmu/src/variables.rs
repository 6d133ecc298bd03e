//! The variables of an FMU, derived from a model: the same for the description and for the library.
//!
//! Value references do not move when a model gains points, sensors, modes or load cases:
//!
//! | from | what |
//! |---|---|
//! | 0 | time |
//! | 1 | parameters |
//! | 100 | motion of A |
//! | 200 | centre of mass, momenta, energies |
//! | 300 | rates of the motion of A |
//! | 400 | reaction on what holds or moves A |
//! | 1000 + i | amplitude of the i-th mode |
//! | 100,000 + i | its rate |
//! | 200,000 + i | its acceleration |
//! | 1,000,000 + 1000 p | point p: outputs, from 100 inputs |
//! | 1,500,000,000 + 10 s | section s: force and moment |
//! | 2,000,000,000 + 100 s | sensor s |
//! | 3,000,000,000 + 4,000,000 b | stations of block b: arrays of outputs, from 2,000,000 of inputs |

mod stations;

use rom_runtime::data::{ModelData, PointData};
use rom_runtime::loads::{DistributedFrame, LoadFrame};

pub use self::stations::check_stations;
pub(crate) use self::stations::output as station_output;

/// First references of the blocks above.
const FRAME: u32 = 100;
const LEDGER: u32 = 200;
const FRAME_RATES: u32 = 300;
const REACTION: u32 = 400;
const AMPLITUDES: u32 = 1000;
const RATES: u32 = 100_000;
const ACCELERATIONS: u32 = 200_000;
const POINTS: u32 = 1_000_000;
const PER_POINT: u32 = 1000;
const INPUTS: u32 = 100;
const SECTIONS: u32 = 1_500_000_000;
const PER_SECTION: u32 = 10;
const SENSORS: u32 = 2_000_000_000;
const PER_SENSOR: u32 = 100;

/// One variable: a scalar, or an array over stations.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Value reference; of an array that of its first element, after which come the others.
    pub reference: u32,
    /// Name, in the structured convention of FMI.
    pub name: String,
    /// Unit; empty for what is no real number.
    pub unit: &'static str,
    /// What it is, and in which frame.
    pub description: String,
    /// What it stands for.
    pub role: Role,
    /// Reference of the continuous state whose rate it is.
    pub derivative: Option<u32>,
    /// Rows and columns of an array.
    pub shape: Option<[usize; 2]>,
}

/// What a variable stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Time.
    Time,
    /// An enumeration among the parameters.
    Choice(Choice),
    /// Whether the loads of the equilibrium act.
    EquilibriumLoads,
    /// A real parameter, by its place ([`crate::parameters::Parameters::real`]).
    Real(usize),
    /// A component of a wrench on a point, by its place among all inputs.
    Input(usize),
    /// A component of the motion of A, in the order of the names.
    Frame(usize),
    /// A component of the ledger.
    Ledger(usize),
    /// A modal amplitude.
    Amplitude(usize),
    /// Its rate.
    Rate(usize),
    /// The rate of that.
    Acceleration(usize),
    /// The rate of a component of the motion of A: of `v_A`, `w_A`, `zeta`.
    FrameRate(usize),
    /// A component of the wrench on what holds or moves A.
    Reaction(usize),
    /// A component of the force and moment in a section.
    Section(usize, usize),
    /// A component of what a point does.
    Point(usize, usize),
    /// A component of what a sensor reads.
    Sensor(usize, usize),
    /// A component of what the stations of a block do: the block by its place among those asked for, all stations row by row.
    Station(usize, usize),
}

impl Role {
    /// Whether it is an output.
    pub fn is_output(self) -> bool {
        use Role::{Amplitude, Frame, Ledger, Point, Rate, Reaction, Section, Sensor, Station};
        matches!(
            self,
            Frame(_)
                | Ledger(_)
                | Amplitude(_)
                | Rate(_)
                | Reaction(_)
                | Section(..)
                | Point(..)
                | Sensor(..)
                | Station(..)
        )
    }

    /// Whether loads change it at once: accelerations, and what follows from them.
    pub fn follows_loads(self) -> bool {
        match self {
            Role::Acceleration(_) | Role::Reaction(_) | Role::Section(..) => true,
            Role::FrameRate(place) => place < 6,
            Role::Point(_, place) => place >= 16,
            Role::Sensor(_, place) => !(3..6).contains(&place),
            _ => false,
        }
    }
}

/// Parameters that are enumerations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Load case.
    LoadCase,
    /// Method.
    Method,
    /// Integrator.
    Integrator,
}

/// Six inputs that belong together: force and moment, components in one frame.
#[derive(Clone, Debug, PartialEq)]
pub enum InputBlock {
    /// On a named point.
    Point {
        /// Index of the point.
        point: usize,
        /// Frame of the components.
        frame: LoadFrame,
    },
    /// On a station.
    Station {
        /// Its block, by the place among those asked for.
        slot: usize,
        /// Index in the block.
        station: usize,
        /// Frame of the components.
        frame: DistributedFrame,
    },
}

/// All variables of a model, by reference, and its inputs by place: six of every block.
#[derive(Clone, Debug, PartialEq)]
pub struct Variables {
    /// In ascending order of their references.
    pub all: Vec<Variable>,
    /// What every six inputs are.
    pub inputs: Vec<InputBlock>,
}

impl Variables {
    /// Of a model, and of the blocks of stations with these indices ([`check_stations`]).
    pub fn of(data: &ModelData, stations: &[usize]) -> Self {
        let mut list = List { all: Vec::new(), inputs: Vec::new() };
        list.push(0, "time".into(), "s", "time".into(), Role::Time);
        list.parameters(data);
        list.frame();
        list.ledger();
        for (i, number) in data.modes.number.iter().enumerate() {
            let what = format!("amplitude of elastic mode {number}");
            let i = i as u32;
            list.push(AMPLITUDES + i, format!("q[{number}]"), "1", what, Role::Amplitude(i as usize));
            let what = format!("rate of elastic mode {number}");
            list.push(RATES + i, format!("q_dot[{number}]"), "1/s", what, Role::Rate(i as usize));
            list.is_rate_of(AMPLITUDES + i);
            let what = format!("acceleration of elastic mode {number}");
            let name = format!("der(q_dot[{number}])");
            list.push(ACCELERATIONS + i, name, "1/s2", what, Role::Acceleration(i as usize));
            list.is_rate_of(RATES + i);
        }
        list.frame_rates();
        if data.clamped.is_some() || data.load_cases.iter().any(|case| case.motion.is_some()) {
            list.reaction();
        }
        for (i, cut) in data.cuts.iter().enumerate() {
            list.section(i, &cut.name);
        }
        for (i, point) in data.points.iter().enumerate() {
            list.point(i, point);
        }
        for (i, sensor) in data.sensors.iter().enumerate() {
            list.sensor(i, &sensor.name);
        }
        for (slot, block) in stations.iter().enumerate() {
            if let Some(of) = data.stations.get(*block) {
                list.stations(slot, *block, of);
            }
        }
        list.all.sort_by_key(|variable| variable.reference);
        Variables { all: list.all, inputs: list.inputs }
    }

    /// The continuous states and their rates: `q`, `q_dot`, `v_A`, `w_A`, `zeta`, `r_G`, in this order.
    pub fn states(&self) -> Vec<(u32, u32)> {
        let mut states: Vec<(Role, u32, u32)> = Vec::new();
        for rate in &self.all {
            if let Some(state) = rate.derivative
                && let Some((variable, _)) = self.find(state)
            {
                states.push((variable.role, state, rate.reference));
            }
        }
        let order = |role: &Role| match *role {
            Role::Amplitude(i) => (0, i),
            Role::Rate(i) => (1, i),
            // The position of A comes last.
            Role::Frame(place @ 0..3) => (3, place),
            Role::Frame(place) => (2, place),
            _ => (4, 0),
        };
        states.sort_by_key(|(role, ..)| order(role));
        states.into_iter().map(|(_, state, rate)| (state, rate)).collect()
    }

    /// The variable of a reference, and what the element of it stands for.
    pub fn find(&self, reference: u32) -> Option<(&Variable, Role)> {
        let after = self.all.partition_point(|variable| variable.reference <= reference);
        let variable = self.all.get(after.checked_sub(1)?)?;
        let place = (reference - variable.reference) as usize;
        (place < variable.size()).then(|| (variable, variable.element(place)))
    }

    /// The same with the elements of arrays in their place.
    pub fn scalars(self) -> Self {
        Variables { all: self.all.iter().flat_map(Variable::scalars).collect(), ..self }
    }
}

struct List {
    all: Vec<Variable>,
    inputs: Vec<InputBlock>,
}

/// A vector by its components.
struct Vector<'a> {
    name: String,
    components: &'static str,
    unit: &'static str,
    what: &'a str,
}

impl List {
    fn push(&mut self, reference: u32, name: String, unit: &'static str, description: String, role: Role) {
        self.all.push(Variable { reference, name, unit, description, role, derivative: None, shape: None });
    }

    /// The variable pushed last is the rate of a state.
    fn is_rate_of(&mut self, state: u32) {
        if let Some(last) = self.all.last_mut() {
            last.derivative = Some(state);
        }
    }

    /// Vectors one after the other from `first` on, `role` by running place.
    fn vectors(&mut self, first: u32, vectors: &[Vector], role: impl Fn(usize) -> Role) {
        let mut place = 0;
        for Vector { name, components, unit, what } in vectors {
            if components.is_empty() {
                self.push(first + place, name.clone(), unit, (*what).to_owned(), role(place as usize));
                place += 1;
            }
            for component in components.chars() {
                let (name, what) = (format!("{name}.{component}"), format!("{what}, {component}"));
                self.push(first + place, name, unit, what, role(place as usize));
                place += 1;
            }
        }
    }

    fn parameters(&mut self, data: &ModelData) {
        let choices = [
            (1, "load_case", "load case of the model that acts besides the inputs", Choice::LoadCase),
            (2, "method", "how the equations are simplified", Choice::Method),
            (3, "integrator", "time integrator", Choice::Integrator),
        ];
        for (reference, name, what, choice) in choices {
            self.push(reference, name.into(), "", what.into(), Role::Choice(choice));
        }
        let dt = "internal time step; 0: that of the load case, 0.01 s without one";
        self.push(4, "dt".into(), "s", dt.into(), Role::Real(0));
        let damping = "numerical damping of the implicit integrators, 0 to 1; negative: that of the load case, 0 without one";
        self.push(5, "numerical_damping".into(), "1", damping.into(), Role::Real(1));
        if data.trim.as_ref().is_some_and(|trim| !trim.loads.is_empty()) {
            let what = "whether the loads in balance at the equilibrium act besides";
            self.push(6, "equilibrium_loads".into(), "", what.into(), Role::EquilibriumLoads);
        }
        let vector =
            |name: &str, components, unit, what| Vector { name: name.into(), components, unit, what };
        let vectors = [
            vector("gravity", "xyz", "m/s2", "acceleration of free fall, components in G"),
            vector("initial_r_G", "xyz", "m", "position of the origin of A in G at the start"),
            vector("initial_v_A", "xyz", "m/s", "velocity of the origin of A at the start, components in A"),
            vector("initial_w_A", "xyz", "rad/s", "angular velocity of A at the start, components in A"),
            vector(
                "initial_zeta",
                "wxyz",
                "1",
                "attitude quaternion of A at the start, scalar first, A to G",
            ),
        ];
        self.vectors(10, &vectors, |place| Role::Real(2 + place));
    }

    fn frame(&mut self) {
        let vector =
            |name: &str, components, unit, what| Vector { name: name.into(), components, unit, what };
        let vectors = [
            vector("r_G", "xyz", "m", "position of the origin of A in G"),
            vector("v_G", "xyz", "m/s", "inertial velocity of the origin of A, components in G"),
            vector("w_G", "xyz", "rad/s", "angular velocity of A, components in G"),
            vector("v_A", "xyz", "m/s", "inertial velocity of the origin of A, components in A"),
            vector("w_A", "xyz", "rad/s", "angular velocity of A, components in A"),
            vector(
                "zeta",
                "wxyz",
                "1",
                "attitude quaternion, scalar first, components in A to components in G",
            ),
        ];
        self.vectors(FRAME, &vectors, Role::Frame);
        // v_G is the rate of r_G.
        for variable in &mut self.all {
            if let Role::Frame(place @ 3..6) = variable.role {
                variable.derivative = Some(FRAME + place as u32 - 3);
            }
        }
    }

    /// Rates of the states among the motion of A that are no outputs themselves.
    fn frame_rates(&mut self) {
        let states = self.all.iter().filter(|variable| matches!(variable.role, Role::Frame(9..)));
        let states: Vec<(u32, String)> = states.map(|state| (state.reference, state.name.clone())).collect();
        for (place, (state, name)) in states.into_iter().enumerate() {
            let unit = ["m/s2", "rad/s2", "1/s"][(place / 3).min(2)];
            let what = format!("rate of {name}");
            self.push(FRAME_RATES + place as u32, format!("der({name})"), unit, what, Role::FrameRate(place));
            self.is_rate_of(state);
        }
    }

    fn reaction(&mut self) {
        for (place, name) in ["fx", "fy", "fz", "mx", "my", "mz"].into_iter().enumerate() {
            let unit = if place < 3 { "N" } else { "N.m" };
            let what =
                "what the body exerts on what holds or moves A, about the origin of A, components in A";
            let role = Role::Reaction(place);
            self.push(REACTION + place as u32, format!("reaction_A.{name}"), unit, what.into(), role);
        }
    }

    fn section(&mut self, index: usize, name: &str) {
        let own = identifier(name);
        let vector =
            |name: &str, unit, what| Vector { name: format!("{own}.{name}"), components: "xyz", unit, what };
        let vectors = [
            vector("F", "N", "force on the positive face of the section, axes of the deformed section"),
            vector("M", "N.m", "moment on the positive face of the section, axes of the deformed section"),
        ];
        let first = SECTIONS + PER_SECTION * index as u32;
        self.vectors(first, &vectors, |place| Role::Section(index, place));
    }

    fn ledger(&mut self) {
        let vector =
            |name: &str, components, unit, what| Vector { name: name.into(), components, unit, what };
        let vectors = [
            vector("r_CM_G", "xyz", "m", "position of the centre of mass in G"),
            vector("p_G", "xyz", "kg.m/s", "linear momentum, components in G"),
            vector("L_G", "xyz", "kg.m2/s", "angular momentum about the origin of G, components in G"),
            vector("E_kin", "", "J", "kinetic energy"),
            vector("E_el", "", "J", "elastic energy"),
            vector("E_grav", "", "J", "potential energy in the field of gravity, zero at the origin of G"),
        ];
        self.vectors(LEDGER, &vectors, Role::Ledger);
    }

    fn point(&mut self, index: usize, point: &PointData) {
        let (own, first) = (identifier(&point.name), POINTS + PER_POINT * index as u32);
        let vector = |name: &str, components, unit, what| {
            let name = format!("{own}.{name}");
            Vector { name, components, unit, what }
        };
        let vectors = [
            vector("dR_A", "xyz", "m", "displacement from the equilibrium, components in A"),
            vector("R_G", "xyz", "m", "position in G"),
            vector("zeta", "wxyz", "1", "attitude quaternion, scalar first, node axes to G"),
            vector("v_G", "xyz", "m/s", "velocity, components in G"),
            vector("w_G", "xyz", "rad/s", "angular velocity, components in G"),
            vector("a_G", "xyz", "m/s2", "acceleration, components in G"),
            vector("alpha_G", "xyz", "rad/s2", "angular acceleration, components in G"),
        ];
        self.vectors(first, &vectors, |place| Role::Point(index, place));

        self.wrench(first + INPUTS, index, format!("{own}.dead"), "G", LoadFrame::Dead);
        self.wrench(first + INPUTS + 10, index, format!("{own}.body"), "A", LoadFrame::Body);
        for (i, (member, section)) in point.sections.iter().enumerate().take(70) {
            let (prefix, frame) = match point.sections.len() {
                1 => (format!("{own}.follower"), "the section frame".to_owned()),
                _ => {
                    let which = occurrence(&point.sections, i);
                    (
                        format!("{own}.follower.{}{which}", identifier(member)),
                        format!("the section frame of {member}{which}"),
                    )
                }
            };
            let reference = first + INPUTS + 100 + 10 * i as u32;
            self.wrench(reference, index, prefix, &frame, LoadFrame::Follower { section: *section });
        }
    }

    fn wrench(&mut self, first: u32, point: usize, prefix: String, axes: &str, frame: LoadFrame) {
        let start = 6 * self.inputs.len();
        self.inputs.push(InputBlock::Point { point, frame });
        let (force, moment) =
            (format!("force, components in {axes}"), format!("moment, components in {axes}"));
        let vectors = [
            Vector { name: format!("{prefix}.force"), components: "xyz", unit: "N", what: &force },
            Vector { name: format!("{prefix}.moment"), components: "xyz", unit: "N.m", what: &moment },
        ];
        self.vectors(first, &vectors, |place| Role::Input(start + place));
    }

    fn sensor(&mut self, index: usize, name: &str) {
        let own = identifier(name);
        let vector = |name: &str, components, unit, what| {
            let name = format!("{own}.{name}");
            Vector { name, components, unit, what }
        };
        let vectors = [
            vector("a_S", "xyz", "m/s2", "acceleration read, sensor axes"),
            vector("w_S", "xyz", "rad/s", "angular velocity read, sensor axes"),
            vector("alpha_S", "xyz", "rad/s2", "angular acceleration read, sensor axes"),
        ];
        let first = SENSORS + PER_SENSOR * index as u32;
        self.vectors(first, &vectors, |place| Role::Sensor(index, place));
    }
}

/// Which of the sections of its member it is, as `[1]`, where a member bends at the point and has several; empty elsewhere.
fn occurrence<T>(sections: &[(String, T)], index: usize) -> String {
    let Some((member, _)) = sections.get(index) else { return String::new() };
    let of_member = |sections: &[(String, T)]| sections.iter().filter(|(name, _)| name == member).count();
    match of_member(sections) {
        1 => String::new(),
        _ => format!("[{}]", 1 + of_member(&sections[..index])),
    }
}

/// A name as the structured convention has it: as it is where it is an identifier, in single quotes elsewhere.
fn identifier(name: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if name.chars().all(plain) && name.chars().next().is_some_and(|c| !c.is_ascii_digit()) {
        return name.to_owned();
    }
    let mut quoted = String::from("'");
    for character in name.chars() {
        match character {
            '\'' | '\\' => quoted.extend(['\\', character]),
            // The convention has ASCII only.
            c if c.is_ascii() && !c.is_ascii_control() => quoted.push(c),
            c => quoted.push_str(&format!("u{:04x}", u32::from(c))),
        }
    }
    quoted.push('\'');
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_of_a_member_that_bends_at_a_point_are_numbered() {
        let sections = ["wing", "fin", "wing"].map(|name| (name.to_owned(), ()));
        assert_eq!([0, 1, 2].map(|i| occurrence(&sections, i)), ["[1]", "", "[2]"]);
    }

    #[test]
    fn names_are_identifiers_or_quoted() {
        assert_eq!(identifier("P_1"), "P_1");
        assert_eq!(identifier("right corner"), "'right corner'");
        assert_eq!(identifier("1a"), "'1a'");
        assert_eq!(identifier("it's"), "'it\\'s'");
        assert_eq!(identifier("böe"), "'bu00f6e'");
    }
}
