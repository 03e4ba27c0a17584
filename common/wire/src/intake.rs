//! Intake of frames: checked, reduced to what concerns the node, or refused with a reason.

use crate::beacon::BeaconLabel;
use crate::beacon_intake::BeaconIntake;
use crate::channel::Channel;
use crate::followers::ReportIntake;
use crate::frame::{AxisSample, Frame, KeySeal, sender_id};
use crate::keys::NodeName;
use crate::message::Message;
use crate::plan::PlanIntake;
pub use crate::rejection::{Rejection, RejectionCounters};

/// Takes the axes that are followed out of the frames of one key.
///
/// Decides and keeps no counts: the node that gets the [`Message`] does. Does not allocate.
#[derive(Clone, Debug)]
pub struct Intake {
    seal: KeySeal,
    sender: u32,
    /// The ids that are followed, in order, with their places among the samples.
    places: Box<[(u32, usize)]>,
    /// True for each axis that has come up in the newest frame, valid or not.
    seen: Box<[bool]>,
    /// Samples of the newest frame, in the order of the requested ids.
    samples: Box<[Option<AxisSample>]>,
}

impl Intake {
    /// Follows the axes `ids` of the node `sender`, whose frames travel under `key`.
    #[must_use]
    pub fn new(key: &str, sender: &NodeName, ids: &[u32]) -> Self {
        let mut places: Box<[_]> = (ids.iter().copied()).zip(0..).collect();
        places.sort_unstable();
        Self {
            seal: KeySeal::new(key),
            sender: sender_id(sender),
            places,
            seen: vec![false; ids.len()].into(),
            samples: vec![None; ids.len()].into(),
        }
    }

    /// Returns the message to the node about a frame.
    #[must_use]
    pub fn message(&mut self, payload: &[u8]) -> Message<'_> {
        match self.accept(payload) {
            Ok(frame) => Message::Frame(frame),
            Err(reason) => Message::Rejected(reason),
        }
    }

    /// Returns the followed axes of a frame. Of several axes with the same id the first counts. A frame
    /// is accepted as long as one of its followed axes is valid.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies.
    pub fn accept(&mut self, payload: &[u8]) -> Result<Frame<'_>, Rejection> {
        let Self {
            seal,
            sender,
            places,
            seen,
            samples,
        } = self;
        samples.fill(None);
        seen.fill(false);
        let (mut found, mut good) = (0, 0);
        let header = seal.open(payload, |axis| {
            let Ok(at) = places.binary_search_by_key(&axis.axis_id, |(id, _)| *id) else {
                return;
            };
            let place = places[at].1;
            if !std::mem::replace(&mut seen[place], true) {
                found += 1;
                let plausible = axis.implausible_field().is_none();
                good += usize::from(plausible);
                samples[place] = plausible.then(|| AxisSample::from(axis));
            }
        })?;
        if header.sender != *sender {
            return Err(Rejection::ForeignSender);
        }
        if found == 0 {
            return Err(Rejection::AxisMissing);
        }
        if good == 0 {
            return Err(Rejection::Implausible);
        }
        Ok(Frame {
            header,
            axes: samples,
        })
    }

    /// Returns the ids of all axes of a frame, in its order, for a log message when another axis is
    /// followed. Allocates.
    #[must_use]
    pub fn axis_ids(&self, payload: &[u8]) -> Vec<u32> {
        let mut ids = Vec::new();
        // Ids read before a frame turned out to be invalid are discarded.
        match self.seal.open(payload, |axis| ids.push(axis.axis_id)) {
            Ok(_) => ids,
            Err(_) => Vec::new(),
        }
    }
}

/// Turns the frames of one key into messages.
#[derive(Clone, Debug)]
pub enum Reader {
    /// Axes: a message per frame.
    Axes(Intake),
    /// Time requests of other nodes to this node.
    TimeRequests(KeySeal),
    /// Time responses of the followed node.
    TimeResponses(TimeResponseIntake),
    /// Beacons of the timing channel.
    Beacons(BeaconIntake),
    /// Plans of axes.
    Plans(PlanIntake),
    /// Reports of a follower.
    Reports(ReportIntake),
}

/// Picks a node's responses out of all responses of its counterpart.
#[derive(Clone, Debug)]
pub struct TimeResponseIntake {
    seal: KeySeal,
    sender: u32,
    requester: u32,
}

impl Reader {
    /// Reads the time requests to `node`.
    #[must_use]
    pub fn time_requests_to(node: &NodeName) -> Self {
        Self::TimeRequests(KeySeal::new(&node.channel_key(Channel::TimeRequests)))
    }

    /// Reads the responses of `node` to `requester`.
    #[must_use]
    pub fn time_responses_of(node: &NodeName, requester: &NodeName) -> Self {
        Self::TimeResponses(TimeResponseIntake {
            seal: KeySeal::new(&node.channel_key(Channel::TimeResponses)),
            sender: sender_id(node),
            requester: sender_id(requester),
        })
    }

    /// Returns the number of axes it takes of each frame.
    #[must_use]
    pub fn axes(&self) -> usize {
        match self {
            Self::Axes(intake) => intake.samples.len(),
            Self::TimeRequests(_)
            | Self::TimeResponses(_)
            | Self::Beacons(_)
            | Self::Plans(_)
            | Self::Reports(_) => 0,
        }
    }

    /// Returns the ids of all axes of a frame; none for other messages. Allocates.
    #[must_use]
    pub fn axis_ids(&self, payload: &[u8]) -> Vec<u32> {
        match self {
            Self::Axes(intake) => intake.axis_ids(payload),
            Self::TimeRequests(_)
            | Self::TimeResponses(_)
            | Self::Beacons(_)
            | Self::Plans(_)
            | Self::Reports(_) => Vec::new(),
        }
    }

    /// True if a beacon with this label is for it, as far as that can be seen from outside; true for all
    /// others.
    #[must_use]
    pub fn concerns(&self, label: &BeaconLabel) -> bool {
        match self {
            Self::Beacons(intake) => intake.concerns(label),
            Self::Axes(_)
            | Self::TimeRequests(_)
            | Self::TimeResponses(_)
            | Self::Plans(_)
            | Self::Reports(_) => true,
        }
    }

    /// Passes on the messages to the node about a frame: one, but for responses, plans and reports, which may be several
    /// or none. Does not allocate.
    pub fn read(&mut self, payload: &[u8], mut each: impl FnMut(&Message<'_>)) {
        match self {
            Self::Axes(intake) => each(&intake.message(payload)),
            Self::TimeRequests(seal) => each(&match seal.open_time_request(payload) {
                Ok(request) => Message::TimeRequest(request),
                Err(reason) => Message::Rejected(reason),
            }),
            Self::TimeResponses(intake) => {
                let TimeResponseIntake {
                    seal,
                    sender,
                    requester,
                } = intake;
                let read = seal.open_time_responses(payload, *sender, *requester, |response| {
                    each(&Message::TimeResponse(*response));
                });
                if let Err(reason) = read {
                    each(&Message::Rejected(reason));
                }
            }
            Self::Plans(intake) => {
                if let Err(reason) = intake.read(payload, &mut each) {
                    each(&Message::Rejected(reason));
                }
            }
            Self::Reports(intake) => {
                if let Err(reason) = intake.read(payload, &mut each) {
                    each(&Message::Rejected(reason));
                }
            }
            Self::Beacons(intake) => {
                if let Some(message) = intake.message(payload) {
                    each(&message);
                }
            }
        }
    }
}

impl From<BeaconIntake> for Reader {
    fn from(intake: BeaconIntake) -> Self {
        Self::Beacons(intake)
    }
}

impl From<PlanIntake> for Reader {
    fn from(intake: PlanIntake) -> Self {
        Self::Plans(intake)
    }
}

impl From<ReportIntake> for Reader {
    fn from(intake: ReportIntake) -> Self {
        Self::Reports(intake)
    }
}

impl From<Intake> for Reader {
    fn from(intake: Intake) -> Self {
        Self::Axes(intake)
    }
}
