use super::*;

fn wave(n: usize) -> (Vec<f64>, Vec<f64>) {
    let t: Vec<f64> = (0..n).map(|i| i as f64 * 0.01).collect();
    let y = t.iter().map(|t| t.sin()).collect();
    (t, y)
}

fn page(name: &str, points: usize) -> String {
    let (x, y) = wave(points);
    let plot = |title: &str, curves| Block::Plot(Plot { title: title.to_owned(), curves, ..Plot::default() });
    Document {
        title: name.to_owned(),
        subtitle: name.to_owned(),
        highlights: vec![Highlight { label: name.to_owned(), value: name.to_owned(), note: name.to_owned() }],
        sections: vec![Section {
            title: name.to_owned(),
            blocks: vec![
                plot(name, Curves::Over { x: x.clone(), series: vec![(name.to_owned(), y.clone())] }),
                plot(name, Curves::Paths(vec![(name.to_owned(), x, y)])),
                Block::Text(name.to_owned()),
                Block::Note(name.to_owned()),
                Block::Warning(name.to_owned()),
                Block::Verbatim(name.to_owned()),
                Block::Facts(vec![(name.to_owned(), name.to_owned())]),
                Block::Table(Table {
                    caption: name.to_owned(),
                    columns: vec![name.to_owned()],
                    rows: vec![vec![name.to_owned()]],
                }),
            ],
        }],
        footer: name.to_owned(),
    }
    .to_html()
}

/// Names come from files of strangers: none may end an element or start one.
#[test]
fn no_name_can_break_out_of_its_place() {
    let plain = page("name", 10);
    let hostile = page("</script><script>alert(1)</script>\"'&<!--", 10);
    for mark in ["<script", "</script", "<!--", "<figure", "<p", "<div", "<dd"] {
        assert_eq!(plain.matches(mark).count(), hostile.matches(mark).count(), "{mark}");
    }
    assert!(!hostile.contains("alert(1)</"));
}

#[test]
fn the_page_refers_to_nothing_outside_itself() {
    let html = page("name", 10);
    for reference in ["src=", "href=", "url(", "@import", "fetch(", "XMLHttpRequest"] {
        assert!(!html.contains(reference), "{reference}");
    }
}

#[test]
fn long_series_are_thinned_out_and_the_page_says_so() {
    assert!(!page("name", 4_000).contains("points drawn"));
    let long = page("name", 400_000);
    assert!(long.contains("of 400000 points drawn"));
    assert!(long.len() < 250_000, "{}", long.len());
}

#[test]
fn images_have_a_mark_for_every_value_and_a_gap_for_none() {
    let series = vec![("a".to_owned(), vec![1.0, f64::NAN, 3.0]), ("b & c".to_owned(), vec![2.0, 2.5, 2.0])];
    let plot = Plot {
        title: "t".to_owned(),
        curves: Curves::Over { x: vec![0.0, 1.0, 2.0], series },
        look: Look { markers: true, ..Look::default() },
        ..Plot::default()
    };
    let svg = plot.to_svg().unwrap();
    assert_eq!(svg.matches("<circle").count(), 5);
    assert!(svg.contains("b &amp; c") && !svg.contains("NaN"), "{svg}");
}
