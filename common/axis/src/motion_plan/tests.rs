//! Plans of moves, and every fault of a plan.

use std::string::ToString;
use std::vec::Vec;

use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::{Kinematics, Limits, Profile, to_position, to_velocity};
use proptest::prelude::*;

use super::*;

const START: Span = Span::from_secs(40_000_000);

fn limits() -> Limits {
    Limits::new(1_000.0, 5_000.0, 4_000.0, 100_000.0).unwrap()
}

/// The pieces of a profile that begins at `START`, on the grid of nanoseconds.
pub(super) fn pieces_of(profile: &Profile) -> Vec<MotionPiece> {
    let nanos = |Seconds(s): Seconds| Span::from_nanos((s * 1e9).ceil() as i64);
    let begins: Vec<_> = profile.phase_begins().collect();
    let ends = begins.iter().skip(1).copied().chain([profile.duration()]);
    let phases = begins.iter().zip(ends).filter_map(|(begin, end)| {
        let [start, end] = [*begin, end].map(nanos);
        (end > start).then(|| MotionPiece::of_profile(profile, START, START + start, START + end))
    });
    let mut pieces: Vec<_> = phases.collect();
    pieces.push(MotionPiece {
        start: START + nanos(profile.duration()),
        duration: Span::from_millis(100),
        from: profile.end(),
        jerk: 0.0,
    });
    pieces
}

fn move_of_300() -> Vec<MotionPiece> {
    let start = Kinematics::at_rest(20.0);
    pieces_of(&to_position(&start, 320.0, &limits()))
}

fn end_of(pieces: &[MotionPiece]) -> Span {
    pieces.last().unwrap().end()
}

fn plan_of(pieces: &[MotionPiece]) -> Result<MotionPlan, InvalidPlan> {
    MotionPlan::new(pieces, end_of(pieces), &limits())
}

#[test]
fn a_move_is_a_plan_and_its_states_are_those_of_the_move() {
    let profile = to_position(&Kinematics::at_rest(20.0), 320.0, &limits());
    let plan = plan_of(&pieces_of(&profile)).unwrap();
    assert_eq!(plan.pieces().len(), MOST_PIECES);
    for micros in 0..600_000_i64 {
        let since = Span::from_micros(micros);
        let Some(planned) = plan.at(START, since.into()) else {
            assert!(since > Span::from_secs_f64(profile.duration().0 + 0.1));
            continue;
        };
        let truth = profile.at(since.into());
        assert!((planned.position - truth.position).abs() < 1e-10, "{since}");
        assert!((planned.velocity - truth.velocity).abs() < 1e-9, "{since}");
        let off = (planned.acceleration - truth.acceleration).abs();
        assert!(off < 1e-3, "{since} {off}");
    }
}

#[test]
fn before_its_first_piece_and_beyond_its_promise_nothing_is_known() {
    let pieces = move_of_300();
    let promised = START + Span::from_millis(100);
    let plan = MotionPlan::new(&pieces, promised, &limits()).unwrap();
    let at = |ms: f64| plan.at(START, Seconds(ms * 1e-3)).is_some();
    assert!(!at(-0.001) && at(0.0) && at(100.0) && !at(100.001));
    for after in [f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(plan.at(START, Seconds(after)), None);
    }
}

#[test]
fn every_fault_is_named_with_what_came_and_what_is_expected() {
    let good = move_of_300();
    let changed = |change: fn(&mut Vec<MotionPiece>)| {
        let mut pieces = good.clone();
        change(&mut pieces);
        plan_of(&pieces).unwrap_err()
    };
    let cases: [(InvalidPlan, PlanFault, &str); 13] = [
        (
            changed(|all| all.push(all[7])),
            PlanFault::TooManyPieces,
            "pieces: received 9, expected 1 to 8",
        ),
        (
            changed(|all| all[2].from.velocity = f64::NAN),
            PlanFault::OutOfRange,
            "piece 3, values: received NaN, expected numbers from -1e15 to 1e15",
        ),
        (
            changed(|all| all[1].jerk = f64::INFINITY),
            PlanFault::OutOfRange,
            "piece 2, values: received inf, expected numbers from -1e15 to 1e15",
        ),
        (
            changed(|all| all[0].duration = Span::ZERO),
            PlanFault::NoDuration,
            "piece 1, duration, s: received 0, expected above 0",
        ),
        (
            changed(|all| all[7].duration = Span::MAX),
            PlanFault::NoDuration,
            "piece 8, duration, s: received 9223372036.854",
        ),
        (
            changed(|all| all[3].start -= Span::from_nanos(1)),
            PlanFault::OutOfOrder,
            "piece 4, start, s: received 40000000.2",
        ),
        (
            changed(|all| all[3].start += Span::from_millis(1)),
            PlanFault::Gap,
            "expected the end of the piece before: 40000000.2",
        ),
        (
            changed(|all| all[4].from.position += 1e-4),
            PlanFault::PositionJump,
            "piece 5, position: received ",
        ),
        (
            changed(|all| all[4].from.velocity += 1e-3),
            PlanFault::VelocityJump,
            "expected that of the piece before at its end: ",
        ),
        (
            changed(|all| all[4].from.acceleration += 1e-2),
            PlanFault::AccelerationJump,
            "piece 5, acceleration: received ",
        ),
        (
            changed(|all| all[0].from.velocity = -1_001.0),
            PlanFault::VelocityLimit,
            "piece 1, velocity: received 1001, expected at most 1000",
        ),
        (
            changed(|all| all[0].from.acceleration = 5_001.0),
            PlanFault::AccelerationLimit,
            "piece 1, acceleration: received ",
        ),
        (
            changed(|all| all[1].jerk = -100_001.0),
            PlanFault::AccelerationLimit,
            "piece 2, acceleration: received ",
        ),
    ];
    for (found, fault, text) in cases {
        assert_eq!(found.fault, fault, "{found}");
        assert!(found.to_string().contains(text), "{found}, not {text}");
    }
    let none = MotionPlan::new(&[], START, &limits()).unwrap_err();
    assert_eq!(none.to_string(), "pieces: received 0, expected 1 to 8");
    let short = MotionPiece {
        duration: Span::from_nanos(1),
        jerk: 100_001.0,
        ..MotionPiece::default()
    };
    let jerk = MotionPlan::new(&[short], Span::ZERO, &limits()).unwrap_err();
    assert_eq!(
        jerk.to_string(),
        "piece 1, jerk: received 100001, expected at most 100000"
    );
}

#[test]
fn a_promise_lies_within_the_pieces() {
    let pieces = move_of_300();
    let promise = |until| MotionPlan::new(&pieces, until, &limits());
    assert!(promise(START).is_ok() && promise(end_of(&pieces)).is_ok());
    for until in [
        START - Span::from_nanos(1),
        end_of(&pieces) + Span::from_nanos(1),
        Span::MAX,
    ] {
        let refused = promise(until).unwrap_err();
        assert_eq!(refused.fault, PlanFault::PromiseBeyondPieces);
        let text = refused.to_string();
        assert!(text.contains("promised until, s: received "), "{text}");
        assert!(text.contains("within the pieces, which end at"), "{text}");
    }
}

#[test]
fn every_fault_has_a_name_and_a_number_of_its_own() {
    for (place, fault) in PlanFault::ALL.into_iter().enumerate() {
        assert_eq!(fault as usize, place);
        let same = PlanFault::ALL.iter().filter(|it| it.name() == fault.name());
        assert_eq!(same.count(), 1, "{fault:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// Motions of any planner, in many decades of limits and at any place, are plans.
    #[test]
    fn planned_motions_are_plans(
        exponents in (-3.0..6.0, -3.0..8.0, -3.0..9.0),
        (speed, push) in (-0.9..0.9, -0.9..0.9),
        (place, way) in (-1e6..1e6, -1e4..1e4),
        to_velocity_instead in any::<bool>(),
    ) {
        let (v, a, j): (f64, f64, f64) = exponents;
        let [v, a, j]: [f64; 3] = [v, a, j].map(|exponent| libm::pow(10.0, exponent));
        let (speed, way): (f64, f64) = (speed, way);
        let limits = Limits::new(v, a, 0.7 * a, j).unwrap();
        let start = limits.without_overspeed(&Kinematics {
            position: place,
            velocity: speed * v,
            acceleration: push * 0.7 * a,
        });
        let profile = match to_velocity_instead {
            true => to_velocity(&start, -v * speed, &limits),
            false => to_position(&start, place + way, &limits),
        };
        // Years of motion are no plan of a few seconds.
        prop_assume!(profile.duration().0 < 1e6);
        let pieces = pieces_of(&profile);
        // Eight of them, from the first and to the last one.
        for some in [&pieces[..pieces.len().min(8)], &pieces[pieces.len().saturating_sub(8)..]] {
            let end = end_of(some);
            if let Err(fault) = MotionPlan::new(some, end, &limits) {
                prop_assert!(false, "{fault}");
            }
        }
    }

    /// A change of any value beyond its rounding is found, or leads to a plan that is as smooth.
    #[test]
    fn a_damaged_plan_is_refused_or_smooth(
        piece in 0_usize..8,
        field in 0_usize..6,
        by in prop_oneof![-1e3..-1e-2, 1e-2..1e3],
    ) {
        let mut pieces = move_of_300();
        let damaged = &mut pieces[piece];
        match field {
            0 => damaged.from.position += by,
            1 => damaged.from.velocity += by,
            2 => damaged.from.acceleration += by,
            3 => damaged.jerk += 1e3 * by,
            4 => damaged.start += Seconds(by).to_span(),
            _ => damaged.duration += Seconds(by).to_span(),
        }
        // The first position and the last duration are free.
        if let Ok(plan) = plan_of(&pieces) {
            for pair in plan.pieces().windows(2) {
                let end = pair[0].at(pair[1].start, Seconds::ZERO);
                prop_assert!((end.position - pair[1].from.position).abs() < 1e-5);
                prop_assert!((end.velocity - pair[1].from.velocity).abs() < 1e-4);
            }
        }
    }
}
