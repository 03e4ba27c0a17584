//! Axes that Python moves, as a node: frames at its own pace, responses to time requests, presence and status.

use std::sync::{Arc, Mutex, PoisonError};

use anyhow::Context;
use coaxle_axis::{NcToPlcAxis, StateWord};
use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleIndex, CycleTime, Instant, Span};
use coaxle_host::network::transport::{Declared, Publisher as Way, Transport, Urgency};
use coaxle_node::Message;
use coaxle_node::keys::NodeName;
use coaxle_os::machine::local;
use coaxle_os::{Machine, machine};
use coaxle_wire::frame::{KeySeal, MAX_AXES, body_capacity, encode_body, sender_id};
use coaxle_wire::{Channel, FrameHeader, Reader, TimeServer};
use pyo3::prelude::*;
use serde_json::json;

use crate::columns::numbers;
use crate::error::{told, wrong};

/// Interval of the node's status.
const STATUS_PERIOD: Span = Span::from_millis(250);

/// A node whose axes are published one cycle after the other: `wait`, then `publish`.
#[pyclass(module = "coaxle")]
pub(crate) struct Publisher {
    name: NodeName,
    run: Run,
    /// The axes as published, without their motion.
    axes: Vec<NcToPlcAxis>,
    body: Vec<u8>,
    frames: Sealed,
    status: Box<dyn Way>,
    said: Option<Instant<Machine>>,
    /// The newest cycle waited for, and whether its frame is published.
    cycle: Option<(u64, bool)>,
    published: u64,
    declared: Vec<Declared>,
}

/// A run of the node.
#[derive(Clone, Copy)]
struct Run {
    sender: u32,
    epoch: u64,
    start: Instant<Machine>,
    cycle_time: CycleTime,
}

impl Run {
    fn begin_of(&self, count: u64) -> Instant<Machine> {
        self.start + self.cycle_time.span() * count.cast_signed()
    }

    /// The cycle that an instant lies in.
    fn cycle_at(&self, now: Instant<Machine>) -> u64 {
        // Floor, not truncation: before the start the cycle is negative, and then none.
        let count = (now - self.start).div_floor(self.cycle_time.span());
        u64::try_from(count).unwrap_or_default()
    }
}

/// A publisher of frames, each with its stamp and check sum.
pub(crate) struct Sealed {
    way: Box<dyn Way>,
    seal: KeySeal,
}

impl Sealed {
    pub(crate) fn open(transport: &dyn Transport, key: &str) -> anyhow::Result<Self> {
        Ok(Self {
            way: transport.publisher(key, Urgency::RealTime)?,
            seal: KeySeal::new(key),
        })
    }

    /// Sends the frame of the cycle with this ideal start.
    pub(crate) fn send(&self, body: &[u8], ideal_start: Instant<Machine>) -> anyhow::Result<()> {
        let mut frame = Vec::new();
        // The stamp is taken last, so that it contains the time of the encoding.
        (self.seal).seal(body, Some(machine::now() - ideal_start), &mut frame);
        self.way.publish(frame)
    }
}

#[pymethods]
impl Publisher {
    /// Sleeps until the next cycle begins. Returns its number, and its beginning, s since the start. Missed cycles are skipped.
    fn wait(&mut self, py: Python<'_>) -> PyResult<(u64, f64)> {
        let now = machine::now();
        let last = self.cycle.map_or(0, |(count, _)| count);
        // Missed cycles are skipped: caught up, they would reach receivers as a burst of old data.
        let next = (self.run.cycle_at(now) + 1).max(last + 1);
        let begin = self.run.begin_of(next);
        py.detach(|| machine::sleep_until(begin));
        py.check_signals()?;
        self.cycle = Some((next, false));
        Ok((next, (begin - self.run.start).as_secs_f64()))
    }

    /// Publishes the state of the axes in the cycle waited for: positions, velocities, accelerations, in the order of
    /// the ids, and the code of an error, 0 without one.
    fn publish(
        &mut self,
        py: Python<'_>,
        positions: &[u8],
        velocities: &[u8],
        accelerations: &[u8],
        error_code: u32,
    ) -> PyResult<()> {
        // Two frames of one count would be refused by receivers as repeated.
        let Some((count, false)) = self.cycle else {
            return Err(wrong(
                "received axes twice in a cycle, expected wait() before each",
            ));
        };
        let set = [
            ("positions", positions),
            ("velocities", velocities),
            ("accelerations", accelerations),
        ];
        for (field, bytes) in set {
            self.set(field, &numbers(bytes)?)?;
        }
        for axis in &mut self.axes {
            axis.error_code = error_code;
            axis.state_word.set(StateWord::ERROR, error_code != 0);
            axis.state_word
                .set(StateWord::NOT_MOVING, axis.set_velocity == 0.0);
            axis.state_word
                .set(StateWord::POSITIVE_DIRECTION, axis.set_velocity > 0.0);
            axis.state_word
                .set(StateWord::NEGATIVE_DIRECTION, axis.set_velocity < 0.0);
        }
        // Before sending: a failed send is not tried again with the same count.
        self.cycle = Some((count, true));
        py.detach(|| self.send(count)).map_err(told)
    }

    /// Number of frames published.
    fn published(&self) -> u64 {
        self.published
    }

    /// Removes the node from the network.
    fn close(&mut self) {
        self.declared.clear();
    }
}

impl Publisher {
    pub(crate) fn open(
        transport: &Arc<dyn Transport>,
        name: NodeName,
        cycle_time: CycleTime,
        ids: &[u32],
    ) -> PyResult<Self> {
        check_ids(ids)?;
        Self::declare(transport, name, cycle_time, ids).map_err(told)
    }

    fn declare(
        transport: &Arc<dyn Transport>,
        name: NodeName,
        cycle_time: CycleTime,
        ids: &[u32],
    ) -> anyhow::Result<Self> {
        let run = Run {
            sender: sender_id(&name),
            epoch: getrandom::u64().context("the system gives no random epoch")?,
            start: machine::now(),
            cycle_time,
        };
        let axis = |&axis_id: &u32| NcToPlcAxis {
            axis_id,
            state_word: StateWord::OPERATIONAL | StateWord::HOMED,
            ..NcToPlcAxis::default()
        };
        let responses = Sealed::open(&**transport, &name.channel_key(Channel::TimeResponses))?;
        Ok(Self {
            run,
            axes: ids.iter().map(axis).collect(),
            body: vec![0; body_capacity(ids.len())],
            frames: Sealed::open(&**transport, &name.channel_key(Channel::Axes))?,
            status: transport.publisher(&name.status_key(), Urgency::Ordinary)?,
            said: None,
            cycle: None,
            published: 0,
            declared: vec![
                respond(&**transport, &name, run, responses)?,
                // After its server: a node that is seen can be asked.
                transport.announce(&name.alive_key())?,
                transport.announce(&name.run_key(run.epoch))?,
            ],
            name,
        })
    }

    fn set(&mut self, field: &str, values: &[f64]) -> PyResult<()> {
        if values.len() != self.axes.len() {
            return Err(wrong(format!(
                "{field}: received {}, expected {}, one for each axis",
                values.len(),
                self.axes.len()
            )));
        }
        for (axis, value) in self.axes.iter_mut().zip(values) {
            let place = match field {
                "positions" => &mut axis.set_position,
                "velocities" => &mut axis.set_velocity,
                _ => &mut axis.set_acceleration,
            };
            *place = *value;
            // Receivers would refuse it; here the error names the axis.
            if !value.is_finite() || value.abs() > NcToPlcAxis::LARGEST {
                let id = axis.axis_id;
                let largest = NcToPlcAxis::LARGEST;
                return Err(wrong(format!(
                    "{field}: received {value} for axis {id}, expected a number of at most {largest:e}"
                )));
            }
        }
        Ok(())
    }

    fn send(&mut self, count: u64) -> anyhow::Result<()> {
        for axis in &mut self.axes {
            axis.actual_position = axis.set_position;
            axis.actual_velocity = axis.set_velocity;
        }
        let header = FrameHeader {
            sender: self.run.sender,
            epoch: self.run.epoch,
            // The lower 16 bits: the index of a PLC wraps.
            index: CycleIndex(count as u16),
            count,
            cycle_time: self.run.cycle_time,
            present_after: None,
            send_stamp: None,
        };
        let length = encode_body(&header, &self.axes, &mut self.body)?;
        self.frames
            .send(&self.body[..length], self.run.begin_of(count))?;
        self.published += 1;
        self.say(count)
    }

    /// Publishes the status when it is due.
    fn say(&mut self, count: u64) -> anyhow::Result<()> {
        let now = machine::now();
        if self.said.is_some_and(|said| now - said < STATUS_PERIOD) {
            return Ok(());
        }
        self.said = Some(now);
        let has_error = self.axes.iter().any(|axis| axis.error_code != 0);
        let status = json!({
            "node": self.name.as_str(),
            "role": "sender",
            "health": if has_error { "axis-error" } else { "ok" },
            "epoch": format!("{:016x}", self.run.epoch),
            "uptime_s": (now - self.run.start).as_secs_f64(),
            "cycle": count,
            "cycle_time_us": self.run.cycle_time.span().as_micros_f64(),
            "published": self.published,
        });
        self.status.publish(status.to_string().into_bytes())
    }
}

/// Responds to time requests, from any thread.
fn respond(
    transport: &dyn Transport,
    name: &NodeName,
    run: Run,
    responses: Sealed,
) -> anyhow::Result<Declared> {
    let start = local(run.start);
    let server = TimeServer::new(run.sender, run.epoch, start, run.cycle_time);
    let server = Mutex::new(server);
    let mut reader = Reader::time_requests_to(name);
    let on_request = move |at, bytes: &[u8]| {
        reader.read(bytes, |message| {
            let Message::TimeRequest(request) = message else {
                return;
            };
            let mut server = server.lock().unwrap_or_else(PoisonError::into_inner);
            // Received and responded to at once, in the thread of the transport: Python may be busy for long.
            server.receive(local(at), request);
            let now = machine::now();
            let count = run.cycle_at(now);
            let tick = Tick {
                count,
                ideal_start: local(run.begin_of(count)),
                elapsed: 1,
            };
            server.respond(&tick, local(now));
            if let Some(outgoing) = server.transmit() {
                // A requester repeats a lost request.
                let _ = responses.send(outgoing.body, run.begin_of(count));
            }
        });
    };
    transport.subscribe(
        &name.channel_key(Channel::TimeRequests),
        Box::new(on_request),
    )
}

/// Ids of axes that a frame can hold.
pub(crate) fn check_ids(ids: &[u32]) -> PyResult<()> {
    let received = ids.len();
    if !(1..=MAX_AXES).contains(&received) {
        let expected = format!("expected 1 to {MAX_AXES}");
        return Err(wrong(format!("axes: received {received}, {expected}")));
    }
    let mut places = ids.iter().enumerate();
    match places.find(|(n, id)| ids[..*n].contains(id)) {
        Some((_, id)) => Err(wrong(format!(
            "axes: received {id} twice, expected each once"
        ))),
        None => Ok(()),
    }
}
