//! States that nothing depends on: where the body is, its heading, and in weightlessness its attitude.
//!
//! They are directions of `(theta, r)` along which no acceleration changes, and that the kinematics map on such directions:
//! the kernel of `(B, B K, .., B K^5)`, with `B` the columns of the other rows and `K` the kinematics among them. The poles of the rest are
//! then those of a matrix without the chains of zeros, which would cost half the digits.

use nalgebra::{DMatrix, DVector};

use super::poles::{Pole, poles};
use super::steady::Weights;
use super::{Channel, Full, LineariseError, StateSpace, Steady};

/// Accelerations that count as none, relative to what is there.
const NOTHING: f64 = 1e-9;

/// The parts of the turns and displacements.
struct Directions {
    /// What matters, orthonormal - (6 x k).
    kept: DMatrix<f64>,
    /// What nothing depends on, orthonormal - (6 x 6 - k).
    ignorable: DMatrix<f64>,
}

/// The linear model, with or without the states that nothing depends on.
pub(super) fn split(
    full: Full,
    weights: &Weights,
    steady: Steady,
    reduce: bool,
) -> Result<StateSpace, LineariseError> {
    if steady.driven {
        let poles = poles(&full.a)?;
        return Ok(assembled(full, Vec::new(), 0, poles, steady));
    }
    let first = full.a.nrows() - 6;
    let directions = directions(&full, weights);
    let ignorable = directions.ignorable.ncols();
    let reduced = without(&full, &directions, weights, first);
    let mut all = poles(&reduced.0.a)?;
    all.extend(poles(&of_ignorable(&scaled_kinematics(&full, weights, first), &directions.ignorable))?);
    all.sort_by(Pole::order);
    if reduce {
        return Ok(assembled(reduced.0, reduced.1, ignorable, all, steady));
    }
    Ok(assembled(full, Vec::new(), ignorable, all, steady))
}

fn assembled(
    full: Full,
    dropped: Vec<String>,
    ignorable: usize,
    poles: Vec<Pole>,
    steady: Steady,
) -> StateSpace {
    let Full { a, b, c, d, states, inputs, outputs } = full;
    StateSpace { a, b, c, d, states, inputs, outputs, dropped, ignorable, poles, steady }
}

/// `K` with displacements over the length of the body.
fn scaled_kinematics(full: &Full, weights: &Weights, first: usize) -> DMatrix<f64> {
    let scale = |k: usize| if k < 3 { 1.0 } else { weights.length };
    DMatrix::from_fn(6, 6, |i, j| full.a[(first + i, first + j)] * scale(j) / scale(i))
}

/// The kinematics of the states that nothing depends on. What the velocity adds to the displacement as the body turns has no eigenvalues of
/// its own, but makes chains of those of the turn, which cost half the digits: it is left out where the rest stays a matrix of them.
fn of_ignorable(kinematics: &DMatrix<f64>, basis: &DMatrix<f64>) -> DMatrix<f64> {
    let mut turning = kinematics.clone();
    turning.view_mut((3, 0), (3, 3)).fill(0.0);
    let within = basis.tr_mul(&(&turning * basis));
    let outside = &turning * basis - basis * &within;
    if outside.amax() <= 1e-12 * turning.amax() { within } else { basis.tr_mul(&(kinematics * basis)) }
}

fn directions(full: &Full, weights: &Weights) -> Directions {
    let first = full.a.nrows() - 6;
    let m = (first - 6) / 2;
    let kinematics = scaled_kinematics(full, weights, first);
    let scale = |k: usize| if k < 3 { 1.0 } else { weights.length };
    let rows = DMatrix::from_fn(m + 6, 6, |i, j| full.a[(m + i, first + j)] * scale(j) * weights.relative(i));
    // Rates of the turn make the powers of K comparable.
    let pace = kinematics.amax().max(f64::MIN_POSITIVE);
    let (mut power, mut gram) = (rows, DMatrix::zeros(6, 6));
    for _ in 0..6 {
        gram += power.tr_mul(&power);
        power = &power * &kinematics / pace;
    }
    let eigen = gram.symmetric_eigen();
    let (mut kept, mut ignorable): (Vec<DVector<f64>>, Vec<DVector<f64>>) = (Vec::new(), Vec::new());
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        let matters = *value > NOTHING * NOTHING;
        if matters { &mut kept } else { &mut ignorable }.push(vector.into_owned());
    }
    let columns = |of: &[DVector<f64>]| {
        if of.is_empty() { DMatrix::zeros(6, 0) } else { DMatrix::from_columns(of) }
    };
    let mut found = Directions { kept: columns(&kept), ignorable: columns(&ignorable) };
    found.kept = along_axes(&found.kept);
    found.ignorable = along_axes(&found.ignorable);
    found
}

/// The axes themselves where they span the same.
fn along_axes(basis: &DMatrix<f64>) -> DMatrix<f64> {
    let projector = basis * basis.transpose();
    let spanned = |k: &usize| projector[(*k, *k)] > 1.0 - 1e-9;
    let axes: Vec<usize> = (0..6).filter(spanned).collect();
    if axes.len() != basis.ncols() {
        return basis.clone();
    }
    DMatrix::from_fn(6, axes.len(), |i, j| f64::from(u8::from(axes[j] == i)))
}

/// The model of what matters, and the outputs that go with the rest.
fn without(full: &Full, directions: &Directions, weights: &Weights, first: usize) -> (Full, Vec<String>) {
    let (n, k) = (full.a.nrows(), directions.kept.ncols());
    let scale = |k: usize| if k < 3 { 1.0 } else { weights.length };
    let mut into = DMatrix::zeros(first + k, n);
    let mut out = DMatrix::zeros(n, first + k);
    (0..first).for_each(|i| (into[(i, i)], out[(i, i)]) = (1.0, 1.0));
    for (i, j) in (0..6).flat_map(|i| (0..k).map(move |j| (i, j))) {
        into[(first + j, first + i)] = directions.kept[(i, j)] / scale(i);
        out[(first + i, first + j)] = directions.kept[(i, j)] * scale(i);
    }
    let ignorable = DMatrix::from_fn(n, directions.ignorable.ncols(), |i, j| {
        i.checked_sub(first).map_or(0.0, |i| directions.ignorable[(i, j)] * scale(i))
    });
    // Displacements in the length of the body go back to metres where they are axes.
    let mut states = full.states[..first].to_vec();
    for j in 0..k {
        let column = directions.kept.column(j);
        let axis = (0..6).find(|&i| (column[i] - 1.0).abs() < 1e-12);
        match axis {
            Some(i) => {
                states.push(full.states[first + i].clone());
                into.row_mut(first + j).scale_mut(scale(i));
                out.column_mut(first + j).scale_mut(1.0 / scale(i));
            }
            None => states.push(mixed(&full.states[first..], column.as_slice(), weights, j + 1)),
        }
    }
    let loose = &full.c * ignorable;
    let keeps =
        |row: usize| loose.row(row).iter().all(|x| x.abs() <= NOTHING * (1.0 + full.c.row(row).amax()));
    let rows: Vec<usize> = (0..full.c.nrows()).filter(|row| keeps(*row)).collect();
    let dropped = (0..full.c.nrows()).filter(|row| !keeps(*row));
    let dropped = dropped.map(|row| full.outputs[row].name.clone()).collect();
    let picked = |of: &DMatrix<f64>| DMatrix::from_fn(rows.len(), of.ncols(), |i, j| of[(rows[i], j)]);
    let reduced = Full {
        a: &into * &full.a * &out,
        b: &into * &full.b,
        c: picked(&(&full.c * &out)),
        d: picked(&full.d),
        states,
        inputs: full.inputs.clone(),
        outputs: rows.iter().map(|&row| full.outputs[row].clone()).collect(),
    };
    (reduced, dropped)
}

/// A combination of turns and displacements.
fn mixed(states: &[Channel], column: &[f64], weights: &Weights, number: usize) -> Channel {
    let scale = |k: usize| if k < 3 { 1.0 } else { 1.0 / weights.length };
    let terms: Vec<String> = states
        .iter()
        .zip(column)
        .enumerate()
        .filter(|(_, (_, x))| x.abs() > 1e-9)
        .map(|(k, (state, x))| format!("{:+.6} {}", x * scale(k), state.name))
        .collect();
    Channel::new(format!("attitude.{number}"), "1", terms.join(" "))
}
