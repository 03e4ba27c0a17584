//! The sender seen from outside: cycles in, frames out.

use coaxle_axis::motion_plan::MotionPlan;
use coaxle_axis::{AxisState, CoupleState, NcToPlcAxis, StateWord};
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::{CycleIndex, Instant, Local, Seconds, Span};
use coaxle_node::beacon::{BeaconSeal, Departure};
use coaxle_node::config::parse;
use coaxle_node::frame::{FrameHeader, KeySeal, decode, seal, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{BeaconRequest, Channel, Message, Node, Reader, Rejection, Stamps, TimeRequest};
use coaxle_sender::Sender;
use coaxle_sender::config::SenderConfig;

// Not 0, so that instants and times since the start cannot be confused.
const START: Instant<Local> = Instant::from_nanos(5_000_000_000);
const EPOCH: u64 = 0xC0A_C1E;

fn axis(id: u32, velocity: f64) -> String {
    format!(
        "[[axis]]\nid = {id}\nname = 'axis {id}'\nprogram = {{ start-velocity = {velocity:?}, \
         limits = {{ velocity = 1000, acceleration = 1000, jerk = 1000 }} }}\n"
    )
}

fn sender(axes: &str) -> Sender {
    let text = format!("name = 'test'\ncycle-time-us = 1000\n{axes}");
    let config: SenderConfig = parse("s.toml", &text).expect("valid");
    Sender::new(&config, START, EPOCH).expect("valid")
}

/// Runs the cycle that is due and opens the frame it sends.
fn tick(sender: &mut Sender, now: Instant<Local>) -> (FrameHeader, Vec<NcToPlcAxis>) {
    let taken = sender.cycle(now);
    let outgoing = sender.transmit().expect("each cycle sends a frame");
    assert_eq!(outgoing.channel, Channel::Axes);
    assert_eq!(outgoing.ideal_start, taken.ideal_start);
    let mut frame = Vec::new();
    seal("coaxle/test/axes", outgoing.body, None, &mut frame);
    let mut axes = Vec::new();
    let header = decode("coaxle/test/axes", &frame, |axis| axes.push(*axis)).expect("a frame");
    assert!(sender.transmit().is_none(), "a frame is sent once");
    (header, axes)
}

#[test]
fn a_frame_says_who_when_and_where() {
    let mut sender = sender(&axis(3, 500.0));
    assert!(
        sender.transmit().is_none(),
        "nothing to send before the first cycle"
    );
    assert_eq!(sender.next_cycle(), START);
    let _ = tick(&mut sender, START);
    assert_eq!(sender.next_cycle(), START + Span::from_millis(1));
    let (header, axes) = tick(&mut sender, START + Span::from_micros(1_030));

    assert_eq!(header.sender, sender_id(&NodeName::new("test").unwrap()));
    assert_eq!(header.epoch, EPOCH);
    assert_eq!((header.count, header.index), (1, CycleIndex(1)));
    assert_eq!(header.cycle_time.span(), Span::from_millis(1));

    let axis = axes[0];
    assert_eq!(axes, sender.axes());
    assert_eq!(axis.axis_id, 3);
    // Position of the axis at the ideal start, not at the wake-up of the node.
    assert_eq!(axis.set_position, 0.5);
    assert_eq!(axis.actual_position, 0.5);
    assert_eq!((axis.set_velocity, axis.actual_velocity), (500.0, 500.0));
    assert_eq!(axis.axis_state, AxisState::ConstantVelocity);
    assert_eq!(axis.couple_state, CoupleState::Master);
    assert!(
        axis.state_word
            .contains(StateWord::OPERATIONAL | StateWord::CONSTANT_VELOCITY)
    );
}

#[test]
fn time_requests_are_answered_in_the_next_cycle() {
    let mut sender = sender(&axis(1, 500.0));
    let _ = tick(&mut sender, START);
    let request = TimeRequest {
        requester: sender_id(&NodeName::new("saw").unwrap()),
        run: 6,
        number: 3,
        requested: 42,
    };
    let received = Span::from_micros(1_700);
    sender.receive(START + received, 0, &Message::TimeRequest(request));
    sender.receive(START, 0, &Message::Rejected(Rejection::Malformed));
    let taken = sender.cycle(START + Span::from_micros(2_010));
    let axes = sender.transmit().expect("axes first").channel;
    assert_eq!(axes, Channel::Axes);
    let outgoing = sender.transmit().expect("then the response");
    assert_eq!(outgoing.channel, Channel::TimeResponses);
    assert_eq!(outgoing.ideal_start, taken.ideal_start);
    let node = NodeName::new("test").unwrap();
    let mut frame = Vec::new();
    let stamp = Some(Span::from_micros(60));
    let key = node.channel_key(Channel::TimeResponses);
    seal(&key, outgoing.body, stamp, &mut frame);
    let mut responses = Vec::new();
    Reader::time_responses_of(&node, &NodeName::new("saw").unwrap())
        .read(&frame, |message| responses.push(message.split().0));
    let response = TimeResponse {
        run: 6,
        number: 3,
        requested: Instant::from_nanos(42),
        epoch: EPOCH,
        received,
        // The ideal start of cycle 2 and the stamp of 60 µs.
        responded: Span::from_micros(2_060),
    };
    assert_eq!(responses, [Message::TimeResponse(response)]);
    let shown = sender.snapshot().signals.node;
    assert_eq!((shown.requests_answered, shown.requests_refused), (1, 1));
}

#[test]
fn beacons_are_answered_in_the_next_cycle_where_there_is_a_timing_channel() {
    let mut sender = sender(&format!(
        "timing = {{ listen = '127.0.0.1:1' }}\n{}",
        axis(1, 5.0)
    ));
    let _ = tick(&mut sender, START);
    let request = BeaconRequest {
        requester: sender_id(&NodeName::new("saw").unwrap()),
        run: 6,
        number: 3,
        requested: 42,
        ..BeaconRequest::default()
    };
    let received = Span::from_micros(700);
    sender.receive(START + received, 1, &Message::BeaconRequest(request));
    sender.receive(START, 1, &Message::Rejected(Rejection::WrongChecksum));
    let taken = sender.cycle(START + Span::from_micros(1_010));
    assert_eq!(
        sender.transmit().expect("axes first").channel,
        Channel::Axes
    );
    let outgoing = sender.transmit().expect("then the answer");
    assert_eq!(outgoing.channel, Channel::BeaconResponses);
    assert_eq!(outgoing.ideal_start, taken.ideal_start);
    let node = NodeName::new("test").unwrap();
    let departure = Departure {
        left: Span::from_micros(60),
        stamps: Stamps::Kernel,
        before: None,
        common: None,
    };
    let mut frame = Vec::new();
    let seal = BeaconSeal::new(&node.channel_key(Channel::BeaconResponses));
    seal.seal(outgoing.body, &departure, &mut frame);
    let (_, answer) = seal.open_response(&frame).expect("a good answer");
    assert_eq!((answer.epoch, answer.request), (EPOCH, request));
    assert_eq!(answer.received, received);
    // Cycle 1 and the stamp.
    assert_eq!(answer.responded, Span::from_micros(1_060));
    assert!(sender.transmit().is_none());
    let _ = tick(&mut sender, START + Span::from_millis(2));
    let shown = sender.snapshot().signals.node;
    assert_eq!((shown.beacons_answered, shown.beacons_refused), (1, 1));
    assert_eq!(shown.requests_refused, 0);
}

#[test]
fn the_index_wraps_and_the_count_does_not() {
    let mut sender = sender(&axis(1, 500.0));
    for k in 0..65_540_i64 {
        let (header, axes) = tick(&mut sender, START + Span::from_millis(k));
        assert_eq!(header.count, k as u64);
        assert_eq!(header.index, CycleIndex((k % 65_536) as u16));
        assert_eq!(axes[0].set_velocity, 500.0);
    }
    // 65 539 - 65 536.
    assert_eq!(sender.snapshot().signals.node.index, 3);
    assert_eq!(sender.snapshot().signals.node.cycle, 65_539);
}

#[test]
fn an_overrun_skips_cycles_index_and_motion_alike() {
    let mut sender = sender(&axis(1, 500.0));
    let _ = tick(&mut sender, START);
    let (header, axes) = tick(&mut sender, START + Span::from_micros(7_400));
    assert_eq!((header.count, header.index), (7, CycleIndex(7)));
    // 7 ms at 500 u/s.
    assert_eq!(axes[0].set_position, 3.5);
    let snapshot = sender.snapshot();
    assert_eq!(snapshot.signals.node.overruns, 6);
    assert_eq!(snapshot.ideal_start, START + Span::from_millis(7));
    assert_eq!(snapshot.woke, START + Span::from_micros(7_400));
    // No burst: the next cycle is the next one.
    assert_eq!(sender.next_cycle(), START + Span::from_millis(8));
}

#[test]
fn many_axes_share_a_frame_in_the_order_of_their_ids() {
    // Written in the reverse order, which the frame does not keep.
    let axes: String = (1..=32).rev().map(|id| axis(id, f64::from(id))).collect();
    let mut sender = sender(&axes);
    let _ = tick(&mut sender, START);
    let (_, axes) = tick(&mut sender, START + Span::from_millis(1));
    assert_eq!(axes.len(), 32);
    for (axis, id) in axes.iter().zip(1..) {
        assert_eq!(axis.axis_id, id);
        assert_eq!(axis.set_velocity, f64::from(id));
    }
    let shown: Vec<_> = sender.snapshot().axes().map(|(id, _)| id).collect();
    assert_eq!(shown, [1, 2, 3, 4]);
}

#[test]
fn the_config_chooses_the_axes_that_are_shown() {
    let axes: String = (1..=32).map(|id| axis(id, f64::from(id))).collect();
    let mut sender = sender(&format!("show-axes = [32, 7]\n{axes}"));
    let _ = tick(&mut sender, START);
    let shown = sender.snapshot().axes();
    let motions: Vec<_> = shown.map(|(id, axis)| (id, axis.velocity)).collect();
    assert_eq!(motions, [(32, 32.0), (7, 7.0)]);
}

#[test]
fn an_axis_that_is_to_be_shown_must_exist() {
    let text = format!(
        "name = 'test'\ncycle-time-us = 1000\nshow-axes = [2, 9]\n{}{}",
        axis(1, 1.0),
        axis(2, 1.0)
    );
    let config: SenderConfig = parse("s.toml", &text).expect("valid");
    let error = Sender::new(&config, START, EPOCH).err().expect("refused");
    assert_eq!(
        error.to_string(),
        "show-axes: received id 9, expected ids of the sender's axes: [1, 2]"
    );
}

#[test]
fn a_frame_is_as_large_as_the_config_allows() {
    let axes: String = (1..=128)
        // Ids and velocities of the greatest encoded length.
        .map(|id| axis(id + 4_000_000_000, -999.9))
        .collect();
    let mut sender = sender(&axes);
    assert_eq!(tick(&mut sender, START).1.len(), 128);
}

#[test]
fn before_it_is_enabled_an_axis_stands_at_its_start() {
    let mut sender = sender(
        "[[axis]]\nid = 1\nname = 'x'\nmodulo = 360.0\n[axis.program]\nstart-position = 370.0\n\
         limits = { velocity = 1, acceleration = 1, jerk = 1 }\n\
         steps = [{ dwell = { for-s = 0.002 } }, { enable = true }]",
    );
    let (_, axes) = tick(&mut sender, START);
    let axis = axes[0];
    assert_eq!(axis.state_word, StateWord::HOMED | StateWord::NOT_MOVING);
    assert_eq!(axis.axis_state, AxisState::Inactive);
    assert_eq!(axis.set_position, 370.0);
    // 370 is one turn of 360 and 10.
    assert_eq!((axis.modulo_set_position, axis.modulo_set_turns), (10.0, 1));
    assert_eq!(
        (axis.modulo_actual_position, axis.modulo_actual_turns),
        (10.0, 1)
    );
    let (_, axes) = tick(&mut sender, START + Span::from_millis(2));
    assert!(axes[0].state_word.contains(StateWord::OPERATIONAL));
}

#[test]
fn an_encoder_shows_its_increments_and_the_snapshot_the_truth() {
    let mut sender = sender(
        "[[axis]]\nid = 1\nname = 'x'\n[axis.encoder]\nresolution = 0.2\n\
         [axis.encoder.program]\nstart-velocity = 500.0\n\
         limits = { velocity = 500, acceleration = 1, jerk = 1 }",
    );
    let _ = tick(&mut sender, START);
    let (_, axes) = tick(&mut sender, START + Span::from_millis(1));
    // At 0.5 two increments of 0.2 have been passed, in one cycle of a millisecond.
    assert_eq!(axes[0].set_position, 0.4);
    assert_eq!(axes[0].actual_position, 0.4);
    assert!((axes[0].set_velocity - 400.0).abs() < 1e-9);
    assert_eq!(axes[0].set_acceleration, 0.0);
    let truth = sender.snapshot().signals.axes[0];
    assert_eq!((truth.position, truth.velocity), (0.5, 500.0));
}

#[test]
fn a_recording_that_is_not_there_names_its_field() {
    let text = "name = 'test'\ncycle-time-us = 1000\n[[axis]]\nid = 1\nname = 'taught'\n\
                replay = { file = 'no/such.csv' }";
    let config: SenderConfig = parse("s.toml", text).unwrap();
    let error = Sender::new(&config, START, EPOCH)
        .err()
        .unwrap()
        .to_string();
    assert!(
        error.starts_with("axis[0].replay.file: no/such.csv: cannot be read: "),
        "{error}"
    );
}

/// The plans that a sender has published in a cycle, with their axis ids.
fn plans_of(sender: &mut Sender, now: Instant<Local>) -> Vec<(u32, MotionPlan)> {
    let _ = sender.cycle(now);
    let mut plans = Vec::new();
    while let Some(outgoing) = sender.transmit() {
        if outgoing.channel == Channel::Plans {
            let mut message = Vec::new();
            seal("coaxle/test/plans", outgoing.body, None, &mut message);
            let header = KeySeal::new("coaxle/test/plans")
                .open_plans(&message, |id, plan| plans.push((id, plan.expect("valid"))))
                .expect("plans");
            assert_eq!(header.epoch, EPOCH);
            assert_eq!(header.count, sender.snapshot().signals.node.cycle);
        }
    }
    plans
}

fn in_cycle(sender: &Sender) -> Instant<Local> {
    sender.next_cycle() + Span::from_micros(30)
}

#[test]
fn plans_come_with_every_decision_and_again_before_they_end() {
    let moving = "[[axis]]\nid = 3\nname = 'moving'\nlead-ms = 300\nprogram = { limits = { velocity = 1000, acceleration = 5000, \
                  jerk = 100000 }, steps = [{ enable = true }, { dwell = { for-s = 0.65 } }, { move-absolute = { position = 90 } }] }\n";
    let standing = axis(4, 0.0) + "lead-ms = 40\n";
    let without = axis(5, 10.0);
    let first = "clock = { first-count = 1000 }\n";
    let mut sender = sender(&format!("{first}{moving}{standing}{without}"));
    let mut told = [Vec::new(), Vec::new()];
    for cycle in 0..1_000 {
        let now = in_cycle(&sender);
        for (id, plan) in plans_of(&mut sender, now) {
            told[id as usize - 3].push(cycle);
            // Instants of the run begin with cycle 0.
            let at = Span::from_millis(1_000 + cycle);
            let shown = sender.axes()[id as usize - 3];
            let planned = plan.at(at, Seconds::ZERO).expect("the present");
            assert!(
                (planned.position - shown.set_position).abs() < 1e-9,
                "{cycle}"
            );
            let lead = if id == 3 { 300 } else { 40 };
            assert!(plan.promised_until() <= at + Span::from_millis(lead));
        }
    }
    // Every 100 ms, and when the move is decided, 300 ms before it begins.
    assert_eq!(told[0][..6], [0, 100, 200, 300, 350, 450]);
    // Twice in each lead.
    let expected: Vec<_> = (0..50).map(|n| 20 * n).collect();
    assert_eq!(told[1], expected);
    assert_eq!(
        sender.snapshot().signals.node.plans_published as usize,
        told[0].len() + 50
    );
}

#[test]
fn many_axes_take_turns_and_a_sender_without_a_lead_plans_nothing() {
    let axes = |rest: &str| (1..=100).map(|id| axis(id, 5.0) + rest).collect::<String>();
    let mut many = sender(&axes("present-after-ms = 50\n"));
    let mut told = vec![0; 100];
    for _ in 0..50 {
        let now = in_cycle(&many);
        let plans = plans_of(&mut many, now);
        assert!(plans.len() <= 8);
        plans.iter().for_each(|(id, _)| told[*id as usize - 1] += 1);
    }
    assert!(told.iter().all(|times| (2..=3).contains(times)), "{told:?}");
    let channels = |sender: &str| -> Vec<Channel> {
        let text = format!("name = 'test'\ncycle-time-us = 1000\n{sender}");
        let config: SenderConfig = parse("s.toml", &text).expect("valid");
        config
            .wiring()
            .publications
            .iter()
            .map(|it| it.channel)
            .collect()
    };
    assert_eq!(
        channels(&axis(1, 5.0)),
        [Channel::Axes, Channel::TimeResponses]
    );
    let planned = [Channel::Axes, Channel::TimeResponses, Channel::Plans];
    assert_eq!(channels(&(axis(1, 5.0) + "lead-ms = 5\n")), planned);
}
