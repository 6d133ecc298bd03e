//! `romrun`.

use std::path::Path;

use approx::assert_relative_eq;
use rom_cli::results::Results;
use serde_json::Value;

use super::{frame, refused, romgen, romrun, said, structure, text};

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn load_case_2_of_the_frame() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("made/for/this");
    let summary = json(&said(romrun(&[text(frame()), "--loads", "lc2", "--json", "--out", text(&out)])));
    // Published: dR_z of P reaches about -0.079 of the arm (5 m); an independent prototype of the same model gives w_y
    // between -0.75 and 0.87 rad/s. Both are read from curves: two digits.
    let point = &summary["points"]["P"];
    assert_relative_eq!(number(&point["extreme_dr_a"][2]) / 5.0, -0.079, epsilon = 0.001);
    assert_relative_eq!(number(&point["extreme_time"][2]), 9.3, epsilon = 0.1);
    assert_relative_eq!(number(&summary["range"]["w_G"][1][0]), -0.75, epsilon = 0.01);
    assert_relative_eq!(number(&summary["range"]["w_G"][1][1]), 0.87, epsilon = 0.01);
    assert_eq!(summary["completed"], true);
    assert_eq!((&summary["steps"], &summary["rows"]), (&Value::from(1000), &Value::from(1001)));

    let results = Results::read_npz(&out.join("results.npz")).unwrap();
    let named = ["A", "right corner", "left corner", "P", "Q", "CM"];
    let named = named.into_iter().flat_map(|p| [(format!("{p}.dR_A"), 3), (format!("{p}.R_G"), 3)]);
    let fixed =
        [("t", 1), ("r_G", 3), ("v_G", 3), ("w_G", 3), ("v_A", 3), ("w_A", 3), ("zeta", 4), ("q", 10)];
    let ledger = [("r_CM_G", 3), ("p_G", 3), ("L_G", 3), ("E_kin", 1), ("E_el", 1), ("E_grav", 1)];
    for (name, width) in fixed.into_iter().chain(ledger).map(|(n, w)| (n.to_owned(), w)).chain(named) {
        let channel = results.channel(&name).unwrap_or_else(|| panic!("no {name}"));
        assert_eq!((channel.rows(), channel.width()), (1001, width), "{name}");
    }
    assert!(results.channel("A.dR_A").unwrap().data.iter().all(|&v| v == 0.0), "A is on the reference node");
    let t = results.channel("t").unwrap();
    assert_eq!((t.data[0], t.data[1000]), (0.0, 10.0));

    // The csv has the same columns, in the same order, and the same numbers.
    let csv = std::fs::read_to_string(out.join("results.csv")).unwrap();
    let mut lines = csv.lines();
    let names: Vec<String> = results.channels().iter().flat_map(|c| c.column_names()).collect();
    assert_eq!(lines.next().unwrap(), names.join(","));
    for (i, line) in lines.enumerate() {
        let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        let same: Vec<f64> = results.channels().iter().flat_map(|c| c.row(i)).copied().collect();
        assert_eq!(values, same, "row {i}");
    }

    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    for part in ["FMB, load case lc2", "Angular velocity of A", "Modal amplitudes", "Displacement of P in A"]
    {
        assert!(report.contains(part), "{part}");
    }
    assert_eq!(json(&std::fs::read_to_string(out.join("summary.json")).unwrap()), summary);
}

/// The kinematic identities between channels hold to round-off at every instant.
#[test]
fn channels_fit_together() {
    let folder = tempfile::tempdir().unwrap();
    said(romrun(&[text(frame()), "--loads", "lc2", "--out", text(folder.path()), "--every", "50"]));
    let results = Results::read_npz(&folder.path().join("results.npz")).unwrap();
    let vector =
        |name: &str, i: usize| nalgebra::Vector3::from_row_slice(results.channel(name).unwrap().row(i));
    assert_eq!(results.rows(), 21);
    for i in 0..results.rows() {
        let z = results.channel("zeta").unwrap().row(i);
        let attitude = nalgebra::Quaternion::new(z[0], z[1], z[2], z[3]);
        assert_relative_eq!(attitude.norm(), 1.0, epsilon = 1e-12);
        let attitude = nalgebra::UnitQuaternion::new_unchecked(attitude);
        for (a, g) in [("v_A", "v_G"), ("w_A", "w_G")] {
            assert_relative_eq!(attitude * vector(a, i), vector(g, i), epsilon = 1e-12);
        }
        let drawing = nalgebra::Vector3::new(10.0, 0.0, 5.0);
        let position = vector("r_G", i) + attitude * (drawing + vector("P.dR_A", i));
        assert_relative_eq!(position, vector("P.R_G", i), epsilon = 1e-12);
    }
}

#[test]
fn the_same_run_gives_the_same_files() {
    let folder = tempfile::tempdir().unwrap();
    let files = ["a", "b"].map(|name| {
        let out = folder.path().join(name);
        said(romrun(&[text(frame()), "--loads", "lc1", "--t-end", "2", "--out", text(&out), "--quiet"]));
        ["results.npz", "results.csv"].map(|file| std::fs::read(out.join(file)).unwrap())
    });
    assert_eq!(files[0], files[1]);
}

#[test]
fn without_loads_the_load_cases_are_listed() {
    let out = said(romrun(&[text(frame())]));
    assert!(out.contains("lc1") && out.contains("lc2") && out.contains("--loads lc1"), "{out}");
}

#[test]
fn several_load_cases_get_a_folder_each() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        text(frame()),
        "--loads",
        "all",
        "--t-end",
        "0.5",
        "--out",
        text(folder.path()),
        "--json",
        "--no-report",
    ];
    let summaries = json(&said(romrun(&arguments)));
    let cases: Vec<&str> =
        summaries.as_array().unwrap().iter().map(|s| s["load_case"].as_str().unwrap()).collect();
    assert_eq!(cases, ["lc1", "lc2", "spiral"]);
    for case in cases {
        assert!(folder.path().join(case).join("results.npz").is_file(), "{case}");
        assert!(!folder.path().join(case).join("report.html").exists(), "--no-report");
    }
}

#[test]
fn every_integrator_gives_the_same_motion() {
    let folder = tempfile::tempdir().unwrap();
    let peak = |integrator: &str| {
        let arguments =
            [text(frame()), "--loads", "lc2", "--integrator", integrator, "--numerical-damping", "0"];
        let out = folder.path().join(integrator);
        let arguments = [&arguments[..], &["--json", "--out", text(&out), "--dt", "0.005"]].concat();
        number(&json(&said(romrun(&arguments)))["points"]["P"]["extreme_dr_a"][2])
    };
    // Second order at omega dt = 0.035 for the mode that matters: differences of the order of 1e-4.
    let reference = peak("rk4");
    for integrator in ["newmark", "gen-alpha"] {
        assert_relative_eq!(peak(integrator), reference, max_relative = 1e-3);
    }
}

/// RK4 has no numerical damping, so that of the load case is not meant for it; one asked for by name is refused.
#[test]
fn explicit_integration_knows_its_limits() {
    let folder = tempfile::tempdir().unwrap();
    let rk4 = [text(frame()), "--loads", "lc2", "--integrator", "rk4", "--out", text(folder.path())];
    said(romrun(&rk4));
    let err = refused(romrun(&[&rk4[..], &["--dt", "0.05"]].concat()), 2);
    assert!(err.contains("0.05") && err.contains("dt <="), "{err}");
    refused(romrun(&[&rk4[..], &["--numerical-damping", "0.1"]].concat()), 2);
}

#[test]
fn only_the_points_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let base = [text(frame()), "--loads", "lc2", "--t-end", "0.1", "--out", text(folder.path())];
    said(romrun(&[&base[..], &["--points", "Q,left corner"]].concat()));
    let results = Results::read_npz(&folder.path().join("results.npz")).unwrap();
    let points: Vec<&str> = results.channels().iter().filter_map(|c| c.name.strip_suffix(".R_G")).collect();
    assert_eq!(points, ["Q", "left corner"]);
    let err = refused(romrun(&[&base[..], &["--points", "R"]].concat()), 2);
    assert!(err.contains("R") && err.contains("left corner"), "{err}");
}

#[test]
fn an_end_between_two_steps_is_reached_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let out =
        said(romrun(&[text(frame()), "--loads", "lc2", "--t-end", "0.105", "--out", text(folder.path())]));
    assert!(
        out.contains("0.105 s is not a whole number of steps of 0.01 s: the run ends at 0.11 s"),
        "{out}"
    );
}

fn load_file(folder: &Path, force: &str) -> std::path::PathBuf {
    let path = folder.join("pull.toml");
    let text = format!(
        "[parameters]\nf = {force}\n[load_cases.pull]\ndescription = \"a pull\"\nt_end = 1\ndt = 0.01\n\
         loads = [{{ point = \"P\", frame = \"dead\", force = [0, 0, \"f\"], time = {{ shape = \"constant\", value = 1 }} }}]\n"
    );
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn load_cases_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = load_file(folder.path(), "1");
    let out = folder.path().join("out");
    let base = [text(frame()), "--loads", text(&file), "--out", text(&out), "--json"];
    let speed = |extra: &[&str]| {
        let summary = json(&said(romrun(&[&base[..], extra].concat())));
        assert_eq!(summary["load_case"], "pull");
        let results = Results::read_npz(&out.join("results.npz")).unwrap();
        results.channel("p_G").unwrap().row(100)[2]
    };
    // Momentum is force times time; nearly, in the reduced model, and exactly in proportion while all is small.
    assert_relative_eq!(speed(&[]), 1.0, max_relative = 1e-2);
    assert_relative_eq!(speed(&["--set", "f=3"]), 3.0, max_relative = 1e-2);
}

#[test]
fn a_run_that_fails_says_when_and_keeps_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let file = load_file(folder.path(), "1e12");
    let out = folder.path().join("out");
    let err = refused(romrun(&[text(frame()), "--loads", text(&file), "--out", text(&out)]), 3);
    assert!(err.contains("load case pull") && err.contains("t = ") && err.contains("--dt"), "{err}");
    let summary = json(&std::fs::read_to_string(out.join("summary.json")).unwrap());
    assert_eq!(summary["completed"], false);
    assert!(summary["failure"]["message"].is_string());
    let results = Results::read_npz(&out.join("results.npz")).unwrap();
    assert_eq!(results.rows() as f64 - 1.0, number(&summary["steps"]));
    assert!(results.channels().iter().all(|c| c.data.iter().all(|v| v.is_finite())));
    assert!(std::fs::read_to_string(out.join("report.html")).unwrap().contains("Stopped early"));
}

#[test]
fn what_makes_no_sense_is_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let base = [text(frame()), "--out", text(&out)];
    for (arguments, part) in [
        (&["--loads", "lc3"][..], "lc1, lc2"),
        (&["--loads", "lc1,lc3"], "lc3"),
        (&["--loads", "lc1,lc1"], "twice"),
        (&["--loads", "all,lc1"], "two load cases are named lc1"),
        (&["--loads", "no/such.toml"], "cannot be read"),
        (&["--loads", "lc1", "--set", "sigma=3"], "--set has nothing to act on"),
        (&["--loads", "lc1", "--dt", "0"], "time step is 0"),
        (&["--loads", "lc1", "--dt=-0.1"], "time step is -0.1"),
        (&["--loads", "lc1", "--dt", "nan"], "time step is NaN"),
        (&["--loads", "lc1", "--t-end", "inf"], "ends at inf"),
        (&["--loads", "lc1", "--every", "0"], "--every 1"),
        (&["--loads", "lc1", "--numerical-damping", "2"], "from 0 to 1"),
        (&["--loads", "lc1", "--integrator", "euler"], "newmark, rk4, gen-alpha"),
        (&["--loads", "lc1", "--dt", "1e-9"], "--every"),
    ] {
        let err = refused(romrun(&[&base[..], arguments].concat()), 2);
        assert!(err.contains(part), "{arguments:?}: {err}");
        assert!(!out.exists(), "{arguments:?}");
    }
}

#[test]
fn a_rigid_body_and_the_beam_run_too() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("m.rom");
    for (input, modes, case) in
        [("fmb.toml", "0", "lc1"), ("ffb.toml", "4", "planar"), ("ffb.toml", "8", "spatial")]
    {
        said(romgen(&["build", text(&structure(input)), "--modes", modes, "-o", text(&model)]));
        let out = folder.path().join(case);
        said(romrun(&[text(&model), "--loads", case, "--t-end", "1", "--out", text(&out)]));
    }
}
