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
//! away is the *phase*: a straight line plus jitter. Eight messages at a time are reduced to one
//! measurement of the line, the most likely one under a model of the jitter that is itself measured
//! (`jitter`); a `bank` of Kalman filters, each for another restlessness of the drift, follows the
//! measurements; `shift` notices when the line jumps; and `output` walks along it without steps.
//!
//! All this holds for delays that are independent of each other. Between processes they are not:
//! `correlation` notices it, the `edge` of the phases is then the better line, and `choice` decides
//! which of both is followed.
//!
//! Nothing here allocates, and the work per message and per cycle is bounded.

mod attributed;
mod bank;
mod batches;
mod bias;
mod calibration;
mod choice;
mod correlated_delay;
mod correlation;
mod counts;
mod drift_change;
mod drift_step;
mod echo;
mod edge;
mod far_line;
mod filter;
mod follow_shift;
mod follow_teeth;
mod hazard;
mod information;
mod jitter;
mod misfit;
mod output;
mod parameters;
mod path_delay;
mod progress;
mod pull;
mod report;
mod resolution;
mod shift;
mod show;
mod steadiness;
mod stream;
mod teeth;
mod waits;

pub(crate) use bank::Bank;
pub use drift_change::SuspectedDrift;
pub use far_line::FarLine;
pub use output::FarTime;
pub use parameters::ObserverParameters;
pub use report::{ObserverLine, ObserverOutput, ObserverState};

use crate::cycle::CycleTime;
use crate::instant::{Instant, Local, Remote, Seconds, Span};
use crate::numbers::rounded;
use crate::time_sync::WrongParameter;
use batches::{Arrival, Batches, Picked};
use calibration::Calibration;
use choice::Choice;
use counts::{Counts, News};
use drift_change::DriftChange;
use drift_step::DriftSteps;
use echo::Echo;
use edge::Edge;
use far_line::within_largest;
use filter::Estimate;
use jitter::{FIRST_BLOCK, Jitter};
use output::Shown;
use path_delay::PathDelay;
use progress::{Events, Progress};
use resolution::Resolution;
use shift::ShiftDetector;
use stream::{BLOCK, Line, Residual, Stream};
use teeth::{Teeth, within_cell};
use waits::Waits;

/// The accuracy that is sure enough is a part of the jitter: where the edge is followed, the scatter of points is
/// worth a jitter of this multiple.
const EDGE_AS_JITTER: f64 = 24.0;
/// Time, s, until which, where delays are correlated, only an accuracy that is fine anywhere is sure enough.
const CORRELATION_IS_KNOWN_AFTER: f64 = 4.0;
/// Time after which the best there is will do, s.
const LONGEST_IF_CORRELATED: f64 = 8.0;
/// Far time that is no further from the line than this is where it should be, s.
const AT_THE_LINE: f64 = 1e-6;
/// Largest drift of a clock that this crate is made for, s/s.
const LARGEST_DRIFT: f64 = 0.01;

/// The line that is followed.
struct Followed {
    /// Count of the estimate since the first.
    at: i64,
    estimate: Estimate,
    /// The variance that the drift gains per second.
    drift_walk: f64,
}

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
            News::Old => return,
            News::Restarted => self.begin(epoch, count, arrived),
            News::New => {}
        }
        let Some(stream) = &mut self.stream else {
            return;
        };
        self.is_stamped = send_stamp.is_some();
        let gap = arrived - stream.newest_arrival;
        stream.newest_arrival = stream.newest_arrival.max(arrived);
        self.progress.heard(arrived, &mut self.events);
        let arrival = Arrival {
            count,
            at: arrived,
            send_stamp,
        };
        match stream.batches.take(arrival, gap * 2 < self.data_cycle_time) {
            Picked::Nothing => {}
            Picked::Message(arrival) => self.take_phase(&arrival),
            Picked::Changed => self.begin_again(arrived),
        }
    }

    /// Takes the phase of a message into both lines.
    fn take_phase(&mut self, arrival: &Arrival) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        let Arrival {
            count,
            at: arrived,
            send_stamp,
        } = *arrival;
        let count = count.wrapping_sub(stream.first_count) as i64;
        let gap = arrived - stream.newest_used;
        stream.newest_used = stream.newest_used.max(arrived);
        let sent = arrived - send_stamp.unwrap_or(Span::ZERO);
        let phase = sent - stream.first_arrival - self.data_cycle_time * count;
        let phase = phase.as_secs_f64();
        let value = phase - stream.expected(count, self.seconds_per_count);
        if stream.batches.are_picked_from() && stream.line.is_some() {
            stream.waits.take(value);
        }
        if let Some(stamp) = send_stamp {
            let stamp = stamp.as_secs_f64();
            stream.echo.take(count, phase + stamp, stamp);
        }
        let time = count as f64 * self.seconds_per_count;
        self.take_edge(time, phase, arrived);
        self.suspect_drift_step(time, phase, arrived);
        self.take_residual(Residual { count, value }, gap, arrived);
    }

    /// Forgets what was learnt of the messages of this run: the lines are found again.
    fn begin_again(&mut self, now: Instant<Local>) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        let smallest_skip = self.parameters.smallest_skip_ms * 1e-3;
        stream.filled = 0;
        stream.held_up = 0;
        stream.line = None;
        stream.edge = Edge::new(self.seconds_per_count, smallest_skip);
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

    /// Takes a phase into the lower edge. Where it is followed, its jumps are the line's.
    fn take_edge(&mut self, time: f64, phase: f64, arrived: Instant<Local>) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        // The edge of teeth is no line.
        if stream.resolution.polled() > 0.0 {
            return;
        }
        stream.edge.observe(time, phase);
        let (jump, shift) = (stream.edge.take_jump(), stream.edge.take_shift());
        stream.choice.edge_jumped(jump);
        if let Some(shift) = shift {
            stream.choice.shift_edge(shift);
        }
        if stream.choice.is_edge() {
            self.corrected.0 += jump;
            if let Some(shift) = shift {
                stream.calibration.shift(shift);
                self.jumped.0 += shift;
                self.drift_change.attributed.note(time, shift);
                self.events.shift(arrived);
            }
        }
    }

    /// Takes the residual of a message into the line of all messages; it came `gap` after the one before.
    fn take_residual(&mut self, residual: Residual, gap: Span, arrived: Instant<Local>) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        stream.resolution.take(residual.count, arrived);
        let coarse = self.jitter.cell() > 0.0 || stream.resolution.polled() > 0.0;
        let is_queue = gap * 2 < self.data_cycle_time;
        let held_up = !coarse && stream.is_held_up(residual.value, gap, is_queue);
        if !held_up {
            if !coarse {
                stream.choice.observe(residual.value);
            }
            stream.block[stream.filled] = residual;
            stream.filled += 1;
        }
        let queued = held_up && is_queue;
        let shifted = stream.line.as_ref().is_some_and(|line| {
            !queued
                && self.detector.observe(
                    residual.value,
                    line.bounds,
                    arrived,
                    self.data_cycle_time,
                    self.shift_messages,
                )
        });
        if shifted {
            self.follow_shift(arrived, residual.count);
        } else if stream.block_is_full() {
            self.end_block(arrived);
        }
    }

    /// Begins with a first message, or the first of a sender that was restarted.
    fn begin(&mut self, epoch: u64, count: u64, arrived: Instant<Local>) {
        let mut counts = Counts::starting_at(count);
        let _ = counts.take(count);
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
            batches: Batches::default(),
            waits: Waits::new(),
            block: [Residual::default(); FIRST_BLOCK],
            filled: 0,
            held_up: 0,
            line: None,
            resolution: Resolution::new(self.data_cycle_time),
            echo: Echo::default(),
            teeth: Teeth::default(),
            edge: Edge::new(
                self.seconds_per_count,
                self.parameters.smallest_skip_ms * 1e-3,
            ),
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
            let fits = count < i64::MAX / 4 / cycle.as_nanos();
            return Instant::EPOCH + cycle * if fits { count } else { 0 };
        };
        let passed = (arrived - shown.at).as_nanos() as f64 / (1.0 + self.drift());
        let far = shown.far.plus(passed - self.delay.shown()).instant;
        let cycles = (far.since_epoch() + cycle / 2).div_floor(cycle);
        Instant::EPOCH + cycle * cycles
    }

    fn drift(&self) -> f64 {
        let followed = self.followed();
        followed.map_or(0.0, |followed| within_largest(followed.estimate.drift))
    }

    /// Returns the line that is followed: that of all messages, or their lower edge.
    fn followed(&self) -> Option<Followed> {
        let stream = self.stream.as_ref()?;
        let line = stream.line.as_ref()?;
        let mut followed = match stream.edge.line() {
            Some(edge) if stream.choice.is_edge() => Followed {
                at: rounded(edge.at / self.seconds_per_count),
                estimate: edge.estimate,
                drift_walk: Edge::drift_walk(),
            },
            _ => Followed {
                at: line.at,
                estimate: *line.bank.combined(),
                drift_walk: line.bank.drift_walk(),
            },
        };
        followed.estimate.offset += stream.choice.carry();
        Some(followed)
    }

    fn end_block(&mut self, arrived: Instant<Local>) {
        if self.take_level(arrived) {
            return;
        }
        let Some(stream) = &mut self.stream else {
            return;
        };
        let middle = stream.middle();
        let values = stream.block.map(|residual| residual.value);
        stream.filled = 0;
        self.jitter.set_cell(stream.resolution.cell());
        let Some(line) = &mut stream.line else {
            let drift = self.parameters.expected_drift_ppm * 1e-6;
            stream.line = Some(Line::first(middle, &values, &mut self.jitter, drift));
            return;
        };
        if self.detector.is_suspected() {
            return;
        }
        let dt = (middle - line.at).max(0) as f64 * self.seconds_per_count;
        let estimate = *line.bank.combined();
        let walk = line.bank.drift_walk();
        let (expected, prior) = line.bank.agile(dt);
        let line_offset = estimate.offset + estimate.drift * dt;
        let reference = expected - line_offset + self.jitter.moved();
        let mut residuals = [0.0; BLOCK];
        for (residual, value) in residuals.iter_mut().zip(values) {
            *residual = value - reference;
        }
        let location = self.jitter.locate(&residuals, prior);
        let variance = location.variance;
        let measured = expected + location.measured;
        let known = estimate.offset_variance_after(dt, walk) < 0.5 * variance;
        // Where the line is not known, nothing would show that the widths fit again.
        if !known || !self.jitter.is_unfit() {
            line.at = line.at.max(middle);
            line.bank.observe(dt, measured, variance);
        }
        if known {
            let correlated = line.bank.correlated();
            (self.jitter).learn(&residuals, line_offset - expected, correlated);
        }
        line.bounds = Line::bounds(&line.bank, &self.jitter);
        self.choose_line(arrived, middle);
    }

    /// Chooses the line to follow after a block, and judges its uncertainty.
    fn choose_line(&mut self, arrived: Instant<Local>, middle: i64) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        let Some(line) = &stream.line else {
            return;
        };
        let all = line.bank.combined();
        let age = (arrived - self.progress.since).as_secs_f64();
        let width = self.jitter.width();
        let mut variance = all.offset_variance + line.bank.bias_variance();
        let polled = stream.resolution.polled();
        if polled > 0.0 {
            let ahead = middle.saturating_sub(line.at).max(0) as f64 * self.seconds_per_count;
            variance = within_cell(all, ahead, line.bank.drift_walk(), polled);
        } else if let Some(edge) = stream.edge.line() {
            let time = middle as f64 * self.seconds_per_count;
            if self.jitter.cell() == 0.0 {
                stream.choice.suspect(line.bank.correlated().factor());
            }
            self.corrected.0 += stream.choice.judge(time, age, all, edge, width);
            if stream.choice.is_edge() {
                variance = edge.estimate.offset_variance;
            }
        }
        let longest = self.parameters.longest_locking_s;
        let (jitter, longest) = match stream.choice.is_correlated() {
            false if !stream.choice.may_be_correlated() => (width, longest),
            false => (0.0, longest),
            // It is not known as yet how long a delay may last.
            true if age < CORRELATION_IS_KNOWN_AFTER => (0.0, longest),
            // It does not become better by waiting longer.
            true => {
                let scatter = EDGE_AS_JITTER * stream.edge.point_sigma();
                (width.max(scatter), longest.min(LONGEST_IF_CORRELATED))
            }
        };
        let sigma = stream.choice.sigma(variance);
        let may_end = self.may_end_locking(arrived);
        (self.progress).judge(arrived, may_end, sigma, jitter, longest, &self.parameters);
        self.calibrate(middle, sigma);
    }

    /// Compares the line that is followed, of standard deviation `sigma`, with its own predictions, at a mean count.
    fn calibrate(&mut self, middle: i64, sigma: f64) {
        let Some(Followed {
            at,
            mut estimate,
            drift_walk,
        }) = self.followed()
        else {
            return;
        };
        let Some(stream) = self.stream.as_mut() else {
            return;
        };
        if stream.resolution.polled() > 0.0 {
            return;
        }
        let bias_variance = match &stream.line {
            Some(line) if !stream.choice.is_edge() => line.bank.lasting_bias_variance(),
            _ => stream.edge.lasting_bias_variance(),
        };
        stream.calibration.remember(bias_variance);
        let ahead = middle.saturating_sub(at) as f64 * self.seconds_per_count;
        if ahead > 0.0 {
            estimate.predict(ahead, drift_walk);
        } else {
            estimate.offset += estimate.drift * ahead;
        }
        let time = middle as f64 * self.seconds_per_count;
        (stream.calibration).look(time, &estimate, drift_walk, sigma);
        if stream.choice.is_edge() {
            stream.calibration.hold(sigma);
        }
    }

    /// True if locking may end: not on a backlog that comes all at once, and not before far time is where the line
    /// is, as it is slewed afterwards so slowly that it would take an hour.
    fn may_end_locking(&self, now: Instant<Local>) -> bool {
        let messages = i64::from(self.parameters.synced_messages);
        let is_there = |shown: &Shown| shown.remaining.0.abs() < AT_THE_LINE;
        now - self.progress.since >= self.data_cycle_time * messages / 2
            && self.shown.as_ref().is_none_or(is_there)
    }
}

#[cfg(test)]
mod tests;
