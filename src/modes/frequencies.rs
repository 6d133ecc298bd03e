//! Frequencies against a load level, each curve one mode.

use std::io;
use std::path::Path;

use nalgebra::Vector3;
use rom_generator::equilibrium::trim::About;
use rom_generator::input::Structure;
use rom_generator::mesh::Mesh;
use rom_generator::vibration::{Spectrum, Support, analyse, spinning, track};
use serde::Serialize;

use crate::atomic;
use crate::failure::Failure;
use crate::parallel;
use crate::text::significant;

/// What is varied.
#[derive(Clone, Debug, PartialEq)]
pub enum Swept {
    /// The loads and the gravity of the equilibrium, times these factors; factors that balance it are solved for at each.
    LoadFactor(Vec<f64>),
    /// Spin of the clamped reference node about an axis of A (unit vector), rad/s.
    Spin(Vec<f64>, [f64; 3]),
    /// A parameter of the structure: its name, and values or expressions.
    Parameter(String, Vec<String>),
}

/// One point of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// As it was given.
    pub text: String,
    /// Its value.
    pub value: f64,
}

/// Frequencies of the same modes at every level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Frequencies {
    /// What is varied, with its unit.
    pub label: String,
    /// Its values - (levels).
    pub levels: Vec<f64>,
    /// Circular frequencies, rad/s, by mode as numbered at the first level; none where a mode is not among those found -
    /// (levels of m).
    pub omega: Vec<Vec<Option<f64>>>,
    /// Growth rates, 1/s; above round-off the motion is unstable - (levels of m).
    pub growth: Vec<Vec<Option<f64>>>,
    /// Modal assurance criterion with the level before: near one a mode has kept its shape - (levels of m).
    pub mac: Vec<Vec<Option<f64>>>,
}

/// Modes beyond those wanted that are looked at, so that a mode can pass others and still be found.
const SPARE: usize = 6;

/// Follows the lowest `count` modes of the first level through all levels.
///
/// # Errors
/// A level at which there is no such structure, equilibrium or mode; it is named.
pub fn frequencies(
    swept: &Swept,
    base: &Mesh,
    about: About,
    support: Support,
    count: usize,
    vary: &(dyn Fn(&str, &str) -> Result<Structure, Failure> + Sync),
) -> Result<Frequencies, Failure> {
    let (levels, label) = match swept {
        Swept::LoadFactor(values) => (numbers(values), "load factor".to_owned()),
        Swept::Spin(values, _) => (numbers(values), "spin (rad/s)".to_owned()),
        Swept::Parameter(name, values) => {
            (values.iter().map(|v| Level { text: v.clone(), value: f64::NAN }).collect(), name.clone())
        }
    };
    let work = |level: &Level| -> Result<(f64, Spectrum), Failure> {
        let here = |e: rom_generator::vibration::VibrationError| {
            let help = "leave this value out, or choose others";
            Failure::numerical(format!("{label} = {}: {e}", level.text), help)
        };
        match swept {
            Swept::LoadFactor(_) => {
                let Some(trim) = &base.trim else {
                    return Err(Failure::input(
                        "the structure has no equilibrium whose loads could be varied",
                        "give it an [equilibrium], see docs/structure-file.md",
                    ));
                };
                let found = trim.solve_at(base, level.value).map_err(|e| here(e.into()))?;
                let set = analyse(base, found.configuration, support, count + SPARE).map_err(here)?;
                Ok((level.value, Spectrum::from(&set)))
            }
            Swept::Spin(_, axis) => {
                let spin = Vector3::from(*axis) * level.value;
                Ok((level.value, spinning(base, &spin, count + SPARE).map_err(here)?))
            }
            Swept::Parameter(name, _) => {
                let structure = vary(name, &level.text)?;
                let mut mesh = structure.mesh();
                if let Some(trim) = &mut mesh.trim {
                    trim.about = about;
                }
                let value = structure.parameters().iter().find(|(n, _)| n == name).map_or(f64::NAN, |p| p.1);
                let set = super::of_mesh(&mesh, support, count + SPARE).map_err(here)?;
                Ok((value, Spectrum::from(&set)))
            }
        }
    };
    let found = parallel::map(&levels, work).into_iter().collect::<Result<Vec<_>, _>>()?;
    let (levels, spectra): (Vec<f64>, Vec<Spectrum>) = found.into_iter().unzip();
    let tracked = track(&spectra);
    let by_mode = |of: &dyn Fn(&Spectrum, usize, f64) -> f64| -> Vec<Vec<Option<f64>>> {
        let at = |(pairs, spectrum): (&Vec<Option<(usize, f64)>>, &Spectrum)| {
            pairs.iter().take(count).map(|pair| pair.map(|(k, mac)| of(spectrum, k, mac))).collect()
        };
        tracked.iter().zip(&spectra).map(at).collect()
    };
    Ok(Frequencies {
        label,
        levels,
        omega: by_mode(&|spectrum, k, _| spectrum.omega[k]),
        growth: by_mode(&|spectrum, k, _| spectrum.growth[k]),
        mac: by_mode(&|_, _, mac| mac),
    })
}

fn numbers(values: &[f64]) -> Vec<Level> {
    values.iter().map(|&value| Level { text: significant(value, 12), value }).collect()
}

impl Frequencies {
    /// Number of modes followed.
    fn modes(&self) -> usize {
        self.omega.first().map_or(0, Vec::len)
    }

    /// The frequencies of one mode; not a number where there is none - (levels).
    fn curve(&self, mode: usize) -> Vec<f64> {
        self.omega.iter().map(|level| level[mode].unwrap_or(f64::NAN)).collect()
    }

    /// Name and frequencies of every mode.
    pub(super) fn curves(&self) -> Vec<(String, Vec<f64>)> {
        (0..self.modes()).map(|mode| (format!("mode {}", mode + 1), self.curve(mode))).collect()
    }

    /// Rows under a heading.
    pub fn table(&self) -> Vec<Vec<String>> {
        let heading =
            std::iter::once(self.label.clone()).chain((1..=self.modes()).map(|k| format!("mode {k}")));
        let cell = |omega: &Option<f64>| omega.map_or_else(|| "–".to_owned(), |w| significant(w, 5));
        let row = |(level, omega): (&f64, &Vec<Option<f64>>)| {
            std::iter::once(significant(*level, 6)).chain(omega.iter().map(cell)).collect()
        };
        std::iter::once(heading.collect()).chain(self.levels.iter().zip(&self.omega).map(row)).collect()
    }

    /// What a reader of the table has to know beyond it: unstable levels, modes that cannot be followed with confidence.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        for (level, (omega, growth)) in self.levels.iter().zip(self.omega.iter().zip(&self.growth)) {
            let fastest = omega.iter().flatten().copied().fold(0.0, f64::max);
            if growth.iter().flatten().any(|g| *g > 1e-6 * fastest) {
                remarks.push(format!("unstable at {} = {}", self.label, significant(*level, 6)));
            }
        }
        for mode in 0..self.modes() {
            let doubtful = |k: &usize| self.mac[*k][mode].is_some_and(|mac| mac < 0.5);
            if let Some(k) = (1..self.levels.len()).find(doubtful) {
                let level = significant(self.levels[k], 6);
                remarks.push(format!(
                    "mode {} changes its shape before {} = {level} (MAC below 0.5): take more levels to follow it",
                    mode + 1,
                    self.label
                ));
            }
        }
        remarks
    }

    /// Writes one line per level: its value, then `omega` of every mode in rad/s; empty where there is none.
    ///
    /// # Errors
    /// Those of the file system, naming the file.
    pub fn write_csv(&self, path: &Path) -> io::Result<()> {
        let names: Vec<String> = (1..=self.modes()).map(|k| format!("omega_{k}")).collect();
        let mut text = format!("{},{}\n", self.label, names.join(","));
        for (level, omega) in self.levels.iter().zip(&self.omega) {
            let cells = omega.iter().map(|w| w.map_or_else(String::new, |w| w.to_string()));
            let row: Vec<String> = std::iter::once(level.to_string()).chain(cells).collect();
            text.push_str(&row.join(","));
            text.push('\n');
        }
        atomic::write(path, |sink| sink.write_all(text.as_bytes()))
    }
}
