//! Frames on their way from node to node.

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::{Arrived, Channel};
use coaxle_sim::{Traffic, World};

use crate::toy::{BELT, Memory, SAW, Toy, at, belt_and_saw, link, link_of, run, toy};

fn local(micros: i64) -> Instant<Local> {
    Instant::from_nanos(micros * 1_000)
}

#[test]
fn a_frame_arrives_after_the_delay_of_its_link_in_the_receivers_own_clock() {
    let mut world = belt_and_saw("", "drift-ppm = 1000", &["latency-us = 400"]);
    run(&mut world, 11_000, &mut Memory::default());
    let received = world.node(SAW).unwrap().counts();
    assert_eq!(received.len(), 11);
    for (k, (arrived, count)) in received.into_iter().enumerate() {
        assert_eq!(count, k as u64);
        let micros = 1.001 * (k as f64 * 1_000.0 + 400.0);
        let expected = local(0) + Span::from_micros_f64(micros);
        assert!(
            (arrived - expected).abs() <= Span::from_nanos(1),
            "{arrived:?}"
        );
    }
}

#[test]
fn models_in_a_row_add_their_delays_and_each_may_repeat() {
    let twice = "latency-us = 30\nduplication = 1";
    let mut world = belt_and_saw("", "", &[twice, "latency-us = 50\nduplication = 1"]);
    run(&mut world, 500, &mut Memory::default());
    // 30 + 50 µs, and two copies of two copies.
    assert_eq!(world.node(SAW).unwrap().counts(), [(local(80), 0); 4]);
}

#[test]
fn each_model_judges_by_when_the_frame_was_sent() {
    let late = "latency-us = 5000";
    let cut = "partitions = [{ at-s = 0.002, for-s = 0.002 }]";
    let mut world = belt_and_saw("", "", &[late, cut]);
    run(&mut world, 12_000, &mut Memory::default());
    let counts: Vec<_> = world.node(SAW).unwrap().counts();
    let counts: Vec<_> = counts.into_iter().map(|(_, count)| count).collect();
    // Frames 2 and 3 are sent during the partition, and arrive by their delay long after it.
    assert_eq!(counts, [0, 1, 4, 5, 6]);
}

#[test]
fn each_model_has_numbers_of_its_own() {
    let half = "loss = 0.5";
    let mut world = belt_and_saw("", "", &[half, half]);
    run(&mut world, 4_000_000, &mut Memory::default());
    let arrived = world.node(SAW).unwrap().received.len();
    // A quarter of 4000, five standard deviations of 27. With shared numbers it would be half.
    assert!((850..1_150).contains(&arrived), "{arrived} of 4000");
}

#[test]
fn a_frame_goes_to_all_who_subscribe_to_its_channel_and_to_nobody_else() {
    let mut world = World::new();
    let belt = world
        .add_node(toy("belt", "", &[Channel::Axes, Channel::Slaves]))
        .expect("no files");
    let others = ["a", "b", "c", "d"].map(|name| {
        world
            .add_node(toy(name, "", &[Channel::Axes]))
            .expect("no files")
    });
    world
        .add_link(link(belt, others[0], &[]))
        .expect("no files");
    world
        .add_link(link(belt, others[1], &["latency-us = 10"]))
        .expect("no files");
    world
        .add_link(link_of(
            Channel::Slaves,
            belt,
            others[2],
            &["latency-us = 20"],
        ))
        .expect("no files");
    run(&mut world, 1_000, &mut Memory::default());
    let received = |index| {
        let counts = world.node(index).unwrap().counts();
        counts.into_iter().map(|(at, _)| at).collect::<Vec<_>>()
    };
    assert_eq!(received(belt), []);
    assert_eq!(
        others.map(received),
        [vec![local(0)], vec![local(10)], vec![local(20)], vec![]]
    );
}

#[test]
fn a_node_is_told_what_somebody_subscribes_to_in_each_of_its_runs() {
    let mut world = belt_and_saw("", "", &[]);
    let subscribed = |world: &World<_>, node| {
        let node: &Toy = world.node(node).expect("it runs");
        node.subscribed.clone()
    };
    for _ in 0..2 {
        assert_eq!(subscribed(&world, BELT), [Channel::Axes]);
        assert_eq!(subscribed(&world, SAW), []);
        world.kill(BELT);
        world.start(BELT);
    }
}

#[test]
fn frames_that_arrive_together_come_in_the_order_of_sending() {
    // The delay falls by as much as a cycle lasts.
    let step = "latency-us = 3000\ndelay-steps = [{ at-s = 0.002, by-us = -1000 }]";
    let mut world = belt_and_saw("", "", &[step]);
    run(&mut world, 6_000, &mut Memory::default());
    let expected = [(3_000, 0), (4_000, 1), (4_000, 2), (5_000, 3)];
    let expected = expected.map(|(at, count)| (local(at), count));
    assert_eq!(world.node(SAW).unwrap().counts(), expected);
}

#[test]
fn every_message_is_delivered_lost_dropped_or_under_way() {
    let rough = "latency-us = 2000\nloss = 0.2\nduplication = 0.3\nreorder = 0.3\nreorder-us = 50000\n\
                 burst-loss = { begins = 0.01, ends = 0.1 }\npartitions = [{ at-s = 0.5, for-s = 0.2 }]";
    let forged = "corruption = 0.1\nduplication = 0.1\n\
                  forgeries = [{ at-s = 0.1, for-s = 3, what = 'noise', times = 2 }, \
                  { at-s = 1, for-s = 0.5, what = 'first-again', instead = true }]";
    let mut world = belt_and_saw("", "", &[rough, forged]);
    let mut memory = Memory::default();
    let mut largest = Traffic::default();
    for step in 1..=400 {
        match step {
            100 | 300 => world.stop(SAW),
            150 => world.resume(SAW),
            200 | 320 => world.kill(SAW),
            250 | 350 => world.start(SAW),
            _ => {}
        }
        run(&mut world, 10_000 * step, &mut memory);
        let traffic = world.traffic();
        let Traffic {
            sent,
            added,
            lost,
            delivered,
            dropped,
            waiting,
            under_way,
        } = traffic;
        assert_eq!(sent, memory.of(BELT).len() as u64);
        assert_eq!(
            sent + added,
            lost + delivered + dropped + waiting + under_way,
            "{traffic:?}"
        );
        largest.waiting = largest.waiting.max(waiting);
        largest.under_way = largest.under_way.max(under_way);
        largest = Traffic {
            waiting: largest.waiting,
            under_way: largest.under_way,
            ..traffic
        };
    }
    let least = [
        largest.added,
        largest.lost,
        largest.delivered,
        largest.dropped,
    ];
    // Each kind of end must have occurred often, or the sum says nothing of it.
    assert!(
        least.iter().all(|count| *count > 500) && largest.waiting > 100 && largest.under_way > 10,
        "{largest:?}"
    );
}

#[test]
fn a_frame_says_how_late_it_left_in_the_senders_own_clock() {
    let late = "drift-ppm = 1000\njitter = { uniform-us = 300 }";
    let mut world = belt_and_saw(late, "", &[]);
    let mut memory = Memory::default();
    run(&mut world, 100_000, &mut memory);
    let stamps = world.node(SAW).unwrap().send_stamps();
    let cycles = memory.of(BELT);
    assert_eq!(stamps.len(), cycles.len());
    for (stamp, seen) in stamps.into_iter().zip(cycles) {
        let true_lateness = (seen.woke - seen.ideal_start).as_micros_f64();
        let off = stamp.unwrap().as_micros_f64() - 1.001 * true_lateness;
        // Instants are whole nanoseconds, of three clocks.
        assert!(off.abs() < 0.003, "{off} µs");
    }
}

#[test]
fn who_sends_no_stamps_still_stamps_what_carries_no_axes() {
    let mut world = World::new();
    let mut setup = toy("belt", "", &[Channel::Axes, Channel::TimeResponses]);
    setup.send_stamps = false;
    let belt = world.add_node(setup).expect("no files");
    let (axes, responses) = (
        world.add_node(toy("a", "", &[])).expect("no files"),
        world.add_node(toy("b", "", &[])).expect("no files"),
    );
    world.add_link(link(belt, axes, &[])).expect("no files");
    world
        .add_link(link_of(Channel::TimeResponses, belt, responses, &[]))
        .expect("no files");
    run(&mut world, 1_000, &mut Memory::default());
    let stamps = |index| world.node(index).unwrap().send_stamps();
    assert_eq!(stamps(axes), [None]);
    assert_eq!(stamps(responses), [Some(Span::ZERO)]);
}

#[test]
fn an_arrival_is_told_with_the_cycle_that_took_it_in_and_before_that_is() {
    let mut world = belt_and_saw("", "drift-ppm = -100", &["latency-us = 400"]);
    let mut memory = Memory::default();
    run(&mut world, 10_000, &mut memory);
    let cycles = memory.of(SAW);
    assert_eq!(
        memory.arrived.len(),
        9,
        "the tenth waits for the next cycle"
    );
    for (k, (index, ideal_start, tick, arrival)) in memory.arrived.iter().enumerate() {
        let Arrived::Message(header) = arrival.what else {
            panic!("{arrival:?}");
        };
        assert_eq!((*index, header.count), (SAW, k as u64));
        // An arrival at k + 0.4 ms is taken in by the cycle at k + 1 ms.
        assert_eq!(
            (*tick, *ideal_start),
            (cycles[k + 1].tick, cycles[k + 1].ideal_start)
        );
        assert_eq!(cycles[k + 1].arrivals, k + 1);
    }
    assert_eq!(memory.of(BELT).len(), 10);
    assert_eq!(world.now(), at(10_000));
}
