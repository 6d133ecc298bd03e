//! `romgen validate`, on a coarse frame and short runs.

use approx::assert_relative_eq;
use rom_cli::results::Results;
use serde_json::Value;

use super::{refused, romgen, romrun, said, structure, text};

const COARSE: [&str; 4] = ["--set", "elements=12", "--t-end", "2"];

/// `romgen validate models/fmb.toml --loads lc2` on a coarse mesh and for two seconds.
fn validate(more: &[&str]) -> std::process::Output {
    let frame = structure("fmb.toml");
    romgen(&[&["validate", text(&frame), "--loads", "lc2"], &COARSE[..], more].concat())
}

fn rows(output: std::process::Output) -> Vec<Value> {
    serde_json::from_str(&said(output)).unwrap()
}

fn error(row: &Value, name: &str) -> f64 {
    row["errors"][name].as_f64().unwrap_or_else(|| panic!("no error of {name} in {row}"))
}

/// Largest row length of a channel, or of the difference of two.
fn largest(a: &Results, b: Option<&Results>, name: &str) -> f64 {
    let (a, b) = (a.channel(name).unwrap(), b.map(|b| b.channel(name).unwrap()));
    let length = |i: usize| {
        let other = |j: usize| b.map_or(0.0, |b| b.row(i)[j]);
        a.row(i).iter().enumerate().map(|(j, v)| (v - other(j)).powi(2)).sum::<f64>().sqrt()
    };
    (0..a.rows()).map(length).fold(0.0, f64::max)
}

/// Theory [26], computed again from the files that were written.
#[test]
fn errors_are_those_of_the_files() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("made/for/this");
    let rows = rows(validate(&["--method", "nonlinear,rom", "--json", "-", "--out", text(&out)]));
    let [row] = rows.as_slice() else { panic!("{rows:?}") };
    assert_eq!(row["loads"], "lc2");
    assert_eq!(row["set"], serde_json::json!({ "elements": 12.0 }));
    assert_eq!((&row["method"], &row["against"]), (&Value::from("rom"), &Value::from("nonlinear")));
    assert_eq!(row["modes"], 10);
    let read = |method: &str| Results::read_npz(&out.join(method).join("results.npz")).unwrap();
    let (nonlinear, rom) = (read("nonlinear"), read("rom"));
    for name in ["v_G", "w_G", "P.dR_A", "left corner.dR_A"] {
        let expected = largest(&rom, Some(&nonlinear), name) / largest(&nonlinear, None, name);
        assert_relative_eq!(error(row, name), expected, max_relative = 1e-12);
        assert!(expected > 1e-6 && expected < 0.1, "{name}: {expected}");
    }
    // The reference node and what is rigidly linked to it do not move in A.
    assert_eq!((&row["errors"]["A.dR_A"], &row["errors"]["CM.dR_A"]), (&Value::Null, &Value::Null));
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    for part in ["rom against nonlinear", "Displacement of P in A, z", "Angular velocity of A"] {
        assert!(report.contains(part), "{part}");
    }
    let written: Value = serde_json::from_slice(&std::fs::read(out.join("errors.json")).unwrap()).unwrap();
    assert_eq!(written, Value::Array(rows));
}

#[test]
fn a_sweep_over_modes_ends_where_it_says() {
    let rows = rows(validate(&["--method", "nonlinear,rom,rigid", "--sweep", "modes=0..2", "--json", "-"]));
    let place = |row: &Value| (row["modes"].as_u64().unwrap(), row["method"].as_str().unwrap().to_owned());
    let expected = [(0, "rom"), (0, "rigid"), (1, "rom"), (1, "rigid"), (2, "rom"), (2, "rigid")];
    assert_eq!(rows.iter().map(place).collect::<Vec<_>>(), expected.map(|(m, n)| (m, n.to_owned())));
    // Without elastic modes the reduced model is the rigid body, and no displacement is right.
    assert_eq!(rows[0]["errors"], rows[1]["errors"]);
    assert_eq!(error(&rows[0], "P.dR_A"), 1.0);
    // Two modes make the left tip better (the right one needs the third as early as this).
    assert!(error(&rows[4], "Q.dR_A") < 0.5, "{}", rows[4]);
}

/// Softer frames bend further, so that what is linear in the displacements errs more; the order of the rows is that of
/// the sweeps, whichever core was faster.
#[test]
fn sweeps_over_parameters_are_multiplied() {
    let sweeps = ["--sweep", "sigma=5,50", "--sweep", "modes=3,10", "--sweep", "h=0.05,0.06"];
    let more = [&["--method", "nonlinear,rom", "--points", "P", "--json", "-"], &sweeps[..]].concat();
    let rows = rows(validate(&more));
    let place = |row: &Value| (row["set"]["sigma"].clone(), row["set"]["h"].clone(), row["modes"].clone());
    let mut expected = Vec::new();
    for sigma in [5.0, 50.0] {
        for h in [0.05, 0.06] {
            expected.extend([3, 10].map(|modes| (Value::from(sigma), Value::from(h), Value::from(modes))));
        }
    }
    assert_eq!(rows.iter().map(place).collect::<Vec<_>>(), expected);
    assert!(rows.iter().all(|row| row["errors"].as_object().unwrap().len() == 3), "only P");
    assert!(error(&rows[1], "w_G") > error(&rows[5], "w_G"));
}

#[test]
fn a_model_file_stands_for_the_structure_and_options_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("soft.rom");
    let frame = structure("fmb.toml");
    let options = ["--set", "elements=12", "--set", "sigma=4", "--modes", "1,2,5"];
    said(romgen(&[&["build", text(&frame), "-o", text(&model)], &options[..]].concat()));
    let run = ["--loads", "lc2", "--t-end", "2", "--method", "nonlinear,rom", "--json", "-"];
    let from_model = rows(romgen(&[&["validate", text(&model)], &run[..]].concat()));
    let from_text = rows(romgen(&[&["validate", text(&frame)], &options[..], &run[..]].concat()));
    assert_eq!(from_model, from_text);
    assert_eq!(
        (&from_model[0]["modes"], &from_model[0]["set"]["sigma"]),
        (&Value::from(3), &Value::from(4.0))
    );
    let stiffer = rows(romgen(&[&["validate", text(&model), "--set", "sigma=40"], &run[..]].concat()));
    assert_eq!(stiffer[0]["set"], serde_json::json!({ "elements": 12.0, "sigma": 40.0 }));
}

/// One method alone writes what `romrun` writes, but for the amplitudes and estimates that only reduced models have.
#[test]
fn one_method_alone_writes_the_files_of_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let (full, reduced) = (folder.path().join("full"), folder.path().join("reduced"));
    let out = said(validate(&["--method", "nonlinear", "--out", text(&full), "--every", "7"]));
    assert!(out.contains("200 steps of 0.01 s, newmark (nonlinear)"), "{out}");
    let model = folder.path().join("frame.rom");
    said(romgen(&["build", text(&structure("fmb.toml")), "--set", "elements=12", "-o", text(&model), "-q"]));
    let every = ["--loads", "lc2", "--t-end", "2", "--every", "7", "--out", text(&reduced), "-q"];
    said(romrun(&[&[text(&model)], &every[..]].concat()));
    let read = |folder: &std::path::Path| Results::read_npz(&folder.join("results.npz")).unwrap();
    let (full_results, reduced_results) = (read(&full), read(&reduced));
    let of_reduced = |name: &str| {
        matches!(name, "q" | "q_dot") || name == "error_indicator" || name.starts_with("predicted_error")
    };
    let shapes = |results: &Results| {
        let channels = results.channels().iter().filter(|c| !of_reduced(&c.name));
        channels.map(|c| (c.name.clone(), c.components.clone(), c.unit.clone(), c.rows())).collect::<Vec<_>>()
    };
    assert!(full_results.channel("q").is_none() && reduced_results.channel("q").is_some());
    assert_eq!(shapes(&full_results), shapes(&reduced_results));
    assert_eq!(full_results.channel("t"), reduced_results.channel("t"));
    for file in ["results.csv", "summary.json", "report.html"] {
        assert!(full.join(file).is_file(), "{file}");
    }
    let summary: Value = serde_json::from_slice(&std::fs::read(full.join("summary.json")).unwrap()).unwrap();
    assert_eq!((&summary["method"], &summary["completed"]), (&Value::from("nonlinear"), &Value::from(true)));
}

/// The finite-element methods have no explicit integrator: that method says so, the others are compared.
#[test]
fn a_method_that_fails_does_not_take_the_others_along() {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("errors.json");
    let more =
        ["--method", "rom,nonlinear,rigid", "--modes", "3", "--integrator", "rk4", "--json", text(&json)];
    let err = refused(validate(&more), 3);
    assert!(err.contains("nonlinear, load case lc2") && err.contains("newmark or gen-alpha"), "{err}");
    let rows: Vec<Value> = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    assert_eq!(rows[0]["method"], "nonlinear");
    assert_eq!(rows[0]["errors"]["w_G"], Value::Null);
    assert!(rows[0]["failure"].as_str().unwrap().contains("nonlinear did not start"), "{}", rows[0]);
    assert_eq!(rows[1]["method"], "rigid");
    assert!(error(&rows[1], "w_G") > 0.0 && rows[1].get("failure").is_none());
}

#[test]
fn wrong_questions_are_refused_before_anything_runs() {
    for (more, part) in [
        (&["--method", "exact"][..], "no method `exact`"),
        (&["--method", "rom,rom"], "twice"),
        (&["--sweep", "sigma"], "name=a,b,c"),
        (&["--sweep", "sgma=1,2"], "sgma"),
        (&["--sweep", "sigma=1,-2"], "modulus"),
        (&["--sweep", "elements=12,24"], "elements is given twice"),
        (&["--sweep", "modes=1,2", "--modes", "3"], "modes is given twice"),
        (&["--points", "R"], "no point \"R\""),
        (&["--dt", "0"], "time step"),
        (&["--numerical-damping", "2"], "numerical damping is 2"),
    ] {
        let err = refused(validate(more), 2);
        assert!(err.contains(part), "{more:?}: {err}");
    }
    let frame = structure("fmb.toml");
    let err = refused(romgen(&["validate", text(&frame), "--loads", "lc3"]), 2);
    assert!(err.contains("no load case \"lc3\"") && err.contains("lc1, lc2, spiral"), "{err}");
}

#[test]
fn the_table_for_people() {
    let out = said(validate(&["--method", "nonlinear,rom", "--points", "P"]));
    for part in ["FMB, load case lc2: relative errors against nonlinear", "max |X|", "P.dR_A", " %"] {
        assert!(out.contains(part), "{part} in\n{out}");
    }
}

/// The reduced model says beside the measured errors what it estimates them at. Where they are that of its equations, with modes
/// enough and small steps, the estimate is within a factor of two of velocities and three of the displacement.
#[test]
fn predicted_errors_are_near_the_measured_ones() {
    let rows = rows(validate(&[
        "--method",
        "nonlinear,rom",
        "--points",
        "P",
        "--sweep",
        "sigma=10,100",
        "--json",
        "-",
    ]));
    for row in &rows {
        for (name, predicted, factor) in [("v_G", "v_G", 2.0), ("w_G", "w_G", 2.0), ("P.dR_A", "dR_A", 3.0)] {
            let (measured, predicted) = (error(row, name), row["predicted"][predicted].as_f64().unwrap());
            let quotient = predicted / measured;
            assert!(
                (1.0 / factor..factor).contains(&quotient),
                "{name}: predicted {predicted}, measured {measured}"
            );
        }
    }
    assert!(error(&rows[0], "v_G") > 3.0 * error(&rows[1], "v_G"), "the stiffer frame errs less");
}

/// Ten modes have no torsion of the aircraft's wing, which the gust twists and with it the lift: nearly all of the error of a geometric
/// model comes from loads per length on what the modes miss, one in ten of the velocities.
#[test]
fn loads_per_length_on_missing_modes_are_predicted() {
    let aircraft = structure("hale.toml");
    let options = ["--method", "nonlinear,rom", "--inertia", "consistent", "--elastic", "geometric"];
    let case = ["validate", text(&aircraft), "--loads", "gust", "--points", "right tip", "--json", "-"];
    let rows = rows(romgen(&[&case[..], &options].concat()));
    for name in ["v_G", "w_G"] {
        let (measured, predicted) = (error(&rows[0], name), rows[0]["predicted"][name].as_f64().unwrap());
        assert!(measured > 0.05, "{name}: {measured}");
        let quotient = predicted / measured;
        assert!((0.5..2.0).contains(&quotient), "{name}: predicted {predicted}, measured {measured}");
    }
}

/// Modes that meet a target are found and told; where none do nothing is written.
#[test]
fn modes_are_selected_to_meet_a_target() {
    let folder = tempfile::tempdir().unwrap();
    let (good, none) = (folder.path().join("good.rom"), folder.path().join("none.rom"));
    // Only the first two seconds of the load case: many models are run.
    let frame = folder.path().join("short.toml");
    let (head, case) = include_str!("../../models/fmb.toml").split_once("[load_cases.lc2]").unwrap();
    let text_of = format!("{head}[load_cases.lc2]{}", case.replacen("t_end = 10", "t_end = 2", 1));
    std::fs::write(&frame, text_of).unwrap();
    let build = |sigma: &str, target: &str, out: &std::path::Path, more: &[&str]| {
        let base = [
            "build",
            text(&frame),
            "--set",
            "elements=6",
            "--set",
            sigma,
            "--target-error",
            target,
            "--for",
            "lc2",
        ];
        romgen(&[&base[..], &["-o", text(out)], more].concat())
    };
    let out = said(build("sigma=300", "2%", &good, &[]));
    assert!(out.contains("mode 1") && out.contains("taken") && out.contains("left"), "{out}");
    let info: Value = serde_json::from_str(&said(romgen(&["info", text(&good), "--json"]))).unwrap();
    let selection = &info["selection"];
    let errors = selection["errors"].as_array().unwrap();
    assert!(errors.iter().all(|e| e[1].as_f64().unwrap() <= 0.02), "{errors:?}");
    assert!(info["modes"].as_array().unwrap().len() < 10);

    let err = refused(build("sigma=10", "0.0001%", &none, &["--quiet"]), 3);
    assert!(err.contains("no model meets 0.0001 %") && !none.exists(), "{err}");
    refused(build("sigma=10", "0.0001%", &none, &["--quiet", "--keep-best"]), 3);
    assert!(none.exists());
    refused(romgen(&["build", text(&frame), "--target-error", "1%"]), 2);
    refused(build("sigma=10", "-1%", &none, &[]), 2);
}

/// The motion of every method for ParaView, internal loads on its lines where the structure tells any.
#[test]
fn motions_for_paraview() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let aircraft = structure("hale.toml");
    let run =
        ["--loads", "gust", "--method", "nonlinear,rom,rigid", "--t-end", "0.05", "--vtk=3", "--no-report"];
    said(romgen(&[&["validate", text(&aircraft), "--out", text(&out)], &run[..]].concat()));
    for method in ["nonlinear", "rom", "rigid"] {
        let collection = std::fs::read_to_string(out.join(method).join("structure.pvd")).unwrap();
        assert_eq!(collection.matches("<DataSet").count(), 3, "{method}: {collection}");
        let grid = std::fs::read_to_string(out.join(method).join("vtk/structure_0002.vtu")).unwrap();
        for field in ["displacement", "internal_force", "internal_moment", "member"] {
            assert!(grid.contains(&format!("Name=\"{field}\"")), "{method}: {field}");
        }
        let summary = std::fs::read_to_string(out.join(method).join("summary.json")).unwrap();
        assert!(summary.contains("structure.pvd"), "{summary}");
    }
    let words = refused(romgen(&["validate", text(&aircraft), "--loads", "gust", "--vtk"]), 2);
    assert!(words.contains("--out"), "{words}");
}
