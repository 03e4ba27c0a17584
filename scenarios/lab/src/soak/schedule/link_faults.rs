//! Faults of the links of a schedule.

use coaxle_node::faults::Random;

use super::{Draw as _, QUIET_FROM, SoakSchedule};

impl SoakSchedule {
    /// Faults of a link.
    pub(super) fn faults(&mut self) -> String {
        let mut faults = self.delays_and_losses();
        if !self.random.chance(0.6) {
            self.forged(&mut faults);
        }
        faults.extend(self.extra_draws.delay_terms());
        format!(
            "faults = {{ {}, faults-until-s = {QUIET_FROM} }}\n",
            faults.join(", ")
        )
    }

    /// Loss, duplication, order and delays of a link.
    pub(super) fn delays_and_losses(&mut self) -> Vec<String> {
        let mut faults = Vec::new();
        let mut share = |name: &str, random: &mut Random, most: f64| {
            if random.chance(0.5) {
                faults.push(format!("{name} = {:.3}", random.between(0.0, most)));
            }
        };
        share("loss", &mut self.random, 0.7);
        share("duplication", &mut self.random, 0.5);
        share("reorder", &mut self.random, 0.5);
        faults.push(format!(
            "reorder-us = {}",
            self.random.whole(1_000, 500_000)
        ));
        if self.random.chance(0.4) {
            let (share, most) = (
                self.random.between(0.0, 0.05),
                self.random.whole(5_000, 200_000),
            );
            faults.push(format!(
                "spikes = {{ share = {share:.4}, from-us = 1000, to-us = {most} }}"
            ));
        }
        if self.random.chance(0.4) {
            // Lasting ones, limited by the network to non-negative delays.
            let steps: Vec<_> = (0..self.random.whole(1, 2))
                .map(|_| {
                    let by = self.random.between(-50_000.0, 50_000.0);
                    format!("{{ at-s = {}, by-us = {by:.1} }}", self.moment(QUIET_FROM))
                })
                .collect();
            faults.push(format!(
                // Room for steps back.
                "latency-us = 20000, delay-steps = [{}]",
                steps.join(", ")
            ));
        }
        if self.random.chance(0.4) {
            // Up to 2 s, and so over before the quiet phase.
            let how_long = self.random.between(0.01, 2.0);
            let at = self.moment(QUIET_FROM - 2.0);
            faults.push(format!(
                "partitions = [{{ at-s = {at}, for-s = {how_long:.3} }}]"
            ));
        }
        self.losses_and_delays(&mut faults);
        faults
    }

    fn losses_and_delays(&mut self, faults: &mut Vec<String>) {
        if self.random.chance(0.3) {
            let corruption = self.random.between(0.0, 0.2);
            faults.push(format!("corruption = {corruption:.3}"));
        }
        if self.random.chance(0.3) {
            let (begins, ends) = (
                self.random.between(0.0, 0.02),
                self.random.between(0.01, 0.5),
            );
            faults.push(format!(
                "burst-loss = {{ begins = {begins:.4}, ends = {ends:.3} }}"
            ));
        }
        if self.random.chance(0.2) {
            let (sigma, time) = (self.random.whole(1, 100), self.random.between(0.1, 10.0));
            faults.push(format!(
                "correlated = {{ sigma-us = {sigma}, time-s = {time:.2} }}"
            ));
        }
        if self.random.chance(0.2) {
            let resolution = self.random.whole(1, 100);
            faults.push(format!("resolution-us = {resolution}"));
        }
        if self.random.chance(0.3) {
            let (at, length) = (
                self.moment(QUIET_FROM - 2.0),
                self.random.between(0.005, 2.0),
            );
            faults.push(format!("stalls = [{{ at-s = {at}, for-s = {length:.3} }}]"));
        }
    }

    /// Messages that no node has sent.
    pub(super) fn forged(&mut self, faults: &mut Vec<String>) {
        let forgeries: Vec<_> = (0..self.random.whole(1, 3))
            .map(|_| {
                let (at, length) = (self.moment(QUIET_FROM - 1.0), self.random.between(0.0, 1.0));
                let ahead = self.random.between(-300.0, 300.0);
                // Within the 500 counts that the blocks tolerate, beyond them either way, and beyond any count that a node accepts.
                let count = *self.random.one_of(&[-1_000.0, 7.0, 90.0, 1_000.0, 1e12]);
                let what = match self.random.below(12) {
                    0 => "'noise'".to_owned(),
                    1 => "'first-again'".to_owned(),
                    2 => "'other-run'".to_owned(),
                    3 => "'other-node'".to_owned(),
                    4 => "'other-key'".to_owned(),
                    5 => "'other-version'".to_owned(),
                    6 => "'other-axes'".to_owned(),
                    7 => "'not-finite'".to_owned(),
                    // A cycle time that no sender of these schedules has.
                    8 => "{ cycle-time-us = 4000 }".to_owned(),
                    9 => format!("{{ count-ahead = {count} }}"),
                    10 => format!("{{ position-ahead = {ahead:.1} }}"),
                    // 0x4655.
                    _ => "{ axis-error = 18005 }".to_owned(),
                };
                let (times, instead) = (self.random.whole(1, 3), self.random.chance(0.2));
                format!(
                    "{{ at-s = {at}, for-s = {length:.3}, what = {what}, times = {times}, instead = {instead} }}"
                )
            })
            .collect();
        faults.push(format!("forgeries = [{}]", forgeries.join(", ")));
    }
}
