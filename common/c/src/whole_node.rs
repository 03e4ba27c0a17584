//! A receiver with the keys of its channels and the drives of its slaves.

use std::ffi::CString;
use std::sync::Arc;

use ::coaxle_axis::drive::DriveState;
use ::coaxle_receiver::{Drives, Receiver, ReceiverConfig, SlaveNumber};
use coaxle_clock::{Instant, Local};
use coaxle_node::lab::NodeFile;
use coaxle_node::{Channel, Node, Reader};
use coaxle_wire::frame::KeySeal;

use crate::caller_drive::{COAXLE_DRIVE_OF_CALLER, CallerDrive, DriveCells};
use crate::failure::{COAXLE_NOT_THERE, COAXLE_TEXT, Failure};
use crate::memory::growing;
use crate::slave_structs::{coaxle_slave_state, status, tracking};
use crate::wire::COAXLE_MOST_BYTES;

/// A receiver with what a caller names by numbers.
#[derive(Debug)]
pub(crate) struct WholeNode {
    pub(crate) receiver: Receiver,
    /// Subscriptions: a key and a reader each.
    pub(crate) subscriptions: Box<[(CString, Reader)]>,
    pub(crate) publications: Box<[OwnPublication]>,
    pub(crate) far_axes: Box<[String]>,
    pub(crate) slaves: Box<[(String, Arc<DriveCells>)]>,
    /// Message that did not fit the caller's buffer, or is on its way there.
    pub(crate) message: Vec<u8>,
    /// Publication that it belongs to.
    pub(crate) unsent: Option<usize>,
}

/// A channel that the node publishes.
#[derive(Debug)]
pub(crate) struct OwnPublication {
    channel: Channel,
    far: usize,
    key: CString,
    seal: KeySeal,
}

/// Parameters of a receiver beside its config.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_receiver_parameters {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// `COAXLE_DRIVE_IDEAL`: the drives of the config, which are simulated. `COAXLE_DRIVE_OF_CALLER`: the caller has a drive for each
    /// slave, which therefore needs limits.
    pub drive: u32,
    /// Start of its first cycle, ns of the own clock.
    pub start_ns: i64,
    /// Number of this run: random.
    pub epoch: u64,
}

growing! {
    coaxle_receiver_parameters, 24;
}

impl WholeNode {
    /// Makes a node of the text of its config.
    pub(crate) fn new(
        given: &coaxle_receiver_parameters,
        name: &str,
        config: &str,
    ) -> Result<Self, Failure> {
        let config: ReceiverConfig = NodeFile::parse_machine(name, config)
            .map_err(|wrong| Failure::new(COAXLE_TEXT, wrong))?;
        let mut drives = Drives::new();
        let mut slaves = Vec::new();
        for slave in &config.slaves {
            let name = slave.name.as_str();
            let cells = DriveCells::new(given.drive)?;
            if given.drive == COAXLE_DRIVE_OF_CALLER {
                drives = drives.with(name, CallerDrive(Arc::clone(&cells)));
            }
            slaves.push((name.to_owned(), cells));
        }
        let start = Instant::from_nanos(given.start_ns);
        let receiver = Receiver::with_drives(&config, drives, start, given.epoch)
            .map_err(|wrong| Failure::new(COAXLE_TEXT, format_args!("{name}: {wrong}")))?;
        let wiring = config.wiring();
        let subscriptions = wiring.subscriptions.into_iter().map(|subscription| {
            let key = subscription.node.channel_key(subscription.channel);
            Ok((c_string(key)?, subscription.reader))
        });
        let publications = wiring.publications.into_iter().map(|publication| {
            let key = publication.node.channel_key(publication.channel);
            Ok(OwnPublication {
                channel: publication.channel,
                far: publication.far,
                seal: KeySeal::new(&key),
                key: c_string(key)?,
            })
        });
        Ok(Self {
            subscriptions: subscriptions.collect::<Result<_, Failure>>()?,
            publications: publications.collect::<Result<_, Failure>>()?,
            far_axes: config.far_axis_names().into(),
            slaves: slaves.into(),
            message: Vec::with_capacity(COAXLE_MOST_BYTES),
            unsent: None,
            receiver,
        })
    }

    /// Seals the next message of the newest cycle. Returns its key.
    pub(crate) fn next_message(&mut self, now: Instant<Local>) -> Option<&CString> {
        if let Some(unsent) = self.unsent {
            return Some(&self.publications[unsent].key);
        }
        while let Some(outgoing) = self.receiver.transmit() {
            // Beacons and reports go to one node each.
            let place = self.publications.iter().position(|publication| {
                publication.channel == outgoing.channel && publication.far == outgoing.far
            });
            let Some(place) = place else { continue };
            let publication = &self.publications[place];
            let stamp = Some(now - outgoing.ideal_start);
            (publication.seal).seal(outgoing.body, stamp, &mut self.message);
            self.unsent = Some(place);
            return Some(&publication.key);
        }
        None
    }

    pub(crate) fn slave_number(&self, slave: u32) -> Result<SlaveNumber, Failure> {
        (self.slaves.get(slave as usize))
            .and_then(|(name, _)| self.receiver.slave_number(name))
            .ok_or_else(|| not_there("slave", slave))
    }

    pub(crate) fn slave_state(&self, number: usize) -> Option<coaxle_slave_state> {
        let signals = self.receiver.snapshot().signals.slaves.get(number)?;
        let (_, drive) = self.slaves.get(number)?;
        Some(coaxle_slave_state {
            struct_size: 0,
            status: status(signals.state),
            position: signals.position?,
            velocity: signals.velocity?,
            acceleration: signals.acceleration?,
            distance: signals.distance,
            error: signals.error,
            // A simulated drive has the power that it wants.
            wants_power: (drive.wants_power() || signals.drive_state != DriveState::Off).into(),
            is_in_sync: signals.phase.is_some_and(|phase| phase.is_in_sync()).into(),
            tracking: tracking(signals.guard),
            presets: signals.set_anew,
            reserved: 0,
        })
    }
}

/// Finds a name.
pub(crate) fn find<'a>(
    name: &str,
    names: impl Iterator<Item = &'a str> + Clone,
    what: &str,
) -> Result<u32, Failure> {
    let found = (0..).zip(names.clone()).find(|(_, other)| *other == name);
    found.map(|(number, _)| number).ok_or_else(|| {
        let known = NameList(names);
        let sentence = format_args!("{what}: received {name:?}, expected one of: {known}");
        Failure::new(COAXLE_NOT_THERE, sentence)
    })
}

/// Names as a list, written without a text of its own.
struct NameList<N>(N);

impl<'a, N: Iterator<Item = &'a str> + Clone> core::fmt::Display for NameList<N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for (n, name) in self.0.clone().enumerate() {
            f.write_str(if n == 0 { "" } else { ", " })?;
            f.write_str(name)?;
        }
        Ok(())
    }
}

pub(crate) fn not_there(what: &str, number: u32) -> Failure {
    Failure::new(
        COAXLE_NOT_THERE,
        format_args!("there is no {what} {number}"),
    )
}

fn c_string(text: String) -> Result<CString, Failure> {
    CString::new(text).map_err(|wrong| Failure::new(COAXLE_TEXT, wrong))
}
