//! A far axis by the plan of its node: through losses and silences, shown later or now, and a node that lies.

use assert_no_alloc::assert_no_alloc;
use coaxle_axis::motion_plan::{MotionPlan, PlanFault};
use coaxle_clock::{Instant, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::config::parse;
use coaxle_node::{AxisSample, Frame, FrameHeader, Message, Node, PlannedPiece, PresentAfter};
use coaxle_receiver::signals::FarAxisSignals;
use coaxle_receiver::{ContinuityState, Receiver};
use coaxle_source::config::ProgramConfig;
use coaxle_source::{AxisSource, MotionProgram};

use crate::nodes::{self, MILLISECOND};

mod reaches;

/// Time from a cycle of the master to the arrival of its frame, and of its plan.
const WAY: i64 = 20 * MILLISECOND;
/// Cycle of the master by the clock of the receiver, 40 ppm long.
const CYCLE: i64 = 1_000_040;
/// The subscription to plans comes last.
const PLANS: usize = 3;

/// To and fro between 100 and 800 u/s with 5 000 u/s² and 100 000 u/s³.
fn program(lead: Span) -> MotionProgram {
    let text = "limits = { velocity = 1000, acceleration = 5000, jerk = 100000 }\nrepeat = true\nsteps = [{ enable = true }, \
                { velocity = { value = 800, for-s = 0.1 } }, { velocity = { value = 100, for-s = 0.1 } }]";
    let config: ProgramConfig = parse("p.toml", text).expect("a program");
    MotionProgram::new(&config).with_lead(lead)
}

struct Bench {
    receiver: Receiver,
    source: MotionProgram,
    /// The motion once more, which is sampled at the instants shown.
    truth: MotionProgram,
    next: u64,
    delay: Span,
    lead: Span,
    /// Cycles whose frames and plans are lost.
    is_lost: fn(u64) -> bool,
    /// Change of the plans, by a node that lies.
    lie: fn(&mut PlannedPiece),
    before: Option<(f64, f64)>,
    hardest: f64,
}

impl Bench {
    fn new(rest: &str, delay: i64, lead: i64) -> Self {
        Self::with_master("node = 'a'", rest, delay, lead)
    }

    fn with_master(master: &str, rest: &str, delay: i64, lead: i64) -> Self {
        let text = format!(
            "mode = 'observer'\nmaster = {{ {master} }}\ndelay = {{ fixed-us = 20000 }}\n\
             sync.time-sync = {{ age-of-data-limit = 50, max-cycle-index-difference = 50 }}\n{rest}"
        );
        let [delay, lead] = [delay, lead].map(Span::from_millis);
        Self {
            receiver: nodes::receiver(&text),
            source: program(lead),
            truth: program(Span::ZERO),
            next: 0,
            delay,
            lead,
            is_lost: |_| false,
            lie: |_| {},
            before: None,
            hardest: 0.0,
        }
    }

    fn send_until(&mut self, now: i64) {
        while self.next as i64 * CYCLE + WAY <= now {
            let count = self.next;
            self.next += 1;
            let since_start = Span::from_millis(count as i64);
            let set = self.source.sample(since_start).motion;
            let plan = self.source.plan(since_start, Span::ZERO);
            if (self.is_lost)(count) {
                continue;
            }
            // Primes: 997 messages in sequence have different jitters, of up to a microsecond.
            let jitter = (count * 7_919 % 997) as i64;
            let at = Instant::from_nanos(count as i64 * CYCLE + WAY + jitter);
            let header = FrameHeader {
                present_after: PresentAfter::new(self.delay),
                ..nodes::header_of(count)
            };
            let axes = &[Some(AxisSample {
                set,
                ..AxisSample::default()
            })];
            self.receiver
                .receive(at, 0, &Message::Frame(Frame { header, axes }));
            // As a sender publishes them: twice in each lead, and every 100 ms.
            let period = (self.lead / 2).min(Span::from_millis(100));
            let is_due = count.is_multiple_of(period.as_nanos().unsigned_abs() / 1_000_000);
            if let Some(plan) = plan.filter(|_| is_due) {
                self.send_plan(at, count, &plan);
            }
        }
    }

    fn send_plan(&mut self, at: Instant<coaxle_clock::Local>, count: u64, plan: &MotionPlan) {
        for (number, piece) in (0..).zip(plan.pieces()) {
            let mut piece = PlannedPiece {
                epoch: 1,
                count,
                axis: 0,
                number,
                of: plan.pieces().len() as u8,
                promised_until: plan.promised_until(),
                piece: *piece,
            };
            (self.lie)(&mut piece);
            self.receiver
                .receive(at, PLANS, &Message::PlannedPiece(piece));
        }
    }

    /// Runs until then, s; passes on the axis and the master at the instant that it shows.
    fn run(&mut self, until_s: f64, mut each: impl FnMut(&FarAxisSignals, Option<Kinematics>)) {
        while self.receiver.next_cycle().as_nanos() < (until_s * 1e9) as i64 {
            let now = self.receiver.next_cycle();
            self.send_until(now.as_nanos());
            let _ = self.receiver.cycle(now);
            while self.receiver.transmit().is_some() {}
            let axis = &self.receiver.snapshot().signals.axes[0];
            if let Some(position) = axis.corrected_position {
                let velocity = self.before.map(|(before, _)| (position - before) * 1e3);
                if let (Some(velocity), Some((_, last))) = (velocity, self.before) {
                    self.hardest = self.hardest.max((velocity - last).abs() * 1e3);
                }
                self.before = Some((position, velocity.unwrap_or_default()));
            }
            let shown = axis.far_time_ns.map(|nanos| Span::from_nanos(nanos.max(0)));
            let master = shown.map(|at| self.truth.sample(at).motion);
            each(axis, master);
        }
    }

    fn axis(&self) -> &FarAxisSignals {
        &self.receiver.snapshot().signals.axes[0]
    }
}

/// Distance of an axis that follows from its master, u.
fn off(axis: &FarAxisSignals, master: Option<Kinematics>) -> f64 {
    let master = master.expect("it follows");
    (axis.corrected_position.expect("received") - master.position).abs()
}

/// A third of a second without any message, in which the master speeds up.
const OUTAGE: fn(u64) -> bool = |count| (5_020..5_320).contains(&count);

#[test]
fn an_outage_within_the_promise_takes_nothing_away() {
    for (delay, lead) in [(60, 400), (0, 500)] {
        let mut bench = Bench::new("", delay, lead);
        bench.run(4.0, |_, _| {});
        bench.hardest = 0.0;
        bench.is_lost = OUTAGE;
        let (mut worst, mut velocities) = (0.0_f64, (f64::MAX, 0.0_f64));
        bench.run(6.0, |axis, master| {
            assert!(axis.synced && axis.continuity == ContinuityState::Following);
            worst = worst.max(off(axis, master));
            if axis.planned == Some(true) {
                let velocity = axis.corrected_velocity.expect("known");
                velocities = (velocities.0.min(velocity), velocities.1.max(velocity));
            }
        });
        assert!(worst < 1e-6, "{delay}: {worst}");
        assert!(velocities.1 - velocities.0 > 400.0, "{velocities:?}");
        // The differences of the positions, in own cycles 40 ppm apart.
        assert!(bench.hardest < 5_002.0, "{delay}: {}", bench.hardest);
        let axis = bench.axis();
        assert!(axis.planned_cycles >= 220, "{}", axis.planned_cycles);
        assert_eq!(axis.plan_contradictions, 0);
    }
}

/// Its node is 20 ms away: what an extrapolation is off by, 0.16 mm, the plan knows.
#[test]
fn an_axis_that_is_shown_now_is_its_master_too() {
    let mut bench = Bench::new("", 0, 100);
    bench.run(4.0, |_, _| {});
    // The plans arrive.
    bench.is_lost = |count| count % 50 % 7 == 3 || (10..13).contains(&(count % 100));
    let mut worst = 0.0_f64;
    bench.run(8.0, |axis, master| {
        assert_eq!(axis.planned, Some(true));
        let ahead = axis.promised_ahead_us.expect("a promise");
        assert!((20_000.0..=80_000.0).contains(&ahead), "{ahead}");
        worst = worst.max(off(axis, master));
    });
    assert!(worst < 1e-6, "{worst}");
    let mut without = Bench::new("", 0, 100);
    without.lie = |piece| piece.epoch = 2;
    without.run(4.0, |_, _| {});
    let mut predicted = 0.0_f64;
    without.run(8.0, |axis, master| {
        assert_eq!(axis.planned, None);
        predicted = predicted.max(off(axis, master));
    });
    assert!(predicted > 0.1, "{predicted}");
    let far = &without.receiver.snapshot().signals.far[0];
    assert!(far.plans_refused > 100 && far.plan_fault == Some(PlanFault::OtherRun));
}

#[test]
fn lost_frames_are_filled_and_an_axis_with_all_of_them_needs_no_plan() {
    let mut bench = Bench::new("", 60, 60);
    bench.run(4.0, |_, _| {});
    let before = bench.axis().planned_cycles;
    let predicted = bench.axis().extrapolated_cycles;
    bench.run(5.0, |axis, _| {
        assert_eq!((axis.planned, axis.interpolated), (Some(false), Some(true)))
    });
    assert_eq!(bench.axis().planned_cycles, before);
    // Ten in a row, ten times a second.
    bench.is_lost = |count| (90..100).contains(&(count % 100));
    let mut worst = 0.0_f64;
    bench.run(9.0, |axis, master| worst = worst.max(off(axis, master)));
    assert!(worst < 1e-6, "{worst}");
    assert!(bench.axis().planned_cycles > before + 400);
    assert_eq!(bench.axis().extrapolated_cycles, predicted);
}

#[test]
fn beyond_the_promise_it_is_lost_as_without_one() {
    let mut bench = Bench::new("", 60, 60);
    bench.run(4.0, |_, _| {});
    bench.is_lost = |count| (5_020..5_520).contains(&count);
    bench.hardest = 0.0;
    let mut braked = false;
    bench.run(8.0, |axis, _| {
        braked |= axis.continuity == ContinuityState::Braking
    });
    assert!(braked);
    assert!(bench.hardest < 15_000.0, "{}", bench.hardest);
    assert!(bench.axis().synced && bench.axis().continuity == ContinuityState::Following);
}

/// Lies that are plans by themselves.
#[test]
fn a_node_that_lies_moves_nothing() {
    let lies: [fn(&mut PlannedPiece); 4] = [
        |piece| piece.piece.from.position += 0.01,
        |piece| piece.piece.start += Span::from_millis(3),
        |piece| piece.piece.from.velocity *= 1.001,
        |piece| piece.piece.from.position = f64::from_bits(piece.count | 1 << 62),
    ];
    let run = |lie: fn(&mut PlannedPiece), delay| {
        let mut bench = Bench::new("", delay, 200);
        bench.run(4.0, |_, _| {});
        (bench.hardest, bench.lie) = (0.0, lie);
        bench.is_lost = |count| (10..13).contains(&(count % 100));
        let mut positions = Vec::new();
        bench.run(9.0, |axis, _| {
            assert!(axis.synced && axis.continuity == ContinuityState::Following);
            positions.push(axis.corrected_position.expect("received"));
        });
        let far = &bench.receiver.snapshot().signals.far[0];
        let counted = (bench.axis().plan_contradictions, far.plans_refused);
        (positions, bench.hardest, counted)
    };
    // Plans that are refused in any case.
    let without: fn(&mut PlannedPiece) = |piece| piece.epoch = 2;
    for (n, lie) in lies.into_iter().enumerate() {
        // With a fixed delay of the frames no plan is needed but for the losses.
        let (positions, hardest, (contradictions, refused)) = run(lie, 60);
        let (expected, hardest_without, _) = run(without, 60);
        let faults = (contradictions, refused);
        assert!(contradictions > 5, "{n}: {faults:?}");
        assert!(
            hardest < hardest_without * 1.01 + 10.0,
            "{hardest} {hardest_without}"
        );
        let pairs = positions.iter().zip(&expected);
        let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 2e-4, "{off}");
    }
}

#[test]
fn pieces_that_are_lost_in_the_node_leave_no_plan() {
    let mut bench = Bench::new("", 60, 200);
    bench.lie = |piece| {
        if piece.number == 1 {
            piece.number = 2;
        }
    };
    bench.run(4.0, |axis, _| assert_ne!(axis.planned, Some(true)));
    let far = &bench.receiver.snapshot().signals.far[0];
    assert_eq!(far.plan_fault, Some(PlanFault::Incomplete));
    assert!(far.plans_refused > 20, "{}", far.plans_refused);
}

#[test]
fn planned_cycles_do_not_allocate() {
    let mut bench = Bench::new("", 60, 400);
    bench.is_lost = |count| count.is_multiple_of(7) || OUTAGE(count);
    assert_no_alloc(|| bench.run(6.0, |_, _| {}));
    // In a debug build, an allocation ends the test at once.
    #[cfg(not(debug_assertions))]
    assert_eq!(assert_no_alloc::violation_count(), 0);
    assert!(bench.axis().planned_cycles > 220);
}
