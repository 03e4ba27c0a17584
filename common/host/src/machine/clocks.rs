//! Clocks of this PC beyond its own quartz: TAI, cards that PTP disciplines, and the service that does so.

use std::time::Duration;

use coaxle_node::config::GrandmasterId;
use coaxle_os::machine;
use coaxle_os::{Os, PtpService, PtpState, System, SystemFacts};

use super::finding::{Finding, Severity};

/// Time that the PTP service has to answer.
const PATIENCE: Duration = Duration::from_millis(300);

/// Properties of the clocks.
#[derive(Clone, Debug, Default)]
struct ClockFacts {
    /// Offset of TAI from UTC, s; none if the system has no TAI.
    tai_offset_s: Option<i64>,
    /// Clocks of network cards.
    cards: Vec<String>,
    /// Answer of the PTP service; none if there is none.
    ptp: Option<PtpState>,
}

/// Says what the clocks of this PC can do, and what to switch on.
pub(super) fn examine(facts: Option<&SystemFacts>) -> Vec<Finding> {
    findings(&ClockFacts {
        tai_offset_s: machine::tai_offset_s(),
        cards: facts.map_or_else(Vec::new, |facts| facts.card_clocks.clone()),
        ptp: ask(),
    })
}

/// Asks the service, by either kind of address that it may answer to.
fn ask() -> Option<PtpState> {
    ask_once().or_else(ask_once)
}

fn ask_once() -> Option<PtpState> {
    let mut service = <<Os as System>::PtpService as PtpService>::open().ok()?;
    service.ask().ok()?;
    std::thread::park_timeout(PATIENCE);
    service.answer()
}

fn findings(facts: &ClockFacts) -> Vec<Finding> {
    let Some(tai_offset_s) = facts.tai_offset_s else {
        // Nothing else is of use without it.
        return Vec::new();
    };
    let note = |text: String, remedy| Finding {
        severity: Severity::Note,
        text,
        remedy: Some(remedy),
    };
    let cards = match &facts.cards[..] {
        [] => "no network card has a clock of its own, so PTP has stamps of the kernel, good to some 10 us".to_owned(),
        cards => format!("cards with a clock of their own: {}", cards.join(", ")),
    };
    let of_ptp = match &facts.ptp {
        Some(state) if state.is_present => Finding {
            severity: Severity::Good,
            text: format!(
                "common time: ptp4l follows the grandmaster {}, {} ns off at its last measurement; {cards}",
                GrandmasterId::from(state.grandmaster),
                state.offset_ns
            ),
            remedy: None,
        },
        Some(_) => note(
            format!("common time: ptp4l runs, and follows no grandmaster; {cards}"),
            "let one PC or switch be the grandmaster, in the same domain; docs/CLOCKS.md",
        ),
        None => note(
            format!("common time: none by ptp4l, which does not answer; {cards}"),
            "not needed; where several PCs have PTP: `time = { ptp = \"auto\" }` in the configs of nodes, docs/CLOCKS.md",
        ),
    };
    let mut all = vec![of_ptp];
    if tai_offset_s == 0 && facts.ptp.is_some_and(|state| state.is_present) {
        all.push(note(
            "the offset of TAI from UTC is not set: TAI of this PC is 37 s behind that of those which set it".to_owned(),
            "phc2sys sets it; where ptp4l disciplines the system's clock itself, set it at all PCs, or at none",
        ));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_there_is_is_said_and_what_to_switch_on() {
        let state = PtpState {
            grandmaster: 0x001b_21ff_fe3c_04e5,
            offset_ns: -12,
            is_present: true,
        };
        let said = |facts: ClockFacts| {
            let found = findings(&facts);
            let lines = found
                .iter()
                .map(|finding| format!("{:?} {}", finding.severity, finding.text));
            lines.collect::<Vec<_>>().join("\n")
        };
        assert_eq!(said(ClockFacts::default()), "");
        let none = ClockFacts {
            tai_offset_s: Some(0),
            ..ClockFacts::default()
        };
        assert!(said(none.clone()).starts_with("Note common time: none by ptp4l"));
        let followed = ClockFacts {
            tai_offset_s: Some(37),
            cards: vec!["ptp0 (igb)".to_owned()],
            ptp: Some(state),
        };
        assert_eq!(
            said(followed.clone()),
            "Good common time: ptp4l follows the grandmaster 00:1b:21:ff:fe:3c:04:e5, -12 ns off at its last measurement; \
             cards with a clock of their own: ptp0 (igb)"
        );
        let unset = ClockFacts {
            tai_offset_s: Some(0),
            ..followed
        };
        assert!(said(unset).contains("Note the offset of TAI from UTC is not set"));
        let alone = ClockFacts {
            ptp: Some(PtpState {
                is_present: false,
                ..state
            }),
            ..none
        };
        assert!(said(alone).contains("follows no grandmaster"));
    }
}
