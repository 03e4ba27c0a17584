//! The node to play to a receiver, by its status.

use std::fmt::Display;

use coaxle_clock::{CycleTime, Span};
use coaxle_node::keys::NodeName;
use serde_json::{Map, Value};

use super::player::PlayedRole;
use crate::conform::rule::comma_separated;

/// Shortest period of frames: the machine has other things to do.
const SHORTEST: Span = Span::from_millis(5);

/// Choices of the user.
#[derive(Clone, Debug, Default)]
pub(super) struct PlayOptions {
    pub(super) played: Option<NodeName>,
    pub(super) axis: Option<u32>,
    pub(super) cycle_time: Option<CycleTime>,
}

/// The node, its axis and its cycle time. `chance` makes its run differ from others.
///
/// # Errors
/// The reason why no node can be played, in words.
pub(super) fn chosen_role(
    receiver: &NodeName,
    status: &Map<String, Value>,
    options: &PlayOptions,
    chance: u64,
) -> Result<PlayedRole, String> {
    let played = played(status, options.played.as_ref())?;
    let axis = axis(status, &played, options.axis)?;
    let cycle_time = options.cycle_time.map_or_else(|| cycle_time(status), Ok)?;
    Ok(PlayedRole {
        played,
        axis,
        receiver: receiver.clone(),
        cycle_time,
        // An odd factor keeps different chances different.
        epoch: chance.wrapping_mul(0x9e37_79b9_7f4a_7c15),
    })
}

fn played(status: &Map<String, Value>, wish: Option<&NodeName>) -> Result<NodeName, String> {
    let sources = status.get("sources").and_then(Value::as_object);
    let sources = sources
        .filter(|sources| !sources.is_empty())
        .ok_or("received a status without sources, expected a receiver that follows a node")?;
    let names: Vec<_> = sources.keys().map(String::as_str).collect();
    let followed = names.join(", ");
    let name = match (wish.map(NodeName::as_str), names.as_slice()) {
        (Some(wish), names) if names.contains(&wish) => wish,
        (Some(wish), _) => return Err(not_followed("--as", wish, &followed)),
        (None, [name]) => *name,
        (None, _) => {
            return Err(format!(
                "it follows {followed}, expected --as with one of them"
            ));
        }
    };
    if sources[name]["alive"] == true {
        return Err(format!(
            "received {name}, which is there itself, expected one that is not: two of a name are told apart, and neither \
             could be tried"
        ));
    }
    NodeName::new(name).map_err(|error| error.to_string())
}

fn axis(status: &Map<String, Value>, played: &NodeName, wish: Option<u32>) -> Result<u32, String> {
    let axes = status.get("axes").and_then(Value::as_object);
    let of_node =
        (axes.into_iter().flat_map(Map::values)).filter(|axis| axis["node"] == played.as_str());
    let ids = of_node.filter_map(|axis| u32::try_from(axis["id"].as_u64()?).ok());
    let ids: Vec<_> = ids.collect();
    let first = *ids.first().ok_or_else(|| {
        format!("received a status without an axis of {played}, expected axes.*.node and axes.*.id")
    })?;
    match wish {
        Some(wish) if !ids.contains(&wish) => {
            Err(not_followed("--axis", wish, &comma_separated(&ids)))
        }
        wish => Ok(wish.unwrap_or(first)),
    }
}

fn not_followed(option: &str, wish: impl Display, followed: &str) -> String {
    format!("received {option} {wish}, expected one that it follows: {followed}")
}

fn cycle_time(status: &Map<String, Value>) -> Result<CycleTime, String> {
    let own = status.get("cycle_time_us").and_then(Value::as_f64);
    let own = own.and_then(|micros| CycleTime::new(Span::from_micros_f64(micros)).ok());
    let own = own.ok_or(
        "received a status without cycle_time_us from 100 to 100000, expected --cycle-time",
    )?;
    let span = own.span();
    let times = (SHORTEST - Span::from_nanos(1)).div_floor(span) + 1;
    CycleTime::new(span * times).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn cast(status: &Value, options: &PlayOptions) -> Result<PlayedRole, String> {
        let receiver = NodeName::new("saw").unwrap();
        chosen_role(&receiver, status.as_object().unwrap(), options, 1)
    }

    fn status() -> Value {
        json!({ "cycle_time_us": 2000.0,
            "sources": { "belt": { "alive": false }, "line": { "alive": true } },
            "axes": { "belt.3": { "node": "belt", "id": 3 }, "belt.4": { "node": "belt", "id": 4 } } })
    }

    #[test]
    fn whom_the_receiver_follows_is_played() {
        let belt = PlayOptions {
            played: NodeName::new("belt").ok(),
            ..PlayOptions::default()
        };
        let part = cast(&status(), &belt).unwrap();
        assert_eq!((part.played.as_str(), part.axis), ("belt", 3));
        assert_eq!(
            part.cycle_time.span(),
            Span::from_millis(6),
            "a multiple of its own"
        );
        let other = PlayOptions {
            axis: Some(4),
            ..belt
        };
        assert_eq!(cast(&status(), &other).unwrap().axis, 4);
    }

    #[test]
    fn who_cannot_be_played_is_told_with_who_can() {
        let wish = |name: &str, axis| PlayOptions {
            played: NodeName::new(name).ok(),
            axis,
            ..PlayOptions::default()
        };
        for (options, expected) in [
            (PlayOptions::default(), "belt, line, expected --as"),
            (
                wish("press", None),
                "received --as press, expected one that it follows: belt, line",
            ),
            (wish("line", None), "which is there itself"),
            (
                wish("belt", Some(9)),
                "received --axis 9, expected one that it follows: 3, 4",
            ),
        ] {
            let error = cast(&status(), &options).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        let error = cast(&json!({ "role": "sender" }), &PlayOptions::default()).unwrap_err();
        assert!(error.contains("without sources"), "{error}");
    }
}
