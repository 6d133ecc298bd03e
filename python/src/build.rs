//! From a structure file to a model.

use std::path::PathBuf;

use pyo3::exceptions::{PyRuntimeWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyString};
use rom_cli::options;
use rom_generator::build::ModeSelection;
use rom_generator::input::{self, Structure};
use rom_generator::{Reduction, ResidualSelection};
use toml::{Table, Value};

use crate::errors;
use crate::model::Model;

/// Builds the reduced model of a structure. What is not given of modes, residual, inertia and elastic is as its table ``[reduction]``
/// says, else the default.
///
/// Args:
///     structure: path of a structure file, its text (anything with a line break), or the same as a dict.
///     modes: how many of the lowest elastic modes, a list of their numbers from 1, or a frequency limit such as ``"15Hz"`` or
///         ``"90rad/s"`` (else 10).
///     residual: names of points whose static response to loads residual modes are to complete, ``"all"`` that carry loads, or
///         ``"none"`` (else the default).
///     parameters: values of parameters of the structure, as numbers or expressions (``--set`` of the command line).
///     all_nodes: keep the mode shapes at every node, for pictures.
///     inertia: mass matrix, ``"constant"`` (else the default) or ``"consistent"`` (that of the deformed body).
///     elastic: elastic forces, ``"linear"`` (else the default) or ``"geometric"`` (large deflections, with consistent inertia).
///
/// Raises:
///     InputError: for a structure that is wrong.
///     BuildError: for one that cannot be reduced.
///
/// Warns:
///     RuntimeWarning: for a check of the model that is not passed.
#[pyfunction]
#[pyo3(signature = (structure, *, modes = None, residual = None, parameters = None, all_nodes = false, inertia = None, elastic = None))]
#[allow(clippy::too_many_arguments)] // keywords of Python
pub(crate) fn build(
    py: Python<'_>,
    structure: &Bound<'_, PyAny>,
    modes: Option<&Bound<'_, PyAny>>,
    residual: Option<&Bound<'_, PyAny>>,
    parameters: Option<&Bound<'_, PyDict>>,
    all_nodes: bool,
    inertia: Option<&str>,
    elastic: Option<&str>,
) -> PyResult<Model> {
    let inertia = inertia.map(str::parse).transpose().map_err(PyValueError::new_err)?;
    let elastic = elastic.map(str::parse).transpose().map_err(PyValueError::new_err)?;
    let (text, name) = text(structure)?;
    let structure =
        Structure::from_toml_str(&text, &name, &assignments(parameters)?).map_err(|e| errors::input(&e))?;
    let (modes, residual) = (modes.map(selection).transpose()?, residual.map(points).transpose()?);
    let asked = Reduction { modes, residual, inertia, elastic };
    let options = asked.or(structure.reduction()).options(all_nodes);
    let data = py
        .detach(|| rom_generator::build::build(&structure, &options, &mut |_| ()))
        .map_err(|e| errors::build(&e))?;
    let model = rom_runtime::Model::new(data).map_err(|e| errors::model(&e))?;
    for check in &model.data().checks {
        if check.value.is_nan() || check.value > check.limit {
            let text = format!(
                "check not passed, do not trust the model: {}: {:e}, limit {:e}",
                check.name, check.value, check.limit
            );
            let text = std::ffi::CString::new(text.replace('\0', " "))?;
            PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 1)?;
        }
    }
    Ok(Model::new(model))
}

/// JSON Schema of the structure file.
#[pyfunction]
pub(crate) fn schema() -> String {
    input::schema()
}

/// The TOML text of a path, of a text (which has more than one line), or of a dict; and what to call it in messages.
pub(crate) fn text(source: &Bound<'_, PyAny>) -> PyResult<(String, String)> {
    if let Ok(dict) = source.cast::<PyDict>() {
        let table = table(dict, "")?;
        let text =
            toml::to_string(&table).map_err(|e| errors::value(format!("no TOML can hold this dict: {e}")))?;
        return Ok((text, "dict".into()));
    }
    if let Ok(text) = source.cast::<PyString>() {
        let text = text.to_str()?;
        if text.contains('\n') {
            return Ok((text.into(), "text".into()));
        }
    }
    let path: PathBuf = source
        .extract()
        .map_err(|_| errors::kind("expected the path of a TOML file, its text, or a dict"))?;
    Ok((input::read_text(&path).map_err(|e| errors::input(&e))?, path.display().to_string()))
}

/// Parameters as the `--set` of the command line: numbers, or expressions.
pub(crate) fn assignments(parameters: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<(String, String)>> {
    let Some(parameters) = parameters else { return Ok(Vec::new()) };
    let pair = |(name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let value = match value.extract::<String>() {
            Ok(expression) => expression,
            // Rust writes every number so that it reads back to the same bits.
            Err(_) => value.extract::<f64>()?.to_string(),
        };
        Ok((name.extract()?, value))
    };
    parameters.iter().map(pair).collect()
}

/// `10`, `[1, 2, 5]`, or the words of the command line (`"15Hz"`).
fn selection(modes: &Bound<'_, PyAny>) -> PyResult<ModeSelection> {
    if let Ok(count) = modes.extract::<usize>() {
        return Ok(ModeSelection::Count(count));
    }
    if let Ok(text) = modes.extract::<String>() {
        return options::modes(&text).map_err(|e| errors::value(format!("modes: {e}")));
    }
    modes.extract::<Vec<usize>>().map(ModeSelection::List).map_err(|_| {
        errors::kind("modes: expected a count (10), a list ([1, 2, 5]) or a frequency limit (\"60Hz\")")
    })
}

/// `["P", "Q"]`, or the words of the command line (`"all"`, `"P,Q"`).
fn points(residual: &Bound<'_, PyAny>) -> PyResult<ResidualSelection> {
    if let Ok(text) = residual.extract::<String>() {
        return options::residual(&text).map_err(|e| errors::value(format!("residual: {e}")));
    }
    residual
        .extract::<Vec<String>>()
        .map(ResidualSelection::Points)
        .map_err(|_| errors::kind("residual: expected names of points ([\"P\", \"Q\"]) or \"all\""))
}

fn table(dict: &Bound<'_, PyDict>, place: &str) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, value) in dict {
        let key: String =
            key.extract().map_err(|_| errors::kind(format!("key {key} of {{{place}}} is no text")))?;
        let place = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
        table.insert(key, toml_value(&value, &place)?);
    }
    Ok(table)
}

fn toml_value(value: &Bound<'_, PyAny>, place: &str) -> PyResult<Value> {
    if let Ok(dict) = value.cast::<PyDict>() {
        return table(dict, place).map(Value::Table);
    }
    if value.is_instance_of::<PyString>() {
        return Ok(Value::String(value.extract()?));
    }
    // A bool is an int in Python, so it comes first.
    if value.is_instance_of::<PyBool>() {
        return Ok(Value::Boolean(value.extract()?));
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(Value::Integer(value.extract()?));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(value.extract()?));
    }
    // Arrays and scalars of NumPy.
    if let Ok(plain) = value.call_method0("tolist") {
        return toml_value(&plain, place);
    }
    match value.try_iter() {
        Ok(items) => {
            let list = items.enumerate().map(|(i, item)| toml_value(&item?, &format!("{place}[{i}]")));
            list.collect::<PyResult<_>>().map(Value::Array)
        }
        Err(_) => Err(errors::kind(format!(
            "{place} is {}, expected a number, text, list or dict",
            value.get_type().name()?
        ))),
    }
}
