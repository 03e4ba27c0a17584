//! The library of Coaxle's units: the C functions of FMI 3.0 over [`coaxle_fmi`].
//!
//! `docs/FMI.md` is its manual. What decides is in `coaxle_fmi`; here is the border: `instance` has the handle, the log and the guard
//! against panics, `memory` reads and writes what callers point to, `functions` and `values` are the functions of the standard, and
//! `absent` those of other interfaces, which are refused. All `unsafe` code of the units is in this crate.
#![allow(non_snake_case, reason = "names of the standard")]
#![allow(
    clippy::missing_safety_doc,
    reason = "the rules of the standard hold for all functions: valid pointers, one call of an instance at a time"
)]
#![allow(clippy::too_many_arguments, reason = "signatures of the standard")]

mod absent;
mod functions;
mod instance;
mod memory;
mod states;
mod values;

pub use absent::*;
pub use functions::*;
pub use states::*;
pub use values::*;
