//! The modes as rows, for people and machines.

use rom_generator::vibration::{ModeSet, Shape, Support};
use serde::Serialize;

use crate::info::shares;
use crate::text::significant;

/// One mode; `modes.json` is a list of these.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModeRow {
    /// Number among the elastic modes, from 1.
    pub number: usize,
    /// Circular frequency, rad/s.
    pub omega: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Generalised mass with the largest displacement scaled to 1 m, kg; none where nodes turn but do not move.
    pub mass_at_unit_displacement: Option<f64>,
    /// Displacement of the centre of mass per unit amplitude, times the root of the mass: zero but for round-off in free modes.
    pub drift_of_centre_of_mass: f64,
    /// Symmetry about each plane of symmetry, in words; empty where there is none.
    pub symmetry: String,
    /// Share of the kinetic energy: translation along and rotation about x, y, z of A.
    pub kinetic_energy_share: [f64; 6],
    /// Effective masses along (kg) and about (kg m^2) x, y, z of A where the reference node is clamped.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_mass: Option<[f64; 6]>,
}

/// All modes of a set.
pub fn mode_rows(set: &ModeSet) -> Vec<ModeRow> {
    let row = |(k, mode): (usize, &Shape)| ModeRow {
        number: k + 1,
        omega: mode.omega,
        frequency_hz: mode.omega / std::f64::consts::TAU,
        mass_at_unit_displacement: Some(mode.mass_at_unit_displacement).filter(|m| m.is_finite()),
        drift_of_centre_of_mass: mode.drift,
        symmetry: super::symmetry(set, &mode.parity),
        kinetic_energy_share: mode.kinetic_share,
        effective_mass: (set.support == Support::Clamped).then_some(mode.effective_mass),
    };
    set.modes.iter().enumerate().map(row).collect()
}

/// Rows under a heading.
pub fn table(set: &ModeSet) -> Vec<Vec<String>> {
    let clamped = set.support == Support::Clamped;
    let mut heading = vec!["mode", "omega (rad/s)", "f (Hz)", "mass at 1 m (kg)"];
    heading.extend(if clamped { ["effective mass x, y, z (%)"] } else { ["drift of CM"] });
    if !set.planes.is_empty() {
        heading.push("symmetry");
    }
    heading.push("kinetic energy along and about axes of A");
    let row = |row: &ModeRow| {
        let mut cells = vec![
            row.number.to_string(),
            significant(row.omega, 6),
            significant(row.frequency_hz, 5),
            row.mass_at_unit_displacement.map_or_else(|| "–".to_owned(), |m| significant(m, 4)),
            match &row.effective_mass {
                None => significant(row.drift_of_centre_of_mass, 1),
                Some(masses) => {
                    let percent = |m: &f64| format!("{:.1}", 100.0 * m / set.mass);
                    masses[..3].iter().map(percent).collect::<Vec<_>>().join(", ")
                }
            },
        ];
        if !set.planes.is_empty() {
            cells.push(row.symmetry.clone());
        }
        cells.push(shares(&row.kinetic_energy_share));
        cells
    };
    let heading = heading.into_iter().map(String::from).collect();
    std::iter::once(heading).chain(mode_rows(set).iter().map(row)).collect()
}
