//! `romgen linearise`.

use super::{frame, refused, romgen, said, structure, text};

#[test]
fn matrices_with_names_and_a_table_of_poles() {
    let folder = tempfile::tempdir().unwrap();
    let (npz, mat) = (folder.path().join("fmb.npz"), folder.path().join("fmb.mat"));
    let told = said(romgen(&["linearise", text(frame()), "-o", text(&npz), "-o", text(&mat)]));
    assert!(told.contains("12 x") && told.contains("6.91937"), "{told}");
    let mut archive = npyz::npz::NpzArchive::open(&npz).unwrap();
    let mut shape = |name: &str| archive.by_name(name).unwrap().unwrap().shape().to_vec();
    assert_eq!((shape("A"), shape("poles")), (vec![32, 32], vec![32, 2]));
    let inputs: Vec<String> = archive.by_name("inputs").unwrap().unwrap().into_vec().unwrap();
    assert!(inputs.contains(&"P.F.z".to_owned()) && inputs.contains(&"A.M.y".to_owned()), "{inputs:?}");
    let bytes = std::fs::read(&mat).unwrap();
    assert!(bytes.starts_with(b"MATLAB 5.0 MAT-file") && bytes.len() % 8 == 0);
    // To look at.
    let (svg, page) = (folder.path().join("poles.svg"), folder.path().join("fmb.html"));
    said(romgen(&["linearise", text(frame()), "-o", text(&svg), "-o", text(&page), "--quiet"]));
    let [drawn, page] = [svg, page].map(|path| std::fs::read_to_string(path).unwrap());
    // A mark for each of 20 poles of the modes, and for the twelve at the origin.
    assert!(drawn.starts_with("<svg") && drawn.matches("<circle").count() >= 32, "{drawn}");
    for part in ["Steady state", "6.91937", "P.F.z", "at the origin: rigid-body motion", "romgen linearise"] {
        assert!(page.contains(part), "{part}");
    }
    // The same twice.
    let again = folder.path().join("again.npz");
    said(romgen(&[
        "linearise",
        text(frame()),
        "-o",
        text(&again),
        "--quiet",
        "--inputs",
        "P",
        "--outputs",
        "A",
    ]));
    let mut archive = npyz::npz::NpzArchive::open(&again).unwrap();
    assert_eq!(archive.by_name("D").unwrap().unwrap().shape(), [12, 6]);
}

#[test]
fn a_steady_rotation_and_what_is_none() {
    let model = text(frame());
    let told = said(romgen(&["linearise", model, "--rate", "0,0.5,0", "--reduce", "--json"]));
    let found: serde_json::Value = serde_json::from_str(&told).unwrap();
    assert_eq!(found["states"].as_array().unwrap().len(), 26);
    let velocity = &found["steady"]["velocity"];
    assert!((velocity[4].as_f64().unwrap() - 0.5).abs() < 1e-12, "{velocity}");
    // The centre of mass, 5/6 m along z, stays where it is: v = -w x r, to the stretch of the frame.
    assert!((velocity[0].as_f64().unwrap() + 0.5 * 5.0 / 6.0).abs() < 0.02, "{velocity}");
    let words = refused(romgen(&["linearise", model, "--loads", "lc2", "--time", "2"]), 3);
    assert!(words.contains("frame A accelerates by") && words.contains("--hold"), "{words}");
    let words = refused(romgen(&["linearise", model, "--inputs", "nowhere"]), 2);
    assert!(words.contains("no input \"nowhere\"; it has: A, modes"), "{words}");
    let words = refused(romgen(&["linearise", model, "-o", "fmb.txt"]), 2);
    assert!(words.contains(".npz, .mat, .svg or .html"), "{words}");
    let words = refused(romgen(&["linearise", model, "--rate", "0,nan,0"]), 2);
    assert!(words.contains("three finite numbers"), "{words}");
    let gust = structure("gust.toml");
    let words = refused(romgen(&["linearise", model, "--loads", &format!("{}:none", text(&gust))]), 2);
    assert!(words.contains("no load case \"none\""), "{words}");
}
