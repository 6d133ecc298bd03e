//! The commands of docs/tutorial.md, in order, in one folder; what it says they print is what they print. Its Python is run by
//! python/tests/test_pages.py.

use std::fs;
use std::path::Path;

use assert_cmd::Command;

/// Fenced blocks of a page: language and text.
pub(super) fn blocks(page: &str) -> Vec<(String, String)> {
    let mut blocks = Vec::new();
    let mut open: Option<(String, String)> = None;
    for line in page.lines() {
        match (open.take(), line.strip_prefix("```")) {
            (None, Some(language)) => open = Some((language.to_owned(), String::new())),
            (None, None) => {}
            (Some(block), Some(_)) => blocks.push(block),
            (Some((language, text)), None) => open = Some((language, text + line + "\n")),
        }
    }
    blocks
}

/// Words of a text without those that vary: the time that something took is the last one of its line.
fn words(text: &str) -> Vec<Vec<&str>> {
    text.lines()
        .map(|line| line.split_whitespace().collect())
        .filter(|words: &Vec<&str>| !words.is_empty())
        .collect()
}

#[test]
fn the_tutorial_works_as_written() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/tutorial.md");
    let blocks = blocks(&fs::read_to_string(page).unwrap());
    let folder = tempfile::tempdir().unwrap();
    // By the command before; nothing after a program in Python.
    let mut printed = None;
    let mut commands = 0;
    for (language, text) in &blocks {
        match language.as_str() {
            "toml" => fs::write(folder.path().join("wing.toml"), text).unwrap(),
            "sh" => {
                for line in text.lines() {
                    let mut parts = line.split(' ');
                    let program = parts.next().unwrap();
                    // One argument of the page is in quotes.
                    let arguments = line[program.len()..].replace("\"right tip\"", "right_tip");
                    let arguments = arguments.split_whitespace().map(|a| a.replace("right_tip", "right tip"));
                    let output = Command::cargo_bin(program)
                        .unwrap()
                        .args(arguments)
                        .current_dir(&folder)
                        .output()
                        .unwrap();
                    assert!(output.status.success(), "{line}\n{}", String::from_utf8_lossy(&output.stderr));
                    printed = Some(String::from_utf8(output.stdout).unwrap());
                    commands += 1;
                }
            }
            "python" => printed = None,
            "text" => {
                let Some(printed) = &printed else { continue };
                let found = words(printed);
                for expected in words(text) {
                    assert!(
                        found.iter().any(|line| line.starts_with(&expected)),
                        "the page says {expected:?}, the program\n{printed}"
                    );
                }
            }
            _ => {}
        }
    }
    assert!(commands >= 5 && blocks.iter().any(|(language, _)| language == "text"));
    for file in ["wing.html", "results/report.html", "study/report.html"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
}
