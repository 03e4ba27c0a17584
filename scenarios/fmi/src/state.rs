//! State of an instance, to return to.

use coaxle_node::config::Wrong;
use serde::{Deserialize, Serialize};

use crate::mode::InstanceMode;
use crate::variable::UnitValue;

/// State of an instance: its parameters and all that it was given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InstanceState {
    /// Token of the unit that it belongs to.
    pub(crate) token: String,
    pub(crate) mode: InstanceMode,
    pub(crate) start_s: f64,
    /// Values in the order of the value references.
    pub(crate) values: Vec<UnitValue>,
    /// Parameters and inputs at the start of the unit.
    pub(crate) started_with: Vec<UnitValue>,
    /// Steps, as in a journal.
    pub(crate) steps: Vec<f64>,
}

impl InstanceState {
    /// Writes it as bytes.
    ///
    /// # Errors
    /// [`Wrong`]: more than the memory holds.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Wrong> {
        postcard::to_allocvec(self).map_err(|error| Wrong::with_reason("FMUState", error))
    }

    /// Reads it from bytes.
    ///
    /// # Errors
    /// [`Wrong`]: no bytes of a state.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Wrong> {
        postcard::from_bytes(bytes).map_err(|error| {
            let received = format!("{} bytes that are no state ({error})", bytes.len());
            Wrong::of(
                "serializedState",
                received,
                "those of fmi3SerializeFMUState",
            )
        })
    }
}
