//! `romgen check`, `schema`, `build`.

use super::{refused, romgen, romrun, said, structure, text};

#[test]
fn check_says_what_is_in_a_sound_file() {
    let out =
        said(romgen(&["check", text(&structure("fmb.toml")), "--set", "elements=60", "--set", "sigma=3*10"]));
    for part in ["is sound: FMB", "60 elements", "sigma = 30", "lc2"] {
        assert!(out.contains(part), "{part} in\n{out}");
    }
}

#[test]
fn a_wrong_file_is_refused_with_place_and_hint() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wrong.toml");
    let sound = std::fs::read_to_string(structure("fmb.toml")).unwrap();
    std::fs::write(&path, sound.replace("torsion_constant", "torsion_konstant")).unwrap();
    for command in [&["check", text(&path)][..], &["build", text(&path)]] {
        let err = refused(romgen(command), 2);
        assert!(
            err.contains("torsion_konstant") && err.contains("help:") && err.contains("wrong.toml:"),
            "{err}"
        );
    }
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let err = refused(romgen(&["check", "no/such.toml"]), 2);
    assert!(err.contains("no/such.toml") && err.contains("cannot be read"), "{err}");
}

#[test]
fn set_refuses_what_the_file_has_not() {
    let err = refused(romgen(&["check", text(&structure("fmb.toml")), "--set", "sgima=3"]), 2);
    assert!(err.contains("sgima") && err.contains("sigma"), "{err}");
}

#[test]
fn the_schema_is_json_and_knows_the_tables() {
    let schema: serde_json::Value = serde_json::from_str(&said(romgen(&["schema"]))).unwrap();
    for table in ["structure", "sections", "points", "members", "load_cases"] {
        assert!(schema["properties"][table].is_object(), "{table}");
    }
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let built = ["a.rom", "b.rom"].map(|name| {
        let path = folder.path().join(name);
        let input = structure("ffb.toml");
        said(romgen(&[
            "build",
            text(&input),
            "--modes",
            "60Hz",
            "--all-nodes",
            "-o",
            text(&path),
            "--quiet",
        ]));
        std::fs::read(path).unwrap()
    });
    assert_eq!(built[0], built[1]);
}

#[test]
fn modes_can_be_chosen_by_count_list_and_frequency() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.rom");
    // Frequencies of the frame, rad/s: 6.92, 15.32, 16.38, 21.58, 23.13, 40.26, ...
    for (modes, numbers) in [
        ("0", &[][..]),
        ("3", &[1, 2, 3]),
        ("5,2", &[2, 5]),
        ("4,", &[4]),
        ("17rad/s", &[1, 2, 3]),
        ("3.5Hz", &[1, 2, 3, 4]),
    ] {
        let input = structure("fmb.toml");
        said(romgen(&["build", text(&input), "--set", "elements=60", "--modes", modes, "-o", text(&path)]));
        let info: serde_json::Value =
            serde_json::from_str(&said(romgen(&["info", text(&path), "--json"]))).unwrap();
        let found: Vec<u64> =
            info["modes"].as_array().unwrap().iter().map(|m| m["number"].as_u64().unwrap()).collect();
        assert_eq!(found, numbers, "--modes {modes}");
    }
}

#[test]
fn impossible_modes_are_refused() {
    let input = structure("fmb.toml");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.rom");
    for modes in ["ten", "1,1", "0,1", "-5Hz", "100000", "1,100000"] {
        refused(romgen(&["build", text(&input), "--modes", modes, "-o", text(&path)]), 2);
        assert!(!path.exists());
    }
}

#[test]
fn a_place_that_cannot_be_written_is_another_failure() {
    let err = refused(romgen(&["build", text(&structure("ffb.toml")), "-o", "no/such/folder/m.rom"]), 1);
    assert!(err.contains("no/such/folder/m.rom"), "{err}");
}

#[test]
fn the_demo_needs_no_other_file() {
    let folder = tempfile::tempdir().unwrap();
    let demo = folder.path().join("demo");
    let out = said(romgen(&["demo", "--out", text(&demo), "--set", "elements=60", "--no-open"]));
    assert!(out.contains("load case lc2") && out.contains("report.html in a browser"), "{out}");
    for file in ["fmb.toml", "fmb.rom", "results.npz", "results.csv", "report.html", "summary.json"] {
        assert!(demo.join(file).is_file(), "{file}");
    }
}

/// The first example of the reference, about its equilibrium: built, told, and left alone by `romrun`.
#[test]
fn a_structure_in_flight_is_built_about_its_equilibrium_and_stays_there() {
    let folder = tempfile::tempdir().unwrap();
    let reference = include_str!("../../docs/structure-file.md");
    let example = reference.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let (toml, rom) = (folder.path().join("t.toml"), folder.path().join("t.rom"));
    std::fs::write(&toml, example).unwrap();
    let out = said(romgen(&["build", text(&toml), "--modes", "4", "-o", text(&rom)]));
    for part in ["factor on `lift`: 2.25", "displacement from the drawing", "it flies by itself"] {
        assert!(out.contains(part), "{part} in\n{out}");
    }
    let info = said(romgen(&["info", text(&rom)]));
    assert!(info.contains("(0, 0, -9.81) m/s^2 in G") && info.contains("it flies by itself"), "{info}");
    let rest = folder.path().join("rest.toml");
    std::fs::write(&rest, "[load_cases.rest]\nt_end = 1\ndt = 0.01\nloads = []\n").unwrap();
    let results = folder.path().join("results");
    let summary: serde_json::Value = serde_json::from_str(&said(romrun(&[
        text(&rom),
        "--loads",
        text(&rest),
        "--out",
        text(&results),
        "--json",
    ])))
    .unwrap();
    // Round-off of some 500 N of lift and weight on 46 kg over a second.
    for (name, point) in summary["points"].as_object().unwrap() {
        assert!(point["peak"].as_f64().unwrap() < 1e-10, "{name}: {point}");
    }
    assert!(summary["centre_of_mass_travel"].as_f64().unwrap() < 1e-10, "{summary}");

    // Without the balance the tips do not carry it, and it is told what is missing.
    let start = example.find("balance = ").unwrap();
    let end = start + example[start..].find('\n').unwrap();
    let unbalanced = format!("{}{}", &example[..start], &example[end..]);
    std::fs::write(&toml, &unbalanced).unwrap();
    let err = refused(romgen(&["build", text(&toml), "-o", text(&rom)]), 3);
    assert!(err.contains("not in balance with itself") && err.contains("unbalanced = \"warn\""), "{err}");
    std::fs::write(&toml, unbalanced.replace("[equilibrium] ", "[equilibrium]\nunbalanced = \"warn\" "))
        .unwrap();
    let out = said(romgen(&["build", text(&toml), "--modes", "4", "-o", text(&rom)]));
    assert!(out.contains("NOT IN BALANCE: it moves off when let go"), "{out}");
}

/// What the file says of its reduction holds where the command says nothing else; the model file says what was taken.
#[test]
fn the_file_says_how_it_is_reduced() {
    let folder = tempfile::tempdir().unwrap();
    let (input, path) = (folder.path().join("frame.toml"), folder.path().join("m.rom"));
    let sound = std::fs::read_to_string(structure("fmb.toml")).unwrap();
    let table = "[reduction]\nmodes = [1, 3]\nresidual = [\"P\"]\ninertia = \"consistent\"\n\n[sections.";
    std::fs::write(&input, sound.replacen("[sections.", table, 1)).unwrap();
    let built = |options: &[&str]| {
        let arguments =
            [&["build", text(&input), "--set", "elements=12", "-o", text(&path), "--json"], options];
        let info: serde_json::Value = serde_json::from_str(&said(romgen(&arguments.concat()))).unwrap();
        let model = rom_runtime::Model::read_path(&path).unwrap();
        let options = model.data().provenance.options.clone();
        (info, options, model.data().modes.number.clone())
    };
    let (_, options, numbers) = built(&[]);
    assert_eq!(numbers[..2], [1, 3]);
    assert!(numbers.len() > 2, "residual modes: {numbers:?}");
    for pair in [("--modes", "1,3"), ("--residual", "P"), ("--inertia", "consistent")] {
        assert!(options.contains(&(pair.0.to_owned(), pair.1.to_owned())), "{pair:?} in {options:?}");
    }
    let (_, options, numbers) = built(&["--modes", "4", "--residual", "none", "--inertia", "constant"]);
    assert_eq!(numbers, [1, 2, 3, 4]);
    // The text in the model says otherwise: what was taken is named.
    assert!(options.contains(&("--inertia".to_owned(), "constant".to_owned())), "{options:?}");
    let told = said(romgen(&[
        "validate",
        text(&path),
        "--loads",
        "lc2",
        "--method",
        "linear,rom",
        "--t-end",
        "0.1",
        "--json",
        "-",
    ]));
    let rows: serde_json::Value = serde_json::from_str(&told).unwrap();
    assert_eq!(rows[0]["modes"], 4, "{rows}");
}
