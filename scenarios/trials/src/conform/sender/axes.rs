//! Checks of the axes in frames.

use std::collections::BTreeMap;

use coaxle_axis::{NcToPlcAxis, StateWord};
use coaxle_clock::Span;

use super::rules::{AXIS_IDS, AXIS_NUMBERS, AXIS_ORDER, AXIS_STATE, AXIS_VELOCITY};
use super::runs::FramePlace;
use crate::conform::rule::{RuleFinding, RuleOutcome, Tally};

/// Number of frames over which velocity and position are compared.
const WINDOW: u32 = 50;
/// Difference of both, as a share of the way, that is allowed …
const SHARE: f64 = 0.2;
/// … and exceeded in at most this share of the windows: a position may be reset, and wrap.
const WINDOWS: f64 = 0.5;

/// Contradictory states of an axis.
const CONTRADICTIONS: [(StateWord, &str); 4] = [
    (
        StateWord::POSITIVE_DIRECTION.union(StateWord::NEGATIVE_DIRECTION),
        "positive direction (9) and negative direction (10)",
    ),
    (
        StateWord::NOT_MOVING.union(StateWord::POSITIVE_DIRECTION),
        "not moving (2) and positive direction (9)",
    ),
    (
        StateWord::NOT_MOVING.union(StateWord::NEGATIVE_DIRECTION),
        "not moving (2) and negative direction (10)",
    ),
    (
        StateWord::NOT_MOVING.union(StateWord::CONSTANT_VELOCITY),
        "not moving (2) and constant velocity (12)",
    ),
];

/// The axes of all frames.
#[derive(Debug, Default)]
pub(super) struct AxisChecks {
    /// The ids of the run's first frame.
    ids: Vec<u32>,
    once: Tally,
    order: Tally,
    numbers: Tally,
    state: Tally,
    /// Tally of each axis.
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
    pub(super) fn take(&mut self, axes: &[NcToPlcAxis], cycle: Span, step: FramePlace) {
        self.empty += u64::from(axes.is_empty());
        let ids: Vec<_> = axes.iter().map(|axis| axis.axis_id).collect();
        if step == FramePlace::Begins {
            self.windows.clear();
            self.ids.clone_from(&ids);
        }
        self.judge_ids(&ids);
        for axis in axes {
            self.judge(axis);
        }
        // Of axes that share an id, the first is the axis.
        let mut seen = Vec::new();
        for axis in axes {
            if !seen.contains(&axis.axis_id) {
                seen.push(axis.axis_id);
                self.judge_velocity(axis, cycle, step);
            }
        }
    }

    pub(super) fn findings(&self) -> Vec<RuleFinding> {
        let none = match self.empty {
            0 => "no good frame came",
            _ => "no frame has an axis: nobody can follow one",
        };
        vec![
            RuleFinding::new(&AXIS_IDS, self.once.outcome("frames", none)),
            RuleFinding::new(&AXIS_ORDER, self.order.outcome("frames", none)),
            RuleFinding::new(&AXIS_NUMBERS, self.numbers.outcome("axes", none)),
            RuleFinding::new(&AXIS_STATE, self.state.outcome("axes", none)),
            RuleFinding::new(&AXIS_VELOCITY, self.velocity()),
        ]
    }

    /// Outcome of the first axis that is not in order, or of any that moved.
    fn velocity(&self) -> RuleOutcome {
        let of = |tally: &Tally| tally.outcome_but_for(WINDOWS, "stretches", "");
        let mut all: Vec<_> = self.velocity.values().map(of).collect();
        let broken = all
            .iter()
            .position(|outcome| matches!(outcome, RuleOutcome::Broken { .. }));
        match all.is_empty() {
            true => RuleOutcome::not_seen("no axis moved for long enough"),
            false => all.swap_remove(broken.unwrap_or(0)),
        }
    }

    fn judge_ids(&mut self, ids: &[u32]) {
        if ids.is_empty() {
            return;
        }
        let twice = (1..ids.len()).find(|n| ids[..*n].contains(&ids[*n]));
        self.once.check(twice.is_none(), || {
            let id = twice.map_or(0, |n| ids[n]);
            (
                format!("axis {id} twice in a frame"),
                "each id once".to_owned(),
            )
        });
        self.order.check(*ids == self.ids, || {
            (
                format!("the axes {}", listed(ids)),
                format!("{} in every frame of the run", listed(&self.ids)),
            )
        });
    }

    fn judge(&mut self, axis: &NcToPlcAxis) {
        let field = axis.implausible_field();
        self.numbers.check(field.is_none(), || {
            (
                format!(
                    "no such number in {} of axis {}",
                    field.unwrap_or(""),
                    axis.axis_id
                ),
                "numbers from -1e15 to 1e15".to_owned(),
            )
        });
        let word = axis.state_word;
        let both = CONTRADICTIONS.iter().find(|(bits, _)| word.contains(*bits));
        let is_silent = word.contains(StateWord::ERROR) && axis.error_code == 0;
        self.state
            .check(both.is_none() && !is_silent, || match both {
                Some((_, both)) => (
                    format!("{both} of axis {}", axis.axis_id),
                    "one of them at a time".to_owned(),
                ),
                None => (
                    format!("error (31) and nErrorCode 0 of axis {}", axis.axis_id),
                    "the code of the error".to_owned(),
                ),
            });
    }

    fn judge_velocity(&mut self, axis: &NcToPlcAxis, cycle: Span, step: FramePlace) {
        let (position, velocity) = (axis.set_position, axis.set_velocity);
        let new = VelocityWindow {
            begin: position,
            velocity,
            way: 0.0,
            path: 0.0,
            frames: 0,
        };
        let counts = match step {
            FramePlace::Begins => 0,
            FramePlace::Goes { counts } => counts,
        };
        let window = self.windows.entry(axis.axis_id).or_insert(new);
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
        let tally = self.velocity.entry(axis.axis_id).or_default();
        tally.check(is_good, || {
            (
                format!("axis {} to move by {moved} u in fPosSoll", axis.axis_id),
                format!("{way} u, as fVeloSoll in u/s says"),
            )
        });
    }
}

fn listed(ids: &[u32]) -> String {
    let ids: Vec<_> = ids.iter().map(u32::to_string).collect();
    ids.join(", ")
}
