//! What becomes of a frame on its way in: checked, reduced to what concerns the node, or refused with
//! a reason.

use coaxle_axis::NcToPlcAxis;

use crate::channel::Channel;
use crate::frame::{KeySeal, Sample, sender_id};
use crate::keys::NodeName;
use crate::message::Message;
pub use crate::rejection::{Rejection, RejectionCounters};

/// Turns the frames of one key into samples of the one axis that is followed.
///
/// It decides and keeps no count: the node that gets the [`Message`] does. It does not allocate.
#[derive(Clone, Debug)]
pub struct Intake {
    seal: KeySeal,
    sender: u32,
    axis_id: u32,
}

impl Intake {
    /// Follows the axis `axis_id` of the node `sender`, whose frames travel under `key`.
    #[must_use]
    pub fn new(key: &str, sender: &NodeName, axis_id: u32) -> Self {
        Self {
            seal: KeySeal::new(key),
            sender: sender_id(sender),
            axis_id,
        }
    }

    /// What the node is told about a frame.
    #[must_use]
    pub fn message(&self, payload: &[u8]) -> Message {
        match self.accept(payload) {
            Ok(sample) => Message::Sample(sample),
            Err(reason) => Message::Rejected(reason),
        }
    }

    /// The followed axis from a frame. Of several axes with the same id the first counts.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies.
    pub fn accept(&self, payload: &[u8]) -> Result<Sample, Rejection> {
        let mut found: Option<NcToPlcAxis> = None;
        let header = self.seal.open(payload, |axis| {
            if axis.axis_id == self.axis_id && found.is_none() {
                found = Some(*axis);
            }
        })?;
        if header.sender != self.sender {
            return Err(Rejection::ForeignSender);
        }
        let axis = found.ok_or(Rejection::AxisMissing)?;
        if axis.implausible_field().is_some() {
            return Err(Rejection::Implausible);
        }
        Ok(Sample { header, axis })
    }
}

/// Turns the frames of one key into messages.
#[derive(Clone, Debug)]
pub enum Reader {
    /// Axes: a sample per frame.
    Axis(Intake),
    /// What others ask this node.
    Questions(KeySeal),
    /// What the followed node answers.
    Answers(AnswerIntake),
}

/// Picks a node's answers out of all that its counterpart gives.
#[derive(Clone, Debug)]
pub struct AnswerIntake {
    seal: KeySeal,
    sender: u32,
    asker: u32,
}

impl Reader {
    /// Reads what `node` is asked.
    #[must_use]
    pub fn questions_to(node: &NodeName) -> Self {
        Self::Questions(KeySeal::new(&node.channel_key(Channel::Questions)))
    }

    /// Reads what `node` answers to `asker`.
    #[must_use]
    pub fn answers_of(node: &NodeName, asker: &NodeName) -> Self {
        Self::Answers(AnswerIntake {
            seal: KeySeal::new(&node.channel_key(Channel::Answers)),
            sender: sender_id(node),
            asker: sender_id(asker),
        })
    }

    /// What the node is told about a frame: one message, but for answers, which may be several or
    /// none. Does not allocate.
    pub fn read(&self, payload: &[u8], mut each: impl FnMut(Message)) {
        match self {
            Self::Axis(intake) => each(intake.message(payload)),
            Self::Questions(seal) => each(match seal.open_question(payload) {
                Ok(question) => Message::Question(question),
                Err(reason) => Message::Rejected(reason),
            }),
            Self::Answers(intake) => {
                let AnswerIntake {
                    seal,
                    sender,
                    asker,
                } = intake;
                let read = seal.open_answers(payload, *sender, *asker, |answer| {
                    each(Message::Answer(*answer));
                });
                if let Err(reason) = read {
                    each(Message::Rejected(reason));
                }
            }
        }
    }
}

impl From<Intake> for Reader {
    fn from(intake: Intake) -> Self {
        Self::Axis(intake)
    }
}
