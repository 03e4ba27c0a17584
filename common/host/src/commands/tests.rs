//! Clerk and desk without a network.

use std::cell::RefCell;
use std::rc::Rc;

use coaxle_motion::slave::Command;
use coaxle_node::command::{NotTaken, SlaveName, Verdict};

use super::*;
use coaxle_node::CommandAnswer;

/// Keeps what it is told.
struct Paper {
    text: String,
    answers: Answers,
}

type Answers = Rc<RefCell<Vec<(String, CommandAnswer)>>>;

impl Asker for Paper {
    fn order(&self) -> std::borrow::Cow<'_, [u8]> {
        self.text.as_bytes().into()
    }

    fn answer(&self, answer: &CommandAnswer) {
        let entry = (self.text.clone(), answer.clone());
        self.answers.borrow_mut().push(entry);
    }
}

struct Bench {
    desk: Desk,
    clerk: Clerk<Paper>,
    counter: Counter<Paper>,
    answers: Answers,
}

fn bench() -> Bench {
    let (desk, clerk, counter) = commands();
    Bench {
        desk,
        clerk,
        counter,
        answers: Answers::default(),
    }
}

fn at(millis: i64) -> Instant<Machine> {
    Instant::EPOCH + Span::from_millis(millis)
}

/// An order that is told from others by its position.
fn order(position: f64) -> String {
    let order = CommandOrder {
        slave: SlaveName::new("carriage").unwrap(),
        command: Command::Home { position },
        dry_run: false,
    };
    order.to_json()
}

impl Bench {
    fn ask(&self, millis: i64, text: String) {
        let answers = Rc::clone(&self.answers);
        self.counter.hand_in(Incoming {
            arrival: at(millis),
            asker: Paper { text, answers },
        });
    }

    /// A scan, with the positions that were executed in it.
    fn scan(&mut self, millis: i64) -> Vec<f64> {
        let mut executed = Vec::new();
        self.desk.serve(at(millis), |order| {
            if let Command::Home { position } = order.command {
                executed.push(position);
            }
            CommandOutcome::NotTaken(NotTaken::NoSlaves)
        });
        executed
    }

    fn reasons(&self) -> Vec<String> {
        let answers = self.answers.take();
        let reason = |(_, answer): (_, CommandAnswer)| match answer.verdict {
            Verdict::NotTaken { reason, .. } => reason,
            other => panic!("{other:?}"),
        };
        answers.into_iter().map(reason).collect()
    }
}

#[test]
fn each_order_is_executed_once_and_its_own_asker_gets_the_answer() {
    let mut bench = bench();
    bench.ask(0, order(1.0));
    bench.ask(0, order(2.0));
    bench.clerk.round(at(1));
    assert_eq!(bench.scan(2), [1.0, 2.0]);
    assert!(bench.scan(3).is_empty());
    bench.clerk.round(at(4));
    let asked: Vec<_> = bench.answers.take().into_iter().map(|(by, _)| by).collect();
    assert_eq!(asked, [order(1.0), order(2.0)]);
}

#[test]
fn what_is_no_order_never_reaches_the_cycle() {
    let mut bench = bench();
    bench.ask(0, "{".to_owned());
    bench.clerk.round(at(1));
    assert_eq!(bench.reasons(), ["malformed"]);
    assert!(bench.scan(2).is_empty());
}

#[test]
fn a_cycle_that_stands_still_neither_answers_nor_executes_later() {
    let mut bench = bench();
    bench.ask(0, order(1.0));
    bench.clerk.round(at(1));
    bench.clerk.round(at(999));
    assert!(bench.answers.borrow().is_empty());
    bench.clerk.round(at(1_000));
    assert_eq!(bench.reasons(), ["no-answer"]);
    assert!(bench.scan(1_001).is_empty());

    // The next one finds everything as it should be.
    bench.ask(1_002, order(2.0));
    bench.clerk.round(at(1_003));
    assert_eq!(bench.scan(1_004), [2.0]);
    bench.clerk.round(at(1_005));
    assert_eq!(bench.reasons(), ["no-slaves"]);
}

#[test]
fn sixteen_wait_and_more_are_refused() {
    let mut bench = bench();
    for k in 0..MAX_WAITING {
        bench.ask(0, order(k as f64));
    }
    // One too many before the clerk has looked, and one after.
    bench.ask(0, order(100.0));
    assert_eq!(bench.reasons(), ["busy"]);
    bench.clerk.round(at(1));
    bench.ask(1, order(101.0));
    bench.clerk.round(at(2));
    assert_eq!(bench.reasons(), ["busy"]);
    assert_eq!(bench.scan(3).len(), MAX_WAITING);
    bench.clerk.round(at(4));
    assert_eq!(bench.reasons().len(), MAX_WAITING);
}

#[test]
fn a_node_that_ends_says_so_to_those_who_wait() {
    let mut bench = bench();
    bench.ask(0, order(1.0));
    // Between the clerk's last look at the clock and the end of the cycle.
    bench.clerk.round(at(1));
    bench.scan(2);
    bench.ask(2, order(2.0));
    let Bench {
        desk,
        clerk,
        counter,
        answers,
    } = bench;
    drop(desk);
    clerk.work();
    let reason = |entry: &(String, CommandAnswer)| match &entry.1.verdict {
        Verdict::NotTaken { reason, .. } => reason.clone(),
        other => panic!("{other:?}"),
    };
    let reasons: Vec<_> = answers.borrow().iter().map(reason).collect();
    assert_eq!(reasons, ["no-slaves", "stopped"]);

    // There is nobody left to take it.
    counter.hand_in(Incoming {
        arrival: at(3),
        asker: Paper {
            text: order(3.0),
            answers: Rc::clone(&answers),
        },
    });
    assert_eq!(answers.borrow().last().map(reason).unwrap(), "stopped");
}
