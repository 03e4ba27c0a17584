//! Followers of a sender's axes: reports in, motion and signals out.

use assert_no_alloc::assert_no_alloc;
use coaxle_clock::{Instant, Local, Span};
use coaxle_curve::profile::Limits;
use coaxle_node::config::parse;
use coaxle_node::{Channel, FollowerState, Message, Node, ReceivedReport, Rejection};
use coaxle_sender::config::SenderConfig;
use coaxle_sender::{FollowerCondition, Sender};

const START: Instant<Local> = Instant::from_nanos(5_000_000_000);
const RUN: u64 = 42;

/// Subscriptions behind that to time requests.
const SAW: usize = 1;
const WINDER: usize = 2;

const AXIS: &str = "name = 'line'\ncycle-time-us = 1000\n\
    [[axis]]\nid = 3\nname = 'conveyor'\nfollowers = { nodes = ['saw', 'winder'], on-failure = 'halt' }\n\
    [axis.program]\nlimits = { velocity = 1000, acceleration = 5000, jerk = 100000 }\n\
    steps = [{ enable = true }, { when = { followers = 'in-sync' } }, { velocity = { value = 500 } }]\n";

fn config(text: &str) -> SenderConfig {
    parse("s.toml", text).expect("valid")
}

struct Bench {
    sender: Sender,
    count: u64,
    /// Report of each follower: its epoch, slaves in sync, slaves in error.
    saw: Option<(u64, u16, u16)>,
    winder: Option<(u64, u16, u16)>,
}

impl Bench {
    fn new() -> Self {
        Self {
            sender: Sender::new(&config(AXIS), START, RUN).expect("valid"),
            count: 0,
            saw: None,
            winder: None,
        }
    }

    fn report(&mut self, subscription: usize, epoch: u64, in_sync: u16, in_error: u16) {
        let report = ReceivedReport {
            epoch,
            count: self.count,
            run: RUN,
            axis_id: 3,
            state: FollowerState {
                slaves: 2,
                in_sync,
                in_error,
                distance: 0.0,
                limits: Limits::NONE,
                wanted_delay: None,
            },
        };
        let at = self.sender.next_cycle() - Span::from_micros(100);
        let message = Message::FollowerReport(report);
        assert_no_alloc(|| self.sender.receive(at, subscription, &message));
    }

    /// Runs this number of cycles, with a report of each every 50 ms.
    fn run(&mut self, cycles: u64) {
        for _ in 0..cycles {
            if self.count.is_multiple_of(50) {
                let reports = [(SAW, self.saw), (WINDER, self.winder)];
                for (subscription, report) in reports {
                    if let Some((epoch, in_sync, in_error)) = report {
                        self.report(subscription, epoch, in_sync, in_error);
                    }
                }
            }
            self.count += 1;
            let now = self.sender.next_cycle();
            assert_no_alloc(|| self.sender.cycle(now));
            while self.sender.transmit().is_some() {}
        }
    }

    fn velocity(&self) -> f64 {
        self.sender.axes()[0].set_velocity
    }

    fn conditions(&self) -> &[FollowerCondition] {
        &self.sender.snapshot().followers
    }
}

#[test]
fn it_waits_for_all_and_halts_with_any() {
    use FollowerCondition::{BegunAgain, InError, InSync, NotInSync, Silent, Unheard};
    let mut bench = Bench::new();
    bench.saw = Some((7, 2, 0));
    bench.run(500);
    assert_eq!(bench.conditions(), [InSync, Unheard]);
    bench.winder = Some((8, 1, 0));
    bench.run(500);
    assert_eq!(bench.conditions(), [InSync, NotInSync]);
    assert_eq!(bench.velocity(), 0.0);
    bench.winder = Some((8, 2, 0));
    bench.run(1_000);
    let signals = bench.sender.snapshot().signals.node;
    assert_eq!(
        (signals.followers_in_sync, signals.followers_failed),
        (2, 0)
    );
    assert_eq!(bench.velocity(), 500.0);
    // One that loses sync without an error does not stop it: it may have been uncoupled.
    bench.winder = Some((8, 0, 0));
    bench.run(500);
    assert_eq!(bench.velocity(), 500.0);

    for (failed, condition) in [
        (Some((7, 1, 1)), InError),
        (None, Silent),
        (Some((99, 0, 0)), BegunAgain),
    ] {
        bench.saw = failed;
        bench.run(1_000);
        assert_eq!(bench.conditions()[0], condition);
        assert_eq!(bench.velocity(), 0.0);
        let signals = bench.sender.snapshot().signals.node;
        assert_eq!((signals.followers_failed, signals.axes_held), (1, 1));
        bench.saw = Some((failed.map_or(7, |(epoch, ..)| epoch), 2, 0));
        bench.run(1_000);
        assert_eq!(bench.velocity(), 500.0);
    }
}

#[test]
fn reports_of_others_say_nothing() {
    let mut bench = Bench::new();
    bench.saw = Some((7, 2, 0));
    bench.winder = Some((8, 2, 0));
    bench.run(1_000);
    let well = |bench: &Bench| bench.conditions() == [FollowerCondition::InSync; 2];
    let stored = |bench: &mut Bench, change: &dyn Fn(&mut ReceivedReport)| {
        let mut report = ReceivedReport {
            epoch: 7,
            count: bench.count + 1_000,
            run: RUN,
            axis_id: 3,
            state: FollowerState {
                slaves: 2,
                in_sync: 0,
                in_error: 2,
                distance: 0.0,
                limits: Limits::NONE,
                wanted_delay: None,
            },
        };
        change(&mut report);
        let at = bench.sender.next_cycle();
        let message = Message::FollowerReport(report);
        bench.sender.receive(at, SAW, &message);
        bench.run(1);
    };
    stored(&mut bench, &|it| it.run = RUN - 1);
    assert!(well(&bench), "of an earlier run of the sender");
    stored(&mut bench, &|it| it.axis_id = 4);
    assert!(well(&bench), "of another axis");
    stored(&mut bench, &|it| it.count = 3);
    assert!(well(&bench), "an earlier one");
    stored(&mut bench, &|_| {});
    assert!(!well(&bench));
    // The follower begins again; the last reports of its earlier run come late.
    bench.saw = Some((9, 2, 0));
    bench.run(100);
    assert!(well(&bench));
    stored(&mut bench, &|it| it.count = u64::MAX);
    assert!(well(&bench), "of the run before");
    let rejected = Message::Rejected(Rejection::WrongChecksum);
    bench.sender.receive(START, SAW, &rejected);
    bench.run(1);
    let signals = bench.sender.snapshot().signals.node;
    assert_eq!((signals.reports_refused, signals.requests_refused), (1, 0));
}

#[test]
fn it_subscribes_to_each_follower_once_and_does_not_follow_itself() {
    let two = AXIS.to_owned()
        + "[[axis]]\nid = 4\nname = 'belt'\nfollowers = { nodes = ['winder', 'cutter'] }\n\
           [axis.program]\nlimits = { velocity = 1, acceleration = 1, jerk = 1 }\n";
    let wiring = config(&two).wiring();
    let followed: Vec<_> = (wiring.subscriptions.iter())
        .filter(|it| it.channel == Channel::Followers)
        .map(|it| it.node.as_str())
        .collect();
    assert_eq!(followed, ["saw", "winder", "cutter"]);
    let itself = AXIS.replace("'winder'", "'line'");
    let error = Sender::new(&config(&itself), START, RUN)
        .err()
        .expect("wrong");
    assert_eq!(
        error.to_string(),
        "axis[0].followers.nodes[1]: received \"line\", the node itself, expected receivers"
    );
}
