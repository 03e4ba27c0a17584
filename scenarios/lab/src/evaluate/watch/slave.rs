//! A slave: its limits, and its error stops.

use coaxle_axis::AxisStatus;
use coaxle_clock::Span;
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_node::CommandOrder;
use coaxle_receiver::signals::SlaveSignals;
use coaxle_receiver::{ReceiverConfig, SlaveConfig, StepConfig};
use coaxle_saw::SyncMask;
use coaxle_sim::{
    DistanceExceeded, ErrorStopCheck, ReportedCheck, ReportedValue, SetValueBound, SetValueCheck,
    Shares,
};
use coaxle_slave::{Command, OnMasterLoss, SlaveError, SlaveParameters};

use super::found::{Found, WatchedCycle};
use super::shown::{SHOWN_FASTER, ShownWatch};
use super::target::TargetWatch;
use crate::event::{Event, EventKind};
use crate::invariants::Invariant;

/// An order is executed within this time, or not at all, s.
// In virtual time an order is executed in the next cycle. A process gets it through the network first.
const ORDER_UNDER_WAY: f64 = 1.0;

/// Watches a slave.
#[derive(Debug)]
pub(super) struct SlaveWatch {
    pub(super) name: String,
    check: Option<SetValueCheck>,
    reported: Option<ReportedCheck>,
    shown: Option<ShownWatch>,
    target: Option<TargetWatch>,
    stop: Option<ErrorStopCheck>,
    /// The newest cycle and its signals.
    last: Option<(WatchedCycle, SlaveSignals)>,
    /// Times of the orders that may reset it, s after the start of the run.
    resets: Vec<f64>,
    /// Cycle time of its receiver, s.
    cycle_time: f64,
    /// A lost master stops it with unlimited jerk.
    stops_quickly: bool,
    /// A master that runs back may stop it within a cycle.
    stops_instantly: bool,
    /// True while it may be as fast as it was shown when it was set back.
    is_braked_back: bool,
    before: SlaveBefore,
    pub(super) found: Found,
}

/// State of a cycle that the next one is compared with.
#[derive(Clone, Copy, Debug, Default)]
struct SlaveBefore {
    /// Planned time of the cycle, s after the start of the run.
    t_s: f64,
    state: AxisStatus,
    position: Option<f64>,
    velocity: Option<f64>,
    acceleration: Option<f64>,
    distance: f64,
    set_anew: u32,
    set_back: u32,
}

impl SlaveBefore {
    const fn of(cycle: &WatchedCycle, slave: &SlaveSignals) -> Self {
        Self {
            t_s: cycle.t_s,
            state: slave.state,
            position: slave.position,
            velocity: slave.velocity,
            acceleration: slave.acceleration,
            distance: slave.distance,
            set_anew: slave.set_anew,
            set_back: slave.set_back,
        }
    }
}

impl SlaveWatch {
    /// `events` are those of the whole scenario: its commands decide which motions are possible.
    pub(super) fn new(config: &SlaveConfig, receiver: &ReceiverConfig, events: &[Event]) -> Self {
        let cycle_time = receiver.cycle_time_us.0.as_secs_f64();
        let stops_instantly = commands_to(config, receiver, events).any(may_stop_instantly);
        let limits = config.limits();
        let profile = profile_limits(&limits);
        let dead_time = config.dead_time_us.span();
        let check = |profile| SetValueCheck::new(&profile, software_limits(&limits), cycle_time);
        Self {
            name: config.name.to_string(),
            check: profile.map(check),
            reported: profile.map(|profile| ReportedCheck::new(&profile, cycle_time)),
            // A stop without a jerk limit is shown later than it is made.
            shown: profile
                .filter(|_| receiver.may_hold_back() || dead_time > Span::ZERO)
                .filter(|_| !stops_instantly)
                .filter(|_| limits.on_master_loss != OnMasterLoss::QuickStop)
                .map(|profile| ShownWatch::new(&profile, cycle_time, dead_time.as_secs_f64())),
            target: profile
                .and_then(|profile| TargetWatch::new(&limits, &profile, receiver.cycle_time_us.0)),
            last: None,
            stop: profile.map(|profile| ErrorStopCheck::new(profile, cycle_time)),
            resets: resets_of(config, receiver, events),
            cycle_time,
            stops_quickly: limits.on_master_loss == OnMasterLoss::QuickStop,
            stops_instantly,
            is_braked_back: false,
            before: SlaveBefore::default(),
            found: Found::default(),
        }
    }

    pub(super) fn push(&mut self, cycle: &WatchedCycle, slave: &SlaveSignals) {
        let shown = [slave.position, slave.velocity, slave.acceleration];
        // The drive is a simulation of its own: it may diverge on finite set values.
        let shown = shown.into_iter().flatten().chain([slave.drive_position]);
        for value in shown.filter(|value| !value.is_finite()) {
            self.found.add(cycle, Invariant::Finite, value, f64::MAX);
        }
        let before = std::mem::replace(&mut self.before, SlaveBefore::of(cycle, slave));
        let had = cycle.since.and(before.position).is_some();
        let has = [slave.position, slave.velocity, slave.acceleration].map(|value| value.is_some());
        // All three or none, and all once there was a position.
        if has != [had || has[0]; 3] {
            self.found
                .add(cycle, Invariant::SetValues, f64::NAN, f64::NAN);
        }
        self.last = Some((*cycle, *slave));
        if let Some(target) = &mut self.target {
            target.push(cycle, slave, &mut self.found);
        }
        self.watch_error_stop(cycle, &before, slave);
        self.watch_rest(cycle, &before, slave);
        let stops_now = self.stops_instantly && is_instant_stop(&before, slave);
        let is_set_anew = slave.set_anew != before.set_anew || slave.state == AxisStatus::Disabled;
        // The drive sees no step of it: it goes on from what it was given.
        let is_set_back = slave.set_back != before.set_back;
        // A position that is set, or a stop within a cycle, is a step that differences would take for a motion.
        let begins_anew = is_set_anew || is_set_back || stops_now || cycle.since.is_none();
        self.watch_positions(cycle, slave, begins_anew);
        self.is_braked_back |= is_set_back;
        if let Some(shown) = &mut self.shown {
            let begins_anew = is_set_anew || cycle.since.is_none();
            shown.push(cycle, slave, begins_anew, &mut self.found);
        }
        self.watch_told(cycle, slave, begins_anew);
    }

    fn watch_positions(&mut self, cycle: &WatchedCycle, slave: &SlaveSignals, begins_anew: bool) {
        let (Some(check), Some(position)) = (&mut self.check, slave.position) else {
            return;
        };
        if begins_anew {
            check.restart();
        }
        if self.stops_quickly && is_quick_stop(slave) {
            // A quick stop takes its full deceleration at once, on purpose.
            check.free_jerk();
        }
        let found = &mut self.found;
        let mut is_faster = false;
        check.push(position, cycle.since.unwrap_or(1), |excess| {
            let is_velocity = excess.bound == SetValueBound::Velocity;
            is_faster |= is_velocity;
            // It brakes from the velocity that its drive was shown.
            if !(self.is_braked_back && is_velocity && excess.value <= excess.limit * SHOWN_FASTER)
            {
                found.add(cycle, excess.bound.into(), excess.value, excess.limit);
            }
        });
        self.is_braked_back &= is_faster;
    }

    fn watch_told(&mut self, cycle: &WatchedCycle, slave: &SlaveSignals, begins_anew: bool) {
        let (Some(check), Some(set)) = (&mut self.reported, set_of(slave)) else {
            return;
        };
        if begins_anew {
            check.restart();
        }
        if self.stops_quickly && is_quick_stop(slave) {
            check.free_jerk();
        }
        let wrong = check.push(&set, cycle.since.unwrap_or(1));
        for wrong in wrong.into_iter().flatten() {
            let invariant = match wrong.what {
                ReportedValue::Velocity => Invariant::ToldVelocity,
                ReportedValue::Acceleration => Invariant::ToldAcceleration,
            };
            self.found.add(cycle, invariant, wrong.value, wrong.limit);
        }
    }

    /// Ends the run.
    pub(super) fn end(&mut self) {
        if let (Some((cycle, slave)), Some(target)) = (&self.last, &self.target) {
            target.end(cycle, slave, &mut self.found);
        }
    }

    /// Greatest shares of its limits that its set positions reached.
    pub(super) fn shares(&self) -> Option<Shares> {
        self.check.as_ref().map(SetValueCheck::largest)
    }

    /// True if an order may reset it in the cycle that is planned for `t_s`, `before` being the time of the cycle before.
    fn is_reset_at(&self, before: f64, t_s: f64) -> bool {
        // An order waits for the next cycle. A node whose clock was set back has none for as long: swarm schedule 2530 was reset 2.7 s later.
        let first = (t_s - ORDER_UNDER_WAY).min(before);
        // A row has the planned time of its cycle. The node wakes up later, by less than a cycle, and has an order of the meantime (wide
        // schedule 601779).
        let last = t_s + self.cycle_time;
        let orders = self.resets.iter();
        orders.copied().any(|at| first < at && at <= last)
    }

    /// A position is set without a motion at rest only. In skipped cycles the axis may have come to rest.
    fn watch_rest(&mut self, cycle: &WatchedCycle, before: &SlaveBefore, slave: &SlaveSignals) {
        let is_set_anew = cycle.since == Some(1) && slave.set_anew != before.set_anew;
        let moved = [before.velocity, before.acceleration].map(|value| value.unwrap_or_default());
        // Exactly zero: an axis at rest has no rest of a velocity, as profiles end at zero.
        if is_set_anew && moved != [0.0; 2] {
            let velocity = moved[0].abs();
            (self.found).add(cycle, Invariant::SetAnew, velocity, 0.0);
        }
    }

    fn watch_error_stop(
        &mut self,
        cycle: &WatchedCycle,
        before: &SlaveBefore,
        slave: &SlaveSignals,
    ) {
        let is_next = cycle.since.is_some();
        // In cycles that were skipped it may have been reset and moved.
        let was_stopped = cycle.since == Some(1) && before.state == AxisStatus::ErrorStop;
        // A velocity that is not known counts as a motion.
        let was_moving = before.velocity != Some(0.0);
        let is_left = was_stopped && !follows_error_stop(slave.state);
        // An order that comes with the reset moves it in the same cycle.
        if is_left && (was_moving || !self.is_reset_at(before.t_s, cycle.t_s)) {
            let velocity = slave.velocity.unwrap_or_default().abs();
            (self.found).add(cycle, Invariant::ErrorLatch, velocity, 0.0);
        }
        let Some(stop) = &mut self.stop else {
            return;
        };
        // Each error stop is measured from its own beginning.
        let is_placed = slave.set_anew != before.set_anew || slave.set_back != before.set_back;
        if slave.state != AxisStatus::ErrorStop || is_placed || !is_next {
            let is_before = slave.state != AxisStatus::ErrorStop;
            stop.restart(set_of(slave).filter(|_| is_before));
        }
        let (AxisStatus::ErrorStop, Some(position)) = (slave.state, slave.position) else {
            return;
        };
        let set = Kinematics {
            position,
            velocity: slave.velocity.unwrap_or_default(),
            acceleration: slave.acceleration.unwrap_or_default(),
        };
        if let Some(DistanceExceeded { way, most }) =
            // With the distances: an axis that catches up goes on until its target has stopped.
            stop.push(&set, [before.distance, slave.distance])
        {
            self.found.add(cycle, Invariant::StoppingWay, way, most);
        }
    }
}

/// Set values; none if any is missing.
fn set_of(slave: &SlaveSignals) -> Option<Kinematics> {
    Some(Kinematics {
        position: slave.position?,
        velocity: slave.velocity?,
        acceleration: slave.acceleration?,
    })
}

fn resets_of(slave: &SlaveConfig, receiver: &ReceiverConfig, events: &[Event]) -> Vec<f64> {
    let is_reset = |event: &&Event| {
        let command = command_of(event, slave, receiver);
        matches!(command, Some(Command::Reset {}))
    };
    let resets = events.iter().filter(is_reset);
    resets.map(|event| f64::from(event.at_s)).collect()
}

fn profile_limits(parameters: &SlaveParameters) -> Option<Limits> {
    let SlaveParameters {
        velocity,
        acceleration,
        deceleration,
        jerk,
        ..
    } = *parameters;
    // As the slave itself takes a missing deceleration.
    let deceleration = deceleration.unwrap_or(acceleration);
    Limits::new(velocity, acceleration, deceleration, jerk).ok()
}

fn software_limits(parameters: &SlaveParameters) -> [f64; 2] {
    let min = parameters.min_position.unwrap_or(f64::NEG_INFINITY);
    [min, parameters.max_position.unwrap_or(f64::INFINITY)]
}

/// True if a slave in error stop may enter this state next.
const fn follows_error_stop(state: AxisStatus) -> bool {
    matches!(
        state,
        AxisStatus::ErrorStop | AxisStatus::Standstill | AxisStatus::Disabled
    )
}

/// The stop of a slave whose master is lost, with its full deceleration from the next cycle on.
fn is_quick_stop(slave: &SlaveSignals) -> bool {
    let quick = SlaveError::LOSSES_OF_MASTER.map(|error| error.code());
    slave.state == AxisStatus::ErrorStop && quick.contains(&slave.error)
}

/// The stop of a flying saw whose master runs back past the coupling position: it stands from one cycle to the
/// next.
fn is_instant_stop(before: &SlaveBefore, now: &SlaveSignals) -> bool {
    before.state == AxisStatus::SynchronizedMotion
        && matches!(
            now.state,
            AxisStatus::Standstill | AxisStatus::DiscreteMotion
        )
        // Another way from synchronised motion to discrete motion keeps its velocity.
        && now.velocity == Some(0.0)
}

/// Every command that a slave may get: by its program, or by an event.
fn commands_to<'a>(
    slave: &'a SlaveConfig,
    receiver: &'a ReceiverConfig,
    events: &'a [Event],
) -> impl Iterator<Item = &'a Command> {
    let of_program = slave.steps.iter().filter_map(StepConfig::slave_command);
    // An event may command what no program has.
    let of_events = (events.iter()).filter_map(move |event| command_of(event, slave, receiver));
    of_program.chain(of_events)
}

/// Command of an event to the slave.
fn command_of<'a>(
    event: &'a Event,
    slave: &SlaveConfig,
    receiver: &ReceiverConfig,
) -> Option<&'a Command> {
    match &event.what {
        EventKind::Command(commanded) if event.node == receiver.name => match &commanded.order {
            CommandOrder::Slave(order) if order.addressee.as_str() == slave.name.as_str() => {
                Some(&order.command)
            }
            CommandOrder::Slave(_) | CommandOrder::Plate(_) | CommandOrder::Far(_) => None,
        },
        _ => None,
    }
}

fn may_stop_instantly(command: &Command) -> bool {
    let mode = match command {
        Command::GearInPos(command) => command.sync_mode,
        Command::GearInVelo(command) => command.sync_mode,
        _ => return false,
    };
    mode.mask.contains(SyncMask::INSTANT_STOP_ON_ROLLBACK)
}

impl From<SetValueBound> for Invariant {
    fn from(bound: SetValueBound) -> Self {
        match bound {
            SetValueBound::Finite => Self::Finite,
            SetValueBound::Velocity => Self::Velocity,
            SetValueBound::Acceleration => Self::Acceleration,
            SetValueBound::Jerk => Self::Jerk,
            SetValueBound::SoftwareLimit => Self::SoftwareLimit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::parse;

    /// Swarm schedule 2530.
    #[test]
    fn a_node_that_stood_executes_the_resets_of_the_meantime_and_no_others() {
        let text = "name = 'saw'\ncycle-time-us = 1000\nmaster = { node = 'belt' }\n[[slave]]\nname = 'x'\n\
                    limits = { velocity = 500, acceleration = 1000, jerk = 1e5 }\n";
        let config: ReceiverConfig = parse("saw.toml", text).expect("a config");
        let is_found = |ordered: f64, moves: f64| {
            let text = format!(
                "at-s = {ordered}\nnode = 'saw'\nslave = 'x'\ncommand = {{ reset = {{}} }}"
            );
            let events = [toml::from_str(&text).expect("an event")];
            let mut watch = SlaveWatch::new(&config.slaves[0], &config, &events);
            for (number, t_s, state) in [
                (1, 5.0, AxisStatus::ErrorStop),
                (2, moves, AxisStatus::DiscreteMotion),
            ] {
                let slave = SlaveSignals {
                    state,
                    position: Some(0.0),
                    velocity: Some(0.0),
                    acceleration: Some(0.0),
                    ..SlaveSignals::default()
                };
                let since = Some(1);
                watch.push(&WatchedCycle { number, t_s, since }, &slave);
            }
            let of = crate::invariants::WatchedPart {
                receiver: "saw".to_owned(),
                part: None,
            };
            watch.found.violations(of).next().is_some()
        };
        // Set back by 2.7 s after the cycle of 5 s, it has its next one at 7.7 s.
        assert!(!is_found(6.0, 7.7));
        assert!(is_found(3.9, 5.001) && is_found(4.9, 7.7) && is_found(7.702, 7.7));
    }
}
