//! A connection to an ADS device: one request at a time, and the notifications that come meanwhile.

use std::collections::VecDeque;
use std::net::IpAddr;

use coaxle_clock::{Instant, Span};
use coaxle_os::{Machine, machine};

use super::wire::{AdsWire, Tcp};
use crate::ams::{
    self, ADD_NOTIFICATION, AMS_PORT, AdsRefusal, AmsAddress, AmsError, DELETE_NOTIFICATION,
    HANDLE_BY_NAME, NOTIFICATION, Packet, READ, READ_STATE, READ_WRITE, RELEASE_HANDLE, REPLY,
    REQUEST, VALUE_BY_HANDLE, WRITE, take_packet,
};
use crate::config::AdsConfig;

/// Timeout of a response.
// The text of the error says so, too.
const RESPONSE_TIMEOUT: Span = Span::from_secs(1);
/// Notifications that wait to be taken; older ones are left out.
// Nearly two cycles of 128 axes and the index, if each comes in a packet of its own.
const MOST_WAITING: usize = 256;

/// A connection. After an error it is of no use: a late response could be taken for that to another request.
pub(super) struct AdsClient {
    wire: Box<dyn AdsWire>,
    own: AmsAddress,
    plc: AmsAddress,
    invoke: u32,
    /// Received bytes that were not taken yet, and the time of the newest of them.
    received: Vec<u8>,
    received_at: Instant<Machine>,
    sent: Vec<u8>,
    notifications: VecDeque<Notified>,
    /// Handles of values and of notifications, to release them.
    handles: Vec<(u16, u32)>,
}

/// A notification, and its time of reception.
pub(super) struct Notified {
    pub(super) at: Instant<Machine>,
    pub(super) data: Vec<u8>,
}

/// Reason for the end of a connection.
#[derive(Debug, thiserror::Error)]
pub(super) enum AdsError {
    #[error("{address}: {reason}")]
    Unreachable {
        address: String,
        reason: std::io::Error,
    },
    #[error("the connection ended: {0}")]
    Lost(#[from] std::io::Error),
    #[error("no answer within a second to {request}; does the PLC have a route to this PC?")]
    NoAnswer { request: String },
    #[error("{request}: {refusal}")]
    Refused {
        request: String,
        refusal: AdsRefusal,
    },
    #[error("{request}: {received} bytes came, expected {expected}")]
    Length {
        request: String,
        received: usize,
        expected: usize,
    },
    #[error("no notification came for a second")]
    Silent,
    #[error(transparent)]
    Malformed(#[from] AmsError),
    #[error("a notification of the PLC ends in the middle of a sample")]
    Notification,
}

impl AdsClient {
    /// Connects to the device of a config.
    pub(super) fn connect(config: &AdsConfig) -> Result<Self, AdsError> {
        let (host, port) = (config.address.host(), config.address.port());
        let port = port.unwrap_or(AMS_PORT);
        let unreachable = |reason| AdsError::Unreachable {
            address: format!("{host}:{port}"),
            reason,
        };
        let tcp = Tcp::reach(host, port, RESPONSE_TIMEOUT).map_err(unreachable)?;
        let own = config.own_net_id.map(|id| id.0);
        let own = match (own, tcp.own_ip().map_err(unreachable)?) {
            (Some(own), _) => own,
            (None, IpAddr::V4(ip)) => {
                let [a, b, c, d] = ip.octets();
                [a, b, c, d, 1, 1]
            }
            // An AMS net id has room for an IPv4 address only. A PLC that is reached by IPv6 needs `own-net-id`.
            (None, IpAddr::V6(_)) => [127, 0, 0, 1, 1, 1],
        };
        let own = AmsAddress {
            net_id: own,
            // Ports from 0x8000 on are for clients.
            // The process id: two gateways on one PC should differ.
            port: 0x8000 | std::process::id() as u16,
        };
        Ok(Self::over(Box::new(tcp), own, config))
    }

    /// A client of this address, to the device of a config, over a connection that is there.
    pub(super) fn over(wire: Box<dyn AdsWire>, own: AmsAddress, config: &AdsConfig) -> Self {
        Self {
            wire,
            own,
            plc: AmsAddress {
                net_id: config.net_id.0,
                port: config.port,
            },
            invoke: 0,
            received: Vec::new(),
            received_at: machine::now(),
            sent: Vec::new(),
            notifications: VecDeque::new(),
            handles: Vec::new(),
        }
    }

    /// State of the PLC: 5 is running, 6 stopped.
    pub(super) fn state(&mut self) -> Result<u16, AdsError> {
        let request = "the request for its state";
        let reply = self.send_request(READ_STATE, &[], request)?;
        let expected = 4;
        match reply.as_slice() {
            [low, high, _, _, ..] => Ok(u16::from_le_bytes([*low, *high])),
            other => Err(AdsError::Length {
                request: request.to_owned(),
                received: other.len(),
                expected,
            }),
        }
    }

    /// The handle of a symbol.
    pub(super) fn handle_of(&mut self, symbol: &str) -> Result<u32, AdsError> {
        let request = format!("the request for the symbol {symbol:?}");
        let data = ams::read_write(HANDLE_BY_NAME, 0, 4, symbol.as_bytes());
        let mut handle = [0; 4];
        self.read_reply(READ_WRITE, &data, &request, &mut handle)?;
        let handle = u32::from_le_bytes(handle);
        // Kept for the end: the PLC holds handles until they are released.
        self.handles.push((WRITE, handle));
        Ok(handle)
    }

    /// Reads the value of a handle. Returns the time at which the response was received.
    pub(super) fn read(
        &mut self,
        handle: u32,
        value: &mut [u8],
    ) -> Result<Instant<Machine>, AdsError> {
        let data = ams::read(VALUE_BY_HANDLE, handle, value.len() as u32);
        self.read_reply(READ, &data, "reading a variable", value)
    }

    /// Writes a value.
    pub(super) fn write(&mut self, handle: u32, value: &[u8]) -> Result<(), AdsError> {
        let data = ams::write(VALUE_BY_HANDLE, handle, value);
        self.send_request(WRITE, &data, "writing a variable")
            .map(drop)
    }

    /// Subscribes to the value of a handle in each cycle. Returns the handle of the notification.
    pub(super) fn notify(&mut self, handle: u32, length: usize) -> Result<u32, AdsError> {
        let request = "the request for notifications";
        let data = ams::add_notification(VALUE_BY_HANDLE, handle, length as u32);
        let reply = self.send_request(ADD_NOTIFICATION, &data, request)?;
        let four = reply.first_chunk().ok_or_else(|| AdsError::Length {
            request: request.to_owned(),
            received: reply.len(),
            expected: 4,
        })?;
        let notification = u32::from_le_bytes(*four);
        self.handles.push((DELETE_NOTIFICATION, notification));
        Ok(notification)
    }

    /// The next notification, if one comes within `timeout`.
    pub(super) fn notification(&mut self, timeout: Span) -> Result<Option<Notified>, AdsError> {
        // By the monotonic clock, not per read: a stream of other packets must not prolong the wait.
        let until = machine::now() + timeout;
        loop {
            if let Some(notified) = self.notifications.pop_front() {
                return Ok(Some(notified));
            }
            match self.packet(until)? {
                // A reply to no request of ours.
                Some(_) => {}
                // The queue is empty: each notification that is queued returns from `packet` at once.
                None => return Ok(None),
            }
        }
    }

    /// Releases the handles that the PLC keeps for this connection, as long as it responds.
    pub(super) fn release_handles(mut self) {
        let handles = std::mem::take(&mut self.handles);
        // Notifications first: they are of the values.
        // In reverse order of their making: a notification refers to the handle of its value.
        for (command, handle) in handles.into_iter().rev() {
            let data = match command {
                DELETE_NOTIFICATION => handle.to_le_bytes().to_vec(),
                _ => ams::write(RELEASE_HANDLE, 0, &handle.to_le_bytes()),
            };
            if self
                .send_request(command, &data, "giving back a handle")
                .is_err()
            {
                // Each further handle would cost another second.
                return;
            }
        }
    }

    fn read_reply(
        &mut self,
        command: u16,
        data: &[u8],
        request: &str,
        value: &mut [u8],
    ) -> Result<Instant<Machine>, AdsError> {
        let reply = self.send_request(command, data, request)?;
        // The arrival of the newest bytes, which are those of this reply.
        let at = self.received_at;
        let read = ams::read_bytes(&reply).unwrap_or_default();
        // A symbol of another length is another structure: a part of it would pass for an image.
        if read.len() != value.len() {
            return Err(AdsError::Length {
                request: request.to_owned(),
                received: read.len(),
                expected: value.len(),
            });
        }
        value.copy_from_slice(read);
        Ok(at)
    }

    /// Sends a request and waits for the reply. Returns the data behind its result.
    fn send_request(
        &mut self,
        command: u16,
        data: &[u8],
        request: &str,
    ) -> Result<Vec<u8>, AdsError> {
        // Wrapping: after 2³² requests no old reply is left.
        self.invoke = self.invoke.wrapping_add(1);
        let invoke = self.invoke;
        let packet = Packet {
            target: self.plc,
            source: self.own,
            command,
            flags: REQUEST,
            error: 0,
            invoke,
            data,
        };
        packet.write(&mut self.sent);
        self.wire.send(&self.sent)?;
        let until = machine::now() + RESPONSE_TIMEOUT;
        let refused = |refusal| AdsError::Refused {
            request: request.to_owned(),
            refusal,
        };
        loop {
            match self.packet(until)? {
                Some(reply) if (reply.command, reply.invoke) == (command, invoke) => {
                    // The router refuses by the error of the header, the device by the result in the data.
                    if reply.error != 0 {
                        return Err(refused(AdsRefusal(reply.error)));
                    }
                    return ams::result(&reply.data)
                        .map(<[u8]>::to_vec)
                        .map_err(refused);
                }
                // A late reply to an earlier request, or a notification, which is queued.
                Some(_) => {}
                None => {
                    let request = request.to_owned();
                    return Err(AdsError::NoAnswer { request });
                }
            }
        }
    }

    /// The next reply, if one comes until then; notifications before it are kept.
    fn packet(&mut self, until: Instant<Machine>) -> Result<Option<AdsReply>, AdsError> {
        loop {
            while let Some((packet, end)) = take_packet(&self.received)? {
                let reply = packet.and_then(|packet| classified(&packet));
                self.received.drain(..end);
                match reply {
                    Some(IncomingPacket::Reply(reply)) => return Ok(Some(reply)),
                    Some(IncomingPacket::Notified(data)) => {
                        // The oldest goes: an old cycle of the PLC is of no use, and the newest is.
                        if self.notifications.len() == MOST_WAITING {
                            self.notifications.pop_front();
                        }
                        let at = self.received_at;
                        self.notifications.push_back(Notified { at, data });
                        // Handed back as a reply to nobody, so that `notification` looks into the queue at once.
                        return Ok(Some(AdsReply::notification_marker()));
                    }
                    None => {}
                }
            }
            let left = until - machine::now();
            // After the received packets: those that are there count, even if time is over.
            if left <= Span::ZERO {
                return Ok(None);
            }
            self.receive(left)?;
        }
    }

    /// Takes the bytes that come within this time, if any.
    fn receive(&mut self, timeout: Span) -> Result<(), AdsError> {
        // Longer packets take several reads.
        let mut bytes = [0; 4096];
        let length = self.wire.receive(&mut bytes, timeout)?;
        // 0 is a read that timed out.
        if length > 0 {
            self.received_at = machine::now();
            self.received.extend_from_slice(&bytes[..length]);
        }
        Ok(())
    }
}

/// A reply, taken out of the received bytes.
struct AdsReply {
    command: u16,
    invoke: u32,
    error: u32,
    data: Vec<u8>,
}

enum IncomingPacket {
    Reply(AdsReply),
    Notified(Vec<u8>),
}

impl AdsReply {
    /// A notification came: no request has the command 0.
    const fn notification_marker() -> Self {
        Self {
            command: 0,
            invoke: 0,
            error: 0,
            data: Vec::new(),
        }
    }
}

/// Classifies a packet for a client; none for other kinds.
fn classified(packet: &Packet<'_>) -> Option<IncomingPacket> {
    let data = packet.data.to_vec();
    match (packet.command, packet.flags) {
        (NOTIFICATION, REQUEST) => Some(IncomingPacket::Notified(data)),
        (command, REPLY) => Some(IncomingPacket::Reply(AdsReply {
            command,
            invoke: packet.invoke,
            error: packet.error,
            data,
        })),
        // Requests to this PC: a gateway serves nobody.
        _ => None,
    }
}
