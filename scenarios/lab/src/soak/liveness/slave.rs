//! A slave at the end: coupled, it is where its coupling has it.

use coaxle_axis::AxisStatus;
use coaxle_curve::profile::Limits;
use coaxle_receiver::SlaveConfig;
use coaxle_receiver::config::MasterRef;
use coaxle_receiver::signals::SlaveSignals;
use coaxle_sim::LargestLately;
use coaxle_slave::CouplingPhase;

use super::rough::RoughTarget;
use super::tolerance;
use super::way::{self, HALF, Way};

/// Time before the end in which the target of a slave is slow, unless something says why not, s: all commands have been carried out.
// The last couplings begin at 62 s, with the limits of the axis; those with less, down to a fiftieth, by 32 s: 500/(0.02 · 500) = 50 s.
const LAST: f64 = 5.0;

/// Motion of a far axis, as far as a slave behind it can follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TargetMotion {
    /// By a clock, from a master in a slow and steady motion.
    Even,
    /// By a clock, from a node that follows another one: that may be brought back, or go to and fro.
    Relayed,
    /// In beats: shown as it comes.
    Beats,
}

/// Watches a slave.
#[derive(Debug)]
pub(super) struct SlaveLiveness {
    pub(super) name: String,
    /// True if its master is another slave, which may itself be on the way.
    follows_slave: bool,
    limits: Option<Limits>,
    way: Way,
    /// Time, position of its target and run of its receiver in the cycle before.
    before: Option<(f64, f64, u64)>,
    /// The part of its target's motion that is beyond its limits, and its velocity in the cycle before, u/s.
    rough: Option<RoughTarget>,
    velocity: Option<f64>,
    /// Longest recent way of its target in a cycle, u.
    beat: LargestLately,
    /// Newest velocity of its target beyond half of its limit, u/s, and its time, s.
    too_fast: Option<(f64, f64)>,
    last: Option<(f64, SlaveSignals)>,
}

impl SlaveLiveness {
    pub(super) fn new(config: &SlaveConfig, master: Option<MasterRef>) -> Self {
        let limits = config.limits();
        let deceleration = limits.deceleration.unwrap_or(limits.acceleration);
        // A config with other limits is refused.
        let limits = Limits::new(
            limits.velocity,
            limits.acceleration,
            deceleration,
            limits.jerk,
        )
        .ok();
        Self {
            name: config.name.to_string(),
            follows_slave: matches!(master, Some(MasterRef::Slave(_))),
            limits,
            way: Way::new(0.0, 0.0),
            before: None,
            rough: limits.map(RoughTarget::new),
            velocity: None,
            beat: LargestLately::over(LAST),
            too_fast: None,
            last: None,
        }
    }

    pub(super) fn push(&mut self, t_s: f64, run: u64, slave: &SlaveSignals) {
        let before = self.last.replace((t_s, *slave));
        let Some(position) = slave.position else {
            self.before = None;
            return;
        };
        let target = position - slave.distance;
        let last = self.before.replace((t_s, target, run));
        let most = self
            .limits
            .map_or(f64::INFINITY, |limits| limits.velocity());
        // A row after a jump of the clock may be closer than a cycle.
        let last = last.filter(|(at, _, of)| *of == run && t_s > *at);
        self.take_motion(t_s, target, last);
        let moved = last.map_or(0.0, |(_, before, _)| (target - before).abs());
        let velocity = last.map_or(0.0, |(at, ..)| moved / (t_s - at));
        self.beat
            .push(moved, before.map_or(0.0, |(at, _)| t_s - at));
        let is_too_fast = velocity > HALF * most;
        if is_too_fast {
            self.too_fast = Some((velocity, t_s));
        }
        let is_another = before.is_none_or(|(_, before)| {
            before.set_anew != slave.set_anew || before.state != slave.state
        });
        let distance = slave.distance.abs();
        if is_too_fast || is_another || distance <= tolerance(position) {
            self.way = Way::new(t_s, distance);
        } else {
            self.way.note(distance);
        }
    }

    /// Takes the motion of its target, by the differences of its positions, from the `last` cycle on.
    fn take_motion(&mut self, t_s: f64, target: f64, last: Option<(f64, f64, u64)>) {
        let Some(rough) = &mut self.rough else {
            return;
        };
        rough.advance(t_s);
        let velocity = last.map(|(at, before, _)| (t_s - at, (target - before) / (t_s - at)));
        let before = std::mem::replace(&mut self.velocity, velocity.map(|(_, velocity)| velocity));
        if let (Some((passed, velocity)), Some(before)) = (velocity, before) {
            rough.push(velocity, (velocity - before) / passed, false);
        }
    }

    /// True if it has set values, which it publishes.
    pub(super) fn has_set_values(&self) -> bool {
        (self.last).is_some_and(|(_, slave)| slave.position.is_some())
    }

    /// Fault at the end, if any, behind a far axis with this motion.
    pub(super) fn broken(&self, of_axis: TargetMotion) -> Option<String> {
        let is_even = of_axis == TargetMotion::Even;
        let (t_s, slave) = self.coupled()?;
        let position = slave.position?;
        let distance = slave.distance.abs();
        // A target in beats is on either side of the motion that it is of, by up to a beat, and a slave that cannot step goes on between
        // them: swarm schedules 2726, 2799 and 3279.
        let beat = if is_even { 0.0 } else { self.beat.largest() };
        // A chain hands on what one of its axes cannot follow: in swarm schedule 90356, two receivers behind one in `bypass`, the target was accelerated by up to
        // 3300 u/s², more than five times what the slave may. Steps have no velocity that would say how far it gets.
        let rough = self.rough.filter(|_| of_axis == TargetMotion::Relayed);
        let rough = rough.and_then(|rough| rough.beside(t_s, 0.0));
        if distance <= tolerance(position) + beat.max(rough.unwrap_or(0.0)) {
            return None;
        }
        let (limits, way) = (self.limits?, self.way);
        let too_fast = self.too_fast.filter(|(_, at)| t_s - at < LAST);
        if let Some((velocity, at)) = too_fast.filter(|_| is_even && !self.follows_slave) {
            return Some(format!(
                "is not where its coupling has it: {distance:.6} u away at the end, as its target moved at {velocity:.3} u/s at {at:.3} s, \
                 which its master does not"
            ));
        }
        let (had, longest) = (t_s - way.since, way::within(&limits, way.distance));
        (had > longest).then(|| {
            format!(
                "is not where its coupling has it: {distance:.6} u away at the end, after {:.6} u at {:.3} s, it takes {longest:.3} s \
                 at most, and had {had:.3} s",
                way.distance, way.since
            )
        })
    }

    /// What it waits for at the end, if it waits.
    pub(super) fn waits_for(&self) -> Option<String> {
        let (_, slave) = self.coupled()?;
        let queued = [
            (slave.cam_table_queued, "a plate"),
            (slave.cam_data_queued, "points"),
            (slave.cam_scaling_pending, "a scaling"),
        ];
        let master = slave.master_position.unwrap_or_default();
        if let Some((_, what)) = queued.iter().find(|(is_queued, _)| *is_queued) {
            return Some(format!(
                "waits for the moment of {what}, its master at {master:.3}"
            ));
        }
        if slave.phase.is_none_or(CouplingPhase::is_in_sync) {
            return None;
        }
        let at = match slave.master_sync_position {
            Some(sync) => format!(", to be in sync at {sync:.3}"),
            None => String::new(),
        };
        let phase = slave.phase?;
        Some(format!("is {phase:?} with its master at {master:.3}{at}"))
    }

    /// The last cycle of a slave that is coupled, has power and no error.
    fn coupled(&self) -> Option<(f64, &SlaveSignals)> {
        let (t_s, slave) = self.last.as_ref()?;
        let is_coupled = slave.state == AxisStatus::SynchronizedMotion && slave.error == 0;
        is_coupled.then_some((*t_s, slave))
    }
}
