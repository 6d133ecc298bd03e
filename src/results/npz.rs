//! NumPy archives.

use std::io::{self, Read, Seek, Write};
use std::path::Path;

use npyz::npz::{NpzArchive, NpzWriter};
use npyz::zip::{CompressionMethod, DateTime, write::FileOptions};
use npyz::{AutoSerialize, WriterBuilder};
use serde_json::{Map, Value, json};

use super::{Channel, Results};

const METADATA: &str = "metadata";

/// Sizes from which a zip entry needs 64-bit fields, with room for the array header.
const LARGE: usize = (u32::MAX as usize) - 65_536;

pub(super) fn write(results: &Results, sink: impl Write + Seek) -> io::Result<()> {
    let mut archive = NpzWriter::new(sink);
    for channel in results.channels() {
        let (rows, width) = (channel.rows() as u64, channel.width() as u64);
        let shape: &[u64] = if channel.components.is_empty() { &[rows] } else { &[rows, width] };
        write_array(&mut archive, &channel.name, shape, &channel.data)?;
    }
    let text = serde_json::to_vec(&described(results))?;
    write_array(&mut archive, METADATA, &[text.len() as u64], &text)?;
    archive.zip_writer().finish()?;
    Ok(())
}

/// Appends one array in C order to an archive; entries carry no time of day, so equal arrays give equal bytes.
///
/// # Errors
/// Those of the destination.
///
/// # Panics
/// When `shape` does not hold as many values as `data`: a mistake of the caller.
pub fn write_array<T: AutoSerialize + Copy, W: Write + Seek>(
    archive: &mut NpzWriter<W>,
    name: &str,
    shape: &[u64],
    data: &[T],
) -> io::Result<()> {
    assert_eq!(shape.iter().product::<u64>(), data.len() as u64, "shape of array {name}");
    let mut writer = archive
        .array::<T>(name, entry_options(size_of_val(data)))?
        .default_dtype()
        .shape(shape)
        .begin_nd()?;
    writer.extend(data.iter().copied())?;
    writer.finish()
}

/// Options of an entry of so many bytes, which carries no time of day.
pub fn entry_options(bytes: usize) -> FileOptions {
    FileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .large_file(bytes >= LARGE)
}

/// Metadata of the run and what each channel is.
fn described(results: &Results) -> Map<String, Value> {
    let mut metadata = results.metadata.clone();
    let channels = results.channels().iter().map(|c| {
        json!({ "name": c.name, "components": c.components, "unit": c.unit, "description": c.description })
    });
    metadata.insert("channels".to_owned(), channels.collect());
    metadata
}

pub(super) fn read(path: &Path) -> io::Result<Results> {
    let mut archive = NpzArchive::open(path)?;
    let text: Vec<u8> = read_array(&mut archive, METADATA)?;
    let mut metadata: Map<String, Value> = serde_json::from_slice(&text)?;
    let Some(Value::Array(descriptions)) = metadata.remove("channels") else {
        return Err(invalid("its metadata lists no channels"));
    };
    let mut channels = Vec::with_capacity(descriptions.len());
    for description in &descriptions {
        let text = |key: &str| {
            description[key].as_str().map(str::to_owned).ok_or_else(|| invalid("its metadata is incomplete"))
        };
        let components = description["components"].as_array().map(Vec::as_slice).unwrap_or_default();
        let name = text("name")?;
        channels.push(Channel {
            components: components.iter().filter_map(Value::as_str).map(str::to_owned).collect(),
            unit: text("unit")?,
            description: text("description")?,
            data: read_array(&mut archive, &name)?,
            name,
        });
    }
    Ok(Results { channels, metadata })
}

fn read_array<T: npyz::Deserialize, R: Read + Seek>(
    archive: &mut NpzArchive<R>,
    name: &str,
) -> io::Result<Vec<T>> {
    let array = archive.by_name(name)?.ok_or_else(|| invalid(&format!("it holds no array {name}")))?;
    array.into_vec()
}

fn invalid(message: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message)
}
