//! A receiver, judged cycle by cycle.

mod figures;

use std::collections::VecDeque;

use coaxle_clock::{CycleTime, Instant, Span};
use coaxle_receiver::config::{GearConfig, MasterRef};
use coaxle_receiver::{ContinuityState, ReceiverConfig, SignalRow, SlaveConfig};
use coaxle_sim::Truth;

use super::TrackedMaster;
use super::cuts::TrueMotion as _;
use super::drift::DriftTruth;
use super::followed_delay::FollowedDelay;
use super::followed_motion::FollowedMotion;
use super::frame_age::FrameAges;
use super::lag::MasterLag;
use super::own_time::OwnTime;
use super::settling::{SettledFigure, Settling};
use super::shown_later::{self, OwnPace};
use super::slave::SlaveJudge;
use super::unnoticed::UnnoticedChange;
use super::watch::{FarErrorWatch, FarPositionWatch};
use crate::event::Event;
use crate::followed::JudgedAxis;
use crate::invariants::InvariantViolation;
use crate::record::ReceiverCycle;
use crate::row::{Reference, Row};
use crate::summary::ReceiverSummary;
use crate::topology::{ReceiverAxis, View};

/// Source of an axis's motion, as indices of masters.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotionSource {
    /// The master of the motion.
    pub(super) motion: usize,
    /// The master of the clock.
    pub(super) clock: usize,
    /// Received position as a function of that motion.
    pub(super) gear: Option<GearConfig>,
    /// Time after its generation at which the motion is shown; the longest one, if followers decide it.
    pub(super) later: Span,
    /// True if followers decide it.
    pub(super) is_led: bool,
    /// Greatest jerk of the motion, u/s³; unknown for a recorded one.
    pub(super) jerk: Option<f64>,
    /// True for a receiver, whose runs are not visible.
    pub(super) is_receiver: bool,
    /// True if the axis is as shown: not seen through an encoder, and not forged.
    pub(super) is_shown: bool,
}

impl MotionSource {
    /// Delay of what is to be shown `left` after a cycle; far time has this pace by the own clock.
    fn later_in(
        &self,
        record: &ReceiverCycle,
        masters: &[TrackedMaster],
        pace: f64,
        left: Span,
    ) -> Span {
        if !self.is_led || self.later == Span::ZERO {
            return self.later;
        }
        let oracle = &masters[self.motion].oracle;
        let stated = oracle.shown_after(Instant::from_nanos(record.at_ns), left);
        let received = record.far.present_after_us.map(Span::from_micros_f64);
        // A delay that steps, while nothing moves, is known with the first frame that states it.
        let has_come = |stated: &Span| {
            let differs = received.is_some_and(|newest| (newest - *stated).abs() > SLEWED);
            self.is_receiver || !differs
        };
        // Beyond the newest frame nothing is known but its own delay, which a receiver follows slowly.
        if record.axis.interpolated == Some(false) && !self.is_receiver {
            let shown = shown_later::shown_in(record, pace);
            let is_near = |shown: &Span| {
                received.is_some_and(|newest| (newest - *shown).abs() <= FOLLOWED_WITHIN)
            };
            return shown.filter(is_near).or(received).unwrap_or(self.later);
        }
        stated.filter(has_come).or(received).unwrap_or(self.later)
    }
}

/// Change of a delay within the time that its frames take to be shown, 4 s: of one that is slewed it is below.
const SLEWED: Span = Span::from_millis(4);
/// Distance of a delay that a receiver shows from that of its newest frame: frames that come some fifty at a time bring that much at once.
const FOLLOWED_WITHIN: Span = Span::from_micros(50);

/// Clocks and links in virtual time, as far as known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clocks<'a> {
    /// Times at which clocks jump, s after the start of the run.
    pub(super) jumps: &'a [f64],
    /// Resolution of arrival times, µs; none where delays change for good.
    pub(super) resolution_us: Option<f64>,
}

/// Judges one receiver.
#[derive(Debug)]
pub(super) struct ReceiverJudge {
    /// Sources of its motion: the far node, then its standbys.
    sources: Vec<MotionSource>,
    view: View,
    /// Gear from the master to the first slave, where gears alone couple it.
    gear: Option<GearConfig>,
    dead_time: DriveDeadTime,
    slaves: Vec<SlaveJudge>,
    cycle_time: CycleTime,
    synchronises: bool,
    /// Cycles whose truth is not known yet.
    pub(super) waiting: VecDeque<Box<ReceiverCycle>>,
    /// Records to be used again.
    #[expect(
        clippy::vec_box,
        reason = "records go round in their boxes: only these move"
    )]
    spare: Vec<Box<ReceiverCycle>>,
    /// The record that was judged last.
    last: Option<Box<ReceiverCycle>>,
    previous: Option<Previous>,
    first_data: Option<(i64, u64)>,
    evaluating: bool,
    settling: Settling,
    ripple: SettledFigure,
    time_error: SettledFigure,
    far_error: Option<FarErrorWatch>,
    far_position: Option<FarPositionWatch>,
    unnoticed: Option<UnnoticedChange>,
    lag: MasterLag,
    fastest_master: f64,
    drift: DriftTruth,
    own_pace: OwnPace,
    followed_delay: FollowedDelay,
    own_time: OwnTime,
    frame_ages: FrameAges,
    was_synced: bool,
    was_error: u16,
    was_warning: u16,
    summary: ReceiverSummary,
}

/// Dead time of the drive of the first slave.
#[derive(Clone, Copy, Debug, Default)]
struct DriveDeadTime {
    /// That by which it is given its set values earlier.
    stated: Span,
    /// That of the simulated drive.
    simulated: Span,
}

impl DriveDeadTime {
    fn of(slave: Option<&SlaveConfig>) -> Self {
        slave.map_or(Self::default(), |slave| Self {
            stated: slave.dead_time_us.span(),
            simulated: slave.simulated_dead_time(),
        })
    }
}

/// The cycle before, as far as differences need it.
#[derive(Clone, Copy, Debug)]
struct Previous {
    at_ns: i64,
    /// Place of the followed node.
    place: usize,
    slave_position: Option<f64>,
    true_position: Option<f64>,
    epoch: Option<u64>,
    evaluated: bool,
}

impl ReceiverJudge {
    /// The judge of a receiver by one of its axes, in a scenario with these `events`. Its stated error is judged if there are `clock_jumps`.
    pub(super) fn new(
        config: &ReceiverConfig,
        events: &[Event],
        sources: Vec<MotionSource>,
        view: &View,
        clock_jumps: Option<Clocks<'_>>,
    ) -> Self {
        let followed = JudgedAxis::of(config, view);
        // Relayed or incremental positions are wrong by the error that the relay or the encoder adds.
        let is_shown = sources
            .iter()
            .all(|source| source.is_shown && !source.is_receiver);
        let mut jerks = sources.iter().map(|source| source.jerk);
        let jerk = jerks.try_fold(0.0, |most, jerk| Some(f64::max(most, jerk?)));
        Self {
            sources,
            gear: view.slaves.first().and_then(|n| config.gear_to(*n)),
            dead_time: DriveDeadTime::of(view.slaves.first().map(|n| &config.slaves[*n])),
            slaves: slaves_of(config, view),
            cycle_time: config.cycle_time_us.0,
            synchronises: followed.synchronises,
            waiting: VecDeque::new(),
            spare: Vec::new(),
            last: None,
            previous: None,
            first_data: None,
            evaluating: false,
            settling: Settling::default(),
            ripple: SettledFigure::default(),
            time_error: SettledFigure::default(),
            far_error: clock_jumps.and_then(|clocks| {
                FarErrorWatch::new(config, view, clocks.jumps, clocks.resolution_us)
            }),
            far_position: is_shown
                .then(|| FarPositionWatch::new(config, view, events, jerk))
                .flatten(),
            unnoticed: UnnoticedChange::new(config, view),
            lag: MasterLag::default(),
            fastest_master: 0.0,
            drift: DriftTruth::default(),
            own_pace: OwnPace::default(),
            followed_delay: FollowedDelay::default(),
            own_time: OwnTime::default(),
            frame_ages: FrameAges::default(),
            was_synced: false,
            was_error: 0,
            was_warning: 0,
            summary: ReceiverSummary {
                mode: followed.mode,
                master: followed.name,
                unit: followed.unit,
                ..ReceiverSummary::default()
            },
            view: view.clone(),
        }
    }

    /// Takes the next cycle of its receiver.
    pub(super) fn take(&mut self, at_ns: i64, woke_ns: i64, signals: &SignalRow) {
        let mut record = self.spare.pop().unwrap_or_default();
        record.fill(at_ns, woke_ns, signals, &self.view);
        self.waiting.push_back(record);
    }

    const fn is_virtual(&self) -> bool {
        matches!(self.view.of, ReceiverAxis::Virtual(_))
    }

    /// Takes back the record that was judged last: the one before is not needed any more.
    pub(super) fn take_back(&mut self, record: Box<ReceiverCycle>) {
        self.spare.extend(self.last.replace(record));
    }

    /// True if the truth of the source at this place is known up to `at`.
    pub(super) fn is_known(
        &self,
        masters: &[TrackedMaster],
        place: usize,
        at: Instant<Reference>,
    ) -> bool {
        let MotionSource { motion, clock, .. } = self.sources[place];
        [motion, clock]
            .iter()
            .filter_map(|n| masters[*n].oracle.known_until())
            .all(|until| at <= until)
    }

    pub(super) fn judge(
        &mut self,
        record: Box<ReceiverCycle>,
        masters: &[TrackedMaster],
        start: Instant<Reference>,
    ) -> Row {
        let at = Instant::from_nanos(record.at_ns);
        let source = self.sources[record.place];
        let oracle = &masters[source.motion].oracle;
        self.own_pace.take(record.node.cycle, record.at_ns);
        let own_time = self.own_time.take(&record, self.cycle_time);
        let pace = || {
            let own = (self.own_pace).at(record.node.cycle, record.at_ns, self.cycle_time.span());
            // After the last cycle of the run its clock has the pace of before (swarm schedule 20033).
            let known = oracle.at(at).or_else(|| oracle.at(at - source.later));
            own * known.map_or(1.0, |truth| truth.pace)
        };
        let own_pace = if source.is_led { pace() } else { 1.0 };
        let later = |left| source.later_in(&record, masters, own_pace, left);
        let followed = |left| match source.is_led && !source.is_receiver {
            true => (self.followed_delay).take(&record, later(left), own_pace, self.cycle_time),
            false => later(left),
        };
        let far = FollowedMotion {
            oracle,
            gear: source.gear,
            later: shown_later::delay_in(&record, followed, source.is_receiver, pace),
            start,
        };
        let truth = far.at(at);
        // Asking an oracle is a search: once suffices where motion and clock have one source, and show one instant.
        let clock_now = match source.clock {
            clock if clock == source.motion && far.later == Span::ZERO => truth,
            clock => masters[clock].oracle.at(at),
        };
        // The frames of a relay are evaluated by its clock, however late their motion is.
        let clock = match source.clock == source.motion {
            true => truth,
            false => match shown_later::lag_in(&record) {
                Span::ZERO => clock_now,
                lag => shown_later::at(&masters[source.clock].oracle, at, lag),
            },
        };
        let master = truth.and_then(|truth| far.moves(&truth));
        // What the drive is given was calculated earlier, and shows the instant that all others show.
        let master_of_drive = match self.is_shown_later(&record) {
            true => {
                let later = later(Span::ZERO);
                let shown = FollowedMotion { later, ..far };
                shown.at(at).and_then(|truth| shown.moves(&truth))
            }
            false => master,
        };
        let epoch = truth.map(|truth| truth.epoch);
        let set_velocity = self.difference(
            &record,
            |previous| previous.slave_position,
            record.slave_position(),
        );
        // A row about an ended run shows no error of the next run's time.
        let is_heard = source.is_receiver
            || self.is_virtual()
            || epoch.is_some_and(|epoch| record.far.epoch == Some(epoch));
        let time_error = || time_error_us(&record, clock.as_ref(), master);
        let mut row = Row {
            t_s: far.time(at),
            time_error_us: is_heard.then(time_error).flatten(),
            record,
            truth: master,
            set_velocity,
            evaluated: false,
        };
        let unnoticed = self.unnoticed_us(&row, clock_now.as_ref(), own_time);
        if let Some(watch) = &mut self.far_error {
            watch.push(&row, unnoticed);
            if let Some(position) = &mut self.far_position {
                // A position is judged by the stated error, so only where that is judged itself.
                let pace = clock.map_or(1.0, |clock| clock.pace);
                position.push(
                    &row,
                    pace,
                    unnoticed,
                    is_heard && !watch.has_jumped(row.t_s),
                );
            }
        }
        let record = &row.record;
        self.note_events(&row);
        self.count(record);
        for (judge, slave) in self.slaves.iter_mut().zip(&record.slaves) {
            judge.push(record, slave, &far);
        }
        self.note_sync(&row);
        // Another node has another clock: a drift from one to the other means nothing.
        if self.previous.is_some_and(|last| last.place != record.place) {
            self.drift = DriftTruth::default();
        }
        if let (Some(clock), false) = (&clock_now, self.is_virtual()) {
            self.drift.push(at, clock, own_time);
        }
        if self.evaluating {
            // Asked in every evaluated cycle, as each break has to restart the time.
            let settled = self.settling.is_settled(record.axis.synced && is_heard, at);
            self.measure(&row, epoch, settled || !self.synchronises);
            self.measure_drive(&row, master_of_drive);
            self.frame_ages.push(&row.record);
            if settled {
                self.lag.push(&row, self.gear, self.fastest_master);
            }
        }
        self.previous = Some(Previous {
            at_ns: record.at_ns,
            place: record.place,
            slave_position: record.slave_position(),
            true_position: master.map(|(position, _)| position),
            epoch,
            evaluated: self.evaluating,
        });
        row.evaluated = self.evaluating;
        row
    }

    /// True if the drive of the first slave shows the instant that all others show, and not the one that is calculated.
    fn is_shown_later(&self, record: &ReceiverCycle) -> bool {
        // A hold-back that the dead time takes up is none that waits.
        let is_predicted = record.node.hold_back_us <= self.dead_time.stated.as_micros_f64();
        record
            .slave()
            .is_some_and(|slave| slave.held_back_us > 0.0 || is_predicted)
    }

    /// Error of the far time by a change of the clocks' rates that cannot be known yet, µs.
    fn unnoticed_us(&mut self, row: &Row, clock: Option<&Truth>, own: f64) -> f64 {
        let is_another = (self.previous).is_some_and(|last| last.place != row.record.place);
        let Some(unnoticed) = &mut self.unnoticed else {
            return 0.0;
        };
        if is_another {
            unnoticed.forget();
        }
        clock.map_or(0.0, |truth| unnoticed.push(truth, own))
    }

    /// Violations by the corrected time and position.
    pub(super) fn violations(&self) -> impl Iterator<Item = InvariantViolation> + '_ {
        let of_time = self.far_error.iter().flat_map(FarErrorWatch::violations);
        let of_position = self.far_position.iter();
        of_time.chain(of_position.flat_map(FarPositionWatch::violations))
    }
}

fn slaves_of(config: &ReceiverConfig, view: &View) -> Vec<SlaveJudge> {
    let judge = |n: &usize| {
        // A slave's master is a slave of this very axis.
        let (master, unit) = match config.master_of(*n) {
            Ok(MasterRef::Slave(master)) => (
                view.slaves.iter().position(|n| *n == master),
                config.slave_unit(master),
            ),
            Ok(MasterRef::Far(_) | MasterRef::Virtual(_)) | Err(_) => {
                (None, JudgedAxis::of(config, view).unit)
            }
        };
        SlaveJudge::new(&config.slaves[*n], master, [config.slave_unit(*n), unit])
    };
    view.slaves.iter().map(judge).collect()
}

/// Corrected minus true far time. Where a filter smears it, the position shows it, if it moves; but not while the axis is
/// braked or brought back: then it stands for no far time, and is far off.
fn time_error_us(
    record: &ReceiverCycle,
    clock: Option<&Truth>,
    master: Option<(f64, f64)>,
) -> Option<f64> {
    if let Some(far_time) = record.far_time() {
        return clock.map(|truth| truth.error_of(far_time).as_micros());
    }
    if record.axis.continuity != ContinuityState::Following {
        return None;
    }
    let (position, velocity) = master?;
    let corrected = record.axis.corrected_position?;
    // At rest any time gives the position, and the quotient is noise.
    (velocity.abs() > 1e-9).then(|| (corrected - position) / velocity * 1e6)
}
