//! Intake of beacons: checked, and refused or turned into messages.

use crate::beacon::{BeaconLabel, BeaconSeal, BeaconSecret, PairKeys};
use crate::channel::Channel;
use crate::frame::sender_id;
use crate::keys::NodeName;
use crate::message::Message;
use crate::rejection::Rejection;

/// Turns beacons into messages.
#[derive(Clone, Debug)]
pub struct BeaconIntake {
    seal: BeaconSeal,
    accepts: Accepts,
}

#[derive(Clone, Copy, Debug)]
enum Accepts {
    Requests,
    Responses { sender: u32, requester: u32 },
}

impl BeaconIntake {
    /// Takes the beacons to `node` from the nodes that follow it.
    #[must_use]
    pub fn requests_to(node: &NodeName) -> Self {
        Self {
            seal: BeaconSeal::new(&node.channel_key(Channel::BeaconRequests)),
            accepts: Accepts::Requests,
        }
    }

    /// Takes the responses of `node` to the beacons of `requester`.
    #[must_use]
    pub fn responses_of(node: &NodeName, requester: &NodeName) -> Self {
        Self {
            seal: BeaconSeal::new(&node.channel_key(Channel::BeaconResponses)),
            accepts: Accepts::Responses {
                sender: sender_id(node),
                requester: sender_id(requester),
            },
        }
    }

    /// Accepts only beacons that are authenticated by the secret.
    #[must_use]
    pub fn authenticated(self, secret: &BeaconSecret) -> Self {
        let seal = self.seal.authenticated(secret);
        Self { seal, ..self }
    }

    /// Accepts only requests that are authenticated by the key of the pair with their requester.
    #[must_use]
    pub fn authenticated_by(self, keys: &PairKeys) -> Self {
        let seal = self.seal.authenticated_by(keys);
        Self { seal, ..self }
    }

    /// True if a beacon with this body is for this intake, as far as that can be seen without the key.
    #[must_use]
    pub fn concerns(&self, label: &BeaconLabel) -> bool {
        match self.accepts {
            Accepts::Requests => true,
            Accepts::Responses { requester, .. } => requester == label.requester,
        }
    }

    /// Returns the message to the node about a beacon; none if the beacon is for another node.
    pub(crate) fn message(&self, payload: &[u8]) -> Option<Message<'static>> {
        let read = match self.accepts {
            Accepts::Requests => {
                (self.seal.open_request(payload)).map(|it| Some(Message::BeaconRequest(it)))
            }
            Accepts::Responses { sender, requester } => (self.seal.open_response(payload))
                .and_then(|(from, response)| match from == sender {
                    false => Err(Rejection::ForeignSender),
                    true if response.request.requester != requester => Ok(None),
                    true => Ok(Some(Message::BeaconResponse(response))),
                }),
        };
        read.unwrap_or_else(|reason| Some(Message::Rejected(reason)))
    }
}
