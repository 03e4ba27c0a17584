//! One receiver cycle as a flat row: what trace files hold and measurements are made from.

mod slave;

use coaxle_clock::delay::DelayState;
use coaxle_clock::observer::ObserverState;
use coaxle_clock::{Instant, Remote, Seconds};
use coaxle_motion::drive::DriveState;
use coaxle_motion::remote::FilterState;
use serde::{Deserialize, Serialize};

pub use slave::SlaveRecord;

use crate::snapshot::ReceiverSnapshot;

/// A row of a receiver's trace. Instants are nanoseconds of the world's reference clock: true time
/// in the pretend world, the machine's monotonic clock in the real one.
///
/// In a file the columns of the slaves come last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReceiverRecord {
    /// Ideal start of the cycle, ns.
    pub at_ns: i64,
    /// When the scan really began, ns.
    pub woke_ns: i64,
    /// Cycle number, skipped ones counted.
    pub cycle: u64,
    /// Cycles skipped so far.
    pub overruns: u64,
    /// The node's own opinion of itself.
    pub health: HealthName,
    /// The mode that made the set values; none before the first message.
    pub state: Option<StateName>,
    /// Whether the far clock is known.
    pub synced: bool,
    /// The manual's error code, 0: none.
    pub error: u16,
    /// The manual's warning code, 0: none.
    pub warning: u16,
    /// Beats so far.
    pub beats: u32,
    /// The sender's run.
    pub epoch: Option<u64>,
    /// The sender's count in the input image.
    pub count: Option<u64>,
    /// The cycle index in the input image.
    pub index: Option<u16>,
    /// Own cycles since the input image was renewed.
    pub age_cycles: u32,
    /// Received set position, master units.
    pub received_position: Option<f64>,
    /// Received set velocity, master units/s.
    pub received_velocity: Option<f64>,
    /// Corrected set position, master units.
    pub corrected_position: Option<f64>,
    /// Corrected set velocity, master units/s.
    pub corrected_velocity: Option<f64>,
    /// Correction time, µs; none where the mode uses none.
    pub correction_us: Option<f64>,
    /// The instant of the sender's ideal time that the set values stand for, ns.
    pub far_time_ns: Option<i64>,
    /// Estimated drift, ppm.
    pub drift_ppm: Option<f64>,
    /// How far the phase observer is; none in other modes.
    pub observer: Option<ObserverState>,
    /// Its own standard deviation of the offset, µs.
    pub offset_sigma_us: Option<f64>,
    /// Its own standard deviation of the drift, ppm.
    pub drift_sigma_ppm: Option<f64>,
    /// The random walk of the drift that predicts best, ppm/√s.
    pub random_walk_ppm: Option<f64>,
    /// Messages per measurement.
    pub block_length: Option<u16>,
    /// Jumps of the delay that it noticed so far.
    pub shifts: u32,
    /// Times it began to lock anew.
    pub relocks: u32,
    /// Where the delay comes from; none in other modes.
    pub delay: Option<DelayState>,
    /// How far the sender's time is taken to be ahead of the observer's line, µs.
    pub delay_us: Option<f64>,
    /// That is wrong by at most this, µs.
    pub delay_uncertainty_us: Option<f64>,
    /// Exchanges of a question and an answer so far.
    pub exchanges: u64,
    /// Answers refused so far.
    pub answers_refused: u64,
    /// Accepted messages so far.
    pub received: u64,
    /// Missing messages so far.
    pub lost: u64,
    /// Repeated messages so far.
    pub duplicates: u64,
    /// Overtaken messages so far.
    pub late: u64,
    /// Messages too old to use so far.
    pub stale: u64,
    /// Refused frames so far.
    pub rejected: u64,
    /// New runs of the sender so far.
    pub restarts: u64,
    /// The first slave.
    pub slave: SlaveRecord,
    /// The other slaves.
    #[serde(default)]
    pub others: Vec<SlaveRecord>,
}

macro_rules! named {
    ($(#[$meta:meta])* $name:ident { $($(#[$doc:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        pub enum $name {
            $($(#[$doc])* #[serde(rename = $text)] $variant,)*
        }

        impl $name {
            /// The name, as traces and reports spell it.
            #[must_use]
            pub const fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)*
                }
            }
        }
    };
}

named! {
    /// The mode that made the set values.
    StateName {
        /// As received.
        Bypass = "bypass",
        /// Through the PT1 filter.
        Pt1 = "pt1",
        /// Extrapolated in sync mode.
        Sync = "sync",
        /// Extrapolated in time mode.
        Time = "time",
        /// Extrapolated by the phase observer.
        Observer = "observer",
    }
}

named! {
    /// The drive's state.
    DriveStateName {
        /// No power.
        Off = "off",
        /// It follows.
        Following = "following",
        /// It tripped.
        Tripped = "tripped",
    }
}

named! {
    /// The node's own opinion of itself.
    HealthName {
        /// Nothing heard of the master.
        WaitingForMaster = "waiting-for-master",
        /// The far clock is not known yet.
        StartingUp = "starting-up",
        /// All is well.
        Ok = "ok",
        /// Nothing new for too long.
        MasterSilent = "master-silent",
        /// An error is latched.
        Error = "error",
        /// The cycle times do not fit.
        CycleTimesDoNotFit = "cycle-times-do-not-fit",
        /// A drive tripped.
        DriveTripped = "drive-tripped",
        /// A slave is in error stop.
        SlaveFailed = "slave-failed",
        /// What its config has a slave do was refused.
        CommandRefused = "command-refused",
    }
}

impl From<FilterState> for StateName {
    fn from(state: FilterState) -> Self {
        match state {
            FilterState::Bypass => Self::Bypass,
            FilterState::Pt1 => Self::Pt1,
            FilterState::Sync => Self::Sync,
            FilterState::Time => Self::Time,
            FilterState::Observer => Self::Observer,
        }
    }
}

impl Default for DriveStateName {
    fn default() -> Self {
        DriveState::default().into()
    }
}

impl From<DriveState> for DriveStateName {
    fn from(state: DriveState) -> Self {
        match state {
            DriveState::Off => Self::Off,
            DriveState::Following => Self::Following,
            DriveState::Tripped => Self::Tripped,
        }
    }
}

impl ReceiverRecord {
    /// The names of all fields but those of the slaves, in their order.
    const COLUMNS: [&'static str; 40] = [
        "at_ns",
        "woke_ns",
        "cycle",
        "overruns",
        "health",
        "state",
        "synced",
        "error",
        "warning",
        "beats",
        "epoch",
        "count",
        "index",
        "age_cycles",
        "received_position",
        "received_velocity",
        "corrected_position",
        "corrected_velocity",
        "correction_us",
        "far_time_ns",
        "drift_ppm",
        "observer",
        "offset_sigma_us",
        "drift_sigma_ppm",
        "random_walk_ppm",
        "block_length",
        "shifts",
        "relocks",
        "delay",
        "delay_us",
        "delay_uncertainty_us",
        "exchanges",
        "answers_refused",
        "received",
        "lost",
        "duplicates",
        "late",
        "stale",
        "rejected",
        "restarts",
    ];

    /// The columns of a trace of a receiver with slaves of these names. Those of all slaves but
    /// the first have the slave's name in front.
    #[must_use]
    pub fn columns<'a>(slaves: impl IntoIterator<Item = &'a str>) -> Vec<String> {
        let named = |(n, name): (usize, &'a str)| {
            SlaveRecord::COLUMNS.map(|column| match n {
                0 => column.to_owned(),
                _ => format!("{name}.{column}"),
            })
        };
        let slaves = slaves.into_iter().enumerate().flat_map(named);
        let own = Self::COLUMNS.map(str::to_owned);
        own.into_iter().chain(slaves).collect()
    }

    /// All slaves, in the order of the config.
    pub fn slaves(&self) -> impl Iterator<Item = &SlaveRecord> {
        std::iter::once(&self.slave).chain(&self.others)
    }

    /// The row of a cycle whose ideal start and wake-up the world dates in its own clock.
    #[must_use]
    pub fn new(at_ns: i64, woke_ns: i64, snapshot: &ReceiverSnapshot) -> Self {
        let master = snapshot.master.as_ref();
        let observer = snapshot.observer.as_ref();
        let delay = snapshot.delay.as_ref();
        let counters = &snapshot.counters;
        let mut slaves = snapshot.slaves().map(SlaveRecord::new);
        Self {
            at_ns,
            woke_ns,
            cycle: snapshot.cycle,
            overruns: snapshot.overruns,
            health: snapshot.health.name(),
            state: master.map(|m| m.state.into()),
            synced: master.is_some_and(|m| m.synced),
            error: master.and_then(|m| m.error).map_or(0, |e| e.code()),
            warning: master.and_then(|m| m.warning).map_or(0, |w| w.code()),
            beats: master.map_or(0, |m| m.beats),
            epoch: master.map(|m| m.epoch),
            count: master.map(|m| m.count),
            index: master.map(|m| m.index.0),
            age_cycles: master.map_or(0, |m| m.age_cycles),
            received_position: master.map(|m| m.received.position),
            received_velocity: master.map(|m| m.received.velocity),
            corrected_position: master.map(|m| m.corrected.position),
            corrected_velocity: master.map(|m| m.corrected.velocity),
            correction_us: master
                .and_then(|m| m.correction_time)
                .map(|time| time.as_micros()),
            far_time_ns: master.and_then(|m| m.far_time).map(Instant::as_nanos),
            drift_ppm: master.map(|m| m.drift_ppm),
            observer: observer.map(|o| o.state),
            offset_sigma_us: observer.map(|o| o.offset_sigma.as_micros()),
            drift_sigma_ppm: observer.map(|o| o.drift_sigma_ppm),
            random_walk_ppm: observer.map(|o| o.random_walk_ppm),
            block_length: observer.map(|o| o.block_length),
            shifts: observer.map_or(0, |o| o.shifts),
            relocks: observer.map_or(0, |o| o.relocks),
            delay: delay.map(|d| d.state),
            delay_us: delay.and_then(|d| d.delay).map(Seconds::as_micros),
            delay_uncertainty_us: delay.and_then(|d| d.uncertainty).map(Seconds::as_micros),
            exchanges: delay.map_or(0, |d| d.exchanges),
            answers_refused: delay.map_or(0, |d| d.refused),
            received: counters.received,
            lost: counters.lost,
            duplicates: counters.duplicates,
            late: counters.late,
            stale: counters.stale,
            rejected: counters.rejected.total(),
            restarts: counters.restarts,
            slave: slaves.next().unwrap_or_default(),
            others: slaves.collect(),
        }
    }

    /// The far instant of the set values, typed.
    #[must_use]
    pub fn far_time(&self) -> Option<Instant<Remote>> {
        self.far_time_ns.map(Instant::from_nanos)
    }
}
