//! A rule of docs/WIRE.md, and its outcome.

use serde::Serialize;

/// A rule: docs/WIRE.md lists all of them under "Rules by name".
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Rule {
    /// `S7`, `R3`: its number.
    pub(crate) number: &'static str,
    /// Short name.
    pub(crate) name: &'static str,
    /// Section of docs/WIRE.md with the rule, as a link there.
    pub(crate) section: &'static str,
}

impl Rule {
    pub(crate) const fn new(
        number: &'static str,
        name: &'static str,
        section: &'static str,
    ) -> Self {
        Self {
            number,
            name,
            section,
        }
    }
}

/// Outcome of a rule.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "outcome", rename_all = "kebab-case")]
pub(crate) enum RuleOutcome {
    /// Kept, as far as was seen.
    Kept {
        /// Observations.
        seen: String,
    },
    /// Broken.
    Broken {
        /// Received value.
        received: String,
        /// Expected value.
        expected: String,
        /// Number of violations.
        seen: String,
    },
    /// No case of it was seen.
    NotSeen {
        /// Reason.
        why: String,
    },
}

impl RuleOutcome {
    pub(crate) fn kept(seen: impl Into<String>) -> Self {
        Self::Kept { seen: seen.into() }
    }

    pub(crate) fn broken(received: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Broken {
            received: received.into(),
            expected: expected.into(),
            seen: String::new(),
        }
    }

    pub(crate) fn not_seen(why: impl Into<String>) -> Self {
        Self::NotSeen { why: why.into() }
    }

    /// Outcome of a value that is described by `received`: kept if it is as expected.
    pub(crate) fn of(
        is_kept: bool,
        received: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        match is_kept {
            true => Self::kept(received),
            false => Self::broken(received, expected),
        }
    }
}

/// A rule with its outcome.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RuleFinding {
    pub(crate) rule: &'static Rule,
    pub(crate) outcome: RuleOutcome,
}

impl RuleFinding {
    pub(crate) const fn new(rule: &'static Rule, outcome: RuleOutcome) -> Self {
        Self { rule, outcome }
    }

    pub(crate) const fn is_broken(&self) -> bool {
        matches!(self.outcome, RuleOutcome::Broken { .. })
    }
}

/// Result of trying a node.
pub(crate) enum TrialResult {
    /// Findings about the rules.
    Findings(Vec<RuleFinding>),
    /// No message came: the reason, as far as known.
    Nothing(String),
    /// Ended by the user before it was done.
    Interrupted,
}

/// Received value of a bad case, and the expected one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Mismatch {
    received: String,
    expected: String,
}

pub(crate) fn mismatch(received: impl Into<String>, expected: impl Into<String>) -> Mismatch {
    Mismatch {
        received: received.into(),
        expected: expected.into(),
    }
}

/// Judges a case, good or bad; `otherwise` describes a bad one.
pub(crate) fn ensure(is_good: bool, otherwise: impl FnOnce() -> Mismatch) -> Result<(), Mismatch> {
    if is_good { Ok(()) } else { Err(otherwise()) }
}

/// Numbers in words, for messages.
pub(crate) fn comma_separated(numbers: &[u32]) -> String {
    let numbers: Vec<_> = numbers.iter().map(u32::to_string).collect();
    numbers.join(", ")
}

/// Number of good and bad cases, with the first bad one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    good: u64,
    bad: u64,
    first: Option<Mismatch>,
}

impl Tally {
    /// Counts a case.
    pub(crate) fn count(&mut self, case: Result<(), Mismatch>) {
        match case {
            Ok(()) => self.good += 1,
            Err(bad) => {
                self.bad += 1;
                self.first.get_or_insert(bad);
            }
        }
    }

    pub(crate) const fn all(&self) -> u64 {
        self.good + self.bad
    }

    /// Outcome for cases called `things`; `why` explains that none was seen.
    pub(crate) fn outcome(&self, things: &str, why: &str) -> RuleOutcome {
        self.outcome_but_for(0.0, things, why)
    }

    /// Outcome that permits this share of bad cases: machines and networks are busy now and then.
    pub(crate) fn outcome_but_for(&self, share: f64, things: &str, why: &str) -> RuleOutcome {
        let all = self.all();
        match &self.first {
            Some(Mismatch { received, expected }) if self.bad as f64 > share * all as f64 => {
                RuleOutcome::Broken {
                    received: received.clone(),
                    expected: expected.clone(),
                    seen: format!("{} of {all} {things}", self.bad),
                }
            }
            _ if all == 0 => RuleOutcome::not_seen(why),
            Some(_) => RuleOutcome::kept(format!("{} of {all} {things}", self.good)),
            None => RuleOutcome::kept(format!("{all} {things}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tally_tells_the_first_that_was_not_as_it_should_be_and_how_many_were_not() {
        let mut tally = Tally::default();
        assert_eq!(
            tally.outcome("frames", "none came"),
            RuleOutcome::not_seen("none came")
        );
        tally.count(Ok(()));
        assert_eq!(tally.outcome("frames", ""), RuleOutcome::kept("1 frames"));
        for received in ["5", "6"] {
            tally.count(ensure(false, || mismatch(received, "4")));
        }
        let RuleOutcome::Broken {
            received,
            expected,
            seen,
        } = tally.outcome("frames", "")
        else {
            panic!("it is broken");
        };
        assert_eq!(
            [received, expected, seen],
            ["5", "4", "2 of 3 frames"].map(str::to_owned)
        );
        assert_eq!(
            tally.outcome_but_for(0.7, "frames", ""),
            RuleOutcome::kept("1 of 3 frames")
        );
    }
}
