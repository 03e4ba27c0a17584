//! Orders to the slaves of a receiver, as the network hands them in.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use coaxle_clock::{Instant, Local, Span};
use coaxle_motion::axis::AxisStatus;
use coaxle_motion::slave::{Accepted, Command, Dynamics, Refusal};
use coaxle_node::command::{NotTaken, SlaveName, SlaveView};
use coaxle_node::config::parse;
use coaxle_node::{CommandOrder, CommandOutcome, Node};
use coaxle_receiver::{Receiver, ReceiverConfig};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

const CONFIG: &str = "
    name = 'saw'
    cycle-time-us = 1000
    master = { node = 'belt' }
    [[slave]]
    name = 'carriage'
    couple = 'off'
    limits = { velocity = 500, acceleration = 5000, jerk = 1e6, max-position = 800 }
    [[slave]]
    name = 'follower'
";

fn receiver() -> Receiver {
    let config: ReceiverConfig = parse("test", CONFIG).unwrap();
    Receiver::new(&config, Instant::EPOCH, 1).unwrap()
}

fn cycles(receiver: &mut Receiver, count: u32) {
    for _ in 0..count {
        let now: Instant<Local> = receiver.next_cycle() + Span::from_micros(5);
        receiver.cycle(now);
        while receiver.transmit().is_some() {}
    }
}

fn order(slave: &str, command: Command) -> CommandOrder {
    CommandOrder {
        slave: SlaveName::new(slave).unwrap(),
        command,
        dry_run: false,
    }
}

fn to(position: f64) -> Command {
    Command::MoveAbsolute {
        position,
        velocity: None,
        dynamics: Dynamics::default(),
    }
}

fn accepted(outcome: &CommandOutcome) -> (Accepted, SlaveView) {
    match *outcome {
        CommandOutcome::Accepted { accepted, slave } => (accepted, slave),
        other => panic!("{other:?}"),
    }
}

fn refused(outcome: &CommandOutcome) -> (Refusal, SlaveView) {
    match *outcome {
        CommandOutcome::Refused { refusal, slave } => (refusal, slave),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_order_is_executed_and_answered_with_the_slave_as_it_is_then() {
    let mut receiver = receiver();
    cycles(&mut receiver, 2);
    let on = receiver.execute(&order("carriage", Command::Power(true)));
    let (at_once, slave) = accepted(&on);
    assert_eq!(
        (at_once, slave.status),
        (Accepted::AtOnce, AxisStatus::Standstill)
    );

    cycles(&mut receiver, 1);
    let moves = receiver.execute(&order("carriage", to(100.0)));
    let (job, slave) = accepted(&moves);
    assert!(matches!(job, Accepted::Job(_)));
    assert_eq!(slave.status, AxisStatus::DiscreteMotion);
    assert_eq!((slave.position, slave.velocity), (0.0, 0.0));

    cycles(&mut receiver, 100);
    let beyond = receiver.execute(&order("carriage", to(900.0)));
    let (refusal, slave) = refused(&beyond);
    assert_eq!(refusal.code(), 0x4229);
    assert!(slave.position > 0.0 && slave.velocity > 0.0);

    cycles(&mut receiver, 2_000);
    let halt = Command::Halt {
        dynamics: Dynamics::default(),
    };
    let (_, slave) = accepted(&receiver.execute(&order("carriage", halt)));
    assert_eq!(slave.position, 100.0);
}

#[test]
fn a_slave_without_limits_takes_no_orders() {
    let mut receiver = receiver();
    cycles(&mut receiver, 2);
    let outcome = receiver.execute(&order("follower", Command::Power(true)));
    let (refusal, _) = refused(&outcome);
    assert!(matches!(refusal, Refusal::NoLimits { .. }), "{refusal}");
}

#[test]
fn what_cannot_be_done_for_nobody_is_not_taken() {
    let mut receiver = receiver();
    let unknown = receiver.execute(&order("cariage", to(1.0)));
    let CommandOutcome::NotTaken(reason) = unknown else {
        panic!("{unknown:?}");
    };
    let text = reason.to_string();
    assert_eq!(
        text,
        "slave: received \"cariage\", expected carriage, follower"
    );

    let dry_run = CommandOrder {
        dry_run: true,
        ..order("carriage", Command::Power(true))
    };
    let reason = NotTaken::NoDryRun {
        command: "MC_Power",
    };
    assert_eq!(receiver.execute(&dry_run), CommandOutcome::NotTaken(reason));
    let (refusal, _) = refused(&receiver.execute(&order("carriage", to(1.0))));
    assert_eq!(refusal.code(), 0x422a, "it has no power yet");
}

#[test]
fn orders_do_not_allocate() {
    let mut receiver = receiver();
    cycles(&mut receiver, 10);
    let orders = [
        order("nobody", to(1.0)),
        order("carriage", to(1.0)),
        order("carriage", Command::Power(true)),
        order("carriage", to(100.0)),
        order("carriage", to(900.0)),
        order("follower", to(1.0)),
        order("carriage", Command::GearIn { ratio: 1.0 }),
    ];
    assert_no_alloc(|| {
        for order in &orders {
            let _ = receiver.execute(order);
            cycles(&mut receiver, 3);
        }
    });
}
