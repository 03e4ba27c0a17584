//! The phase observer: a far clock made local from when its messages arrive.
//!
//! TS5066 sees only which cycle index lies in the input image when a cycle starts, and so needs
//! whole beats to learn the drift. The observer looks at the arrival of each message instead:
//!
//! ```text
//! arrival(k) = offset + k·T·(1 + drift) + least delay + jitter
//! ```
//!
//! What remains of an arrival when `k·T` (and the sender's own lateness, if it sends it) is taken
//! away is the *phase*: a straight line plus jitter. Three rooms share the work:
//!
//! * `noise`: the jitter, measured while the line is followed. Eight messages at a time are reduced to one measurement
//!   of the line, the most likely one under that model.
//! * `line`: the estimators. A bank of Kalman filters, each for another random walk of the drift, follows the
//!   measurements. Between processes delays are not independent of each other; the lower edge of the phases is then the
//!   better line, and a choice decides which of both is followed.
//! * `events`: the detectors of jumps of the line, of changes of its drift and of polled arrivals.
//!
//! The observer itself takes phases into the lines (`follow_line`), does what an event asks for (`follow_shift`,
//! `follow_teeth`, `drift_change`) and walks along the line without steps (`show`, `output`).
//!
//! Nothing here allocates, and the work per message and per cycle is bounded.

mod drift_change;
mod events;
mod far_line;
mod follow_line;
mod follow_shift;
mod follow_teeth;
mod line;
mod noise;
mod output;
mod parameters;
mod path_delay;
mod progress;
mod report;
mod show;
mod stream;

pub use drift_change::SuspectedDrift;
pub use far_line::FarLine;
pub(crate) use line::Bank;
pub use output::FarTime;
pub use parameters::ObserverParameters;
#[cfg(feature = "perturb")]
pub(crate) const TUNED: &[&[crate::tuning::TunedBlock]] = &[
    line::TUNED,
    noise::TUNED,
    events::TUNED,
    &[
        drift_change::TUNED,
        follow_line::TUNED,
        follow_shift::TUNED,
        output::TUNED,
        path_delay::TUNED,
        progress::TUNED,
        show::TUNED,
        stream::TUNED,
    ],
];

pub use report::{ObserverLine, ObserverOutput, ObserverState};

use crate::cycle::CycleTime;
use crate::instant::{Instant, Local, Remote, Seconds, Span};
use crate::time_sync::WrongParameter;
use drift_change::DriftChange;
use events::{
    Arrival, Backlog, Batches, Counts, DriftSteps, News, Pace, Picked, ShiftDetector, Teeth,
};
use far_line::within_largest;
use follow_line::Followed;
use line::{Calibration, Choice, Edge};
use noise::{Echo, FIRST_BLOCK, Jitter, Resolution, Waits};
use output::Shown;
use path_delay::PathDelay;
use progress::{Events, Progress};
use stream::{Residual, Stream};

/// Largest drift of a clock that this crate is made for, s/s.
const LARGEST_DRIFT: f64 = 0.01;

/// Follows one sender's clock. Feed it each message with [`observe`](Self::observe) and read the far time once per
/// receiver cycle with [`cycle`](Self::cycle).
///
/// # What the far time means
///
/// At the local instant `t` the far time is that `k·T` whose message, if it met no jitter, arrives at `t`. It lags
/// behind the sender's true time by the least delay of the link, which one-way messages cannot show; set it by
/// [`set_delay`](Self::set_delay).
#[derive(Clone, Debug)]
pub struct PhaseObserver {
    parameters: ObserverParameters,
    data_cycle_time: Span,
    seconds_per_count: f64,
    holdover_after: Span,
    lost_after: Span,
    shift_messages: u16,
    delay: PathDelay,
    /// Rate of the far clock, where it is known better than by the line.
    known_rate: Option<f64>,
    /// See [`FarLine::jumped`].
    jumped: Seconds,
    /// See [`FarLine::corrected`].
    corrected: Seconds,
    drift_change: DriftChange,
    stream: Option<Stream>,
    shown: Option<Shown>,
    progress: Progress,
    jitter: Jitter,
    detector: ShiftDetector,
    events: Events,
    /// True if exchanges attribute steps.
    exchanges_tell: bool,
    /// True if the newest message had a send stamp.
    is_stamped: bool,
}

impl PhaseObserver {
    /// Makes an observer of a sender of the given nominal cycle time.
    ///
    /// # Errors
    /// [`WrongParameter`] names the parameter that is out of its range.
    pub fn new(
        data_cycle_time: CycleTime,
        parameters: ObserverParameters,
    ) -> Result<Self, WrongParameter> {
        parameters.check()?;
        let data_cycle_time = data_cycle_time.span();
        let (holdover_after, lost_after) = parameters.silences(data_cycle_time);
        Ok(Self {
            seconds_per_count: data_cycle_time.as_secs_f64(),
            data_cycle_time,
            holdover_after,
            lost_after,
            shift_messages: parameters.messages_of_a_shift(data_cycle_time),
            parameters,
            delay: PathDelay::default(),
            known_rate: None,
            jumped: Seconds::ZERO,
            corrected: Seconds::ZERO,
            drift_change: DriftChange::new(),
            stream: None,
            shown: None,
            progress: Progress::starting_at(Instant::EPOCH),
            jitter: Jitter::new(),
            detector: ShiftDetector::new(),
            events: Events::default(),
            exchanges_tell: false,
            is_stamped: false,
        })
    }

    /// Takes a message: number `count` of the sender's run `epoch`, which arrived at `arrived`.
    /// `send_stamp` is how late after its ideal cycle start the sender sent it.
    ///
    /// Duplicates and stragglers do no harm, nor do messages that lay in a mailbox while the receiver stood still.
    pub fn observe(
        &mut self,
        epoch: u64,
        count: u64,
        arrived: Instant<Local>,
        send_stamp: Option<Span>,
    ) {
        match self.news(epoch, count) {
            // Before everything else: a duplicate with another arrival would be a second opinion of one message.
            News::Old => return,
            News::Restarted => self.begin(epoch, count, arrived),
            News::New => {}
        }
        let Some(stream) = &mut self.stream else {
            return;
        };
        self.is_stamped = send_stamp.is_some();
        // Against the newest arrival and not the last one, as transports may pass messages in another order.
        let gap = arrived - stream.newest_arrival;
        stream.newest_arrival = stream.newest_arrival.max(arrived);
        self.progress.heard(arrived, &mut self.events);
        let arrival = Arrival {
            count,
            at: arrived,
            send_stamp,
        };
        let together = gap * 2 < self.data_cycle_time;
        if self.progress.is_synced() {
            stream.backlog.end();
        }
        match stream.backlog.take(arrival, together, self.data_cycle_time) {
            Pace::Usual => self.take_arrival(arrival, together),
            Pace::Backlog => self.begin_again(arrived),
            Pace::More => {}
            Pace::After(last) => {
                self.begin_at(&last);
                self.take_arrival(last, false);
                self.take_arrival(arrival, false);
            }
        }
    }

    /// Begins the far time of a run whose first message came with a backlog at the last one of that.
    fn begin_at(&mut self, last: &Arrival) {
        let far = self.origin_of(last.count, last.at);
        let Some(stream) = &mut self.stream else {
            return;
        };
        let first = Arrival {
            count: stream.first_count,
            at: stream.first_arrival,
            send_stamp: None,
        };
        if first.is_late_beside(last, self.data_cycle_time) && self.shown.is_some() {
            let count = last.count.saturating_sub(stream.first_count);
            stream.origin = far - self.data_cycle_time * count as i64;
            self.events.rebase();
        }
    }

    /// Takes the message of a run that came at its time, and whether it came together with the one before.
    fn take_arrival(&mut self, arrival: Arrival, together: bool) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        match stream.batches.take(arrival, together) {
            Picked::Nothing => {}
            Picked::Message(arrival) => self.take_phase(&arrival),
            Picked::Changed => self.begin_again(arrival.at),
        }
    }

    /// Forgets what was learnt of the messages of this run: the lines are found again.
    fn begin_again(&mut self, now: Instant<Local>) {
        let edge = self.new_edge();
        let Some(stream) = &mut self.stream else {
            return;
        };
        stream.filled = 0;
        stream.held_up = 0;
        stream.line = None;
        stream.edge = edge;
        stream.choice = Choice::new();
        stream.calibration = Calibration::new();
        stream.drift_steps = DriftSteps::new(self.seconds_per_count);
        stream.echo = Echo::default();
        stream.waits = Waits::new();
        self.jitter = Jitter::new();
        self.detector.clear();
        self.drift_change.forget_suspicion();
        self.progress = Progress::starting_at(now);
        self.events.relock(now);
    }

    /// Makes the edge of a run.
    fn new_edge(&self) -> Edge {
        let smallest_skip = self.parameters.smallest_skip_ms * 1e-3;
        Edge::new(self.seconds_per_count, smallest_skip)
    }

    /// Returns the far time at which message number `count` of the present run was due to be sent. It is `count·T`
    /// for a sender that never stood still. None until the first message.
    #[must_use]
    pub fn far_time_of(&self, count: u64) -> Option<Instant<Remote>> {
        let stream = self.stream.as_ref()?;
        let count = count.wrapping_sub(stream.first_count) as i64;
        Some(stream.origin + self.data_cycle_time * count)
    }

    /// The parameters in force.
    #[must_use]
    pub const fn parameters(&self) -> &ObserverParameters {
        &self.parameters
    }

    fn news(&mut self, epoch: u64, count: u64) -> News {
        match &mut self.stream {
            Some(stream) if stream.epoch == epoch => stream.counts.take(count),
            // A straggler of the run before the present one.
            Some(stream) if stream.previous_epoch == Some(epoch) => News::Old,
            _ => News::Restarted,
        }
    }

    /// Begins with a first message, or the first of a sender that was restarted.
    fn begin(&mut self, epoch: u64, count: u64, arrived: Instant<Local>) {
        let mut counts = Counts::starting_at(count);
        let _ = counts.take(count);
        // Stragglers of the run before must not begin it again.
        let previous_epoch = match &self.stream {
            Some(stream) if stream.epoch != epoch => Some(stream.epoch),
            Some(stream) => stream.previous_epoch,
            None => None,
        };
        if self.stream.is_some() {
            self.events.relock(arrived);
            self.events.rebase();
        }
        let origin = self.origin_of(count, arrived);
        self.progress = Progress::starting_at(arrived);
        self.detector.clear();
        self.drift_change.forget_suspicion();
        self.stream = Some(Stream {
            epoch,
            previous_epoch,
            first_count: count,
            first_arrival: arrived,
            origin,
            counts,
            newest_arrival: arrived,
            newest_used: arrived,
            backlog: Backlog::default(),
            batches: Batches::default(),
            waits: Waits::new(),
            block: [Residual::default(); FIRST_BLOCK],
            filled: 0,
            held_up: 0,
            line: None,
            resolution: Resolution::new(self.data_cycle_time),
            echo: Echo::default(),
            teeth: Teeth::default(),
            edge: self.new_edge(),
            choice: Choice::new(),
            calibration: Calibration::new(),
            drift_steps: DriftSteps::new(self.seconds_per_count),
        });
    }

    /// Far time of a first count: its own, or (far time must not go back) the whole cycle that is nearest to the
    /// shown one.
    fn origin_of(&self, count: u64, arrived: Instant<Local>) -> Instant<Remote> {
        let cycle = self.data_cycle_time;
        let Some(shown) = &self.shown else {
            let count = i64::try_from(count).unwrap_or(0);
            // A count that a stranger made up must not overflow the far time.
            let fits = count < i64::MAX / 4 / cycle.as_nanos();
            return Instant::EPOCH + cycle * if fits { count } else { 0 };
        };
        let passed = (arrived - shown.at).as_nanos() as f64 / (1.0 + self.drift());
        let far = shown.far.plus(passed - self.delay.shown()).instant;
        // Whole cycles, as the first message of a run was due at the beginning of one.
        let cycles = (far.since_epoch() + cycle / 2).div_floor(cycle);
        Instant::EPOCH + cycle * cycles
    }

    fn drift(&self) -> f64 {
        let followed = self.followed();
        followed.map_or(0.0, |followed| within_largest(followed.estimate.drift))
    }
}

#[cfg(test)]
mod tests;
