//! The view of a reduced model and of its runs: modes of the model file, amplitudes of the results.

use nalgebra::{UnitQuaternion, Vector3};
use rom_runtime::data::{ModelData, PointData};
use rom_runtime::expression::Variables;
use rom_runtime::loads::{Load, LoadCase};
use rom_runtime::{Model, State};

use super::arrows::{Instant, arrows, largest, unit, wrench};
use super::drawn::Drawn;
use super::{Body, FRAMES, MOST_NODES, Modes, Scene, Track, Velocity, frames};
use crate::info;
use crate::results::Results;
use crate::text::significant;

/// The structure at rest with its modes, and no body yet; none when the model file holds no picture.
pub fn modes(data: &ModelData) -> Option<Scene> {
    let drawn = Drawn::modes(data, MOST_NODES)?;
    let names = data.modes.number.iter().zip(&data.modes.omega);
    let name = |(number, omega): (&u32, &f64)| {
        format!("mode {number}, {} Hz", significant(omega / std::f64::consts::TAU, 4))
    };
    Some(Scene {
        title: "The structure in space".to_owned(),
        modes: Modes {
            names: names.map(name).collect(),
            shapes: drawn.shapes,
            rigid: data.modes.phi_r.clone(),
        },
        positions: drawn.positions,
        lines: drawn.lines,
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
    let mut drawn = Drawn::of_run(data, results, MOST_NODES)?;
    let rows = frames(results.rows(), FRAMES);
    let column = |name: &str| {
        let channel = results.channel(name)?;
        Some(rows.iter().flat_map(|&row| channel.row(row).iter().copied()).collect::<Vec<f64>>())
    };
    let (t, origin, attitude) = (column("t")?, column("r_G")?, column("zeta")?);
    let modal = column("q").unwrap_or_default();
    // The rigid method has none.
    let k = modal.len() / t.len().max(1);
    let (v_a, w_a) = (column("v_A")?, column("w_A")?);
    let vector = |values: &[f64], i: usize| [values[3 * i], values[3 * i + 1], values[3 * i + 2]];
    let q = |i: usize| modal.get(i * k..(i + 1) * k).unwrap_or(&[]);
    let modal_rates = column("q_dot").unwrap_or_default();
    let q_dot = |i: usize| modal_rates.get(i * k..(i + 1) * k).unwrap_or(&[]);
    let (mut amplitudes, mut rates) = (Vec::new(), Vec::new());
    for i in 0..t.len() {
        let [of_shapes, their_rates] = drawn.amplitudes(q(i), q_dot(i));
        amplitudes.extend(of_shapes);
        rates.extend(their_rates);
    }
    let (v_g, w_g) = (column("v_G")?, column("w_G")?);
    let of_a = (0..t.len()).flat_map(|i| [vector(&v_g, i), vector(&w_g, i)]).flatten().collect();
    // Without their rates the modes would seem to stand still.
    let known = modal_rates.len() == modal.len();
    let velocity = if known { Velocity::OfShapes { of_a, rates } } else { Velocity::Unknown };
    let shapes = if amplitudes.is_empty() { Vec::new() } else { drawn.shapes };
    let places = Places::new(data, results);
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
        let displacement = (0..t.len()).flat_map(|i| <[f64; 3]>::from(places.displaced(p, q(i)).0));
        Track { name: point.name.clone(), rest: info::position(point), displacement: displacement.collect() }
    };
    let points: Vec<Track> = shown.iter().map(track).collect();
    let mut all = Vec::new();
    for load in loads {
        let p = load.point as usize;
        let Some(index) = shown.iter().position(|&s| s == p) else { continue };
        let at = |i: usize| Instant {
            variables: Variables {
                t: t[i],
                v_a: vector(&v_a, i),
                w_a: vector(&w_a, i),
                r_g: vector(&origin, i),
            },
            attitude: turn(i),
            node: turn(i) * places.displaced(p, q(i)).1,
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
        velocity,
        points,
        arrows: largest(all),
    })
}

/// Where named points are at modal amplitudes.
struct Places<'a> {
    data: &'a ModelData,
    /// The model itself where its shapes are curved.
    curved: Option<Model>,
}

impl<'a> Places<'a> {
    fn new(data: &'a ModelData, results: &Results) -> Self {
        let reduced = results.metadata.get("method").is_some_and(|method| method == "rom");
        let curved = data.picture_curve.is_some() && reduced;
        Self { data, curved: curved.then(|| Model::new(data.clone()).ok()).flatten() }
    }

    /// Displacement of a point in A, and the attitude of its node in A, at modal amplitudes; none: at rest.
    fn displaced(&self, point: usize, q: &[f64]) -> (Vector3<f64>, UnitQuaternion<f64>) {
        if let Some(model) = &self.curved
            && q.len() == model.n_modes()
        {
            let mut state = State::at_rest(model);
            (state.attitude, state.position) = ([1.0, 0.0, 0.0, 0.0], [0.0; 3]);
            state.q.copy_from_slice(q);
            let still = vec![0.0; q.len() + 6];
            let motion = model.point_motion(&state, &still, point);
            if let (Some(output), Some(motion)) = (model.point_output(&state, point), motion) {
                return (output.dr_a.into(), unit(motion.attitude));
            }
        }
        self.data.points.get(point).map_or_else(Default::default, |point| linear(point, q))
    }
}

/// The same with linear shapes.
fn linear(point: &PointData, q: &[f64]) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let m = q.len();
    let sum = |phi: &[f64]| {
        Vector3::from_fn(|row, _| phi.iter().skip(row * m).zip(q).map(|(phi, q)| phi * q).sum::<f64>())
    };
    let (rest, offset) = (unit(point.node_rotation), Vector3::from(point.offset));
    let now = rest * UnitQuaternion::from_scaled_axis(sum(&point.phi_rotation));
    (sum(&point.phi_translation) + now * offset - rest * offset, now)
}
