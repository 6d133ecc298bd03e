//! What a build is asked for: modes, mass matrix, elastic forces.

use std::fmt;
use std::str::FromStr;

use crate::reduce::residual::ResidualSelection;

/// Most modes a reduced model may keep: its tensors grow with the square of the number.
pub const MAX_MODES: usize = 300;

/// Which elastic modes to keep.
#[derive(Clone, Debug, PartialEq)]
pub enum ModeSelection {
    /// The lowest so many.
    Count(usize),
    /// By number in the ascending list, from 1.
    List(Vec<usize>),
    /// All below a circular frequency, rad/s.
    Below(f64),
}

impl fmt::Display for ModeSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(n) => write!(f, "{n}"),
            // A comma tells a list of one from a count.
            Self::List(list) if list.len() == 1 => write!(f, "{},", list[0]),
            Self::List(list) => f.write_str(&list.iter().map(usize::to_string).collect::<Vec<_>>().join(",")),
            Self::Below(omega) => write!(f, "{omega}rad/s"),
        }
    }
}

/// `10` (the lowest ten), `1,2,5` (these; `5,` is mode 5 alone), `60Hz` or `400rad/s` (all below this frequency).
impl FromStr for ModeSelection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if let Some(limit) = frequency(text) {
            return limit.map(Self::Below);
        }
        if text.contains(',') {
            let items = text.strip_suffix(',').unwrap_or(text).split(',');
            let list = items.map(mode_number).collect::<Result<Vec<usize>, String>>()?;
            return mode_list(list).map(Self::List);
        }
        text.parse().map(Self::Count).map_err(|_| {
            format!(
                "expected a count (10), a list (1,2,5) or a frequency limit (60Hz, 400rad/s), found {text:?}"
            )
        })
    }
}

/// A frequency with its unit, rad/s; none where the text has no unit.
pub(crate) fn frequency(text: &str) -> Option<Result<f64, String>> {
    let lower = text.trim().to_ascii_lowercase();
    let (number, factor) = [("hz", std::f64::consts::TAU), ("rad/s", 1.0)]
        .into_iter()
        .find_map(|(unit, factor)| Some((lower.strip_suffix(unit)?.trim(), factor)))?;
    Some(match number.parse::<f64>() {
        Ok(limit) if limit.is_finite() && limit > 0.0 => Ok(limit * factor),
        _ => Err(format!("expected a positive frequency before the unit, found {number:?}")),
    })
}

/// In ascending order.
pub(crate) fn mode_list(mut list: Vec<usize>) -> Result<Vec<usize>, String> {
    list.sort_unstable();
    match list.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(format!("mode {} is listed twice", pair[0])),
        None => Ok(list),
    }
}

fn mode_number(text: &str) -> Result<usize, String> {
    match text.trim().parse() {
        Ok(0) => Err("there is no mode 0: elastic modes are numbered from 1".to_owned()),
        Ok(number) => Ok(number),
        Err(_) => Err(format!("expected the number of an elastic mode, found {:?}", text.trim())),
    }
}

/// What the mass matrix of the reduced model depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Inertia {
    /// That of the equilibrium, as in the paper.
    #[default]
    Constant,
    /// That of the deformed body.
    Consistent,
}

/// The elastic forces of the reduced model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Elastic {
    /// Linear in the amplitudes of modes whose shapes are linear too, as in the paper.
    #[default]
    Linear,
    /// Those of large deflections, on the curved manifold of linear strains. Asks for consistent inertia.
    Geometric,
}

impl fmt::Display for Inertia {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Constant => "constant",
            Self::Consistent => "consistent",
        })
    }
}

impl fmt::Display for Elastic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Linear => "linear",
            Self::Geometric => "geometric",
        })
    }
}

impl FromStr for Inertia {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Self::Constant, Self::Consistent]
            .into_iter()
            .find(|x| x.to_string() == text)
            .ok_or_else(|| format!("expected constant or consistent, found {text:?}"))
    }
}

impl FromStr for Elastic {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Self::Linear, Self::Geometric]
            .into_iter()
            .find(|x| x.to_string() == text)
            .ok_or_else(|| format!("expected linear or geometric, found {text:?}"))
    }
}

/// Options of a build.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildOptions {
    /// Modes to keep.
    pub modes: ModeSelection,
    /// Points to make residual modes for.
    pub residual: ResidualSelection,
    /// Store every node for pictures, not only as many as a drawing needs.
    pub all_nodes: bool,
    /// Mass matrix of the reduced model.
    pub inertia: Inertia,
    /// Elastic forces of the reduced model.
    pub elastic: Elastic,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            modes: ModeSelection::Count(10),
            residual: ResidualSelection::None,
            all_nodes: true,
            inertia: Inertia::default(),
            elastic: Elastic::default(),
        }
    }
}

/// What a structure file says about its reduction; none where it leaves that to the command.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reduction {
    /// Modes to keep.
    pub modes: Option<ModeSelection>,
    /// Points to make residual modes for.
    pub residual: Option<ResidualSelection>,
    /// Mass matrix of the reduced model.
    pub inertia: Option<Inertia>,
    /// Elastic forces of the reduced model.
    pub elastic: Option<Elastic>,
}

impl Reduction {
    /// What is said here, else what `other` says.
    pub fn or(self, other: &Self) -> Self {
        Self {
            modes: self.modes.or_else(|| other.modes.clone()),
            residual: self.residual.or_else(|| other.residual.clone()),
            inertia: self.inertia.or(other.inertia),
            elastic: self.elastic.or(other.elastic),
        }
    }

    /// Options of a build, with the defaults where nothing is said.
    pub fn options(self, all_nodes: bool) -> BuildOptions {
        let default = BuildOptions::default();
        BuildOptions {
            modes: self.modes.unwrap_or(default.modes),
            residual: self.residual.unwrap_or_default(),
            all_nodes,
            inertia: self.inertia.unwrap_or_default(),
            elastic: self.elastic.unwrap_or_default(),
        }
    }
}
