//! The send stamps of frames.

use coaxle_clock::Span;
use coaxle_node::FrameHeader;

use super::rules::{SenderRule, Tallies};
use super::runs::FramePlace;
use crate::conform::rule::{RuleOutcome, mismatch};

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
    /// Departure of the frame before, since the ideal start of its node's cycle 0.
    left: Option<Span>,
}

impl StampChecks {
    /// Takes a frame that has its place in a run.
    pub(super) fn take(&mut self, header: &FrameHeader, place: FramePlace, tallies: &mut Tallies) {
        if place == FramePlace::Begins {
            self.left = None;
        }
        let Some(stamp) = header.send_stamp else {
            self.without += 1;
            return;
        };
        self.with += 1;
        self.zeros += u64::from(stamp == Span::ZERO);
        let (cycle, count) = (header.cycle_time.span(), header.count);
        let is_possible = possible(header).is_some();
        tallies.check(SenderRule::StampRange, is_possible, || {
            let earliest = -cycle;
            mismatch(
                format!("{stamp} at count {count}"),
                format!("{earliest} to {MOST}, the nanoseconds since its own cycle began"),
            )
        });
        if !is_possible {
            return;
        }
        let left = cycle * count as i64 + stamp;
        if let Some(before) = self.left.replace(left) {
            tallies.check(SenderRule::StampOrder, left > before, || {
                let early = before - left;
                mismatch(
                    format!("count {count} to leave {early} before the one before it"),
                    "later frames to leave later",
                )
            });
        }
    }

    /// The newest departure.
    pub(super) const fn left(&self) -> Option<Span> {
        self.left
    }

    /// Reason why no stamp was seen.
    pub(super) const fn why_none(&self) -> &'static str {
        match self.without {
            0 => "no good frame came",
            _ => "no frame has one: the jitter of the sender counts as the network's",
        }
    }

    pub(super) fn present(&self) -> RuleOutcome {
        match (self.with, self.without) {
            (0, _) => RuleOutcome::not_seen(self.why_none()),
            (with, 0) => RuleOutcome::kept(format!("{with} frames")),
            (with, without) => RuleOutcome::broken(
                format!("{without} of {} frames without one", with + without),
                "one in every frame of a client that knows, none in those of one that does not",
            ),
        }
    }

    pub(super) fn range(&self, tallies: &Tallies) -> RuleOutcome {
        if self.zeros == self.with && self.zeros >= ZEROS {
            return RuleOutcome::broken(
                format!("0 in all of {} frames", self.zeros),
                "none from a client that cannot tell",
            );
        }
        let tally = tallies.of(SenderRule::StampRange);
        tally.outcome("stamps", self.why_none())
    }
}
