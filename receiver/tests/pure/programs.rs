//! Programs that react to the results of their commands: an order, a master that turns back or is lost.

use crate::bench;
use std::slice::from_mut;

use crate::bench::{Far, Near, SECOND, run_pair};
use crate::nodes::{receiver, run};
use coaxle_axis::AxisStatus;
use coaxle_node::Node;
use coaxle_receiver::signals::SlaveSignals;
use coaxle_receiver::{Health, HealthName, Outcome, ProgramState, Receiver, WaitsFor};
use coaxle_slave::{Command, CouplingPhase, Dynamics};

const JERK: f64 = 200_000.0;

/// Cuts every 1000 mm of a conveyor at 500 mm/s, with these branches in `otherwise`.
fn cutting(otherwise: &str) -> Receiver {
    receiver(&format!(
        "[[virtual-axis]]
        id = 1
        name = 'conveyor'
        [virtual-axis.program]
        limits = {{ velocity = 1000, acceleration = 1000, jerk = 10000 }}
        steps = [{{ enable = true }}, {{ velocity = {{ value = 500 }} }}]
        [[slave]]
        name = 'saw'
        limits = {{ velocity = 1500, acceleration = 10000, jerk = {JERK}, min-position = -10, max-position = 800 }}
        marks = {{ spacing = 1000, sensor-distance = 300 }}
        [[slave.step]]
        do = {{ power = true }}
        [[slave.step]]
        label = 'couple'
        at-mark = true
        [slave.step.do.gear-in-pos]
        ratio = {{ numerator = 1 }}
        master-sync-position = 300
        slave-sync-position = 300
        limits = {{ velocity = 1400, acceleration = 9000, deceleration = 9000, jerk = {JERK} }}
        [[slave.step]]
        when = {{ in-sync = true, position-above = 450 }}
        cut = true
        {otherwise}
        [[slave.step]]
        when = {{ position-above = 600 }}
        do = {{ gear-out = {{}} }}
        {otherwise}
        [[slave.step]]
        label = 'return'
        do = {{ move-absolute = {{ position = 0, velocity = 800, dynamics = {{ acceleration = 9000, jerk = {JERK} }} }} }}
        [[slave.step]]
        when = {{ position-below = 200 }}
        go-to = 'couple'
        {otherwise}
        [[slave.step]]
        label = 'stopped'
        when = {{ standstill = true }}
        go-to = 'return'
        "
    ))
}

/// The largest jerk in the differences of a slave's positions, and the slave's last signals.
#[derive(Default)]
struct Watch {
    positions: Vec<f64>,
    last: SlaveSignals,
    health: HealthName,
}

impl Watch {
    fn run(&mut self, receiver: &mut Receiver, seconds: f64) {
        let from = receiver.next_cycle().as_nanos();
        run(
            receiver,
            &mut [],
            from + (seconds * 1e9) as i64,
            |row, _| {
                self.positions.extend(row.slaves[0].position);
                self.last = row.slaves[0];
                self.health = row.node.health;
            },
        );
    }

    /// Runs until the slave's signals satisfy `what`.
    fn until(&mut self, receiver: &mut Receiver, what: impl Fn(&SlaveSignals) -> bool) {
        for _ in 0..20_000 {
            self.run(receiver, 1e-3);
            if what(&self.last) {
                return;
            }
        }
        panic!("it never came: {:?}", self.last);
    }

    fn largest_jerk(&self) -> f64 {
        // 1e-9 s³ is the cycle of 1 ms, cubed.
        let jerk = |p: &[f64]| (p[3] - 3.0 * p[2] + 3.0 * p[1] - p[0]) / 1e-9;
        self.positions
            .windows(4)
            .map(|window| jerk(window).abs())
            .fold(0.0, f64::max)
    }
}

fn order(receiver: &mut Receiver, command: &Command) {
    let number = receiver.slave_number("saw").expect("a slave");
    receiver.command(number, command).expect("it is taken");
}

fn halt(receiver: &mut Receiver) {
    let dynamics = Dynamics {
        deceleration: Some(5_000.0),
        ..Dynamics::default()
    };
    order(receiver, &Command::Halt { dynamics });
}

fn is_synchronizing(slave: &SlaveSignals) -> bool {
    slave.phase == Some(CouplingPhase::Synchronizing)
}

#[test]
fn a_saw_that_an_order_stops_returns_and_goes_on_cutting() {
    let mut receiver = cutting("otherwise = { aborted = 'stopped' }");
    let mut watch = Watch::default();
    watch.until(&mut receiver, |saw| saw.cuts == 2);
    // In sync, on the way there, and on the way back.
    for (number, stops) in [
        |saw: &SlaveSignals| saw.phase == Some(CouplingPhase::InSync),
        is_synchronizing,
        |saw: &SlaveSignals| saw.velocity.is_some_and(|velocity| velocity < -100.0),
    ]
    .into_iter()
    .enumerate()
    {
        let cuts = watch.last.cuts;
        watch.until(&mut receiver, stops);
        halt(&mut receiver);
        watch.run(&mut receiver, 2e-3);
        // Steps count from 1: step 7 is `stopped`.
        assert_eq!(watch.last.program_step, Some(7), "case {number}");
        assert_eq!(watch.last.program_outcome, Some(Outcome::Aborted));
        assert_eq!(watch.last.program, Some(ProgramState::Running));
        watch.until(&mut receiver, |saw| saw.cuts >= cuts + 2);
        assert_eq!(watch.health, HealthName::Ok);
        assert_eq!(watch.last.error, 0);
    }
    let jerk = watch.largest_jerk();
    assert!(jerk <= JERK * 1.01, "{jerk}");
}

#[test]
fn a_saw_whose_program_handles_nothing_says_that_it_waits_in_vain_until_somebody_helps() {
    let mut receiver = cutting("");
    let mut watch = Watch::default();
    watch.until(&mut receiver, is_synchronizing);
    watch.run(&mut receiver, 2e-3);
    assert_eq!(watch.last.program_waits_for, Some(WaitsFor::InSync));
    assert_eq!(watch.health, HealthName::Ok);
    halt(&mut receiver);
    // At once, because it is uncoupled.
    watch.run(&mut receiver, 2e-3);
    assert_eq!(watch.last.program, Some(ProgramState::Blocked));
    assert_eq!(watch.last.program_waits_for, Some(WaitsFor::InSync));
    assert_eq!(watch.last.program_outcome, Some(Outcome::Aborted));
    assert_eq!(watch.health, HealthName::ProgramBlocked);
    let shown = receiver.snapshot();
    assert_eq!(shown.health, Health::ProgramBlocked { slave: 0 });
    let why = shown.faults[0].blocked.expect("it is told").to_string();
    assert_eq!(
        why,
        "step 3 of the program waits for in-sync, which cannot come by itself: its command was aborted"
    );
    watch.run(&mut receiver, 1.0);
    assert_eq!(watch.last.program, Some(ProgramState::Blocked));
    // The operator couples it, as the program would have.
    let gear = coaxle_gear::GearIn::of(1.0);
    order(&mut receiver, &Command::GearIn(gear));
    watch.run(&mut receiver, 2e-3);
    assert_eq!(watch.last.program, Some(ProgramState::Running));
    assert_eq!(watch.health, HealthName::Ok);
    watch.until(&mut receiver, |saw| saw.cuts == 2);
    assert!(watch.largest_jerk() <= JERK * 1.01);
}

/// A conveyor that reverses at 600 mm, and returns.
fn turning_back(otherwise: &str) -> Receiver {
    receiver(&format!(
        "[[virtual-axis]]
        id = 1
        name = 'conveyor'
        [virtual-axis.program]
        start-position = -500
        limits = {{ velocity = 500, acceleration = 1000, jerk = 10000 }}
        steps = [{{ enable = true }}, {{ move-absolute = {{ position = 600 }} }},
          {{ move-absolute = {{ position = -500 }} }}, {{ velocity = {{ value = 500 }} }}]
        [[slave]]
        name = 'saw'
        limits = {{ velocity = 1500, acceleration = 10000, jerk = {JERK} }}
        [[slave.step]]
        do = {{ power = true }}
        [[slave.step]]
        label = 'couple'
        when = {{ master-above = -100 }}
        do = {{ move-velocity = {{ velocity = 250 }} }}
        [[slave.step]]
        when = {{ master-above = 0 }}
        [slave.step.do.gear-in-pos]
        ratio = {{ numerator = 1 }}
        master-sync-position = 1000
        slave-sync-position = 800
        limits = {{ deceleration = 2500, jerk = 50000 }}
        [[slave.step]]
        when = {{ in-sync = true }}
        {otherwise}
        [[slave.step]]
        cut = true
        [[slave.step]]
        when = {{ after-s = 60 }}
        [[slave.step]]
        label = 'turned-back'
        when = {{ standstill = true, rolled-back = true }}
        do = {{ move-absolute = {{ position = 0 }} }}
        [[slave.step]]
        when = {{ done = true, master-below = -200 }}
        go-to = 'couple'
        "
    ))
}

#[test]
fn a_saw_whose_master_turns_back_couples_again_when_it_comes() {
    let mut receiver = turning_back("otherwise = { rolled-back = 'turned-back' }");
    let mut watch = Watch::default();
    watch.until(&mut receiver, |saw| {
        saw.program_outcome == Some(Outcome::RolledBack)
    });
    // Steps count from 1: step 7 is `turned-back`.
    assert_eq!(watch.last.program_step, Some(7));
    assert_eq!(watch.last.state, AxisStatus::DiscreteMotion);
    assert_eq!(watch.last.cuts, 0);
    watch.until(&mut receiver, |saw| saw.cuts == 1);
    assert_eq!(watch.last.error, 0);
    assert_eq!(watch.last.refusal, 0);
    let jerk = watch.largest_jerk();
    assert!(jerk <= JERK * 1.01, "{jerk}");
}

#[test]
fn a_rollback_that_nobody_handles_is_told_before_the_saw_stands() {
    let mut receiver = turning_back("");
    let mut watch = Watch::default();
    watch.until(&mut receiver, |saw| {
        saw.program == Some(ProgramState::Blocked)
    });
    assert_eq!(watch.last.program_outcome, Some(Outcome::RolledBack));
    assert_eq!(watch.last.state, AxisStatus::DiscreteMotion);
    assert_eq!(watch.health, HealthName::ProgramBlocked);
    // The master returns, without any effect on that.
    watch.run(&mut receiver, 10.0);
    assert_eq!(watch.last.program, Some(ProgramState::Blocked));
}

/// A far master that falls silent, and returns as another run.
fn losing_its_master(otherwise: &str) -> (Near, Vec<(ProgramState, Option<WaitsFor>)>) {
    let config = format!(
        "mode = 'time'
        sync.time-sync.automatic-re-init = true
        [[slave]]
        limits = {{ velocity = 2000, acceleration = 5000, jerk = 1e6 }}
        couple = 'off'
        [[slave.step]]
        label = 'begin'
        when = {{ master-ready = true, error-stop = false }}
        do = {{ power = true }}
        [[slave.step]]
        do = {{ gear-in = {{ ratio = 1.0 }} }}
        [[slave.step]]
        when = {{ in-sync = true }}
        [[slave.step]]
        when = {{ in-sync = false, after-s = 100 }}
        {otherwise}
        [[slave.step]]
        label = 'trouble'
        when = {{ standstill = true }}
        do = {{ reset = {{}} }}
        go-to = 'begin'
        "
    );
    let mut near = Near::new(1000, 0, &config);
    let mut far = Far::new(1000, 100, 0, 1);
    run_pair(&mut far, &mut near, 2 * SECOND);
    let coupled = near.last().slaves[0];
    assert_eq!(coupled.phase, Some(CouplingPhase::InSync));
    bench::run(None, from_mut(&mut near), 5 * SECOND);
    let mut again = Far::new(1000, 100, 5 * SECOND, 2);
    run_pair(&mut again, &mut near, 9 * SECOND);
    let mut seen = Vec::new();
    for shown in &near.snapshots {
        let program = shown.slaves[0].program.expect("a program");
        let now = (program.state, program.waits_for);
        if seen.last() != Some(&now) {
            seen.push(now);
        }
    }
    (near, seen)
}

#[test]
fn a_slave_that_lost_its_master_resets_itself_and_waits_for_it() {
    let (near, seen) = losing_its_master("otherwise = { failed = 'trouble' }");
    let last = near.last();
    assert_eq!(last.health, Health::Ok);
    assert_eq!(last.slaves[0].phase, Some(CouplingPhase::InSync));
    assert_eq!(last.slaves[0].error, None);
    let waits = (ProgramState::WaitingForMaster, Some(WaitsFor::MasterReady));
    assert!(seen.contains(&waits), "{seen:?}");
    let failed = near
        .snapshots
        .iter()
        .filter(|shown| matches!(shown.health, Health::SlaveFailed { .. }));
    assert!(failed.count() > 0);
    assert!(
        seen.iter()
            .all(|(state, _)| *state != ProgramState::Blocked)
    );
}

#[test]
fn without_a_branch_it_stays_in_error_stop_and_its_step_comes_with_time() {
    let (near, _) = losing_its_master("");
    let last = near.last();
    assert_eq!(last.health, Health::SlaveFailed { slave: 0 });
    let program = last.slaves[0].program.expect("a program");
    assert_eq!(program.state, ProgramState::Running);
    assert_eq!(program.waits_for, Some(WaitsFor::AfterS));
    assert_eq!(program.outcome, Some(Outcome::Failed));
}

#[test]
fn a_program_that_waits_for_an_operator_is_well() {
    let mut receiver = receiver(
        "[[virtual-axis]]
        id = 1
        name = 'conveyor'
        program.limits = { velocity = 500, acceleration = 1000, jerk = 10000 }
        program.steps = [{ enable = true }]
        [[slave]]
        name = 'saw'
        limits = { velocity = 1500, acceleration = 10000, jerk = 200000 }
        [[slave.step]]
        when = { state = 'standstill' }
        do = { move-absolute = { position = 5 } }
        [[slave.step]]
        when = { done = true }
        [[slave.step]]
        when = { in-sync = true }
        timeout-s = 3
        ",
    );
    let mut watch = Watch::default();
    watch.run(&mut receiver, 0.1);
    let waits = |watch: &Watch, waits_for| {
        assert_eq!(watch.last.program, Some(ProgramState::WaitingForOrder));
        assert_eq!(watch.last.program_waits_for, Some(waits_for));
        assert_eq!(watch.health, HealthName::Ok);
    };
    waits(&watch, WaitsFor::State);
    order(&mut receiver, &Command::Power(true));
    watch.run(&mut receiver, 1.0);
    waits(&watch, WaitsFor::InSync);
    // Jogging it meanwhile has no effect.
    halt(&mut receiver);
    watch.run(&mut receiver, 0.5);
    waits(&watch, WaitsFor::InSync);
    // But it may not take for ever.
    watch.run(&mut receiver, 3.0);
    assert_eq!(watch.last.program, Some(ProgramState::TimedOut));
    assert_eq!(watch.health, HealthName::ProgramBlocked);
}
