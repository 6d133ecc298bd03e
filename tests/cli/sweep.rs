//! `romrun --sweep` and `--cases`.

use std::fs;

use rom_cli::sweep::{Variable, change_start};
use rom_runtime::{Method, Model, State};

use super::{frame, refused, romgen, romrun, said, structure, text};

/// Column of a table by name, in the order of the lines.
fn column(csv: &str, name: &str) -> Vec<f64> {
    let mut lines = csv.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at =
        head.iter().position(|column| *column == name).unwrap_or_else(|| panic!("no {name} in {head:?}"));
    lines.map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

#[test]
fn a_case_of_a_sweep_is_the_run_alone_and_a_stopped_sweep_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("sweep");
    let arguments = [
        text(frame()),
        "--loads",
        "lc1,lc2",
        "--sweep",
        "scale=0.8..1.2:11",
        "--sweep",
        "w_A.z=0,0.1",
        "--t-end",
        "1",
        "--points",
        "P",
        "--out",
        text(&out),
    ];
    let printed = said(romrun(&arguments));
    assert!(printed.contains("44 cases") && printed.contains("|P.dR_A|"), "{printed}");
    let whole = fs::read_to_string(out.join("cases.csv")).unwrap();
    assert_eq!(column(&whole, "case"), (0..44).map(f64::from).collect::<Vec<_>>());
    assert!(column(&whole, "completed").iter().all(|x| *x == 1.0));
    let at = |name: &str| column(&whole, name);
    let (scale, w, case) = (at("scale"), at("w_A.z"), at("load_case"));
    let one = (0..44).find(|&i| scale[i] == 1.0 && w[i] == 0.0 && case[i] == 1.0).unwrap();
    let alone = folder.path().join("alone");
    let json = said(romrun(&[
        text(frame()),
        "--loads",
        "lc2",
        "--t-end",
        "1",
        "--points",
        "P",
        "--no-report",
        "--json",
        "--out",
        text(&alone),
    ]));
    let alone: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(alone["points"]["P"]["peak"].as_f64(), Some(at("P.dR_A.peak")[one]));
    assert_eq!(alone["points"]["P"]["extreme_dr_a"][1].as_f64(), Some(at("P.dR_A.y")[one]));

    // Stopped in the middle of a line, with lines in the order in which cases finished.
    let lines: Vec<&str> = whole.lines().collect();
    let stopped = format!("{}\n{}\n{}\n{}", lines[0], lines[20], lines[3], &lines[7][..30]);
    fs::write(out.join("cases.csv"), stopped).unwrap();
    let archive = fs::read(out.join("cases.npz")).unwrap();
    let printed = said(romrun(&arguments));
    assert!(printed.contains("2 of them from an earlier run"), "{printed}");
    assert_eq!(fs::read_to_string(out.join("cases.csv")).unwrap(), whole);
    assert_eq!(fs::read(out.join("cases.npz")).unwrap(), archive);

    // Another sweep does not touch it.
    let other = [&arguments[..4], &["scale=2", "--out", text(&out)]].concat();
    let message = refused(romrun(&other), 2);
    assert!(message.contains("holds another sweep"), "{message}");
    assert_eq!(fs::read_to_string(out.join("cases.csv")).unwrap(), whole);
}

/// `scale` is of all loads of the case, those along members too, and of none of the equilibrium: without its gust an aircraft flies on.
#[test]
fn loads_along_members_are_scaled_and_those_of_the_equilibrium_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let (model, out) = (folder.path().join("hale.rom"), folder.path().join("out"));
    said(romgen(&["build", text(&structure("hale.toml")), "--modes", "4", "--quiet", "-o", text(&model)]));
    let sweep = ["--sweep", "scale=0,0.5,1", "--t-end", "0.5", "--points", "right tip", "--quiet"];
    said(romrun(&[&[text(&model), "--loads", "gust"], &sweep[..], &["--out", text(&out)]].concat()));
    let peak = column(&fs::read_to_string(out.join("cases.csv")).unwrap(), "right tip.dR_A.peak");
    // Round-off of an equilibrium of some 800 N; a gust small enough to be nearly linear.
    assert!(peak[0] < 1e-9, "{peak:?}");
    assert!(peak[2] > 1e-2 && (peak[1] / peak[2] - 0.5).abs() < 0.05, "{peak:?}");
}

#[test]
fn cases_of_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let (table, out) = (folder.path().join("cases.csv"), folder.path().join("out"));
    fs::write(&table, "scale.P, q.2\n0, 0.01\n1, 0\n").unwrap();
    let run = |table| {
        romrun(&[
            text(frame()),
            "--loads",
            "lc2",
            "--cases",
            text(table),
            "--t-end",
            "0.5",
            "--integrator",
            "rk4",
            "--quiet",
            "--out",
            text(&out),
        ])
    };
    assert_eq!(said(run(&table)), "");
    let csv = fs::read_to_string(out.join("cases.csv")).unwrap();
    assert_eq!(column(&csv, "q.2"), [0.01, 0.0]);
    assert!(column(&csv, "P.dR_A.peak").iter().all(|x| *x > 0.0));
    let wrong = folder.path().join("wrong.csv");
    fs::write(&wrong, "scale\nx\n").unwrap();
    let message = refused(run(&wrong), 2);
    assert!(message.contains("line 2: expected a finite number"), "{message}");
}

/// Whatever axes the equations are written in, what is asked of A comes out.
#[test]
fn initial_conditions_are_those_of_frame_a() {
    let source = Model::read_path(frame()).unwrap();
    for method in Method::ALL {
        let model = source.with_method(method).unwrap();
        let mut names = vec!["v_A.x", "w_A.y", "w_A.z", "r_G.z"];
        let mut values = vec![3.0, 0.2, -0.1, 7.0];
        if method != Method::Rigid {
            names.extend(["q.1", "q_dot.3"]);
            values.extend([0.5, -0.25]);
        }
        let variables: Vec<(Variable, f64)> =
            names.iter().map(|name| Variable::parse(name, &model).unwrap()).zip(values).collect();
        let mut state = State::at_rest(&model);
        change_start(&model, &variables, &mut state);
        let rigid = model.rigid_output(&state);
        for (found, expected) in
            [(rigid.v_a[0], 3.0), (rigid.w_a[1], 0.2), (rigid.w_a[2], -0.1), (rigid.r_g[2], 7.0)]
        {
            assert!((found - expected).abs() < 1e-12, "{method}: {found}, {expected}");
        }
        if method != Method::Rigid {
            assert_eq!((state.q[0], state.q_dot[2]), (0.5, -0.25));
        }
    }
}

#[test]
fn what_cannot_be_swept_is_refused() {
    for (sweep, word) in [
        ("sigma=1,2", "sigma is no parameter"),
        ("scale.nowhere=1", "no point nowhere"),
        ("q.77=1", "no elastic mode 77"),
        ("v_A.t=1", "expected v_A.x"),
        ("speed.x=1", "nothing that can be swept"),
        ("scale=1,,2", "expected name="),
    ] {
        let message = refused(romrun(&[text(frame()), "--loads", "lc2", "--sweep", sweep]), 2);
        assert!(message.contains(word), "{sweep}: {message}");
    }
}
