//! `romgen info` and `romgen export`.

use std::process::{Command, Stdio};

use approx::assert_relative_eq;
use npyz::npz::NpzArchive;

use super::{frame, refused, romgen, said, text};

/// Elastic frequencies of the frame at sigma = 10 with 120 elements, rad/s: figures beside Table 3 of Hesse & Palacios
/// (2012), from an independent computation given to five digits.
const FREQUENCIES: [f64; 8] = [6.919, 15.319, 16.377, 21.576, 23.126, 40.263, 61.515, 67.911];

#[test]
fn info_for_machines() {
    let info: serde_json::Value =
        serde_json::from_str(&said(romgen(&["info", text(frame()), "--json"]))).unwrap();
    let modes = info["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 10);
    for (mode, omega) in modes.iter().zip(FREQUENCIES) {
        assert_relative_eq!(mode["omega"].as_f64().unwrap(), omega, max_relative = 2e-4);
        let share: f64 =
            mode["kinetic_energy_share"].as_array().unwrap().iter().map(|s| s.as_f64().unwrap()).sum();
        assert_relative_eq!(share, 1.0, epsilon = 1e-9);
    }
    assert_relative_eq!(info["rigid"]["mass"].as_f64().unwrap(), 405.0, max_relative = 1e-12);
    assert_relative_eq!(info["rigid"]["centre_of_mass"][2].as_f64().unwrap(), 5.0 / 6.0, max_relative = 1e-9);
    // RK4 is stable up to omega dt = 2 sqrt(2) without damping.
    let highest = modes[9]["omega"].as_f64().unwrap();
    let dt = info["stable_time_step"]["rk4"].as_f64().unwrap();
    assert_relative_eq!(dt * highest, 8.0_f64.sqrt(), max_relative = 0.01);
    assert!(info["checks"].as_array().unwrap().iter().all(|c| c["passed"] == true));
}

#[test]
fn info_for_people() {
    let out = said(romgen(&["info", text(frame())]));
    for part in ["10 elastic modes", "6.919", "mass 405 kg", "couples mode", "lc2:", "SHA-256", "sigma = 10"]
    {
        assert!(out.contains(part), "{part} in\n{out}");
    }
}

/// `romgen info FILE | head -1`: the reader goes, the writer ends quietly.
#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("romgen"))
        .args(["info", text(frame())])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]));
}

#[test]
fn a_file_that_is_no_model_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let whole = std::fs::read(frame()).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    let cases = [
        ("empty", Vec::new()),
        ("text", b"hello, I am not a model".to_vec()),
        ("short", whole[..whole.len() / 2].to_vec()),
        ("flipped", flipped),
        ("long", [whole.as_slice(), b"x"].concat()),
    ];
    for (name, bytes) in cases {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let err = refused(romgen(&["info", text(&path)]), 2);
        assert!(err.contains(name), "{err}");
    }
    refused(romgen(&["info", "no/such.rom"]), 2);
}

#[test]
fn export_holds_every_array_under_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fmb.npz");
    said(romgen(&["export", text(frame()), "--npz", text(&path)]));
    let mut archive = NpzArchive::open(&path).unwrap();
    let mut shape =
        |name: &str| archive.by_name(name).unwrap().unwrap_or_else(|| panic!("no {name}")).shape().to_vec();
    assert_eq!(shape("M"), [16, 16]);
    assert_eq!(shape("K"), [16, 16]);
    assert_eq!(shape("modes.phi_r"), [6, 10]);
    assert_eq!(shape("points.right corner.phi_translation"), [3, 10]);
    assert_eq!(shape("c.value"), shape("c.r"));
    assert_eq!(shape("k.value"), shape("k.s"));
    let stiffness: Vec<f64> = archive.by_name("K").unwrap().unwrap().into_vec().unwrap();
    assert_relative_eq!(stiffness[0].sqrt(), FREQUENCIES[0], max_relative = 2e-4);
}
