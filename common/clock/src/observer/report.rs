//! Output of the observer.

use super::output::FarTime;
use crate::instant::{Instant, Local, Seconds};

/// State of the observer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ObserverState {
    /// Too few messages to say anything.
    #[default]
    Startup,
    /// A far time that is not yet sure, and may still move fast.
    Locking,
    /// The far time is sure.
    Synced,
    /// A far time that was sure, and is followed on, but is uncertain by more than twice what is good enough, or is so
    /// far from where it should be that making that up takes longer than ten seconds.
    Unsure,
    /// No messages lately: going on by the last estimate.
    Holdover,
    /// No messages for too long.
    Lost,
}

/// Line of the phases that the far time follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ObserverLine {
    /// Line of all messages: their delays are independent, as far as can be seen.
    #[default]
    AllMessages,
    /// The lower edge of the phases: delays are correlated, as between processes on busy machines.
    LowerEdge,
    /// Line of the time exchanges: delays wander, both ways alike.
    TwoWay,
}

/// Output of one cycle of [`PhaseObserver`](super::PhaseObserver).
#[must_use]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObserverOutput {
    /// State of the observer.
    pub state: ObserverState,
    /// Line that is followed.
    pub line: ObserverLine,
    /// The far time now. None in start-up. Strictly monotone from then on, through everything.
    pub far_time: Option<FarTime>,
    /// The far clock's rate against the own, ppm; negative when the sender's cycle is the longer one.
    pub drift_ppm: f64,
    /// Standard deviation of the drift, ppm.
    pub drift_sigma_ppm: f64,
    /// Standard deviation of the estimated offset, s. In the first seconds it includes what is not known as yet:
    /// whether messages will come earlier.
    pub offset_sigma: Seconds,
    /// The part of its own predictions of one and of four seconds before that the line was within three standard deviations
    /// of, in the last two minutes: 0.99 and more where it is as sure as it says. None before there were any.
    pub within_three_sigma: Option<f64>,
    /// The estimate minus the far time shown: what is still to be slewed, s.
    pub slew_remaining: Seconds,
    /// Messages per measurement.
    pub block_length: u16,
    /// The random walk of the drift that predicts best, ppm/√s.
    pub random_walk_ppm: f64,
    /// Lead of the far time over the one that lags by exactly the least delay, s: the first messages fix what counts
    /// as no jitter, and learning the jitter better afterwards does not move the far time. To have no lag at all,
    /// take this from the delay that is set.
    pub lead: Seconds,
    /// Measured standard deviation of the normal part of the jitter, s.
    pub normal_jitter: Seconds,
    /// Measured mean of the exponential part of the jitter, s.
    pub exponential_jitter: Seconds,
    /// Jumps of the delay (or of the sender) so far.
    pub shifts: u32,
    /// Time when the last of them was noticed.
    pub last_shift: Option<Instant<Local>>,
    /// Number of changes of the sender's drift after which the line was found again.
    pub drift_steps: u32,
    /// Number of restarts of locking: after a restarted or lost sender.
    pub relocks: u32,
    /// Time of the last restart.
    pub last_relock: Option<Instant<Local>>,
    /// Number of times that counts got another map to far time: see
    /// [`far_time_of`](super::PhaseObserver::far_time_of).
    pub rebases: u32,
    /// True if that happened since the previous cycle.
    pub rebased: bool,
}
