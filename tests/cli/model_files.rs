//! `romgen info` and `romgen export`.

use std::process::{Command, Stdio};

use approx::assert_relative_eq;
use npyz::npz::NpzArchive;

use super::{frame, refused, romgen, romrun, said, structure, text};

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

/// Residual modes come last, say what they are, and are marched like modes; the model is rebuilt with them for a validation.
#[test]
fn residual_modes_are_told_marched_and_rebuilt() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("few.rom");
    let frame = structure("fmb.toml");
    let build = [
        "build",
        text(&frame),
        "--set",
        "elements=12",
        "--modes",
        "3",
        "--residual",
        "P,Q",
        "-o",
        text(&model),
    ];
    let out = said(romgen(&build));
    assert!(out.contains("3 elastic modes from") && out.contains("residual modes from"), "{out}");
    let info: serde_json::Value =
        serde_json::from_str(&said(romgen(&["info", text(&model), "--json"]))).unwrap();
    let residual: Vec<bool> =
        info["modes"].as_array().unwrap().iter().map(|m| m["residual"].as_bool().unwrap()).collect();
    assert!(
        residual.len() > 3 && residual[..3] == [false; 3] && residual[3..].iter().all(|r| *r),
        "{residual:?}"
    );
    // 13 nodes, one of them held: 72 elastic modes, and the residual ones are numbered from there.
    assert_eq!(info["modes"][3]["number"], 73);
    let shares = info["residual_loads"].as_array().unwrap();
    // M1 of load case 1 acts on the tips: three forces and three moments on each.
    assert_eq!(shares.len(), 12);
    let csv = folder.path().join("run");
    said(romrun(&[
        text(&model),
        "--loads",
        "lc2",
        "--t-end",
        "0.5",
        "--no-report",
        "--out",
        text(&csv),
        "--quiet",
    ]));
    let heading = std::fs::read_to_string(csv.join("results.csv")).unwrap();
    assert!(heading.lines().next().unwrap().contains("q.73"), "{}", heading.lines().next().unwrap());

    let errors = |arguments: &[&str]| -> f64 {
        let all = [
            &["validate"],
            arguments,
            &["--loads", "lc2", "--t-end", "2", "--method", "linear,rom", "--points", "P", "--json", "-"],
        ]
        .concat();
        let rows: serde_json::Value = serde_json::from_str(&said(romgen(&all))).unwrap();
        rows[0]["errors"]["P.dR_A"].as_f64().unwrap()
    };
    let alone = errors(&[text(&frame), "--set", "elements=12", "--modes", "3"]);
    let with = errors(&[text(&model)]);
    assert!(with < 0.2 * alone, "three modes {alone}, with residual modes {with}");

    let err = refused(romgen(&["build", text(&frame), "--residual", "tip", "-o", "unwritten.rom"]), 2);
    assert!(err.contains("no point `tip`") && err.contains("right corner"), "{err}");
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
