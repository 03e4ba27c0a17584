//! Requests of a node to its operating system.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Real-time requests. Those that are not permitted are skipped with a warning that gives the reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct RealTimeConfig {
    /// `SCHED_FIFO` priority of the cycle thread, 1 to 99; without one the normal scheduler
    /// applies. The threads that stamp, send and receive frames get the next lower one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub priority: Option<u8>,
    /// The processor the cycle thread is bound to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cpu: Option<usize>,
    /// Keep all memory in RAM.
    pub lock_memory: bool,
    /// Spin for the last microseconds before each cycle instead of sleeping.
    pub spin_us: u32,
}
