//! Model files on disk.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use super::container::{self, HEADER};
use super::error::FormatError;
use crate::data::ModelData;
use crate::model::Model;

impl Model {
    /// Reads a model file.
    ///
    /// # Errors
    /// As [`Model::from_bytes`], and what the operating system refuses; always with the name of the file.
    pub fn read_path(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        let path = path.as_ref();
        read(path).and_then(|bytes| Model::from_bytes(&bytes)).map_err(in_file(path))
    }

    /// Writes the model file atomically, see [`ModelData::write_path`].
    ///
    /// # Errors
    /// As [`ModelData::write_path`].
    pub fn write_path(&self, path: impl AsRef<Path>) -> Result<(), FormatError> {
        self.data().write_path(path)
    }
}

impl ModelData {
    /// Writes the model file atomically: whoever opens `path` sees the old file or the whole new one.
    ///
    /// # Errors
    /// What the operating system refuses, with the name of the file.
    pub fn write_path(&self, path: impl AsRef<Path>) -> Result<(), FormatError> {
        let path = path.as_ref();
        self.to_bytes().and_then(|bytes| write(path, &bytes)).map_err(in_file(path))
    }
}

fn in_file(path: &Path) -> impl FnOnce(FormatError) -> FormatError {
    let path = PathBuf::from(path);
    |source| FormatError::File { path, source: Box::new(source) }
}

fn io_error(action: &'static str) -> impl FnOnce(io::Error) -> FormatError {
    move |source| FormatError::Io { action, source }
}

/// The bytes of a file that starts like a model file and is as long as it says: a large file of another kind is
/// refused before memory is reserved for it.
fn read(path: &Path) -> Result<Vec<u8>, FormatError> {
    let mut file = File::open(path).map_err(io_error("open the model file"))?;
    let length = file.metadata().map_err(io_error("read the length of the model file"))?.len();
    let mut bytes = Vec::with_capacity(HEADER);
    let reading = || io_error("read the model file");
    (&mut file).take(HEADER as u64).read_to_end(&mut bytes).map_err(reading())?;
    let header = container::header(&bytes)?;
    if header.length != length {
        let expected = header.length;
        return Err(FormatError::Length { what: "the file", offset: 0, found: length, expected });
    }
    let rest = usize::try_from(length).unwrap_or(usize::MAX).saturating_sub(bytes.len());
    bytes
        .try_reserve_exact(rest)
        .map_err(|error| reading()(io::Error::new(io::ErrorKind::OutOfMemory, error)))?;
    file.take(rest as u64).read_to_end(&mut bytes).map_err(reading())?;
    Ok(bytes)
}

/// Writes beside the target, flushes to the disk, then renames over it.
fn write(path: &Path, bytes: &[u8]) -> Result<(), FormatError> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".rom-");
    #[cfg(unix)]
    {
        // Temporary files are private by default; a model file is an ordinary one (the umask still applies).
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder).map_err(io_error("create a file beside the model file"))?;
    file.write_all(bytes).map_err(io_error("write the model file"))?;
    file.as_file().sync_all().map_err(io_error("flush the model file to disk"))?;
    file.persist(path).map_err(|error| io_error("rename the finished model file into place")(error.error))?;
    // The rename itself must reach the disk too. Not every system lets a folder be opened: the file is whole anyway.
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}
