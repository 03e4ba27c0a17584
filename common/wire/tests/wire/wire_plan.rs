//! `docs/WIRE.md` against the code: its worked plan.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use crate::document::{assert_consistent, example_dump, section};
use coaxle_axis::motion_plan::{MotionPiece, MotionPlan, PlanFault};
use coaxle_clock::Span;
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_wire::frame::{KeySeal, sender_id};
use coaxle_wire::keys::NodeName;
use coaxle_wire::plan::{PLANS_CAPACITY, encode_plans};
use coaxle_wire::{AxisPlan, RunCycle};

const KEY: &str = "coaxle/press/plans";
const PLAN: &str = "## Worked plan";

fn header() -> RunCycle {
    RunCycle {
        sender: sender_id(&NodeName::new("press").unwrap()),
        epoch: 0x0123_4567_89ab_cdef,
        count: 70_000,
    }
}

fn plan() -> AxisPlan {
    let piece = |start, duration, position, jerk| MotionPiece {
        start: Span::from_millis(start),
        duration: Span::from_millis(duration),
        from: Kinematics {
            position,
            velocity: 500.0,
            acceleration: 0.0,
        },
        jerk,
    };
    let pieces = [
        piece(139_500, 625, 1_234.5, 0.0),
        piece(140_125, 75, 1_547.0, -50_000.0),
    ];
    let limits = Limits::new(1_000.0, 5_000.0, 4_000.0, 100_000.0).unwrap();
    let plan = MotionPlan::new(&pieces, Span::from_millis(140_200), &limits).unwrap();
    AxisPlan { axis_id: 300, plan }
}

#[test]
fn the_table_covers_the_dump_and_the_rules_give_its_values() {
    assert_consistent(PLAN);
}

#[test]
fn the_crate_reads_and_writes_the_documented_bytes() {
    let mut plans = Vec::new();
    let read = KeySeal::new(KEY).open_plans(&example_dump(PLAN), |axis_id, plan| {
        plans.push(AxisPlan {
            axis_id,
            plan: plan.unwrap(),
        });
    });
    assert_eq!((read, &plans[..]), (Ok(header()), &[plan()][..]));
    let (mut body, mut payload) = ([0; PLANS_CAPACITY], Vec::new());
    let length = encode_plans(&header(), &plans, &mut body);
    let stamp = Some(Span::from_micros(65));
    KeySeal::new(KEY).seal(&body[..length], stamp, &mut payload);
    assert_eq!(payload, example_dump(PLAN));
}

#[test]
fn every_fault_of_a_plan_is_described() {
    for fault in PlanFault::ALL {
        let name = format!("`{}`", fault.name());
        assert!(section("\n## Plans\n").contains(&name), "{name}");
    }
}
