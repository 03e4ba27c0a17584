//! What becomes of a beacon on its way in.

use crate::beacon::{BeaconLabel, BeaconSeal, BeaconSecret};
use crate::channel::Channel;
use crate::frame::sender_id;
use crate::keys::NodeName;
use crate::message::Message;
use crate::rejection::Rejection;

/// Turns beacons into messages.
#[derive(Clone, Debug)]
pub struct BeaconIntake {
    seal: BeaconSeal,
    of: Of,
}

#[derive(Clone, Copy, Debug)]
enum Of {
    Requests,
    Responses { sender: u32, requester: u32 },
}

impl BeaconIntake {
    /// The beacons to `node` of those who follow it.
    #[must_use]
    pub fn requests_to(node: &NodeName) -> Self {
        Self {
            seal: BeaconSeal::new(&node.channel_key(Channel::BeaconRequests)),
            of: Of::Requests,
        }
    }

    /// What `node` answers to those of `requester`.
    #[must_use]
    pub fn responses_of(node: &NodeName, requester: &NodeName) -> Self {
        Self {
            seal: BeaconSeal::new(&node.channel_key(Channel::BeaconResponses)),
            of: Of::Responses {
                sender: sender_id(node),
                requester: sender_id(requester),
            },
        }
    }

    /// The same, but only what is authenticated by the secret is a good beacon.
    #[must_use]
    pub fn authenticated(self, secret: &BeaconSecret) -> Self {
        let seal = self.seal.authenticated(secret);
        Self { seal, ..self }
    }

    /// Whether a beacon with this body concerns it, as far as that can be seen from outside.
    #[must_use]
    pub fn concerns(&self, label: &BeaconLabel) -> bool {
        match self.of {
            Of::Requests => true,
            Of::Responses { requester, .. } => requester == label.requester,
        }
    }

    /// What the node is told of a beacon; none of one that is for another node.
    pub(crate) fn message(&self, payload: &[u8]) -> Option<Message<'static>> {
        let read = match self.of {
            Of::Requests => {
                (self.seal.open_request(payload)).map(|it| Some(Message::BeaconRequest(it)))
            }
            Of::Responses { sender, requester } => {
                (self.seal.open_response(payload)).and_then(|(from, response)| {
                    match from == sender {
                        false => Err(Rejection::ForeignSender),
                        true if response.request.requester != requester => Ok(None),
                        true => Ok(Some(Message::BeaconResponse(response))),
                    }
                })
            }
        };
        read.unwrap_or_else(|reason| Some(Message::Rejected(reason)))
    }
}
