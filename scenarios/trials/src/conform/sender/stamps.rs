//! The send stamps of frames.

use coaxle_clock::Span;
use coaxle_node::FrameHeader;

use super::rules::{STAMP_ORDER, STAMP_PRESENT, STAMP_RANGE};
use super::runs::FramePlace;
use crate::conform::rule::{RuleFinding, RuleOutcome, Tally};

/// Greatest lateness of a node.
const MOST: Span = Span::from_secs(1);
/// Number of zeros that are no coincidence.
const ZEROS: u64 = 20;

/// The stamp, if it is in the possible range.
pub(super) fn possible(header: &FrameHeader) -> Option<Span> {
    let cycle = header.cycle_time.span();
    header
        .send_stamp
        .filter(|stamp| (-cycle..=MOST).contains(stamp))
}

/// Checks of the stamps.
#[derive(Debug, Default)]
pub(super) struct StampChecks {
    with: u64,
    without: u64,
    zeros: u64,
    range: Tally,
    order: Tally,
    /// Departure of the frame before, since the ideal start of its node's cycle 0.
    left: Option<Span>,
}

impl StampChecks {
    /// Takes a frame that has its place in a run.
    pub(super) fn take(&mut self, header: &FrameHeader, step: FramePlace) {
        if step == FramePlace::Begins {
            self.left = None;
        }
        let Some(stamp) = header.send_stamp else {
            self.without += 1;
            return;
        };
        self.with += 1;
        self.zeros += u64::from(stamp == Span::ZERO);
        let cycle = header.cycle_time.span();
        let is_possible = possible(header).is_some();
        self.range.check(is_possible, || {
            (
                format!("{stamp} at count {}", header.count),
                format!(
                    "{} to {MOST}, the nanoseconds since its own cycle began",
                    -cycle
                ),
            )
        });
        if is_possible {
            self.leave(header, cycle * header.count as i64 + stamp);
        }
    }

    /// The newest departure.
    pub(super) const fn left(&self) -> Option<Span> {
        self.left
    }

    pub(super) fn findings(&self) -> Vec<RuleFinding> {
        let none = match self.without {
            0 => "no good frame came",
            _ => "no frame has one: the jitter of the sender counts as the network's",
        };
        vec![
            RuleFinding::new(&STAMP_PRESENT, self.present(none)),
            RuleFinding::new(&STAMP_RANGE, self.range(none)),
            RuleFinding::new(&STAMP_ORDER, self.order.outcome("stamps", none)),
        ]
    }

    fn leave(&mut self, header: &FrameHeader, left: Span) {
        if let Some(before) = self.left.replace(left) {
            self.order.check(left > before, || {
                (
                    format!(
                        "count {} to leave {} before the one before it",
                        header.count,
                        before - left
                    ),
                    "later frames to leave later".to_owned(),
                )
            });
        }
    }

    fn present(&self, none: &str) -> RuleOutcome {
        match (self.with, self.without) {
            (0, _) => RuleOutcome::not_seen(none),
            (with, 0) => RuleOutcome::kept(format!("{with} frames")),
            (with, without) => RuleOutcome::broken(
                format!("{without} of {} frames without one", with + without),
                "one in every frame of a client that knows, none in those of one that does not",
            ),
        }
    }

    fn range(&self, none: &str) -> RuleOutcome {
        if self.zeros == self.with && self.zeros >= ZEROS {
            return RuleOutcome::broken(
                format!("0 in all of {} frames", self.zeros),
                "none from a client that cannot tell",
            );
        }
        self.range.outcome("stamps", none)
    }
}
