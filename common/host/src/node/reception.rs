//! The path of received messages into a node, and the state of their source.

use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use coaxle_clock::{Instant, Span};
use coaxle_node::config::Wrong;
use coaxle_node::wiring::Subscription;
use coaxle_node::{Message, Reader, Rejection};
use coaxle_os::machine::Machine;

use crate::node::counters::{Counters, count};
use crate::node::described::{DescribedRuns, FrameAdmission};
use crate::node::faults::Faults;
use crate::node::mailbox::Inbox;

/// State of a source, written by the transport's threads.
pub(crate) struct Contact {
    alive: AtomicBool,
    /// Machine time of the last accepted frame; `i64::MIN` before the first.
    last_frame: AtomicI64,
    /// The axis ids of a frame with none of the followed axes, and its arrival.
    other_axes: Mutex<Option<(Instant<Machine>, Vec<u32>)>>,
    /// Decision about runs by what they say of their axes.
    described: DescribedRuns,
}

/// Interval between checks of the axes of frames that have none of the followed ones.
// Ids change with a restart of the sender at most, and copying them allocates.
const LOOK: Span = Span::from_secs(1);

impl Contact {
    pub(crate) fn new() -> Arc<Self> {
        Arc::new(Self {
            alive: AtomicBool::new(false),
            last_frame: AtomicI64::new(i64::MIN),
            other_axes: Mutex::new(None),
            described: DescribedRuns::default(),
        })
    }

    /// Decision about runs by what they say of their axes.
    pub(crate) const fn described(&self) -> &DescribedRuns {
        &self.described
    }

    /// Ids of the axes received instead of the followed ones; empty otherwise.
    pub(crate) fn other_axes(&self) -> Vec<u32> {
        let other = self.other_axes.lock();
        let other = other.unwrap_or_else(PoisonError::into_inner);
        other.as_ref().map_or_else(Vec::new, |(_, ids)| ids.clone())
    }

    fn note_other_axes(&self, at: Instant<Machine>, ids: impl FnOnce() -> Vec<u32>) {
        let other = self.other_axes.lock();
        let mut other = other.unwrap_or_else(PoisonError::into_inner);
        // The interval is checked before the ids are read: they are decoded from the payload.
        if other
            .as_ref()
            .is_none_or(|(before, _)| at - *before >= LOOK)
        {
            *other = Some((at, ids()));
        }
    }

    /// Notes that the source has announced itself or left.
    pub(crate) fn set_alive(&self, alive: bool) {
        self.alive.store(alive, Ordering::Relaxed);
    }

    /// True if the source has announced itself. For display only: health depends on the age of its
    /// frames.
    pub(crate) fn is_alive(&self) -> bool {
        // Relaxed: a status that sees the change a moment later is as good.
        self.alive.load(Ordering::Relaxed)
    }

    /// Age of the source's last good frame; none before the first.
    pub(crate) fn frame_age(&self, now: Instant<Machine>) -> Option<Span> {
        match self.last_frame.load(Ordering::Relaxed) {
            // The clock of the machine starts at its boot: no frame has the least of all numbers.
            i64::MIN => None,
            nanos => Some(now - Instant::from_nanos(nanos)),
        }
    }
}

/// The path of the frames of one key: checked, passed through the faults, into the mailbox.
pub(crate) struct Reception {
    carries_axes: bool,
    reader: Reader,
    faults: Faults,
    inbox: Inbox,
    contact: Arc<Contact>,
    counters: Arc<Counters>,
}

impl Reception {
    /// Creates the path of a subscription; its messages go to `inbox`.
    ///
    /// # Errors
    /// A file that its faults name cannot be used.
    pub(crate) fn new(
        subscription: &Subscription,
        seed: u64,
        inbox: Inbox,
        contact: Arc<Contact>,
        counters: Arc<Counters>,
    ) -> Result<Self, Wrong> {
        let Subscription { channel, far, .. } = *subscription;
        let key = subscription.node.channel_key(channel);
        Ok(Self {
            carries_axes: channel.carries_axes(),
            reader: subscription.reader.clone(),
            faults: Faults::new(&subscription.faults, seed, &key, channel, far)?,
            inbox,
            contact,
            counters,
        })
    }

    /// Takes a message; returns true if it was good. A delayed message is delivered at once, with a
    /// stamp in the future, and held by the node.
    pub(crate) fn take(&mut self, arrival: Instant<Machine>, payload: &[u8]) -> bool {
        // A single good copy is enough: the others may be damaged by injected faults.
        let mut is_good = false;
        let Self {
            carries_axes,
            reader,
            faults,
            inbox,
            contact,
            counters,
        } = self;
        for delay in faults.deliveries(arrival) {
            faults.tamper(arrival, payload, |payload| {
                let arrival = arrival + delay;
                let mut is_of_other_axes = false;
                reader.read(payload, |message| {
                    if let Message::Frame(frame) = message {
                        // Otherwise as if it had not come: nothing may move by it.
                        match contact.described.admission(frame.header.epoch, arrival) {
                            FrameAdmission::Pass => {}
                            FrameAdmission::Wait => return,
                            FrameAdmission::Refuse => {
                                count(&counters.refused);
                                return;
                            }
                        }
                    }
                    is_good |= !matches!(message, Message::Rejected(_) | Message::PlanRefused(_));
                    match message {
                        Message::Frame(_) => {
                            let nanos = arrival.as_nanos();
                            // Dated by the delayed arrival, as the node sees it.
                            contact.last_frame.store(nanos, Ordering::Relaxed);
                            count(&counters.received);
                        }
                        Message::Rejected(reason) if *carries_axes => {
                            is_of_other_axes = *reason == Rejection::AxisMissing;
                            count(&counters.refused);
                        }
                        Message::Rejected(_) | Message::PlanRefused(_) => {
                            count(&counters.exchange_refused);
                        }
                        Message::TimeRequest(_)
                        | Message::TimeResponse(_)
                        | Message::BeaconRequest(_)
                        | Message::BeaconResponse(_)
                        | Message::PlannedPiece(_)
                        | Message::FollowerReport(_) => {}
                    }
                    // Refused messages as well: the node counts them by their reasons.
                    inbox.push(arrival, message);
                });
                if is_of_other_axes {
                    // Outside the reader, which borrows the payload for its own message.
                    contact.note_other_axes(arrival, || reader.axis_ids(payload));
                }
            });
        }
        is_good
    }
}
