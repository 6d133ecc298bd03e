//! `romgen export --fmu`. What the FMUs do in a host is proven in `fmu/tests`.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use zip::ZipArchive;

use super::{frame, refused, romgen, said, text};

fn entries(path: &Path) -> Vec<(String, Vec<u8>)> {
    let mut archive = ZipArchive::new(File::open(path).unwrap()).unwrap();
    let count = archive.len();
    let read = |index| {
        let mut entry = archive.by_index(index).unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        (entry.name().to_owned(), bytes)
    };
    (0..count).map(read).collect()
}

#[test]
fn both_versions_with_model_description_and_library() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fmb.fmu");
    let words = said(romgen(&["export", text(frame()), "--fmu", text(&path)]));
    assert!(words.contains("fmb.fmu (FMI 3.0)") && words.contains("fmb-fmi2.fmu (FMI 2.0)"), "{words}");
    let second = folder.path().join("fmb-fmi2.fmu");
    for (path, version, platform) in [(&path, "3.0", "x86_64-linux"), (&second, "2.0", "linux64")] {
        let entries = entries(path);
        let names: Vec<&str> = entries.iter().map(|(name, _)| name.as_str()).collect();
        let library = format!("binaries/{platform}/FMB.so");
        if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
            assert_eq!(names, ["modelDescription.xml", library.as_str(), "resources/model.rom"]);
            // A shared library with the functions of the standard, not the placeholder of `cargo check`.
            let bytes = &entries[1].1;
            assert!(bytes.starts_with(b"\x7fELF"));
            for symbol in ["fmi2DoStep", "fmi3DoStep", "fmi2SerializeFMUstate", "fmi3GetFloat64"] {
                assert!(bytes.windows(symbol.len()).any(|part| part == symbol.as_bytes()), "{symbol}");
            }
        }
        assert_eq!(entries.last().unwrap().1, fs::read(frame()).unwrap());
        let description = String::from_utf8(entries[0].1.clone()).unwrap();
        assert!(description.contains(&format!("fmiVersion=\"{version}\"")));
        let references: Vec<&str> = description
            .lines()
            .filter(|line| line.contains("causality="))
            .map(|line| line.split("valueReference=\"").nth(1).unwrap().split('"').next().unwrap())
            .collect();
        assert!(references.len() > 200);
        assert_eq!(references.iter().collect::<BTreeSet<_>>().len(), references.len(), "each once");
    }
}

#[test]
fn the_same_model_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for name in ["a.fmu", "b.fmu"] {
        said(romgen(&["export", text(frame()), "--fmu", text(&path(name)), "--fmi", "2"]));
    }
    assert_eq!(fs::read(path("a.fmu")).unwrap(), fs::read(path("b.fmu")).unwrap());
    assert!(!path("a-fmi2.fmu").exists(), "one version only");
}

#[test]
fn libraries_for_other_platforms_are_put_beside_the_own_one() {
    let folder = tempfile::tempdir().unwrap();
    let (path, library) = (folder.path().join("fmb.fmu"), folder.path().join("rom_fmu.dll"));
    fs::write(&library, b"MZ").unwrap();
    let given = |platform: &str| format!("{platform}={}", library.display());
    let export = |given: &str, version: &str| {
        let path = text(&path);
        romgen(&["export", text(frame()), "--fmu", path, "--fmi", version, "--fmu-library", given])
    };
    said(export(&given("x86_64-windows"), "3"));
    let windows = entries(&path).into_iter().find(|(name, _)| name == "binaries/x86_64-windows/FMB.dll");
    assert_eq!(windows.unwrap().1, b"MZ");
    said(export(&given("x86_64-windows"), "2"));
    assert!(entries(&path).iter().any(|(name, _)| name == "binaries/win64/FMB.dll"));

    let before = fs::read(&path).unwrap();
    assert!(refused(export(&given("aarch64-linux"), "2"), 2).contains("--fmi 3"));
    assert!(refused(export(&given("amiga"), "3"), 2).contains("aarch64-darwin"));
    assert!(refused(export("x86_64-windows=nowhere.dll", "3"), 2).contains("nowhere.dll"));
    assert_eq!(fs::read(&path).unwrap(), before, "a refusal leaves the earlier file");
}

#[test]
fn an_export_of_nothing_is_refused() {
    assert!(refused(romgen(&["export", text(frame())]), 2).contains("--fmu"));
    let none = ["export", text(frame()), "--fmu", "x.fmu", "--stations", "all"];
    assert!(refused(romgen(&none), 2).contains("no block of stations"));
    let fmi = ["export", text(frame()), "--fmu", "x.fmu", "--fmi", "1"];
    assert!(refused(romgen(&fmi), 2).contains("expected 2 or 3"));
}
