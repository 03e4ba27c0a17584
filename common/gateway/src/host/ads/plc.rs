//! Reading from the PLC and writing to it.

use coaxle_axis::{IMAGE_LEN, ImageLayout, NcToPlcAxis};
use coaxle_clock::{CycleIndex, Instant, Span};
use coaxle_os::{Machine, machine};

use super::client::{AdsClient, AdsError, Notified};
use crate::PlcSample;
use crate::ams::notified;
use crate::assembly::Assembly;
use crate::config::{GatewayConfig, ImageKind, OutputConfig};
use crate::host::port::{OutputSlot, PlcEnd};
use crate::polled::{PlcMemory, PollPauses, Polled, poll};
use crate::record::write_image;

/// Bytes of the cycle index.
// `UINT` or `WORD`.
const INDEX_LEN: usize = 2;
/// Timeout of notifications.
// Ten cycles of the slowest PLC (100 ms).
const SILENCE: Span = Span::from_secs(1);

/// Reads the index again and again, and the axes whenever it is new.
pub(super) struct Polling {
    index: u32,
    axes: Vec<u32>,
    images: Vec<[u8; IMAGE_LEN]>,
    layout: ImageLayout,
    newest: Option<CycleIndex>,
    pub(super) pauses: PollPauses,
}

impl Polling {
    pub(super) fn prepare(
        client: &mut AdsClient,
        config: &GatewayConfig,
        index: &str,
    ) -> Result<Self, AdsError> {
        let (index, axes) = handles(client, config, index)?;
        Ok(Self {
            index,
            images: vec![[0; IMAGE_LEN]; axes.len()],
            axes,
            layout: config.layout.into(),
            newest: None,
            pauses: PollPauses::default(),
        })
    }

    /// Looks once, and sends the sample of a new cycle.
    pub(super) fn poll(
        &mut self,
        client: &mut AdsClient,
        end: &mut PlcEnd,
        connection: u32,
    ) -> Result<(), AdsError> {
        let mut memory = Memory {
            client,
            index: self.index,
            axes: &self.axes,
            images: &mut self.images,
            at: Instant::EPOCH,
            kept: Instant::EPOCH,
        };
        let polled = poll(&mut memory, self.newest)?;
        // The arrival of the first index that matches: reading the images took longer.
        let at = memory.kept;
        match polled {
            Polled::Nothing => {}
            Polled::Torn => end.link.count_torn(1),
            Polled::Images(index) => {
                // Only after a whole sample: a torn cycle is read again.
                self.newest = Some(index);
                let images = self.images.iter().map(<[u8; IMAGE_LEN]>::as_slice);
                send(end, at, index, connection, self.layout, images);
            }
        }
        Ok(())
    }
}

/// The PLC's memory during one poll.
struct Memory<'a> {
    client: &'a mut AdsClient,
    index: u32,
    axes: &'a [u32],
    images: &'a mut [[u8; IMAGE_LEN]],
    /// Time of reception of the newest index.
    at: Instant<Machine>,
    /// Time of reception of the index that the images belong to.
    kept: Instant<Machine>,
}

impl PlcMemory for Memory<'_> {
    type Error = AdsError;

    fn read_index(&mut self) -> Result<CycleIndex, AdsError> {
        let mut bytes = [0; INDEX_LEN];
        self.at = self.client.read(self.index, &mut bytes)?;
        Ok(CycleIndex(u16::from_le_bytes(bytes)))
    }

    fn read_images(&mut self) -> Result<(), AdsError> {
        for (axis, image) in self.axes.iter().zip(&mut *self.images) {
            self.client.read(*axis, image)?;
        }
        Ok(())
    }

    fn keep_arrival(&mut self) {
        self.kept = self.at;
    }
}

/// Receives the notifications that the PLC sends each cycle.
pub(super) struct Notifications {
    /// The handles of the notifications: of the index, then of the axes.
    parts: Vec<u32>,
    assembly: Assembly,
    layout: ImageLayout,
    newest: Instant<Machine>,
    torn: u64,
}

impl Notifications {
    pub(super) fn prepare(
        client: &mut AdsClient,
        config: &GatewayConfig,
        index: &str,
    ) -> Result<Self, AdsError> {
        let (index, axes) = handles(client, config, index)?;
        let mut lengths = vec![INDEX_LEN];
        lengths.resize(1 + axes.len(), IMAGE_LEN);
        // In the order of the parts: the index is part 0.
        let parts = std::iter::once(index).chain(axes).zip(&lengths);
        let parts = parts.map(|(handle, length)| client.notify(handle, *length));
        Ok(Self {
            parts: parts.collect::<Result<_, _>>()?,
            assembly: Assembly::of(&lengths),
            layout: config.layout.into(),
            newest: machine::now(),
            torn: 0,
        })
    }

    /// Waits up to `timeout` for a notification, and sends the samples completed by it and by those that wait behind it:
    /// none of them grows old while a value is written.
    pub(super) fn take(
        &mut self,
        client: &mut AdsClient,
        end: &mut PlcEnd,
        connection: u32,
        timeout: Span,
    ) -> Result<(), AdsError> {
        let mut next = client.notification(timeout)?;
        // Nothing else shows a connection that the PLC has given up.
        if next.is_none() && machine::now() - self.newest > SILENCE {
            return Err(AdsError::Silent);
        }
        while let Some(notification) = next {
            self.send(&notification, end, connection)?;
            next = client.notification(Span::ZERO)?;
        }
        Ok(())
    }

    /// Sends the samples that a notification completes.
    fn send(
        &mut self,
        notification: &Notified,
        end: &mut PlcEnd,
        connection: u32,
    ) -> Result<(), AdsError> {
        let at = notification.at;
        self.newest = at;
        let Self {
            parts,
            assembly,
            layout,
            ..
        } = self;
        let is_whole = notified(&notification.data, |sample| {
            // A handle of an earlier connection, or of nobody.
            let Some(part) = parts.iter().position(|part| *part == sample.handle) else {
                return;
            };
            match assembly.take(sample.stamp, part, sample.data) {
                Ok(true) => {
                    let (index, images) = assembly.parts().split_at(1);
                    let index = CycleIndex(u16::from_le_bytes([index[0][0], index[0][1]]));
                    let images = images.iter().map(Vec::as_slice);
                    send(end, at, index, connection, *layout, images);
                }
                Ok(false) => {}
                Err(error) => {
                    if end.link.count_refused() {
                        tracing::warn!("a notification was refused, and others may be: {error}");
                    }
                }
            }
        });
        // The difference since the last notification: the link counts sums.
        end.link.count_torn(self.assembly.torn() - self.torn);
        self.torn = self.assembly.torn();
        if is_whole {
            Ok(())
        } else {
            Err(AdsError::Notification)
        }
    }
}

fn handles(
    client: &mut AdsClient,
    config: &GatewayConfig,
    index: &str,
) -> Result<(u32, Vec<u32>), AdsError> {
    let index = client.handle_of(index)?;
    let symbols = config.axes.iter().filter_map(|axis| axis.symbol.as_deref());
    let axes = symbols.map(|symbol| client.handle_of(symbol));
    Ok((index, axes.collect::<Result<_, _>>()?))
}

/// Sends a sample to the node. The images are as long as they should be.
fn send<'a>(
    end: &mut PlcEnd,
    at: Instant<Machine>,
    index: CycleIndex,
    connection: u32,
    layout: ImageLayout,
    images: impl Iterator<Item = &'a [u8]>,
) {
    let sent = end.samples.send(at, |sample: &mut PlcSample| {
        sample.index = index;
        sample.connection = connection;
        for (axis, image) in sample.axes.iter_mut().zip(images) {
            *axis = NcToPlcAxis::from_image_slice(layout, image)?;
        }
        // The images were made with the length that the structure has.
        Ok::<_, coaxle_axis::ImageLengthError>(())
    });
    if sent.is_err() {
        end.link.count_refused();
    }
}

/// Writes the axes of one output into the PLC.
pub(super) struct Writing {
    axes: Vec<(u32, ImageKind)>,
    index: Option<u32>,
    layout: ImageLayout,
    image: Vec<u8>,
}

impl Writing {
    /// Prepares the writing of each output.
    pub(super) fn prepare(
        client: &mut AdsClient,
        config: &GatewayConfig,
    ) -> Result<Vec<Self>, AdsError> {
        let outputs = config.outputs.iter();
        let layout = config.layout.into();
        outputs
            .map(|output| Self::of(client, output, layout))
            // The first missing symbol ends the connection: half an output would be worse than none.
            .collect()
    }

    fn of(
        client: &mut AdsClient,
        output: &OutputConfig,
        layout: ImageLayout,
    ) -> Result<Self, AdsError> {
        let mut axes = Vec::new();
        for axis in &output.axes {
            if let Some(symbol) = &axis.symbol {
                axes.push((client.handle_of(symbol)?, axis.image));
            }
        }
        let symbol = output.cycle_index.as_deref();
        let index = symbol.map(|symbol| client.handle_of(symbol)).transpose()?;
        Ok(Self {
            axes,
            index,
            layout,
            image: Vec::new(),
        })
    }

    /// Writes the axes that are there, and then the index: a PLC that sees a new one finds its axes.
    pub(super) fn write(
        &mut self,
        client: &mut AdsClient,
        slot: &OutputSlot,
    ) -> Result<(), AdsError> {
        for ((handle, kind), axis) in self.axes.iter().zip(&slot.axes) {
            // An axis that did not come keeps its last values in the PLC. The index says that others are new.
            let Some(axis) = axis else {
                continue;
            };
            self.image.clear();
            write_image(*kind, self.layout, axis, &mut self.image);
            client.write(*handle, &self.image)?;
        }
        match self.index {
            Some(handle) => client.write(handle, &slot.index.0.to_le_bytes()),
            None => Ok(()),
        }
    }
}
