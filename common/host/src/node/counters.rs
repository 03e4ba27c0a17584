//! The host's counters, shared by its threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counters that several threads increment and the status reads. No ordering is needed, so relaxed
/// access is enough.
#[derive(Debug, Default)]
pub(crate) struct Counters {
    /// Cycles run.
    pub(crate) cycles: AtomicU64,
    /// Frames handed to the transport.
    pub(crate) published: AtomicU64,
    /// Frames that found the publisher's ring full.
    pub(crate) publish_dropped: AtomicU64,
    /// Frames that the transport refused.
    pub(crate) publish_failed: AtomicU64,
    /// Frames accepted on arrival.
    pub(crate) received: AtomicU64,
    /// Frames of axes refused on arrival.
    pub(crate) refused: AtomicU64,
    /// Time requests and responses refused on arrival.
    pub(crate) exchange_refused: AtomicU64,
    /// Messages that found the mailbox full. Shared on its own, with the mailbox.
    pub(crate) mailbox_dropped: Arc<AtomicU64>,
    /// Records that found the telemetry ring full.
    pub(crate) telemetry_dropped: AtomicU64,
    /// Arrivals that found their ring full.
    pub(crate) arrivals_dropped: AtomicU64,
}

/// Increments a counter.
pub(crate) fn count(counter: &AtomicU64) {
    // Each counter stands alone: no other memory is read by its value.
    counter.fetch_add(1, Ordering::Relaxed);
}

/// Reads a counter.
pub(crate) fn read(counter: &AtomicU64) -> u64 {
    counter.load(Ordering::Relaxed)
}
