//! A receiver's config for tests of its parts.

use super::ReceiverConfig;

/// Reads a config of a receiver with a cycle of 1 ms, and the text of an error.
pub(crate) fn config(rest: &str) -> Result<ReceiverConfig, String> {
    let text = format!("name = 'r'\ncycle-time-us = 1000\n{rest}");
    coaxle_node::config::parse("r.toml", &text).map_err(|error| error.to_string())
}
