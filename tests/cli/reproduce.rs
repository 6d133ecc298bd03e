//! `romgen reproduce`. The whole of it runs in `.ci/run` as a command of the README, its statements as a literature test.

use super::{refused, romgen, said, text};

#[test]
fn a_folder_that_cannot_be_made_is_known_before_the_runs() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let err = refused(romgen(&["reproduce", "--quick", "--out", text(&file.join("below"))]), 1);
    assert!(err.contains("cannot make the folder"), "{err}");
}

#[test]
fn help_says_what_is_written() {
    let help = said(romgen(&["reproduce", "--help"]));
    assert!(help.contains("report.html") && help.contains("--quick"), "{help}");
}
