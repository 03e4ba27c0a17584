//! Nodes that ought to be there and are not to be seen: when the transport is asked for the reason, and when a reason
//! holds.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use coaxle_clock::{Instant, Span};
use coaxle_node::keys::NodeName;
use coaxle_os::machine::Machine;

use crate::transport::{Transport, Unseen};

/// A node that is missing for so long is asked for. Most are there sooner.
const PATIENCE: Span = Span::from_secs(3);
/// A reason holds once it was found twice, so far apart: a node that is just about to start has none.
const AGAIN: Span = Span::from_secs(3);
/// How often one that holds is looked at again.
const REVIEW: Span = Span::from_secs(30);

/// What is known of one node that may be missing.
#[derive(Default)]
pub(crate) struct Search {
    missing_since: Option<Instant<Machine>>,
    asked: Option<Instant<Machine>>,
    found: Option<Unseen>,
    reason: Option<Unseen>,
}

impl Search {
    /// Whether the transport is to be asked now. A node that is seen is not missing any more.
    pub(crate) fn is_due(&mut self, now: Instant<Machine>, is_seen: bool) -> bool {
        if is_seen {
            *self = Self::default();
            return false;
        }
        let since = *self.missing_since.get_or_insert(now);
        let due = match self.asked {
            None => since + PATIENCE,
            Some(asked) if self.reason.is_some() && self.found == self.reason => asked + REVIEW,
            Some(asked) => asked + AGAIN,
        };
        now >= due
    }

    /// The transport is asked now.
    pub(crate) fn ask(&mut self, now: Instant<Machine>) {
        self.asked = Some(now);
    }

    /// What the transport found; true if that holds from now on.
    pub(crate) fn find(&mut self, found: Option<Unseen>) -> bool {
        if self.asked.is_none() {
            // It was seen meanwhile.
            return false;
        }
        let holds = found == self.found && found != self.reason;
        if holds {
            self.reason.clone_from(&found);
        }
        self.found = found;
        holds && self.reason.is_some()
    }

    /// Why it is missing, once that holds.
    pub(crate) const fn reason(&self) -> Option<&Unseen> {
        self.reason.as_ref()
    }
}

/// Asks the transport on a thread of its own: that may take seconds.
#[derive(Default)]
pub(crate) struct Inquiry(Option<(usize, Receiver<Option<Unseen>>)>);

impl Inquiry {
    /// Whether one is under way.
    pub(crate) const fn is_open(&self) -> bool {
        self.0.is_some()
    }

    /// Asks for the n-th node.
    pub(crate) fn open(&mut self, n: usize, node: &NodeName, transport: &Arc<dyn Transport>) {
        let (answer, answered) = sync_channel(1);
        let (node, transport) = (node.clone(), Arc::clone(transport));
        let asking = move || answer.send(transport.why_unseen(node.as_str()));
        let thread = std::thread::Builder::new().name("inquiry".to_owned());
        // Without a thread there is no answer, and the next one is asked for later.
        if thread.spawn(asking).is_ok() {
            self.0 = Some((n, answered));
        }
    }

    /// What came of the one that is over, and of which node.
    pub(crate) fn take(&mut self) -> Option<(usize, Option<Unseen>)> {
        let (n, answered) = self.0.as_ref()?;
        let n = *n;
        let found = match answered.try_recv() {
            Ok(found) => found,
            Err(TryRecvError::Empty) => return None,
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

    fn refused(why: &str) -> Option<Unseen> {
        Some(Unseen::Refused(why.to_owned()))
    }

    /// Seconds at which it asks, and at which a reason begins to hold, if `find` says what is found.
    fn course(found: impl Fn(i64) -> Option<Unseen>) -> (Vec<i64>, Vec<i64>) {
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
        assert_eq!((asked, held), (vec![3, 6, 36], vec![6]));
        let (asked, held) = course(|at| if at < 8 { None } else { refused("b") });
        assert_eq!(asked[..4], [3, 6, 9, 12]);
        assert_eq!(held, [12]);
        let (_, held) = course(|at| refused(if at < 10 { "a" } else { "b" }));
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
