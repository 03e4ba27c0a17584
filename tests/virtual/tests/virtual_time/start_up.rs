//! Axes while their clocks are not known yet: no step, whatever is missing.

use coaxle_lab::catalog::Source;
use coaxle_lab::row::{Row, RowSink};
use coaxle_lab::virtual_time;

/// A master that goes to and fro between 300 and 700 u/s, on a PC that stands still for 30 to 80 ms again and again.
const TEXT: &str = r#"
title = "start-up"
duration-s = 20
event = [
  { at-s = 0.3, node = "line", action = "freeze", for-s = 0.05 },
  { at-s = 0.7, node = "line", action = "freeze", for-s = 0.08 },
  { at-s = 1.1, node = "line", action = "freeze", for-s = 0.03 },
  { at-s = 1.5, node = "saw", action = "freeze", for-s = 0.05 },
  { at-s = 8.0, node = "line", action = "freeze", for-s = 0.09 },
  { at-s = 10.0, node = "saw", far = "line", command = { disable = {} } },
  { at-s = 10.5, node = "saw", far = "line", command = { enable = {} } },
  { at-s = 10.6, node = "line", action = "freeze", for-s = 0.06 },
  { at-s = 12.0, node = "saw", action = "freeze", for-s = 0.08 },
  { at-s = 14.0, node = "saw", action = "restart", for-s = 0.5 },
  { at-s = 14.8, node = "line", action = "freeze", for-s = 0.07 },
  { at-s = 15.2, node = "saw", far = "line", command = { set-parameters = { time-sync = { threshold-for-sync = 0.06 } } } },
  { at-s = 15.3, node = "line", action = "freeze", for-s = 0.05 },
]
[network]
latency-us = 300
jitter = { exponential-us = 50 }
[[sender]]
name = "line"
cycle-time-us = 1000
clock = { drift-ppm = 80 }
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
master = { node = "line", axis = 1 }
clock = { drift-ppm = -20, start-phase-us = 350 }
"#;

/// Positions of a far axis and of its master, by run and cycle of the receiver, once it is shown.
#[derive(Default)]
struct ShownPositions(Vec<(u64, u64, f64, f64)>);

impl RowSink for ShownPositions {
    fn row(&mut self, _view: usize, row: &Row) {
        let shown = row.record.axis.corrected_position;
        // Disabled it passes what comes, with its beats.
        let is_enabled = row.record.far.enabled;
        if let (Some(shown), Some((truth, _)), true) = (shown, row.truth, is_enabled) {
            let node = &row.record.node;
            self.0.push((node.run, node.cycle, shown, truth));
        }
    }
}

#[test]
fn a_start_with_silences_has_no_step_and_stays_with_its_master() {
    let source = Source {
        name: "start-up".to_owned(),
        file: "start-up.toml".to_owned(),
        text: TEXT.to_owned(),
    };
    let scenario = source.read(&[]).expect("a scenario");
    let mut rows = ShownPositions::default();
    virtual_time::run(&scenario, &mut rows, &mut ()).expect("it runs");
    assert!(rows.0.len() > 18_000, "{} cycles are shown", rows.0.len());
    for pair in rows.0.windows(2) {
        let [(run, cycle, shown, _), (next_run, next, then, truth)] = [pair[0], pair[1]];
        if run != next_run || next - cycle > 200 {
            continue;
        }
        let velocity = (then - shown) / (1e-3 * (next - cycle) as f64);
        // A correction of up to a cycle, faded in over 60, and 80 ms of 5 m/s², 16 mm, that are brought in likewise.
        assert!(
            (150.0..1_100.0).contains(&velocity),
            "{next}: {velocity} u/s"
        );
        assert!(
            (then - truth).abs() < 20.0,
            "{next}: {then}, master at {truth}"
        );
    }
}
