use super::*;
use coaxle_clock::{CycleIndex, CycleTime};

fn store(inbox: &mut Inbox, at: Instant<Local>, epoch: u64, count: u64) {
    store_frame(inbox, at, epoch, count, at);
}

fn store_frame(inbox: &mut Inbox, at: Instant<Local>, epoch: u64, count: u64, due: Instant<Local>) {
    let header = FrameHeader {
        sender: 1,
        epoch,
        index: CycleIndex::of_count(count),
        count,
        cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
        present_after: None,
        send_stamp: None,
    };
    let axes = [Some(AxisSample::default())];
    let frame = Frame {
        header,
        axes: &axes,
    };
    inbox.store(at, &frame, due);
}

fn at(micros: i64) -> Instant<Local> {
    Instant::EPOCH + Span::from_micros(micros)
}

fn inbox() -> Inbox {
    Inbox::new(Some(Span::from_millis(7)), 8, 1)
}

fn count_of(image: Option<FrameHeader>) -> Option<u64> {
    image.map(|header| header.count)
}

fn image(inbox: &mut Inbox, cycle_start: Instant<Local>) -> Option<FrameHeader> {
    let image = inbox.image(cycle_start, |_, _, _| {});
    inbox.end_cycle(cycle_start);
    image
}

/// Delivers a message of a run at the beginning of a cycle; returns the cycle's image.
fn cycle_with(inbox: &mut Inbox, now: i64, epoch: u64, count: u64) -> Option<FrameHeader> {
    store(inbox, at(now), epoch, count);
    image(inbox, at(now))
}

#[test]
fn a_cycle_sees_what_had_arrived_when_it_ideally_began() {
    let mut inbox = inbox();
    store(&mut inbox, at(900), 1, 0);
    store(&mut inbox, at(1_100), 1, 1);
    assert_eq!(count_of(image(&mut inbox, at(800))), None);
    assert_eq!(count_of(image(&mut inbox, at(1_000))), Some(0));
    assert_eq!(count_of(image(&mut inbox, at(2_000))), Some(1));
    assert_eq!(
        count_of(image(&mut inbox, at(3_000))),
        Some(1),
        "the image stays"
    );
}

#[test]
fn repeated_overtaken_and_lost_messages_are_told_apart() {
    let mut inbox = inbox();
    for (micros, count) in [
        (0, 10),
        (100, 12),
        (200, 11),
        (300, 12),
        (400, 11),
        (500, 15),
    ] {
        store(&mut inbox, at(micros), 1, count);
    }
    assert_eq!(count_of(image(&mut inbox, at(1_000))), Some(15));
    let counters = inbox.counters();
    assert_eq!(counters.duplicates, 2);
    assert_eq!(counters.late, 1);
    assert_eq!(counters.lost, 2, "13 and 14");
    assert_eq!(counters.received, 6);
}

/// Messages that are not accounted for: of those received, and of those expected.
fn balance(inbox: &Inbox) -> [i64; 2] {
    let counters = inbox.counters();
    let (waiting, foreign) = (inbox.waiting.len() as u64, inbox.choice.foreign());
    let gone = counters.overflow + foreign + waiting;
    let taken = counters.in_order + counters.late;
    let due = taken - counters.outdated + counters.lost;
    let apart = |one: u64, other: u64| one as i64 - other as i64;
    [
        apart(counters.received, taken + counters.duplicates + gone),
        apart(counters.expected, due),
    ]
}

#[test]
fn every_message_is_accounted_for_whatever_comes() {
    let mut inbox = inbox();
    let mut random = coaxle_node::faults::Random::new(3);
    let mut now = 0;
    for cycle in 0..20_000_u64 {
        now += 1_000;
        // A run of 5 s, a silence of 20 ms, and the next one.
        let (epoch, count) = (cycle / 5_000, cycle % 5_000);
        for _ in 0..(random.uniform() * 4.0) as u64 {
            let behind = (random.uniform().powi(4) * 200.0) as u64;
            let late = (random.uniform() * 1_500.0) as i64;
            let stray = u64::from(random.chance(0.01)) * 77;
            if count >= 20 {
                store(
                    &mut inbox,
                    at(now + late),
                    1 + epoch + stray,
                    count.saturating_sub(behind),
                );
            }
        }
        let _ = image(&mut inbox, at(now));
        assert_eq!(balance(&inbox), [0, 0], "cycle {cycle}");
    }
    let counters = inbox.counters();
    assert_eq!(counters.restarts, 3);
    for seen in [
        counters.in_order,
        counters.lost,
        counters.duplicates,
        counters.late,
        counters.stale,
        counters.outdated,
        inbox.choice.foreign(),
    ] {
        assert!(seen > 50, "{counters:?}");
    }
    for count in 0..2_000 {
        store(&mut inbox, at(now), 4, 5_000 + count);
    }
    assert_eq!(balance(&inbox), [0, 0]);
    assert!(inbox.counters().overflow > 900);
}

#[test]
fn a_new_run_of_the_sender_is_followed_when_the_one_before_is_silent() {
    let mut inbox = inbox();
    store(&mut inbox, at(0), 1, 70_000);
    store(&mut inbox, at(1_000), 1, 70_003);
    for count in 0..20 {
        let image = cycle_with(&mut inbox, 2_000 + 1_000 * count, 2, count as u64);
        let expected = if count > 9 { count as u64 } else { 70_003 };
        assert_eq!(count_of(image), Some(expected));
    }
    let counters = inbox.counters();
    assert_eq!((counters.restarts, counters.lost), (1, 2));
    // Stragglers of the previous run have no effect, and do not bring it back.
    store(&mut inbox, at(22_000), 1, 70_004);
    assert_eq!(count_of(image(&mut inbox, at(22_000))), Some(19));
    assert_eq!(inbox.counters().restarts, 1);
}

#[test]
fn a_restart_is_shown_with_the_epoch_of_the_run_that_began() {
    let mut inbox = inbox();
    for count in 0..5 {
        cycle_with(&mut inbox, 1_000 * count, 1, count as u64);
    }
    for count in 0..40 {
        let image = cycle_with(&mut inbox, 5_000 + 1_000 * count, 2, count as u64);
        let epoch = image.map(|header| header.epoch);
        let mut signals = FarNodeSignals::default();
        inbox.show(&mut signals);
        assert_eq!(epoch, Some(1 + signals.restarts), "frame {count}");
    }
    assert_eq!(inbox.counters().restarts, 1);
}

#[test]
fn stray_frames_move_nothing_and_push_out_nothing() {
    let mut inbox = inbox();
    store(&mut inbox, at(0), 1, 0);
    let _ = image(&mut inbox, at(0));
    store(&mut inbox, at(500), 1, 1);
    for stray in 0..50 {
        store(&mut inbox, at(600), 9, stray);
        store(&mut inbox, at(600), 1, u64::MAX - stray);
    }
    assert_eq!(count_of(image(&mut inbox, at(1_000))), Some(1));
    assert_eq!(inbox.counters().lost, 0);
    assert_eq!(inbox.choice.foreign(), 100);
}

#[test]
fn a_backlog_never_reaches_the_image() {
    let mut inbox = inbox();
    for count in 0..100 {
        cycle_with(&mut inbox, 1_000 * count, 1, count as u64);
    }
    // The receiver stood still for a second; half of the backlog arrives, all of it old.
    for count in 100..600 {
        store(&mut inbox, at(1_100_000), 1, count);
    }
    assert_eq!(count_of(image(&mut inbox, at(1_100_000))), Some(99));
    assert_eq!(inbox.counters().stale, 500);
    // Then they are in time: possibly part of the backlog, until they keep pace.
    for count in 1_101..1_105 {
        assert_eq!(
            count_of(cycle_with(&mut inbox, 1_000 * count, 1, count as u64)),
            Some(99)
        );
    }
    assert_eq!(
        count_of(cycle_with(&mut inbox, 1_105_000, 1, 1_105)),
        Some(1_105)
    );
}

#[test]
fn too_many_messages_push_out_the_oldest() {
    let mut inbox = inbox();
    for count in 0..INBOX_CAPACITY as u64 + 10 {
        store(&mut inbox, at(0), 1, count);
    }
    assert_eq!(inbox.counters().overflow, 10);
    assert_eq!(inbox.waiting.len(), INBOX_CAPACITY);
}

#[test]
fn refused_frames_are_counted_by_reason() {
    let mut inbox = inbox();
    inbox.reject(Rejection::WrongChecksum);
    inbox.reject(Rejection::WrongChecksum);
    inbox.reject(Rejection::Implausible);
    let rejected = inbox.counters().rejected;
    assert_eq!(rejected.of(Rejection::WrongChecksum), 2);
    assert_eq!(rejected.of(Rejection::Implausible), 1);
    assert_eq!(rejected.total(), 3);
}

#[test]
fn messages_held_back_for_longer_than_there_is_room_still_renew_the_image() {
    // 2 000 messages are under way, one per cycle of a millisecond.
    let latency = 2_000;
    let mut inbox = Inbox::new(Some(Span::from_millis(100)), 128, 1);
    for cycle in 0..3 * latency {
        let now = at(1_000 * cycle);
        let arrival = now + Span::from_millis(latency);
        store_frame(&mut inbox, arrival, 1, cycle as u64, now);
        let count = count_of(image(&mut inbox, now));
        if cycle >= latency {
            // 128 frames are kept, so that at worst every 32nd is.
            let age = (cycle - latency) as u64 - count.expect("an image");
            assert!(age < 32, "{cycle}: {age}");
        }
    }
    assert!(inbox.counters().overflow > 0);
    assert_eq!(inbox.waiting.len(), INBOX_CAPACITY);
}
