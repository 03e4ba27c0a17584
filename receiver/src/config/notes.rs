//! Notes on a valid config.

use super::{ReceiverConfig, SlaveConfig};

impl ReceiverConfig {
    /// Notes for the operator on a valid config, a line each.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let mut notes = self.notes_on_encoders();
        let slaves = self.slaves.iter().enumerate();
        for (n, slave) in slaves {
            notes.extend(note_on_drive(n, slave));
            notes.extend(note_on_dead_time(n, slave));
        }
        notes
    }
}

/// Note on a slave that may be faster than its drive: its set values keep the limits, but the drive
/// falls behind.
fn note_on_drive(n: usize, slave: &SlaveConfig) -> Option<String> {
    // Without limits of its own a slave has those of its drive, and cannot be faster.
    let received = slave.limits?.velocity;
    // 0 stands for a drive without a limit.
    let most = Some(slave.drive.simulated().max_velocity).filter(|most| *most > 0.0)?;
    (received > most).then(|| {
        format!(
            "slave[{n}].limits.velocity: received {received}, recommended at most {most}, the max-velocity of its drive: \
             where the slave is faster than that, its drive falls behind"
        )
    })
}

/// Note on a slave whose simulated drive has another dead time: it is shown earlier or later than its master.
fn note_on_dead_time(n: usize, slave: &SlaveConfig) -> Option<String> {
    let (received, simulated) = (slave.dead_time_us.span(), slave.simulated_dead_time());
    (received != simulated).then(|| {
        let [received, simulated] = [received, simulated].map(|time| time.as_micros_f64());
        format!(
            "slave[{n}].dead-time-us: received {received}, recommended {simulated}, the dead-time-us of its simulated drive: \
             the position is off by the velocity times the difference"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_beyond_those_of_the_drive_are_worth_a_note() {
        let notes = |velocity: f64, drive: &str| {
            let text = format!(
                "name = 'a'\ncycle-time-us = 1000\nmaster.node = 'b'\nslave = [{{ limits = {{ velocity = {velocity}, acceleration = 1e3, \
                 jerk = 1e4 }}, drive = {{ {drive} }} }}]"
            );
            let config: ReceiverConfig =
                coaxle_node::config::parse("a.toml", &text).expect("a config");
            config.notes()
        };
        let said = notes(2_000.0, "max-velocity = 1500.0");
        assert_eq!(said.len(), 1);
        assert!(
            said[0]
                .starts_with("slave[0].limits.velocity: received 2000, recommended at most 1500")
        );
        assert!(notes(1_500.0, "max-velocity = 1500.0").is_empty());
        assert!(notes(2_000.0, "").is_empty());
        let said = notes(2_000.0, "dead-time-us = 4000");
        assert!(said[0].starts_with("slave[0].dead-time-us: received 0, recommended 4000"));
    }
}
