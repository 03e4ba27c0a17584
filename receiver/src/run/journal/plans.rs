//! Log events of plans that cannot be used.

use super::{Level, Note};
use crate::signals::FarNodeSignals;
use crate::snapshot::ReceiverSnapshot;

/// A line for each axis whose plan is contradicted for the first time.
pub(super) fn of_contradictions(
    before: &ReceiverSnapshot,
    now: &ReceiverSnapshot,
    names: &[String],
) -> Vec<Note> {
    let axes = before.signals.axes.iter().zip(&now.signals.axes);
    let contradicted = axes.zip(names).filter_map(|((before, now), name)| {
        // The first one only: a node that does not keep its promises may break each of them.
        let is_first = before.plan_contradictions == 0 && now.plan_contradictions > 0;
        let text = || {
            format!(
                "{name}: received samples beside the motion that its node has promised, expected the promised ones: the \
                 plan is not used, and the samples are followed"
            )
        };
        is_first.then(|| Note::new(Level::Warning, text()))
    });
    contradicted.collect()
}

/// A line for the first plan that is refused for a reason.
pub(super) fn of_refusals(before: &FarNodeSignals, now: &FarNodeSignals) -> Option<Note> {
    let fault = now.plan_fault?;
    let is_new = now.plans_refused > before.plans_refused && before.plan_fault != Some(fault);
    is_new.then(|| {
        let name = fault.name();
        let text = format!("received a plan that cannot be used, {name}; it is left out");
        Note::new(Level::Warning, text)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_axis::motion_plan::PlanFault;

    #[test]
    fn a_refusal_is_told_once_for_each_reason() {
        let signals = |plans_refused, plan_fault| FarNodeSignals {
            plans_refused,
            plan_fault,
            ..FarNodeSignals::default()
        };
        let gap = Some(PlanFault::Gap);
        let said = |before: &FarNodeSignals, now: &FarNodeSignals| {
            of_refusals(before, now).map(|note| note.text)
        };
        assert_eq!(
            said(&signals(0, None), &signals(1, gap)).as_deref(),
            Some("received a plan that cannot be used, gap; it is left out")
        );
        assert_eq!(said(&signals(1, gap), &signals(2, gap)), None);
        let other = Some(PlanFault::OtherRun);
        assert!(said(&signals(2, gap), &signals(3, other)).is_some());
        // A contradiction has a line of its own.
        let beside = Some(PlanFault::Contradicted);
        assert_eq!(said(&signals(3, other), &signals(3, beside)), None);
    }
}
