//! Clamped structures, moved bases and starts from the command line.

use rom_cli::results::Results;

use super::{refused, romgen, romrun, said, structure, text};

const MAST: &str = r#"
[structure]
name = "mast"
reference = "foot"
support = "clamped"
[sections.tube]
shape = "constants"
EA = 1e6
GAy = 1e6
GAz = 1e6
GJ = 40
EIy = 10
EIz = 40
rhoA = 2
rhoJ = [2e-5, 1e-5, 1e-5]
[points]
foot = [0, 0, 0]
top = [2, 0, 0]
[[members]]
name = "mast"
path = ["foot", "top"]
section = "tube"
elements = 20
local_y = [0, 1, 0]
[load_cases.quake]
t_end = 0.2
dt = 0.002
motion = { acceleration = { z = { shape = "sine", omega = 20 } } }
"#;

#[test]
fn a_clamped_structure_is_built_told_of_and_shaken() {
    let folder = tempfile::tempdir().unwrap();
    let (structure, model) = (folder.path().join("mast.toml"), folder.path().join("mast.rom"));
    std::fs::write(&structure, MAST).unwrap();
    said(romgen(&["build", text(&structure), "-o", text(&model), "--modes", "6"]));
    let info = said(romgen(&["info", text(&model)]));
    // 61.3 % of 4 kg for the first bending mode in either plane.
    assert!(info.contains("effective mass") && info.contains("2.45"), "{info}");
    let out = folder.path().join("run");
    said(romrun(&[text(&model), "--loads", "quake", "--out", text(&out), "--no-report", "--quiet"]));
    let results = Results::read_npz(&out.join("results.npz")).unwrap();
    // Nothing estimates errors where the motion of A is given: no channel says zero.
    assert!(results.channel("t").is_some() && results.channel("error_indicator").is_none());
    let row = |name: &str, i: usize| results.channel(name).unwrap().row(i).to_vec();
    let parts = ["reaction_inertia_A", "reaction_loads_A", "reaction_increment_A"].map(|name| row(name, 50));
    for (k, total) in row("reaction_A", 50).iter().enumerate() {
        let sum: f64 = parts.iter().map(|part| part[k]).sum();
        assert!((total - sum).abs() < 1e-12, "{total} {sum}");
    }
    // Mass times acceleration of the base at 0.1 s.
    assert!((parts[0][2] + 4.0 * 2.0_f64.sin()).abs() < 1e-9, "{parts:?}");
    // v = (1 - cos 20 t)/20.
    assert!((row("v_G", 50)[2] - (1.0 - 2.0_f64.cos()) / 20.0).abs() < 1e-9);
    let err = refused(romrun(&[text(&model), "--loads", "quake", "--method", "mean-axes"]), 2);
    assert!(err.contains("clamped") && err.contains("mean-axes"), "{err}");
}

/// On the curved manifold: every integrator, held places, section forces and sweeps as for the paper's model.
#[test]
fn a_clamped_structure_bends_far_with_consistent_inertia() {
    let folder = tempfile::tempdir().unwrap();
    let (structure, model) = (folder.path().join("mast.toml"), folder.path().join("mast.rom"));
    let pull = "loads = [{ point = \"top\", frame = \"dead\", force = [0, 0, 2] }]";
    let cases = format!(
        "[internal_loads.foot]\nmember = \"mast\"\nfractions = [0]\n\
         [load_cases.held]\nt_end = 0.1\ndt = 0.002\ninitial = {{ shape_of = \"held\" }}\n{pull}\n"
    );
    std::fs::write(&structure, format!("{MAST}{cases}")).unwrap();
    let dynamics = ["--modes", "6", "--inertia", "consistent", "--elastic", "geometric"];
    said(romgen(&[&["build", text(&structure), "-o", text(&model)], &dynamics[..]].concat()));
    let out = folder.path().join("run");
    for integrator in ["newmark", "gen-alpha", "rk4"] {
        // The fastest of six modes has 0.027 s.
        let run = ["--integrator", integrator, "--out", text(&out), "--no-report", "--quiet"];
        said(romrun(&[&[text(&model), "--loads", "held"], &run[..]].concat()));
        let results = Results::read_npz(&out.join("results.npz")).unwrap();
        let row = |name: &str| results.channel(name).unwrap().row(50).to_vec();
        let (moved, told) = (row("top.dR_A"), row("reaction_A"));
        // F L^2/EI = 0.8: the elastica's 0.25 of the length, shortened by 0.038; held in balance all the time.
        assert!(
            (moved[2] / 2.0 - 0.25).abs() < 0.005 && (-moved[0] / 2.0 - 0.038).abs() < 0.003,
            "{moved:?}"
        );
        assert!((told[2] - 2.0).abs() < 1e-6 && (told[4] + 2.0 * (2.0 + moved[0])).abs() < 1e-6, "{told:?}");
        said(romrun(&[&[text(&model), "--loads", "quake"], &run[..]].concat()));
    }
    let err = refused(romrun(&[text(&model), "--loads", "held", "--integrator", "energy-momentum"]), 2);
    assert!(err.contains("clamped") && err.contains("newmark"), "{err}");
    let run = ["--sweep", "scale=0.5,1", "--out", text(&out), "--no-report", "--quiet"];
    said(romrun(&[&[text(&model), "--loads", "quake"], &run[..]].concat()));
}

#[test]
fn wrong_motions_and_starts_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mast.toml");
    let motion = "motion = { acceleration = { z = { shape = \"sine\", omega = 20 } } }";
    for (line, words) in [
        ("motion = { velocity = { z = { shape = \"step\" } } }", "velocity jumps by 1"),
        ("motion = { velocity = { z = { expression = \"vx\" } } }", "cannot depend on itself"),
        ("motion = { velocity = { z = 1 }, acceleration = { z = 1 } }", "velocity is given already"),
        ("motion = { speed = { z = 1 } }", "no key `speed`"),
        ("motion = {}\ninitial = { velocity = [1, 0, 0] }", "says what this velocity is"),
        ("initial = { shape_of = \"quak\" }", "no load case `quak`"),
        (
            "initial = { shape_loads = [{ point = \"tip\", frame = \"dead\", force = [0, 0, 1] }] }",
            "no point `tip`",
        ),
    ] {
        std::fs::write(&path, MAST.replace(motion, line)).unwrap();
        let err = refused(romgen(&["check", text(&path)]), 2);
        assert!(err.contains(words) && err.contains("mast.toml:"), "{line}: {err}");
    }
    // A mode that the reduced model does not keep.
    std::fs::write(&path, MAST.replace(motion, "initial = { amplitudes = [0, 0, 0, 1e-3] }")).unwrap();
    let model = folder.path().join("mast.rom");
    said(romgen(&["build", text(&path), "-o", text(&model), "--modes", "2"]));
    let err = refused(romrun(&[text(&model), "--loads", "quake"]), 2);
    assert!(err.contains("no elastic mode 4") && err.contains("1, 2"), "{err}");
}

/// The curved blade without its clamp: its pull is no equilibrium, which is refused; let go all the same it whips round, out of the range of
/// the paper's model, which says so, and within that of the consistent one.
#[test]
fn a_pull_that_nothing_holds_is_refused_and_let_go_leaves_the_range() {
    let folder = tempfile::tempdir().unwrap();
    let (input, model) = (folder.path().join("free.toml"), folder.path().join("free.rom"));
    let clamped = std::fs::read_to_string(structure("curved_blade.toml")).unwrap();
    let free = clamped.replace("support = \"clamped\"\n", "");
    std::fs::write(&input, &free).unwrap();
    let words = refused(romgen(&["build", text(&input), "-o", text(&model)]), 3);
    assert!(
        words.contains("not in balance with itself: 150.0000 N") && words.contains("unbalanced"),
        "{words}"
    );
    std::fs::write(&input, free.replace("[equilibrium]", "[equilibrium]\nunbalanced = \"warn\"")).unwrap();
    let told = said(romgen(&["build", text(&input), "-o", text(&model)]));
    assert!(told.contains("NOT IN BALANCE: it moves off when let go"), "{told}");
    let out = folder.path().join("out");
    let run = ["--loads", "flick", "--t-end", "0.02", "--dt", "2e-4", "--no-report", "--out", text(&out)];
    let ended = romrun(&[&[text(&model)][..], &run].concat());
    let told = String::from_utf8(ended.stdout.clone()).unwrap();
    assert!(told.contains("the model is out of its range"), "{told}");
    let words = refused(ended, 3);
    assert!(words.contains("did not converge") && words.contains("--inertia consistent"), "{words}");
    let consistent = ["--inertia", "consistent", "--elastic", "geometric"];
    said(romgen(&[&["build", text(&input), "-o", text(&model)], &consistent[..]].concat()));
    said(romrun(&[&[text(&model)][..], &run].concat()));
}
