//! Orders to the slaves of a receiver, as received from the network.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use assert_no_alloc::assert_no_alloc;
use coaxle_axis::AxisStatus;
use coaxle_cam::CamIn;
use coaxle_clock::{Instant, Local, Span};
use coaxle_gear::GearIn;
use coaxle_node::command::{SlaveName, SlaveOrder, SlaveView};
use coaxle_node::config::parse;
use coaxle_node::{CommandOrder, CommandOutcome, Node};
use coaxle_receiver::{Receiver, ReceiverConfig};
use coaxle_saw::{GearInPos, Ratio, SyncLimits, SyncMode};
use coaxle_slave::{Command, CouplingPhase, Dynamics, Refusal};

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
    slave_order(slave, command).into()
}

fn slave_order(slave: &str, command: Command) -> SlaveOrder {
    SlaveOrder {
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

/// The number of its job, and the slave.
fn accepted(outcome: &CommandOutcome) -> (Option<u32>, SlaveView) {
    match *outcome {
        CommandOutcome::Accepted { job, slave, .. } => (job, slave),
        other => panic!("{other:?}"),
    }
}

fn refused(outcome: &CommandOutcome) -> (Refusal, SlaveView) {
    match *outcome {
        CommandOutcome::Refused { refusal, slave, .. } => (refusal, slave),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_order_is_executed_and_answered_with_the_slave_as_it_is_then() {
    let mut receiver = receiver();
    cycles(&mut receiver, 2);
    let on = receiver.execute(&order("carriage", Command::Power(true)));
    let (at_once, slave) = accepted(&on);
    assert_eq!((at_once, slave.status), (None, AxisStatus::Standstill));

    cycles(&mut receiver, 1);
    let moves = receiver.execute(&order("carriage", to(100.0)));
    let (job, slave) = accepted(&moves);
    assert_eq!(job, Some(1));
    assert_eq!(slave.status, AxisStatus::DiscreteMotion);
    // An order is answered before the cycle that begins to move.
    assert_eq!((slave.position, slave.velocity), (0.0, 0.0));

    cycles(&mut receiver, 100);
    // Its max-position is 800.
    let beyond = receiver.execute(&order("carriage", to(900.0)));
    let (refusal, slave) = refused(&beyond);
    assert_eq!(refusal.code(), 0x4229);
    assert!(slave.position > 0.0 && slave.velocity > 0.0);

    cycles(&mut receiver, 2_000);
    let halt = Command::Halt {
        dynamics: Dynamics::default(),
    };
    let (_, slave) = accepted(&receiver.execute(&order("carriage", halt)));
    // A profile ends exactly at its target.
    assert_eq!(slave.position, 100.0);
}

#[test]
fn a_slave_without_limits_takes_orders_as_any_other() {
    let mut receiver = receiver();
    cycles(&mut receiver, 2);
    accepted(&receiver.execute(&order("follower", Command::Power(true))));
    cycles(&mut receiver, 1);
    // The limits of its drive apply.
    let beyond = Command::MoveVelocity {
        velocity: 1e5,
        dynamics: Dynamics::default(),
    };
    let outcome = receiver.execute(&order("follower", beyond));
    assert_eq!(refused(&outcome).0.code(), 0x42dd);
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

    // Every command can be tried, including those on cam plates.
    cycles(&mut receiver, 1);
    receiver.execute(&order("carriage", Command::Power(true)));
    let (refusal, _) =
        refused(&receiver.execute(&dry_run("carriage", Command::CamIn(CamIn::default()))));
    assert_eq!(refusal, Refusal::NoMaster);
}

fn dry_run(slave: &str, command: Command) -> CommandOrder {
    SlaveOrder {
        dry_run: true,
        ..slave_order(slave, command)
    }
    .into()
}

#[test]
fn a_dry_run_answers_and_changes_nothing() {
    let mut receiver = receiver();
    cycles(&mut receiver, 2);
    let (_, slave) = accepted(&receiver.execute(&dry_run("carriage", Command::Power(true))));
    assert_eq!(slave.status, AxisStatus::Disabled);
    let (refusal, _) = refused(&receiver.execute(&dry_run("carriage", to(1.0))));
    assert_eq!(refusal.code(), 0x422a, "it has no power yet");
    assert_eq!(receiver.snapshot().faults[0].refusal, None);
}

const SAW: &str = "
    name = 'saw'
    cycle-time-us = 1000
    master = { node = 'belt' }
    [[slave]]
    name = 'belt'
    couple = 'off'
    limits = { velocity = 500, acceleration = 5000, jerk = 1e6 }
    [[slave]]
    name = 'carriage'
    id = 7
    master = 'belt'
    couple = 'off'
    limits = { velocity = 500, acceleration = 5000, jerk = 1e6, max-position = 800 }
";

fn gear_in_pos(master_sync_position: f64) -> Command {
    Command::from(GearInPos {
        ratio: Ratio::of(1.0),
        master_sync_position,
        slave_sync_position: 150.0,
        master_start_distance: None,
        strategy: None,
        sync_mode: SyncMode::default(),
        limits: SyncLimits::default(),
    })
}

#[test]
fn a_flying_saw_is_tried_refused_coupled_and_read() {
    let config: ReceiverConfig = parse("test", SAW).unwrap();
    let mut receiver = Receiver::new(&config, Instant::EPOCH, 1).unwrap();
    cycles(&mut receiver, 1);
    for slave in ["belt", "carriage"] {
        accepted(&receiver.execute(&order(slave, Command::Power(true))));
    }
    let belt = Command::MoveVelocity {
        velocity: 200.0,
        dynamics: Dynamics::default(),
    };
    accepted(&receiver.execute(&order("belt", belt)));
    cycles(&mut receiver, 500);

    let read = Command::ReadFlyingSawCharacteristics {};
    let (refusal, _) = refused(&receiver.execute(&order("carriage", read)));
    assert_eq!(refusal.code(), 0x4216);
    // Belt at some 95 u: no carriage moves by 150 u within the next 15 u of the belt.
    let near = receiver.execute(&dry_run("carriage", gear_in_pos(110.0)));
    let CommandOutcome::Refused {
        refusal,
        saw: Some(attempt),
        ..
    } = near
    else {
        panic!("{near:?}");
    };
    assert_eq!(refusal.code(), 0x42df);
    assert_eq!(attempt.moment.master.velocity, 200.0);

    let saws = |outcome: CommandOutcome| match outcome {
        CommandOutcome::Accepted { saw, slave, .. } => (saw.unwrap(), slave),
        other => panic!("{other:?}"),
    };
    // With 305 u left, or 1.5 s, the plan is possible.
    let (tried, slave) = saws(receiver.execute(&dry_run("carriage", gear_in_pos(400.0))));
    assert_eq!(slave.status, AxisStatus::Standstill);
    let (coupled, slave) = saws(receiver.execute(&order("carriage", gear_in_pos(400.0))));
    assert_eq!(slave.status, AxisStatus::SynchronizedMotion);
    // No cycle ran in between, so the plans are equal to the last bit.
    assert_eq!(coupled, tried);
    assert_eq!((coupled.axis_id, coupled.plan.line().slave), (7, 150.0));
    cycles(&mut receiver, 2_000);
    let (read, slave) = saws(receiver.execute(&order("carriage", read)));
    assert_eq!(read, coupled);
    assert_eq!(slave.coupling, Some(CouplingPhase::InSync));
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
        order("carriage", Command::GearIn(GearIn::of(1.0))),
        order("carriage", gear_in_pos(100.0)),
        dry_run("carriage", to(50.0)),
        dry_run("carriage", gear_in_pos(100.0)),
        dry_run("carriage", Command::CamIn(CamIn::default())),
        order("carriage", Command::ReadFlyingSawCharacteristics {}),
    ];
    assert_no_alloc(|| {
        for order in &orders {
            // Accepted or refused, neither may allocate.
            let _ = receiver.execute(order);
            cycles(&mut receiver, 3);
        }
    });
}

const KNIFE: &str = "
    name = 'knife'
    cycle-time-us = 1000
    [[far]]
    node = 'conveyor'
    modulo = 100
    [[slave]]
    name = 'belt'
    couple = 'off'
    modulo = 600
    limits = { velocity = 1000, acceleration = 10000, jerk = 1e6 }
    [[slave]]
    name = 'drum'
    master = 'belt'
    couple = 'off'
    modulo = 360
    limits = { velocity = 1000, acceleration = 10000, jerk = 1e6 }
";

fn in_turn(order: &str) -> Command {
    let order =
        format!("c.gear-in-pos = {{ ratio = {{ numerator = 360, denominator = 600 }}, {order} }}");
    let command: std::collections::BTreeMap<String, Command> = parse("c", &order).unwrap();
    command["c"]
}

#[test]
fn sync_positions_by_the_turn_are_resolved_once_and_shown() {
    let config: ReceiverConfig = parse("test", KNIFE).unwrap();
    let mut receiver = Receiver::new(&config, Instant::EPOCH, 1).unwrap();
    cycles(&mut receiver, 1);
    for slave in ["belt", "drum"] {
        accepted(&receiver.execute(&order(slave, Command::Power(true))));
    }
    let backwards = Command::MoveVelocity {
        velocity: -500.0,
        dynamics: Dynamics::default(),
    };
    accepted(&receiver.execute(&order("belt", backwards)));
    // 5 000 u in 10 s: more than eight turns of 600 back.
    cycles(&mut receiver, 10_000);
    let saw =
        in_turn("master-sync-position = { in-turn = 150 }, slave-sync-position = { in-turn = 90 }");
    let positions = |outcome: CommandOutcome| match outcome {
        CommandOutcome::Accepted { sync_positions, .. } => sync_positions.unwrap(),
        other => panic!("{other:?}"),
    };
    let tried = positions(receiver.execute(&dry_run("drum", saw)));
    let given = order("drum", saw);
    let at = positions(assert_no_alloc(|| receiver.execute(&given)));
    assert_eq!(at, tried);
    // The master runs backwards, so that 90 of a knife at 0 is a quarter before.
    assert_eq!((at.slave, at.master.rem_euclid(600.0)), (-270.0, 150.0));
    cycles(&mut receiver, 4_000);
    let shown = receiver.snapshot().signals.slaves[1];
    let master = shown.master_position.unwrap();
    assert_eq!(shown.master_sync_position, Some(at.master));
    assert_eq!(shown.slave_sync_position, Some(at.slave));
    assert_eq!(shown.master_modulo_position, Some(master.rem_euclid(600.0)));
    // Ratio 360 to 600.
    let off = shown.position.unwrap() - at.slave - 0.6 * (master - at.master);
    assert!(off.abs() < 1e-6, "{off}");
    assert_eq!(
        shown.modulo_position,
        Some(shown.position.unwrap().rem_euclid(360.0))
    );
}

#[test]
fn positions_by_the_turn_are_of_axes_that_turn() {
    let step = "[[slave.step]]\ndo.gear-in-pos = { ratio = { numerator = 1 }, \
        master-sync-position = { in-turn = 150 }, slave-sync-position = { in-turn = 90 } }";
    let error = |text: &str| {
        let config: ReceiverConfig = parse("test", &format!("{text}{step}")).unwrap();
        let error = Receiver::new(&config, Instant::EPOCH, 1).unwrap_err();
        error.to_string()
    };
    let no_master_turns = KNIFE.replace("modulo = 600", "");
    let said = error(&no_master_turns);
    assert!(
        said.contains("slave[1].step[0].do: 0x4b06: master-sync-position: received in-turn 150"),
        "{said}"
    );
    // 90 lies beyond a turn of 45.
    let said = error(&KNIFE.replace("modulo = 360", "modulo = 45"));
    assert!(
        said.contains("slave-sync-position: received in-turn 90, expected 0 up to less than"),
        "{said}"
    );
    let marked = format!(
        "{KNIFE}marks = {{ spacing = 600, sensor-distance = 100 }}\n{step}at-mark = true\n"
    );
    let config: ReceiverConfig =
        parse("test", &marked.replace("} }at-mark", "} }\nat-mark")).unwrap();
    let said = Receiver::new(&config, Instant::EPOCH, 1)
        .unwrap_err()
        .to_string();
    assert!(said.contains("slave[1].step[0].at-mark"), "{said}");
}
