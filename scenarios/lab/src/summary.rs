//! Results of a run: `summary.json`.

mod coupling;
mod cuts;
mod last;
mod router;

use std::collections::BTreeMap;

use coaxle_node::config::Unit;
use coaxle_receiver::signals::SlaveSignals;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use coupling::CouplingSummary;
pub use cuts::{Cut, CutsSummary};
pub use last::LastSignals;
pub use router::{RouterLinkSummary, RouterSummary};

use crate::verdict::Verdict;

/// Figures of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The scenario's name.
    pub scenario: String,
    /// Title of the scenario.
    pub title: String,
    /// `virtual` or `processes`.
    pub world: World,
    /// The seed.
    pub seed: u64,
    /// Intended duration, s of true time.
    pub duration_s: f64,
    /// Time of an early end, s; figures cover the time before it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interrupted_at_s: Option<f64>,
    /// Figures of each receiver, by its name.
    pub receivers: BTreeMap<String, ReceiverSummary>,
    /// Figures of each router, by its name; in virtual time alone.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub routers: BTreeMap<String, RouterSummary>,
    /// Outcome of each expectation.
    pub expectations: Vec<Verdict>,
}

impl Summary {
    /// The expectations that failed.
    pub fn failed(&self) -> impl Iterator<Item = &Verdict> {
        self.expectations.iter().filter(|verdict| !verdict.met)
    }
}

/// World in which a scenario runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum World {
    /// In virtual time.
    Virtual,
    /// As real processes over real Zenoh.
    Processes,
}

impl World {
    /// Returns the name in configs and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Virtual => "virtual",
            Self::Processes => "processes",
        }
    }
}

/// Figures of one receiver. Those of motion are in units of its master axis, and taken over
/// the time after it first synchronised, or from 100 cycles after its first data where its mode
/// never does.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct ReceiverSummary {
    /// `bypass`, `pt1`, `time`, `sync` or `observer`.
    pub mode: &'static str,
    /// Followed axis: node, channel, axis id.
    pub master: String,
    /// Unit of that axis: the meaning of `u` here.
    pub unit: Unit,
    /// Cycles run.
    pub cycles: u64,
    /// Signals of the last cycle.
    #[serde(flatten)]
    #[schemars(skip)]
    pub last: LastSignals,
    /// Cycles that the node before it skipped itself: no message of those was ever sent. They are not among `lost` here.
    pub skipped_by_sender: u64,
    /// Times an error was raised.
    pub errors: u64,
    /// The last error's code, such as `0x4b52`; null if there was none.
    pub last_error: Option<String>,
    /// Times a warning was raised.
    pub warnings: u64,
    /// From the first data to the first cycle in sync, s; null if never.
    pub time_to_sync_s: Option<f64>,
    /// Beats counted at that moment.
    pub beats_at_sync: Option<u32>,
    /// Number of times that synchronisation was reached.
    pub synced_times: u64,
    /// True if it was in sync at the end.
    pub synced_at_end: bool,
    /// The true drift of the sender's clock, over the last seconds, ppm; positive when it is the faster one.
    pub drift_ppm_true: Option<f64>,
    /// Times at which the observer noticed jumps of the delay, s after the start.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shift_times_s: Vec<f64>,
    /// Times at which another node took over, s after the start.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub take_over_times_s: Vec<f64>,
    /// Times at which the observer restarted its lock, s after the start.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub relock_times_s: Vec<f64>,
    /// Error of the delay, with the ripple of the far time, µs: the mean over the time that
    /// the lag errors below are taken over.
    pub delay_error_us: Option<f64>,
    /// Share of the cycles of that time in which the uncertainty covered the error.
    pub delay_covered_share: Option<f64>,
    /// Beginning of the evaluation, s after the start; null if there was nothing to evaluate.
    pub evaluated_from_s: Option<f64>,
    /// Cycles evaluated.
    pub evaluated_cycles: u64,
    /// Difference quotient of the set position given to the drive, minus the true master velocity:
    /// root mean square, u/s.
    pub velocity_ripple_rms: Option<f64>,
    /// Largest magnitude of that, u/s.
    pub velocity_ripple_max: Option<f64>,
    /// The largest ripple divided by the largest master velocity.
    pub velocity_ripple_ratio: Option<f64>,
    /// The root mean square once it had been in sync for a second without a break, u/s; with a mode
    /// that never synchronises, over the whole evaluation. Likewise for all figures called settled.
    pub velocity_ripple_settled_rms: Option<f64>,
    /// The largest magnitude then, u/s.
    pub velocity_ripple_settled_max: Option<f64>,
    /// The largest settled ripple divided by the largest master velocity.
    pub velocity_ripple_settled_ratio: Option<f64>,
    /// Largest magnitude while it locked in, the first time and every time after, u/s.
    pub velocity_ripple_lock_in_max: Option<f64>,
    /// Corrected far time minus true far time, mean removed: root mean square, µs.
    pub corrected_time_error_rms_us: Option<f64>,
    /// Largest magnitude of that, µs.
    pub corrected_time_error_max_us: Option<f64>,
    /// The root mean square once settled, without the mean of that time, µs.
    pub corrected_time_error_settled_rms_us: Option<f64>,
    /// The largest magnitude then, µs.
    pub corrected_time_error_settled_max_us: Option<f64>,
    /// The largest distance from that mean before it was settled, µs.
    pub corrected_time_error_lock_in_max_us: Option<f64>,
    /// Mean lag of the corrected far time behind the true one, µs.
    pub lag_us: Option<f64>,
    /// Largest distance of the far axis from its master's position at one true instant, in motion and at rest, u.
    /// Taken over the time in which the receiver had been in sync for a second, as the lag errors are.
    pub far_position_error_max: Option<f64>,
    /// Root mean square of that, u.
    pub far_position_error_rms: Option<f64>,
    /// Largest distance of the far axis from where its master was at the instant that it shows, u: the error of the
    /// clock, times the velocity, is taken out.
    pub far_motion_error_max: Option<f64>,
    /// Largest distance of the slave's set position from the master's position at one true instant,
    /// in units of the master. This one and the next two are taken over the time in which the receiver
    /// had been in sync for a second.
    pub lag_error_max: Option<f64>,
    /// Largest such distance in µs of travel: divided by the master's velocity, where that is at least a tenth of its
    /// highest.
    pub lag_error_max_us: Option<f64>,
    /// Root mean square of that, µs.
    pub lag_error_rms_us: Option<f64>,
    /// Largest distance of the drive from the slave position by the master's true position, lag
    /// included, in slave units.
    pub drive_position_error_max: Option<f64>,
    /// Largest distance of what the drive is given from that position, without the drive's own lag, in slave units. Of a simulated drive
    /// with a dead time, that of what it follows by now.
    pub shown_position_error_max: Option<f64>,
    /// Largest following error of the drive, slave units.
    pub following_error_max: f64,
    /// True if the drive tripped.
    pub drive_tripped: bool,
    /// Largest delay from the ideal start of a cycle to its scan, µs.
    pub wake_up_max_us: f64,
    /// Age of the newest frame at the scan: what 1 % of the cycles are below, µs. Where the cycle is to be locked, this one and the next three are taken over the time in which
    /// it has been for ten seconds.
    pub frame_age_p1_us: Option<f64>,
    /// The median, µs.
    pub frame_age_p50_us: Option<f64>,
    /// Age that 1 % of the cycles exceed, µs.
    pub frame_age_p99_us: Option<f64>,
    /// The last minus the first of these, µs.
    pub frame_age_spread_us: Option<f64>,
    /// Figures of each slave, by its name. The slave in figures above is the first one.
    #[schemars(skip)]
    pub slaves: BTreeMap<String, SlaveSummary>,
}

/// Figures of one slave, by its signals.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct SlaveSummary {
    /// Unit of its position: the meaning of `u` here.
    pub unit: Unit,
    /// Signals of the last cycle.
    #[serde(flatten, serialize_with = "last::summarized")]
    #[schemars(skip)]
    pub last: SlaveSignals,
    /// Times it went to error stop.
    pub errors: u64,
    /// Code of the last error, such as `0x42a0`; null if there was none.
    pub last_error: Option<String>,
    /// The code of the last refusal of a command; null if there was none.
    pub last_refusal: Option<String>,
    /// Share of the cycles in which its coupling was in sync.
    pub in_sync_share: f64,
    /// Largest step of the set position beyond what the set velocity accounts for, u. This one and
    /// the next two are taken while it moves, or is coupled.
    pub position_jump_max: f64,
    /// Largest set velocity, u/s.
    pub velocity_max: f64,
    /// Largest change of the set velocity from cycle to cycle, u/s².
    pub acceleration_max: f64,
    /// Largest difference of two set positions, as a share of the limit of its velocity.
    pub velocity_share_max: Option<f64>,
    /// Likewise the second difference, of the larger of acceleration and deceleration.
    pub acceleration_share_max: Option<f64>,
    /// Likewise the third difference, of the jerk.
    pub jerk_share_max: Option<f64>,
    /// Largest following error of its drive, u.
    pub following_error_max: f64,
    /// Coupling and release.
    #[serde(flatten)]
    pub coupling: CouplingSummary,
    /// Cuts.
    #[serde(flatten)]
    pub cuts: CutsSummary,
}
