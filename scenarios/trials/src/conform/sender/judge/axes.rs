//! Checks of the axes in frames.

use std::collections::BTreeMap;

use coaxle_axis::{NcToPlcAxis, StateWord};
use coaxle_clock::Span;

use super::rules::{SenderRule, Tallies};
use super::runs::FramePlace;
use crate::conform::rule::{Mismatch, RuleOutcome, Tally, comma_separated, ensure, mismatch};

/// Number of frames over which velocity and position are compared.
const WINDOW: u32 = 50;
/// Difference of both, as a share of the way, that is allowed …
const SHARE: f64 = 0.2;
/// … and exceeded in at most this share of the windows: a position may be reset, and wrap.
const WINDOWS: f64 = 0.5;

/// Contradictory states of an axis.
const CONTRADICTIONS: [(StateWord, &str); 4] = {
    use StateWord as Bit;
    let (positive, negative) = (Bit::POSITIVE_DIRECTION, Bit::NEGATIVE_DIRECTION);
    let (resting, constant) = (Bit::NOT_MOVING, Bit::CONSTANT_VELOCITY);
    [
        (
            positive.union(negative),
            "positive direction (9) and negative direction (10)",
        ),
        (
            resting.union(positive),
            "not moving (2) and positive direction (9)",
        ),
        (
            resting.union(negative),
            "not moving (2) and negative direction (10)",
        ),
        (
            resting.union(constant),
            "not moving (2) and constant velocity (12)",
        ),
    ]
};

/// The axes of all frames.
#[derive(Debug, Default)]
pub(super) struct AxisChecks {
    /// The ids of the run's first frame.
    ids: Vec<u32>,
    /// Tally of the velocity of each axis.
    velocity: BTreeMap<u32, Tally>,
    windows: BTreeMap<u32, VelocityWindow>,
    empty: u64,
}

/// The way of an axis through some frames.
#[derive(Clone, Copy, Debug)]
struct VelocityWindow {
    begin: f64,
    velocity: f64,
    /// Way by the velocity, signed and as path length.
    way: f64,
    path: f64,
    frames: u32,
}

impl AxisChecks {
    /// Takes the axes of a frame that has its place in a run.
    pub(super) fn take(
        &mut self,
        axes: &[NcToPlcAxis],
        cycle: Span,
        place: FramePlace,
        tallies: &mut Tallies,
    ) {
        let ids: Vec<_> = axes.iter().map(|axis| axis.axis_id).collect();
        if place == FramePlace::Begins {
            self.windows.clear();
            self.ids.clone_from(&ids);
        }
        if axes.is_empty() {
            self.empty += 1;
            return;
        }
        let repeated = (1..ids.len()).find(|n| ids[..*n].contains(&ids[*n]));
        tallies.count(SenderRule::AxisIds, each_once(repeated.map(|n| ids[n])));
        tallies.count(SenderRule::AxisOrder, self.check_order(&ids));
        for (n, axis) in axes.iter().enumerate() {
            tallies.count(SenderRule::AxisNumbers, check_numbers(axis));
            tallies.count(SenderRule::AxisState, check_state(axis));
            // Of axes that share an id, the first is the axis.
            if !ids[..n].contains(&axis.axis_id) {
                self.check_velocity(axis, cycle, place);
            }
        }
    }

    /// Reason why no axis was seen.
    pub(super) const fn why_none(&self) -> &'static str {
        match self.empty {
            0 => "no good frame came",
            _ => "no frame has an axis: nobody can follow one",
        }
    }

    /// Outcome of the first axis that is not in order, or of any that moved.
    pub(super) fn velocity(&self) -> RuleOutcome {
        let of = |tally: &Tally| tally.outcome_but_for(WINDOWS, "stretches", "");
        let is_broken = |outcome: &RuleOutcome| matches!(outcome, RuleOutcome::Broken { .. });
        let all = || self.velocity.values().map(of);
        let outcome = all().find(is_broken).or_else(|| all().next());
        outcome.unwrap_or_else(|| RuleOutcome::not_seen("no axis moved for long enough"))
    }

    fn check_order(&self, ids: &[u32]) -> Result<(), Mismatch> {
        ensure(*ids == self.ids, || {
            let (received, first) = (comma_separated(ids), comma_separated(&self.ids));
            mismatch(
                format!("the axes {received}"),
                format!("{first} in every frame of the run"),
            )
        })
    }

    fn check_velocity(&mut self, axis: &NcToPlcAxis, cycle: Span, place: FramePlace) {
        let (id, position, velocity) = (axis.axis_id, axis.set_position, axis.set_velocity);
        let new = VelocityWindow {
            begin: position,
            velocity,
            way: 0.0,
            path: 0.0,
            frames: 0,
        };
        let counts = match place {
            FramePlace::Begins => 0,
            FramePlace::Goes { counts } => counts,
        };
        let window = self.windows.entry(id).or_insert(new);
        let by = (window.velocity + velocity) / 2.0 * cycle.as_secs_f64() * counts as f64;
        window.way += by;
        window.path += by.abs();
        window.velocity = velocity;
        window.frames += 1;
        if window.frames < WINDOW {
            return;
        }
        let (moved, way, path) = (position - window.begin, window.way, window.path);
        *window = new;
        if !(moved.is_finite() && path.is_finite()) || (moved == 0.0 && path == 0.0) {
            return;
        }
        let is_good = (moved - way).abs() <= SHARE * path.max(moved.abs());
        let case = ensure(is_good, || {
            mismatch(
                format!("axis {id} to move by {moved} u in fPosSoll"),
                format!("{way} u, as fVeloSoll in u/s says"),
            )
        });
        self.velocity.entry(id).or_default().count(case);
    }
}

fn each_once(repeated: Option<u32>) -> Result<(), Mismatch> {
    repeated.map_or(Ok(()), |id| {
        Err(mismatch(
            format!("axis {id} twice in a frame"),
            "each id once",
        ))
    })
}

fn check_numbers(axis: &NcToPlcAxis) -> Result<(), Mismatch> {
    axis.implausible_field().map_or(Ok(()), |field| {
        let received = format!("no such number in {field} of axis {}", axis.axis_id);
        Err(mismatch(received, "numbers from -1e15 to 1e15"))
    })
}

fn check_state(axis: &NcToPlcAxis) -> Result<(), Mismatch> {
    let (word, id) = (axis.state_word, axis.axis_id);
    if let Some((_, both)) = CONTRADICTIONS.iter().find(|(bits, _)| word.contains(*bits)) {
        let received = format!("{both} of axis {id}");
        return Err(mismatch(received, "one of them at a time"));
    }
    let is_silent = word.contains(StateWord::ERROR) && axis.error_code == 0;
    ensure(!is_silent, || {
        let received = format!("error (31) and nErrorCode 0 of axis {id}");
        mismatch(received, "the code of the error")
    })
}
