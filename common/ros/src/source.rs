//! The frames of one channel of a node, as the states of joints.

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{Instant, Local, Span};
use coaxle_wire::frame::{KeySeal, sender_id};
use coaxle_wire::keys::NodeName;
use coaxle_wire::{Channel, FrameHeader, Rejection};

use crate::catalog::Catalog;
use crate::cycle_starts::CycleStarts;
use crate::message::{JointState, Time};

/// Values of an axis to publish.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PublishedValues {
    /// `fPosSoll` and `fVeloSoll`.
    #[default]
    Set,
    /// `fPosIst` and `fVeloIst`.
    Actual,
}

/// Position and velocity of a slave: set values, u and u/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlaveMotion {
    /// u.
    pub position: f64,
    /// u/s.
    pub velocity: f64,
}

/// The frames of a channel that carries axes.
#[derive(Clone, Debug)]
pub struct FrameSource {
    node: NodeName,
    channel: Channel,
    seal: KeySeal,
    sender: u32,
    cycle_starts: CycleStarts,
    newest: Option<NewestFrame>,
    is_new: bool,
}

/// The newest frame.
#[derive(Clone, Debug)]
struct NewestFrame {
    header: FrameHeader,
    received_at: Instant<Local>,
    axes: Vec<NcToPlcAxis>,
}

impl FrameSource {
    /// Makes the source of the frames of a node on a channel.
    #[must_use]
    pub fn new(node: NodeName, channel: Channel) -> Self {
        Self {
            seal: KeySeal::new(&node.channel_key(channel)),
            sender: sender_id(&node),
            node,
            channel,
            cycle_starts: CycleStarts::default(),
            newest: None,
            is_new: false,
        }
    }

    /// Takes a frame.
    ///
    /// # Errors
    /// [`Rejection`]: not a frame, or another node's.
    pub fn frame(&mut self, received_at: Instant<Local>, payload: &[u8]) -> Result<(), Rejection> {
        let mut axes = Vec::new();
        let header = self.seal.open(payload, |axis| axes.push(*axis))?;
        // The seal holds for the key; the sender in the frame must be that of the key too.
        if header.sender != self.sender {
            return Err(Rejection::ForeignSender);
        }
        // Late frames as well: their arrivals are measurements of the clock.
        self.cycle_starts.frame(&header, received_at);
        let is_late = |newest: &NewestFrame| {
            // Another epoch is a restarted node, whose counts begin again.
            newest.header.epoch == header.epoch && newest.header.count >= header.count
        };
        if self.newest.as_ref().is_some_and(is_late) {
            return Ok(());
        }
        // Without an implausible axis the other joints of the message stay usable.
        axes.retain(|axis| axis.implausible_field().is_none());
        self.newest = Some(NewestFrame {
            header,
            received_at,
            axes,
        });
        self.is_new = true;
        Ok(())
    }

    /// Returns the newest states of the joints as of `now`, if they have not been returned yet. `unix` is
    /// CLOCK_REALTIME at time 0 of the local clock.
    pub fn joint_state(
        &mut self,
        now: Instant<Local>,
        catalog: &Catalog,
        values: PublishedValues,
        unix: Span,
    ) -> Option<JointState> {
        self.cycle_starts.cycle(now);
        // A state that was published already would be one more with an old stamp.
        if !std::mem::take(&mut self.is_new) {
            return None;
        }
        let newest = self.newest.as_ref()?;
        let cycle_start = self
            .cycle_starts
            .cycle_start(newest.header.count, newest.received_at);
        let mut state = JointState {
            stamp: Time::from_nanos((cycle_start.since_epoch() + unix).as_nanos()),
            ..JointState::default()
        };
        for axis in &newest.axes {
            let joint = catalog.joint(&self.node, self.channel, axis.axis_id);
            let (position, velocity) = match values {
                PublishedValues::Set => (axis.set_position, axis.set_velocity),
                PublishedValues::Actual => (axis.actual_position, axis.actual_velocity),
            };
            state.position.push(joint.scale().to_ros(position));
            state.velocity.push(joint.scale().to_ros(velocity));
            state.name.push(joint.name);
        }
        (!state.name.is_empty()).then_some(state)
    }

    /// Returns the motion of an axis, and its time of arrival; none before its first frame.
    #[must_use]
    pub fn motion(&self, id: u32) -> Option<(Instant<Local>, SlaveMotion)> {
        let newest = self.newest.as_ref()?;
        let axis = newest.axes.iter().find(|axis| axis.axis_id == id)?;
        let motion = SlaveMotion {
            position: axis.set_position,
            velocity: axis.set_velocity,
        };
        Some((newest.received_at, motion))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::{CycleIndex, CycleTime};
    use coaxle_wire::frame::{body_capacity, encode_body, seal};
    use serde_json::json;

    fn at(millis: i64) -> Instant<Local> {
        Instant::from_nanos(millis * 1_000_000)
    }

    fn frame(key: &str, node: &NodeName, count: u64, position: f64) -> Vec<u8> {
        let header = FrameHeader {
            sender: sender_id(node),
            epoch: 5,
            index: CycleIndex(count as u16),
            count,
            cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
            present_after: None,
            send_stamp: None,
        };
        let axis = |axis_id, set_position| NcToPlcAxis {
            axis_id,
            set_position,
            actual_position: set_position - 1.0,
            set_velocity: 500.0,
            ..NcToPlcAxis::default()
        };
        let mut body = vec![0; body_capacity(2)];
        let axes = [axis(1, position), axis(2, f64::NAN)];
        let length = encode_body(&header, &axes, &mut body).unwrap();
        let mut sealed = Vec::new();
        seal(key, &body[..length], None, &mut sealed);
        sealed
    }

    #[test]
    fn the_newest_frame_is_told_once_in_metres() {
        let node = NodeName::new("conveyor").unwrap();
        let status = json!({ "axes": { "belt": { "id": 1, "unit": "mm" } } });
        let catalog = Catalog::of_status(&node, status.as_object().unwrap());
        let mut source = FrameSource::new(node.clone(), Channel::Axes);
        let key = node.channel_key(Channel::Axes);
        source.frame(at(1), &frame(&key, &node, 2, 1500.0)).unwrap();
        source.frame(at(2), &frame(&key, &node, 1, 1000.0)).unwrap();
        let unix = Span::from_secs(1_700_000_000);
        let state = source
            .joint_state(at(3), &catalog, PublishedValues::Set, unix)
            .unwrap();
        assert_eq!(
            state.name,
            ["conveyor/belt"],
            "what is no number is left out"
        );
        assert_eq!(
            (&state.position[..], &state.velocity[..]),
            (&[1.5][..], &[0.5][..])
        );
        assert_eq!(
            (state.stamp.sec, state.stamp.nanosec),
            (1_700_000_000, 1_000_000)
        );
        assert_eq!(
            source.joint_state(at(4), &catalog, PublishedValues::Set, unix),
            None
        );
        source.frame(at(5), &frame(&key, &node, 3, 2000.0)).unwrap();
        let actual = source
            .joint_state(at(6), &catalog, PublishedValues::Actual, unix)
            .unwrap();
        assert_eq!((actual.position[0], actual.velocity[0]), (1.999, 0.0));
    }

    #[test]
    fn what_is_no_frame_of_the_node_is_refused() {
        let (node, other) = (NodeName::new("a").unwrap(), NodeName::new("b").unwrap());
        let mut source = FrameSource::new(node.clone(), Channel::Axes);
        let key = node.channel_key(Channel::Axes);
        assert_eq!(source.frame(at(1), &[]), Err(Rejection::Truncated));
        let foreign = frame(&key, &other, 1, 0.0);
        assert_eq!(source.frame(at(1), &foreign), Err(Rejection::ForeignSender));
        assert!(source.motion(1).is_none());
        source.frame(at(1), &frame(&key, &node, 1, 7.0)).unwrap();
        assert_eq!(source.motion(1).unwrap().1.position, 7.0);
        assert!(source.motion(2).is_none());
    }
}
