//! Senders of a schedule: their clocks, their axes and their absences.

use std::fmt::Write as _;

use super::{Draw as _, QUIET_FROM, SoakSchedule};

impl SoakSchedule {
    pub(super) fn sender(&mut self, sender: u64, cycle: u64) {
        let name = format!("line{sender}");
        // At least 150 ppm from the receivers' ±100: a beat of TS5066 at least every 13 s at 2 ms, and mostly within 4.
        let drift = self.random.one_of(&[-1.0, 1.0]) * self.random.between(250.0, 800.0);
        let clock = self.clock(drift);
        let _ = write!(
            self.text,
            "\n[[sender]]\nname = '{name}'\ncycle-time-us = {cycle}\n{clock}"
        );
        let later = self.extra_draws.present_after(cycle);
        for axis in 1..=2 {
            self.axis(axis, &later);
        }
        self.life_of(&name, &["restart", "freeze", "twin"]);
    }

    /// A clock that drifts, and steps during the faulty phase.
    pub(super) fn clock(&mut self, drift: f64) -> String {
        let mut clock = format!(
            "clock = {{ drift-ppm = {drift:.1}, start-phase-us = {}, jitter = {{ exponential-us = {} }}",
            self.random.whole(0, 900),
            self.random.whole(1, 60),
        );
        if self.random.chance(0.3) {
            let _ = write!(
                clock,
                ", random-walk-ppm = {:.2}",
                self.random.between(0.01, 1.0)
            );
        }
        let mut steps = Vec::new();
        if self.random.chance(0.4) {
            steps.push(self.clock_step());
        }
        steps.extend(self.extra_draws.step_back());
        if !steps.is_empty() {
            let _ = write!(clock, ", steps = [{}]", steps.join(", "));
        }
        if let Some(terms) = self.extra_draws.drift_terms() {
            let _ = write!(clock, ", {terms}");
        }
        clock + " }\n"
    }

    /// A step of a clock during the faulty phase, in phase and drift.
    pub(super) fn clock_step(&mut self) -> String {
        let phase = self.random.between(1.0, 50_000.0);
        let drift = self.random.between(-100.0, 100.0);
        let at = self.moment(QUIET_FROM);
        format!("{{ at-s = {at}, phase-us = {phase:.1}, drift-ppm = {drift:.1} }}")
    }

    fn axis(&mut self, id: u64, later: &str) {
        if let Some(axis) = self.wide.axis() {
            let _ = write!(
                self.text,
                "\n[[sender.axis]]\nid = {id}\nname = 'axis {id}'\nunit = 'mm'\n{later}{axis}"
            );
            return;
        }
        let is_encoder = self.random.chance(0.3);
        let place = if is_encoder {
            "encoder.program"
        } else {
            "program"
        };
        let _ = write!(
            self.text,
            "\n[[sender.axis]]\nid = {id}\nname = 'axis {id}'\nunit = 'mm'\n{later}"
        );
        if is_encoder {
            let resolution = self.random.one_of(&[0.001, 0.01, 0.1]);
            let window = self.random.whole(1, 16);
            let differentiated = self.random.chance(0.3);
            let _ = write!(
                self.text,
                "encoder.resolution = {resolution}\nencoder.velocity-window-cycles = {window}\n\
                 encoder.differentiate-acceleration = {differentiated}\n"
            );
        }
        let start = self.random.between(-400.0, 400.0);
        let _ = write!(
            self.text,
            "{place}.start-velocity = {start:.1}\n{place}.limits = {{ velocity = 500, acceleration = {}, jerk = {} \
             }}\n{place}.repeat = true\n{place}.steps = [\n  {{ enable = true }},\n",
            self.random.whole(500, 3_000),
            self.random.whole(5_000, 60_000),
        );
        for _ in 0..self.random.whole(1, 4) {
            let step = match self.random.below(4) {
                0 => format!(
                    "{{ move-relative = {{ distance = {:.1} }} }}",
                    self.random.between(-900.0, 900.0)
                ),
                1 => format!(
                    "{{ dwell = {{ for-s = {:.3} }} }}",
                    self.random.between(0.1, 2.0)
                ),
                _ => format!(
                    "{{ velocity = {{ value = {:.1}, for-s = {:.3} }} }}",
                    self.random.between(-450.0, 450.0),
                    self.random.between(0.2, 3.0)
                ),
            };
            let _ = writeln!(self.text, "  {step},");
        }
        // A step of zero length would run for ever within a cycle.
        self.add("  { dwell = { for-s = 0.2 } },\n]\n");
    }

    /// Absences of a node during the faulty phase.
    pub(super) fn life_of(&mut self, node: &str, actions: &[&str]) {
        for action in actions {
            if !self.random.chance(0.3) {
                continue;
            }
            // An absence takes up to 2.5 s, and is over before the quiet phase.
            let drawn = self.random.between(1.0, QUIET_FROM - 3.0);
            let at = self.wide.moment(drawn, QUIET_FROM - 3.0);
            // Half of them are within the silence that the blocks tolerate: others meet timeouts.
            let how_long = if self.random.chance(0.5) {
                self.random.between(0.002, 0.2)
            } else {
                self.random.between(0.2, 2.5)
            };
            let _ = write!(
                self.events,
                "\n[[event]]\nat-s = {at:.3}\nnode = '{node}'\naction = '{action}'\nfor-s = {how_long:.3}\n"
            );
        }
    }
}
