//! Variables of blocks of stations: arrays with a row for every station.
//!
//! A block has ten: what it does (position, attitude, velocities), and force and moment on it in each of three frames. FMI 3.0 lists the
//! arrays; FMI 2.0, which has none, their elements ([`super::Variables::scalars`]). An element has the reference of its array and its place in it.

use rom_runtime::data::{ModelData, StationsData};
use rom_runtime::loads::DistributedFrame;

use super::{InputBlock, List, Role, Variable, identifier};

const STATIONS: u32 = 3_000_000_000;
const PER_BLOCK: u32 = 4_000_000;
/// References of an array. Of the sixteen that a block has room for the first eight are outputs.
const PER_ARRAY: u32 = 250_000;
const INPUTS: u32 = 8 * PER_ARRAY;

/// Components of the outputs: position, attitude, velocity, angular velocity.
const WIDTHS: [usize; 4] = [3, 4, 3, 3];
const COLUMNS: [&str; 2] = ["xyz", "wxyz"];

/// Whether a model has these blocks, each once, and there are references for them.
///
/// # Errors
/// What is wrong, in words.
pub fn check_stations(data: &ModelData, stations: &[usize]) -> Result<(), String> {
    let blocks = (u32::MAX - STATIONS) / PER_BLOCK;
    for (slot, block) in stations.iter().enumerate() {
        let Some(of) = data.stations.get(*block) else {
            let n = data.stations.len();
            return Err(format!("there is no block of stations {block}, the model has {n}, from 0"));
        };
        let (name, n) = (&of.name, of.sections.len());
        if stations.iter().take(slot).any(|other| other == block) {
            return Err(format!("the block of stations {name:?} is given twice"));
        }
        let most = PER_ARRAY as usize / 4;
        if n > most {
            let what = format!("the block of stations {name:?} has {n} of them");
            return Err(format!("{what}, expected at most {most} in an FMU"));
        }
        if *block >= blocks as usize {
            return Err(format!("{name:?} comes after {blocks} blocks of stations: an FMU has those before"));
        }
    }
    Ok(())
}

/// Output, station and component of a place among the outputs of `n` stations.
pub(crate) fn output(n: usize, place: usize) -> Option<(usize, usize, usize)> {
    let mut rest = place;
    for (output, width) in WIDTHS.into_iter().enumerate() {
        if rest < width * n {
            return Some((output, rest / width, rest % width));
        }
        rest -= width * n;
    }
    None
}

impl List {
    /// Of the block with the index `block` in the model, the `slot`-th of those asked for.
    pub(super) fn stations(&mut self, slot: usize, block: usize, data: &StationsData) {
        let (own, n) = (identifier(&data.name), data.sections.len());
        let first = STATIONS + PER_BLOCK * block as u32;
        let outputs = [
            ("R_G", "m", "positions of the stations in G"),
            ("zeta", "1", "attitude quaternions of the stations, scalar first, section axes to G"),
            ("v_G", "m/s", "velocities of the stations, components in G"),
            ("w_G", "rad/s", "angular velocities of the sections of the stations, components in G"),
        ];
        let mut place = 0;
        for ((name, unit, what), (array, width)) in outputs.into_iter().zip((0..).zip(WIDTHS)) {
            let reference = first + PER_ARRAY * array;
            self.push(reference, format!("{own}.{name}"), unit, what.into(), Role::Station(slot, place));
            self.is_array([n, width]);
            place += width * n;
        }
        let frames = [
            ("dead", DistributedFrame::Dead, "in G"),
            ("body", DistributedFrame::Body, "in A"),
            ("follower", DistributedFrame::Follower, "in the axes of their sections"),
        ];
        let mut reference = first + INPUTS;
        for (frame, axes, components) in frames {
            let start = 6 * self.inputs.len();
            let blocks = (0..n).map(|station| InputBlock::Station { slot, station, frame: axes });
            self.inputs.extend(blocks);
            for (offset, name, unit) in [(0, "force", "N"), (3, "moment", "N.m")] {
                let what = format!("{name}s on the stations, components {components}");
                let name = format!("{own}.{frame}.{name}");
                self.push(reference, name, unit, what, Role::Input(start + offset));
                self.is_array([n, 3]);
                reference += PER_ARRAY;
            }
        }
    }

    fn is_array(&mut self, shape: [usize; 2]) {
        if let Some(last) = self.all.last_mut() {
            last.shape = Some(shape);
        }
    }
}

impl Variable {
    /// Number of elements: 1 for a scalar.
    pub fn size(&self) -> usize {
        self.shape.map_or(1, |[rows, columns]| rows * columns)
    }

    /// What an element stands for.
    pub(super) fn element(&self, place: usize) -> Role {
        match self.role {
            // Six inputs a station, of which the array is the first or the last three.
            Role::Input(start) if self.shape.is_some() => Role::Input(start + 6 * (place / 3) + place % 3),
            Role::Station(slot, start) => Role::Station(slot, start + place),
            other => other,
        }
    }

    /// The elements as variables of their own: `wing.R_G[3].x`.
    pub(super) fn scalars(&self) -> Vec<Variable> {
        let Some([rows, columns]) = self.shape else { return vec![self.clone()] };
        let scalar = |(place, component): (usize, char)| Variable {
            reference: self.reference + place as u32,
            name: format!("{}[{}].{component}", self.name, 1 + place / columns),
            description: format!("{}, {component}", self.description),
            role: self.element(place),
            shape: None,
            ..self.clone()
        };
        let components = COLUMNS[usize::from(columns == 4)].chars().cycle();
        (0..rows * columns).zip(components).map(scalar).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_found_again() {
        assert_eq!(output(5, 0), Some((0, 0, 0)));
        assert_eq!(output(5, 14), Some((0, 4, 2)));
        assert_eq!(output(5, 15 + 4 * 3 + 1), Some((1, 3, 1)));
        assert_eq!(output(5, 15 + 20 + 15 + 14), Some((3, 4, 2)));
        assert_eq!(output(5, 65), None);
    }

    #[test]
    fn elements_of_inputs_are_six_a_station() {
        let name = "wing.body.moment".to_owned();
        let variable = Variable {
            reference: STATIONS,
            name,
            unit: "N.m",
            description: String::new(),
            role: Role::Input(15),
            derivative: None,
            shape: Some([4, 3]),
        };
        let scalars = variable.scalars();
        assert_eq!(scalars.len(), 12);
        let last = &scalars[11];
        assert_eq!((last.reference, last.role), (STATIONS + 11, Role::Input(15 + 18 + 2)));
        assert_eq!(last.name, "wing.body.moment[4].z");
    }
}
