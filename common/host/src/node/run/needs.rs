//! Resources that a node needs of the system.

use coaxle_node::Node;

use super::Setup;
use super::rings::memory_of;
use crate::machine::needs::Needs;

/// Descriptors of a node without neighbours: of its runtime, Zenoh's, and the clients that command and watch it.
// A sender that one receiver follows has 17 of its own (/proc/PID/fd, Zenoh 1.10.2): 9 of epoll and events, 7 sockets and a
// pipe. The others are for operators and viewers.
const FILES: usize = 32;
/// Descriptors of a link, also while it is replaced by another one.
const LINK_FILES: usize = 2;
/// Descriptors of a timing channel at each end.
const TIMING_FILES: usize = 4;
/// Threads of a node: six of its own, those of Zenoh as of [`ZENOH_RUNTIME`](crate::network::transport::ZENOH_RUNTIME), and
/// one while the session closes.
// Ten run in a sender, and more of Zenoh's start for a moment while links open.
const THREADS: usize = 14;
/// Memory of the libraries and of telemetry, bytes.
// 32 MiB of records that wait, and what a session takes.
const MEMORY: usize = 48 << 20;

/// Needs of the node in this set-up.
pub(super) fn of<N: Node>(setup: &Setup<N>) -> Needs {
    let transport = &setup.transport;
    let followed = setup.wiring.subscriptions.iter();
    let followed = followed.filter(|of| of.channel.carries_axes()).count();
    let links = transport.listen.len() + transport.connect.len() + followed;
    let timing = if setup.timing.is_none() {
        0
    } else {
        TIMING_FILES
    };
    let service = setup.transport_service.as_ref();
    let (files, threads) = service.map_or((0, 0), |of| (of.files, of.threads));
    Needs {
        files: FILES + LINK_FILES * links + timing + files,
        threads: THREADS + threads,
        memory: MEMORY + memory_of(&setup.wiring.subscriptions),
    }
}
