//! Passages of planned motions: against closed forms, and against a scan in small steps.

use std::vec::Vec;

use coaxle_curve::profile::{Limits, to_position, to_velocity};
use proptest::prelude::*;

use super::*;
use TravelDirection::{Backward, Forward};

const START: Span = Span::from_secs(40_000_000);

fn at(position: f64) -> AwaitedPosition {
    AwaitedPosition {
        position,
        modulo: None,
        direction: None,
    }
}

fn toward(position: f64, direction: TravelDirection) -> AwaitedPosition {
    AwaitedPosition {
        direction: Some(direction),
        ..at(position)
    }
}

fn in_turn(position: f64, turn: f64, direction: Option<TravelDirection>) -> AwaitedPosition {
    AwaitedPosition {
        position,
        modulo: Modulo::new(turn).ok(),
        direction,
    }
}

/// A piece that begins this time after [`START`].
fn piece(after_ms: i64, lasts_ms: i64, from: [f64; 3], jerk: f64) -> MotionPiece {
    let [position, velocity, acceleration] = from;
    MotionPiece {
        start: START + Span::from_millis(after_ms),
        duration: Span::from_millis(lasts_ms),
        from: Kinematics {
            position,
            velocity,
            acceleration,
        },
        jerk,
    }
}

/// Time of the first passage after a time, s after [`START`].
fn passage_after(pieces: &[MotionPiece], s: f64, target: &AwaitedPosition) -> Option<f64> {
    let until = pieces.last()?.end();
    let passage = first_passage(pieces, START + Seconds(s).to_span(), until, target)?;
    let on_the_piece = pieces.iter().any(|piece| {
        let state = piece.at(passage.at, Seconds::ZERO);
        (state.position - passage.state.position).abs() < 1e-4
    });
    assert!(on_the_piece, "{passage:?}");
    Some((passage.at - START).as_secs_f64())
}

fn first(pieces: &[MotionPiece], target: &AwaitedPosition) -> Option<f64> {
    passage_after(pieces, 0.0, target)
}

fn is_at(found: Option<f64>, expected: f64) -> bool {
    found.is_some_and(|found| (found - expected).abs() <= 1e-9)
}

#[test]
fn passages_are_those_of_the_closed_forms() {
    // 0.5 s at 200 u/s: t = s/v.
    let cruise = [piece(0, 500, [1_000.0, 200.0, 0.0], 0.0)];
    assert!(is_at(first(&cruise, &at(1_070.0)), 0.35));
    // From rest with 500 u/s²: t = √(2·s/a).
    let ramp = [piece(0, 500, [0.0, 0.0, 500.0], 0.0)];
    assert!(is_at(first(&ramp, &at(40.0)), 0.4));
    // With 3000 u/s³ alone: t = ∛(6·s/j).
    let jerk = [piece(0, 500, [0.0; 3], 3_000.0)];
    assert!(is_at(first(&jerk, &at(32.0)), 0.4));
    // Thrown up and falling back: t = (v ∓ √(v² − 2·a·s))/a.
    let thrown = [piece(0, 500, [0.0, 100.0, -500.0], 0.0)];
    let root = (100.0_f64 * 100.0 - 1_000.0 * 6.0).sqrt();
    let [up, down] = [-1.0, 1.0].map(|sign| (100.0 + sign * root) / 500.0);
    assert!(is_at(first(&thrown, &toward(6.0, Forward)), up));
    assert!(is_at(first(&thrown, &toward(6.0, Backward)), down));
    assert!(is_at(passage_after(&thrown, up + 1e-6, &at(6.0)), down));
    // It turns at 10 u, and no farther.
    assert!(is_at(first(&thrown, &at(10.0)), 0.2));
    assert!(is_at(first(&thrown, &toward(10.0, Forward)), 0.2));
    assert_eq!(first(&thrown, &toward(10.0, Backward)), None);
    assert_eq!(first(&thrown, &at(10.001)), None);
}

#[test]
fn ends_of_pieces_are_passages_once_and_nothing_beyond_the_promise_is_one() {
    let pieces = [
        piece(0, 100, [0.0, 100.0, 0.0], 0.0),
        piece(100, 100, [10.0, 100.0, 0.0], 0.0),
        piece(200, 100, [20.0, 100.0, -1_000.0], 0.0),
    ];
    for (position, s) in [(0.0, 0.0), (10.0, 0.1), (20.0, 0.2), (25.0, 0.3)] {
        assert!(is_at(first(&pieces, &at(position)), s), "{position}");
        assert!(is_at(first(&pieces, &toward(position, Forward)), s));
        assert_eq!(first(&pieces, &toward(position, Backward)), None);
    }
    let until = |ms: i64| first_passage(&pieces, START, START + Span::from_millis(ms), &at(15.0));
    assert!(until(150).is_some() && until(149).is_none() && until(-1).is_none());
    // Before the first piece, behind the last one, and across a gap nothing is known.
    assert_eq!(passage_after(&pieces, -0.001, &at(5.0)), None);
    assert_eq!(passage_after(&pieces, 0.301, &at(25.0)), None);
    let gap = [pieces[0], pieces[2]];
    assert_eq!(first(&gap, &at(21.0)), None);
    assert!(is_at(first(&gap, &at(5.0)), 0.05));
    assert_eq!(first_passage(&[], START, START, &at(0.0)), None);
    for nowhere in [f64::NAN, f64::INFINITY, 1e300] {
        assert_eq!(first(&pieces, &at(nowhere)), None);
    }
}

#[test]
fn an_axis_that_stands_at_the_target_is_there_and_does_not_arrive_again() {
    let pieces = [
        piece(0, 100, [1_500.0, 0.0, 0.0], 0.0),
        piece(100, 100, [1_500.0, 0.0, 100.0], 0.0),
    ];
    assert!(is_at(passage_after(&pieces, 0.05, &at(1_500.0)), 0.05));
    assert_eq!(
        passage_after(&pieces, 0.05, &toward(1_500.0, Forward)),
        None
    );
    // On its way out, and at the very begin of it.
    assert!(is_at(
        passage_after(&pieces, 0.1, &toward(1_500.0, Forward)),
        0.1
    ));
    assert_eq!(
        passage_after(&pieces, 0.1, &toward(1_500.0, Backward)),
        None
    );
    assert_eq!(passage_after(&pieces, 0.05, &at(1_499.0)), None);
}

#[test]
fn a_modulo_axis_comes_to_a_position_in_each_turn() {
    let forth = [piece(0, 4_000, [3_600_000.0, 360.0, 0.0], 0.0)];
    let back = [piece(0, 4_000, [3_600_000.0, -360.0, 0.0], 0.0)];
    let quarter = in_turn(90.0, 360.0, None);
    assert!(is_at(first(&forth, &quarter), 0.25));
    assert!(is_at(passage_after(&forth, 0.26, &quarter), 1.25));
    assert!(is_at(first(&back, &quarter), 0.75));
    assert_eq!(first(&back, &in_turn(90.0, 360.0, Some(Forward))), None);
    assert!(is_at(
        first(&forth, &in_turn(0.0, 360.0, Some(Forward))),
        0.0
    ));
    assert!(is_at(
        passage_after(&forth, 1e-3, &in_turn(0.0, 360.0, None)),
        1.0
    ));
    // A turn that is shorter than any way.
    assert!(is_at(first(&forth, &in_turn(0.0, 1e-12, None)), 0.0));
}

#[test]
fn the_target_of_a_move_is_reached_at_its_end() {
    let limits = Limits::new(1_000.0, 5_000.0, 4_000.0, 100_000.0).unwrap();
    for (from, to) in [(20.0, 1_500.0), (-700.0, 0.0), (1e6, -3.3), (0.1, 0.3)] {
        let profile = to_position(&Kinematics::at_rest(from), to, &limits);
        let pieces = crate::motion_plan::tests::pieces_of(&profile);
        let end = profile.duration().0;
        let found = first(&pieces, &at(to)).unwrap();
        // The jerk of 10⁵ u/s³ leads over the last 10⁻⁹ of the way in ∛(6·10⁻⁹·s/j).
        let last = (6e-9 * (from.abs() + to.abs()) / 1e5).cbrt();
        assert!(
            found <= end + 2e-9 && found > end - last - 2e-9,
            "{found} {end}"
        );
        let direction = if to > from { Forward } else { Backward };
        assert_eq!(first(&pieces, &toward(to, direction)), Some(found));
        assert_eq!(first(&pieces, &toward(to, direction.opposite())), None);
    }
}

/// A program of moves: pieces one after the other from a start.
fn program(start: f64, ways: &[(f64, bool)], limits: &Limits) -> Vec<MotionPiece> {
    let mut pieces: Vec<MotionPiece> = Vec::new();
    let mut state = Kinematics::at_rest(start);
    let mut began = START;
    for (way, is_move) in ways {
        let profile = match is_move {
            true => to_position(&state, state.position + way, limits),
            false => to_velocity(&state, way.clamp(-0.9, 0.9) * limits.velocity(), limits),
        };
        let own = crate::motion_plan::tests::pieces_of(&profile);
        pieces.extend(own.iter().map(|piece| MotionPiece {
            start: piece.start - START + began,
            ..*piece
        }));
        let last = pieces[pieces.len() - 1];
        began = last.end();
        state = last.at(began, Seconds::ZERO);
        // The next planner begins within the limits.
        state.acceleration = 0.0;
    }
    pieces
}

/// First step of a scan, in seconds after [`START`], over which the axis comes to a target.
fn by_scan(pieces: &[MotionPiece], step: f64, target: &AwaitedPosition) -> Option<f64> {
    let end = (pieces[pieces.len() - 1].end() - START).as_secs_f64();
    let position = |s: f64| {
        let instant = START + Seconds(s).to_span();
        let piece = crate::motion_plan::piece_at(pieces, instant)?;
        Some(piece.at(instant, Seconds::ZERO).position)
    };
    // In turns, where the target has some.
    let level = |position: f64| match target.modulo {
        Some(modulo) => ((position - target.position) / modulo.length()).floor(),
        None => f64::from(position >= target.position),
    };
    let mut before = position(0.0)?;
    let mut s = 0.0;
    while s < end {
        s = (s + step).min(end);
        let now = position(s)?;
        let (was, is) = (level(before), level(now));
        let passes = match target.direction {
            None => was != is,
            Some(Forward) => is > was,
            Some(Backward) => is < was,
        };
        if passes {
            return Some(s);
        }
        before = now;
    }
    None
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// A scan in small steps finds the passage in the step in which it is, unless the axis only touches the target.
    #[test]
    fn a_scan_finds_no_other_passage(
        start in -500.0..500.0,
        ways in prop::collection::vec((-300.0..300.0, any::<bool>()), 1..4),
        (part, turn) in (-0.2..1.2, 20.0..400.0),
        is_modulo: bool,
        direction in prop_oneof![Just(None), Just(Some(Forward)), Just(Some(Backward))],
    ) {
        const STEP: f64 = 1e-3;
        let limits = Limits::new(700.0, 5_000.0, 4_000.0, 100_000.0).unwrap();
        let pieces = program(start, &ways, &limits);
        let end = pieces[pieces.len() - 1];
        let span = end.at(end.end(), Seconds::ZERO).position - start;
        let target = AwaitedPosition {
            position: if is_modulo { part * turn } else { start + part * span },
            modulo: is_modulo.then(|| Modulo::new(turn).unwrap()),
            direction,
        };
        // At the first instant a scan has no step.
        let here = target.modulo.map_or(start - target.position, |turn| turn.of(start - target.position).within);
        prop_assume!(here.abs() > 1e-6 && (here - turn).abs() > 1e-6);
        let scanned = by_scan(&pieces, STEP, &target);
        let found = first(&pieces, &target);
        match (scanned, found) {
            (None, None) => {}
            (Some(scanned), Some(found)) => {
                // An arrival between two steps, out and back, is none to the scan.
                prop_assert!(found <= scanned + 2e-9, "{found} {scanned}");
                let is_seen = found >= scanned - STEP - 2e-9;
                prop_assert!(is_seen || touches(&pieces, found, STEP), "{found} {scanned}");
            }
            (None, Some(found)) => prop_assert!(touches(&pieces, found, STEP), "{found}"),
            (Some(scanned), None) => prop_assert!(false, "at {scanned}"),
        }
    }

    /// The state of a passage is that of the plan, and at the target.
    #[test]
    fn a_passage_is_at_the_target(
        start in -1e6..1e6,
        way in prop_oneof![-3_000.0..-1.0, 1.0..3_000.0],
        part in 0.01..0.99,
    ) {
        let limits = Limits::new(700.0, 5_000.0, 4_000.0, 100_000.0).unwrap();
        let pieces = program(start, &[(way, true)], &limits);
        let position = start + part * way;
        let passage = first_passage(&pieces, START, pieces[pieces.len() - 1].end(), &at(position));
        let passage = passage.expect("on the way");
        let tolerance = 2e-9 * (start.abs() + way.abs());
        prop_assert!((passage.state.position - position).abs() <= tolerance);
        let piece = crate::motion_plan::piece_at(&pieces, passage.at).unwrap();
        let state = piece.at(passage.at, Seconds::ZERO);
        // By half a nanosecond.
        prop_assert!((state.position - passage.state.position).abs() <= tolerance + 1e-6);
        prop_assert!(way.signum() == passage.state.velocity.signum());
    }
}

/// True if the axis turns or halts within a step of an instant, s after [`START`].
fn touches(pieces: &[MotionPiece], s: f64, step: f64) -> bool {
    let velocity = |s: f64| {
        let instant = START + Seconds(s).to_span();
        let piece = crate::motion_plan::piece_at(pieces, instant);
        piece.map_or(0.0, |piece| piece.at(instant, Seconds::ZERO).velocity)
    };
    let [before, after] = [-step, step].map(|by| velocity(s + by));
    before * after <= 1e-3 * before.abs()
}
