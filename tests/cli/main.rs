//! The two programs as a user meets them: files in, files and words out, exit codes.

mod clamped;
mod fmu;
mod linearise;
mod model_files;
mod modes;
mod pages;
mod plots;
mod reproduce;
mod runs;
mod serve;
mod structures;
mod sweep;
mod tutorial;
mod validate;
mod views;

use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::OnceLock;

use assert_cmd::Command;
use tempfile::TempDir;

/// A structure file of the repository.
fn structure(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name)
}

fn romgen(arguments: &[&str]) -> Output {
    Command::cargo_bin("romgen").unwrap().args(arguments).output().unwrap()
}

fn romrun(arguments: &[&str]) -> Output {
    Command::cargo_bin("romrun").unwrap().args(arguments).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Standard output of a command that should succeed.
fn said(output: Output) -> String {
    let (out, err) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert_eq!(output.status.code(), Some(0), "{out}\n{err}");
    assert_eq!(err, "", "nothing on standard error when it is not a terminal");
    out
}

/// Standard error of a command that should end with `code`, line breaks of the rendering undone.
fn refused(output: Output, code: i32) -> String {
    let err = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{err}");
    assert!(!err.contains("panicked"), "{err}");
    err.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

/// The frame as a model file, built once for all tests of this process.
fn frame() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("fmb.rom");
        said(romgen(&["build", text(&structure("fmb.toml")), "-o", text(&model)]));
        folder
    });
    // The path must outlive the borrow of the folder, which lives as long as the process.
    static MODEL: OnceLock<PathBuf> = OnceLock::new();
    MODEL.get_or_init(|| folder.path().join("fmb.rom"))
}
