//! Errors as Python receives them.

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

pyo3::create_exception!(
    _coaxle,
    CoaxleError,
    PyValueError,
    "What was received and what is expected, as the tool says it."
);

/// An error with its causes.
pub(crate) fn told(error: impl Into<anyhow::Error>) -> PyErr {
    // The alternate form has the whole chain of causes in one line.
    CoaxleError::new_err(format!("{:#}", error.into()))
}

/// An error in words.
pub(crate) fn wrong(words: impl std::fmt::Display) -> PyErr {
    CoaxleError::new_err(words.to_string())
}
