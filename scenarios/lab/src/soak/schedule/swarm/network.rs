//! Links and routers of a swarm schedule.

use std::fmt::Write as _;

use super::super::QUIET_FROM;
use super::super::draw::Draw as _;
use super::SwarmSchedule;
use super::features::Feature;

impl SwarmSchedule {
    /// Faults of a link, where there are any.
    pub(super) fn link_faults(&mut self) -> String {
        let mut faults = Vec::new();
        if self.features.has(Feature::LinkFaults) {
            faults = self.base.delays_and_losses();
        }
        if self.features.has(Feature::Forgeries) {
            self.base.forged(&mut faults);
        }
        match faults.is_empty() {
            true => String::new(),
            false => format!(
                "faults = {{ {}, faults-until-s = {QUIET_FROM} }}\n",
                faults.join(", ")
            ),
        }
    }

    /// Writes one to three routers in a row, and every node behind one of them.
    pub(super) fn routers(&mut self) {
        let random = &mut self.base.random;
        let count = random.whole(1, 3) as usize;
        let mut behind = vec![Vec::new(); count];
        for node in &self.nodes {
            behind[random.below(count as u64) as usize].push(format!("'{node}'"));
        }
        let mut text = String::new();
        for (n, nodes) in behind.iter().enumerate() {
            let _ = write!(
                text,
                "\n[[router]]\nname = 'hub{n}'\nnodes = [{}]\nforward-us = {}\nmbit-s = {}\n",
                nodes.join(", "),
                random.whole(1, 20),
                // A frame of three slaves is some 300 bytes: 24 µs at the slowest.
                *random.one_of(&[100, 1_000]),
            );
            if n > 0 {
                let _ = writeln!(text, "to = ['hub{}']", n - 1);
            }
        }
        self.base.text += &text;
        if self.features.has(Feature::Absences) {
            for n in 0..count {
                self.base
                    .life_of(&format!("hub{n}"), &["restart", "freeze"]);
            }
        }
    }
}
