//! A time that nodes have in common, followed and contradicted.

use coaxle_clock::timing::TimingState;
use coaxle_lab::catalog;
use coaxle_lab::row::{Row, RowSink};
use coaxle_lab::virtual_time;

/// Time, s, from which far time is judged: messages alone are followed in the first seconds.
const SETTLED: f64 = 10.0;

/// Errors of the far time of one receiver, and when its clocks disagreed first.
#[derive(Clone, Debug, Default)]
struct FarTimeErrors {
    count: u64,
    squares: f64,
    largest: f64,
    largest_step: f64,
    last: Option<f64>,
    named_at: Option<f64>,
}

impl FarTimeErrors {
    fn take(&mut self, at: f64, row: &Row) {
        let far = &row.record.far;
        let disagrees = far.health.name() == "clocks-disagree";
        let is_contradicted = far.common_time_state == Some(TimingState::Contradicted);
        assert_eq!(disagrees, is_contradicted && far.synced, "at {at} s");
        if disagrees {
            self.named_at.get_or_insert(at);
        }
        let Some(error) = row.time_error_us.filter(|_| at > SETTLED) else {
            return;
        };
        self.count += 1;
        self.squares += error * error;
        self.largest = self.largest.max(error.abs());
        if let Some(last) = self.last.replace(error) {
            self.largest_step = self.largest_step.max((error - last).abs());
        }
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }
}

struct OfReceivers([FarTimeErrors; 5]);

impl RowSink for OfReceivers {
    fn row(&mut self, view: usize, row: &Row) {
        let at = row.record.node.cycle as f64 * 1e-3;
        self.0[view].take(at, row);
    }
}

#[test]
fn a_common_time_is_followed_and_named_where_ways_contradict_it() {
    let source = catalog::find("common-time").expect("a scenario of the catalogue");
    let scenario = source.read(&[]).expect("a scenario");
    let mut rows = OfReceivers(Default::default());
    virtual_time::run(&scenario, &mut rows, &mut ()).expect("it runs");
    let names: Vec<_> = scenario
        .receivers
        .iter()
        .map(|it| it.name.as_str())
        .collect();
    assert_eq!(names, ["agreed", "leaps", "runs-free", "strange", "ways"]);
    for (name, errors) in names.iter().zip(&rows.0) {
        assert!(errors.count > 49_000, "{name}: {}", errors.count);
    }
    let [agreed, leaps, runs_free, strange, ways] = &rows.0;
    assert!(agreed.rms() < 0.02, "{} us", agreed.rms());
    assert!(agreed.largest < 0.05, "{} us", agreed.largest);
    // It leaps at 50 s.
    let named = leaps.named_at.expect("it is named");
    assert!((50.0..60.0).contains(&named), "named at {named} s");
    assert!(leaps.largest < 0.2, "{} us", leaps.largest);
    // 0.5 ppm from 20 s on, until neither way leaves it room: half of the round trip, and what both state.
    let named = runs_free.named_at.expect("it is named");
    assert!((20.0..50.0).contains(&named), "named at {named} s");
    assert!(runs_free.largest < 8.0, "{} us", runs_free.largest);
    for (name, errors) in [("strange", strange), ("ways", ways)] {
        assert_eq!(errors.named_at, None, "{name}");
        assert!(
            errors.rms() > 2.0 * agreed.rms(),
            "{name}: {} us",
            errors.rms()
        );
    }
    for (name, errors) in names.iter().zip(&rows.0) {
        assert!(
            errors.largest_step < 0.1,
            "{name}: {} us",
            errors.largest_step
        );
    }
}

/// A master that goes to and fro, and everything that happens to a common time, to its channel, and to both nodes.
const IN_MOTION: &str = r#"
title = "common time in motion"
duration-s = 80
event = [
  { at-s = 8, node = "saw", action = "freeze", for-s = 0.06 },
  { at-s = 40, node = "saw", action = "restart", for-s = 0.5 },
  { at-s = 48, node = "line", action = "restart", for-s = 0.5 },
  { at-s = 56, node = "saw", far = "line", command = { disable = {} } },
  { at-s = 56.5, node = "saw", far = "line", command = { enable = {} } },
  { at-s = 62, node = "saw", far = "line", command = { set-delay = "off" } },
  { at-s = 66, node = "saw", far = "line", command = { set-delay = "measured" } },
]
[network]
latency-us = 300
jitter = { exponential-us = 30 }
loss = 0.01
[timing-network]
latency-us = 5
jitter = { exponential-us = 2 }
loss = 0.02
[[sender]]
name = "line"
cycle-time-us = 1000
clock = { drift-ppm = 80, random-walk-ppm = 0.01, common-time = { noise-us = 0.02 } }
timing = { listen = "127.0.0.1:7450" }
time = { ptp = "auto", bound-us = 0.2 }
[[sender.axis]]
id = 1
name = "belt"
[sender.axis.program]
start-velocity = 500
limits = { velocity = 1000, acceleration = 5000, jerk = 100000 }
steps = [
  { enable = true },
  { loop = { count = 1000, steps = [{ velocity = { value = 700, for-s = 0.45 } }, { velocity = { value = 300, for-s = 0.45 } }] } },
]
[[receiver]]
name = "saw"
cycle-time-us = 1000
master = { node = "line", axis = 1, limits = { velocity = 2000, acceleration = 20000, jerk = 1e6 } }
timing = { connect = "127.0.0.1:7450", faults = { partitions = [{ at-s = 34, for-s = 3 }] } }
time = { ptp = "auto", bound-us = 0.2 }
sync.time-sync = { age-of-data-limit = 2000, max-cycle-index-difference = 2000, automatic-re-init = true }
[receiver.clock]
drift-ppm = -20
start-phase-us = 350
[receiver.clock.common-time]
noise-us = 0.02
changes = [
  { at-s = 12, lost = true }, { at-s = 15, lost = false },
  { at-s = 18, grandmaster = "0000000000000002" }, { at-s = 21, grandmaster = "00005efffe000001" },
  { at-s = 24, offset-us = 20 }, { at-s = 29, offset-us = -20 },
]
[[receiver.slave]]
name = "roll"
gear = { ratio = 1.0 }
limits = { velocity = 2000, acceleration = 20000, jerk = 1e6, on-master-loss = "follow" }
"#;

/// States of the common time as they follow each other, and the greatest change of the error of far time in a cycle, µs.
#[derive(Default)]
struct InMotion {
    states: Vec<TimingState>,
    last: Option<(u64, u64, f64)>,
    largest_step: (f64, f64),
    largest: f64,
}

impl RowSink for InMotion {
    fn row(&mut self, _view: usize, row: &Row) {
        let (node, far) = (&row.record.node, &row.record.far);
        if let Some(state) = far.common_time_state
            && self.states.last() != Some(&state)
        {
            self.states.push(state);
        }
        let at = node.cycle as f64 * 1e-3;
        // A delay that is off is an error by its length.
        let is_led = row.record.axis.synced && far.enabled && !(61.9..70.0).contains(&row.t_s);
        let Some(error) = row.time_error_us.filter(|_| is_led) else {
            self.last = None;
            return;
        };
        if far.common_time_state == Some(TimingState::InUse) && far.slew_remaining_us == Some(0.0) {
            self.largest = self.largest.max(error.abs());
        }
        let run = far.epoch.unwrap_or_default();
        if let Some((of, cycle, before)) = self.last.replace((run, node.cycle, error))
            && of == run
            && node.cycle == cycle + 1
        {
            let step = (error - before).abs();
            if step > self.largest_step.0 {
                self.largest_step = (step, at);
            }
        }
    }
}

#[test]
fn in_motion_nothing_that_happens_to_it_moves_far_time_at_once() {
    let source = catalog::Source {
        name: "common-time-in-motion".to_owned(),
        file: "common-time-in-motion.toml".to_owned(),
        text: IN_MOTION.to_owned(),
    };
    let scenario = source.read(&[]).expect("a scenario");
    let mut rows = InMotion::default();
    virtual_time::run(&scenario, &mut rows, &mut ()).expect("it runs");
    // A correction is slewed by 0.1 % of a cycle, and noise is beside that.
    assert!(rows.largest_step.0 < 1.1, "{:?}", rows.largest_step);
    assert!(rows.largest < 0.5, "{} us", rows.largest);
    for state in [
        TimingState::InUse,
        TimingState::Held,
        TimingState::Contradicted,
    ] {
        assert!(
            rows.states.contains(&state),
            "{state:?} of {:?}",
            rows.states
        );
    }
    assert_eq!(rows.states.last(), Some(&TimingState::InUse));
    // The errors that it states, its axis and its slave are judged in each cycle.
    let summary = crate::common::run_source(&source, &[]);
    let failed: Vec<_> = summary.failed().map(ToString::to_string).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
