//! Axes of another node, in the clock of this machine.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use anyhow::Context;
use coaxle_axis::motion_plan::AwaitedPosition;
use coaxle_axis::{Modulo, TravelDirection};
use coaxle_clock::far_clock::{DelaySource, FarClock, FarReading};
use coaxle_clock::observer::ObserverParameters;
use coaxle_clock::{CycleTime, Instant, Seconds, Span};
use coaxle_host::client::PromisedAxes;
use coaxle_host::network::transport::{Declared, Transport};
use coaxle_node::Message;
use coaxle_node::keys::NodeName;
use coaxle_os::machine::local;
use coaxle_os::{Machine, machine};
use coaxle_wire::exchange::{TIME_REQUEST_CAPACITY, encode_time_request};
use coaxle_wire::frame::sender_id;
use coaxle_wire::{AxisSample, Channel, Frame, Intake, Reader};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{told, wrong};
use crate::publish::{Sealed, check_ids};

/// Time without frames after which another run of the node is followed.
const SILENCE: Span = Span::from_millis(250);

/// Follows axes of a node: receives frames, and calculates the present positions.
#[pyclass(module = "coaxle")]
pub(crate) struct Follower {
    ids: Vec<u32>,
    shared: Arc<Shared>,
    declared: Vec<Declared>,
}

struct Shared {
    followed: Mutex<Followed>,
    came: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Followed> {
        // A panic in a callback leaves complete values behind: each field is set by itself.
        self.followed.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// State of the followed node.
struct Followed {
    /// The own run: responses to other runs are not for it.
    run: u64,
    requester: u32,
    requests: Sealed,
    clock: Option<(CycleTime, FarClock)>,
    is_sure: bool,
    newest: Option<Newest>,
    promised: PromisedAxes,
    frames: u64,
    rejected: u64,
}

/// The newest frame of the run that is followed.
struct Newest {
    at: Instant<Machine>,
    /// Generation: count times the nominal cycle, by which the clock counts.
    sent: Span,
    epoch: u64,
    count: u64,
    axes: Vec<Option<AxisSample>>,
}

/// Time until an axis comes to a position, s, the position, u, and its velocity then, u/s.
type PlannedArrival = (f64, f64, f64);

#[pymethods]
impl Follower {
    /// Waits until this number of further frames came, or the time passed. Returns whether they came.
    fn wait(&self, py: Python<'_>, frames: u64, within_s: f64) -> PyResult<bool> {
        // Further ones from now on, whatever came before the call.
        let wanted = self.shared.lock().frames.saturating_add(frames);
        let end = machine::now() + crate::clock::span("within_s", within_s)?;
        loop {
            // Python runs its signal handlers here alone: without it Ctrl-C would act at the end only.
            py.check_signals()?;
            // Without the interpreter's lock: other threads of Python run on while this one waits.
            if py.detach(|| self.glance(wanted, end)) {
                return Ok(true);
            }
            if machine::now() >= end {
                return Ok(false);
            }
        }
    }

    /// Present motion of each axis by its id: position, velocity, acceleration, state word, error code, or None if it did
    /// not come; with age and uncertainty. None before a frame has come.
    fn read<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let now = machine::now();
        let followed = self.shared.lock();
        let Some((newest, age)) = followed.newest_at(now) else {
            return Ok(None);
        };
        let far = followed.far_time_at(now);
        let axes = PyDict::new(py);
        for (id, sample) in self.ids.iter().zip(&newest.axes) {
            let now = sample.map(|sample| {
                let set = sample.set.after(age.0, 0.0);
                let state = sample.state_word.bits();
                (
                    set.position,
                    set.velocity,
                    set.acceleration,
                    state,
                    sample.error_code,
                )
            });
            axes.set_item(id, now)?;
        }
        let read = PyDict::new(py);
        read.set_item("axes", axes)?;
        read.set_item("is_sure", followed.is_sure)?;
        read.set_item("age_s", age.0)?;
        read.set_item("uncertainty_s", far.map(|far| far.uncertainty.0))?;
        read.set_item("silent_s", (now - newest.at).as_secs_f64())?;
        read.set_item("cycle", newest.count)?;
        read.set_item("epoch", format!("{:016x}", newest.epoch))?;
        read.set_item("frames", followed.frames)?;
        read.set_item("rejected", followed.rejected)?;
        Ok(Some(read))
    }

    /// First arrival of an axis at a position from now on: time until then, s, position and velocity, or None within the promise of its
    /// node; and the time until that ends, s, or None without a promise.
    #[pyo3(signature = (axis, position, direction, modulo))]
    fn when(
        &self,
        axis: u32,
        position: f64,
        direction: Option<&str>,
        modulo: Option<f64>,
    ) -> PyResult<(Option<PlannedArrival>, Option<f64>)> {
        let place = self.ids.iter().position(|id| *id == axis);
        let place = place.ok_or_else(|| {
            wrong(format!(
                "axis: received {axis}, expected one of {:?}",
                self.ids
            ))
        })?;
        if !position.is_finite() {
            return Err(wrong(format!(
                "position: received {position}, expected a finite number"
            )));
        }
        let awaited = AwaitedPosition {
            position,
            modulo: modulo
                .map(Modulo::new)
                .transpose()
                .map_err(|error| wrong(format!("modulo: {error}")))?,
            direction: direction.map(travel_direction).transpose()?,
        };
        let now = machine::now();
        let followed = self.shared.lock();
        let Some((newest, age)) = followed.newest_at(now) else {
            return Ok((None, None));
        };
        let now = newest.sent + age.to_span();
        let promised = followed.promised.promised_until(place);
        let passage = followed.promised.passage(place, now, &awaited);
        let arrival = passage.map(|passage| {
            let state = passage.state;
            (
                (passage.at - now).as_secs_f64(),
                state.position,
                state.velocity,
            )
        });
        Ok((arrival, promised.map(|end| (end - now).as_secs_f64())))
    }

    /// Stops receiving.
    fn close(&mut self) {
        self.declared.clear();
    }
}

/// Interval at which Python is checked for signals.
const GLANCE: Duration = Duration::from_millis(100);

impl Follower {
    pub(crate) fn open(
        transport: &Arc<dyn Transport>,
        node: &NodeName,
        own: &NodeName,
        ids: Vec<u32>,
    ) -> PyResult<Self> {
        check_ids(&ids)?;
        let open = || {
            let shared = Arc::new(Shared {
                followed: Mutex::new(Followed::new(&**transport, node, own, &ids)?),
                came: Condvar::new(),
            });
            let mut intake = Intake::new(&node.channel_key(Channel::Axes), node, &ids);
            let for_frames = Arc::clone(&shared);
            let on_frame = move |at, bytes: &[u8]| {
                let mut followed = for_frames.lock();
                match intake.accept(bytes) {
                    Ok(frame) => followed.take(at, &frame),
                    Err(_) => followed.rejected += 1,
                }
                for_frames.came.notify_all();
            };
            let mut reader = Reader::time_responses_of(node, own);
            let for_responses = Arc::clone(&shared);
            let on_response = move |at, bytes: &[u8]| {
                reader.read(bytes, |message| {
                    if let Message::TimeResponse(response) = message
                        && let Some((_, clock)) = &mut for_responses.lock().clock
                    {
                        clock.response(local(at), response);
                    }
                });
            };
            let for_plans = Arc::clone(&shared);
            let on_plans = move |_, bytes: &[u8]| {
                // A message of a stranger counts as one that was refused.
                let mut followed = for_plans.lock();
                if followed.promised.take_plans(bytes).is_err() {
                    followed.rejected += 1;
                }
            };
            let responses = node.channel_key(Channel::TimeResponses);
            Ok(Self {
                declared: vec![
                    // Responses first: the first frame already causes a request, whose response must be heard.
                    transport.subscribe(&responses, Box::new(on_response))?,
                    transport.subscribe(&node.channel_key(Channel::Axes), Box::new(on_frame))?,
                    transport.subscribe(&node.channel_key(Channel::Plans), Box::new(on_plans))?,
                ],
                shared,
                ids,
            })
        };
        open().map_err(|error: anyhow::Error| told(error))
    }

    /// Waits briefly, at most until `end`. True if this number of frames has come.
    fn glance(&self, wanted: u64, end: Instant<Machine>) -> bool {
        // Past the end the difference is negative, and no time is left.
        let left = u64::try_from((end - machine::now()).as_nanos()).unwrap_or_default();
        let patience = GLANCE.min(Duration::from_nanos(left));
        let waits = |followed: &mut Followed| followed.frames < wanted;
        let waited = self
            .shared
            .came
            .wait_timeout_while(self.shared.lock(), patience, waits);
        // Asked again after waking, which a wait may do for no reason.
        waited.unwrap_or_else(PoisonError::into_inner).0.frames >= wanted
    }
}

impl Followed {
    fn new(
        transport: &dyn Transport,
        node: &NodeName,
        own: &NodeName,
        ids: &[u32],
    ) -> anyhow::Result<Self> {
        Ok(Self {
            run: getrandom::u64().context("the system gives no random run")?,
            requester: sender_id(own),
            requests: Sealed::open(transport, &node.channel_key(Channel::TimeRequests))?,
            clock: None,
            is_sure: false,
            newest: None,
            promised: PromisedAxes::new(node, ids),
            frames: 0,
            rejected: 0,
        })
    }

    /// The time of the node, if its clock is known.
    fn far_time_at(&self, now: Instant<Machine>) -> Option<FarReading> {
        let (_, clock) = self.clock.as_ref()?;
        clock.far_time_at(local(now))
    }

    /// The newest frame, and its age; none before the first.
    fn newest_at(&self, now: Instant<Machine>) -> Option<(&Newest, Seconds)> {
        let newest = self.newest.as_ref()?;
        let age = match self.far_time_at(now) {
            Some(far) => far.time.since(Instant::EPOCH + newest.sent),
            // Until the clock is known the age counts from the arrival, without the delay.
            None => Seconds((now - newest.at).as_secs_f64()),
        };
        Some((newest, age))
    }

    /// Takes a frame: its axes, and its arrival for the clock.
    fn take(&mut self, at: Instant<Machine>, frame: &Frame<'_>) {
        let header = &frame.header;
        let heard_other = |newest: &Newest| {
            // Two senders of one name would otherwise alternate, and the axes jump between them.
            newest.epoch != header.epoch && at - newest.at < SILENCE
                || newest.epoch == header.epoch && newest.count >= header.count
        };
        if self.newest.as_ref().is_some_and(heard_other) {
            self.rejected += 1;
            return;
        }
        let (cycle_time, run) = (header.cycle_time, self.run);
        let is_as_before = |(known, _): &(CycleTime, FarClock)| *known == cycle_time;
        // A node that returns with another cycle time counts in other units.
        if !self.clock.as_ref().is_some_and(is_as_before) {
            let parameters = ObserverParameters::default();
            let clock = FarClock::new(cycle_time, parameters, DelaySource::Measured, run);
            self.clock = clock.ok().map(|clock| (cycle_time, clock));
        }
        self.promised.take_frame(frame);
        self.newest = Some(Newest {
            at,
            sent: cycle_time.span() * header.count.cast_signed(),
            epoch: header.epoch,
            count: header.count,
            axes: frame.axes.to_vec(),
        });
        self.frames += 1;
        let Some((_, clock)) = &mut self.clock else {
            return;
        };
        clock.message(header.epoch, header.count, local(at), header.send_stamp);
        self.is_sure = clock.cycle(local(at), |_, _| {}).is_sure;
        // After the frame's cycle: the requester is due by the time of this machine.
        let due = clock.request(local(machine::now()));
        if let Some(number) = due {
            self.ask(number);
        }
    }

    fn ask(&self, number: u32) {
        let now = machine::now();
        let mut body = [0; TIME_REQUEST_CAPACITY];
        let length = encode_time_request(self.requester, self.run, number, local(now), &mut body);
        // A lost request is repeated.
        let _ = self.requests.send(&body[..length], now);
    }
}

fn travel_direction(name: &str) -> PyResult<TravelDirection> {
    match name {
        "forward" => Ok(TravelDirection::Forward),
        "backward" => Ok(TravelDirection::Backward),
        other => Err(wrong(format!(
            "direction: received {other:?}, expected \"forward\" or \"backward\""
        ))),
    }
}
