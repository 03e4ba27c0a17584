//! A far node and its standbys: choice of the node and its run, its clock, and its axes made local.

mod axis;
mod beacons;
mod candidate;
mod clock;
mod clock_signals;
mod course;
mod encoder;
mod frames;
mod held_back;
mod inbox;
mod lag;
mod limited;
mod orders;
mod pace;
mod plans;
mod run;
mod seen;
mod sequence;
mod steps;
mod take_over;
mod unwrapping;

use coaxle_clock::cycle::Tick;
use coaxle_clock::cycle_lock::FarPhase;
use coaxle_clock::time_sync::{SyncError, WrongParameter};
use coaxle_clock::{CycleTime, Instant, Local, Seconds, Span};
use coaxle_node::config::LinkConfig;

use crate::arrivals::ArrivalLog;
use crate::config::{FarAxisConfig, FarConfig, Lag};
use crate::health::Health;
use crate::promised::PromisedMotion;
use crate::signals::{FarAxisSignals, FarNodeSignals};
use crate::slaves::Master;
use axis::{Axis, AxisScan};
use beacons::Beacons;
pub(crate) use candidate::Candidate;
use candidate::age_limit;
use clock::ClockSetup;
use encoder::Encoder;
use inbox::Inbox;
pub(crate) use lag::HeldNow;
use lag::show_lag;
use orders::OrderCounters;
#[cfg(feature = "host")]
pub(crate) use pace::LARGEST_PPM;
use take_over::TakeOver;

/// A far node with its standbys.
#[derive(Debug)]
pub(crate) struct FarNode {
    cycle_time: CycleTime,
    /// The node itself, then its standbys.
    candidates: Box<[Candidate]>,
    take_over: TakeOver,
    axes: Box<[Axis]>,
    /// Lag of axes that are shown later.
    lag: Lag,
    /// Part of a full lag that is left to the drives, for their dead times.
    dead_time: Span,
    orders: OrderCounters,
}

/// Outputs of one cycle of a far node.
pub(crate) struct FarOutputs<'a> {
    /// Axes as masters of slaves, in their order.
    pub(crate) masters: &'a mut [Option<Master>],
    /// The signals of its axes, likewise.
    pub(crate) axes: &'a mut [FarAxisSignals],
    /// Signals of all received nodes, by their numbers.
    pub(crate) nodes: &'a mut [FarNodeSignals],
    /// Health of these nodes.
    pub(crate) health: &'a mut [Health],
    /// Cycle times of these nodes, as in their frames.
    pub(crate) data_cycle_times: &'a mut [Option<CycleTime>],
}

/// Silence after which a node is never reported healthy, at any age limit.
// An age limit of 0 switches the block's own monitor off. Without a second bound a silent node would stay healthy.
const SILENCE: Span = Span::from_secs(1);

/// Number of frames whose axes can wait for their cycle …
const FRAMES: usize = 8;
/// … and where injected faults hold them back.
// At a millisecond the 128 frames bridge faults that hold messages back for an eighth of a second; of longer ones,
// some frames remain.
const FRAMES_OF_FAULTS: usize = 128;

/// The own node, as its far nodes have to know it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OwnNode {
    pub(crate) cycle_time: CycleTime,
    /// Run of the own node.
    pub(crate) run: u64,
    /// True if it has a time in common with others, or is to have one.
    pub(crate) takes_common_time: bool,
}

impl FarNode {
    /// Creates the node; `numbers` are those of the node and of its standbys among all received nodes.
    pub(crate) fn new(
        config: &FarConfig,
        own: OwnNode,
        numbers: &[usize],
    ) -> Result<Self, WrongParameter> {
        let OwnNode {
            cycle_time,
            run,
            takes_common_time,
        } = own;
        let axis = |axis: &FarAxisConfig| Axis::new(cycle_time, config, axis);
        let candidate = |(place, number): (usize, &usize)| {
            let inbox = Inbox::new(
                age_limit(&config.sync, config.mode, cycle_time),
                frames(config),
                config.axes.count(),
            );
            let setup = ClockSetup::of(config, cycle_time, run);
            let encoder = |axis: &FarAxisConfig| {
                // The axes begin with those of the node itself.
                // Standbys smooth the increments as well: a smoothing that begins with the take-over would need its
                // time to settle.
                let encoder = axis.encoder.filter(|_| place > 0);
                let encoder = encoder.map(|encoder| Encoder::new(cycle_time, encoder));
                Ok(encoder.transpose()?.map(Box::new))
            };
            let encoders = config.axes.iter().map(encoder).collect::<Result<_, _>>()?;
            // A config has one address for the timing channel: that of the node itself.
            let beacons = config.timing.as_ref().filter(|_| place == 0);
            let beacons =
                beacons.map(|timing| Box::new(Beacons::new(timing, run, takes_common_time)));
            let candidate = Candidate::new(config, cycle_time, *number, inbox, setup, encoders)?;
            Ok(candidate.with_beacons(beacons))
        };
        let candidates = numbers.iter().enumerate().map(candidate);
        Ok(Self {
            cycle_time,
            candidates: candidates.collect::<Result<_, _>>()?,
            take_over: TakeOver::default(),
            axes: config.axes.iter().map(axis).collect::<Result<_, _>>()?,
            lag: config.lag_ms,
            dead_time: Span::ZERO,
            orders: OrderCounters::default(),
        })
    }

    /// Node at a place: itself is the first.
    pub(crate) fn node(&mut self, place: usize) -> &mut Candidate {
        &mut self.candidates[place]
    }

    /// Runs one cycle: selects the node and its run, evaluates its clock, and calculates its axes.
    pub(crate) fn scan(
        &mut self,
        tick: &Tick,
        held: HeldNow,
        arrivals: &mut ArrivalLog,
        out: FarOutputs<'_>,
    ) {
        // Standbys run their clocks, too: a node takes over with a clock that is known already.
        for node in &mut self.candidates {
            node.cycle(tick, arrivals.of(node.number));
        }
        self.take_over(tick);
        self.take_axes(tick);
        // After the choice of the node, since all axes move by the clock of that one.
        let error = self.correct_axes(tick, held, out.masters, out.axes);
        let followed = self.take_over.followed();
        for (place, node) in self.candidates.iter_mut().enumerate() {
            // An error of an axis is one of the node that the axis comes from.
            let own = health_of(node, error.filter(|_| place == followed));
            out.health[node.number] = own;
            out.data_cycle_times[node.number] = node.clock.data_cycle_time();
            let signals = &mut out.nodes[node.number];
            node.show(signals);
            self.orders.show(signals);
            if place == followed {
                show_lag(&self.axes, signals);
            }
            signals.health = own.name();
            signals.followed = place == followed;
            signals.stands_by = place != followed && node.could_take_over(tick.ideal_start);
            signals.take_overs = self.take_over.count();
            // Last, because it frees the axes of the image that this cycle has read.
            node.inbox.end_cycle(tick.ideal_start);
        }
        let health = self.health(out.health, tick.ideal_start);
        // The entry of the node itself speaks for all of its standbys, so it is written after theirs.
        let number = self.candidates[0].number;
        out.health[number] = health;
        out.nodes[number].health = health.name();
    }

    /// Place of the node that is followed, itself or a standby, and its run; none before its first frame.
    pub(crate) fn followed_run(&self) -> Option<(usize, u64)> {
        let header = self.followed().news().header.as_ref()?;
        Some((self.take_over.followed(), header.epoch))
    }

    /// The promised motion of one of its axes; none without a promise.
    pub(crate) fn promised(&self, axis: usize) -> Option<PromisedMotion<'_>> {
        let plans = self.followed().plans.as_deref()?;
        let shown = self.axes.get(axis)?.shown_instants()?;
        Some(PromisedMotion::new(plans.motion(axis)?, shown))
    }

    /// Cycle of the node that is followed, in relation to the own one.
    pub(crate) fn phase(&self) -> Option<FarPhase> {
        self.followed().phase()
    }

    /// The node that is followed.
    fn followed(&self) -> &Candidate {
        &self.candidates[self.take_over.followed()]
    }

    /// Changes to another node from this cycle on, if its frame is there.
    fn take_over(&mut self, tick: &Tick) {
        let Self {
            candidates,
            take_over,
            axes,
            ..
        } = self;
        if candidates.len() == 1 {
            return;
        }
        let standings = candidates.iter().map(|node| {
            let samples = node.fresh_axes();
            let mut pairs = axes.iter().zip(samples);
            // A take-over without an axis that slaves follow already would take their master away. An axis that has
            // never come holds nothing up.
            let has_axes = !samples.is_empty()
                && pairs.all(|(axis, sample)| sample.is_some() || !axis.has_come());
            node.standing(has_axes)
        });
        let Some(before) = take_over.decide(tick.ideal_start, standings) else {
            return;
        };
        let next = take_over.followed();
        for (axis, encoder) in axes.iter_mut().zip(candidates[next].encoders_mut()) {
            axis.take_over(encoder);
        }
        // The smoothing of the old node goes to standby with it.
        let encoders = std::mem::take(candidates[next].encoders_mut());
        let none = std::mem::replace(candidates[before].encoders_mut(), encoders);
        *candidates[next].encoders_mut() = none;
    }

    /// Takes the axes of the newest cycle.
    fn take_axes(&mut self, tick: &Tick) {
        let followed = self.take_over.followed();
        for (place, node) in self.candidates.iter_mut().enumerate() {
            if place != followed {
                node.stand_by(tick.elapsed);
                continue;
            }
            let news = node.news();
            if let Some(cycle) = news.started {
                self.axes.iter_mut().for_each(|axis| axis.restart(cycle));
            }
            if let Some(header) = news.header.filter(|_| news.is_fresh) {
                let samples = node.fresh_axes();
                for (n, axis) in self.axes.iter_mut().enumerate() {
                    // Before the sample of this frame is taken: forgetting drops the newest one.
                    if news.is_new_run {
                        axis.forget();
                    }
                    axis.take(samples.get(n).copied().flatten(), &header);
                }
            }
            // After the newest one, whose turn the others share. Nobody asks for them where nothing is shown later.
            let presented = news.header.filter(|header| header.present_after.is_some());
            if let Some(header) = presented {
                for frame in node.frames() {
                    for (axis, sample) in self.axes.iter_mut().zip(frame.samples) {
                        axis.take_beside(sample.as_ref(), &frame, &header);
                    }
                }
            }
            // A remapped clock moves all set values at once. Without a way back that would be a step.
            if news.following.is_some_and(|now| now.is_remapped) {
                self.axes.iter_mut().for_each(Axis::rejoin);
            }
        }
    }

    /// Moves every axis in time by the common clock. Returns the first error.
    fn correct_axes(
        &mut self,
        tick: &Tick,
        held: HeldNow,
        masters: &mut [Option<Master>],
        signals: &mut [FarAxisSignals],
    ) -> Option<SyncError> {
        let node = &self.candidates[self.take_over.followed()];
        let (Some(header), Some(following)) = (&node.news().header, &node.news().following) else {
            // Otherwise the values of an earlier cycle would pass for those of this one.
            masters.fill(None);
            signals.fill(FarAxisSignals::default());
            return None;
        };
        let correction = &following.correction;
        let age_limit = node.clock.age_limit();
        let time_sigma = node.clock.time_sigma();
        let held_in_its_clock = node.in_its_clock(held.by);
        // At most 10 000 cycles, since none is shorter than 100 µs.
        let longest = (SILENCE.as_nanos() / self.cycle_time.span().as_nanos()) as u32;
        let mut first = None;
        let plans = node.plans.as_deref();
        let axes = self.axes.iter_mut().zip(masters).zip(signals);
        for (n, ((axis, master), signals)) in axes.enumerate() {
            let own;
            // An axis that the newest frame lacks is older than its node, and is moved on by that much more.
            let planned = plans.and_then(|plans| plans.of(n, axis.count(), header));
            let (age, correction) = if axis.count() == header.count {
                (node.age_cycles(), correction)
            } else {
                own = axis.catch_up(correction, header, tick.elapsed, age_limit);
                (axis.missing_cycles(), &own)
            };
            // Frames that are shown later outlast a silence, and so does a promise.
            let outlasting;
            let planned = axis.usable(correction, planned, tick.elapsed);
            let covers = axis.covers(correction) || planned.is_some();
            let correction = match covers {
                true => {
                    outlasting = correction.despite_silence();
                    &outlasting
                }
                false => correction,
            };
            let is_lost = correction.is_silent || (age > longest && !covers);
            let scan = AxisScan {
                elapsed: tick.elapsed,
                age,
                is_lost,
                held: held_in_its_clock,
                time_sigma,
                planned,
            };
            *master = axis.cycle(header, correction, scan, signals);
            signals.age_cycles = age;
            if let Some(plans) = plans {
                plans.show_axis(n, signals);
            }
            // The first hold-back moves an axis that is shown later.
            signals.synced &= held.is_decided || axis.lag().is_none();
            if let Some(master) = master {
                master.is_sound &= age <= longest || covers;
                // Bypass, PT1 and time mode never report sync, so their axes are ready without it.
                let needs_no_clock = node.clock.is_enabled() && !node.clock.synchronises();
                let is_there = signals.synced || needs_no_clock;
                // A blend is a straight line between two modes: its velocity steps where it begins and ends.
                let is_placed = held.is_decided || axis.lag().is_none();
                master.is_ready = master.is_sound && is_there && is_placed && !axis.is_blending();
                first = first.or(axis.error());
            }
        }
        first
    }

    /// Health of the far node: that of the followed node, and of the standbys.
    fn health(&self, of: &[Health], now: Instant<Local>) -> Health {
        let followed = self.take_over.followed();
        let own = of[self.candidates[followed].number];
        if own != Health::Ok {
            return own;
        }
        if followed != 0 {
            return Health::OnStandby;
        }
        let standbys = &self.candidates[1..];
        if !standbys.is_empty() && !standbys.iter().any(|node| node.could_take_over(now)) {
            return Health::NoStandby;
        }
        Health::Ok
    }
}

/// Health of a single node.
fn health_of(node: &Candidate, error_of_axis: Option<SyncError>) -> Health {
    let Some(following) = &node.news().following else {
        return if node.clock.is_refused() {
            Health::CycleTimesDoNotFit
        } else {
            Health::WaitingForMaster
        };
    };
    let correction = &following.correction;
    // Before the error of the correction, which a refused pace sets as well: only the pace names the cause.
    if node.inbox.is_pace_refused() {
        return Health::PaceOutOfRange;
    }
    if let Some(error) = correction.error.or(error_of_axis) {
        return Health::Error(error);
    }
    // After the errors: beyond an age limit a silence is one of them, with a code.
    if node.silence() > SILENCE {
        return Health::MasterSilent;
    }
    if node.has_rival() {
        return Health::TwoSenders;
    }
    if !node.clock.is_enabled() {
        return Health::Disabled;
    }
    if node.clock.synchronises() && !correction.synced {
        return Health::StartingUp;
    }
    // Last: set values are in order, by the clock as it was before.
    if node.do_clocks_disagree() {
        return Health::ClocksDisagree;
    }
    Health::Ok
}

/// Number of frames that can wait.
fn frames(config: &FarConfig) -> usize {
    if config.faults == LinkConfig::default() {
        FRAMES
    } else {
        FRAMES_OF_FAULTS
    }
}

/// Returns the time as signals show it, µs.
pub(super) fn micros(seconds: Option<Seconds>) -> Option<f64> {
    seconds.map(Seconds::as_micros)
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::AxisSample;

    #[test]
    fn a_far_axis_takes_little_more_than_a_kilobyte() {
        let kept = FRAMES * size_of::<Option<AxisSample>>();
        let shown = size_of::<FarAxisSignals>() + size_of::<Option<Master>>();
        let bytes = size_of::<Axis>() + kept + shown;
        // Frames that are shown later and plans lie beside it.
        assert!(bytes <= 1456, "{bytes}");
    }
}
