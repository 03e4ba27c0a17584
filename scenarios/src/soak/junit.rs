//! A report as continuous integration reads it: JUnit's XML, a case for each schedule.

use std::fmt::Write as _;

use super::{Soak, Soaked};

pub(super) fn report(soak: &Soak, soaked: &Soaked) -> String {
    let world = soak.world.name();
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite name=\"soak {world}\" tests=\"{}\" \
         failures=\"{}\" time=\"{:.1}\">\n",
        soaked.schedules,
        soaked.failures.len(),
        soaked.took_s
    );
    for seed in soak.seeds.clone() {
        let _ = write!(
            text,
            "<testcase classname=\"soak.{world}\" name=\"seed {seed}\""
        );
        match soaked.failures.iter().find(|failure| failure.seed == seed) {
            None => text += "/>\n",
            Some(failure) => {
                let (wrong, file) = (failure.wrong.join("\n"), failure.file.display().to_string());
                let _ = writeln!(
                    text,
                    "><failure message=\"{}\">{}</failure></testcase>",
                    escaped(&file),
                    escaped(&wrong)
                );
            }
        }
    }
    text + "</testsuite>\n</testsuites>\n"
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            // XML has no other control characters, not even escaped.
            control if control.is_control() && !matches!(control, '\n' | '\t') => out.push(' '),
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::soak::Failure;
    use crate::summary::World;

    #[test]
    fn every_schedule_is_a_case_and_what_failed_says_why() {
        let soak = Soak {
            world: World::Virtual,
            seeds: 3..6,
            out: "out".into(),
            junit: None,
        };
        let soaked = Soaked {
            schedules: 3,
            simulated_s: 120.0,
            took_s: 1.25,
            failures: vec![Failure {
                seed: 4,
                wrong: vec!["a.b is \"x\" < 3 & more".to_owned()],
                file: "out/seed-4.toml".into(),
            }],
        };
        let text = report(&soak, &soaked);
        assert!(text.contains("tests=\"3\" failures=\"1\""), "{text}");
        assert!(text.contains("name=\"seed 3\"/>"), "{text}");
        assert!(
            text.contains(
                "name=\"seed 4\"><failure message=\"out/seed-4.toml\">a.b is &quot;x&quot; &lt; 3 &amp; more</failure>"
            ),
            "{text}"
        );
    }
}
