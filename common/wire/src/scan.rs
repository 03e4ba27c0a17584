//! Inputs of a node before a scan, as bytes: replaying them gives the same outputs.

mod beacons;
#[cfg(test)]
mod tests;

use coaxle_axis::StateWord;
use coaxle_axis::motion_plan::PlanFault;
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::{CycleIndex, CycleTime, Instant, Local, Span};
use coaxle_curve::profile::Kinematics;
use serde::{Deserialize, Serialize};

use crate::beacon::CommonStamp;
use crate::circle_change::{CircleChange, CircleOnWire};
use crate::command::CommandOrder;
use crate::exchange::TimeRequest;
use crate::followers::StateBody;
use crate::frame::{AxisSample, Frame, FrameHeader};
use crate::message::{KeptMessage, Message, ReceivedReport};
use crate::plan::PlannedPieceOnWire;
use crate::present_after::PresentAfter;
use crate::rejection::Rejection;
use beacons::{RequestOnWire, ResponseOnWire};

/// The first byte of a scan.
pub const SCAN_VERSION: u8 = 1;
/// The first byte of a scan that ends with changes of circles. Others are written as before, for older tools.
const VERSION_WITH_CIRCLES: u8 = 2;

/// Reasons by their number in a scan: new ones come last, so that older scans keep theirs.
const REJECTIONS: [Rejection; Rejection::ALL.len()] = [
    Rejection::WrongVersion,
    Rejection::Truncated,
    Rejection::WrongChecksum,
    Rejection::Malformed,
    Rejection::TrailingBytes,
    Rejection::CycleTimeOutOfRange,
    Rejection::ForeignSender,
    Rejection::AxisMissing,
    Rejection::Implausible,
    Rejection::PresentAfterOutOfRange,
];

/// Scan with all inputs of the node before it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeScan {
    /// The messages, one after the other.
    pub received: Vec<ReceivedMessage>,
    /// Changes of the circles across nodes after them.
    pub circles: Vec<CircleChange>,
    /// The orders after those.
    pub orders: Vec<CommandOrder>,
    /// Real start of the scan, in the node's own clock.
    pub now: Instant<Local>,
}

/// Message that was received.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceivedMessage {
    /// Arrival, in the node's own clock.
    pub at: Instant<Local>,
    /// Number of the subscription.
    pub subscription: usize,
    /// The message.
    pub message: KeptMessage,
}

/// Error of bytes that are not a scan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidScan {
    /// Bytes of another format or another version.
    #[error("received version {received:?}, expected {SCAN_VERSION} or {VERSION_WITH_CIRCLES}")]
    WrongVersion {
        /// First byte, if there is one.
        received: Option<u8>,
    },
    /// Bytes that end too soon, go on too long, or hold an impossible value.
    #[error("received bytes that are no scan of their version")]
    Malformed,
    /// Order that no node takes.
    #[error("an order: {0}")]
    Order(String),
}

impl NodeScan {
    /// Writes the scan as bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let on_wire = ScanOnWire {
            received: self.received.iter().map(ReceivedOnWire::from).collect(),
            orders: self.orders.iter().map(CommandOrder::to_json).collect(),
            now: self.now.as_nanos(),
        };
        if self.circles.is_empty() {
            return bytes(SCAN_VERSION, &on_wire);
        }
        let circles: Vec<_> = self.circles.iter().map(CircleOnWire::from).collect();
        bytes(VERSION_WITH_CIRCLES, &(on_wire, circles))
    }

    /// Reads the scan from bytes.
    ///
    /// # Errors
    /// [`InvalidScan`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, InvalidScan> {
        let (on_wire, circles) = match bytes {
            [SCAN_VERSION, rest @ ..] => (whole::<ScanOnWire>(rest)?, Vec::new()),
            [VERSION_WITH_CIRCLES, rest @ ..] => whole::<(ScanOnWire, Vec<CircleOnWire>)>(rest)?,
            other => {
                let received = other.first().copied();
                return Err(InvalidScan::WrongVersion { received });
            }
        };
        let circles = circles.iter().map(CircleOnWire::change);
        let orders = on_wire.orders.iter().map(|json| {
            let order = CommandOrder::from_json(json.as_bytes());
            order.map_err(|wrong| InvalidScan::Order(wrong.to_string()))
        });
        let received = on_wire.received.into_iter().map(ReceivedMessage::try_from);
        Ok(Self {
            received: received.collect::<Result<_, _>>()?,
            circles: (circles.collect::<Option<_>>()).ok_or(InvalidScan::Malformed)?,
            orders: orders.collect::<Result<_, _>>()?,
            now: Instant::from_nanos(on_wire.now),
        })
    }
}

fn bytes(version: u8, content: &impl Serialize) -> Vec<u8> {
    postcard::to_extend(content, vec![version]).expect("a vector takes whatever comes")
}

/// Reads a value that takes all of the bytes.
fn whole<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, InvalidScan> {
    match postcard::take_from_bytes(bytes) {
        Ok((value, [])) => Ok(value),
        _ => Err(InvalidScan::Malformed),
    }
}

#[derive(Serialize, Deserialize)]
struct ScanOnWire {
    received: Vec<ReceivedOnWire>,
    orders: Vec<String>,
    now: i64,
}

#[derive(Serialize, Deserialize)]
struct ReceivedOnWire {
    at: i64,
    subscription: u32,
    message: MessageOnWire,
}

#[derive(Serialize, Deserialize)]
enum MessageOnWire {
    Frame(FrameOnWire),
    TimeRequest {
        requester: u32,
        run: u64,
        number: u32,
        requested: i64,
    },
    TimeResponse {
        run: u64,
        number: u32,
        requested: i64,
        epoch: u64,
        received: i64,
        responded: i64,
    },
    /// Index in [`REJECTIONS`].
    Rejected(u8),
    BeaconRequest(RequestOnWire),
    BeaconResponse(ResponseOnWire),
    /// Presentation delay, ns, and the frame.
    PresentedFrame(u32, FrameOnWire),
    PlannedPiece(PlannedPieceOnWire),
    /// Index in [`PlanFault::ALL`].
    PlanRefused(u8),
    FollowerReport {
        epoch: u64,
        count: u64,
        run: u64,
        axis_id: u32,
        state: StateBody,
    },
    /// Request of a node with a common time, and its reading.
    CommonBeaconRequest(RequestOnWire, Option<CommonStamp>),
    /// Response of a node with a common time, and the readings of the requester and of the responder.
    CommonBeaconResponse(ResponseOnWire, [Option<CommonStamp>; 2]),
}

#[derive(Serialize, Deserialize)]
struct FrameOnWire {
    sender: u32,
    epoch: u64,
    index: u16,
    count: u64,
    cycle_time: i64,
    send_stamp: Option<i64>,
    axes: Vec<Option<AxisOnWire>>,
}

#[derive(Serialize, Deserialize)]
struct AxisOnWire {
    position: f64,
    velocity: f64,
    acceleration: f64,
    state_word: u32,
    error_code: u32,
}

impl From<&ReceivedMessage> for ReceivedOnWire {
    fn from(received: &ReceivedMessage) -> Self {
        Self {
            at: received.at.as_nanos(),
            subscription: u32::try_from(received.subscription).unwrap_or(u32::MAX),
            message: received.message.get().into(),
        }
    }
}

impl TryFrom<ReceivedOnWire> for ReceivedMessage {
    type Error = InvalidScan;

    fn try_from(received: ReceivedOnWire) -> Result<Self, InvalidScan> {
        Ok(Self {
            at: Instant::from_nanos(received.at),
            subscription: received.subscription as usize,
            message: received.message.kept()?,
        })
    }
}

impl From<Message<'_>> for MessageOnWire {
    fn from(message: Message<'_>) -> Self {
        match message {
            Message::Frame(frame) => match frame.header.present_after {
                None => Self::Frame(frame.into()),
                Some(delay) => Self::PresentedFrame(delay.nanos(), frame.into()),
            },
            Message::TimeRequest(request) => Self::TimeRequest {
                requester: request.requester,
                run: request.run,
                number: request.number,
                requested: request.requested,
            },
            Message::TimeResponse(response) => Self::TimeResponse {
                run: response.run,
                number: response.number,
                requested: response.requested.as_nanos(),
                epoch: response.epoch,
                received: response.received.as_nanos(),
                responded: response.responded.as_nanos(),
            },
            Message::BeaconRequest(request) => match request.takes_common_time {
                false => Self::BeaconRequest((&request).into()),
                true => Self::CommonBeaconRequest((&request).into(), request.common),
            },
            Message::BeaconResponse(response) => match response.request.takes_common_time {
                false => Self::BeaconResponse((&response).into()),
                true => {
                    let common = [response.request.common, response.common];
                    Self::CommonBeaconResponse((&response).into(), common)
                }
            },
            Message::PlannedPiece(piece) => Self::PlannedPiece(piece.into()),
            Message::PlanRefused(fault) => Self::PlanRefused(fault as u8),
            Message::FollowerReport(report) => Self::FollowerReport {
                epoch: report.epoch,
                count: report.count,
                run: report.run,
                axis_id: report.axis_id,
                state: StateBody::from(&report.state),
            },
            Message::Rejected(reason) => {
                let place = REJECTIONS.iter().position(|other| *other == reason);
                Self::Rejected(place.map_or(u8::MAX, |place| place as u8))
            }
        }
    }
}

impl MessageOnWire {
    fn kept(self) -> Result<KeptMessage, InvalidScan> {
        let message = match self {
            Self::Frame(frame) => return frame.kept(None),
            Self::PresentedFrame(nanos, frame) => {
                let delay = PresentAfter::new(Span::from_nanos(nanos.into()));
                return frame.kept(Some(delay.ok_or(InvalidScan::Malformed)?));
            }
            Self::TimeRequest {
                requester,
                run,
                number,
                requested,
            } => Message::TimeRequest(TimeRequest {
                requester,
                run,
                number,
                requested,
            }),
            Self::TimeResponse {
                run,
                number,
                requested,
                epoch,
                received,
                responded,
            } => Message::TimeResponse(TimeResponse {
                run,
                number,
                requested: Instant::from_nanos(requested),
                epoch,
                received: Span::from_nanos(received),
                responded: Span::from_nanos(responded),
            }),
            Self::BeaconRequest(request) => Message::BeaconRequest(request.with(None)),
            Self::BeaconResponse(response) => Message::BeaconResponse(response.with(None)),
            Self::CommonBeaconRequest(request, common) => {
                Message::BeaconRequest(request.with(Some(common)))
            }
            Self::CommonBeaconResponse(response, common) => {
                Message::BeaconResponse(response.with(Some(common)))
            }
            Self::PlannedPiece(piece) => Message::PlannedPiece(piece.into()),
            Self::PlanRefused(place) => {
                let fault = PlanFault::ALL.get(usize::from(place));
                Message::PlanRefused(*fault.ok_or(InvalidScan::Malformed)?)
            }
            Self::FollowerReport {
                epoch,
                count,
                run,
                axis_id,
                state,
            } => Message::FollowerReport(ReceivedReport {
                epoch,
                count,
                run,
                axis_id,
                state: state.checked().map_err(|_| InvalidScan::Malformed)?,
            }),
            Self::Rejected(place) => {
                let reason = REJECTIONS.get(usize::from(place));
                Message::Rejected(*reason.ok_or(InvalidScan::Malformed)?)
            }
        };
        Ok(KeptMessage::new(&message))
    }
}

impl From<Frame<'_>> for FrameOnWire {
    fn from(Frame { header, axes }: Frame<'_>) -> Self {
        Self {
            sender: header.sender,
            epoch: header.epoch,
            index: header.index.0,
            count: header.count,
            cycle_time: header.cycle_time.span().as_nanos(),
            send_stamp: header.send_stamp.map(Span::as_nanos),
            axes: axes.iter().map(|axis| axis.map(AxisOnWire::from)).collect(),
        }
    }
}

impl FrameOnWire {
    fn kept(self, present_after: Option<PresentAfter>) -> Result<KeptMessage, InvalidScan> {
        let cycle_time = CycleTime::new(Span::from_nanos(self.cycle_time));
        let header = FrameHeader {
            sender: self.sender,
            epoch: self.epoch,
            index: CycleIndex(self.index),
            count: self.count,
            cycle_time: cycle_time.map_err(|_| InvalidScan::Malformed)?,
            present_after,
            send_stamp: self.send_stamp.map(Span::from_nanos),
        };
        let axes = self.axes.into_iter().map(|axis| axis.map(AxisSample::from));
        let axes: Vec<_> = axes.collect();
        let axes = axes.as_slice();
        Ok(KeptMessage::new(&Message::Frame(Frame { header, axes })))
    }
}

impl From<AxisSample> for AxisOnWire {
    fn from(axis: AxisSample) -> Self {
        Self {
            position: axis.set.position,
            velocity: axis.set.velocity,
            acceleration: axis.set.acceleration,
            state_word: axis.state_word.bits(),
            error_code: axis.error_code,
        }
    }
}

impl From<AxisOnWire> for AxisSample {
    fn from(axis: AxisOnWire) -> Self {
        Self {
            set: Kinematics {
                position: axis.position,
                velocity: axis.velocity,
                acceleration: axis.acceleration,
            },
            state_word: StateWord::from_bits_retain(axis.state_word),
            error_code: axis.error_code,
        }
    }
}
