//! Plans that agree, and plans that do not.

use std::vec::Vec;

use super::*;

fn ms(millis: i64) -> Span {
    Span::from_millis(millis)
}

/// A master that stands at 100 u, accelerates from 1 s on with a jerk of 10 000 u/s³ for 0.1 s, and keeps its velocity of
/// 100 u/s then.
fn motion() -> [MotionPiece; 4] {
    let mut from = Kinematics::at_rest(100.0);
    let mut start = Span::ZERO;
    [
        (1_000, 0.0),
        (100, 10_000.0),
        (100, -10_000.0),
        (60_000, 0.0),
    ]
    .map(|(lasts, jerk)| {
        let piece = MotionPiece {
            start,
            duration: ms(lasts),
            from,
            jerk,
        };
        start = piece.end();
        from = piece.at(start, Seconds::ZERO);
        piece
    })
}

fn truth(at: Span) -> Kinematics {
    let pieces = motion();
    piece_at(&pieces, at).unwrap().at(at, Seconds::ZERO)
}

/// The pieces of the master from a cycle on, up to a promise.
fn ahead(count: u64, until: Span) -> Vec<MotionPiece> {
    let now = ms(count as i64);
    let pieces = motion().into_iter();
    pieces
        .filter(|it| it.end() > now && it.start < until)
        .collect()
}

fn take(planned: &mut PlannedMotion, count: u64, lead: i64) -> Result<(), PlanFault> {
    let promised_until = ms(count as i64 + lead);
    let pieces = ahead(count, promised_until);
    planned.take(&ReceivedPlan {
        count,
        pieces: &pieces,
        promised_until,
    })
}

/// A motion that is planned every 100 ms up to `count`, each time for the next `lead` ms, and confirmed.
fn planned(count: u64, lead: i64) -> PlannedMotion {
    let mut planned = PlannedMotion::default();
    for count in (0..=count).step_by(100) {
        take(&mut planned, count, lead).unwrap();
        let now = ms(count as i64);
        planned.check(now, &truth(now)).unwrap();
    }
    planned
}

#[test]
fn the_motion_is_known_up_to_the_promise() {
    let planned = planned(900, 300);
    assert_eq!(planned.known_until(), Some(ms(1_200)));
    for millis in 0..=1_300 {
        let (newest, after) = (ms(millis - 20), Seconds(0.02));
        let found = planned.at(newest, after);
        assert_eq!(found.is_some(), millis <= 1_200, "{millis}");
        assert_eq!(planned.reaches(newest, after), found.is_some());
        if let Some(found) = found {
            let off = found.position - truth(ms(millis)).position;
            assert!(off.abs() < 1e-10, "{millis} {off}");
        }
    }
}

#[test]
fn nothing_is_used_before_a_sample_has_confirmed_it() {
    let mut planned = PlannedMotion::default();
    assert_eq!(
        (planned.at(ms(0), Seconds(0.0)), planned.known_until()),
        (None, None)
    );
    take(&mut planned, 0, 300).unwrap();
    assert_eq!(planned.at(ms(5), Seconds(0.0)), None);
    // One that lies beyond the promise says nothing.
    planned.check(ms(400), &Kinematics::at_rest(0.0)).unwrap();
    assert!(!planned.reaches(ms(5), Seconds(0.0)));
    planned.check(ms(7), &truth(ms(7))).unwrap();
    assert_eq!(planned.at(ms(5), Seconds(0.0)), Some(truth(ms(5))));
}

#[test]
fn a_sample_beside_the_plan_ends_its_use() {
    let mut planned = planned(1_000, 300);
    let beside = |off: f64| {
        let mut sample = truth(ms(1_150));
        sample.position += off;
        sample
    };
    // A microsecond at the velocity there is 87.5 nm.
    planned.check(ms(1_150), &beside(80e-6)).unwrap();
    let contradiction = planned.check(ms(1_150), &beside(-90e-6));
    assert_eq!(contradiction, Err(PlanFault::Contradicted));
    assert_eq!(planned.at(ms(1_100), Seconds(0.0)), None);
    // A later plan is used again once a sample has confirmed it.
    take(&mut planned, 1_100, 300).unwrap();
    assert!(!planned.reaches(ms(1_200), Seconds(0.0)));
    planned.check(ms(1_160), &truth(ms(1_160))).unwrap();
    assert!(planned.reaches(ms(1_200), Seconds(0.0)));
    let lost = planned.check(ms(1_170), &Kinematics::at_rest(f64::NAN));
    assert_eq!(lost, Err(PlanFault::Contradicted));
}

#[test]
fn a_promise_neither_moves_back_nor_is_broken() {
    let mut planned = planned(900, 300);
    // Older ones, and the newest again.
    for count in [0, 300, 900] {
        take(&mut planned, count, 300).unwrap();
    }
    assert_eq!(
        take(&mut planned, 950, 200),
        Err(PlanFault::PromiseMovedBack)
    );
    assert_eq!(planned.known_until(), Some(ms(1_200)));
    // It stands on after 1 s, and the promise was that it does not.
    let standing = [MotionPiece {
        duration: ms(9_000),
        ..motion()[0]
    }];
    let broken = planned.take(&ReceivedPlan {
        count: 1_000,
        pieces: &standing,
        promised_until: ms(1_300),
    });
    assert_eq!(broken, Err(PlanFault::PromiseBroken));
    assert_eq!(planned.known_until(), None);
    // The samples decide.
    let moving = planned.check(ms(1_100), &truth(ms(1_100)));
    assert_eq!(moving, Err(PlanFault::Contradicted));
}

#[test]
fn what_was_only_intended_may_change() {
    let mut planned = PlannedMotion::default();
    // The whole of a move, of which the first 50 ms are promised.
    let whole = ReceivedPlan {
        count: 1_000,
        pieces: &motion()[1..],
        promised_until: ms(1_050),
    };
    planned.take(&whole).unwrap();
    planned.check(ms(1_000), &truth(ms(1_000))).unwrap();
    let then = truth(ms(1_060));
    let other = MotionPiece {
        start: ms(1_060),
        duration: ms(500),
        from: then,
        jerk: 0.0,
    };
    let first = MotionPiece {
        duration: ms(60),
        ..motion()[1]
    };
    let changed = planned.take(&ReceivedPlan {
        count: 1_020,
        pieces: &[first, other],
        promised_until: ms(1_500),
    });
    assert_eq!(changed, Ok(()));
    let found = planned.at(ms(1_100), Seconds::ZERO).unwrap();
    assert_eq!(found.acceleration, then.acceleration);
    // A plan from later on leaves a hole: nothing was promised there.
    let mut late = PlannedMotion::default();
    late.take(&whole).unwrap();
    late.check(ms(1_000), &truth(ms(1_000))).unwrap();
    take(&mut late, 1_400, 100).unwrap();
    for (millis, is_known) in [(1_050, true), (1_051, false), (1_199, false), (1_450, true)] {
        assert_eq!(
            late.reaches(ms(millis), Seconds::ZERO),
            is_known,
            "{millis}"
        );
    }
}

#[test]
fn the_oldest_pieces_make_room() {
    let mut planned = PlannedMotion::default();
    for n in 0..100_i64 {
        let pieces: [_; 8] = std::array::from_fn(|k| MotionPiece {
            start: ms(80 * n + 10 * k as i64),
            duration: ms(10),
            ..MotionPiece::default()
        });
        let promised_until = pieces[7].end();
        let plan = ReceivedPlan {
            count: 1 + n as u64,
            pieces: &pieces,
            promised_until,
        };
        planned.take(&plan).unwrap();
        planned
            .check(promised_until, &Kinematics::default())
            .unwrap();
        let known = |back| planned.reaches(promised_until - ms(back), Seconds::ZERO);
        assert_eq!((known(239), known(241)), (n >= 2, false), "{n}");
    }
}
