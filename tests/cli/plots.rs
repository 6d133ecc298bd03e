//! The plots of reports as SVG files.

use rom_cli::report::{Block, Curves, Document, Look, Plot, Section};

fn written(plots: Vec<Plot>) -> Vec<(String, String)> {
    let folder = tempfile::tempdir().unwrap();
    let blocks = plots.into_iter().map(Block::Plot).collect();
    let document =
        Document { sections: vec![Section { title: String::new(), blocks }], ..Document::default() };
    document.write_svg(folder.path()).unwrap();
    let mut files: Vec<(String, String)> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            (path.file_name().unwrap().to_str().unwrap().to_owned(), std::fs::read_to_string(path).unwrap())
        })
        .collect();
    files.sort();
    files
}

fn over(title: &str, y: Vec<f64>, look: Look) -> Plot {
    let x = (0..y.len()).map(|i| i as f64).collect();
    let curves = Curves::Over { x, series: vec![("a & b".to_owned(), y.clone()), ("c".to_owned(), y)] };
    Plot { title: title.to_owned(), curves, look, ..Plot::default() }
}

#[test]
fn one_file_for_each_plot_named_by_number_and_title() {
    let path = Curves::Paths(vec![("<P>".to_owned(), vec![0.0, 3.0], vec![0.0, 1.0])]);
    let files = written(vec![
        over("Velocity of A, components in G", vec![0.0, 1.0, -1.0], Look::default()),
        Plot { title: "../<top>".to_owned(), curves: path, ..Plot::default() },
    ]);
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["01-velocity-of-a-components-in-g.svg", "02-top.svg"]);
    for (_, text) in &files {
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
        assert!(!text.contains("<top>") && !text.contains("a & b"), "names are escaped");
        assert!(text.contains("<polyline"));
    }
}

/// Gaps, nothing at all, a constant, values that a logarithmic axis cannot show: all make a picture.
#[test]
fn whatever_the_values() {
    let log = Look { log_y: true, markers: true, ..Look::default() };
    let cases = [
        (vec![1.0, f64::NAN, 2.0, 3.0], Look::default()),
        (vec![f64::NAN; 3], Look::default()),
        (vec![5.0; 3], Look::default()),
        (vec![0.0; 3], Look::default()),
        (vec![-1.0, 0.0, 1e-3, 1e3], log),
        (vec![-1.0; 3], log),
        (vec![1e-300, 1e300], Look { stages: true, ..Look::default() }),
        (Vec::new(), Look::default()),
    ];
    for (i, (y, look)) in cases.into_iter().enumerate() {
        let files = written(vec![over("x", y, look)]);
        assert!(files[0].1.contains("</svg>") && !files[0].1.contains("NaN"), "case {i}");
    }
}
