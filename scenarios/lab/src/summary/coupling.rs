//! Figures of a slave's coupling and release.

use schemars::JsonSchema;
use serde::Serialize;

/// The last synchronisation of a slave, and its last release by a flying gear.
///
/// Both are seen in whole cycles: a synchronisation begins with the cycle before its first one,
/// where a saw is coupled, and ends with the first cycle in sync. So times and ways may be a cycle's
/// more than the true ones, and two cycles' where the master begins it by passing a position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct CouplingSummary {
    /// Number of times that it came in sync.
    pub synchronisations: u64,
    /// Duration of the last synchronisation, s.
    pub sync_duration_s: Option<f64>,
    /// Way of the master during it, u of the master.
    pub sync_master_way: Option<f64>,
    /// Way of the slave during it, u.
    pub sync_slave_way: Option<f64>,
    /// Position of the master at its end, u of the master.
    pub sync_master_position: Option<f64>,
    /// Position of the slave at its end, u.
    pub sync_slave_position: Option<f64>,
    /// Lowest position of the slave during it, u.
    pub sync_position_min: Option<f64>,
    /// Highest position of the slave during it, u.
    pub sync_position_max: Option<f64>,
    /// Way of the master during the last release, u of the master.
    pub release_master_way: Option<f64>,
    /// Way of the slave during it, u.
    pub release_slave_way: Option<f64>,
    /// Position of the master at its end, u of the master.
    pub release_master_position: Option<f64>,
    /// Position of the slave at its end, u.
    pub release_slave_position: Option<f64>,
}
