//! Reports to the nodes that a receiver follows: how its slaves of each axis are.

use assert_no_alloc::assert_no_alloc;
use coaxle_clock::{Instant, Local};
use coaxle_curve::profile::Limits;
use coaxle_node::frame::{KeySeal, seal, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, FollowerReport, Node};
use coaxle_receiver::Receiver;

use crate::nodes::{self, Far, MILLISECOND};

/// The key of the reports of the receiver.
const KEY: &str = "coaxle/line/followers";

fn id(name: &str) -> u32 {
    sender_id(&NodeName::new(name).expect("a name"))
}

/// Runs until then; the reports of each cycle, with its time.
fn run(receiver: &mut Receiver, far: &mut [Far], until: i64) -> Vec<(i64, FollowerReport)> {
    let mut reports = Vec::new();
    while receiver.next_cycle().as_nanos() < until {
        let now: Instant<Local> = receiver.next_cycle();
        for far in &mut *far {
            far.send_until(now, receiver);
        }
        assert_no_alloc(|| receiver.cycle(now));
        while let Some(outgoing) = receiver.transmit() {
            if outgoing.channel == Channel::Followers {
                let mut message = Vec::new();
                seal(KEY, outgoing.body, None, &mut message);
                KeySeal::new(KEY)
                    .open_reports(&message, |report| reports.push((now.as_nanos(), *report)))
                    .expect("reports");
            }
        }
    }
    reports
}

const SLAVES: &str = "
    [[far]]
    node = 'press'
    delay = 'off'
    sync.time-sync.age-of-data-limit = 7
    axes = [1, { id = 7, name = 'belt' }]
    [[slave]]
    name = 'roll'
    master = 'press.1'
    gear = { ratio = 2 }
    limits = { velocity = 3000, acceleration = 40000, deceleration = 20000, jerk = 1e6 }
    [[slave]]
    name = 'behind'
    master = 'roll'
    gear = { ratio = -0.5 }
    limits = { velocity = 2000, acceleration = 15000, jerk = 1e6 }
    [[slave]]
    name = 'free'
    master = 'belt'
    couple = 'off'
    limits = { velocity = 2000, acceleration = 15000, jerk = 1e6 }
";

#[test]
fn it_reports_how_the_slaves_of_each_axis_are() {
    let mut receiver = nodes::receiver(SLAVES);
    let mut far = [Far::new(0, MILLISECOND, &[100.0, 50.0])];
    let reports = run(&mut receiver, &mut far, 3_000 * MILLISECOND);
    let last = |axis| {
        let mut of_axis = reports.iter().rev().map(|(_, report)| report);
        *of_axis
            .find(|report| report.axis_id == axis)
            .expect("reported")
    };
    let (first, belt) = (last(1), last(7));
    assert_eq!((first.node, first.run), (id("press"), 1));
    let numbers = |report: &FollowerReport| {
        let state = report.state;
        (state.slaves, state.in_sync, state.in_error)
    };
    assert_eq!((numbers(&first), numbers(&belt)), ((2, 2, 0), (1, 0, 0)));
    // `behind` would allow `roll` 4000 u/s, 30 000 u/s² and a jerk of 2e6; what is left is half of each.
    let expected = Limits::new(1_500.0, 15_000.0, 10_000.0, 5e5).expect("valid");
    assert_eq!(first.state.limits, expected);
    assert_eq!(belt.state.limits, Limits::NONE);
    // Until they are in sync, which they are once the clock is known.
    let changes = reports.iter().filter(|(_, report)| report.axis_id == 1);
    assert!(
        changes
            .clone()
            .any(|(_, report)| numbers(report) == (2, 0, 0))
    );
    // 20 times a second.
    let in_last_second = changes.filter(|(at, _)| *at >= 2_000 * MILLISECOND);
    assert_eq!(in_last_second.count(), 20);
}

#[test]
fn a_change_is_reported_in_its_cycle() {
    let mut receiver = nodes::receiver(SLAVES);
    let mut far = [Far::new(0, MILLISECOND, &[100.0, 50.0])];
    run(&mut receiver, &mut far, 3_000 * MILLISECOND);
    far[0].silent = true;
    let reports = run(&mut receiver, &mut far, 3_200 * MILLISECOND);
    // The master is lost: both slaves go to error stop, one after the other at most.
    let errors = reports
        .iter()
        .filter(|(_, report)| report.state.in_error > 0);
    let signals = &receiver.snapshot().signals;
    assert!(signals.slaves.iter().take(2).all(|slave| slave.error != 0));
    let (at, first) = errors.clone().next().expect("an error");
    assert_eq!((first.state.in_sync, first.state.in_error), (0, 2));
    // In error they bound nothing.
    assert_eq!(first.state.limits, Limits::NONE);
    let before = reports.iter().rev().find(|(other, _)| other < at);
    assert!(before.is_some_and(|(_, report)| report.state.in_error == 0));
    assert!(errors.count() > 2);
}

#[test]
fn without_a_subscriber_nothing_is_published() {
    let mut receiver = nodes::receiver(SLAVES);
    receiver.set_subscribed(Channel::Followers, false);
    let mut far = [Far::new(0, MILLISECOND, &[100.0, 50.0])];
    let reports = run(&mut receiver, &mut far, 1_000 * MILLISECOND);
    assert!(reports.is_empty());
}

#[test]
fn many_axes_take_turns() {
    let mut text = "[[far]]\nnode = 'press'\ndelay = 'off'\naxes = ['1-100']\n".to_owned();
    for n in 1..=100 {
        text += &format!("[[slave]]\nname = 's{n}'\nmaster = 'press.{n}'\n");
    }
    let mut receiver = nodes::receiver(&text);
    let mut far = [Far::new(0, MILLISECOND, &[5.0; 100])];
    run(&mut receiver, &mut far, 2_000 * MILLISECOND);
    let reports = run(&mut receiver, &mut far, 3_000 * MILLISECOND);
    for axis in 1..=100 {
        let of_axis = reports.iter().filter(|(_, report)| report.axis_id == axis);
        assert_eq!(of_axis.count(), 20, "{axis}");
    }
}
