//! A report as continuous integration reads it: JUnit's XML.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Context;
use coaxle_os::exit::lines_of;

/// A judged case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JunitCase {
    /// Name of the case.
    pub name: String,
    /// Failure, if the case failed.
    pub failure: Option<JunitFailure>,
}

/// Reason of a failure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JunitFailure {
    /// In a line.
    pub message: String,
    /// In full.
    pub text: String,
}

/// Writes the report of all cases of a suite, which took `took_s`.
///
/// # Errors
/// Names the file that cannot be written.
pub fn write(
    path: &Path,
    suite: &str,
    took_s: f64,
    cases: impl IntoIterator<Item = JunitCase>,
) -> anyhow::Result<()> {
    let text = report(suite, took_s, cases);
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// Passes on the result of a suite. If it could not be run, writes a report with an error, which is no failed case.
///
/// # Errors
/// The error of the suite.
pub fn report_error<T>(
    path: Option<&Path>,
    suite: &str,
    run: anyhow::Result<T>,
) -> anyhow::Result<T> {
    if let (Some(path), Err(error)) = (path, &run) {
        // That error says more than a missing report.
        let _ = std::fs::write(path, not_run(suite, &lines_of(error)));
    }
    run
}

fn not_run(suite: &str, lines: &[String]) -> String {
    let message = lines.first().map_or("", String::as_str);
    let (message, text) = (escaped(message), escaped(&lines.join("\n")));
    let class = escaped(&suite.replace(' ', "."));
    let suite = escaped(suite);
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite name=\"{suite}\" tests=\"1\" failures=\"0\" \
         errors=\"1\">\n<testcase classname=\"{class}\" name=\"can be run\"><error message=\"{message}\">{text}</error></testcase>\n\
         </testsuite>\n</testsuites>\n"
    )
}

fn report(suite: &str, took_s: f64, cases: impl IntoIterator<Item = JunitCase>) -> String {
    let (mut all, mut failed, mut lines) = (0, 0, String::new());
    let class = escaped(&suite.replace(' ', "."));
    for JunitCase { name, failure } in cases {
        all += 1;
        let name = escaped(&name);
        // Writing to a string cannot fail.
        let _ = write!(lines, "<testcase classname=\"{class}\" name=\"{name}\"");
        match failure {
            None => lines += "/>\n",
            Some(JunitFailure { message, text }) => {
                failed += 1;
                let (message, text) = (escaped(&message), escaped(&text));
                let failure = format!("<failure message=\"{message}\">{text}</failure>");
                let _ = writeln!(lines, ">{failure}</testcase>");
            }
        }
    }
    let suite = escaped(suite);
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite name=\"{suite}\" tests=\"{all}\" \
         failures=\"{failed}\" time=\"{took_s:.1}\">\n{lines}</testsuite>\n</testsuites>\n"
    )
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

    #[test]
    fn what_could_not_be_run_is_an_error_and_no_failed_case() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("junit.xml");
        let run: anyhow::Result<()> = Err(anyhow::anyhow!("x.toml: is <no> scenario"));
        report_error(Some(&path), "run x", run).unwrap_err();
        let text = std::fs::read_to_string(path).unwrap();
        assert!(
            text.contains("tests=\"1\" failures=\"0\" errors=\"1\""),
            "{text}"
        );
        assert!(
            text.contains("<error message=\"x.toml: is &lt;no&gt; scenario\">"),
            "{text}"
        );
    }

    #[test]
    fn every_case_is_there_and_what_failed_says_why() {
        let failure = JunitFailure {
            message: "out/seed-4.toml".to_owned(),
            text: "a.b is \"x\" < 3 & more".to_owned(),
        };
        let cases = [("seed 3", None), ("seed 4", Some(failure))];
        let cases = cases.map(|(name, failure)| JunitCase {
            name: name.to_owned(),
            failure,
        });
        let text = report("soak virtual", 1.25, cases);
        assert!(
            text.contains("name=\"soak virtual\" tests=\"2\" failures=\"1\" time=\"1.2\""),
            "{text}"
        );
        assert!(
            text.contains("classname=\"soak.virtual\" name=\"seed 3\"/>"),
            "{text}"
        );
        assert!(
            text.contains(
                "name=\"seed 4\"><failure message=\"out/seed-4.toml\">a.b is &quot;x&quot; &lt; 3 &amp; more</failure>"
            ),
            "{text}"
        );
        assert!(report("none", 0.0, []).contains("tests=\"0\" failures=\"0\""));
    }
}
