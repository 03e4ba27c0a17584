//! A PLC by UDP: each datagram is a record, the cycle index and the images.

use std::io::ErrorKind;
use std::net::UdpSocket;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context, bail};
use coaxle_axis::ImageLayout;
use coaxle_clock::{Instant, Span};
use coaxle_os::{Machine, machine};

use super::port::{OutputSlot, PlcEnd, PlcLink, PlcOutputs, Samples, StopFlag};
use super::thread;
use crate::config::{GatewayConfig, HostPort, OutputAxisConfig, UdpConfig};
use crate::record::{RecordLengthError, read_record, record_len, write_image};

/// Silence after which a PLC is away.
// Ten cycles of the slowest PLC (100 ms).
const SILENCE: Span = Span::from_secs(1);
/// Longest wait for a datagram between checks for the end.
// The longest delay of an end.
const RECEIVE_POLL: Duration = Duration::from_millis(100);

/// Starts to listen and to send.
pub(super) fn start(
    config: &GatewayConfig,
    udp: &UdpConfig,
    end: PlcEnd,
) -> anyhow::Result<Vec<JoinHandle<()>>> {
    let mut threads = Vec::new();
    let PlcEnd {
        samples,
        outputs,
        link,
        stop,
    } = end;
    if let Some(listen) = &udp.listen {
        let socket = listening(listen)?;
        let (layout, axes) = (config.layout.into(), config.axes.len());
        let (link, stop) = (Arc::clone(&link), Arc::clone(&stop));
        threads.push(thread("plc-in", move || {
            Receiving {
                socket,
                layout,
                axes,
                samples,
                link,
            }
            .work(&stop);
        })?);
    } else {
        // Without received datagrams, nothing shows whether the PLC is there.
        let _ = link.connected();
    }
    if let Some(send_to) = &udp.send_to {
        let socket = sending(send_to)?;
        let config = config.clone();
        threads.push(thread("plc-out", move || {
            send(&config, &socket, outputs, &stop);
        })?);
    }
    Ok(threads)
}

fn listening(listen: &HostPort) -> anyhow::Result<UdpSocket> {
    let at = (listen.host(), listen.port().unwrap_or_default());
    let field = || format!("udp.listen: cannot listen on {}:{}", at.0, at.1);
    let socket = UdpSocket::bind(at).with_context(field)?;
    socket
        .set_read_timeout(Some(RECEIVE_POLL))
        .with_context(field)?;
    Ok(socket)
}

fn sending(send_to: &HostPort) -> anyhow::Result<UdpSocket> {
    let to = (send_to.host(), send_to.port().unwrap_or_default());
    let field = || format!("udp.send-to: cannot send to {}:{}", to.0, to.1);
    for any in ["0.0.0.0:0", "[::]:0"] {
        let socket = UdpSocket::bind(any).with_context(field)?;
        // A socket of the other family cannot be connected to it.
        if socket.connect(to).is_ok() {
            return Ok(socket);
        }
    }
    bail!("{}", field())
}

/// Takes datagrams.
struct Receiving {
    socket: UdpSocket,
    layout: ImageLayout,
    axes: usize,
    samples: Samples,
    link: Arc<PlcLink>,
}

impl Receiving {
    fn work(mut self, stop: &StopFlag) {
        // One byte more shows that one is too long.
        let mut bytes = vec![0; record_len(self.axes) + 1];
        let mut newest = None;
        while !stop.is_set() {
            let came = self.socket.recv(&mut bytes);
            // Right after the datagram: parsing is not part of the arrival.
            let now = machine::now();
            match came {
                Ok(length) if self.take(now, &bytes[..length]) => {
                    // The first one after a silence only.
                    if newest.replace(now).is_none() {
                        let _ = self.link.connected();
                        tracing::info!("datagrams of the PLC come");
                    }
                }
                Ok(_) => {}
                // Of a datagram that was sent from this socket: nothing to do with those that come.
                Err(error) if is_nothing(error.kind()) => {}
                Err(error) => {
                    tracing::debug!(%error, "a datagram could not be taken");
                    // An interface that is down fails at once, and the loop would take a whole processor.
                    stop.sleep(Span::from_millis(100));
                }
            }
            if newest.is_some_and(|newest| now - newest > SILENCE) {
                newest = None;
                self.link.disconnected();
                tracing::warn!("no datagram of the PLC came for a second");
            }
        }
    }

    /// Takes a datagram; true if it was a record. All are of one connection: a PLC that was silent continues, or shows by
    /// its index that it has restarted.
    fn take(&mut self, at: Instant<Machine>, bytes: &[u8]) -> bool {
        let layout = self.layout;
        let taken = self.samples.send(at, |sample| {
            sample.index = read_record(layout, bytes, &mut sample.axes)?;
            Ok::<_, RecordLengthError>(())
        });
        if let Err(error) = &taken
            && self.link.count_refused()
        {
            tracing::warn!("a datagram was refused, and others may be: {error}");
        }
        taken.is_ok()
    }
}

fn is_nothing(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::WouldBlock
            | ErrorKind::TimedOut
            | ErrorKind::Interrupted
            | ErrorKind::ConnectionRefused
            | ErrorKind::ConnectionReset
    )
}

/// Sends each record once. One with an axis missing is none.
fn send(config: &GatewayConfig, socket: &UdpSocket, mut outputs: PlcOutputs, stop: &StopFlag) {
    outputs.attach();
    let mut slot = OutputSlot::of(config);
    let axes: Vec<&OutputAxisConfig> = config.output_axes().collect();
    let (layout, mut record) = (config.layout.into(), Vec::new());
    while !stop.is_set() {
        // Whole or not at all: a record has no place for a missing axis.
        if outputs.next_into(&mut slot) && write_record(&slot, &axes, layout, &mut record) {
            // A missing peer is no reason to stop: the next datagram may arrive.
            if let Err(error) = socket.send(&record) {
                tracing::debug!(%error, "a datagram was not sent");
            }
        }
    }
}

/// Replaces the content of `record` by a slot's; false if an axis is missing.
pub(super) fn write_record(
    slot: &OutputSlot,
    axes: &[&OutputAxisConfig],
    layout: ImageLayout,
    record: &mut Vec<u8>,
) -> bool {
    record.clear();
    record.extend_from_slice(&slot.index.0.to_le_bytes());
    for (axis, of) in slot.axes.iter().zip(axes) {
        let Some(axis) = axis else {
            return false;
        };
        write_image(of.image, layout, axis, record);
    }
    true
}
