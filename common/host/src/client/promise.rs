//! The motion that a node has promised for its axes, from outside: when an axis will be at a position.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use coaxle_axis::motion_plan::{AwaitedPosition, PlannedPassage};
use coaxle_clock::Span;
use coaxle_node::frame::{KeySeal, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, Frame, FrameHeader, Intake, Rejection};
use coaxle_os::machine;
use coaxle_remote::{PlannedMotion, ReceivedPlan};

use crate::network::transport::{Declared, Transport};

/// Promised motions of a node's axes: its plans, each confirmed by a frame before it is used.
#[derive(Debug)]
pub struct PromisedAxes {
    seal: KeySeal,
    sender: u32,
    ids: Box<[u32]>,
    motions: Box<[PlannedMotion]>,
    /// The newest frame of the run that is followed.
    newest: Option<FrameHeader>,
}

impl PromisedAxes {
    /// Follows the axes `ids` of a node.
    #[must_use]
    pub fn new(node: &NodeName, ids: &[u32]) -> Self {
        Self {
            seal: KeySeal::new(&node.channel_key(Channel::Plans)),
            sender: sender_id(node),
            ids: ids.into(),
            motions: ids.iter().map(|_| PlannedMotion::default()).collect(),
            newest: None,
        }
    }

    /// Takes a frame of the axes, in the order of their ids. One of another run ends all promises.
    pub fn take_frame(&mut self, frame: &Frame<'_>) {
        let header = frame.header;
        if self
            .newest
            .is_none_or(|newest| newest.epoch != header.epoch)
        {
            self.motions.iter_mut().for_each(PlannedMotion::clear);
            self.newest = None;
        }
        if self
            .newest
            .is_some_and(|newest| newest.count >= header.count)
        {
            return;
        }
        self.newest = Some(header);
        for (motion, sample) in self.motions.iter_mut().zip(frame.axes) {
            if let Some(sample) = sample {
                // A contradiction ends the use of the plan, which is all that can be done about it.
                let _ = motion.check(instant_of(&header), &sample.set);
            }
        }
    }

    /// Takes a message of plans.
    ///
    /// # Errors
    /// [`Rejection`] of the message. A faulty plan in it is left out.
    pub fn take_plans(&mut self, payload: &[u8]) -> Result<(), Rejection> {
        let mut plans = Vec::new();
        let header = self.seal.open_plans(payload, |id, plan| {
            let place = self.ids.iter().position(|own| *own == id);
            plans.extend(place.zip(plan.ok()));
        })?;
        if header.sender != self.sender {
            return Err(Rejection::ForeignSender);
        }
        // Plans of a run whose frames are not followed would be checked by nothing.
        if self
            .newest
            .is_none_or(|newest| newest.epoch != header.epoch)
        {
            return Ok(());
        }
        for (place, plan) in plans {
            // As above: the fault has ended the use of the plan.
            let _ = self.motions[place].take(&ReceivedPlan {
                count: header.count,
                pieces: plan.pieces(),
                promised_until: plan.promised_until(),
            });
        }
        Ok(())
    }

    /// Returns the instant of the newest frame; none before the first.
    #[must_use]
    pub fn newest(&self) -> Option<Span> {
        self.newest.as_ref().map(instant_of)
    }

    /// Returns the end of the promise of an axis, by its place among the ids; none without one.
    #[must_use]
    pub fn promised_until(&self, place: usize) -> Option<Span> {
        self.motions.get(place)?.known_until()
    }

    /// Returns the first arrival of an axis at a position from an instant on; none within the promise.
    #[must_use]
    pub fn passage(
        &self,
        place: usize,
        from: Span,
        position: &AwaitedPosition,
    ) -> Option<PlannedPassage> {
        let motion = self.motions.get(place)?;
        motion.passage(from, motion.known_until()?, position)
    }
}

/// Generation instant of a frame.
fn instant_of(header: &FrameHeader) -> Span {
    header.cycle_time.span() * header.count.cast_signed()
}

/// Subscription to the plans of one axis of a node, and to its frames.
pub struct PromiseReader {
    shared: Arc<SharedPromise>,
    _declared: [Declared; 2],
}

#[derive(Debug)]
struct SharedPromise {
    axes: Mutex<PromisedAxes>,
    changed: Condvar,
}

/// Answer to the question when an axis will be at a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PromisedArrival {
    /// No frame of the axis came.
    NoFrame,
    /// Frames came, and no plan that they confirm.
    NoPromise,
    /// The axis does not come there within its promise, which ends this time after its newest frame.
    Beyond {
        /// The time.
        promised: Span,
    },
    /// The axis comes there.
    Comes {
        /// Time from the newest frame to the arrival.
        after: Span,
        /// Velocity then, u/s.
        velocity: f64,
    },
}

impl SharedPromise {
    fn lock(&self) -> MutexGuard<'_, PromisedAxes> {
        // Each frame and each plan is taken as a whole: a panic between two leaves nothing half done.
        self.axes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl PromiseReader {
    /// Subscribes over a transport.
    ///
    /// # Errors
    /// The transport refuses.
    pub fn over(transport: &dyn Transport, node: &NodeName, axis: u32) -> anyhow::Result<Self> {
        let ids = [axis];
        let shared = Arc::new(SharedPromise {
            axes: Mutex::new(PromisedAxes::new(node, &ids)),
            changed: Condvar::new(),
        });
        let key = node.channel_key(Channel::Axes);
        let mut intake = Intake::new(&key, node, &ids);
        let taken = Arc::clone(&shared);
        let on_frame = move |_, bytes: &[u8]| {
            if let Ok(frame) = intake.accept(bytes)
                && frame.axes.iter().any(Option::is_some)
            {
                taken.lock().take_frame(&frame);
                taken.changed.notify_all();
            }
        };
        let planned = Arc::clone(&shared);
        let on_plans = move |_, bytes: &[u8]| {
            // A message of a stranger is as good as none: the answer says what is missing.
            let _ = planned.lock().take_plans(bytes);
        };
        Ok(Self {
            _declared: [
                transport.subscribe(&key, Box::new(on_frame))?,
                transport.subscribe(&node.channel_key(Channel::Plans), Box::new(on_plans))?,
            ],
            shared,
        })
    }

    /// Waits for a promise, at most for a time, and returns when the axis comes to a position.
    #[must_use]
    pub fn arrival(&self, position: &AwaitedPosition, patience: Span) -> PromisedArrival {
        let end = machine::now() + patience;
        let mut axes = self.shared.lock();
        loop {
            let arrival = arrival(&axes, position);
            let is_answer = matches!(
                arrival,
                PromisedArrival::Beyond { .. } | PromisedArrival::Comes { .. }
            );
            let left = end - machine::now();
            if is_answer || left <= Span::ZERO {
                return arrival;
            }
            let left = Duration::from_nanos(left.as_nanos().unsigned_abs());
            let waited = self.shared.changed.wait_timeout(axes, left);
            axes = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

/// Arrival of the only axis.
fn arrival(axes: &PromisedAxes, position: &AwaitedPosition) -> PromisedArrival {
    let Some(now) = axes.newest() else {
        return PromisedArrival::NoFrame;
    };
    let Some(until) = axes.promised_until(0) else {
        return PromisedArrival::NoPromise;
    };
    match axes.passage(0, now, position) {
        Some(passage) => PromisedArrival::Comes {
            after: passage.at - now,
            velocity: passage.state.velocity,
        },
        None => PromisedArrival::Beyond {
            promised: until - now,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_axis::NcToPlcAxis;
    use coaxle_axis::motion_plan::{MotionPiece, MotionPlan};
    use coaxle_clock::{CycleIndex, CycleTime};
    use coaxle_curve::profile::{Kinematics, Limits};
    use coaxle_node::frame::{body_capacity, encode_body, sender_id};
    use coaxle_node::plan::{PLANS_CAPACITY, encode_plans};
    use coaxle_node::{AxisPlan, RunCycle};

    use crate::network::transport::{InProcess, Publisher, Urgency};

    const CYCLE: Span = Span::from_millis(1);

    /// A node whose axis 7 moves at 500 u/s from 0 on.
    struct Belt {
        frames: Box<dyn Publisher>,
        plans: Box<dyn Publisher>,
        name: NodeName,
    }

    impl Belt {
        fn new(transport: &InProcess) -> Self {
            let name = NodeName::new("belt").unwrap();
            let publisher = |channel| {
                transport
                    .publisher(&name.channel_key(channel), Urgency::Ordinary)
                    .unwrap()
            };
            Self {
                frames: publisher(Channel::Axes),
                plans: publisher(Channel::Plans),
                name,
            }
        }

        fn frame(&self, epoch: u64, count: u64) {
            let header = FrameHeader {
                sender: sender_id(&self.name),
                epoch,
                index: CycleIndex(count as u16),
                count,
                cycle_time: CycleTime::new(CYCLE).unwrap(),
                present_after: None,
                send_stamp: None,
            };
            let axis = NcToPlcAxis {
                axis_id: 7,
                set_position: 0.5 * count as f64,
                set_velocity: 500.0,
                ..NcToPlcAxis::default()
            };
            let mut body = vec![0; body_capacity(1)];
            let length = encode_body(&header, &[axis], &mut body).unwrap();
            self.publish(&*self.frames, Channel::Axes, &body[..length]);
        }

        /// The plan of a cycle: 300 ms are promised.
        fn plan(&self, epoch: u64, count: u64) {
            let start = CYCLE * count as i64;
            let piece = MotionPiece {
                start,
                duration: Span::from_secs(10),
                from: Kinematics {
                    position: 0.5 * count as f64,
                    velocity: 500.0,
                    acceleration: 0.0,
                },
                jerk: 0.0,
            };
            let limits = Limits::new(1e3, 1e4, 1e4, 1e5).unwrap();
            let promised = start + Span::from_millis(300);
            let plan = MotionPlan::new(&[piece], promised, &limits).unwrap();
            let header = RunCycle {
                sender: sender_id(&self.name),
                epoch,
                count,
            };
            let mut body = [0; PLANS_CAPACITY];
            let plans = [AxisPlan { axis_id: 7, plan }];
            let length = encode_plans(&header, &plans, &mut body);
            self.publish(&*self.plans, Channel::Plans, &body[..length]);
        }

        fn publish(&self, publisher: &dyn Publisher, channel: Channel, body: &[u8]) {
            let seal = KeySeal::new(&self.name.channel_key(channel));
            let mut message = Vec::new();
            seal.seal(body, None, &mut message);
            publisher.publish(message).unwrap();
        }
    }

    fn at(position: f64) -> AwaitedPosition {
        AwaitedPosition {
            position,
            modulo: None,
            direction: None,
        }
    }

    #[test]
    fn an_arrival_is_that_of_a_plan_that_a_frame_has_confirmed() {
        let transport = InProcess::default();
        let belt = Belt::new(&transport);
        let reader = PromiseReader::over(&transport, &belt.name, 7).unwrap();
        let ask = |position| reader.arrival(&at(position), Span::ZERO);
        assert_eq!(ask(50.0), PromisedArrival::NoFrame);
        belt.plan(1, 9);
        belt.frame(1, 10);
        assert_eq!(ask(50.0), PromisedArrival::NoPromise);
        belt.plan(1, 10);
        // Nothing has confirmed it yet.
        assert_eq!(ask(50.0), PromisedArrival::NoPromise);
        belt.frame(1, 12);
        let comes = PromisedArrival::Comes {
            after: Span::from_millis(88),
            velocity: 500.0,
        };
        assert_eq!(ask(50.0), comes);
        let promised = Span::from_millis(298);
        assert_eq!(ask(160.0), PromisedArrival::Beyond { promised });
        assert_eq!(ask(5.0), PromisedArrival::Beyond { promised });
        // Another run has promised nothing.
        belt.frame(2, 12);
        assert_eq!(ask(50.0), PromisedArrival::NoPromise);
    }
}
