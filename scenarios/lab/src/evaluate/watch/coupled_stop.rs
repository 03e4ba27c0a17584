//! Masters whose followers have failed: they come to rest, and stay there.

use coaxle_receiver::ReceiverConfig;
use coaxle_receiver::config::{FarChannel, MasterRef};
use coaxle_receiver::signals::SlaveSignals;
use coaxle_source::config::{AxisConfig, FollowersConfig, OnFailure};

use super::found::{Found, WatchedCycle};
use crate::invariants::{Invariant, InvariantViolation, WatchedPart};
use crate::scenario::Scenario;

/// Time within which a master rests, beside its age limit for silent followers and the lead of what it has promised, s.
// Reports come every 50 ms, and what a network loses for longer is a silence. The rest is the ramp, which the slowest follower decides: that of
// random schedules takes up to 5 s.
const RESTS_WITHIN: f64 = 10.0;
/// Time between two cycles of a node from which it stood still, s.
const PAUSE: f64 = 0.5;

/// Watches the masters of a run that stop with their followers.
#[derive(Debug)]
pub(in super::super) struct CoupledStopWatch(Vec<FollowedMaster>);

/// A master that stops with its followers.
#[derive(Debug)]
struct FollowedMaster {
    of: WatchedPart,
    sender: usize,
    axis: u32,
    /// Time within which it rests, s.
    within: f64,
    /// Slaves that it leads, by the numbers of their receivers and their own.
    slaves: Vec<WatchedSlave>,
    run: MasterRun,
    found: Found,
}

/// Present run of a master, s.
#[derive(Clone, Copy, Debug, Default)]
struct MasterRun {
    number: u64,
    since: f64,
    last: f64,
}

#[derive(Debug)]
struct WatchedSlave {
    receiver: usize,
    slave: usize,
    /// Time since which it is in error, s.
    in_error_since: Option<f64>,
}

impl CoupledStopWatch {
    /// Creates the watch of a scenario.
    pub(in super::super) fn new(scenario: &Scenario) -> Self {
        let senders = scenario.senders.iter().enumerate();
        let axes = senders.flat_map(|(sender, config)| {
            let axes = config.axes.iter();
            axes.filter_map(move |axis| FollowedMaster::new(scenario, sender, axis))
        });
        Self(axes.collect())
    }

    /// Takes the slaves of a receiver's cycle, at a time, s.
    pub(in super::super) fn push_slaves(
        &mut self,
        receiver: usize,
        t_s: f64,
        slaves: &[SlaveSignals],
    ) {
        let watched = self.0.iter_mut().flat_map(|master| &mut master.slaves);
        for slave in watched.filter(|slave| slave.receiver == receiver) {
            let is_in_error = slaves
                .get(slave.slave)
                .is_some_and(|slave| slave.error != 0);
            slave.in_error_since = is_in_error.then(|| slave.in_error_since.unwrap_or(t_s));
        }
    }

    /// Checks a cycle of a sender's axis, with its run and its velocity.
    pub(in super::super) fn push_master(
        &mut self,
        (sender, axis): (usize, u32),
        (run, number): (u64, u64),
        t_s: f64,
        velocity: f64,
    ) {
        let is_it = |master: &&mut FollowedMaster| (master.sender, master.axis) == (sender, axis);
        if let Some(master) = self.0.iter_mut().find(is_it) {
            master.push((run, number), t_s, velocity);
        }
    }

    /// Violations by all masters.
    pub(in super::super) fn violations(&self) -> impl Iterator<Item = InvariantViolation> {
        let masters = self.0.iter();
        masters.flat_map(|master| master.found.violations(master.of.clone()))
    }
}

impl FollowedMaster {
    /// Absent for an axis that stops with nobody.
    fn new(scenario: &Scenario, sender: usize, axis: &AxisConfig) -> Option<Self> {
        let followers = axis.followers.as_ref();
        let followers = followers.filter(|one| one.on_failure != OnFailure::Ignore)?;
        let name = &scenario.senders[sender].name;
        let within = RESTS_WITHIN + (followers.age_limit() + axis.lead()).as_secs_f64();
        Some(Self {
            of: WatchedPart {
                receiver: name.to_string(),
                part: Some(axis.name.to_string()),
            },
            sender,
            axis: axis.id.get(),
            within,
            slaves: slaves_of(scenario, name.as_str(), axis.id.get(), followers),
            run: MasterRun::default(),
            found: Found::default(),
        })
    }

    fn push(&mut self, (run, number): (u64, u64), t_s: f64, velocity: f64) {
        // A run that has just begun hears of its followers first, and one that stood still hears late.
        if run != self.run.number || t_s - self.run.last > PAUSE {
            self.run.since = t_s;
        }
        (self.run.number, self.run.last) = (run, t_s);
        let failed = self.slaves.iter().filter_map(|slave| slave.in_error_since);
        let Some(first) = failed.reduce(f64::min) else {
            return;
        };
        if velocity != 0.0 && t_s - first.max(self.run.since) > self.within {
            let cycle = WatchedCycle {
                number,
                t_s,
                since: None,
            };
            (self.found).add(&cycle, Invariant::CoupledStop, velocity.abs(), 0.0);
        }
    }
}

/// Slaves whose master is an axis of a sender, of the receivers that are its followers.
fn slaves_of(
    scenario: &Scenario,
    sender: &str,
    axis: u32,
    followers: &FollowersConfig,
) -> Vec<WatchedSlave> {
    let receivers = scenario.receivers.iter().enumerate();
    let receivers = receivers.filter(|(_, config)| followers.nodes.contains(&config.name));
    let slaves = receivers.flat_map(|(receiver, config)| {
        let slaves = 0..config.slaves.len();
        let slaves = slaves.filter(|slave| follows(config, *slave, sender, axis));
        slaves.map(move |slave| WatchedSlave {
            receiver,
            slave,
            in_error_since: None,
        })
    });
    slaves.collect()
}

/// True if a slave has the axis of a sender for a master, without another slave between them.
fn follows(config: &ReceiverConfig, slave: usize, sender: &str, id: u32) -> bool {
    let masters = config.masters_of(slave).unwrap_or_default();
    masters.into_iter().any(|master| {
        let MasterRef::Far(number) = master else {
            return false;
        };
        config.far_axes().nth(number).is_some_and(|(_, far, axis)| {
            far.node.as_str() == sender && far.channel == FarChannel::Axes && axis.id == id
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Source;

    fn watch(on_failure: &str) -> CoupledStopWatch {
        let text = format!(
            "title = 'stop'\nduration-s = 1\n[[sender]]\nname = 'a'\ncycle-time-us = 1000\n\
             [[sender.axis]]\nid = 3\nname = 'x'\nlead-ms = 200\n\
             followers = {{ nodes = ['b'], on-failure = '{on_failure}', age-limit-ms = 300 }}\n\
             program.start-velocity = 1.0\n\
             program.limits = {{ velocity = 2.0, acceleration = 3.0, jerk = 4.0 }}\n\
             [[receiver]]\nname = 'b'\ncycle-time-us = 1000\n\
             [[receiver.far]]\nnode = 'a'\naxes = [{{ id = 3, name = 'x' }}]\n\
             [[receiver.slave]]\nname = 's'\n\
             limits = {{ velocity = 2.0, acceleration = 3.0, jerk = 4.0 }}\n"
        );
        let source = Source {
            name: "stop".to_owned(),
            file: "stop.toml".to_owned(),
            text,
        };
        let scenario = source.read(&[]).unwrap_or_else(|error| panic!("{error:#}"));
        CoupledStopWatch::new(&scenario)
    }

    /// Time of the first violation by a master that does not stop, whose slave is in error from 5 s on, s; its run begins at the times `runs`.
    fn found(on_failure: &str, until: f64, runs: &[f64]) -> Option<f64> {
        let mut watch = watch(on_failure);
        for cycle in 0..3_000_u32 {
            let t_s = 0.01 * f64::from(cycle);
            let error = if (5.0..until).contains(&t_s) {
                0x4b09
            } else {
                0
            };
            let slave = SlaveSignals {
                error,
                ..SlaveSignals::default()
            };
            watch.push_slaves(0, t_s, &[slave]);
            let run = runs.iter().filter(|from| t_s >= **from).count() as u64;
            watch.push_master((0, 3), (run, u64::from(cycle)), t_s, 1.0);
        }
        let first = watch.violations().next()?;
        assert_eq!(
            (first.of.receiver.as_str(), first.of.part.as_deref()),
            ("a", Some("x"))
        );
        Some(first.first.t_s)
    }

    #[test]
    fn a_master_that_goes_on_beside_a_slave_in_error_is_found() {
        // 10 s, the age limit and the lead.
        let at = found("stop", 30.0, &[0.0]).expect("it never stops");
        assert!((15.5..15.53).contains(&at), "{at}");
        assert!(found("halt", 30.0, &[0.0]).is_some());
        assert_eq!(found("ignore", 30.0, &[0.0]), None);
        // The slave was reset in time.
        assert_eq!(found("stop", 15.0, &[0.0]), None);
        // Its sender was started again.
        let at = found("stop", 30.0, &[0.0, 10.0]).expect("it never stops");
        assert!((20.5..20.53).contains(&at), "{at}");
    }
}
