//! Numbers across the boundary.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::errors;

/// A copy of a vector - (n).
pub(crate) fn vector<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, values)
}

/// A row-major matrix - (rows x columns).
pub(crate) fn matrix<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    columns: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    PyArray1::from_vec(py, values).reshape([rows, columns])
}

/// The entries of anything NumPy takes for an array of floats, row by row, when it has the shape wanted; `None` in `shape` fits
/// any length.
pub(crate) fn entries(
    what: &str,
    object: &Bound<'_, PyAny>,
    shape: &[Option<usize>],
) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let numpy = object.py().import("numpy")?;
    let array = numpy.call_method1("ascontiguousarray", (object, "float64"))?;
    let array: PyReadonlyArrayDyn<'_, f64> = array.extract()?;
    let found = array.shape().to_vec();
    // A scalar becomes an array of one entry there.
    let fits = found.len() == shape.len()
        && found.iter().zip(shape).all(|(found, wanted)| wanted.is_none_or(|wanted| wanted == *found));
    if !fits {
        let words: Vec<String> = shape.iter().map(|n| n.map_or("any".into(), |n| n.to_string())).collect();
        return Err(errors::value(format!("{what} has shape {found:?}, expected ({})", words.join(", "))));
    }
    Ok((array.as_slice()?.to_vec(), found))
}

/// A vector of known length.
pub(crate) fn fixed<const N: usize>(what: &str, object: &Bound<'_, PyAny>) -> PyResult<[f64; N]> {
    let (values, _) = entries(what, object, &[Some(N)])?;
    values.try_into().map_err(|_| errors::value(format!("{what} needs {N} numbers")))
}

/// Refuses what is not finite.
pub(crate) fn finite(what: &str, values: &[f64]) -> PyResult<()> {
    match values.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(at) => {
            Err(errors::value(format!("{what} holds {} at entry {at}, expected finite numbers", values[at])))
        }
    }
}
