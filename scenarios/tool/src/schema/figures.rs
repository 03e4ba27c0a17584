//! The figures of `summary.json` that signals give.
#![cfg(test)]

use std::fmt::Write;

use coaxle_node::signal::Signals;
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals, NodeSignals, SlaveSignals};

/// The figures of a receiver.
pub(super) fn of_receiver() -> String {
    rows::<NodeSignals>() + &rows::<FarNodeSignals>() + &rows::<FarAxisSignals>()
}

/// The figures of a slave.
pub(super) fn of_slave() -> String {
    rows::<SlaveSignals>()
}

fn rows<T: Signals>() -> String {
    let mut rows = String::new();
    for signal in T::SIGNALS.iter().filter(|signal| signal.is_summarized) {
        let unit = match signal.unit {
            "" => String::new(),
            unit => format!(" Unit: {unit}."),
        };
        let meaning = signal.meaning();
        let _ = writeln!(
            rows,
            "| `{}` | In the last cycle: {meaning}{unit} |",
            signal.name
        );
    }
    rows
}
