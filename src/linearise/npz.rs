//! A linear model as a NumPy archive.

use std::io;

use nalgebra::DMatrix;
use npyz::npz::NpzWriter;
use npyz::{DType, WriterBuilder};
use rom_generator::linearise::{Channel, StateSpace};

use super::metadata;
use crate::atomic::Sink;
use crate::results::{entry_options as options, write_array};

/// Matrices, `poles` as (n x 2) real and imaginary parts, and names, units and descriptions as UTF-8 bytes of a JSON text, `metadata`;
/// the names besides as arrays of text, `states`, `inputs`, `outputs`.
pub(super) fn write(model: &StateSpace, origin: &str, sink: &mut dyn Sink) -> io::Result<()> {
    let mut archive = NpzWriter::new(sink);
    for (name, matrix) in [("A", &model.a), ("B", &model.b), ("C", &model.c), ("D", &model.d)] {
        let rows = by_rows(matrix);
        write_array(&mut archive, name, &[matrix.nrows() as u64, matrix.ncols() as u64], &rows)?;
    }
    let poles: Vec<f64> = model.poles.iter().flat_map(|pole| [pole.re, pole.im]).collect();
    write_array(&mut archive, "poles", &[model.poles.len() as u64, 2], &poles)?;
    for (name, channels) in
        [("states", &model.states), ("inputs", &model.inputs), ("outputs", &model.outputs)]
    {
        text_array(&mut archive, name, channels)?;
    }
    let steady = &model.steady;
    write_array(&mut archive, "steady.q", &[steady.q.len() as u64], &steady.q)?;
    write_array(&mut archive, "steady.velocity", &[6], &steady.velocity)?;
    write_array(&mut archive, "steady.attitude", &[4], &steady.attitude)?;
    write_array(&mut archive, "steady.position", &[3], &steady.position)?;
    let text = serde_json::to_vec(&metadata(model, origin))?;
    write_array(&mut archive, "metadata", &[text.len() as u64], &text)?;
    archive.zip_writer().finish()?;
    Ok(())
}

fn by_rows(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

/// Names, as numpy's own text.
fn text_array(archive: &mut NpzWriter<&mut dyn Sink>, name: &str, channels: &[Channel]) -> io::Result<()> {
    let longest = channels.iter().map(|channel| channel.name.chars().count()).max().unwrap_or(1).max(1);
    let text = format!("<U{longest}").parse().map_err(io::Error::other)?;
    let writer = archive.array::<str>(name, options(0))?.dtype(DType::new_scalar(text));
    let mut writer = writer.shape(&[channels.len() as u64]).begin_nd()?;
    for channel in channels {
        writer.push(&channel.name)?;
    }
    writer.finish()
}
