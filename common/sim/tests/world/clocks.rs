//! Cycles on drifting clocks.

use coaxle_clock::Span;
use coaxle_sim::World;

use crate::toy::{Memory, Seen, at, run, toy};

fn cycles(clock: &str, micros: i64) -> (World<crate::toy::Toy>, Vec<Seen>) {
    let mut world = World::new();
    world.add_node(toy("belt", clock, &[])).expect("no files");
    let mut memory = Memory::default();
    run(&mut world, micros, &mut memory);
    (world, memory.cycles)
}

#[test]
fn a_node_wakes_when_its_own_clock_says_so() {
    let (world, cycles) = cycles("drift-ppm = 1000", 100_000);
    assert_eq!(cycles.len(), 101, "cycle 100 begins at 99.9 ms");
    for (count, seen) in cycles.iter().enumerate() {
        assert_eq!(seen.tick.count, count as u64);
        // A clock that is fast by 1000 ppm reaches its milliseconds after 1/1.001 of them.
        let expected = at(0) + Span::from_secs_f64(count as f64 * 1e-3 / 1.001);
        assert!(
            (seen.woke - expected).abs() <= Span::from_nanos(1),
            "{seen:?}"
        );
        assert!(
            (seen.ideal_start - expected).abs() <= Span::from_nanos(1),
            "{seen:?}"
        );
    }
    assert_eq!(world.drift_ppm(0), 1000.0);
}

#[test]
fn the_first_cycle_comes_after_the_start_phase() {
    let (_, cycles) = cycles("start-phase-us = 250", 3_000);
    let woke: Vec<_> = cycles.iter().map(|seen| seen.woke).collect();
    assert_eq!(woke, [at(250), at(1_250), at(2_250)]);
}

#[test]
fn jitter_moves_the_wake_up_and_not_the_ideal_start() {
    let (_, cycles) = cycles("jitter = { normal-us = 20 }", 1_000_000);
    let mut early = 0;
    for (count, seen) in cycles.iter().enumerate() {
        assert_eq!(seen.tick.elapsed, 1);
        assert_eq!(seen.ideal_start, at(count as i64 * 1_000));
        // Five sigmas, which a thousand normal deviates do not exceed with this seed.
        assert!((seen.woke - seen.ideal_start).abs() < Span::from_micros(100));
        early += usize::from(seen.woke < seen.ideal_start);
    }
    // Half of 1000, with six standard deviations of √250 to either side.
    assert!((400..600).contains(&early), "{early} of {}", cycles.len());
}

#[test]
fn a_phase_step_brings_the_next_cycles_forward() {
    let (_, cycles) = cycles("steps = [{ at-s = 0.0105, phase-us = 200 }]", 13_000);
    let woke: Vec<_> = cycles.iter().skip(10).map(|seen| seen.woke).collect();
    // The clock jumps ahead by 200 µs between cycles 10 and 11.
    assert_eq!(woke, [at(10_000), at(10_800), at(11_800), at(12_800)]);
}

#[test]
fn time_flows_up_to_the_end_without_it() {
    let mut world = World::new();
    world.add_node(toy("belt", "", &[])).expect("no files");
    let mut memory = Memory::default();
    run(&mut world, 2_000, &mut memory);
    assert_eq!((memory.cycles.len(), world.now()), (2, at(2_000)));
    run(&mut world, 2_001, &mut memory);
    assert_eq!((memory.cycles.len(), world.now()), (3, at(2_001)));
}

#[test]
fn nodes_take_their_cycles_in_the_order_of_true_time() {
    let mut world = World::new();
    for (name, clock) in [
        ("a", "drift-ppm = 900"),
        ("b", "start-phase-us = 100"),
        ("c", ""),
    ] {
        world.add_node(toy(name, clock, &[])).expect("no files");
    }
    let mut memory = Memory::default();
    run(&mut world, 500_000, &mut memory);
    assert!(memory.cycles.is_sorted_by_key(|seen| seen.woke));
    for index in 0..3 {
        assert!(memory.of(index).len() >= 499);
    }
}
