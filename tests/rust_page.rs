//! The programs of docs/rust.md, which stand in `tests/rust_page` too: they are those of the page, and they run.

use std::path::Path;

use assert_cmd::Command;

mod aircraft {
    include!("rust_page/aircraft.rs");

    pub(super) fn run() {
        main().unwrap();
    }
}

mod many {
    include!("rust_page/many.rs");

    pub(super) fn run() {
        main().unwrap();
    }
}

/// The Rust programs of a page, lines that it hides included.
fn programs(page: &str) -> Vec<String> {
    let blocks = page.split("```rust,no_run\n").skip(1).filter_map(|rest| rest.split("```").next());
    let shown = |line: &str| line.strip_prefix("# ").unwrap_or(line).to_owned() + "\n";
    blocks.map(|block| block.lines().map(shown).collect()).collect()
}

fn words(text: &str) -> Vec<&str> {
    text.split_whitespace().collect()
}

/// One test, for it goes to another folder.
#[test]
fn the_programs_are_those_of_the_page_and_run() {
    let found = programs(include_str!("../docs/rust.md"));
    let files = [include_str!("rust_page/aircraft.rs"), include_str!("rust_page/many.rs")];
    assert_eq!(found.len(), files.len());
    // Word by word: the formatter breaks and moves lines of files.
    for (program, file) in found.iter().zip(files) {
        let (program, file) = (words(program), words(file));
        assert!(file.ends_with(&program), "the page has\n{program:?}\nthe file\n{file:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    let hale = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/hale.toml");
    let mut build = Command::cargo_bin("romgen").unwrap();
    build.arg("build").arg(hale).args(["--set", "wing_elements=6", "--modes", "4", "-o", "hale.rom"]);
    build.current_dir(&folder).assert().success();
    std::env::set_current_dir(&folder).unwrap();
    aircraft::run();
    many::run();
}
