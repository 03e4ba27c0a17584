//! Command server and order queue without a network.

use std::sync::{Arc, Mutex};

use coaxle_clock::{Instant, Span};
use coaxle_node::audit::AuditDoor;
use coaxle_node::command::{CommandVerdict, SlaveName, SlaveOrder};
use coaxle_node::keys::NodeName;
use coaxle_node::{CommandAnswer, CommandOrder};
use coaxle_os::machine::Machine;
use coaxle_slave::Command;

use super::*;
use crate::network::transport::Request;

/// A request that keeps its responses.
struct Kept {
    text: String,
    answers: Answers,
}

type Answers = Arc<Mutex<Vec<(String, CommandAnswer)>>>;

impl Request for Kept {
    fn key(&self) -> &str {
        "coaxle/toy/command"
    }

    fn payload(&self) -> std::borrow::Cow<'_, [u8]> {
        self.text.as_bytes().into()
    }

    fn reply(&self, json: String, taken: bool) {
        let answer = CommandAnswer::from_json(json.as_bytes()).unwrap();
        // The transport marks a response as an error by `taken`: both have to agree.
        assert_eq!(answer.is_taken(), taken);
        let entry = (self.text.clone(), answer);
        self.answers.lock().unwrap().push(entry);
    }
}

struct Bench {
    queue: OrderQueue,
    server: CommandServer,
    requests: RequestSender,
    answers: Answers,
    audit: Audit,
}

fn bench() -> Bench {
    let toy = NodeName::new("toy").unwrap();
    let audit = Audit::new(&toy, 0);
    let (queue, server, requests) = commands(&toy, &audit);
    Bench {
        queue,
        server,
        requests,
        answers: Answers::default(),
        audit,
    }
}

fn at(millis: i64) -> Instant<Machine> {
    Instant::EPOCH + Span::from_millis(millis)
}

/// An order that is distinguished from others by its position.
fn order(position: f64) -> String {
    let order = SlaveOrder {
        addressee: SlaveName::new("carriage").unwrap(),
        command: Command::Home { position },
        dry_run: false,
    };
    CommandOrder::from(order).to_json()
}

impl Bench {
    fn ask(&self, millis: i64, text: String) {
        let answers = Arc::clone(&self.answers);
        self.requests
            .send(at(millis), Box::new(Kept { text, answers }), None);
    }

    /// A scan, with the positions that were executed in it.
    fn scan(&mut self, millis: i64) -> Vec<f64> {
        let mut executed = Vec::new();
        self.queue.execute_all(at(millis), |order, _| {
            if let CommandOrder::Slave(SlaveOrder {
                command: Command::Home { position },
                ..
            }) = order
            {
                executed.push(*position);
            }
            order.without_addressee()
        });
        executed
    }

    fn reasons(&self) -> Vec<String> {
        let answers = std::mem::take(&mut *self.answers.lock().unwrap());
        let reason = |(_, answer): (_, CommandAnswer)| match answer.verdict {
            CommandVerdict::NotTaken { reason, .. } => reason,
            other => panic!("{other:?}"),
        };
        answers.into_iter().map(reason).collect()
    }
}

#[test]
fn each_order_is_executed_once_and_who_sent_it_gets_the_answer() {
    let mut bench = bench();
    bench.ask(0, order(1.0));
    bench.ask(0, order(2.0));
    bench.server.round(at(1));
    assert_eq!(bench.scan(2), [1.0, 2.0]);
    assert!(bench.scan(3).is_empty());
    bench.server.round(at(4));
    let asked: Vec<_> = std::mem::take(&mut *bench.answers.lock().unwrap())
        .into_iter()
        .map(|(by, _)| by)
        .collect();
    assert_eq!(asked, [order(1.0), order(2.0)]);
}

#[test]
fn what_is_no_order_never_reaches_the_cycle() {
    let mut bench = bench();
    bench.ask(0, "{".to_owned());
    bench.server.round(at(1));
    assert_eq!(bench.reasons(), ["malformed"]);
    assert!(bench.scan(2).is_empty());
}

#[test]
fn a_cycle_that_stands_still_neither_answers_nor_executes_later() {
    let mut bench = bench();
    bench.ask(0, order(1.0));
    bench.server.round(at(1));
    bench.server.round(at(999));
    assert!(bench.answers.lock().unwrap().is_empty());
    // The second is over exactly now, and 999 ms are within it.
    bench.server.round(at(1_000));
    assert_eq!(bench.reasons(), ["no-answer"]);
    // Popped with 1.001 s of age, beyond the 0.9 s: it returns unexecuted.
    assert!(bench.scan(1_001).is_empty());

    // The next order finds a working server.
    bench.ask(1_002, order(2.0));
    bench.server.round(at(1_003));
    assert_eq!(bench.scan(1_004), [2.0]);
    bench.server.round(at(1_005));
    // The toy of this test has no slaves: the reason shows that the order was executed.
    assert_eq!(bench.reasons(), ["no-slaves"]);
}

#[test]
fn sixteen_wait_and_more_are_refused() {
    let mut bench = bench();
    for k in 0..MAX_WAITING {
        bench.ask(0, order(k as f64));
    }
    // An order beyond the limit before the server's round, and another after.
    bench.ask(0, order(100.0));
    assert_eq!(bench.reasons(), ["busy"]);
    bench.server.round(at(1));
    bench.ask(1, order(101.0));
    bench.server.round(at(2));
    assert_eq!(bench.reasons(), ["busy"]);
    assert_eq!(bench.scan(3).len(), MAX_WAITING);
    bench.server.round(at(4));
    assert_eq!(bench.reasons().len(), MAX_WAITING);
}

#[test]
fn a_node_that_ends_says_so_to_those_who_wait() {
    let mut bench = bench();
    bench.ask(0, order(1.0));
    // Between the server's last look at the clock and the end of the cycle.
    bench.server.round(at(1));
    bench.scan(2);
    bench.ask(2, order(2.0));
    let Bench {
        queue,
        server,
        requests,
        answers,
        ..
    } = bench;
    drop(queue);
    server.work();
    let reason = |entry: &(String, CommandAnswer)| match &entry.1.verdict {
        CommandVerdict::NotTaken { reason, .. } => reason.clone(),
        other => panic!("{other:?}"),
    };
    let reasons: Vec<_> = answers.lock().unwrap().iter().map(reason).collect();
    // The first was executed and gets its outcome. The second was never taken from the queue.
    assert_eq!(reasons, ["no-slaves", "stopped"]);

    // The server is gone.
    let late = Kept {
        text: order(3.0),
        answers: Arc::clone(&answers),
    };
    requests.send(at(3), Box::new(late), None);
    assert_eq!(
        answers.lock().unwrap().last().map(reason).unwrap(),
        "stopped"
    );
}

#[test]
fn each_request_has_one_record_of_the_audit_with_its_result() {
    let mut bench = bench();
    bench.ask(0, order(1.0));
    bench.ask(0, "{".to_owned());
    bench.server.round(at(1));
    bench.scan(2);
    bench.server.round(at(3));
    // Too old when the cycle takes it.
    bench.ask(3_000, order(2.0));
    bench.server.round(at(3_001));
    assert!(bench.scan(4_500).is_empty());
    bench.server.round(at(4_501));
    for k in 0..=MAX_WAITING {
        bench.ask(5_000, order(k as f64));
    }
    let noted = bench.audit.take().into_iter();
    let noted = noted.map(|(_, record)| record.entry);
    // Other tests of this process may report connections.
    let noted = noted.filter(|entry| entry.door == AuditDoor::Order);
    let noted: Vec<_> = noted.map(|entry| entry.to_string()).collect();
    let home = "order of somebody without a name: MC_Home to \"carriage\": not taken";
    let request = "order of somebody without a name: request: not taken";
    for (noted, expected) in noted.iter().zip([
        format!("{request}, .: EOF while"),
        format!("{home}, the node has no slaves"),
        format!("{home}, "),
        format!("{request}, "),
    ]) {
        assert!(noted.starts_with(&expected), "{noted}: {expected}");
    }
    assert_eq!(noted.len(), 4, "{noted:?}");
}
