//! Ports for nodes and peers that a test starts.

use coaxle_os::ClaimedPort;

/// A port of this machine, free for connections and datagrams, that no other test is given while this program of tests runs.
///
/// # Panics
/// The machine has none.
#[must_use]
pub fn free_port() -> u16 {
    ClaimedPort::find().expect("a free port").keep()
}

/// An endpoint of Zenoh at a [`free_port`].
#[must_use]
pub fn free_endpoint() -> String {
    format!("tcp/127.0.0.1:{}", free_port())
}
