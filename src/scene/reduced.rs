//! The view of a reduced model and of its runs: modes of the model file, amplitudes of the results.

use nalgebra::{UnitQuaternion, Vector3};
use rom_generator::picture;
use rom_runtime::data::{ModelData, PictureData, PointData};
use rom_runtime::expression::Variables;
use rom_runtime::loads::{Load, LoadCase};

use super::arrows::{Instant, arrows, largest, unit, wrench};
use super::{Body, FRAMES, MOST_NODES, Modes, Scene, Track, frames};
use crate::info;
use crate::results::Results;
use crate::text::significant;

/// The structure at rest with its modes, and no body yet; none when the model file holds no picture.
pub fn modes(data: &ModelData) -> Option<Scene> {
    let picture = drawn(data.picture.as_ref()?, data.modes.omega.len());
    let names = data.modes.number.iter().zip(&data.modes.omega);
    let name = |(number, omega): (&u32, &f64)| {
        format!("mode {number}, {} Hz", significant(omega / std::f64::consts::TAU, 4))
    };
    Some(Scene {
        title: "The structure in space".to_owned(),
        modes: Modes {
            names: names.map(name).collect(),
            shapes: picture.phi_translation,
            rigid: data.modes.phi_r.clone(),
        },
        positions: picture.positions,
        lines: picture.lines,
        bodies: Vec::new(),
    })
}

/// The structure, its modes and a run of it; none where there is nothing to draw.
pub fn of_run(data: &ModelData, case: &LoadCase, results: &Results, name: &str) -> Option<Scene> {
    Some(Scene { bodies: vec![body(data, case, results, name)?], ..modes(data)? })
}

/// A run as a body. `data` is that of the reduced model itself, also where a simpler method ran: its shapes are relative to A.
/// None when the model file holds no picture or the results lack what it takes.
fn body(data: &ModelData, case: &LoadCase, results: &Results, name: &str) -> Option<Body> {
    let m = data.modes.omega.len();
    let picture = drawn(data.picture.as_ref()?, m);
    let rows = frames(results.rows(), FRAMES);
    let column = |name: &str| {
        let channel = results.channel(name)?;
        Some(rows.iter().flat_map(|&row| channel.row(row).iter().copied()).collect::<Vec<f64>>())
    };
    let (t, origin, attitude) = (column("t")?, column("r_G")?, column("zeta")?);
    let amplitudes = column("q").unwrap_or_default();
    // The rigid method has none.
    let k = amplitudes.len() / t.len().max(1);
    let shapes = if k == m { picture.phi_translation } else { Vec::new() };
    let (v_a, w_a) = (column("v_A")?, column("w_A")?);
    let vector = |values: &[f64], i: usize| [values[3 * i], values[3 * i + 1], values[3 * i + 2]];
    let q = |i: usize| amplitudes.get(i * k..(i + 1) * k).unwrap_or(&[]);
    let turn = |i: usize| unit(std::array::from_fn(|c| attitude[4 * i + c]));
    let trim = data.trim.iter().flat_map(|trim| &trim.loads);
    let loads: Vec<&Load> = trim.chain(&case.loads).collect();
    let shown: Vec<usize> = (0..data.points.len())
        .filter(|&p| {
            results.channel(&format!("{}.dR_A", data.points[p].name)).is_some()
                || loads.iter().any(|load| load.point as usize == p)
        })
        .collect();
    let track = |&p: &usize| {
        let point = &data.points[p];
        let displacement = (0..t.len()).flat_map(|i| <[f64; 3]>::from(displaced(point, q(i)).0));
        Track { name: point.name.clone(), rest: info::position(point), displacement: displacement.collect() }
    };
    let points: Vec<Track> = shown.iter().map(track).collect();
    let mut all = Vec::new();
    for load in loads {
        let p = load.point as usize;
        let (Some(point), Some(index)) = (data.points.get(p), shown.iter().position(|&s| s == p)) else {
            continue;
        };
        let at = |i: usize| Instant {
            variables: Variables {
                t: t[i],
                v_a: vector(&v_a, i),
                w_a: vector(&w_a, i),
                r_g: vector(&origin, i),
            },
            attitude: turn(i),
            node: turn(i) * displaced(point, q(i)).1,
        };
        let wrenches: Vec<_> = (0..t.len()).map(|i| wrench(load, &at(i))).collect();
        all.extend(arrows(index, &wrenches));
    }
    Some(Body {
        name: name.to_owned(),
        t,
        origin,
        attitude,
        shapes,
        amplitudes,
        points,
        arrows: largest(all),
    })
}

/// Displacement of a point in A, and the attitude of its node in A, at modal amplitudes; none: at rest.
fn displaced(point: &PointData, q: &[f64]) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let m = q.len();
    let sum = |phi: &[f64]| {
        Vector3::from_fn(|row, _| phi.iter().skip(row * m).zip(q).map(|(phi, q)| phi * q).sum::<f64>())
    };
    let (rest, offset) = (unit(point.node_rotation), Vector3::from(point.offset));
    let now = rest * UnitQuaternion::from_scaled_axis(sum(&point.phi_rotation));
    (sum(&point.phi_translation) + now * offset - rest * offset, now)
}

/// A picture of no more nodes than a page should hold.
fn drawn(picture: &PictureData, m: usize) -> PictureData {
    let n = picture.positions.len() / 3;
    if n <= MOST_NODES {
        return picture.clone();
    }
    let lines: Vec<Vec<usize>> =
        picture.lines.iter().map(|line| line.iter().map(|&node| node as usize).collect()).collect();
    let lines: Vec<&[usize]> = lines.iter().map(Vec::as_slice).collect();
    let outline = picture::thin(&lines, &vec![false; n], MOST_NODES);
    let rows = |values: &[f64], width: usize| {
        outline.nodes.iter().flat_map(|&node| values[node * width..(node + 1) * width].to_vec()).collect()
    };
    PictureData {
        positions: rows(&picture.positions, 3),
        phi_translation: rows(&picture.phi_translation, 3 * m),
        lines: outline.lines,
    }
}
