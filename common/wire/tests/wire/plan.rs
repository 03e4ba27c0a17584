//! Plans: round trip, refusals of a message and of a single plan.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use assert_no_alloc::assert_no_alloc;
use coaxle_axis::motion_plan::{MOST_PIECES, MotionPiece, MotionPlan, PlanFault};
use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_wire::frame::{KeySeal, sender_id};
use coaxle_wire::keys::NodeName;
use coaxle_wire::plan::{MAX_PLANS, PLANS_CAPACITY, encode_plans};
use coaxle_wire::{
    AxisPlan, Channel, Message, PlanIntake, PlannedPiece, Reader, Rejection, RunCycle,
};
use proptest::prelude::*;

fn name(name: &str) -> NodeName {
    NodeName::new(name).unwrap()
}

fn seal() -> KeySeal {
    KeySeal::new(&name("press").channel_key(Channel::Plans))
}

fn header() -> RunCycle {
    RunCycle {
        sender: sender_id(&name("press")),
        epoch: u64::MAX,
        count: 70_000,
    }
}

fn limits() -> Limits {
    Limits::new(1_000.0, 10_000.0, 9_000.0, 200_000.0).unwrap()
}

/// This number of pieces of 50 ms, with a jerk to and fro, from a start on.
fn pieces(count: usize, start: Span) -> Vec<MotionPiece> {
    let mut from = Kinematics::at_rest(-12.5);
    let piece = |n: usize| {
        let piece = MotionPiece {
            start: start + Span::from_millis(50 * n as i64),
            duration: Span::from_millis(50),
            from,
            jerk: if n % 4 < 2 { 1_000.0 } else { -1_000.0 },
        };
        from = piece.at(piece.end(), Seconds::ZERO);
        piece
    };
    (0..count).map(piece).collect()
}

fn plan(axis_id: u32, count: usize) -> AxisPlan {
    let pieces = pieces(count, Span::from_nanos(i64::MAX / 2));
    let end = pieces.last().unwrap().end();
    AxisPlan {
        axis_id,
        plan: MotionPlan::new(&pieces, end, &limits()).unwrap(),
    }
}

fn sealed(header: &RunCycle, plans: &[AxisPlan]) -> Vec<u8> {
    let mut body = [0; PLANS_CAPACITY];
    let length = encode_plans(header, plans, &mut body);
    let mut payload = Vec::new();
    seal().seal(&body[..length], Some(Span::from_micros(53)), &mut payload);
    payload
}

/// The messages to a follower of the axes 7 and 300.
fn read(payload: &[u8]) -> Vec<Message<'static>> {
    let mut messages = Vec::new();
    let mut reader = Reader::from(PlanIntake::new(&name("press"), &[300, 7]));
    reader.read(payload, |message| messages.push(message.split().0));
    messages
}

#[test]
fn plans_come_back_to_the_last_bit() {
    let plans: Vec<_> = (1..=8).map(|n| plan(n, n as usize)).collect();
    let mut back = Vec::new();
    let read = seal().open_plans(&sealed(&header(), &plans), |axis_id, plan| {
        back.push(AxisPlan {
            axis_id,
            plan: plan.unwrap(),
        });
    });
    assert_eq!(read, Ok(header()));
    assert_eq!(back, plans);
}

#[test]
fn a_follower_gets_the_pieces_of_its_axes() {
    let [other, seventh] = [plan(6, 1), plan(7, 3)];
    let messages = read(&sealed(&header(), &[other, seventh, plan(300, 1)]));
    let piece = |number: u8| PlannedPiece {
        epoch: u64::MAX,
        count: 70_000,
        // By the order in which it named them.
        axis: 1,
        number,
        of: 3,
        promised_until: seventh.plan.promised_until(),
        piece: seventh.plan.pieces()[usize::from(number)],
    };
    let expected = [0, 1, 2].map(|number| Message::PlannedPiece(piece(number)));
    assert_eq!(messages[..3], expected);
    let [Message::PlannedPiece(last)] = messages[3..] else {
        panic!("{messages:?}");
    };
    assert_eq!((last.axis, last.number, last.of), (0, 0, 1));
}

#[test]
fn a_message_that_is_no_plan_is_refused_with_its_reason() {
    let good = sealed(&header(), &[plan(7, 2)]);
    let changed = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut payload = good.clone();
        change(&mut payload);
        read(&payload)
    };
    let resealed = |body: &[u8], stamp| {
        let mut payload = Vec::new();
        seal().seal(body, stamp, &mut payload);
        read(&payload)
    };
    let foreign = RunCycle {
        sender: 1,
        ..header()
    };
    let mut body = [0; PLANS_CAPACITY];
    let length = encode_plans(&header(), &[plan(7, 2)], &mut body);
    // Behind version, sender, epoch and count.
    let number = 1 + 5 + 10 + 3;
    assert_eq!(body[number], 1);
    let mut nine = body;
    nine[number] = MAX_PLANS as u8 + 1;
    for (messages, reason) in [
        (changed(&|it| it[0] = 2), Rejection::WrongVersion),
        (changed(&|it| it.truncate(40)), Rejection::Truncated),
        (read(&[]), Rejection::Truncated),
        (changed(&|it| it[30] ^= 4), Rejection::WrongChecksum),
        (resealed(&nine[..length], None), Rejection::Malformed),
        (
            resealed(&[&body[..length], &[0]].concat(), None),
            Rejection::TrailingBytes,
        ),
        (
            read(&sealed(&foreign, &[plan(7, 2)])),
            Rejection::ForeignSender,
        ),
    ] {
        assert_eq!(messages, [Message::Rejected(reason)]);
    }
}

/// The bytes of a plan with any pieces and limits, as a node writes them that checks nothing.
fn unchecked(pieces: &[MotionPiece], limits: [f64; 4], promised_until: Span) -> Vec<u8> {
    type Piece = (i64, i64, [f64; 4]);
    let lines = pieces.iter().map(|piece| -> Piece {
        let Kinematics {
            position,
            velocity,
            acceleration,
        } = piece.from;
        let values = [position, velocity, acceleration, piece.jerk];
        (piece.start.as_nanos(), piece.duration.as_nanos(), values)
    });
    let lines: Vec<Piece> = lines.collect();
    let RunCycle {
        sender,
        epoch,
        count,
    } = header();
    let plan = (7_u32, limits, promised_until.as_nanos(), lines);
    // A vector has its length in front of it, as a list in the format.
    let mut body =
        postcard::to_extend(&(1_u8, sender, epoch, count, vec![plan]), Vec::new()).unwrap();
    let good = sealed(&header(), &[self::plan(300, 1)]);
    // One good plan behind it.
    let first = 1 + 5 + 10 + 3 + 1;
    body[first - 1] = 2;
    body.extend_from_slice(&good[first..good.len() - 4 - 4]);
    let mut payload = Vec::new();
    seal().seal(&body, Some(Span::from_micros(53)), &mut payload);
    payload
}

#[test]
fn a_plan_that_cannot_be_used_is_refused_alone() {
    const LIMITS: [f64; 4] = [1_000.0, 10_000.0, 9_000.0, 200_000.0];
    let good = pieces(3, Span::ZERO);
    let end = good[2].end();
    let changed = |change: &dyn Fn(&mut Vec<MotionPiece>)| {
        let mut pieces = good.clone();
        change(&mut pieces);
        unchecked(&pieces, LIMITS, end)
    };
    for (payload, fault) in [
        (unchecked(&[], LIMITS, end), PlanFault::NoPieces),
        (
            unchecked(&pieces(MOST_PIECES + 1, Span::ZERO), LIMITS, end),
            PlanFault::TooManyPieces,
        ),
        (
            unchecked(&pieces(1_000, Span::ZERO), LIMITS, end),
            PlanFault::TooManyPieces,
        ),
        (
            unchecked(&good, [1.0, 1.0, -1.0, 1.0], end),
            PlanFault::InvalidLimits,
        ),
        (
            unchecked(&good, [f64::NAN; 4], end),
            PlanFault::InvalidLimits,
        ),
        (
            unchecked(&good, LIMITS, end + Span::from_nanos(1)),
            PlanFault::PromiseBeyondPieces,
        ),
        (
            changed(&|all| all[1].from.position = f64::NAN),
            PlanFault::OutOfRange,
        ),
        (
            unchecked(&good, [1_000.0, 10_000.0, 9_000.0, 999.0], end),
            PlanFault::JerkLimit,
        ),
        (
            changed(&|all| all[1].start = Span::from_nanos(i64::MIN)),
            PlanFault::OutOfOrder,
        ),
        (
            changed(&|all| all[2].duration = Span::from_nanos(-1)),
            PlanFault::NoDuration,
        ),
        (
            changed(&|all| all[2].from.position += 0.1),
            PlanFault::PositionJump,
        ),
    ] {
        let messages = read(&payload);
        assert_eq!(messages[0], Message::PlanRefused(fault), "{messages:?}");
        let [_, Message::PlannedPiece(other)] = messages[..] else {
            panic!("{messages:?}");
        };
        assert_eq!(other.axis, 0);
    }
    let untouched = read(&changed(&|_| {}));
    assert_eq!(untouched.len(), 3 + 1, "{untouched:?}");
}

#[test]
fn writing_and_reading_do_not_allocate() {
    let plans: Vec<_> = (0..MAX_PLANS as u32)
        .map(|id| plan(id, MOST_PIECES))
        .collect();
    let mut body = [0; PLANS_CAPACITY];
    let mut payload = Vec::with_capacity(2 * PLANS_CAPACITY);
    let (seal, header, ids) = (seal(), header(), (0..8).collect::<Vec<_>>());
    let mut reader = Reader::from(PlanIntake::new(&name("press"), &ids));
    let pieces = assert_no_alloc(|| {
        let length = encode_plans(&header, &plans, &mut body);
        seal.seal(&body[..length], None, &mut payload);
        let mut pieces = 0;
        reader.read(&payload, |message| {
            pieces += usize::from(matches!(message, Message::PlannedPiece(_)));
        });
        pieces
    });
    assert_eq!(pieces, MAX_PLANS * MOST_PIECES);
}

proptest! {
    /// Whatever arrives, a plan that is handed out is one that could be made here.
    #[test]
    fn damaged_bytes_are_refused_or_plans(
        places in prop::collection::vec((0_usize..900, any::<u8>()), 1..6),
        is_sealed in any::<bool>(),
    ) {
        let mut bytes = sealed(&header(), &[plan(7, 8), plan(300, 8)]);
        for (place, byte) in places {
            let place = place % bytes.len();
            bytes[place] = byte;
        }
        if is_sealed {
            let body = bytes[..bytes.len() - 4].to_vec();
            let mut hasher = crc32fast::Hasher::new();
            hasher.update(name("press").channel_key(Channel::Plans).as_bytes());
            hasher.update(&body);
            bytes = [&body[..], &hasher.finalize().to_le_bytes()].concat();
        }
        let mut good = true;
        let _ = seal().open_plans(&bytes, |_, plan| if let Ok(plan) = plan {
            good &= MotionPlan::new(plan.pieces(), plan.promised_until(), plan.limits()) == Ok(plan);
        });
        prop_assert!(good);
        let _ = read(&bytes);
    }
}
