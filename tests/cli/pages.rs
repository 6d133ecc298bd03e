//! Commands of the pages that have no test of their own, in order, in a folder with the models they speak of.

use std::fs;
use std::path::Path;

use assert_cmd::Command;

use super::tutorial::blocks;
use super::{frame, romgen, said, structure, text};

/// Commands in blocks of shell and those that stand in tables, in their order.
fn commands(page: &str) -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(page);
    let page = fs::read_to_string(path).unwrap();
    let shell = blocks(&page).into_iter().filter(|(language, _)| language == "sh");
    let mut commands: Vec<String> =
        shell.flat_map(|(_, text)| text.lines().map(str::to_owned).collect::<Vec<_>>()).collect();
    for line in page.lines().filter(|line| line.starts_with('|')) {
        let quoted = line.split('`').skip(1).step_by(2);
        commands.extend(quoted.filter(|words| words.starts_with("romgen ")).map(str::to_owned));
    }
    commands
}

#[test]
fn the_commands_of_the_pages_work_as_written() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(frame(), folder.path().join("fmb.rom")).unwrap();
    let hale = folder.path().join("hale.rom");
    let coarse = ["--set", "wing_elements=6", "--modes", "4", "-o", text(&hale)];
    said(romgen(&[&["build", text(&structure("hale.toml"))], &coarse[..]].concat()));
    let blade = folder.path().join("blade.rom");
    said(romgen(&["build", text(&structure("curved_blade.toml")), "--modes", "3", "-o", text(&blade)]));
    // Libraries made on other platforms: what is in them is for those to read.
    for library in ["rom_fmu.dll", "librom_fmu.dylib"] {
        fs::write(folder.path().join(library), library).unwrap();
    }
    for (page, least) in [("linearise.md", 8), ("fmu.md", 2)] {
        let commands = commands(page);
        assert!(commands.len() >= least, "{page}: {commands:?}");
        for command in &commands {
            let mut words = command.split_whitespace();
            let mut program = Command::cargo_bin(words.next().unwrap()).unwrap();
            let output = program.args(words).current_dir(&folder).output().unwrap();
            assert!(output.status.success(), "{command}\n{}", String::from_utf8_lossy(&output.stderr));
        }
    }
    for file in ["fmb.npz", "fmb.mat", "poles.svg", "fmb.html", "hale.fmu", "fmb.fmu"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
}
