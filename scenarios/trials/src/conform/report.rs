//! Findings for people, as JSON, and for continuous integration.

use clap::ValueEnum;
use coaxle_lab::junit::{JunitCase, JunitFailure};
use coaxle_node::one_line;
use coaxle_os::exit::Exit;
use serde_json::{Value, json};

use super::rule::{RuleFinding, RuleOutcome};

/// Format of the findings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ReportFormat {
    /// A line for each rule.
    #[default]
    Plain,
    /// A single object.
    Json,
}

/// The findings about a node, in the words of `format`.
pub(crate) fn shown(node: &str, findings: &[RuleFinding], format: ReportFormat) -> String {
    match format {
        ReportFormat::Plain => plain(node, findings),
        ReportFormat::Json => format!("{:#}", as_json(node, findings)),
    }
}

/// Not met if a rule is broken.
pub(crate) fn exit(findings: &[RuleFinding]) -> Exit {
    Exit::NotMet.done_if(!findings.iter().any(RuleFinding::is_broken))
}

/// A case for each rule. A rule that was not seen is no failure.
pub(crate) fn cases(findings: &[RuleFinding]) -> impl Iterator<Item = JunitCase> {
    findings.iter().map(|finding| JunitCase {
        name: format!("{} {}", finding.rule.number, finding.rule.name),
        failure: finding.is_broken().then(|| JunitFailure {
            message: outcome_text(&finding.outcome),
            text: place(finding),
        }),
    })
}

fn plain(node: &str, findings: &[RuleFinding]) -> String {
    let mut lines: Vec<_> = findings.iter().map(line).collect();
    let [kept, broken, not_seen] = counts(findings);
    lines.push(format!(
        "{node}: {kept} rules kept, {broken} broken, {not_seen} not seen"
    ));
    lines.join("\n")
}

fn line(finding: &RuleFinding) -> String {
    let word = ["kept", "broken", "not seen"][kind(&finding.outcome)];
    let rule = finding.rule;
    let place = match finding.is_broken() {
        true => format!("; {}", place(finding)),
        false => String::new(),
    };
    let text = outcome_text(&finding.outcome);
    // A node's status may contain any text.
    one_line(&format!(
        "{word:8} {:4} {:16} {text}{place}",
        rule.number, rule.name
    ))
}

fn outcome_text(outcome: &RuleOutcome) -> String {
    match outcome {
        RuleOutcome::Kept { seen: text } | RuleOutcome::NotSeen { why: text } => text.clone(),
        RuleOutcome::Broken {
            received,
            expected,
            seen,
        } => {
            let seen = match seen.as_str() {
                "" => String::new(),
                seen => format!(" ({seen})"),
            };
            format!("received {received}, expected {expected}{seen}")
        }
    }
}

fn place(finding: &RuleFinding) -> String {
    format!("docs/WIRE.md#{}", finding.rule.section)
}

/// Place in [`counts`].
const fn kind(outcome: &RuleOutcome) -> usize {
    match outcome {
        RuleOutcome::Kept { .. } => 0,
        RuleOutcome::Broken { .. } => 1,
        RuleOutcome::NotSeen { .. } => 2,
    }
}

/// Numbers of rules kept, broken and not seen.
fn counts(findings: &[RuleFinding]) -> [usize; 3] {
    [0, 1, 2].map(|n| {
        (findings
            .iter()
            .filter(|finding| kind(&finding.outcome) == n))
        .count()
    })
}

fn as_json(node: &str, findings: &[RuleFinding]) -> Value {
    let [kept, broken, not_seen] = counts(findings);
    let rules = findings.iter().map(|finding| {
        let mut rule = json!(finding.outcome);
        rule["number"] = json!(finding.rule.number);
        rule["rule"] = json!(finding.rule.name);
        rule["section"] = json!(place(finding));
        rule
    });
    json!({
        "node": node, "kept": kept, "broken": broken, "not-seen": not_seen,
        "rules": rules.collect::<Value>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conform::rule::Rule;

    static COUNT: Rule = Rule::new("S7", "count", "what-the-fields-mean");

    fn findings() -> Vec<RuleFinding> {
        vec![
            RuleFinding::new(&COUNT, RuleOutcome::kept("30 frames")),
            RuleFinding::new(&COUNT, RuleOutcome::broken("5\nafter 5", "6 or more")),
            RuleFinding::new(&COUNT, RuleOutcome::not_seen("no frame came")),
        ]
    }

    #[test]
    fn each_rule_has_a_line_and_a_broken_one_says_where_it_stands() {
        let text = shown("belt", &findings(), ReportFormat::Plain);
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(
            lines,
            [
                "kept     S7   count            30 frames",
                "broken   S7   count            received 5 after 5, expected 6 or more; \
                 docs/WIRE.md#what-the-fields-mean",
                "not seen S7   count            no frame came",
                "belt: 1 rules kept, 1 broken, 1 not seen",
            ]
        );
    }

    #[test]
    fn json_junit_and_the_exit_code_say_the_same() {
        let json: Value =
            serde_json::from_str(&shown("belt", &findings(), ReportFormat::Json)).unwrap();
        assert_eq!((&json["kept"], &json["broken"]), (&1.into(), &1.into()));
        assert_eq!(json["rules"][1]["outcome"], "broken");
        assert_eq!(json["rules"][1]["rule"], "count");
        assert_eq!(json["rules"][2]["why"], "no frame came");
        let cases: Vec<_> = cases(&findings()).collect();
        assert_eq!(
            cases.iter().filter(|case| case.failure.is_some()).count(),
            1
        );
        assert_eq!(exit(&findings()), Exit::NotMet);
        assert_eq!(exit(&findings()[..1]), Exit::Done);
    }
}
