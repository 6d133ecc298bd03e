//! The largest entries of the tensors, in words.

use std::collections::BTreeMap;

use rom_runtime::data::ModelData;
use serde::Serialize;

use crate::text::significant;

/// One coupling between motions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coupling {
    /// Tensor it comes from: `c` or `k`.
    pub tensor: &'static str,
    /// In words.
    pub text: String,
    /// Strength: the larger of the entries involved, each row and column divided by the square root of its
    /// generalised mass, so that modes and rigid motions compare - 1 (between rates).
    pub strength: f64,
}

/// As many of each kind are told.
const TOLD: usize = 6;

/// Weaker ones than this fraction of the strongest of their kind are not worth a line.
const LEAST: f64 = 1e-3;

/// The largest couplings through the angular velocity: between two elastic modes, from rigid rotation to a mode,
/// from a mode to the rigid body; and the modes most stiffened or softened by rotation. (Translational velocities
/// are left out: they change with the observer.)
pub fn couplings(data: &ModelData) -> Vec<Coupling> {
    let by_kind = [modes_coupled(data), modes_driven(data), body_moved(data), modes_stiffened(data)];
    by_kind.into_iter().flat_map(largest).collect()
}

fn largest(mut list: Vec<Coupling>) -> Vec<Coupling> {
    // Equal strengths keep their order in the tensor, so that the text is the same everywhere.
    list.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    let least = list.first().map_or(0.0, |c| c.strength) * LEAST;
    list.retain(|c| c.strength > least);
    list.truncate(TOLD);
    list
}

/// Entries of c with an angular velocity r in 0..3: (i, l, r, value divided by the roots of both masses).
fn entries(data: &ModelData) -> impl Iterator<Item = (usize, usize, usize, f64)> {
    let mass = masses(data);
    let c = &data.c;
    let all = (0..c.value.len()).map(|n| (c.i[n] as usize, c.l[n] as usize, c.r[n] as usize, c.value[n]));
    all.filter(|&(_, _, r, _)| r >= 3)
        .map(move |(i, l, r, value)| (i, l, r - 3, value / (mass[i] * mass[l]).sqrt()))
}

/// Generalised masses of all coordinates - (m + 6).
fn masses(data: &ModelData) -> Vec<f64> {
    let rigid = (0..6).map(|i| data.rigid.mass_matrix[7 * i]);
    data.modes.mass.iter().copied().chain(rigid).collect()
}

fn rate(r: usize) -> &'static str {
    ["roll rate (w_x)", "pitch rate (w_y)", "yaw rate (w_z)"][r]
}

fn rigid_motion(i: usize) -> &'static str {
    ["surge (x)", "sway (y)", "heave (z)", "roll (about x)", "pitch (about y)", "yaw (about z)"][i]
}

fn modes_coupled(data: &ModelData) -> Vec<Coupling> {
    let m = data.modes.omega.len();
    let mut pairs: BTreeMap<(usize, usize, usize), [f64; 2]> = BTreeMap::new();
    for (i, l, r, value) in entries(data).filter(|&(i, l, ..)| i < m && l < m) {
        pairs.entry((i.min(l), i.max(l), r)).or_default()[usize::from(i > l)] += value;
    }
    let number = &data.modes.number;
    let tell = |((a, b, r), [upper, lower]): ((usize, usize, usize), [f64; 2])| {
        let text = if a == b {
            format!("{} feeds the rate of mode {} back on itself ({})", rate(r), number[a], figure(upper))
        } else {
            let (a, b) = (number[a], number[b]);
            let figures = format!("{} on mode {a}, {} on mode {b}", figure(upper), figure(lower));
            format!("{} couples mode {a} with mode {b} ({figures})", rate(r))
        };
        Coupling { tensor: "c", text, strength: upper.abs().max(lower.abs()) }
    };
    pairs.into_iter().map(tell).collect()
}

fn modes_driven(data: &ModelData) -> Vec<Coupling> {
    let m = data.modes.omega.len();
    let mut drives: BTreeMap<(usize, usize, usize), f64> = BTreeMap::new();
    // c_ilr beta_l beta_r and c_irl beta_r beta_l are one product.
    for (i, l, r, value) in entries(data).filter(|&(i, l, ..)| i < m && l >= m + 3) {
        let l = l - m - 3;
        *drives.entry((i, l.min(r), l.max(r))).or_default() += value;
    }
    let tell = |((i, l, r), value): ((usize, usize, usize), f64)| {
        let cause =
            if l == r { format!("{} squared", rate(r)) } else { format!("{} times {}", rate(l), rate(r)) };
        let text = format!("{cause} drives mode {} ({})", data.modes.number[i], figure(value));
        Coupling { tensor: "c", text, strength: value.abs() }
    };
    drives.into_iter().map(tell).collect()
}

fn body_moved(data: &ModelData) -> Vec<Coupling> {
    let m = data.modes.omega.len();
    let tell = |(i, l, r, value): (usize, usize, usize, f64)| {
        let (mode, motion) = (data.modes.number[l], rigid_motion(i - m));
        let text =
            format!("{} times the rate of mode {mode} reacts on {motion} ({})", rate(r), figure(value));
        Coupling { tensor: "c", text, strength: value.abs() }
    };
    entries(data).filter(|&(i, l, ..)| i >= m && l < m).map(tell).collect()
}

/// Entries k_ilrr with i = l: the square of the frequency changes by k times the square of the rate.
fn modes_stiffened(data: &ModelData) -> Vec<Coupling> {
    let k = &data.k;
    let all = (0..k.value.len()).map(|n| (k.i[n] as usize, k.l[n] as usize, k.r[n] as usize, k.value[n]));
    let diagonal = all.filter(|&(i, l, rs, _)| i == l && rs / 6 == rs % 6 && rs >= 21);
    let tell = |(i, _, rs, value): (usize, usize, usize, f64)| {
        let value = value / data.modes.mass[i];
        let does = if value > 0.0 { "stiffens" } else { "softens" };
        let (r, mode) = (rate(rs / 6 - 3), data.modes.number[i]);
        let text = format!("{r} squared {does} mode {mode} ({} on its frequency squared)", figure(value));
        Coupling { tensor: "k", text, strength: value.abs() }
    };
    diagonal.map(tell).collect()
}

fn figure(value: f64) -> String {
    significant(value, 3)
}
