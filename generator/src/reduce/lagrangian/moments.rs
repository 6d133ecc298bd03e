//! Moments of two fields, as few as leave the deformed body its mass.
//!
//! `P_ab` counts in the inertia tensor, `y_a P_ab y_b`, and in what couples the rates with the rotation, `y_dot_a P_ab y_b`. The second counts
//! more the more modes there are: those of high frequency have small ranges, and at equal energy rates no smaller than the first. What is
//! dropped of `P_ab` is not dropped of `X`, so that `T` is a sum of squares no longer: too much of it, and the mass matrix (B.7) has a negative
//! eigenvalue where the body is bent. It is therefore compared with that of all moments.

use nalgebra::{DMatrix, Matrix6};
use rom_runtime::data::{LagrangianData, TensorData};

use super::fields::Fields;
use super::momentum::Momentum;

/// What the rate of a kinetic coordinate counts for, beside its size.
const RATE: f64 = 0.3;
/// Least share of its mass that a body keeps in any direction, with one of the modes at its range.
const LEAST: f64 = 0.75;
/// Tolerances are halved so many times at most.
const HALVINGS: usize = 30;

/// All of them.
pub(super) fn all(fields: &Fields) -> TensorData {
    above(fields, 0.0)
}

/// Those above a tolerance, or above a smaller one that leaves enough mass. `whole`: the Lagrangian with all moments.
pub(super) fn enough(
    whole: &LagrangianData,
    fields: &Fields,
    rigid: &Matrix6<f64>,
    mut tolerance: f64,
) -> TensorData {
    let exact = Momentum::new(whole, rigid);
    // A body without inertia about one of its axes has no direction to lose there.
    let bent: Vec<(Vec<f64>, DMatrix<f64>)> = bent(&whole.range)
        .filter_map(|q| Some((inverse_root(exact.mass(&q))?, q)))
        .map(|(r, q)| (q, r))
        .collect();
    let mut data = whole.clone();
    for _ in 0..HALVINGS {
        data.moment = above(fields, tolerance);
        let kept = Momentum::new(&data, rigid);
        let share = |(q, root): &(Vec<f64>, DMatrix<f64>)| {
            (root * kept.mass(q) * root.transpose()).symmetric_eigenvalues().min()
        };
        if bent.iter().all(|it| share(it) >= LEAST) {
            break;
        }
        tolerance *= 0.5;
    }
    data.moment
}

/// One mode after the other at its range, to both sides.
fn bent(range: &[f64]) -> impl Iterator<Item = Vec<f64>> {
    (0..range.len()).flat_map(move |i| {
        [1.0, -1.0].map(|sign| {
            let mut q = vec![0.0; range.len()];
            q[i] = sign * range[i];
            q
        })
    })
}

/// `L^-1` of `L L^t`.
fn inverse_root(mass: DMatrix<f64>) -> Option<DMatrix<f64>> {
    mass.cholesky()?.l().try_inverse()
}

/// `P_ab` without what is below a tolerance in the kinetic energy.
fn above(fields: &Fields, tolerance: f64) -> TensorData {
    let n = fields.size.len();
    let threshold = tolerance * fields.reference * fields.reference;
    let mut out = TensorData {
        i: Vec::new(),
        l: Vec::new(),
        r: Vec::new(),
        value: Vec::new(),
        threshold: tolerance,
        scale: "at the range of the amplitudes, the larger of the size of the two kinetic coordinates and 0.3 times the size of one with the rate of the other, over the square of the largest".into(),
        dropped_norm: 0.0,
        dropped_count: 0,
    };
    let mut dropped = 0.0;
    for a in 0..n {
        for b in 0..n {
            let (size, rate) = (&fields.size, &fields.rate);
            let moving = (size[a] * rate[b]).max(rate[a] * size[b]);
            let measure = (size[a] * size[b]).max(RATE * moving);
            for component in 0..9 {
                // The mean with the mirror image, so that both are the same to the bit.
                let mirror = 3 * (component % 3) + component / 3;
                let value = 0.5 * (fields.moment[a * n + b][component] + fields.moment[b * n + a][mirror]);
                if value.abs() * measure > threshold {
                    out.i.push(a as u32);
                    out.l.push(b as u32);
                    out.r.push(component as u32);
                    out.value.push(value);
                } else if value != 0.0 {
                    dropped += value * value;
                    out.dropped_count += 1;
                }
            }
        }
    }
    out.dropped_norm = f64::sqrt(dropped);
    out
}
