//! The table of a sweep on disk: a line for every case that is done, appended as they finish.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::atomic;

/// What is found in the folder of an earlier sweep.
pub(super) struct Earlier {
    /// Lines of the cases that are done: number, and the numbers of the line.
    pub(super) done: Vec<(usize, Vec<f64>)>,
}

/// Lines are appended whole, by one thread at a time.
pub(super) struct Log {
    path: PathBuf,
    file: Mutex<File>,
}

impl Log {
    /// Opens the table of a sweep that is called `identity`, with the column names of `head`; goes on where an earlier one of the same
    /// identity was stopped. A last line without an end is dropped.
    ///
    /// # Errors
    /// Those of the file system, and `InvalidInput` when the folder holds another sweep.
    pub(super) fn open(
        folder: &Path,
        identity: &str,
        head: &str,
        columns: usize,
    ) -> io::Result<(Self, Earlier)> {
        atomic::make_folder(folder)?;
        let (identity_path, path) = (folder.join("sweep.json"), folder.join("cases.csv"));
        let mut done = Vec::new();
        match std::fs::read_to_string(&identity_path) {
            Ok(found) if found == identity => {
                if let Ok(text) = std::fs::read_to_string(&path) {
                    done = whole_lines(&text, head, columns);
                }
            }
            Ok(_) => {
                let message = format!("{} holds another sweep", folder.display());
                return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
            }
            Err(e) if e.kind() == io::ErrorKind::NotFound => {}
            Err(e) => return Err(e),
        }
        // The table first: where there is an identity, the lines are of that sweep.
        write_table(&path, head, &done)?;
        atomic::write(&identity_path, |sink| sink.write_all(identity.as_bytes()))?;
        let file = OpenOptions::new().append(true).open(&path)?;
        Ok((Log { path, file: Mutex::new(file) }, Earlier { done }))
    }

    /// Appends lines in one piece.
    ///
    /// # Errors
    /// Those of the file system.
    pub(super) fn append(&self, lines: &str) -> io::Result<()> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(lines.as_bytes())
            .map_err(|e| io::Error::new(e.kind(), format!("{}: {e}", self.path.display())))
    }
}

/// A line of the table.
pub(super) fn line(case: usize, values: &[f64]) -> String {
    let mut text = case.to_string();
    for value in values {
        text += &format!(",{value}");
    }
    text + "\n"
}

/// The table with the cases in order, whole or not at all.
///
/// # Errors
/// Those of the file system.
pub(super) fn write_table(path: &Path, head: &str, rows: &[(usize, Vec<f64>)]) -> io::Result<()> {
    atomic::write(path, |sink| {
        writeln!(sink, "{head}")?;
        rows.iter().try_for_each(|(case, values)| sink.write_all(line(*case, values).as_bytes()))
    })
}

/// Lines that are there to their end; nothing of a table with another head.
fn whole_lines(text: &str, head: &str, columns: usize) -> Vec<(usize, Vec<f64>)> {
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    let mut lines = whole.lines();
    if lines.next() != Some(head) {
        return Vec::new();
    }
    let parse = |line: &str| {
        let (case, rest) = line.split_once(',')?;
        let values: Vec<f64> = rest.split(',').map(|x| x.parse().ok()).collect::<Option<_>>()?;
        (values.len() == columns).then_some((case.parse().ok()?, values))
    };
    let mut done: Vec<(usize, Vec<f64>)> = lines.filter_map(parse).collect();
    done.sort_by_key(|(case, _)| *case);
    done.dedup_by_key(|(case, _)| *case);
    done
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_written_line_is_not_taken() {
        let text = "case,a,b\n2,1.5,2\n0,1,2\n1,3,4";
        assert_eq!(whole_lines(text, "case,a,b", 2), [(0, vec![1.0, 2.0]), (2, vec![1.5, 2.0])]);
        assert!(whole_lines(text, "case,a", 1).is_empty() && whole_lines("", "case", 0).is_empty());
    }

    #[test]
    fn another_sweep_is_not_mixed_in() {
        let folder = tempfile::tempdir().unwrap();
        let open = |identity| Log::open(folder.path(), identity, "case,a", 1);
        let (log, earlier) = open("one").unwrap();
        assert!(earlier.done.is_empty());
        log.append(&line(3, &[0.1])).unwrap();
        log.append("4,0.").unwrap();
        assert_eq!(open("one").unwrap().1.done, [(3, vec![0.1])]);
        assert!(open("two").is_err());
    }
}
