//! The session of a client.

use anyhow::Context;
use coaxle_node::config::TransportConfig;

use crate::machine::needs::Needs;
use crate::network::transport::OverZenoh;

/// Joins the network, if the system gives what a session needs.
///
/// # Errors
/// A resource that is missing, a wrong transport section, or a session that cannot be opened, with the endpoints.
pub(super) fn session(transport: &TransportConfig) -> anyhow::Result<OverZenoh> {
    // Without them Zenoh panics.
    Needs::CLIENT.check().context("cannot join the network")?;
    OverZenoh::open_and_wait(transport)
}
