//! Checks of the Lagrangian of a model file.

use alloc::{format, string::ToString};

use super::{Check, array, every, finite_at, indices, positive, shape, tensor};
use crate::data::{CurveValidityData, LagrangianData, PictureCurveData, PolynomialData};
use crate::error::ModelError;
use crate::lagrangian::MAX_FIELDS;

pub(super) fn lagrangian(data: &LagrangianData, m: usize, n_points: usize) -> Check {
    let n = data.fields as usize;
    if n < m || n > MAX_FIELDS {
        return Err(ModelError::Value {
            what: "number of kinetic coordinates".to_string(),
            index: 0,
            found: f64::from(data.fields),
            expected: "at least the number of modes, at most 512",
        });
    }
    array("linear part of the kinetic coordinates", &data.linear, m * m)?;
    for (index, &found) in data.linear.iter().enumerate() {
        let (row, column) = (index / m, index % m);
        let accepted = if column == row { found > 0.0 } else { column > row || found == 0.0 };
        if !accepted {
            let expected = "an upper triangular matrix with a positive diagonal";
            return Err(ModelError::Value {
                what: "linear part of the kinetic coordinates".to_string(),
                index,
                found,
                expected,
            });
        }
    }
    polynomial("kinetic coordinates", &data.curve, n, m)?;
    array("first_moment of the fields", &data.first_moment, 3 * n)?;
    array("moment_0 of the fields", &data.moment_0, 9 * n)?;
    tensor("moments of the fields", &data.moment, n, n, |component| component < 9, "3 row + column below 9")?;
    mirrored(data)?;
    array("stiffness of the Lagrangian", &data.stiffness, m * m)?;
    symmetric(&data.stiffness, m)?;
    let l = data.self_stress.len();
    if l > MAX_FIELDS {
        let (what, index) = ("number of self-stress coordinates".to_string(), 0);
        return Err(ModelError::Index { what, index, found: l, limit: MAX_FIELDS + 1 });
    }
    array("self_stress", &data.self_stress, l)?;
    polynomial("self-stress coordinates", &data.self_stress_curve, l, m)?;
    shape("curves of points", data.points.len(), n_points)?;
    for (index, point) in data.points.iter().enumerate() {
        polynomial(&format!("curve of point {index}"), point, 6, m)?;
    }
    array("range of the amplitudes", &data.range, m)?;
    positive("range of the amplitudes", &data.range)?;
    let sizes = [data.tolerance, data.dropped_norm];
    every("tolerance of the Lagrangian", &sizes, |x| x >= 0.0 && x.is_finite(), "zero or more")
}

pub(super) fn curve_validity(data: &CurveValidityData, m: usize, n_points: usize) -> Check {
    array("limits of the amplitudes", &data.limits, 3 * m)?;
    positive("limits of the amplitudes", &data.limits)?;
    for (mode, limits) in data.limits.chunks_exact(3).enumerate() {
        if !limits.is_sorted() {
            let (what, index) = ("limits of the amplitudes".to_string(), 3 * mode);
            return Err(ModelError::Order { what, index, expected: "ascending limits of each mode" });
        }
    }
    polynomial("dropped terms of the kinetic coordinates", &data.dropped, m, m)?;
    shape("dropped terms of points", data.points.len(), n_points)?;
    for (index, point) in data.points.iter().enumerate() {
        polynomial(&format!("dropped terms of point {index}"), point, 6, m)?;
    }
    Ok(())
}

pub(super) fn picture_curve(data: &PictureCurveData, nodes: usize, m: usize) -> Check {
    let shapes = data.shapes.len().checked_div(3 * nodes).unwrap_or(0);
    array("shapes of the picture curve", &data.shapes, 3 * nodes * shapes)?;
    polynomial("picture curve", &data.curve, shapes, m)
}

/// Every entry of the moments has its mirror image: without, the equations would not be those of an energy.
fn mirrored(data: &LagrangianData) -> Check {
    let moment = &data.moment;
    let key = |index: usize| Some((*moment.i.get(index)?, *moment.l.get(index)?, *moment.r.get(index)?));
    for (index, &found) in moment.value.iter().enumerate() {
        let Some((a, b, component)) = key(index) else { continue };
        let mirror = (b, a, 3 * (component % 3) + component / 3);
        let (mut low, mut high) = (0, moment.value.len());
        while low < high {
            let middle = (low + high) / 2;
            if key(middle).is_some_and(|key| key < mirror) { low = middle + 1 } else { high = middle }
        }
        if key(low) != Some(mirror) || moment.value.get(low) != Some(&found) {
            return Err(ModelError::Value {
                what: "moments of the fields".to_string(),
                index,
                found,
                expected: "the same as its mirror image (b, a, 3 column + row)",
            });
        }
    }
    Ok(())
}

fn symmetric(stiffness: &[f64], m: usize) -> Check {
    for row in 0..m {
        for column in 0..row {
            let at = |i: usize, j: usize| stiffness.get(m * i + j).copied().unwrap_or(0.0);
            if at(row, column) != at(column, row) {
                return Err(ModelError::Value {
                    what: "stiffness of the Lagrangian".to_string(),
                    index: m * row + column,
                    found: at(row, column),
                    expected: "a symmetric matrix",
                });
            }
        }
    }
    Ok(())
}

fn polynomial(what: &str, data: &PolynomialData, rows: usize, m: usize) -> Check {
    terms(&format!("quadratic terms of {what}"), &data.quadratic, rows, m)?;
    terms(&format!("cubic terms of {what}"), &data.cubic, rows, m)
}

fn terms<const N: usize>(what: &str, terms: &[(u32, [u32; N], f64)], rows: usize, m: usize) -> Check {
    for (index, (row, factors, value)) in terms.iter().enumerate() {
        finite_at(|| what.to_string(), index, *value)?;
        indices(&format!("row of {what}"), &[*row], rows)?;
        indices(&format!("factors of {what}"), factors, m)?;
    }
    let ascending = |factors: &[u32; N]| factors.windows(2).all(|pair| matches!(pair, [a, b] if a <= b));
    if let Some(index) = terms.iter().position(|(_, factors, _)| !ascending(factors)) {
        return Err(ModelError::Order { what: what.to_string(), index, expected: "ascending factors" });
    }
    let keys = terms.iter().map(|(row, factors, _)| (row, factors));
    if let Some(index) = keys.clone().zip(keys.skip(1)).position(|(a, b)| a >= b) {
        let expected = "terms sorted by row, then factors, without repetition";
        return Err(ModelError::Order { what: what.to_string(), index: index + 1, expected });
    }
    Ok(())
}
