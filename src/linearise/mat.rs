//! A linear model as a MATLAB file of level 5, which MATLAB, Octave and scipy read: an element for every variable, little-endian, not
//! compressed ("MAT-File Format", The MathWorks).

use std::io::{self, Write};

use rom_generator::linearise::{Channel, StateSpace};

use crate::atomic::Sink;

/// Kinds of data.
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;

/// Classes of arrays.
const CELL: u32 = 1;
const CHAR: u32 = 4;
const NUMBERS: u32 = 6;
const COMPLEX: u32 = 0x0800;

/// `A`, `B`, `C`, `D`; names and units as columns of cells: `ss(A, B, C, D, 'StateName', states, 'InputName', inputs, ..)`.
pub(super) fn write(model: &StateSpace, origin: &str, sink: &mut dyn Sink) -> io::Result<()> {
    sink.write_all(&header())?;
    let mut put = |element: io::Result<Vec<u8>>| sink.write_all(&element?);
    for (name, matrix) in [("A", &model.a), ("B", &model.b), ("C", &model.c), ("D", &model.d)] {
        put(numbers(name, matrix.nrows(), matrix.ncols(), matrix.as_slice()))?;
    }
    let groups = [("states", &model.states), ("inputs", &model.inputs), ("outputs", &model.outputs)];
    for (name, channels) in groups {
        put(cells(name, channels, |channel| &channel.name))?;
    }
    for (name, channels) in groups {
        let units = format!("{}_units", name.trim_end_matches('s'));
        put(cells(&units, channels, |channel| channel.unit))?;
    }
    let parts =
        |of: fn(&rom_generator::linearise::Pole) -> f64| model.poles.iter().map(of).collect::<Vec<f64>>();
    let (re, im) = (parts(|pole| pole.re), parts(|pole| pole.im));
    put(array(
        "poles",
        NUMBERS | COMPLEX,
        re.len(),
        1,
        &[data(DOUBLE, &bytes(&re))?, data(DOUBLE, &bytes(&im))?],
    ))?;
    let steady = &model.steady;
    put(numbers("steady_q", steady.q.len(), 1, &steady.q))?;
    put(numbers("steady_velocity", 6, 1, &steady.velocity))?;
    put(numbers("steady_attitude", 4, 1, &steady.attitude))?;
    put(numbers("steady_position", 3, 1, &steady.position))?;
    put(text("origin", origin))
}

/// 116 characters of text, no subsystem, version 1, byte order.
fn header() -> [u8; 128] {
    let mut header = [b' '; 128];
    let words = b"MATLAB 5.0 MAT-file, written by romgen";
    header[..words.len()].copy_from_slice(words);
    header[116..124].fill(0);
    header[124..].copy_from_slice(&[0x00, 0x01, b'I', b'M']);
    header
}

/// Column by column.
fn numbers(name: &str, rows: usize, columns: usize, values: &[f64]) -> io::Result<Vec<u8>> {
    array(name, NUMBERS, rows, columns, &[data(DOUBLE, &bytes(values))?])
}

fn text(name: &str, text: &str) -> io::Result<Vec<u8>> {
    let units: Vec<u16> = text.encode_utf16().collect();
    let bytes: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
    array(name, CHAR, usize::from(!units.is_empty()), units.len(), &[data(UINT16, &bytes)?])
}

fn cells(name: &str, channels: &[Channel], of: impl Fn(&Channel) -> &str) -> io::Result<Vec<u8>> {
    let cells: Vec<Vec<u8>> =
        channels.iter().map(|channel| text("", of(channel))).collect::<io::Result<_>>()?;
    array(name, CELL, cells.len(), 1, &cells)
}

/// An array of `class`, with its parts.
fn array(name: &str, class: u32, rows: usize, columns: usize, parts: &[Vec<u8>]) -> io::Result<Vec<u8>> {
    let flags: Vec<u8> = [class, 0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let mut inside = data(UINT32, &flags)?;
    let shape = [rows, columns].map(|n| u32::try_from(n).map_err(|_| too_large()));
    let shape: Vec<u32> = shape.into_iter().collect::<io::Result<_>>()?;
    inside.extend(data(INT32, &shape.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>())?);
    inside.extend(data(INT8, name.as_bytes())?);
    parts.iter().for_each(|part| inside.extend(part));
    data(MATRIX, &inside)
}

/// Data with their kind and length, padded to eight bytes.
fn data(kind: u32, bytes: &[u8]) -> io::Result<Vec<u8>> {
    let length = u32::try_from(bytes.len()).map_err(|_| too_large())?;
    let mut out = Vec::with_capacity(bytes.len() + 16);
    out.write_all(&kind.to_le_bytes())?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(bytes)?;
    out.resize(out.len().next_multiple_of(8), 0);
    Ok(out)
}

fn bytes(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn too_large() -> io::Error {
    io::Error::other("MATLAB files of level 5 hold arrays up to 4 GB; write .npz instead")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes of the format's description, for a 1 x 2 matrix and a text.
    #[test]
    fn elements_are_as_the_format_says() {
        assert_eq!(header().len(), 128);
        let found = numbers("A", 1, 2, &[1.0, -2.0]).unwrap();
        let mut expected: Vec<u8> = vec![14, 0, 0, 0, 72, 0, 0, 0];
        expected.extend([6, 0, 0, 0, 8, 0, 0, 0, 6, 0, 0, 0, 0, 0, 0, 0]);
        expected.extend([5, 0, 0, 0, 8, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
        expected.extend([1, 0, 0, 0, 1, 0, 0, 0, b'A', 0, 0, 0, 0, 0, 0, 0]);
        expected.extend([9, 0, 0, 0, 16, 0, 0, 0]);
        expected.extend(1.0_f64.to_le_bytes());
        expected.extend((-2.0_f64).to_le_bytes());
        assert_eq!(found, expected);
        let word = text("s", "ab").unwrap();
        assert_eq!(&word[56..64], &[4, 0, 0, 0, 4, 0, 0, 0]);
        assert_eq!(&word[64..], &[b'a', 0, b'b', 0, 0, 0, 0, 0]);
    }
}
