//! Slaves of a schedule, and the commands to them.

use std::fmt::Write as _;

use super::{Draw as _, QUIET_FOR, QUIET_FROM, SoakSchedule};

impl SoakSchedule {
    pub(super) fn slave(&mut self, receiver: &str, slave: u64) {
        let name = format!("slave{slave}");
        let _ = write!(self.text, "\n[[receiver.slave]]\nname = '{name}'\n");
        let ratio = *self.random.one_of(&[1.0, 1.0, -1.0, 0.5, 2.0]);
        if self.random.chance(0.1) {
            // Without limits: it follows in any case.
            let _ = writeln!(self.text, "gear = {{ ratio = {ratio} }}");
            return;
        }
        // Masters go at up to 500: some slaves cannot keep up with the fastest.
        let velocity = f64::abs(ratio) * self.random.between(450.0, 1_500.0);
        let acceleration = self.random.between(2_000.0, 40_000.0);
        let jerk = self.random.between(30_000.0, 3e6);
        let mut limits =
            format!("velocity = {velocity:.1}, acceleration = {acceleration:.1}, jerk = {jerk:.1}");
        if let Some(wide) = self.wide.slave_limits(ratio) {
            limits = wide;
        }
        if self.random.chance(0.2) {
            let _ = write!(
                limits,
                ", deceleration = {:.1}",
                self.random.between(1_000.0, 60_000.0)
            );
        }
        if self.random.chance(0.3) {
            let _ = write!(
                limits,
                ", min-position = {:.1}, max-position = {:.1}",
                self.random.between(-900.0, -50.0),
                self.random.between(50.0, 900.0)
            );
        }
        if self.random.chance(0.25) {
            let how = *self.random.one_of(&["quick-stop", "follow"]);
            let _ = write!(limits, ", on-master-loss = '{how}'");
        }
        let _ = writeln!(self.text, "limits = {{ {limits} }}");
        if self.random.chance(0.5) {
            let _ = write!(self.text, "couple = 'gear'\ngear = {{ ratio = {ratio} }}\n");
        } else {
            self.add("couple = 'off'\n");
        }
        for _ in 0..self.random.whole(0, 14) {
            let drawn = self.command();
            let command = self.wide.command(drawn);
            // Commands come in the quiet phase, too: a slave may end in error stop, and is not judged for it.
            let at = self.moment(QUIET_FROM + QUIET_FOR);
            let _ = write!(
                self.events,
                "\n[[event]]\nat-s = {at}\nnode = '{receiver}'\nslave = '{name}'\ncommand = {{ {command} }}\n"
            );
        }
    }

    fn command(&mut self) -> String {
        let near = self.random.between(-300.0, 300.0);
        let way = self.random.between(-500.0, 500.0);
        let speed = self.random.between(-400.0, 400.0);
        let ratio = *self.random.one_of(&[1.0, -1.0, 0.5, 2.0]);
        match self.random.below(24) {
            // Often, as all motions need it.
            0..=3 => "power = true".to_owned(),
            4 | 5 => "reset = {}".to_owned(),
            6 => format!("home = {{ position = {near:.2} }}"),
            7 => format!("move-absolute = {{ position = {near:.2} }}"),
            8 => format!("move-relative = {{ distance = {way:.2}, velocity = 300 }}"),
            9 => format!("move-velocity = {{ velocity = {speed:.2} }}"),
            10 => "halt = {}".to_owned(),
            11 => "stop = {}".to_owned(),
            12 | 13 => format!("gear-in = {{ ratio = {ratio} }}"),
            14 => "gear-out = {}".to_owned(),
            15 | 16 => format!("gear-in-velo = {{ ratio = {{ numerator = {ratio} }} }}"),
            17 => format!(
                "gear-in-pos = {{ ratio = {{ numerator = {ratio} }}, master-sync-position = {way:.2}, slave-sync-position \
                 = {near:.2} }}"
            ),
            18 => format!("phasing-relative = {{ shift = {:.2} }}", near / 3.0),
            19 | 20 => format!("move-superimposed = {{ distance = {:.2} }}", near / 3.0),
            21 => "cam-in = { table = 10, start-mode = 'relative' }".to_owned(),
            22 => format!("gear-in-multi-master = {{ ratios = [{ratio}] }}"),
            _ => "power = false".to_owned(),
        }
    }
}
