//! Plans of a virtual axis: its motion, as far as it is decided.

use coaxle_axis::motion_plan::{MOST_PIECES, MotionPlan};
use coaxle_clock::{Seconds, Span};
use coaxle_node::config::parse;
use coaxle_source::config::{AxisConfig, ProgramConfig};
use coaxle_source::{AxisSource, MotionProgram, SourceAxis};
use proptest::prelude::*;

const LIMITS: &str = "limits = { velocity = 1000, acceleration = 5000, jerk = 100000 }\n";

fn program(rest: &str, lead_ms: i64) -> MotionProgram {
    let config: ProgramConfig = parse("p.toml", &format!("{LIMITS}{rest}")).expect("valid");
    MotionProgram::new(&config).with_lead(Span::from_millis(lead_ms))
}

fn ms(millis: i64) -> Span {
    Span::from_millis(millis)
}

const MOVES: &str = "
    repeat = true
    steps = [
      { enable = true },
      { dwell = { for-s = 0.05 } },
      { loop = { count = 3, steps = [{ velocity = { value = 800, for-s = 0.3 } }, { velocity = { value = 100 } }] } },
      { halt = {} },
      { move-relative = { distance = -200 } },
      { move-absolute = { position = 0, velocity = 300 } },
      { enable = false },
    ]";

/// Plans of each millisecond, and the motion.
fn run(axis: &mut MotionProgram, origin: Span, millis: i64) -> Vec<Option<MotionPlan>> {
    let plan = |k| {
        axis.sample(ms(k));
        axis.plan(ms(k), origin)
    };
    (0..millis).map(plan).collect()
}

/// Checks that every plan is the motion up to its promise.
fn assert_honest(plans: &[Option<MotionPlan>], truth: &mut MotionProgram, origin: Span) {
    let step = Span::from_micros(100);
    for k in 0..10 * plans.len() as i64 {
        let at = step * k;
        let sample = truth.sample(at).motion;
        // Each plan that was made by then, and promised it.
        let now = (k / 10) as usize;
        for plan in plans[now.saturating_sub(250)..=now]
            .iter()
            .rev()
            .step_by(9)
            .flatten()
        {
            let Some(planned) = plan.at(origin + at, Seconds::ZERO) else {
                continue;
            };
            let off = (planned.position - sample.position).abs();
            assert!(off < 1e-9 * (1.0 + sample.position.abs()), "{at} {off}");
            assert!((planned.velocity - sample.velocity).abs() < 1e-7, "{at}");
            assert!(
                (planned.acceleration - sample.acceleration).abs() < 1e-3,
                "{at}"
            );
        }
    }
}

#[test]
fn every_plan_is_the_motion_until_its_promise_and_the_promise_never_moves_back() {
    let origin = Span::from_secs(1_000_000);
    for lead in [20, 200] {
        let plans = run(&mut program(MOVES, lead), origin, 4_000);
        assert!(plans.iter().all(Option::is_some));
        assert_honest(&plans, &mut program(MOVES, 0), origin);
        let mut before = Span::ZERO;
        let mut shortest = Span::MAX;
        for (k, plan) in plans.iter().enumerate() {
            let plan = plan.as_ref().expect("a plan");
            assert!(plan.start() <= origin + ms(k as i64), "{k}");
            assert!(plan.promised_until() >= before, "{k}");
            before = plan.promised_until();
            shortest = shortest.min(before - origin - ms(k as i64));
        }
        // Eight pieces last for 190 ms at least, in this program.
        assert!(shortest >= ms(lead.min(90)), "{shortest}");
    }
}

#[test]
fn a_lead_changes_nothing_about_the_motion() {
    let mut axes = [0, 1, 50, 4_000].map(|lead| program(MOVES, lead));
    for k in 0..20_000 {
        // Sometimes late.
        let at = Span::from_micros(k * 977 / 2 + if k % 7 == 0 { 3_000 } else { 0 });
        let at = at.max(Span::from_micros((k - 1).max(0) * 977 / 2 + 3_000));
        let [first, others @ ..] = &mut axes;
        let truth = first.sample(at);
        for other in others {
            assert_eq!(other.sample(at), truth, "{at}");
        }
    }
}

#[test]
fn a_new_decision_changes_the_plan_and_is_counted() {
    let mut axis = program(
        "steps = [{ dwell = { for-s = 1 } }, { enable = true }, { move-absolute = { position = 100 } }]",
        100,
    );
    axis.sample(ms(899));
    let standing = axis.plan(ms(899), Span::ZERO).expect("a plan");
    assert_eq!((axis.decisions(), standing.pieces().len()), (0, 1));
    assert_eq!(standing.promised_until(), ms(999));
    axis.sample(ms(900));
    let decided = axis.plan(ms(900), Span::ZERO).expect("a plan");
    // Enabled, and under way: the move itself lies beyond the promise.
    assert_eq!((axis.decisions(), decided.pieces().len()), (2, 1));
    axis.sample(ms(901));
    let moving = axis.plan(ms(901), Span::ZERO).expect("a plan");
    assert_eq!(moving.pieces().len(), 2);
    // 50 ms of jerk follow.
    assert_eq!(moving.promised_until(), ms(1_001));
    // An axis that stands still at the end of its program will do so for ever.
    axis.sample(ms(60_000));
    let over = axis.plan(ms(60_000), Span::ZERO).expect("a plan");
    assert_eq!(over.pieces().len(), 1);
    assert_eq!(over.promised_until(), ms(60_100));
    assert_eq!(over.pieces()[0].from.position, 100.0);
}

#[test]
fn many_short_steps_are_promised_as_far_as_eight_pieces_reach() {
    let mut axis = program(
        "repeat = true\nsteps = [{ enable = true }, { move-relative = { distance = 0.01 } }, \
         { move-relative = { distance = -0.01 } }]",
        1_000,
    );
    for plan in run(&mut axis, Span::ZERO, 2_000) {
        let plan = plan.expect("a plan");
        assert_eq!(plan.pieces().len(), MOST_PIECES);
        assert_eq!(plan.promised_until(), plan.pieces()[MOST_PIECES - 1].end());
    }
}

#[test]
fn only_a_program_with_a_lead_has_a_plan() {
    let axis = |text: &str| {
        let text = format!("id = 1\nname = 'x'\n{text}");
        let config: AxisConfig = parse("a.toml", &text).map_err(|e| e.to_string())?;
        let mut axis = SourceAxis::open_ahead(&config).map_err(|e| e.to_string())?;
        axis.at(ms(5), &mut Default::default());
        Ok(axis.plan(ms(5), Span::ZERO))
    };
    let program = format!("program = {{ {} }}\n", LIMITS.trim());
    let promise = |text: &str| {
        let plan: Result<_, String> = axis(&format!("{text}{program}"));
        plan.map(|plan| plan.map(|plan| plan.promised_until()))
    };
    assert_eq!(promise(""), Ok(None));
    assert_eq!(promise("lead-ms = 30\n"), Ok(Some(ms(35))));
    assert_eq!(promise("present-after-ms = 20\n"), Ok(Some(ms(25))));
    assert_eq!(promise("present-after-ms = 20\nlead-ms = 0\n"), Ok(None));
    let refused = promise("lead-ms = 4001\n").expect_err("a refusal");
    assert!(
        refused.contains("lead-ms: received 4001, expected a number from 0 to 4000"),
        "{refused}"
    );
    let encoder = format!("encoder = {{ resolution = 0.01, {} }}\n", program.trim());
    assert_eq!(axis(&format!("present-after-ms = 20\n{encoder}")), Ok(None));
    let refused = axis(&format!("lead-ms = 30\n{encoder}")).expect_err("a refusal");
    assert!(
        refused.contains(
            "lead-ms: received 30, expected 0 or none for an encoder: only the motion of a program is known ahead"
        ),
        "{refused}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Programs with any moves, at any lead and with late cycles: plans are honest, and there is one in every cycle.
    #[test]
    fn plans_of_any_program_are_honest(
        steps in prop::collection::vec((0_u8..6, -300.0..300.0, 0.0..0.1), 1..8),
        lead in 1_i64..400,
        cycles in prop::collection::vec(1_i64..20, 50..300),
    ) {
        let step = |(kind, value, time): &(u8, f64, f64)| match kind {
            0 => format!("{{ move-relative = {{ distance = {value} }} }}"),
            1 => format!("{{ move-absolute = {{ position = {value}, velocity = {} }} }}", 1.0 + value.abs()),
            2 | 3 => format!("{{ velocity = {{ value = {value}, for-s = {time} }} }}"),
            4 => "{ halt = {} }".to_owned(),
            _ => format!("{{ dwell = {{ for-s = {} }} }}", 0.001 + time),
        };
        let steps: Vec<_> = steps.iter().map(step).collect();
        let text = format!("repeat = 1000\nstart-velocity = 50\nsteps = [{}, {{ dwell = {{ for-s = 0.01 }} }}]", steps.join(", "));
        let (mut ahead, mut truth) = (program(&text, lead), program(&text, 0));
        let (mut now, mut newest, mut before) = (0, None::<MotionPlan>, Span::ZERO);
        for cycle in cycles {
            for k in now..now + cycle {
                let sample = truth.sample(ms(k)).motion;
                if let Some(planned) = newest.and_then(|plan| plan.at(ms(k), Seconds::ZERO)) {
                    let off = (planned.position - sample.position).abs();
                    prop_assert!(off < 1e-9 * (1e3 + sample.position.abs()), "{k} {off}");
                }
            }
            now += cycle;
            ahead.sample(ms(now));
            newest = ahead.plan(ms(now), Span::ZERO);
            let plan = newest.expect("a plan");
            prop_assert!(plan.promised_until() >= before, "{now}");
            prop_assert!(plan.start() <= ms(now));
            before = plan.promised_until();
        }
    }
}
