//! Curves of a few points as an SVG image, for papers.

use std::fmt::Write;

use crate::text::significant;

const SIZE: [f64; 2] = [720.0, 440.0];
/// Left, top, right, bottom.
const EDGE: [f64; 4] = [64.0, 20.0, 96.0, 48.0];
const COLOURS: [&str; 10] = [
    "#1763b5", "#d4570c", "#1a8a4c", "#8a45c4", "#b8326f", "#7d6b00", "#0d8390", "#8b4a2b", "#55606e",
    "#3d3fb8",
];

/// Curves over a common variable, with a mark at every point; gaps where a value is not a number. Axes begin at zero where that
/// is near.
pub(super) fn chart(x_label: &str, y_label: &str, x: &[f64], series: &[(String, Vec<f64>)]) -> String {
    let (x_ticks, y_ticks) = (ticks(x.iter()), ticks(series.iter().flat_map(|(_, y)| y)));
    let [left, top, right, bottom] = EDGE;
    let across = |v: f64| left + (SIZE[0] - left - right) * part(&x_ticks, v);
    let along = |v: f64| SIZE[1] - bottom - (SIZE[1] - top - bottom) * part(&y_ticks, v);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"12\" fill=\"#1b2430\">\n",
        SIZE[0], SIZE[1]
    );
    for &tick in &x_ticks {
        let (x, y, label) = (across(tick), SIZE[1] - bottom, significant(tick, 6));
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1},{top}V{y}\" stroke=\"#e6e9ee\"/><text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
            y + 16.0
        );
    }
    for &tick in &y_ticks {
        let (y, label) = (along(tick), significant(tick, 6));
        let _ = writeln!(
            svg,
            "<path d=\"M{left},{y:.1}H{}\" stroke=\"#e6e9ee\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            SIZE[0] - right,
            left - 6.0,
            y + 4.0
        );
    }
    let mut free = f64::INFINITY;
    // Names stand at the ends of their curves, from the highest down, none over another.
    let mut names: Vec<(f64, usize)> = Vec::new();
    for (k, (_, y)) in series.iter().enumerate() {
        let colour = COLOURS[k % COLOURS.len()];
        let mut path = String::new();
        let mut pen = 'M';
        for (x, y) in x.iter().zip(y) {
            if y.is_finite() {
                let _ = write!(path, "{pen}{:.1},{:.1}", across(*x), along(*y));
                let _ = writeln!(
                    svg,
                    "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.4\" fill=\"{colour}\"/>",
                    across(*x),
                    along(*y)
                );
            }
            pen = if y.is_finite() { 'L' } else { 'M' };
        }
        let _ = writeln!(svg, "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"/>");
        names.extend(y.iter().rev().find(|y| y.is_finite()).map(|y| (along(*y), k)));
    }
    names.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (wanted, k) in names {
        free = wanted.min(free - 13.0);
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{:.1}\" fill=\"{}\">{}</text>",
            SIZE[0] - right + 8.0,
            free + 4.0,
            COLOURS[k % COLOURS.len()],
            plain(&series[k].0)
        );
    }
    let (middle, low) = (0.5 * (left + SIZE[0] - right), SIZE[1] - 10.0);
    let _ =
        writeln!(svg, "<text x=\"{middle}\" y=\"{low}\" text-anchor=\"middle\">{}</text>", plain(x_label));
    let high = 0.5 * (top + SIZE[1] - bottom);
    let _ = writeln!(
        svg,
        "<text transform=\"translate(16,{high}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n</svg>",
        plain(y_label)
    );
    svg
}

/// Text as it may stand in an element.
fn plain(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

/// Where a value is between the first and the last tick.
fn part(ticks: &[f64], value: f64) -> f64 {
    match ticks {
        [first, .., last] => (value - first) / (last - first),
        _ => 0.5,
    }
}

/// Round numbers around some values.
fn ticks<'a>(values: impl Iterator<Item = &'a f64> + Clone) -> Vec<f64> {
    let finite = || values.clone().copied().filter(|v| v.is_finite());
    let (mut low, mut high) =
        (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    if low > high {
        (low, high) = (0.0, 1.0);
    }
    if low > 0.0 && low < 0.6 * high {
        low = 0.0;
    }
    if high - low <= 1e-9 * high.abs().max(low.abs()) {
        (low, high) = (low - 0.5 * low.abs().max(1.0), high + 0.5 * high.abs().max(1.0));
    }
    let raw = (high - low) / 6.0;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 2.5, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= raw).unwrap_or(raw);
    let (first, last) = ((low / step + 1e-9).floor() as i64, (high / step - 1e-9).ceil() as i64);
    (first..=last).map(|k| k as f64 * step).collect()
}
