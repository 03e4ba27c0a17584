//! Beacons of the timing channel on the wire: `docs/WIRE.md` describes every byte.
//!
//! A beacon is a time request or its response in a datagram of its own beside the transport, stamped by
//! the kernel or the network card instead of by the program. The departure stamp of a datagram is known
//! only after it has left, so each beacon carries the number and the departure of the one before it (as
//! PTP's two-step clocks and NTP's interleaved mode do). The body is written in the cycle; the departures
//! are appended by the sending thread at the last moment ([`BeaconSeal::seal`]).

mod body;
mod hkdf;
mod pair_keys;
mod seal;
mod secret;

pub use body::{
    BEACON_CAPACITY, BeaconLabel, BeaconResponseHeader, encode_beacon_request,
    encode_beacon_response,
};
pub use pair_keys::{InvalidPairKeys, PairKeys, TimingSecret};
pub use seal::{BeaconSeal, Departure};
pub use secret::{BeaconSecret, InvalidSecret, SECRET_LEN};

use coaxle_clock::common_time::CommonReading;
use coaxle_clock::{Instant, Local, Span};
use serde::{Deserialize, Serialize};

/// Place where stamps are taken, the nearest to the wire last.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[serde(rename_all = "kebab-case")]
pub enum Stamps {
    /// Stamps of the program, as it sends and receives.
    #[default]
    Application,
    /// Stamps of the operating system's kernel.
    Kernel,
    /// Stamps of the network card.
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

/// Departure of the previous beacon to the same node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BeaconBefore {
    /// Number of that beacon.
    pub number: u32,
    /// Departure by its stamp, ns: of a request in the requester's clock, of a response since the ideal
    /// start of the responder's cycle 0.
    pub left_ns: i64,
}

/// Version of the beacons between nodes with a common time: with a reading of it in each. Others stay at
/// [`FORMAT_VERSION`](crate::frame::FORMAT_VERSION), byte for byte.
pub const COMMON_TIME_VERSION: u8 = 2;

/// Reading of a common time, as near to the departure of a beacon as the program can take it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CommonStamp {
    /// Own clock at the reading, ns: of a request the requester's clock, of a response since the ideal start of the
    /// responder's cycle 0.
    pub at_ns: i64,
    /// Common time, ns since its epoch: for TAI 1970-01-01.
    pub time_ns: i64,
    /// Greatest error of that against the grandmaster, ns.
    pub bound_ns: u32,
    /// Identity of the clock that the time comes from; of PTP its grandmaster's.
    pub grandmaster: u64,
}

impl CommonStamp {
    /// Returns the reading without the own clock.
    #[must_use]
    pub const fn reading(&self) -> CommonReading {
        CommonReading {
            time: Instant::from_nanos(self.time_ns),
            bound: Span::from_nanos(self.bound_ns as i64),
            grandmaster: self.grandmaster,
        }
    }
}

/// Beacon of a node that follows another one. The responder returns all of it unchanged in its response.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BeaconRequest {
    /// Requester: the CRC-32 of its node name.
    pub requester: u32,
    /// The requester's run.
    pub run: u64,
    /// Sequence number of the beacon in that run to this node.
    pub number: u32,
    /// Departure as the program saw it, ns of the requester's own clock.
    pub requested: i64,
    /// Place where the requester takes its stamps.
    pub stamps: Stamps,
    /// Departure of the previous beacon.
    pub before: Option<BeaconBefore>,
    /// True if the requester has a common time, or is to have one: its beacons have [`COMMON_TIME_VERSION`], and so has the
    /// response.
    pub takes_common_time: bool,
    /// Reading of the common time.
    pub common: Option<CommonStamp>,
}

/// Beacon that responds to a [`BeaconRequest`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BeaconResponse {
    /// The run of the node that responds.
    pub epoch: u64,
    /// The request.
    pub request: BeaconRequest,
    /// Arrival of the request, in the responder's clock since the ideal start of its cycle 0.
    pub received: Span,
    /// Departure of the response as the program saw it, in that clock since that instant.
    pub responded: Span,
    /// Place where the responder takes its stamps.
    pub stamps: Stamps,
    /// Departure of the previous response; its number is that of its request.
    pub before: Option<BeaconBefore>,
    /// Reading of the common time.
    pub common: Option<CommonStamp>,
}

impl BeaconResponse {
    /// Stamps of the two nodes that are further from the wire.
    #[must_use]
    pub fn weakest_stamps(&self) -> Stamps {
        self.stamps.min(self.request.stamps)
    }

    /// Returns the departure of the request, as the requester's program saw it.
    #[must_use]
    pub const fn requested(&self) -> Instant<Local> {
        Instant::from_nanos(self.request.requested)
    }
}
