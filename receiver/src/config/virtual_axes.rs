//! `[[virtual-axis]]`: axes of the receiver's own, written as in a sender's config.

use coaxle_node::config::{LeadMs, PresentAfterChoice, Unit, Wrong};
use coaxle_node::frame::MAX_AXES;
use coaxle_node::keys::NodeName;
use coaxle_slave::MOST_HELD_BACK;
use coaxle_source::config::AxisConfig;

use super::ReceiverConfig;

impl ReceiverConfig {
    /// The names of all virtual axes.
    #[must_use]
    pub fn virtual_axis_names(&self) -> Vec<String> {
        self.virtual_axes.iter().map(|a| a.name.clone()).collect()
    }

    /// Unit of a virtual axis, by its place in the config.
    #[must_use]
    pub fn virtual_axis_unit(&self, axis: usize) -> Unit {
        let axis = self.virtual_axes.get(axis);
        axis.map(|axis| axis.unit.clone()).unwrap_or_default()
    }

    /// The place of the virtual axis of this name.
    pub(crate) fn virtual_axis_called(&self, name: &str) -> Option<usize> {
        self.virtual_axes.iter().position(|axis| axis.name == name)
    }

    pub(super) fn check_virtual_axes(&self) -> Result<(), Wrong> {
        let axes = &self.virtual_axes;
        if axes.len() > MAX_AXES {
            let expected = format!("at most {MAX_AXES}");
            return Err(Wrong::of("virtual-axis", axes.len(), expected));
        }
        for (n, axis) in axes.iter().enumerate() {
            let before = &axes[..n];
            // Quadratic in at most 128 axes.
            if before.iter().any(|other| other.id == axis.id) {
                let received = format!("id {} twice", axis.id);
                let expected = "an id of its own for each";
                return Err(Wrong::of("virtual-axis", received, expected));
            }
            self.check_delay(axis)
                .and_then(|()| check_lead(axis))
                .and_then(|()| check_followers(axis))
                .map_err(|wrong| wrong.within(format_args!("virtual-axis[{n}]")))?;
            self.check_name(axis, before)
                .map_err(|wrong| wrong.within(format_args!("virtual-axis[{n}].name")))?;
        }
        Ok(())
    }

    /// Checks the time by which it is shown later: its slaves are held back by it, in whole cycles.
    fn check_delay(&self, axis: &AxisConfig) -> Result<(), Wrong> {
        let cycle = self.cycle_time_us.0.span();
        let longest = cycle * i64::from(MOST_HELD_BACK);
        let received = match axis.present_after_ms {
            None => return Ok(()),
            Some(PresentAfterChoice::Fixed(time)) if (cycle..=longest).contains(&time.span()) => {
                return Ok(());
            }
            Some(PresentAfterChoice::Fixed(time)) => time.get().to_string(),
            // Followers report to senders.
            Some(PresentAfterChoice::Auto) => "\"auto\"".to_owned(),
        };
        let [least, most] = [cycle, longest].map(|time| time.as_micros_f64() / 1e3);
        let expected = format!("{least} to {most}: a cycle to {MOST_HELD_BACK} cycles");
        Err(Wrong::of("present-after-ms", received, expected))
    }

    /// Checks the name: slaves refer to it, and its signals begin with it, so no other axis and no
    /// far node may have it.
    fn check_name(&self, axis: &AxisConfig, before: &[AxisConfig]) -> Result<(), Wrong> {
        let name = axis.name.as_str();
        NodeName::new(name).map_err(|_| {
            let expected = "1 to 64 letters, digits, '-', '_' or '.'";
            Wrong::value(format_args!("{name:?}"), expected)
        })?;
        // All kinds share one space of names: slaves refer to masters of any kind by the name alone.
        let is_taken = if self.far_axis_called(name).is_some() {
            Some("is a far axis")
        } else if self.far.iter().any(|far| far.node.as_str() == name) {
            Some("is a far node")
        } else if before.iter().any(|other| other.name == name) {
            Some("is another virtual axis")
        } else {
            None
        };
        match is_taken {
            Some(what) => {
                let received = format!("{name:?}, which {what}");
                Err(Wrong::value(received, "a name of its own"))
            }
            None => Ok(()),
        }
    }
}

/// Checks that no motion is promised: a receiver publishes no plans.
fn check_lead(axis: &AxisConfig) -> Result<(), Wrong> {
    match axis.lead_ms.map(LeadMs::get).filter(|ms| *ms > 0.0) {
        Some(ms) => Err(Wrong::of(
            "lead-ms",
            ms,
            "0 or none: only senders publish plans",
        )),
        None => Ok(()),
    }
}

/// Checks that it has no followers: those report to senders.
fn check_followers(axis: &AxisConfig) -> Result<(), Wrong> {
    match &axis.followers {
        Some(_) => {
            let expected = "none: followers report to senders only";
            Err(Wrong::of("followers", "a table", expected))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::MasterRef;
    use crate::config::test_config::config;

    const SHAFT: &str = "program = { start-velocity = 90, limits = { velocity = 360, \
                         acceleration = 720, jerk = 7200 } }\n";

    fn axis(id: u32, name: &str) -> String {
        format!("[[virtual-axis]]\nid = {id}\nname = '{name}'\nunit = '°'\n{SHAFT}")
    }

    const FAR: &str = "[[far]]\nnode = 'press'\naxes = [1, { id = 2, name = 'belt' }]\n";

    #[test]
    fn slaves_name_it_as_any_master_and_it_survives_being_written_and_read() {
        let slaves = "[[slave]]\nname = 'a'\nmaster = 'shaft'\n[[slave]]\nname = 'b'\n\
                      master = 'belt'\nfurther-masters = ['shaft', 'a']\n\
                      [[slave]]\nname = 'c'\nmaster = 'a'";
        let config = config(&(FAR.to_owned() + &axis(7, "shaft") + slaves)).unwrap();
        assert_eq!(config.master_of(0), Ok(MasterRef::Virtual(0)));
        let all = [
            MasterRef::Far(1),
            MasterRef::Virtual(0),
            MasterRef::Slave(0),
        ];
        assert_eq!(config.masters_of(1), Ok(all.to_vec()));
        assert_eq!(config.root_of(2), Some(MasterRef::Virtual(0)));
        let unit = Unit::new("°").unwrap();
        assert_eq!(
            (config.slave_unit(0), config.slave_unit(2)),
            (unit.clone(), unit)
        );
        let written = toml::to_string(&config).unwrap();
        let read = coaxle_node::config::parse("r.toml", &written).map_err(|e| e.to_string());
        assert_eq!(read, Ok(config));
    }

    #[test]
    fn it_may_be_all_there_is_to_follow() {
        let config = config(&(axis(1, "shaft") + "[[slave]]\nname = 'a'")).unwrap();
        assert_eq!(config.master_of(0), Ok(MasterRef::Virtual(0)));
    }

    #[test]
    fn files_are_found_from_the_config() {
        let replay = "[[virtual-axis]]\nid = 1\nname = 'x'\nreplay = { file = 'a/b.csv' }";
        let mut config = config(replay).unwrap();
        config.relative_to(std::path::Path::new("there"));
        let coaxle_source::config::SourceConfig::Replay(replay) = &config.virtual_axes[0].source
        else {
            panic!("{config:?}");
        };
        assert_eq!(replay.file, std::path::Path::new("there/a/b.csv"));
    }

    #[test]
    fn errors_name_the_field_what_came_and_what_is_expected() {
        let many: String = (1..=129).map(|id| axis(id, &format!("x{id}"))).collect();
        for (rest, expected) in [
            (
                axis(1, "a") + &axis(2, "b") + &axis(1, "c"),
                "virtual-axis: received id 1 twice, expected an id of its own for each",
            ),
            (many, "virtual-axis: received 129, expected at most 128"),
            (
                axis(1, "line shaft"),
                "virtual-axis[0].name: received \"line shaft\", expected ",
            ),
            (
                FAR.to_owned() + &axis(1, "a") + &axis(2, "press.2"),
                "virtual-axis[1].name: received \"press.2\", which is a far axis, expected a name \
                 of its own",
            ),
            (
                FAR.to_owned() + &axis(2, "press"),
                "virtual-axis[0].name: received \"press\", which is a far node",
            ),
            (
                axis(1, "a") + &axis(2, "a"),
                "virtual-axis[1].name: received \"a\", which is another virtual axis",
            ),
            (
                axis(1, "a").replace("unit", "present-after-ms = 1001\nunit"),
                "virtual-axis \"a\".present-after-ms: received 1001, expected 1 to 1000: a cycle to 1000 cycles",
            ),
            (
                axis(1, "a").replace("unit", "present-after-ms = 0.5\nunit"),
                "virtual-axis \"a\".present-after-ms: received 0.5, expected 1 to 1000",
            ),
            (axis(0, "a"), "virtual-axis \"a\".id: "),
            (
                axis(1, "a") + "encodr = {}",
                "virtual-axis \"a\".encodr: unknown field `encodr`",
            ),
            (
                axis(1, "a").replace("90", "400"),
                "virtual-axis \"a\".program.start-velocity: received 400, expected -360 to 360",
            ),
        ] {
            let message = config(&rest).unwrap_err();
            assert!(message.contains(expected), "{message}\n{expected}");
        }
    }
}
