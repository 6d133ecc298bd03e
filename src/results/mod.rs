//! Time histories of one run, whichever method made them, and the files they are written to.
//!
//! A [`Results`] is a table with named groups of columns, the [`Channel`]s, one row per instant. The same names
//! appear in `results.npz` (arrays, n x k) and in `results.csv` (columns, `name.component`).

mod csv;
mod names;
mod npz;

pub use names::{
    ChannelSpec, LEDGER, MOTION, REACTION, error_channels, point_channels, point_motion_channels,
    section_channels, sensor_channels,
};
pub use npz::{entry_options, write_array};

use std::io;
use std::path::Path;

use serde_json::{Map, Value};

use crate::atomic;

/// One quantity over time: `rows x components`.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name, for example `v_G` or `P.dR_A`.
    pub name: String,
    /// Names of the components (`x`, `y`, `z`); empty for a scalar, whose array has one dimension.
    pub components: Vec<String>,
    /// Unit, for example `m/s`.
    pub unit: String,
    /// One line for people: what it is and in which frame.
    pub description: String,
    /// Values, row after row - (rows x max(1, components)).
    pub data: Vec<f64>,
}

impl Channel {
    /// Number of columns.
    pub fn width(&self) -> usize {
        self.components.len().max(1)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.data.len() / self.width()
    }

    /// Row `i` - (components).
    ///
    /// # Panics
    /// When there is no such row.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.data[i * self.width()..(i + 1) * self.width()]
    }

    /// Column `j` over time - (rows).
    pub fn column(&self, j: usize) -> impl Iterator<Item = f64> + '_ {
        self.data.iter().skip(j).step_by(self.width()).copied()
    }

    /// Names of the columns in a flat table: `name.component`, or `name` for a scalar.
    pub fn column_names(&self) -> Vec<String> {
        if self.components.is_empty() {
            vec![self.name.clone()]
        } else {
            self.components.iter().map(|c| format!("{}.{c}", self.name)).collect()
        }
    }
}

/// The channels of one run, all with the same number of rows, and facts about the run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Results {
    channels: Vec<Channel>,
    /// Facts that do not vary with time (model, load case, method, settings); nothing that changes when the same run
    /// is repeated, so that equal runs give equal files.
    pub metadata: Map<String, Value>,
}

impl Results {
    /// No channels, `metadata` as given.
    pub fn new(metadata: Map<String, Value>) -> Self {
        Self { channels: Vec::new(), metadata }
    }

    /// Adds an empty channel, to be filled row by row with [`Results::push`]; returns its index.
    ///
    /// # Panics
    /// When the name is taken or rows have been written already: both are mistakes of the caller.
    pub fn add(&mut self, spec: &ChannelSpec, expected_rows: usize) -> usize {
        assert!(self.channel(&spec.name).is_none(), "two channels are named {}", spec.name);
        assert!(self.rows() == 0, "channel {} comes after the first row", spec.name);
        self.channels.push(Channel {
            name: spec.name.clone(),
            components: spec.components.clone(),
            unit: spec.unit.to_owned(),
            description: spec.description.clone(),
            data: Vec::with_capacity(expected_rows * spec.components.len().max(1)),
        });
        self.channels.len() - 1
    }

    /// Appends one row to channel `index`.
    ///
    /// # Panics
    /// When `row` has not as many values as the channel has components.
    pub fn push(&mut self, index: usize, row: &[f64]) {
        let channel = &mut self.channels[index];
        assert_eq!(row.len(), channel.width(), "a row of channel {}", channel.name);
        channel.data.extend_from_slice(row);
    }

    /// All channels, in the order they were added.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The channel of that name.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|c| c.name == name)
    }

    /// Number of instants.
    pub fn rows(&self) -> usize {
        self.channels.first().map_or(0, Channel::rows)
    }

    /// The rows for which `keep` says so, and the last.
    pub fn thinned(mut self, keep: impl Fn(usize) -> bool) -> Self {
        let rows = self.rows();
        for channel in &mut self.channels {
            let width = channel.width();
            let kept = (0..rows).filter(|&i| keep(i) || i + 1 == rows);
            channel.data =
                kept.flat_map(|i| channel.data[i * width..(i + 1) * width].iter().copied()).collect();
        }
        self
    }

    /// Without the channels for which `keep` does not say so.
    pub fn only(mut self, keep: impl Fn(&str) -> bool) -> Self {
        self.channels.retain(|channel| keep(&channel.name));
        self
    }

    /// Writes an uncompressed NumPy archive: one array per channel and `metadata`, a JSON text as bytes (uint8) with
    /// the facts about the run and the unit, components and meaning of every channel. Equal results give equal bytes.
    ///
    /// # Errors
    /// Those of the file system, naming the file.
    pub fn write_npz(&self, path: &Path) -> io::Result<()> {
        atomic::write(path, |sink| npz::write(self, sink))
    }

    /// Reads back what [`Results::write_npz`] wrote.
    ///
    /// # Errors
    /// Those of the file system, and when the file is not such an archive.
    pub fn read_npz(path: &Path) -> io::Result<Self> {
        npz::read(path).map_err(|e| io::Error::new(e.kind(), format!("{}: {e}", path.display())))
    }

    /// Writes comma-separated values: one line of column names, then one line per instant. Every number is the
    /// shortest text that reads back to the same bits.
    ///
    /// # Errors
    /// Those of the file system, naming the file.
    pub fn write_csv(&self, path: &Path) -> io::Result<()> {
        atomic::write(path, |sink| csv::write(self, sink))
    }
}

#[cfg(test)]
mod tests;
