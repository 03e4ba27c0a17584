//! Health of a node with respect to the network.

use std::fmt;

use coaxle_clock::Span;

/// Greatest age of a frame that counts as present: five cycles of the slowest sender.
const FRESH: Span = Span::from_millis(500);

/// A node's health as far as the host can judge it. The node's own judgement is added by its
/// recorder and shows only while this is [`Health::Ok`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Health {
    /// The counterpart is present: frames arrive, or at least one follower receives the frames sent.
    Ok,
    /// The counterpart is alive, but no good frame arrived for half a second.
    NoData,
    /// No counterpart is present.
    Waiting,
    /// A node that this one follows refuses it, or is refused.
    Refused,
    /// The config states another unit or modulo period of an axis than the node that publishes it.
    AxisContradicts,
    /// Another node of the same name is announced.
    NameTaken,
    /// All is well, while somebody floods the node with connects that fail.
    ConnectionFlood,
    /// The node has ended.
    Stopped,
}

impl Health {
    /// The word in the status.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::NoData => "no-data",
            Self::Waiting => "waiting",
            Self::Refused => "refused",
            Self::AxisContradicts => "axis-contradicts",
            Self::NameTaken => "name-taken",
            Self::ConnectionFlood => "connection-flood",
            Self::Stopped => "stopped",
        }
    }
}

impl fmt::Display for Health {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// Evidence from the network.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Evidence {
    /// Evidence about a followed source.
    Source {
        /// True if its liveliness token is present.
        alive: bool,
        /// Age of its last good frame.
        age: Option<Span>,
    },
    /// Evidence about the followers of this node.
    Followers {
        /// True if there is at least one.
        any: bool,
    },
}

/// Judges by arriving frames: a session opens and a `put` succeeds even without a counterpart.
pub(crate) fn judge(evidence: Evidence) -> Health {
    match evidence {
        // Frames before tokens: a token may be lost or refused while frames arrive.
        Evidence::Source { age: Some(age), .. } if age <= FRESH => Health::Ok,
        Evidence::Source { alive: true, .. } => Health::NoData,
        // Without a token and without frames the node is absent, or not to be seen.
        Evidence::Source { alive: false, .. } => Health::Waiting,
        Evidence::Followers { any: true } => Health::Ok,
        Evidence::Followers { any: false } => Health::Waiting,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_follower_is_healthy_only_while_good_frames_come() {
        let source = |alive, age| judge(Evidence::Source { alive, age });
        let (fresh, old) = (Some(Span::from_millis(3)), Some(Span::from_secs(2)));
        assert_eq!(source(true, fresh), Health::Ok);
        assert_eq!(
            source(false, fresh),
            Health::Ok,
            "frames count, tokens do not"
        );
        assert_eq!(source(true, old), Health::NoData);
        assert_eq!(source(true, None), Health::NoData);
        assert_eq!(source(false, old), Health::Waiting);
        assert_eq!(source(false, None), Health::Waiting);
    }

    #[test]
    fn a_sender_is_healthy_only_with_a_follower() {
        assert_eq!(judge(Evidence::Followers { any: true }), Health::Ok);
        assert_eq!(judge(Evidence::Followers { any: false }), Health::Waiting);
    }
}
