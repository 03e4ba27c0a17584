//! How a slave is coupled and released, in figures.

use schemars::JsonSchema;
use serde::Serialize;

/// The last synchronisation of a slave, and its last release by a flying gear.
///
/// Both are seen in whole cycles: a synchronisation begins with the cycle before its first one,
/// where a saw is coupled, and ends with the first cycle in sync. So times and ways may be a cycle's
/// more than they are, and two cycles' where the master begins it by passing a position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct CouplingSummary {
    /// Times that it came in sync.
    pub synchronisations: u64,
    /// How long the last one took, s.
    pub sync_duration_s: Option<f64>,
    /// The way of its master over it, u of the master.
    pub sync_master_way: Option<f64>,
    /// Its own way over it, u.
    pub sync_slave_way: Option<f64>,
    /// Where its master was when it came in sync, u of the master.
    pub sync_master_position: Option<f64>,
    /// Where it was itself then, u.
    pub sync_slave_position: Option<f64>,
    /// Its lowest position over it, u.
    pub sync_position_min: Option<f64>,
    /// Its highest position over it, u.
    pub sync_position_max: Option<f64>,
    /// The way of its master over its last release, u of the master.
    pub release_master_way: Option<f64>,
    /// Its own way over it, u.
    pub release_slave_way: Option<f64>,
    /// Where its master was when it was released, u of the master.
    pub release_master_position: Option<f64>,
    /// Where it was itself then, u.
    pub release_slave_position: Option<f64>,
}
