//! Events of links for the program around Zenoh: what was refused, and which link was ended.

use std::sync::{Mutex, PoisonError};

/// Target of log lines that are for the operator of a node.
pub(crate) const LOG: &str = "coaxle_link";

/// An event of a link.
#[derive(Clone, Copy, Debug)]
pub struct LinkEvent<'a> {
    /// The other end: its name if its certificate is known, or else its address.
    pub client: &'a str,
    /// Kind of the event.
    pub kind: LinkEventKind,
    /// Reason of the event.
    pub reason: &'a str,
}

/// Kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkEventKind {
    /// A handshake was refused.
    Refused,
    /// An established link was ended.
    Ended,
}

type Listener = Box<dyn Fn(LinkEvent<'_>) + Send>;

/// Listeners of this process.
static LISTENERS: Mutex<Vec<Listener>> = Mutex::new(Vec::new());

/// Calls `listener` with each event of a link of this process from now on. It runs on threads that accept
/// connections, and must not wait.
pub fn on_link_event(listener: impl Fn(LinkEvent<'_>) + Send + 'static) {
    let mut listeners = LISTENERS.lock().unwrap_or_else(PoisonError::into_inner);
    listeners.push(Box::new(listener));
}

/// Reports an event.
pub(crate) fn report(client: &str, kind: LinkEventKind, reason: &str) {
    let listeners = LISTENERS.lock().unwrap_or_else(PoisonError::into_inner);
    let event = LinkEvent {
        client,
        kind,
        reason,
    };
    listeners.iter().for_each(|listener| listener(event));
}
