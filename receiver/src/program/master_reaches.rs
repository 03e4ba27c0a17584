//! `when.master-reaches`: the master is about to come to a position, as its node has promised.

use coaxle_axis::motion_plan::AwaitedPosition;
use coaxle_axis::{Modulo, TravelDirection};
use coaxle_node::config::{Finite, LeadMs, Wrong};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::situation::Situation;

/// Position to which the master comes within a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct MasterReaches {
    /// The position of the master, in its units; or `{ in-turn = 90 }`, in each of its modulo turns.
    pub position: AwaitedPlace,
    /// `"forward"` or `"backward"`: the direction of the master then. Any by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<TravelDirection>,
    /// The time, ms, such as the dead time of what the step switches. 0 by default: in the first cycle that shows the master
    /// there, or beyond.
    #[serde(default = "no_time")]
    pub within_ms: LeadMs,
}

/// Position of a master, as written.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a position, or { in-turn = 90 }")]
pub enum AwaitedPlace {
    /// Position that it has once, u.
    At(Finite),
    /// In each turn of a modulo axis.
    InTurn(InTurn),
}

/// Position within each turn of a modulo axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct InTurn {
    /// From 0 up to less than the modulo period, u.
    pub in_turn: Finite,
}

fn no_time() -> LeadMs {
    LeadMs::new(0.0).expect("a lead may be zero")
}

impl MasterReaches {
    /// Checks that the master can come there: `modulo` is its period.
    ///
    /// # Errors
    /// [`Wrong`] names the position.
    pub(crate) fn check(&self, modulo: Option<Modulo>) -> Result<(), Wrong> {
        let AwaitedPlace::InTurn(InTurn { in_turn }) = self.position else {
            return Ok(());
        };
        let (received, expected) = match modulo {
            None => (
                format!(
                    "in-turn {} of a master without a modulo turn",
                    in_turn.get()
                ),
                "a position; or give the master a modulo".to_owned(),
            ),
            Some(modulo) if !modulo.has(in_turn.get()) => (
                format!("in-turn {}", in_turn.get()),
                format!("0 up to less than the modulo turn of {}", modulo.length()),
            ),
            Some(_) => return Ok(()),
        };
        Err(Wrong::of(
            "when.master-reaches.position",
            received,
            expected,
        ))
    }

    /// True if the master comes there within the time, or has come since the cycle before.
    pub(super) fn holds(&self, at: &Situation<'_>) -> bool {
        let (position, modulo) = match self.position {
            AwaitedPlace::At(position) => (position.get(), None),
            AwaitedPlace::InTurn(InTurn { in_turn }) => (in_turn.get(), at.master_modulo),
        };
        let awaited = AwaitedPosition {
            position,
            modulo,
            direction: self.direction,
        };
        let within = self.within_ms.span();
        (at.promised).is_some_and(|promised| promised.comes_to(&awaited, within))
    }
}
