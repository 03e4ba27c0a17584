//! Invariants of every cycle of every run, and a scenario's exceptions.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::number::significant;
use crate::summary::World;
use crate::verdict::Verdict;

/// An invariant of every cycle, in both worlds.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Invariant {
    /// Signals of a slave or of a far axis are finite numbers.
    Finite,
    /// The set positions of a slave keep its velocity in their differences.
    Velocity,
    /// The second differences of the set positions keep the larger of its acceleration and its deceleration.
    Acceleration,
    /// The third differences of the set positions keep its jerk.
    Jerk,
    /// Set positions keep the software limits; from beyond one, they go no farther.
    SoftwareLimit,
    /// The corrected time of a far axis never stands or goes back within a run of its node.
    FarTime,
    /// In observer mode no cycle of that time gains or loses more than a share of its length. TS5066 has no bound.
    FarRate,
    /// In virtual time and in sync with a measured delay, the error of the corrected time is no larger than stated. For 12 s after a clock has jumped, or a
    /// receiver that others may follow has restarted, it is not judged; nor where delays are correlated.
    /// With another delay, where none changes on the way, it deviates from its once settled value by no more than 2 ms.
    FarError,
    /// Within a run of its node the count of the frame that is used never goes back.
    Count,
    /// A slave leaves error stop for standstill or without power, never into a motion.
    ErrorLatch,
    /// In error stop the slave comes to rest within the way that its deceleration and jerk require.
    StoppingWay,
    /// Within a run of the receiver the cycle number increases from row to row, and the cycles between were skipped, as counted.
    Cycles,
    /// A lock changes the period of a receiver's cycle by no more than 500 ppm.
    CyclePeriod,
    /// A slave that has set values has them in every cycle from then on.
    SetValues,
    /// The position of a slave is set, as by switching on, homing or a reset, only where the slave was at rest in the cycle
    /// before.
    SetAnew,
    /// Another run of a far node, or another node, is followed only if it is counted.
    Owner,
    /// Every message of a far node is accounted for, once.
    Messages,
    /// A far axis goes no farther in a cycle, and where it follows is no farther from the received position, than its master's own motion
    /// and its mode explain.
    FarAxis,
    /// In virtual time, in observer mode and in sync with a measured delay, a far axis is at its master's position at that instant, within the
    /// stated error of its time, times the velocity, and the effect of a motion that changed since the newest frame. Judged when
    /// `far-error` is, and not where the master is seen through an encoder.
    FarPosition,
    /// A slave whose coupling is in sync is at the coupling's position, within its window (`distance.in-sync-window`).
    InSync,
    /// A slave that catches up with a steadily moving target does not go away from it faster and faster.
    Approach,
    /// The velocity that leaves beside a set position is that of the set positions, and keeps its limits.
    ToldVelocity,
    /// The acceleration that leaves beside a set position is that of the set positions, and keeps its limits.
    ToldAcceleration,
    /// A sender's axis that stops with its followers rests while a slave of one is in error, from 10 s, its age limit and its lead after that on.
    CoupledStop,
    /// At the end of the run no slave is in error stop, or farther from its coupling's position than its window, and no far axis
    /// in error, or lost.
    EndsWell,
}

impl Invariant {
    /// Returns the name in scenarios and summaries.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Finite => "finite",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
            Self::SoftwareLimit => "software-limit",
            Self::FarTime => "far-time",
            Self::FarRate => "far-rate",
            Self::FarError => "far-error",
            Self::Count => "count",
            Self::ErrorLatch => "error-latch",
            Self::StoppingWay => "stopping-way",
            Self::Cycles => "cycles",
            Self::CyclePeriod => "cycle-period",
            Self::SetValues => "set-values",
            Self::SetAnew => "set-anew",
            Self::Owner => "owner",
            Self::Messages => "messages",
            Self::FarAxis => "far-axis",
            Self::FarPosition => "far-position",
            Self::InSync => "in-sync",
            Self::Approach => "approach",
            Self::ToldVelocity => "told-velocity",
            Self::ToldAcceleration => "told-acceleration",
            Self::CoupledStop => "coupled-stop",
            Self::EndsWell => "ends-well",
        }
    }
}

/// A slave, a far axis or a far node of a receiver, or the receiver itself, by their names; or an axis of a sender.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct WatchedPart {
    /// The receiver.
    pub receiver: String,
    /// The slave, the far axis or the far node; none: the receiver itself.
    pub part: Option<String>,
}

/// An invariant that did not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct InvariantViolation {
    /// The part concerned.
    pub of: WatchedPart,
    /// The violated invariant.
    pub invariant: Invariant,
    /// The first cycle in violation.
    pub first: Broken,
    /// The worst cycle.
    pub worst: Broken,
    /// Limit, without the allowance for rounding.
    pub limit: f64,
    /// Number of cycles in violation.
    pub cycles: u64,
}

/// A cycle in which an invariant did not hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Broken {
    /// The receiver's cycle number.
    pub cycle: u64,
    /// Time, s after the start of the run.
    pub t_s: f64,
    /// Value received: u, u/s, u/s² or u/s³ of a slave; of a far time s or a share; of counters a number.
    pub value: f64,
}

impl fmt::Display for InvariantViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.verdict().fmt(f)
    }
}

impl InvariantViolation {
    fn verdict(&self) -> Verdict {
        let Self {
            of,
            invariant,
            first,
            worst,
            limit,
            cycles,
        } = self;
        let (name, cycle, t_s) = (invariant.name(), first.cycle, first.t_s);
        let mut expected = match invariant {
            Invariant::Finite => "a number".to_owned(),
            Invariant::FarTime => "later than the cycle before".to_owned(),
            Invariant::Cycles | Invariant::Messages => format!("{limit}"),
            Invariant::SetValues => "set values".to_owned(),
            // A distance has a window as its limit, and an error none.
            Invariant::EndsWell if *limit == 0.0 => {
                "no error in the end, and none that is lost".to_owned()
            }
            Invariant::Owner => format!("at least {limit}, as another one is followed"),
            _ => format!("at most {limit}"),
        };
        if *cycles > 1 {
            // Six digits, with which a value just beyond its limit differs from it.
            let value = significant(worst.value, 6);
            let when = worst.t_s;
            expected += &format!("; so in {cycles} cycles, {value} at {when:.3} s the worst");
        }
        Verdict {
            receiver: of.receiver.clone(),
            slave: of.part.clone(),
            field: format!("{name} at {t_s:.3} s, cycle {cycle},"),
            expected,
            received: match invariant {
                // A code, as it is written elsewhere.
                Invariant::EndsWell if *limit == 0.0 => {
                    json!(format!("{:#06x}", first.value as u32))
                }
                _ => json!(first.value),
            },
            met: false,
        }
    }
}

/// An exception of a scenario from an invariant, and its reason.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Exception {
    /// The receiver.
    pub receiver: String,
    /// The slave, for a far time the far axis, for messages the far node concerned, or for cycles the receiver itself.
    pub of: String,
    /// Invariants that do not hold.
    pub from: Vec<Invariant>,
    /// Reason.
    pub reason: String,
}

impl Exception {
    fn covers(&self, violation: &InvariantViolation, invariant: Invariant) -> bool {
        let WatchedPart { receiver, part } = &violation.of;
        // The cycles of the receiver itself belong to none of its parts.
        let is_it = self.receiver == *receiver && self.of == *part.as_ref().unwrap_or(receiver);
        is_it && violation.invariant == invariant
    }
}

/// Failures: violations without an exception, and in virtual time exceptions that were not needed.
/// Processes may or may not need theirs.
pub(crate) fn judge(
    exceptions: &[Exception],
    violations: &[InvariantViolation],
    world: World,
) -> Vec<Verdict> {
    let is_meant = |violation: &&InvariantViolation| {
        let mut all = exceptions.iter();
        all.any(|one| {
            one.from
                .iter()
                .any(|invariant| one.covers(violation, *invariant))
        })
    };
    let broken = violations.iter().filter(|one| !is_meant(one));
    let mut failed: Vec<_> = broken.map(InvariantViolation::verdict).collect();
    // In virtual time each seed breaks what it broke before. Among processes a fault may not show in one run.
    if world == World::Virtual {
        failed.extend(exceptions.iter().flat_map(|one| unneeded(one, violations)));
    }
    failed
}

fn unneeded(exception: &Exception, violations: &[InvariantViolation]) -> Vec<Verdict> {
    let kept = |invariant: &&Invariant| {
        let mut all = violations.iter();
        !all.any(|violation| exception.covers(violation, **invariant))
    };
    let verdict = |invariant: &Invariant| Verdict {
        receiver: exception.receiver.clone(),
        slave: Some(exception.of.clone()),
        field: invariant.name().to_owned(),
        expected: "not so, as the scenario has an exception: it is not needed".to_owned(),
        received: json!("kept in every cycle"),
        met: false,
    };
    exception.from.iter().filter(kept).map(verdict).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn violation(invariant: Invariant, cycles: u64) -> InvariantViolation {
        let broken = |cycle, value| Broken {
            cycle,
            t_s: cycle as f64 * 1e-3,
            value,
        };
        InvariantViolation {
            of: WatchedPart {
                receiver: "bypass".to_owned(),
                part: Some("saw".to_owned()),
            },
            invariant,
            first: broken(3_214, 7_312.5),
            worst: broken(4_001, 9_000.0),
            limit: 5_000.0,
            cycles,
        }
    }

    fn exception(from: &[Invariant]) -> Exception {
        Exception {
            receiver: "bypass".to_owned(),
            of: "saw".to_owned(),
            from: from.to_vec(),
            reason: "it shows the beat".to_owned(),
        }
    }

    fn lines(
        exceptions: &[Exception],
        violations: &[InvariantViolation],
        world: World,
    ) -> Vec<String> {
        let failed = judge(exceptions, violations, world);
        assert!(failed.iter().all(|verdict| !verdict.met));
        failed.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_violation_says_who_when_what_and_how_much() {
        let found = [
            violation(Invariant::Acceleration, 1),
            violation(Invariant::Velocity, 12),
        ];
        assert_eq!(
            lines(&[], &found, World::Processes),
            [
                "bypass.saw.acceleration at 3.214 s, cycle 3214, is 7312.5, expected at most 5000",
                "bypass.saw.velocity at 3.214 s, cycle 3214, is 7312.5, expected at most 5000; \
                 so in 12 cycles, 9000.00 at 4.001 s the worst",
            ]
        );
    }

    /// Violations without a part are the receiver's own, and are excepted by its name.
    #[test]
    fn cycles_of_the_receiver_itself_may_be_excepted() {
        let mut found = violation(Invariant::Cycles, 1);
        found.of.part = None;
        let found = [found];
        let exception = |of: &str| Exception {
            of: of.to_owned(),
            ..exception(&[Invariant::Cycles])
        };
        assert!(lines(&[exception("bypass")], &found, World::Virtual).is_empty());
        assert!(!lines(&[exception("saw")], &found, World::Processes).is_empty());
    }

    #[test]
    fn what_is_meant_is_no_failure_and_nothing_else_is_covered() {
        let found = [violation(Invariant::Acceleration, 1)];
        assert!(
            lines(
                &[exception(&[Invariant::Acceleration])],
                &found,
                World::Virtual
            )
            .is_empty()
        );
        for other in [
            exception(&[Invariant::Velocity]),
            Exception {
                of: "knife".to_owned(),
                ..exception(&[Invariant::Acceleration])
            },
            Exception {
                receiver: "sync".to_owned(),
                ..exception(&[Invariant::Acceleration])
            },
        ] {
            assert_eq!(lines(&[other], &found, World::Processes).len(), 1);
        }
    }

    #[test]
    fn an_exception_that_is_not_needed_fails_in_virtual_time() {
        let exceptions = [exception(&[Invariant::Acceleration, Invariant::Velocity])];
        let found = [violation(Invariant::Acceleration, 1)];
        assert_eq!(
            lines(&exceptions, &found, World::Virtual),
            [
                "bypass.saw.velocity is \"kept in every cycle\", expected not so, as the scenario has \
                 an exception: it is not needed"
            ]
        );
        assert!(lines(&exceptions, &found, World::Processes).is_empty());
    }

    #[test]
    fn an_exception_is_read_as_scenarios_write_it() {
        let text = "receiver = 'bypass'\nof = 'saw'\nfrom = ['acceleration', 'software-limit']\nreason = 'x'";
        let read: Exception = coaxle_node::config::parse("e", text).unwrap();
        assert_eq!(
            read.from,
            [Invariant::Acceleration, Invariant::SoftwareLimit]
        );
        for name in ["finite", "velocity", "jerk", "far-time", "far-rate"] {
            let text = format!("receiver = 'a'\nof = 'b'\nfrom = ['{name}']\nreason = ''");
            let read: Exception = coaxle_node::config::parse("e", &text).unwrap();
            assert_eq!(read.from[0].name(), name);
        }
    }
}
