//! `romgen modes`.

use super::{refused, romgen, said, structure, text};

#[test]
fn table_arrays_pictures_and_page() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("modes");
    let told = said(romgen(&["modes", text(&structure("hale.toml")), "--modes", "4", "--out", text(&out)]));
    assert!(told.contains("about the loaded equilibrium") && told.contains("antisymmetric xz"), "{told}");
    for file in ["report.html", "modes.json", "modes.npz", "mode-01.svg", "mode-04.svg"] {
        assert!(out.join(file).is_file(), "{file}");
    }
    let rows: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("modes.json")).unwrap()).unwrap();
    assert!((rows[0]["omega"].as_f64().unwrap() - 2.342).abs() < 2e-3, "{rows}");
    assert_eq!(rows[1]["symmetry"], "antisymmetric xz");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert_eq!(page.matches("<figure class=\"picture\">").count(), 4);
    // About the drawing the flapping wing is another one.
    let drawn = said(romgen(&[
        "modes",
        text(&structure("hale.toml")),
        "--about",
        "drawing",
        "--json",
        "--modes",
        "1",
    ]));
    let drawn: serde_json::Value = serde_json::from_str(&drawn).unwrap();
    assert!(
        (drawn[0]["omega"].as_f64().unwrap() - rows[0]["omega"].as_f64().unwrap()).abs() > 0.02,
        "{drawn}"
    );
}

#[test]
fn frequencies_against_the_load_factor() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("sweep");
    let hale = structure("hale.toml");
    let sweep = ["modes", text(&hale), "--modes", "3", "--sweep", "load-factor=0..1:3", "--out", text(&out)];
    let told = said(romgen(&sweep));
    assert!(told.contains("load factor") && told.contains("0.5"), "{told}");
    let csv = std::fs::read_to_string(out.join("frequencies.csv")).unwrap();
    assert_eq!(csv.lines().count(), 4, "{csv}");
    for file in ["report.html", "frequencies.json", "frequencies.svg"] {
        assert!(out.join(file).is_file(), "{file}");
    }
    let words = refused(romgen(&["modes", text(&hale), "--sweep", "spin=0..3"]), 3);
    assert!(words.contains("balance"), "{words}");
    let words = refused(romgen(&["modes", text(&hale), "--sweep", "sigma=1,2"]), 2);
    assert!(words.contains("load-factor, spin or one of: level"), "{words}");
}

/// A clamped beam on a turning hub, about an axis across it: the Southwell coefficients make every flapping frequency rise.
#[test]
fn frequencies_against_the_spin() {
    let told = said(romgen(&[
        "modes",
        text(&structure("ffb.toml")),
        "--sweep",
        "spin=0..2",
        "--axis",
        "y",
        "--modes",
        "2",
        "--json",
    ]));
    let found: serde_json::Value = serde_json::from_str(&told).unwrap();
    let omega = |level: usize| found["omega"][level][0].as_f64().unwrap();
    assert!(
        found["levels"].as_array().unwrap().len() == 3 && omega(0) > 0.0 && omega(2) != omega(0),
        "{found}"
    );
    let words = refused(romgen(&["modes", text(&structure("ffb.toml")), "--axis", "0,0,0"]), 2);
    assert!(words.contains("three components"), "{words}");
}
