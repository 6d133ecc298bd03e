//! Whatever the text, the answer is a structure or a list of errors, never a panic.

use proptest::prelude::*;
use rom_generator::input::{InputErrors, Structure};

fn read(text: &str) -> Result<Structure, InputErrors> {
    Structure::from_toml_str(text, "frame.toml", &[])
}

#[test]
fn text_that_is_no_structure() {
    for (text, message) in [
        ("", "empty"),
        (" \n\t\n", "empty"),
        ("# nothing\n", "`structure` is missing"),
        ("[structure\nname = 1", "not valid TOML"),
        ("\u{0}\u{1}\u{7f}", "not valid TOML"),
        ("a = 1\na = 2", "duplicate key"),
        ("[points]\n[points]", "duplicate key"),
        ("structure = 5", "found the number 5, expected a table"),
        ("parameters = 5", "`parameters` is no table"),
    ] {
        let errors = read(text).unwrap_err();
        assert!(errors.iter().any(|d| d.message().contains(message)), "{text:?}: {errors}");
    }
    for deep in [
        "[".repeat(100_000),
        format!("a = {}", "[".repeat(100_000)),
        format!("a = {}1", "{b=".repeat(50_000)),
    ] {
        assert!(read(&deep).is_err());
    }
    let deep = format!("[parameters]\na = \"{}1{}\"", "(".repeat(900), ")".repeat(900));
    assert!(read(&deep).is_err());
    assert!(read(&"a".repeat(17 << 20)).unwrap_err().to_string().contains("16 MiB"));
    let circle: String = (0..1000).map(|i| format!("p{i} = \"p{}\"\n", (i + 1) % 1000)).collect();
    assert!(read(&format!("[parameters]\n{circle}")).unwrap_err().to_string().contains("in a circle"));
    let many: String = (0..2000).map(|i| format!("p{i} = 1\n")).collect();
    assert!(read(&format!("[parameters]\n{many}")).unwrap_err().to_string().contains("at most 1000"));
}

#[test]
fn files_that_cannot_be_read() {
    let read = |path: &std::path::Path| Structure::from_toml_path(path, &[]).unwrap_err().to_string();
    assert!(read("/no/such/file.toml".as_ref()).contains("cannot be read"));
    assert!(read(env!("CARGO_MANIFEST_DIR").as_ref()).contains("cannot be read"));
    let path = std::env::temp_dir().join(format!("romgen-garbage-{}.toml", std::process::id()));
    std::fs::write(&path, b"[structure]\nname = \"\xff\xfe\"").unwrap();
    let message = read(&path);
    std::fs::remove_file(&path).unwrap();
    assert!(message.contains("not UTF-8 text: byte 20"), "{message}");
}

/// The published model with bytes changed, lines dropped, doubled or swapped, numbers replaced.
fn mutated() -> impl Strategy<Value = String> {
    let source = include_str!("../../models/fmb.toml");
    let edit = (
        0..6_u8,
        0..source.len(),
        0..source.len(),
        prop::sample::select(vec![
            "0",
            "-1",
            "1e308",
            "nan",
            "\"",
            "[",
            "]",
            "{",
            "}",
            "=",
            ",",
            "\"1/0\"",
            "'t'",
            "\n",
            "\u{0}",
            "é",
            "A",
            "[[members]]",
            "1_000_000",
            "\"elements\"",
            "true",
            "linked_to",
            "[0, 0, 0]",
            ".",
            "#",
        ]),
    );
    prop::collection::vec(edit, 1..6).prop_map(move |edits| {
        let mut text = source.to_owned();
        for (kind, a, b, new) in edits {
            let mut lines: Vec<&str> = text.lines().collect();
            let (i, j) = (a % lines.len().max(1), b % lines.len().max(1));
            text = match kind {
                0 if !lines.is_empty() => {
                    lines.remove(i);
                    lines.join("\n")
                }
                1 if !lines.is_empty() => {
                    lines.swap(i, j);
                    lines.join("\n")
                }
                2 if !lines.is_empty() => {
                    lines.insert(i, lines[j]);
                    lines.join("\n")
                }
                _ => {
                    let words: Vec<(usize, &str)> =
                        text.match_indices(|c: char| !c.is_whitespace()).collect();
                    let Some(&(at, word)) = words.get(a % words.len().max(1)) else { continue };
                    let keep = if kind == 3 { at } else { at + word.len() };
                    format!("{}{new}{}", &text[..at], &text[keep..])
                }
            };
        }
        text
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn no_text_makes_it_panic(text in mutated()) {
        match read(&text) {
            // Large meshes only cost time here.
            Ok(structure) if structure.element_count() < 100_000 => {
                let mesh = structure.mesh();
                prop_assert!(mesh.nodes.iter().all(|x| x.iter().all(|c| c.is_finite())));
                prop_assert!(mesh.elements.iter().all(|e| e.length > 0.0 && e.frames[0].iter().all(|c| c.is_finite())));
            }
            Ok(_) => {}
            Err(errors) => {
                prop_assert!(errors.iter().count() > 0);
                for d in &errors {
                    prop_assert!(text.get(d.span()).is_some());
                }
            }
        }
    }

    #[test]
    fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = read(&String::from_utf8_lossy(&bytes));
    }
}
