//! The end of a beacon, appended at the last moment, and the reading of beacons that arrive.

use coaxle_clock::Span;
use serde::{Deserialize, Serialize};

use super::body::{BeaconLabel, COMMON_CAPACITY, DepartureSpans, read_request, read_response};
use super::pair_keys::PairKeys;
use super::secret::{BeaconSecret, TAG_LEN};
use super::{BeaconRequest, BeaconResponse, COMMON_TIME_VERSION, CommonStamp, Stamps};
use crate::channel::Channel;
use crate::frame::{FORMAT_VERSION, KeySeal, read, write};
use crate::rejection::Rejection;

/// Departures in a beacon, as spans since the ideal start of its own cycle in the sender's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Departure {
    /// Departure of this beacon, as the program sees it.
    pub left: Span,
    /// Place where the sender takes its stamps.
    pub stamps: Stamps,
    /// Number of the previous beacon to the same node, and its departure by its stamp.
    pub before: Option<(u32, Span)>,
    /// Reading of the common time, with the span to its instant. Left out of beacons without a common time.
    pub common: Option<CommonStamp>,
}

/// Seals the beacons of one node: its key is part of their check sum or of their authentication tag.
#[derive(Clone, Debug)]
pub struct BeaconSeal {
    key: String,
    tag: Tag,
}

/// End of a beacon.
#[derive(Clone, Debug)]
enum Tag {
    CheckSum(KeySeal),
    Authentication(BeaconSecret),
    /// By the key of the pair with the requester, of a node that responds to several.
    ByRequester(PairKeys),
}

const DEPARTURE_CAPACITY: usize = 10 + 1 + 1 + 5 + 10;

#[derive(Serialize, Deserialize)]
struct DepartureFields {
    left: Span,
    stamps: u8,
    before: Option<(u32, Span)>,
}

impl BeaconSeal {
    /// Makes the seal of the beacons under `key`.
    #[must_use]
    pub fn new(key: &str) -> Self {
        Self {
            key: key.to_owned(),
            tag: Tag::CheckSum(KeySeal::new(key)),
        }
    }

    /// Seals with the secret: only its holders can seal, and beacons sealed otherwise are refused.
    #[must_use]
    pub fn authenticated(self, secret: &BeaconSecret) -> Self {
        let tag = Tag::Authentication(secret.clone());
        Self { tag, ..self }
    }

    /// Seals the responses to each requester with the key that the two share, and accepts its requests with that
    /// key only.
    #[must_use]
    pub fn authenticated_by(self, keys: &PairKeys) -> Self {
        let tag = Tag::ByRequester(keys.clone());
        Self { tag, ..self }
    }

    /// Replaces the content of `out` by the complete beacon. Returns false without a valid key of its pair: then
    /// there is none to send.
    pub fn seal(&self, body: &[u8], departure: &Departure, out: &mut Vec<u8>) -> bool {
        let fields = DepartureFields {
            left: departure.left,
            stamps: departure.stamps.code(),
            before: departure.before,
        };
        let mut written = [0; DEPARTURE_CAPACITY];
        let length = write(&fields, &mut written).expect("the buffer holds the longest departure");
        out.clear();
        out.extend_from_slice(body);
        out.extend_from_slice(&written[..length]);
        if body.first() == Some(&COMMON_TIME_VERSION) {
            let mut written = [0; COMMON_CAPACITY];
            let length =
                write(&departure.common, &mut written).expect("it holds the longest reading");
            out.extend_from_slice(&written[..length]);
        }
        let secret = match &self.tag {
            Tag::CheckSum(seal) => {
                seal.append_checksum(out);
                return true;
            }
            Tag::Authentication(secret) => Some(secret),
            Tag::ByRequester(keys) => BeaconLabel::of(Channel::BeaconResponses, body)
                .and_then(|label| keys.of_requester(label.requester)),
        };
        let Some(secret) = secret.filter(|secret| !secret.is_withdrawn()) else {
            out.clear();
            return false;
        };
        let tag = secret.tag(&self.key, out);
        out.extend_from_slice(&tag);
        true
    }

    /// Checks and reads a request. Does not allocate.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies.
    pub fn open_request(&self, payload: &[u8]) -> Result<BeaconRequest, Rejection> {
        let content = self.verify(payload, |content| {
            read_request(content, read_departure).map(drop)
        })?;
        read_request(content, read_departure)
    }

    /// Checks and reads a response, with the id of its responder. Does not allocate.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies.
    pub fn open_response(&self, payload: &[u8]) -> Result<(u32, BeaconResponse), Rejection> {
        let content = self.verify(payload, |content| {
            read_response(content, read_departure).map(drop)
        })?;
        read_response(content, read_departure)
    }

    fn verify<'a>(
        &self,
        payload: &'a [u8],
        walk: impl FnOnce(&[u8]) -> Result<(), Rejection>,
    ) -> Result<&'a [u8], Rejection> {
        let secret = match &self.tag {
            Tag::CheckSum(seal) => {
                return seal.verify_version(payload, COMMON_TIME_VERSION, walk);
            }
            Tag::Authentication(secret) => Some(secret),
            // Requests only: a node hears responses of one other each.
            Tag::ByRequester(keys) => BeaconLabel::of(Channel::BeaconRequests, payload)
                .and_then(|label| keys.of_requester(label.requester)),
        };
        match payload.first() {
            None => Err(Rejection::Truncated),
            Some(&(FORMAT_VERSION | COMMON_TIME_VERSION)) => {
                let split = payload.split_last_chunk::<TAG_LEN>();
                let (content, tag) = split.ok_or(Rejection::Truncated)?;
                match secret {
                    Some(secret) if secret.fits(&self.key, content, tag) => Ok(content),
                    // Of a node without a pair, or of another one than it says.
                    _ => Err(Rejection::WrongChecksum),
                }
            }
            Some(_) => Err(Rejection::WrongVersion),
        }
    }
}

fn read_departure(bytes: &[u8], takes_common_time: bool) -> Result<DepartureSpans, Rejection> {
    let (fields, rest) = read::<DepartureFields>(bytes)?;
    let (common, rest) = match takes_common_time {
        true => read::<Option<CommonStamp>>(rest)?,
        false => (None, rest),
    };
    if !rest.is_empty() {
        return Err(Rejection::TrailingBytes);
    }
    Ok(DepartureSpans {
        left: fields.left,
        stamps: Stamps::of_code(fields.stamps).ok_or(Rejection::Malformed)?,
        before: fields.before,
        common,
    })
}
