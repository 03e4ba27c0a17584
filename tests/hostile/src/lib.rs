//! Hostile input: no input from files or the network may end a node, or use up its time or memory.
//!
//! A [`Target`] is a plain function that handles bytes as a node or the tool would. `tests/hostile.rs`
//! runs each over the stored corpus and over [mutations](mutate) of it; `tests/fuzz` runs each guided by its coverage.
//! `docs/FUZZ.md` describes how. The crate is free of Zenoh, whose build would take longer than a search.

mod axis_commands;
mod axis_orders;
mod bytes;
mod far_frames;
mod files;
pub mod mutate;
mod node;
mod plates;
mod plc;
mod ros;
mod seeds;
mod streams;
pub mod trial;
mod wire;

use coaxle_node::MOST_CHARACTERS;

pub use seeds::root;

/// Outcome of an input: taken, or refused with a message.
pub type Outcome = Result<(), String>;

/// A function that takes external input.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// The name of its folder in `tests/corpus`.
    pub name: &'static str,
    /// Kind of input.
    pub kind: Kind,
    /// Handles the input as a node or the tool would.
    pub run: fn(&[u8]) -> Outcome,
    /// Good inputs, each with a name: shipped files, and messages of nodes.
    pub seeds: fn() -> Vec<(String, Vec<u8>)>,
}

/// Kind of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Text, of numbers, names and brackets.
    Text,
    /// Bytes.
    Bytes,
}

/// Every target.
pub const TARGETS: &[Target] = &[
    Target {
        name: "frame",
        kind: Kind::Bytes,
        run: wire::frame,
        seeds: seeds::frames,
    },
    Target {
        name: "time-request",
        kind: Kind::Bytes,
        run: wire::time_request,
        seeds: seeds::time_requests,
    },
    Target {
        name: "time-response",
        kind: Kind::Bytes,
        run: wire::time_response,
        seeds: seeds::time_responses,
    },
    Target {
        name: "plans",
        kind: Kind::Bytes,
        run: wire::plans,
        seeds: seeds::plans,
    },
    Target {
        name: "reports",
        kind: Kind::Bytes,
        run: wire::reports,
        seeds: seeds::reports,
    },
    Target {
        name: "arrivals",
        kind: Kind::Bytes,
        run: streams::arrivals,
        seeds: seeds::arrivals,
    },
    Target {
        name: "order",
        kind: Kind::Text,
        run: streams::order,
        seeds: seeds::orders,
    },
    Target {
        name: "sender-config",
        kind: Kind::Text,
        run: files::sender_config,
        seeds: || seeds::shipped("sender/configs", "toml"),
    },
    Target {
        name: "receiver-config",
        kind: Kind::Text,
        run: files::receiver_config,
        seeds: || seeds::shipped("receiver/configs", "toml"),
    },
    Target {
        name: "scenario",
        kind: Kind::Text,
        run: files::scenario,
        seeds: seeds::scenarios,
    },
    Target {
        name: "cam-file",
        kind: Kind::Text,
        run: files::cam_file,
        seeds: || seeds::shipped("scenarios/cams", "toml"),
    },
    Target {
        name: "cam-table",
        kind: Kind::Text,
        run: files::cam_table,
        seeds: seeds::cam_tables,
    },
    Target {
        name: "point-table",
        kind: Kind::Text,
        run: files::point_table,
        seeds: seeds::point_tables,
    },
    Target {
        name: "plc-array",
        kind: Kind::Text,
        run: files::plc_array,
        seeds: seeds::plc_arrays,
    },
    Target {
        name: "saw-file",
        kind: Kind::Text,
        run: files::saw_file,
        seeds: || seeds::shipped("scenarios/saws", "toml"),
    },
    Target {
        name: "gear-file",
        kind: Kind::Text,
        run: files::gear_file,
        seeds: || seeds::shipped("scenarios/gears", "toml"),
    },
    Target {
        name: "recording",
        kind: Kind::Text,
        run: files::recording,
        seeds: seeds::recordings,
    },
    Target {
        name: "ros-trajectory",
        kind: Kind::Bytes,
        run: ros::trajectory,
        seeds: ros::trajectories,
    },
    Target {
        name: "ads",
        kind: Kind::Bytes,
        run: plc::ads,
        seeds: plc::recorded,
    },
    Target {
        name: "plc-datagrams",
        kind: Kind::Bytes,
        run: plc::datagrams,
        seeds: plc::good_datagrams,
    },
    Target {
        name: "plc-lines",
        kind: Kind::Text,
        run: plc::lines,
        seeds: plc::good_lines,
    },
    Target {
        name: "axis-orders",
        kind: Kind::Bytes,
        run: axis_orders::axis_orders,
        seeds: axis_orders::good_orders,
    },
    Target {
        name: "far-frames",
        kind: Kind::Bytes,
        run: far_frames::frames,
        seeds: far_frames::good_frames,
    },
    Target {
        name: "plate",
        kind: Kind::Bytes,
        run: plates::plate,
        seeds: plates::good_plates,
    },
];

/// The target of a name.
///
/// # Panics
/// Without one.
#[must_use]
pub fn target(name: &str) -> &'static Target {
    let found = TARGETS.iter().find(|target| target.name == name);
    found.unwrap_or_else(|| panic!("received the target {name:?}, expected one of TARGETS"))
}

impl Target {
    /// Runs it and checks the message of a refusal: one line, not empty and not too long.
    ///
    /// # Panics
    /// The message is not.
    pub fn examine(&self, data: &[u8]) -> Outcome {
        let outcome = (self.run)(data);
        if let Err(message) = &outcome {
            assert!(!message.trim().is_empty(), "refused without a word");
            assert!(
                // Input may be in the message: control characters would move the cursor of a terminal or split a line
                // of the log.
                !message.contains(|c: char| c.is_control()),
                "no single line: {message:?}"
            );
            // The line, the file, the field, and the reason.
            let length = message.chars().count();
            assert!(
                length <= 3 * MOST_CHARACTERS,
                "{length} characters: {message}"
            );
        }
        outcome
    }
}
