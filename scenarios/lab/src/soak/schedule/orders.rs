//! Orders about the nodes that a receiver of a schedule follows.

use std::fmt::Write as _;

use super::{Draw as _, QUIET_FROM, SoakSchedule};

impl SoakSchedule {
    /// Commands about the node that a receiver follows. In the end it follows it as configured.
    pub(super) fn orders_about(&mut self, receiver: &str, far: &str, mode: &str) {
        // Before the quiet phase, at the end of which the configured mode has to be in sync.
        let last = QUIET_FROM - 0.1;
        let tell = |events: &mut String, at: f64, command: &str| {
            let _ = write!(
                events,
                "\n[[event]]\nat-s = {at:.3}\nnode = '{receiver}'\nfar = '{far}'\ncommand = {{ {command} }}\n"
            );
        };
        if self.random.chance(0.6) {
            return;
        }
        for _ in 0..self.random.whole(1, 4) {
            let at = self.random.between(0.5, last);
            let fixed = self.random.between(0.0, 2_000.0);
            let other = *self
                .random
                .one_of(&["bypass", "pt1", "sync", "time", "observer"]);
            let command = match self.random.below(6) {
                0 => "disable = {}".to_owned(),
                1 => "enable = {}".to_owned(),
                2 => "re-initialise = {}".to_owned(),
                3 => format!("set-delay = {{ fixed-us = {fixed:.1} }}"),
                _ => format!("filter-mode = '{other}'"),
            };
            tell(&mut self.events, at, &command);
        }
        tell(&mut self.events, last, "enable = {}");
        tell(&mut self.events, last, &format!("filter-mode = '{mode}'"));
    }
}
