//! A node that breaks the contract ends the run.

use coaxle_clock::Instant;
use coaxle_sim::{Breach, Violation, World};

use crate::toy::{Memory, Misbehaviour, at, toy, wrong_toy};

/// Runs a node with this fault next to one without.
fn run_with(wrong: Misbehaviour) -> (Result<(), Violation>, Memory) {
    let mut world = World::new();
    world.add_node(toy("good", "", &[])).expect("no files");
    world.add_node(wrong_toy("bad", wrong)).expect("no files");
    let mut memory = Memory::default();
    let result = world.run_until(at(10_000), &mut memory);
    (result, memory)
}

fn breach_of(wrong: Misbehaviour) -> Breach {
    let violation = run_with(wrong).0.expect_err("it breaks the contract");
    assert_eq!(violation.node, "bad");
    violation.breach
}

#[test]
fn who_keeps_the_contract_runs_to_the_end() {
    let (result, memory) = run_with(Misbehaviour::Nothing);
    assert_eq!(result, Ok(()));
    assert_eq!(memory.cycles.len(), 20);
}

#[test]
fn each_way_of_breaking_it_is_noticed_in_the_cycle_it_happens() {
    let miscounted = Breach::Miscounted {
        last: 0,
        count: 1,
        elapsed: 0,
    };
    assert_eq!(breach_of(Misbehaviour::Miscounts), miscounted);
    assert_eq!(
        breach_of(Misbehaviour::StandsStill),
        Breach::BackInTime { count: 1 }
    );
    assert_eq!(
        breach_of(Misbehaviour::IsDueAtOnce),
        Breach::NextNotLater { count: 0 }
    );
}

#[test]
fn a_node_that_would_catch_up_with_a_burst_is_noticed() {
    let mut world = World::new();
    let node = world
        .add_node(wrong_toy("bad", Misbehaviour::CatchesUp))
        .expect("no files");
    let mut memory = Memory::default();
    // Frozen over the start of its first cycle, it wakes late.
    world.stop(node);
    world.run_until(at(300), &mut memory).unwrap();
    world.resume(node);
    let violation = world.run_until(at(2_000), &mut memory).unwrap_err();
    let expected = Breach::NextIsPast {
        count: 0,
        due: Instant::from_nanos(1),
        now: Instant::from_nanos(300_000),
    };
    assert_eq!(violation.breach, expected);
}

#[test]
fn a_node_that_was_started_anew_may_count_anew() {
    let mut world = World::new();
    let node = world.add_node(toy("saw", "", &[])).expect("no files");
    let mut memory = Memory::default();
    world.run_until(at(5_500), &mut memory).unwrap();
    world.kill(node);
    world.start(node);
    world.run_until(at(8_000), &mut memory).unwrap();
    assert_eq!(memory.cycles.last().unwrap().tick.count, 2);
}
