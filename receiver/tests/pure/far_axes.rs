//! The far axes as corrected, which a receiver publishes for others.

use crate::nodes;
use crate::nodes::{Far, MILLISECOND, receiver};
use coaxle_axis::{NcToPlcAxis, StateWord};
use coaxle_clock::time_sync::SyncError;
use coaxle_clock::{Instant, Span};
use coaxle_node::frame::{decode, seal};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, Intake, Node};
use coaxle_receiver::{Health, Receiver};

const THREE: &str = "
publish-far-axes = ['belt', 'infeed.2', 'press.1']
[[far]]
node = 'infeed'
axes = ['1-2']
delay = 'off'
[[far]]
node = 'press'
axes = [1, { id = 5, name = 'belt' }]
delay = 'off'
sync.time-sync.age-of-data-limit = 7
";

/// The numbers of the axes among the signals, by the id they are published with, from 1.
const PUBLISHED: [usize; 3] = [3, 1, 2];

fn far() -> [Far; 2] {
    [
        Far::new(0, 1_000_400, &[100.0, 200.0]),
        Far::new(1, 999_700, &[300.0, -50.0]),
    ]
}

/// Runs a cycle and returns the frame of the far axes, if one was sent.
fn cycle(receiver: &mut Receiver, far: &mut [Far]) -> Option<Vec<u8>> {
    let now = receiver.next_cycle();
    far.iter_mut().for_each(|far| far.send_until(now, receiver));
    let _ = receiver.cycle(now);
    let mut frame = None;
    while let Some(outgoing) = receiver.transmit() {
        if outgoing.channel == Channel::FarAxes {
            let sealed = frame.insert(Vec::new());
            seal(KEY, outgoing.body, Some(Span::ZERO), sealed);
        }
    }
    frame
}

const KEY: &str = "coaxle/line/far-axes";

fn axes(frame: &[u8]) -> Vec<NcToPlcAxis> {
    let mut axes = Vec::new();
    decode(KEY, frame, |axis| axes.push(*axis)).expect("a good frame");
    axes
}

#[test]
fn what_is_published_is_what_the_signals_show() {
    let (mut receiver, mut far) = (receiver(THREE), far());
    let (mut frames, mut errors, mut operational) = (0, 0, 0);
    while receiver.next_cycle().as_nanos() < 5_000 * MILLISECOND {
        // A node that is silent at first, then sends, then falls silent.
        let now = receiver.next_cycle().as_nanos();
        far[1].silent = !(1_000 * MILLISECOND..4_000 * MILLISECOND).contains(&now);
        let frame = cycle(&mut receiver, &mut far);
        let shown = &receiver.snapshot().signals.axes;
        let Some(frame) = frame else {
            assert!(shown.iter().all(|axis| axis.corrected_position.is_none()));
            continue;
        };
        frames += 1;
        let axes = axes(&frame);
        for (id, number) in (1..).zip(PUBLISHED) {
            let (axis, shown) = (axes.iter().find(|axis| axis.axis_id == id), &shown[number]);
            assert_eq!(axis.map(|axis| axis.set_position), shown.corrected_position);
            let Some(axis) = axis else { continue };
            assert_eq!(Some(axis.set_velocity), shown.corrected_velocity);
            assert_eq!(axis.error_code, u32::from(shown.error));
            let ready = axis.state_word.contains(StateWord::OPERATIONAL);
            // Not yet while the change of mode is being blended.
            assert!(!ready || shown.synced && shown.error == 0);
            operational += u32::from(ready);
            errors += u32::from(shown.error == SyncError::MaxDataAgeExceeded.code());
        }
    }
    // Two axes of the press, silent in the last second.
    assert!(frames > 4_900 && errors > 1_900, "{frames} {errors}");
    // An axis for 5 s and two for 3 s are 11 000, less the start-ups.
    assert!(operational > 9_000, "{operational}");
}

#[test]
fn nothing_is_published_unless_it_is_asked_for() {
    for publish in ["", "publish-far-axes = false"] {
        let text = THREE.split_once(']').expect("a list").1;
        let (mut receiver, mut far) = (receiver(&format!("{publish}\n{text}")), far());
        for _ in 0..1_000 {
            assert_eq!(cycle(&mut receiver, &mut far), None);
        }
    }
}

#[test]
fn what_nobody_subscribes_to_is_not_sent_and_goes_on_as_if_it_had_been() {
    let (mut receiver, mut far) = (receiver(THREE), far());
    let (mut other, mut other_far) = (nodes::receiver(THREE), self::far());
    for n in 0..3_000 {
        receiver.set_subscribed(Channel::FarAxes, !(1_000..2_000).contains(&n));
        let expected = cycle(&mut other, &mut other_far);
        let sent = cycle(&mut receiver, &mut far);
        assert_eq!(
            sent,
            expected.filter(|_| !(1_000..2_000).contains(&n)),
            "{n}"
        );
        assert_eq!(receiver.snapshot(), other.snapshot());
    }
}

#[test]
fn another_receiver_follows_them() {
    let (mut line, mut far) = (receiver(THREE), far());
    let mut display = receiver(
        "[[far]]\nnode = 'line'\nchannel = 'far-axes'\naxes = [{ id = 1, name = 'belt' }, 3]\n\
         delay = 'off'",
    );
    let line_name = NodeName::new("line").expect("a name");
    let mut intake = Intake::new(KEY, &line_name, &[1, 3]);
    // The display's clock runs 60 ppm fast. A frame takes 0.1 ms, and up to 1 µs more.
    let displayed = |line_ns: i64| Instant::from_nanos(line_ns + line_ns * 60 / 1_000_000);
    while line.next_cycle().as_nanos() < 5_000 * MILLISECOND {
        let now = line.next_cycle().as_nanos();
        let arrival = displayed(now + 100_000 + now / MILLISECOND * 7_919 % 997);
        while display.next_cycle() < arrival {
            let _ = display.cycle(display.next_cycle());
            while display.transmit().is_some() {}
        }
        if now > 4_000 * MILLISECOND {
            assert_eq!(display.snapshot().health, Health::Ok);
            let (theirs, ours) = (line.snapshot(), display.snapshot());
            // The line's newest cycle was a millisecond ago; the display is 0.1 ms behind the line.
            let line_ns = ours.ideal_start.as_nanos() as f64 / 1.000_06;
            let since = (line_ns - (now - MILLISECOND) as f64) * 1e-9 - 0.1e-3;
            for (axis, number) in [(0, 3), (1, 2)] {
                let line = &theirs.signals.axes[number];
                let velocity = line.corrected_velocity.expect("known");
                let expected = line.corrected_position.expect("known") + velocity * since;
                let shown = ours.signals.axes[axis].corrected_position.expect("known");
                let error = (shown - expected).abs();
                assert!(error < velocity.abs() * 10e-6, "{axis}: {error}");
            }
        }
        if let Some(frame) = cycle(&mut line, &mut far) {
            let message = intake.message(&frame);
            display.receive(arrival, 0, &message);
        }
    }
}
