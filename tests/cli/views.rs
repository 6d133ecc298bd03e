//! Reports on models, files for ParaView, help for shells, Ctrl-C.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rom_cli::results::Results;
use serde_json::Value;

use crate::{frame, refused, romgen, romrun, said, structure, text};

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

#[test]
fn a_model_has_a_report_with_its_modes() {
    let folder = tempfile::tempdir().unwrap();
    let report = folder.path().join("model.html");
    let said_nothing = said(romgen(&["info", text(frame()), "--report", text(&report), "--quiet"]));
    assert_eq!(said_nothing, "");
    let html = read(&report);
    for part in [
        "data-scene=\"0\"",
        "mode 1, 1.101 Hz",
        "id=\"three\"",
        "Checks made when it was built",
        "romgen info",
    ] {
        assert!(html.contains(part), "{part}");
    }
    let model = folder.path().join("a.rom");
    let built = said(romgen(&["build", text(&structure("fmb.toml")), "--json", "-o", text(&model)]));
    let info: Value = serde_json::from_str(&built).unwrap();
    assert_eq!(info["modes"].as_array().unwrap().len(), 10);
    assert!(model.exists());
}

#[test]
fn a_run_goes_to_paraview() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let arguments =
        ["--loads", "lc2", "--t-end", "1", "--vtk=5", "--json", "--no-report", "--out", text(&out)];
    let summary: Value =
        serde_json::from_str(&said(romrun(&[&[text(frame())][..], &arguments].concat()))).unwrap();
    assert_eq!(summary["files"]["vtk"], text(&out.join("structure.pvd")));
    let collection = read(&out.join("structure.pvd"));
    assert_eq!(collection.matches("<DataSet").count(), 5);
    assert!(collection.contains(r#"timestep="0""#) && collection.contains(r#"timestep="1""#), "{collection}");
    let grid = read(&out.join("vtk/structure_0004.vtu"));
    for part in ["NumberOfPoints=\"121\"", "NumberOfCells=\"120\"", "\"displacement\"", "\"velocity\""] {
        assert!(grid.contains(part), "{part}");
    }
    let results = Results::read_npz(&out.join("results.npz")).unwrap();
    assert_eq!(results.channel("q_dot").unwrap().width(), 10);
    let modes = folder.path().join("modes.vtu");
    said(romgen(&["export", text(frame()), "--vtk", text(&modes)]));
    assert!(read(&modes).contains("Name=\"mode 10 in space\""));
    // Something has to be asked for.
    assert!(refused(romgen(&["export", text(frame())]), 2).contains("--npz"));
}

#[test]
fn shells_and_man_know_the_commands() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        assert!(said(romgen(&["completions", shell])).contains("validate"), "{shell}");
        assert!(said(romgen(&["completions", shell, "romrun"])).contains("numerical-damping"), "{shell}");
    }
    let folder = tempfile::tempdir().unwrap();
    said(romgen(&["man", text(folder.path())]));
    for (page, part) in
        [("romgen", "reproduce"), ("romgen-build", "all\\-nodes"), ("romrun", "point\\-motion")]
    {
        assert!(read(&folder.path().join(format!("{page}.1"))).contains(part), "{page}");
    }
}

#[test]
fn a_structure_is_told_as_json() {
    let told: Value =
        serde_json::from_str(&said(romgen(&["check", text(&structure("fmb.toml")), "--json"]))).unwrap();
    assert_eq!((told["elements"].as_u64(), told["members"].as_u64()), (Some(120), Some(4)));
    assert_eq!(said(romgen(&["check", text(&structure("fmb.toml")), "--quiet"])), "");
}

/// What goes to a file or a pipe has no colours in it.
#[test]
fn no_colours_where_no_terminal_is() {
    for arguments in [&["build", "no such file.toml"][..], &["frobnicate"], &["--help"]] {
        let output = romgen(arguments);
        assert!(!output.stdout.contains(&0x1b) && !output.stderr.contains(&0x1b), "{arguments:?}");
    }
}

/// Ctrl-C in the middle of a run: what there is gets written, whole, and the exit code says so.
#[test]
#[cfg(unix)]
fn ctrl_c_leaves_complete_files() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    // An hour of simulated time would take longer than anyone waits here; few of its rows are kept.
    let mut child = Command::new(env!("CARGO_BIN_EXE_romrun"))
        .args([text(frame()), "--loads", "lc2", "--t-end", "100000", "--every", "1000", "--out", text(&out)])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(700));
    let interrupt = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(interrupt.success(), "the run was over before it could be stopped");
    let start = Instant::now();
    let output = loop {
        if child.try_wait().unwrap().is_some() {
            break child.wait_with_output().unwrap();
        }
        assert!(start.elapsed() < Duration::from_secs(60), "it does not stop");
        std::thread::sleep(Duration::from_millis(20));
    };
    assert!(refused(output, 130).contains("interrupted: 0 of 1 load cases done, load case lc2 at t ="));
    let summary: Value = serde_json::from_str(&read(&out.join("summary.json"))).unwrap();
    assert_eq!(
        (&summary["completed"], &summary["failure"]["message"]),
        (&Value::Bool(false), &"interrupted".into())
    );
    let results = Results::read_npz(&out.join("results.npz")).unwrap();
    assert_eq!(results.metadata["completed"], Value::Bool(false));
    let last = *results.channel("t").unwrap().data.last().unwrap();
    let told = summary["last"]["t"].as_f64().unwrap();
    // JSON numbers may read back to a neighbour.
    assert!(last > 0.0 && last < 100_000.0 && (last - told).abs() <= 1e-12 * last, "{last} {told}");
    assert!(read(&out.join("report.html")).contains("Stopped early"));
}
