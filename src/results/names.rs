//! The channels every method writes: names, units, frames.

/// What a channel is called and what it holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelSpec {
    /// Name in the files.
    pub name: String,
    /// Names of its components; empty for a scalar.
    pub components: Vec<String>,
    /// Unit.
    pub unit: &'static str,
    /// What it is, and in which frame.
    pub description: String,
}

impl ChannelSpec {
    /// A channel named `name` with the components listed one character each (`"xyz"`, `"wxyz"`, or `""`: a scalar).
    pub fn new(name: &str, components: &str, unit: &'static str, description: &str) -> Self {
        Self {
            name: name.to_owned(),
            components: components.chars().map(String::from).collect(),
            unit,
            description: description.to_owned(),
        }
    }

    /// The modal amplitudes of the elastic modes with these numbers.
    pub fn modal(numbers: &[u32]) -> Self {
        Self {
            name: "q".to_owned(),
            components: numbers.iter().map(u32::to_string).collect(),
            unit: "1",
            description: "amplitude of each elastic mode, modes scaled to phi^t M phi = 1 kg m^2".to_owned(),
        }
    }

    /// The rates of the same amplitudes.
    pub fn modal_rates(numbers: &[u32]) -> Self {
        Self {
            name: "q_dot".to_owned(),
            unit: "1/s",
            description: "rate of the amplitude of each elastic mode".to_owned(),
            ..Self::modal(numbers)
        }
    }
}

/// Motion of frame A: (name, components, unit, description).
pub const MOTION: [(&str, &str, &str, &str); 7] = [
    ("t", "", "s", "time"),
    ("r_G", "xyz", "m", "position of the origin of A in G"),
    ("v_G", "xyz", "m/s", "inertial velocity of the origin of A, components in G"),
    ("w_G", "xyz", "rad/s", "angular velocity of A, components in G"),
    ("v_A", "xyz", "m/s", "inertial velocity of the origin of A, components in A"),
    ("w_A", "xyz", "rad/s", "angular velocity of A, components in A"),
    ("zeta", "wxyz", "1", "attitude quaternion, scalar first: turns components in A into components in G"),
];

/// What is conserved without loads: (name, components, unit, description).
pub const LEDGER: [(&str, &str, &str, &str); 6] = [
    ("r_CM_G", "xyz", "m", "position of the centre of mass in G"),
    ("p_G", "xyz", "kg m/s", "linear momentum, components in G"),
    ("L_G", "xyz", "kg m^2/s", "angular momentum about the origin of G, components in G"),
    ("E_kin", "", "J", "kinetic energy"),
    ("E_el", "", "J", "elastic energy"),
    (
        "E_grav",
        "",
        "J",
        "potential energy in the field of gravity, zero with the centre of mass at the origin of G",
    ),
];

/// How far a reduced run is estimated to be from the body it stands for.
pub fn error_channels() -> [ChannelSpec; 2] {
    let indicator = ChannelSpec::new(
        "error_indicator",
        "",
        "1",
        "estimated relative error so far: the largest of predicted_error",
    );
    let predicted = ChannelSpec {
        components: ["v_G", "w_G", "dR_A"].map(String::from).to_vec(),
        ..ChannelSpec::new(
            "predicted_error",
            "",
            "1",
            "estimated relative errors so far, as a validation measures them: largest error over largest length, of v_G, w_G and the worst dR_A",
        )
    };
    [indicator, predicted]
}

/// What the body does to what moves or holds frame A: force (N) and moment (N m) about the origin of A, components in A. (name,
/// description); the first is the sum of the others.
pub const REACTION: [(&str, &str); 4] = [
    (
        "reaction_A",
        "force (N) and moment about the origin of A (N m) of the body on what moves or holds A, components in A",
    ),
    ("reaction_inertia_A", "part of reaction_A: inertia of the undeformed body"),
    (
        "reaction_loads_A",
        "part of reaction_A: resultant of the loads and of the weight, at the deformed points",
    ),
    ("reaction_increment_A", "part of reaction_A: what elasticity adds"),
];

/// The two channels of a named point.
pub fn point_channels(point: &str) -> [ChannelSpec; 2] {
    [
        ChannelSpec::new(
            &format!("{point}.dR_A"),
            "xyz",
            "m",
            &format!("displacement of {point} in A from its place at the equilibrium"),
        ),
        ChannelSpec::new(&format!("{point}.R_G"), "xyz", "m", &format!("position of {point} in G")),
    ]
}

/// Attitude, velocities and accelerations of a named point.
pub fn point_motion_channels(point: &str) -> [ChannelSpec; 5] {
    let channel = |name: &str, components, unit, what: &str| {
        ChannelSpec::new(&format!("{point}.{name}"), components, unit, &format!("{what} of {point}"))
    };
    [
        channel("zeta", "wxyz", "1", "attitude quaternion, scalar first, node axes to G,"),
        channel("v_G", "xyz", "m/s", "velocity, components in G,"),
        channel("w_G", "xyz", "rad/s", "angular velocity, components in G,"),
        channel("a_G", "xyz", "m/s^2", "acceleration, components in G,"),
        channel("alpha_G", "xyz", "rad/s^2", "angular acceleration, components in G,"),
    ]
}

/// What a sensor reads.
pub fn sensor_channels(sensor: &str) -> [ChannelSpec; 3] {
    let channel = |name: &str, unit, what: &str| {
        let text = format!("{what} read by {sensor} in its own axes");
        ChannelSpec::new(&format!("{sensor}.{name}"), "xyz", unit, &text)
    };
    [
        channel("a_S", "m/s^2", "acceleration"),
        channel("w_S", "rad/s", "angular velocity"),
        channel("alpha_S", "rad/s^2", "angular acceleration"),
    ]
}

/// Section forces at a place of internal loads; in reduced models by the modes too.
pub fn section_channels(place: &str, reduced: bool) -> Vec<ChannelSpec> {
    let channel = |name: &str, unit, what: &str, how: &str| {
        let text = format!("{what} on the positive face of the section at {place}, in its axes{how}");
        ChannelSpec::new(&format!("{place}.{name}"), "xyz", unit, &text)
    };
    let best = if reduced { ", by summation of forces where the model allows it" } else { "" };
    let mut list = vec![channel("F", "N", "force", best), channel("M", "N m", "moment", best)];
    if reduced {
        let modes = ", by the strains of the modes";
        list.extend([channel("F_modes", "N", "force", modes), channel("M_modes", "N m", "moment", modes)]);
    }
    list
}

impl From<(&str, &str)> for ChannelSpec {
    fn from((name, description): (&str, &str)) -> Self {
        let components = ["fx", "fy", "fz", "mx", "my", "mz"].map(String::from).to_vec();
        Self { name: name.to_owned(), components, unit: "N, N m", description: description.to_owned() }
    }
}

impl From<(&str, &str, &'static str, &str)> for ChannelSpec {
    fn from((name, components, unit, description): (&str, &str, &'static str, &str)) -> Self {
        Self::new(name, components, unit, description)
    }
}
