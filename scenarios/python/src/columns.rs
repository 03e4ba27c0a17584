//! Columns of numbers, as bytes in the order of the machine.

use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::wrong;

/// Numbers out.
pub(crate) fn bytes_of<'py, const N: usize, T: Copy>(
    py: Python<'py>,
    numbers: &[T],
    bytes: impl Fn(T) -> [u8; N],
) -> Bound<'py, PyBytes> {
    let all: Vec<u8> = numbers.iter().flat_map(|number| bytes(*number)).collect();
    PyBytes::new(py, &all)
}

/// Numbers out, in double precision.
pub(crate) fn f64s<'py>(py: Python<'py>, numbers: &[f64]) -> Bound<'py, PyBytes> {
    bytes_of(py, numbers, f64::to_ne_bytes)
}

/// Numbers in, in double precision.
///
/// # Errors
/// Bytes that are no such numbers.
pub(crate) fn numbers(bytes: &[u8]) -> PyResult<Vec<f64>> {
    // Native byte order: NumPy on the same machine reads and writes it without conversion.
    let (all, rest) = bytes.as_chunks::<8>();
    if !rest.is_empty() {
        return Err(wrong(format!(
            "received {} bytes, expected eight for each number",
            bytes.len()
        )));
    }
    Ok(all.iter().copied().map(f64::from_ne_bytes).collect())
}
