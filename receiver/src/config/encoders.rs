//! `encoder` of a far axis: smoothing of the increments of an axis that is only measured.

use coaxle_clock::time_sync::WrongParameter;
use coaxle_clock::{Seconds, Span};
use coaxle_node::config::Wrong;
use coaxle_remote::{COARSE_INCREMENT_MM, EncoderParameters};

use super::ReceiverConfig;

/// Field of the short form, which has only one axis.
const SHORT: &str = "master.encoder";

impl ReceiverConfig {
    /// Notes on encoders in a valid config.
    pub(super) fn notes_on_encoders(&self) -> Vec<String> {
        let axes = self.encoders().filter(|(axis, _, encoder)| {
            // Only in mm the size of an increment on the material is known.
            self.far_axis_unit(*axis).as_str() == "mm" && encoder.increment > COARSE_INCREMENT_MM
        });
        let note = |(_, field, encoder): (usize, String, &EncoderParameters)| {
            format!(
                "{field}.increment: received {} mm, recommended at most {COARSE_INCREMENT_MM} mm: the master is \
                 wrong by up to two increments in ripple, and by tenths of a millimetre in ramps",
                encoder.increment
            )
        };
        axes.map(note).collect()
    }

    pub(super) fn check_encoders(&self, is_short: bool) -> Result<(), Wrong> {
        let cycle = self.cycle_time_us.0.span();
        for (_, field, encoder) in self.encoders() {
            let field = if is_short { SHORT.to_owned() } else { field };
            check(encoder, cycle).map_err(|wrong| wrong.within(field))?;
        }
        Ok(())
    }

    /// The encoders, with the number of their axis among all far ones and the field that has them.
    fn encoders(&self) -> impl Iterator<Item = (usize, String, &EncoderParameters)> {
        let axes = self.far_axes().enumerate();
        axes.filter_map(|(number, (n, _, axis))| {
            let place = number - self.first_axis_of(n);
            let field = format!("far[{n}].axes[{place}].encoder");
            Some((number, field, axis.encoder.as_ref()?))
        })
    }
}

/// Checks the parameters, and that no sampling time is given: the counter is read once per cycle of the far node.
fn check(encoder: &EncoderParameters, cycle: Span) -> Result<(), Wrong> {
    // First: a wrong one would appear as a smoothing that does not fit.
    if encoder.sampling_time != Seconds::ZERO {
        let expected = "none: the frames of the far node say how long its cycles are";
        return Err(Wrong::of(
            "sampling-time-s",
            encoder.sampling_time.0,
            expected,
        ));
    }
    let wrong = |wrong: WrongParameter| Wrong::of(wrong.parameter, wrong.received, wrong.expected);
    encoder.checked(cycle).map(drop).map_err(wrong)
}

#[cfg(test)]
mod tests {
    use crate::config::test_config::config;

    fn long(encoder: &str) -> String {
        format!("[[far]]\nnode = 'a'\naxes = [4, {{ id = 1, unit = 'mm', encoder = {encoder} }}]")
    }

    #[test]
    fn the_short_form_has_it_too() {
        let short = config("slave = []\nmaster = { node = 'a', encoder = { increment = 0.01 } }");
        let text =
            "slave = []\n[[far]]\nnode = 'a'\naxes = [{ id = 1, encoder = { increment = 0.01 } }]";
        assert_eq!(short, config(text));
        let written = toml::to_string(&short.clone().unwrap()).unwrap();
        let read = coaxle_node::config::parse("r.toml", &written).map_err(|e| e.to_string());
        assert_eq!(read, short);
    }

    #[test]
    fn what_smooths_nothing_is_refused_by_name() {
        let field = "far \"a\".axes[1].encoder";
        for (encoder, expected) in [
            (
                "{}",
                "increment: received 0, expected a finite number above 0",
            ),
            (
                "{ increment = 0.05, smoothing = 1 }",
                "smoothing: received 1, expected \"auto\", or",
            ),
            (
                "{ increment = 0.05, max-speed = 0 }",
                "max-speed: received 0, expected",
            ),
            (
                "{ increment = 0.05, vibration = -1 }",
                "vibration: received -1, expected",
            ),
            (
                "{ increment = 0.05, sampling-time-s = 0.002 }",
                "sampling-time-s: received 0.002, expected none: the frames",
            ),
        ] {
            let error = config(&long(encoder)).unwrap_err();
            assert!(
                error.contains(&format!("{field}.{expected}")),
                "{encoder}: {error}"
            );
        }
        let error = config("master = { node = 'a', encoder = { increment = -1 } }").unwrap_err();
        assert!(
            error.contains("master.encoder.increment: received -1"),
            "{error}"
        );
    }

    #[test]
    fn a_coarse_increment_in_millimetres_is_worth_a_note() {
        let notes = |text: &str| config(text).unwrap().notes();
        let coarse = notes(&long("{ increment = 0.05 }"));
        assert_eq!(coarse.len(), 1);
        let expected =
            "far[0].axes[1].encoder.increment: received 0.05 mm, recommended at most 0.02 mm";
        assert!(coarse[0].starts_with(expected), "{coarse:?}");
        assert!(notes(&long("{ increment = 0.02 }")).is_empty());
        assert!(notes(&long("{ increment = 0.05 }").replace("'mm'", "'m'")).is_empty());
        assert!(notes("master.node = 'a'").is_empty());
    }
}
