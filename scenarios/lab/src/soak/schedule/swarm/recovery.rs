//! The last commands to the slaves of a swarm schedule: each is brought back into a coupling, so that there is something to judge.

use super::super::draw::Draw as _;
use super::features::Feature;
use super::{LENGTH, STEADY_FROM, SwarmSchedule};

/// Time from which slaves are brought back, s.
// A stop, and the switching on after a reset, end within the seconds between.
pub(super) const RECOVERY_FROM: f64 = STEADY_FROM + 5.0;

impl SwarmSchedule {
    /// Writes commands that acknowledge an error, switch on, and couple, in most cases.
    pub(super) fn recovery(&mut self, receiver: &str, slave: &str, two_masters: bool) {
        let random = &mut self.base.random;
        if random.chance(0.2) {
            return;
        }
        // After the way back of a far axis, or during it.
        let at = RECOVERY_FROM + random.between(0.0, 0.4) * (LENGTH - RECOVERY_FROM);
        let ratio = *random.one_of(&[1.0, -1.0, 0.5]);
        let couple = match random.below(5) {
            0 if two_masters => {
                let second = *random.one_of(&[0.5, -0.5, 0.0]);
                format!("gear-in-multi-master = {{ ratios = [{ratio}, {second}] }}")
            }
            1 if self.features.has(Feature::Plates) => {
                let table = *random.one_of(&[10, 11, 12, 13]);
                format!("cam-in = {{ table = {table}, start-mode = 'relative' }}")
            }
            2 if self.features.has(Feature::Strategies) => {
                // Reached whether the master moves or stands.
                format!(
                    "gear-in-pos = {{ ratio = {{ numerator = {ratio} }}, master-sync-position = {{ ahead = 20 }}, \
                     slave-sync-position = {{ ahead = 20 }}, strategy = 'early' }}"
                )
            }
            // Those that are coupled stay as they are.
            3 => String::new(),
            _ => format!("gear-in = {{ ratio = {ratio} }}"),
        };
        for (after, command) in [(0.0, "reset = {}"), (1.0, "power = true"), (2.0, &couple)] {
            if !command.is_empty() {
                self.order(receiver, slave, &format!("{:.3}", at + after), command);
            }
        }
    }
}
