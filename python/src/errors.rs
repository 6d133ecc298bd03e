//! Exceptions. Their texts are those of the command-line tools.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyTypeError, PyValueError};
use pyo3::prelude::*;
use rom_generator::BuildError as RomBuildError;
use rom_generator::input::InputErrors;
use rom_runtime::StepError as RomStepError;
use rom_runtime::{FormatError, ModelError as RomModelError, SettingsError as RomSettingsError};

create_exception!(romgen, Error, PyException, "Base of all exceptions of this package.");
create_exception!(
    romgen,
    InputError,
    Error,
    "A structure or load file is wrong; one line per mistake, with its place."
);
create_exception!(romgen, BuildError, Error, "A reduced model could not be made of a structure.");
create_exception!(
    romgen,
    ModelError,
    Error,
    "A model file or its contents, or a name that the model does not have."
);
create_exception!(
    romgen,
    SettingsError,
    Error,
    "Settings of a simulation out of range, or a state that does not fit."
);
create_exception!(
    romgen,
    StepError,
    Error,
    "A step could not be made; the state is the one before it. Raised by a run, it carries what was recorded in `results`."
);

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("Error", py.get_type::<Error>())?;
    module.add("InputError", py.get_type::<InputError>())?;
    module.add("BuildError", py.get_type::<BuildError>())?;
    module.add("ModelError", py.get_type::<ModelError>())?;
    module.add("SettingsError", py.get_type::<SettingsError>())?;
    module.add("StepError", py.get_type::<StepError>())
}

pub(crate) fn input(errors: &InputErrors) -> PyErr {
    InputError::new_err(errors.to_string())
}

pub(crate) fn build(error: &RomBuildError) -> PyErr {
    BuildError::new_err(error.to_string())
}

pub(crate) fn format(error: &FormatError) -> PyErr {
    ModelError::new_err(error.to_string())
}

pub(crate) fn model(error: &RomModelError) -> PyErr {
    ModelError::new_err(error.to_string())
}

pub(crate) fn settings(error: &RomSettingsError) -> PyErr {
    SettingsError::new_err(error.to_string())
}

pub(crate) fn step(error: &RomStepError) -> PyErr {
    StepError::new_err(error.to_string())
}

/// A name that the model does not have.
pub(crate) fn missing(message: String) -> PyErr {
    ModelError::new_err(message)
}

/// No steady state.
pub(crate) fn unsteady(message: String) -> PyErr {
    Error::new_err(message)
}

/// An argument of the right type with a value that cannot be.
pub(crate) fn value(message: impl Into<String>) -> PyErr {
    PyValueError::new_err(message.into())
}

/// An argument of the wrong type.
pub(crate) fn kind(message: impl Into<String>) -> PyErr {
    PyTypeError::new_err(message.into())
}
