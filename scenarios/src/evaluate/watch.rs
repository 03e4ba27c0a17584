//! A receiver's slaves and far axes, watched for what must hold in every cycle.

mod axis;
mod found;
mod slave;

use coaxle_receiver::{ReceiverConfig, SignalRow, SlaveConfig};
use coaxle_sim::Shares;

use crate::event::Event;
use crate::invariants::{InvariantViolation, Watched};
use axis::AxisWatch;
use found::WatchedCycle;
use slave::SlaveWatch;

/// Watches a receiver.
#[derive(Debug)]
pub(super) struct ReceiverWatch {
    receiver: String,
    /// Its newest cycle.
    last: Option<u64>,
    slaves: Vec<SlaveWatch>,
    axes: Vec<AxisWatch>,
}

impl ReceiverWatch {
    /// `events` are those of the whole scenario: of commands it counts what they may lead to.
    pub(super) fn new(config: &ReceiverConfig, events: &[Event]) -> Self {
        let cycle_time = config.cycle_time_us.0.as_secs_f64();
        let slave = |slave: &SlaveConfig| SlaveWatch::new(slave, config, events);
        let axis = |((far, _, _), name)| AxisWatch::new(name, config.numbers_of(far), cycle_time);
        let names = config.far_axis_names();
        Self {
            receiver: config.name.to_string(),
            last: None,
            slaves: config.slaves.iter().map(slave).collect(),
            axes: config.far_axes().zip(names).map(axis).collect(),
        }
    }

    /// The next cycle, which ideally began so many s after the start of the run.
    pub(super) fn push(&mut self, t_s: f64, signals: &SignalRow) {
        let number = signals.node.cycle;
        let since = self.last.replace(number).and_then(|last| {
            let passed = number.checked_sub(last)?;
            u32::try_from(passed).ok().filter(|passed| *passed > 0)
        });
        let cycle = WatchedCycle { number, t_s, since };
        for (watch, slave) in self.slaves.iter_mut().zip(&signals.slaves) {
            watch.push(&cycle, slave);
        }
        for (watch, axis) in self.axes.iter_mut().zip(&signals.axes) {
            watch.push(&cycle, signals, axis);
        }
    }

    /// What the set positions of the n-th slave had at most of its limits; none if there is no such slave.
    pub(super) fn shares(&self, slave: usize) -> Option<Shares> {
        self.slaves.get(slave)?.shares()
    }

    /// What did not hold.
    pub(super) fn violations(&self) -> impl Iterator<Item = InvariantViolation> + '_ {
        let slaves = self.slaves.iter().map(|slave| (&slave.name, &slave.found));
        let axes = self.axes.iter().map(|axis| (&axis.name, &axis.found));
        slaves.chain(axes).flat_map(|(axis, found)| {
            found.violations(Watched {
                receiver: self.receiver.clone(),
                axis: axis.clone(),
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::invariants::Invariant;
    use coaxle_axis::AxisStatus;
    use coaxle_node::config::parse;
    use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals, NodeSignals, SlaveSignals};

    const CONFIG: &str = "name = 'saw'\ncycle-time-us = 1000\nmaster = { node = 'belt' }\n[[slave]]\nname = 'x'\n\
                          limits = { velocity = 500, acceleration = 1000, jerk = 1e5 }\n";

    /// The invariants that rows break, a cycle apart.
    fn broken(rows: impl IntoIterator<Item = SignalRow>) -> Vec<Invariant> {
        let config: ReceiverConfig = parse("saw.toml", CONFIG).expect("a config");
        let mut watch = ReceiverWatch::new(&config, &[]);
        for (cycle, mut row) in (1..).zip(rows) {
            row.node.cycle = cycle;
            watch.push(cycle as f64 * 1e-3, &row);
        }
        watch.violations().map(|found| found.invariant).collect()
    }

    fn row(slave: SlaveSignals, far: FarNodeSignals) -> SignalRow {
        SignalRow {
            node: NodeSignals::default(),
            far: [far].into(),
            axes: [FarAxisSignals::default()].into(),
            virtual_axes: [].into(),
            slaves: [slave].into(),
        }
    }

    fn in_state(state: AxisStatus, position: f64, velocity: f64) -> SignalRow {
        let slave = SlaveSignals {
            state,
            position: Some(position),
            velocity: Some(velocity),
            ..SlaveSignals::default()
        };
        row(slave, FarNodeSignals::default())
    }

    #[test]
    fn error_stop_is_left_for_rest_only() {
        use AxisStatus::{DiscreteMotion, ErrorStop, Standstill};
        let states =
            |states: &[AxisStatus]| broken(states.iter().map(|state| in_state(*state, 0.0, 0.0)));
        assert_eq!(
            states(&[DiscreteMotion, ErrorStop, ErrorStop, Standstill]),
            []
        );
        assert_eq!(
            states(&[ErrorStop, DiscreteMotion]),
            [Invariant::ErrorLatch]
        );
    }

    #[test]
    fn error_stop_comes_to_rest() {
        let on = (0..200).map(|k| in_state(AxisStatus::ErrorStop, 0.3 * f64::from(k), 300.0));
        assert_eq!(broken(on), [Invariant::StoppingWay]);
    }

    #[test]
    fn a_count_goes_back_with_another_run_only() {
        let used = |used: &[(u64, u64)]| {
            let row = |(epoch, count): &(u64, u64)| {
                let far = FarNodeSignals {
                    followed: true,
                    epoch: Some(*epoch),
                    count: Some(*count),
                    ..FarNodeSignals::default()
                };
                row(SlaveSignals::default(), far)
            };
            broken(used.iter().map(row))
        };
        assert_eq!(used(&[(1, 5), (1, 5), (1, 7), (2, 0), (2, 1)]), []);
        assert_eq!(used(&[(1, 5), (1, 4)]), [Invariant::Count]);
    }
}
