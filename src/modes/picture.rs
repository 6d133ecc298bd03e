//! A mode shape as a picture: deformed over undeformed, seen obliquely and along the three axes.

use std::fmt::Write;

use nalgebra::Vector3;
use rom_generator::math::so3::exp;
use rom_generator::mesh::Mesh;
use rom_generator::vibration::{ModeSet, Shape};

/// Size of a panel and its margin, in units of the picture.
const PANEL: [f64; 2] = [340.0, 230.0];
const MARGIN: f64 = 26.0;
/// Most points drawn of a member, and most bars across it.
const MOST_POINTS: usize = 160;
const MOST_BARS: usize = 12;
/// Largest displacement and length of the bars over the size of the structure; largest rotation, rad.
const DISPLACEMENT: f64 = 0.1;
const BAR: f64 = 0.05;
const ROTATION: f64 = 0.6;

/// Lines in space, undeformed and deformed.
#[derive(Clone, Debug, Default)]
struct Figure {
    /// The axes of the members and bars along local y of their sections, as they are.
    before: Vec<Vec<Vector3<f64>>>,
    /// The same in the mode.
    after: Vec<Vec<Vector3<f64>>>,
}

/// The lines of a mode at the largest amplitude that is easy to look at.
fn figure(mesh: &Mesh, set: &ModeSet, mode: &Shape) -> Figure {
    let size = extent(&set.at.positions);
    let largest = |v: &[Vector3<f64>]| v.iter().map(Vector3::norm).fold(0.0, f64::max);
    let scale = (DISPLACEMENT * size / largest(&mode.translations)).min(ROTATION / largest(&mode.rotations));
    let mut figure = Figure::default();
    for member in &mesh.members {
        let count = member.nodes.len();
        let per_element = (count - 1) / member.elements.len().max(1);
        // The place of the k-th node on the axis, and the ends of a bar through it, before and after.
        let place = |k: usize| {
            let (index, end) = if k == count - 1 {
                (member.elements.len() - 1, per_element)
            } else {
                (k / per_element, k % per_element)
            };
            let element = &mesh.elements[member.elements.start + index];
            let node = member.nodes[k];
            let turn = set.at.rotation_matrix(node);
            let arm = turn * element.levers[end];
            let bar = turn * element.frames[end].column(1) * (0.5 * BAR * size);
            let turned = exp(&(mode.rotations[node] * scale));
            let before = set.at.positions[node] + arm;
            let after = set.at.positions[node] + mode.translations[node] * scale + turned * arm;
            [[before, before + bar, before - bar], [after, after + turned * bar, after - turned * bar]]
        };
        let along = |most: usize| {
            let step = (count - 1).div_ceil(most).max(1);
            (0..count - 1).step_by(step).chain(std::iter::once(count - 1))
        };
        figure.before.push(along(MOST_POINTS).map(|k| place(k)[0][0]).collect());
        figure.after.push(along(MOST_POINTS).map(|k| place(k)[1][0]).collect());
        for k in along(MOST_BARS) {
            let [[_, a, b], [_, c, d]] = place(k);
            figure.before.push(vec![a, b]);
            figure.after.push(vec![c, d]);
        }
    }
    figure
}

/// Largest side of the box around the nodes.
fn extent(positions: &[Vector3<f64>]) -> f64 {
    let side = |k: usize| {
        let values = || positions.iter().map(move |r| r[k]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    (0..3).map(side).fold(f64::MIN_POSITIVE, f64::max)
}

/// A direction of view: its name, and the directions to the right and up.
fn views() -> [(&'static str, Vector3<f64>, Vector3<f64>); 4] {
    let (azimuth, elevation) = (-50f64.to_radians(), 28f64.to_radians());
    let right = Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0);
    let up =
        Vector3::new(-elevation.sin() * azimuth.cos(), -elevation.sin() * azimuth.sin(), elevation.cos());
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
    [("oblique", right, up), ("x right, y up", x, y), ("x right, z up", x, z), ("y right, z up", y, z)]
}

/// The picture as an SVG image. Colours are attributes, which style sheets of a page override.
pub fn picture(mesh: &Mesh, set: &ModeSet, index: usize) -> String {
    let figure = figure(mesh, set, &set.modes[index]);
    let (width, height) = (2.0 * PANEL[0], 2.0 * PANEL[1]);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\" \
         class=\"shape\" role=\"img\" aria-label=\"mode {}\">\n",
        index + 1
    );
    for (k, (name, right, up)) in views().into_iter().enumerate() {
        let corner = [PANEL[0] * (k % 2) as f64, PANEL[1] * (k / 2) as f64];
        let (scale, centre) = fit(&figure, &right, &up);
        let at = |r: &Vector3<f64>| {
            let x = corner[0] + 0.5 * PANEL[0] + scale * (r.dot(&right) - centre[0]);
            let y = corner[1] + 0.5 * PANEL[1] - scale * (r.dot(&up) - centre[1]);
            format!("{x:.1},{y:.1}")
        };
        for (class, colour, width, lines) in
            [("before", "#9aa4b0", 1.0, &figure.before), ("after", "#1763b5", 1.6, &figure.after)]
        {
            let _ = writeln!(
                svg,
                "<g class=\"{class}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\">"
            );
            for line in lines {
                let points: Vec<String> = line.iter().map(at).collect();
                let _ = writeln!(svg, "<polyline points=\"{}\"/>", points.join(" "));
            }
            svg.push_str("</g>\n");
        }
        let (x, y) = (corner[0] + 8.0, corner[1] + 16.0);
        let _ = writeln!(svg, "<text class=\"view\" fill=\"#5a6675\" x=\"{x}\" y=\"{y}\">{name}</text>");
    }
    svg.push_str("</svg>\n");
    svg
}

/// Largest scale at which a view fits a panel, and its centre.
fn fit(figure: &Figure, right: &Vector3<f64>, up: &Vector3<f64>) -> (f64, [f64; 2]) {
    let points = || figure.before.iter().chain(&figure.after).flatten();
    let range = |axis: &Vector3<f64>| {
        let values = || points().map(|r| r.dot(axis));
        (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
    };
    let (x, y) = (range(right), range(up));
    let room =
        |k: usize, (low, high): (f64, f64)| (PANEL[k] - 2.0 * MARGIN) / (high - low).max(f64::MIN_POSITIVE);
    (room(0, x).min(room(1, y)), [0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1)])
}
