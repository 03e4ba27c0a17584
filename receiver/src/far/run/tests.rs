use super::*;
use Admission::{Begins, Followed, Foreign};
use coaxle_clock::CycleIndex;

fn header(epoch: u64, count: u64) -> FrameHeader {
    with_cycle_time(epoch, count, 1)
}

fn with_cycle_time(epoch: u64, count: u64, millis: i64) -> FrameHeader {
    FrameHeader {
        sender: 1,
        epoch,
        index: CycleIndex::of_count(count),
        count,
        cycle_time: CycleTime::new(Span::from_millis(millis)).unwrap(),
        present_after: None,
        send_stamp: None,
    }
}

fn at(millis: i64) -> Instant<Local> {
    Instant::EPOCH + Span::from_millis(millis)
}

/// Judges a run from its count 0 at `start` on, a frame per millisecond.
fn run(choice: &mut RunChoice, epoch: u64, start: i64, from: i64, to: i64) -> Vec<Admission> {
    let judged = (from..to).map(|now| {
        let header = header(epoch, (now - start) as u64);
        choice.judge(at(now), &header)
    });
    judged.collect()
}

#[test]
fn the_first_run_is_followed_at_once() {
    let mut choice = RunChoice::default();
    let judged = run(&mut choice, 1, 0, 0, 100);
    assert_eq!(judged[0], Begins);
    assert!(judged[1..].iter().all(|one| *one == Followed));
}

#[test]
fn a_new_run_takes_over_when_the_one_before_is_silent() {
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 0, 0, 100);
    let judged = run(&mut choice, 2, 100, 100, 200);
    let begins = judged.iter().position(|one| *one == Begins);
    assert_eq!(begins, Some(9), "silent for 10 ms");
    assert!(judged[10..].iter().all(|one| *one == Followed));
    // A delayed frame of the first run.
    assert_eq!(choice.judge(at(200), &header(1, 99)), Foreign);
    assert_eq!(choice.rival(at(200)), None);
}

#[test]
fn a_second_node_is_named_and_not_followed_until_the_first_is_silent() {
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 0, 0, 100);
    for now in 100..3_000 {
        assert_eq!(choice.judge(at(now), &header(1, now as u64)), Followed);
        assert_eq!(choice.judge(at(now), &header(7, now as u64 + 50)), Foreign);
    }
    assert_eq!(choice.rival(at(3_000)), Some(7));
    let judged = run(&mut choice, 7, -50, 3_000, 5_000);
    let begins = judged.iter().position(|one| *one == Begins);
    assert_eq!(begins, Some(999), "after a second");
    // The first one returns: as a duplicate, but an ended one.
    assert_eq!(choice.judge(at(5_000), &header(1, 5_000)), Foreign);
    assert_eq!(choice.judge(at(5_000), &header(7, 5_050)), Followed);
}

#[test]
fn a_run_that_was_taken_over_from_is_followed_again_when_nothing_else_is_heard() {
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 0, 0, 100);
    // The first run is silent for a while, and a second node takes over, while it continues.
    assert!(run(&mut choice, 7, 100, 200, 300).contains(&Begins));
    for now in 300..2_000 {
        assert_eq!(
            choice.judge(at(now), &header(7, now as u64 - 100)),
            Followed
        );
        assert_eq!(choice.judge(at(now), &header(1, now as u64)), Foreign);
    }
    assert_eq!(choice.rival(at(2_000)), Some(1));
    let judged = run(&mut choice, 1, 0, 2_000, 4_000);
    let begins = judged.iter().position(|one| *one == Begins);
    assert_eq!(begins, Some(999), "after a second");
    assert!(judged[1_000..].iter().all(|one| *one == Followed));
    // The first run is taken over from again as any other.
    assert!(run(&mut choice, 8, 4_000, 4_010, 4_100).contains(&Begins));
}

#[test]
fn what_is_left_of_an_ended_run_keeps_no_new_one_from_taking_over_and_is_no_rival() {
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 0, 0, 100);
    assert!(run(&mut choice, 2, 100, 110, 200).contains(&Begins));
    // The node is started a third time; frames of its first run come between.
    let mut begins = None;
    for now in 300..900 {
        assert_eq!(choice.judge(at(now), &header(1, now as u64 - 250)), Foreign);
        if choice.judge(at(now), &header(3, now as u64 - 300)) == Begins {
            begins = begins.or(Some(now - 300));
        }
        assert_eq!(choice.rival(at(now)), None);
    }
    assert_eq!(begins, Some(4));
}

#[test]
fn a_second_node_that_falls_silent_is_forgotten() {
    let mut choice = RunChoice::default();
    for now in 0..100 {
        choice.judge(at(now), &header(1, now as u64));
        choice.judge(at(now), &header(7, now as u64));
    }
    assert_eq!(choice.rival(at(1_000)), Some(7));
    assert_eq!(choice.rival(at(1_200)), None);
}

#[test]
fn stray_frames_move_nothing() {
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 0, 0, 100);
    for stray in [
        header(3, 5),
        header(1, 1_000_000_000_000),
        header(1, u64::MAX),
        with_cycle_time(1, 100, 2),
    ] {
        assert_eq!(choice.judge(at(100), &stray), Foreign);
    }
    assert_eq!(choice.judge(at(100), &header(1, 100)), Followed);
    // A single one while the node is silent for a while.
    assert_eq!(choice.judge(at(900), &header(3, 6)), Foreign);
    assert_eq!(choice.judge(at(901), &header(1, 901)), Followed);
}

#[test]
fn a_count_that_is_ahead_of_all_that_came_is_no_frame_of_the_run() {
    for ahead in [150, 1_000, 100_000] {
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 100);
        for now in 100..2_000 {
            let forged = header(1, (now + ahead) as u64);
            assert_eq!(choice.judge(at(now), &forged), Foreign);
            assert_eq!(choice.judge(at(now), &header(1, now as u64)), Followed);
        }
    }
}

#[test]
fn a_delay_that_shrinks_or_was_long_for_a_while_is_none_of_another_run() {
    // Fifty milliseconds less than ever.
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 50, 50, 1_000);
    assert_eq!(run(&mut choice, 1, 0, 1_000, 3_000), vec![Followed; 2_000]);
    // Nine hundred more for three seconds, then as before.
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 0, 0, 1_000);
    let late = run(&mut choice, 1, 900, 1_900, 4_000);
    assert_eq!(late, vec![Followed; 2_100]);
    assert_eq!(run(&mut choice, 1, 0, 4_000, 5_000), vec![Followed; 1_000]);
}

#[test]
fn a_clock_that_is_off_by_a_tenth_keeps_its_run() {
    for micros in [900, 1_100] {
        let mut choice = RunChoice::default();
        let judged = (0..100_000).map(|count| {
            let at = Instant::EPOCH + Span::from_micros(micros * count as i64);
            choice.judge(at, &header(1, count))
        });
        assert_eq!(judged.filter(|one| *one == Begins).count(), 1, "{micros}");
    }
}

#[test]
fn a_backlog_is_left_to_who_judges_ages() {
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 0, 0, 100);
    for count in 100..3_000 {
        assert_eq!(choice.judge(at(3_100), &header(1, count)), Followed);
    }
    assert_eq!(choice.judge(at(3_100), &header(1, 3_100)), Followed);
}

#[test]
fn a_backlog_is_no_second_node() {
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 0, 0, 100);
    for count in 100..3_000 {
        choice.judge(at(3_100), &header(1, count));
    }
    run(&mut choice, 1, 0, 3_100, 3_200);
    assert_eq!(choice.rival(at(3_200)), None);
}

#[test]
fn a_stray_frame_does_not_take_over_in_place_of_a_new_run() {
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 0, 0, 100);
    let judged = run(&mut choice, 2, 100, 100, 109);
    assert!(judged.iter().all(|one| *one == Foreign), "not yet");
    // Now the first run is silent for long enough.
    assert_eq!(choice.judge(at(110), &header(3, 7)), Foreign);
    assert_eq!(choice.judge(at(110), &header(2, 10)), Begins);
}

#[test]
fn another_cycle_time_or_count_is_followed_once_it_came_regularly_for_a_second() {
    for first in [5_000_000, 5] {
        let mut choice = RunChoice::default();
        let far = run(&mut choice, 1, -3_000_000, 0, 100);
        assert_eq!(far[99], Followed);
        let judged = run(&mut choice, 1, -first, 100, 2_100);
        let begins = judged.iter().position(|one| *one == Begins);
        assert_eq!(begins, Some(1_000));
        assert_eq!(judged[1_001..], vec![Followed; 999]);
    }
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 0, 0, 100);
    let judged = (0..1_000).map(|n| {
        let header = with_cycle_time(1, 50 + n as u64, 2);
        choice.judge(at(100 + 2 * n), &header)
    });
    let judged: Vec<_> = judged.collect();
    assert_eq!(judged.iter().position(|one| *one == Begins), Some(500));
    assert_eq!(judged[501..], vec![Followed; 499]);
}

#[test]
fn a_frame_that_is_repeated_for_ever_is_no_run() {
    for (epoch, count) in [(1, 0), (1, 1_000_000), (2, 0)] {
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 100);
        // While the run is silent, and no matter for how long.
        for now in 5_000..9_000 {
            let judged = choice.judge(at(now), &header(epoch, count));
            assert_ne!(judged, Begins, "{epoch} {count} at {now}");
        }
        assert_eq!(choice.judge(at(9_000), &header(1, 9_000)), Followed);
    }
}

#[test]
fn of_two_others_the_one_that_is_heard_takes_over() {
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 0, 0, 100);
    let mut begun = 0;
    for now in 100..200 {
        for epoch in [4, 5] {
            let judged = choice.judge(at(now), &header(epoch, now as u64));
            begun += u32::from(judged == Begins);
        }
    }
    assert_eq!(begun, 1);
    let now = at(200);
    assert!(choice.can_be_followed(now, &header(4, 200)));
    assert!(!choice.can_be_followed(now, &header(5, 200)));
}

/// A receiver that stands still repeatedly: each time it finds a backlog, of which it takes a piece
/// per cycle, stamped on removal.
#[test]
fn a_backlog_that_comes_in_pieces_is_never_another_run() {
    for piece in [1, 3, 20, 200, 1_000] {
        let mut choice = RunChoice::default();
        let (mut now, mut sent, mut judged) = (0, 0, Vec::new());
        let mut scan = |now: i64| {
            for _ in 0..=piece {
                if sent < now {
                    judged.push(choice.judge(at(now), &header(1, sent as u64)));
                    sent += 1;
                }
            }
        };
        for stopped in [2_000, 2_000, 1_500, 3_000, 1_900, 2_500] {
            for _ in 0..4_000 {
                now += 1;
                scan(now);
            }
            now += stopped;
        }
        scan(now);
        assert!(judged[1..].iter().all(|one| *one == Followed), "{piece}");
        assert_eq!(choice.foreign(), 0, "{piece}");
    }
}

#[test]
fn a_count_that_fell_behind_for_good_is_followed_after_a_second() {
    let mut choice = RunChoice::default();
    run(&mut choice, 1, 0, 0, 5_000);
    // The sender's machine slept for three seconds, and its clock with it.
    let judged = run(&mut choice, 1, 3_000, 8_000, 11_000);
    let begins = judged.iter().position(|one| *one == Begins);
    assert_eq!(begins, Some(1_000));
    assert_eq!(
        run(&mut choice, 1, 3_000, 11_000, 12_000),
        vec![Followed; 1_000]
    );
}
