//! Coaxle for Python: the module that `import coaxle` loads. `docs/PYTHON.md` is its manual, and `python/coaxle` its interface.
//! Here are the functions that need the tool's own code.
//!
//! Numbers cross as bytes, eight for each, which NumPy reads and writes without a copy; structures cross as JSON.

mod clock;
mod columns;
mod error;
mod follow;
mod motion;
mod network;
mod publish;
mod recording;
mod runs;

/// The module.
#[pyo3::pymodule]
mod _coaxle {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::clock::FarClock;
    #[pymodule_export]
    use super::error::CoaxleError;
    #[pymodule_export]
    use super::follow::Follower;
    #[pymodule_export]
    use super::motion::{Law, Plate, SawPlan, laws};
    #[pymodule_export]
    use super::network::Network;
    #[pymodule_export]
    use super::publish::Publisher;
    #[pymodule_export]
    use super::recording::read_recording;
    #[pymodule_export]
    use super::runs::{run, scenarios, sweep};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
