//! The rules for nodes that publish axes, by name, and how each is judged. docs/WIRE.md has this list, too.

use coaxle_clock::Instant;
use coaxle_os::Machine;

use self::Judging::{Counted, Whole};
use super::SenderJudge;
use crate::conform::rule::{Mismatch, Rule, RuleFinding, RuleOutcome, Tally, ensure};

const FIELDS: &str = "what-the-fields-mean";
const FRAME: &str = "the-frame";
const AXIS: &str = "an-axis";
const EXCHANGE: &str = "time-requests-and-responses";
const NODE: &str = "every-node";
const KEYS: &str = "keys";

/// Way to judge a rule.
pub(super) enum Judging {
    /// By cases, counted as they come: these, of which this share may be bad, or none for this reason.
    Counted(&'static str, f64, fn(&SenderJudge) -> &'static str),
    /// By all that came until an instant.
    Whole(fn(&SenderJudge, Instant<Machine>) -> RuleOutcome),
}

/// Share of messages that may differ in run from the newest frame: a restarting node responds and reports before it
/// sends, or after.
const BETWEEN_RUNS: f64 = 0.1;

/// Reason why no response was seen.
pub(super) const UNANSWERED: &str =
    "no request was answered: nobody can follow the node without lag";
const NO_VERSION: fn(&SenderJudge) -> &'static str = |_| "no frame of version 1 or 2 came";
const NO_WHOLE: fn(&SenderJudge) -> &'static str = |_| "no whole frame came";
const NO_GOOD: fn(&SenderJudge) -> &'static str = |_| "no good frame came";
const NO_TWO: fn(&SenderJudge) -> &'static str = |_| "it takes two good frames of a run";
const NO_AXIS: fn(&SenderJudge) -> &'static str = |judge| judge.axes.why_none();
const NO_ANSWER: fn(&SenderJudge) -> &'static str = |_| UNANSWERED;

/// A row is a rule with its section and the way to judge it.
macro_rules! rules {
    ($($rule:ident $number:literal $name:literal $section:expr => $judging:expr;)*) => {
        /// Rules by name.
        #[expect(dead_code, reason = "a rule that is judged as a whole counts no case by its name")]
        #[derive(Clone, Copy, Debug)]
        pub(super) enum SenderRule { $($rule),* }

        /// All rules, in their order.
        pub(in crate::conform::sender) static RULES: &[Rule] = &[$(Rule::new($number, $name, $section)),*];

        static JUDGING: [Judging; RULES.len()] = [$($judging),*];
    };
}

rules! {
    Version      "S1"  "version"       "versions"      => Counted("frames", 0.0, |_| "no frame came");
    Fields       "S2"  "fields"        FRAME           => Counted("frames", 0.0, NO_VERSION);
    CheckSum     "S3"  "check-sum"     "the-check-sum" => Counted("frames", 0.0, NO_VERSION);
    SenderId     "S4"  "sender-id"     FIELDS          => Counted("frames", 0.0, NO_WHOLE);
    Epoch        "S5"  "epoch"         FIELDS          => Counted("frames", 0.0, NO_GOOD);
    CycleTime    "S6"  "cycle-time"    FIELDS          => Counted("frames", 0.0, NO_GOOD);
    Count        "S7"  "count"         FIELDS          => Counted("frames", 0.0, NO_TWO);
    Index        "S8"  "index"         FIELDS          => Counted("frames", 0.0, NO_TWO);
    Pace         "S9"  "pace"          FIELDS          => Whole(|judge, _| judge.pace.pace());
    EveryCycle   "S10" "every-cycle"   FIELDS          => Whole(|judge, _| judge.pace.every_cycle());
    NoBursts     "S11" "no-bursts"     FIELDS          => Whole(|judge, _| judge.pace.bursts());
    StampPresent "S12" "stamp-present" FIELDS          => Whole(|judge, _| judge.stamps.present());
    StampRange   "S13" "stamp-range"   FIELDS          => Whole(|judge, _| judge.stamps.range(&judge.tallies));
    StampOrder   "S14" "stamp-order"   FIELDS          => Counted("stamps", 0.0, |judge| judge.stamps.why_none());
    AxisIds      "S15" "axis-ids"      AXIS            => Counted("frames", 0.0, NO_AXIS);
    AxisOrder    "S16" "axis-order"    AXIS            => Counted("frames", 0.0, NO_AXIS);
    AxisNumbers  "S17" "axis-numbers"  AXIS            => Counted("axes", 0.0, NO_AXIS);
    AxisState    "S18" "axis-state"    AXIS            => Counted("axes", 0.0, NO_AXIS);
    AxisVelocity "S19" "axis-velocity" AXIS            => Whole(|judge, _| judge.axes.velocity());
    AnswerFrame  "S20" "answer-frame"  EXCHANGE        => Counted("frames", BETWEEN_RUNS, NO_ANSWER);
    AnswerTime   "S21" "answer-time"   EXCHANGE        => Whole(|judge, end| judge.exchange.time(end));
    AnswerEcho   "S22" "answer-echo"   EXCHANGE        => Counted("responses", 0.0, NO_ANSWER);
    AnswerOnce   "S23" "answer-once"   EXCHANGE        => Counted("responses", 0.0, NO_ANSWER);
    AnswerStamps "S24" "answer-stamps" EXCHANGE        => Counted("responses", BETWEEN_RUNS, NO_ANSWER);
    StatusJson   "S25" "status-json"   "status"        => Counted("messages", 0.0, |_| "no status came");
    StatusFields "S26" "status-fields" NODE            => Counted("messages", 0.0, |_| "no status came that is JSON");
    StatusTrue   "S27" "status-true"   NODE            => Counted("messages", BETWEEN_RUNS, |_| "no status with all fields came");
    StatusPace   "S28" "status-pace"   "status"        => Whole(|judge, end| judge.status.pace(end, &judge.tallies));
    Alive        "S29" "alive"         KEYS            => Whole(|judge, _| judge.presence.alive());
    RunToken     "S30" "run-token"     KEYS            => Whole(|judge, _| judge.presence.run(judge.clock.as_ref()));
    Qos          "S31" "qos"           "quality-of-service" => Counted("frames", 0.0, |_| "the transport does not tell");
    PresentAfter "S32" "present-after" FIELDS          => Counted("frames", 0.0, NO_WHOLE);
}

/// Counted cases of each rule.
#[derive(Debug, Default)]
pub(in crate::conform::sender) struct Tallies([Tally; RULES.len()]);

impl Tallies {
    /// Counts a case of a rule, and returns true if it is good.
    pub(super) fn count(&mut self, rule: SenderRule, case: Result<(), Mismatch>) -> bool {
        let is_good = case.is_ok();
        self.0[rule as usize].count(case);
        is_good
    }

    /// Counts a case of a rule, and returns `is_good`; `otherwise` describes a bad one.
    pub(super) fn check(
        &mut self,
        rule: SenderRule,
        is_good: bool,
        otherwise: impl FnOnce() -> Mismatch,
    ) -> bool {
        self.count(rule, ensure(is_good, otherwise))
    }

    pub(super) const fn of(&self, rule: SenderRule) -> &Tally {
        &self.0[rule as usize]
    }

    /// Tallies in the order of the rules.
    pub(in crate::conform::sender) fn iter(&self) -> impl Iterator<Item = &Tally> {
        self.0.iter()
    }
}

/// A finding about each rule, at `end`.
pub(super) fn findings(judge: &SenderJudge, end: Instant<Machine>) -> Vec<RuleFinding> {
    let outcome = |(judging, tally): (&Judging, &Tally)| match judging {
        Counted(cases, share, none) => tally.outcome_but_for(*share, cases, none(judge)),
        Whole(outcome) => outcome(judge, end),
    };
    let outcomes = JUDGING.iter().zip(judge.tallies.iter()).map(outcome);
    let rules = RULES.iter().zip(outcomes);
    rules
        .map(|(rule, outcome)| RuleFinding::new(rule, outcome))
        .collect()
}
