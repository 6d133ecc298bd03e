//! Structural damping as the structure file asks for it; its strain part is with the sections ([`super::Section::retardation`]).

/// Damping in proportion to modes and to mass (theory section 10); none by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Damping {
    /// Ratios of critical damping of the elastic modes.
    pub modal: ModalRatios,
    /// Rayleigh's mass factor `alpha`, 1/s: it acts on the elastic part of the velocities alone.
    pub alpha: f64,
}

/// Critical damping ratios by the number of the mode in the ascending list of elastic modes.
#[derive(Clone, Debug, PartialEq)]
pub enum ModalRatios {
    /// One for all.
    All(f64),
    /// Of mode 1, 2, ..; zero for those beyond.
    Listed(Vec<f64>),
}

impl Default for ModalRatios {
    fn default() -> Self {
        Self::All(0.0)
    }
}

impl ModalRatios {
    /// Modes that one ratio for all damps in the finite-element methods, which have thousands of modes: the lowest so many.
    pub const MODES: usize = 30;

    /// Ratio of a mode, numbered from 1.
    pub fn of(&self, mode: usize) -> f64 {
        match self {
            Self::All(ratio) => *ratio,
            Self::Listed(ratios) => mode.checked_sub(1).and_then(|i| ratios.get(i)).copied().unwrap_or(0.0),
        }
    }

    /// How many of the lowest modes the finite-element methods have to know; zero where nothing is damped.
    pub fn count(&self) -> usize {
        match self {
            Self::All(ratio) if *ratio == 0.0 => 0,
            Self::All(_) => Self::MODES,
            Self::Listed(ratios) => ratios.iter().rposition(|&ratio| ratio != 0.0).map_or(0, |last| last + 1),
        }
    }
}
