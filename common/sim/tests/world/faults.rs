//! Nodes that die, freeze, and return; and orders to them.

use coaxle_clock::{Instant, Span};

use crate::toy::{BELT, Memory, SAW, Seen, at, belt_and_saw, order, run};

fn woke(cycles: &[Seen]) -> Vec<i64> {
    cycles
        .iter()
        .map(|seen| seen.woke.as_nanos() / 1_000)
        .collect()
}

#[test]
fn a_node_that_is_killed_does_nothing_and_hears_nothing() {
    let mut world = belt_and_saw("", "", &["latency-us = 100"]);
    let mut memory = Memory::default();
    run(&mut world, 2_500, &mut memory);
    world.kill(BELT);
    assert!(world.node(BELT).is_none());
    run(&mut world, 5_500, &mut memory);
    assert_eq!(woke(&memory.of(BELT)), [0, 1_000, 2_000]);
    assert_eq!(memory.of(SAW).len(), 6);
    assert_eq!(world.node(SAW).unwrap().received.len(), 3);
}

#[test]
fn a_node_is_started_anew_on_the_same_clock() {
    let mut world = belt_and_saw("drift-ppm = 1000\nstart-phase-us = 200", "", &[]);
    let mut memory = Memory::default();
    run(&mut world, 2_500, &mut memory);
    world.kill(BELT);
    run(&mut world, 4_000, &mut memory);
    world.start(BELT);
    run(&mut world, 5_300, &mut memory);
    let again: Vec<_> = memory
        .of(BELT)
        .into_iter()
        .filter(|seen| seen.run == 2)
        .collect();
    let counts: Vec<_> = again.iter().map(|seen| seen.tick.count).collect();
    assert_eq!(counts, [0, 1]);
    // The clock kept running: 4 ms of true time are 4.004 ms of its own.
    let start = Instant::EPOCH + Span::from_micros(4_204);
    assert!((again[0].tick.ideal_start - start).abs() <= Span::from_nanos(1));
    assert!((again[0].woke - at(4_200)).abs() <= Span::from_micros(1));
}

#[test]
fn a_node_that_is_started_between_two_cycles_has_no_cycle_of_its_former_run() {
    let mut world = belt_and_saw("", "", &[]);
    let mut memory = Memory::default();
    run(&mut world, 2_300, &mut memory);
    world.kill(BELT);
    world.start(BELT);
    run(&mut world, 5_000, &mut memory);
    assert_eq!(
        woke(&memory.of(BELT)),
        [0, 1_000, 2_000, 2_300, 3_300, 4_300]
    );
}

#[test]
fn messages_wait_for_a_frozen_node_and_arrive_when_it_goes_on() {
    let mut world = belt_and_saw("", "", &["latency-us = 100"]);
    let mut memory = Memory::default();
    run(&mut world, 2_500, &mut memory);
    world.stop(SAW);
    run(&mut world, 5_700, &mut memory);
    assert_eq!(memory.of(SAW).len(), 3);
    world.resume(SAW);
    run(&mut world, 8_000, &mut memory);
    let received = world.node(SAW).unwrap().counts();
    let expected = [
        (100, 0),
        (1_100, 1),
        (2_100, 2),
        (5_700, 3),
        (5_700, 4),
        (5_700, 5),
        (6_100, 6),
        (7_100, 7),
    ];
    let expected = expected.map(|(micros, count)| (Instant::from_nanos(micros * 1_000), count));
    assert_eq!(received, expected);
    // Late for cycle 3, it continues at once with the newest that has begun.
    let cycles = memory.of(SAW);
    assert_eq!(woke(&cycles), [0, 1_000, 2_000, 5_700, 6_000, 7_000]);
    let late = cycles[3].tick;
    assert_eq!((late.count, late.elapsed), (5, 3));
}

#[test]
fn a_backlog_in_pieces_comes_a_hundred_at_a_time_and_what_is_sent_meanwhile_behind_it() {
    let mut world = belt_and_saw("", "", &["latency-us = 100"]);
    let mut memory = Memory::default();
    run(&mut world, 2_500, &mut memory);
    world.stop(SAW);
    run(&mut world, 252_500, &mut memory);
    world.resume_in_pieces(SAW);
    run(&mut world, 256_000, &mut memory);
    let received = world.node(SAW).unwrap().counts();
    let counts: Vec<u64> = received.iter().map(|(_, count)| *count).collect();
    assert_eq!(counts, (0..=255).collect::<Vec<_>>());
    let at = |count: usize| received[count].0.as_nanos() / 1_000;
    // Messages 3 to 252 waited: pieces of 100, a millisecond apart.
    assert_eq!(
        [at(3), at(102), at(103), at(203)],
        [252_500, 252_500, 253_500, 254_500]
    );
    // Sent while the backlog arrived, and after it.
    assert_eq!([at(253), at(254), at(255)], [254_500, 254_500, 255_100]);
    assert_eq!(world.traffic().waiting, 0);
}

#[test]
fn a_node_that_freezes_only_between_two_cycles_misses_none_and_has_none_twice() {
    let mut world = belt_and_saw("", "", &[]);
    let mut memory = Memory::default();
    for pause in [2_300, 3_300, 3_600] {
        run(&mut world, pause, &mut memory);
        world.stop(SAW);
        run(&mut world, pause + 200, &mut memory);
        world.resume(SAW);
    }
    run(&mut world, 7_000, &mut memory);
    assert_eq!(
        woke(&memory.of(SAW)),
        [0, 1_000, 2_000, 3_000, 4_000, 5_000, 6_000]
    );
}

#[test]
fn freezing_and_going_on_mean_nothing_to_the_dead_and_going_on_nothing_to_the_living() {
    let mut world = belt_and_saw("", "", &[]);
    let mut memory = Memory::default();
    world.resume(BELT);
    world.kill(SAW);
    world.stop(SAW);
    world.resume(SAW);
    run(&mut world, 3_000, &mut memory);
    assert_eq!(woke(&memory.of(BELT)), [0, 1_000, 2_000]);
    assert_eq!(memory.of(SAW), []);
    assert!(world.node(SAW).is_none());
}

#[test]
fn a_frozen_node_that_is_killed_loses_what_waits_for_it() {
    let mut world = belt_and_saw("", "", &[]);
    let mut memory = Memory::default();
    world.stop(SAW);
    run(&mut world, 2_500, &mut memory);
    world.kill(SAW);
    world.start(SAW);
    run(&mut world, 3_500, &mut memory);
    let counts: Vec<_> = world.node(SAW).unwrap().counts();
    assert_eq!(
        counts
            .into_iter()
            .map(|(_, count)| count)
            .collect::<Vec<_>>(),
        [3]
    );
}

#[test]
fn an_order_is_executed_at_the_beginning_of_the_next_cycle_once() {
    let mut world = belt_and_saw("", "", &[]);
    let mut memory = Memory::default();
    run(&mut world, 1_500, &mut memory);
    world.order(SAW, 7, order("first"));
    world.order(SAW, 4, order("second"));
    assert!(memory.orders.is_empty());
    run(&mut world, 4_000, &mut memory);
    assert_eq!(memory.orders, [7, 4]);
    let expected = ["first", "second"].map(|slave| (slave.to_owned(), Some(1)));
    assert_eq!(world.node(SAW).unwrap().executed, expected);
    assert!(world.node(BELT).unwrap().executed.is_empty());
}

#[test]
fn orders_wait_for_the_frozen_and_die_with_the_dead() {
    let mut world = belt_and_saw("", "", &[]);
    let mut memory = Memory::default();
    run(&mut world, 1_500, &mut memory);
    world.stop(BELT);
    world.order(BELT, 0, order("waits"));
    world.order(SAW, 1, order("dies"));
    world.kill(SAW);
    world.order(SAW, 2, order("unheard"));
    world.start(SAW);
    run(&mut world, 4_500, &mut memory);
    assert!(memory.orders.is_empty());
    world.resume(BELT);
    run(&mut world, 6_000, &mut memory);
    assert_eq!(memory.orders, [0]);
}
