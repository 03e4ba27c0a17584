//! Beacons of the timing channel on the wire: `docs/WIRE.md` describes every byte.
//!
//! A beacon is a time request or its response, but in a datagram of its own beside the transport, stamped by the
//! kernel or the network card instead of by the program. When a datagram left is known only once it has left, so
//! each beacon tells of the one before it (as PTP's two-step clocks and NTP's interleaved mode do): its number, and
//! when that left. The body is written in the cycle, what is known of departures by whoever sends it, at the last
//! moment ([`BeaconSeal::seal`]).

mod body;
mod seal;
mod secret;

pub use body::{
    BEACON_CAPACITY, BeaconLabel, BeaconResponseHeader, encode_beacon_request,
    encode_beacon_response,
};
pub use seal::{BeaconSeal, Departure};
pub use secret::{BeaconSecret, NoSecret, SECRET_LEN};

use coaxle_clock::{Instant, Local, Span};
use serde::{Deserialize, Serialize};

/// Where stamps were taken, the nearest to the wire last.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[serde(rename_all = "kebab-case")]
pub enum Stamps {
    /// By the program, as it sends and receives.
    #[default]
    Application,
    /// By the operating system's kernel.
    Kernel,
    /// By the network card.
    Hardware,
}

impl Stamps {
    pub(crate) const fn code(self) -> u8 {
        self as u8
    }

    pub(crate) const fn of_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::Application),
            1 => Some(Self::Kernel),
            2 => Some(Self::Hardware),
            _ => None,
        }
    }
}

/// What a beacon says of the one before it to the same node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BeaconBefore {
    /// Its number.
    pub number: u32,
    /// When it left by its stamp, ns: of a request in the requester's clock, of a response since the ideal start of the
    /// responder's cycle 0.
    pub left_ns: i64,
}

/// A beacon of a node that follows another one. That one keeps all of it as it is, for the response.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BeaconRequest {
    /// Who asks: the CRC-32 of its node name.
    pub requester: u32,
    /// The requester's run.
    pub run: u64,
    /// Which beacon of that run to this node.
    pub number: u32,
    /// When it left as the program saw it, ns of the requester's own clock.
    pub requested: i64,
    /// Where the requester takes its stamps.
    pub stamps: Stamps,
    /// When the one before left.
    pub before: Option<BeaconBefore>,
}

/// The beacon that answers it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BeaconResponse {
    /// The run of the node that responds.
    pub epoch: u64,
    /// The request.
    pub request: BeaconRequest,
    /// When the request arrived, in the responder's clock since the ideal start of its cycle 0.
    pub received: Span,
    /// When the response left as the program saw it, likewise.
    pub responded: Span,
    /// Where the responder takes its stamps.
    pub stamps: Stamps,
    /// When the response before this one left; its number is that of the request it answered.
    pub before: Option<BeaconBefore>,
}

impl BeaconResponse {
    /// Where the stamps of both nodes come from: those that are further from the wire.
    #[must_use]
    pub fn weakest_stamps(&self) -> Stamps {
        self.stamps.min(self.request.stamps)
    }

    /// When the request left, as the requester's program saw it.
    #[must_use]
    pub const fn requested(&self) -> Instant<Local> {
        Instant::from_nanos(self.request.requested)
    }
}
