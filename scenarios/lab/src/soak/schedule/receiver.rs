//! Receivers of a schedule: their masters and their modes.

use std::fmt::Write as _;

use super::{Draw as _, Follows, PLATES, SoakSchedule, TIME_SYNC};

impl SoakSchedule {
    pub(super) fn receiver(&mut self, receiver: u64, follows: &Follows) {
        let name = format!("follower{receiver}");
        let (source, cycle) = match follows {
            Follows::Sender { sender, cycle } => (
                format!(
                    "{{ node = 'line{sender}', axis = {}{}{} }}",
                    self.random.whole(1, 2),
                    self.wide.modulo(),
                    self.wide.far_limits(),
                ),
                *cycle,
            ),
            Follows::Receiver { cycle } => (
                "{ node = 'follower0', channel = 'slaves', axis = 1 }".to_owned(),
                *cycle,
            ),
        };
        // The observer is the default, and is drawn three times as often.
        let mode = *self.random.one_of(&[
            "observer", "observer", "observer", "sync", "time", "bypass", "pt1",
        ]);
        let mode = self.wide.mode(mode);
        let drift = match (self.random.between(-100.0, 100.0), follows) {
            (drift, Follows::Sender { .. }) => drift,
            // Far enough from the clock that it follows for a beat every few seconds.
            (drift, Follows::Receiver { .. }) => (500.0 + 3.0 * drift.abs()).copysign(drift),
        };
        let clock = self.clock(drift);
        let delay = match self.random.below(4) {
            0 => "'off'".to_owned(),
            1 => format!("{{ fixed-us = {:.1} }}", self.random.between(0.0, 3_000.0)),
            _ => "'measured'".to_owned(),
        };
        let delay = if mode == "observer" {
            format!("delay = {delay}\n")
        } else {
            String::new()
        };
        let faults = self.faults();
        let present = self.extra_draws.present();
        let lag = self.extra_draws.lag();
        let time_sync = self
            .wide
            .time_sync()
            .unwrap_or_else(|| TIME_SYNC.to_owned());
        let _ = write!(
            self.text,
            "\n[[receiver]]\nname = '{name}'\ncycle-time-us = {cycle}\nmode = '{mode}'\n{present}{lag}master = {source}\n{clock}{delay}{PLATES}\
             sync.time-sync = {time_sync}\n{faults}"
        );
        for slave in 0..self.random.whole(1, 3) {
            self.slave(&name, slave);
        }
        self.life_of(&name, &["restart", "freeze"]);
        for (at, how_long) in self.wide.stops() {
            let _ = write!(
                self.events,
                "\n[[event]]\nat-s = {at:.3}\nnode = '{name}'\naction = 'stop'\nfor-s = {how_long:.3}\n"
            );
        }
        let far = match follows {
            Follows::Sender { sender, .. } => format!("line{sender}"),
            Follows::Receiver { .. } => "follower0".to_owned(),
        };
        self.orders_about(&name, &far, mode);
    }
}
