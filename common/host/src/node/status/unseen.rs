//! Expected nodes that are not visible: when the transport looks for the reason, and when a reason
//! is confirmed.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use coaxle_clock::{Instant, Span};
use coaxle_node::keys::NodeName;
use coaxle_os::machine::Machine;

use crate::network::transport::{InvisibilityReason, Transport};

/// Time a node is missing before the transport looks for the reason. Most nodes appear sooner.
// Six times Zenoh's scouting delay.
const INQUIRY_DELAY: Span = Span::from_secs(3);
/// Interval between two findings that confirm a reason: a node that is about to start has none.
// A node that starts refuses connections until it listens: twice the same is no coincidence.
const CONFIRMATION_INTERVAL: Span = Span::from_secs(3);
/// Interval between checks of a confirmed reason.
// Dialling is a connection with a handshake at the other end: rarely, while nothing changes.
const REVIEW: Span = Span::from_secs(30);

/// State of one node that may be missing.
#[derive(Default)]
pub(crate) struct Search {
    missing_since: Option<Instant<Machine>>,
    asked: Option<Instant<Machine>>,
    found: Option<InvisibilityReason>,
    reason: Option<InvisibilityReason>,
}

impl Search {
    /// True if an inquiry is due. A visible node is not missing any more.
    pub(crate) fn is_due(&mut self, now: Instant<Machine>, is_seen: bool) -> bool {
        if is_seen {
            // All of it: a node that vanishes again may have another reason.
            *self = Self::default();
            return false;
        }
        let since = *self.missing_since.get_or_insert(now);
        let due = match self.asked {
            None => since + INQUIRY_DELAY,
            // A finding that differs from the confirmed one is checked again soon.
            Some(asked) if self.reason.is_some() && self.found == self.reason => asked + REVIEW,
            Some(asked) => asked + CONFIRMATION_INTERVAL,
        };
        now >= due
    }

    /// Notes that an inquiry starts now.
    pub(crate) fn ask(&mut self, now: Instant<Machine>) {
        self.asked = Some(now);
    }

    /// Takes the transport's finding; returns true if it is confirmed by this.
    pub(crate) fn find(&mut self, found: Option<InvisibilityReason>) -> bool {
        if self.asked.is_none() {
            // Visible meanwhile.
            return false;
        }
        // Twice the same, and not what is known already.
        let holds = found == self.found && found != self.reason;
        if holds {
            self.reason.clone_from(&found);
        }
        // Kept also if it differs: the next one is compared with it.
        self.found = found;
        // No reason at all may be confirmed too, and is not worth a line.
        holds && self.reason.is_some()
    }

    /// Confirmed reason why the node is missing.
    pub(crate) const fn reason(&self) -> Option<&InvisibilityReason> {
        self.reason.as_ref()
    }
}

/// An inquiry to the transport on a thread of its own, since it may take seconds.
#[derive(Default)]
pub(crate) struct Inquiry(Option<(usize, Receiver<Option<InvisibilityReason>>)>);

impl Inquiry {
    /// True if an inquiry is under way.
    pub(crate) const fn is_open(&self) -> bool {
        self.0.is_some()
    }

    /// Starts an inquiry about the n-th node.
    pub(crate) fn open(&mut self, n: usize, node: &NodeName, transport: &Arc<dyn Transport>) {
        // A single place: the thread ends even if nobody takes its answer any more.
        let (answer, answered) = sync_channel(1);
        let (node, transport) = (node.clone(), Arc::clone(transport));
        let asking = move || answer.send(transport.invisibility_reason(node.as_str()));
        let thread = std::thread::Builder::new().name("inquiry".to_owned());
        // Without a thread there is no result, and the inquiry is repeated later.
        if thread.spawn(asking).is_ok() {
            self.0 = Some((n, answered));
        }
    }

    /// Result of the finished inquiry, and its node.
    pub(crate) fn take(&mut self) -> Option<(usize, Option<InvisibilityReason>)> {
        let (n, answered) = self.0.as_ref()?;
        let n = *n;
        let found = match answered.try_recv() {
            Ok(found) => found,
            Err(TryRecvError::Empty) => return None,
            // The thread panicked: as if there were no finding.
            Err(TryRecvError::Disconnected) => None,
        };
        self.0 = None;
        Some((n, found))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(secs: i64) -> Instant<Machine> {
        Instant::EPOCH + Span::from_secs(secs)
    }

    fn refused(why: &str) -> Option<InvisibilityReason> {
        Some(InvisibilityReason::Refused(why.to_owned()))
    }

    /// Seconds of the inquiries, and those at which a reason is confirmed, with `found` as the finding.
    fn course(found: impl Fn(i64) -> Option<InvisibilityReason>) -> (Vec<i64>, Vec<i64>) {
        let mut search = Search::default();
        let (mut asked, mut held) = (Vec::new(), Vec::new());
        for second in 0..50 {
            if search.is_due(at(second), false) {
                search.ask(at(second));
                asked.push(second);
                if search.find(found(second)) {
                    held.push(second);
                }
            }
        }
        (asked, held)
    }

    #[test]
    fn a_reason_holds_when_it_is_found_twice() {
        let (asked, held) = course(|_| refused("a"));
        // At 3 and 6 s, then every 30 s once confirmed.
        assert_eq!((asked, held), (vec![3, 6, 36], vec![6]));
        let (asked, held) = course(|at| if at < 8 { None } else { refused("b") });
        assert_eq!(asked[..4], [3, 6, 9, 12]);
        // Two findings of `b`, at 9 and 12 s.
        assert_eq!(held, [12]);
        let (_, held) = course(|at| refused(if at < 10 { "a" } else { "b" }));
        // At 36 s the reason differs, and 3 s later the new one is confirmed.
        assert_eq!(held, [6, 39], "it was looked at again at 36");
    }

    #[test]
    fn a_node_that_is_seen_is_not_missing() {
        let mut search = Search::default();
        assert!(!search.is_due(at(0), false));
        assert!(search.is_due(at(3), false));
        search.ask(at(3));
        assert!(!search.is_due(at(4), true));
        assert!(!search.find(refused("late")));
        assert!(!search.is_due(at(5), false), "patience begins anew");
        assert_eq!(search.reason(), None);
    }
}
