//! The script, played to a correct receiver, and to receivers with one fault each.

use std::collections::BTreeMap;

use coaxle_clock::{CycleTime, Instant, Span};
use coaxle_node::exchange::{TIME_REQUEST_CAPACITY, encode_time_request};
use coaxle_node::frame::{KeySeal, sender_id};
use coaxle_node::intake::RejectionCounters;
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, FrameHeader, Intake, Message, Reader};
use coaxle_os::Machine;
use serde_json::{Map, Value, json};

use super::player::{PlayedRole, Player};
use super::script::SCRIPT;
use crate::conform::rule::{RuleFinding, RuleOutcome};

const EPOCH: u64 = 77;

/// Name of the counter of frames refused for this reason.
fn rejected(reason: &str) -> String {
    format!("rejected_{}", reason.replace('-', "_"))
}

/// Names of all counters.
fn counters() -> impl Iterator<Item = String> {
    let reasons = RejectionCounters::default();
    let rejections: Vec<_> = reasons.iter().map(|(name, _)| rejected(name)).collect();
    COUNTERS.into_iter().map(str::to_owned).chain(rejections)
}

/// Counters beside those of rejections.
const COUNTERS: [&str; 7] = [
    "received",
    "duplicates",
    "late",
    "foreign_frames",
    "restarts",
    "exchanges",
    "responses_refused",
];

/// A receiver in a few lines, which counts as docs/WIRE.md requires.
struct Toy {
    played: NodeName,
    name: NodeName,
    intake: Intake,
    responses: Reader,
    counters: BTreeMap<String, u64>,
    newest: Option<FrameHeader>,
    last_at: Instant<Machine>,
    error: u32,
    asked: u32,
    open: Vec<u32>,
}

impl Toy {
    fn new(played: &NodeName, name: &NodeName) -> Self {
        Self {
            intake: Intake::new(&played.channel_key(Channel::Axes), played, &[3]),
            responses: Reader::time_responses_of(played, name),
            played: played.clone(),
            name: name.clone(),
            counters: counters().map(|name| (name, 0)).collect(),
            newest: None,
            last_at: Instant::EPOCH,
            error: 0,
            asked: 0,
            open: Vec::new(),
        }
    }

    fn count(&mut self, name: &str) {
        *self.counters.entry(name.to_owned()).or_default() += 1;
    }

    fn frame(&mut self, at: Instant<Machine>, bytes: &[u8]) {
        let (header, error) = match self.intake.accept(bytes) {
            Ok(frame) => (
                frame.header,
                frame.axes[0].map_or(0, |axis| axis.error_code),
            ),
            Err(reason) => return self.count(&rejected(reason.name())),
        };
        self.count("received");
        if let Some(newest) = self.newest {
            let is_silent = at - self.last_at > Span::from_secs(1);
            let same = (header.epoch, header.cycle_time) == (newest.epoch, newest.cycle_time);
            if !same && is_silent {
                self.count("restarts");
            } else if !same || header.count > newest.count + 100 {
                return self.count("foreign_frames");
            } else if header.count == newest.count {
                return self.count("duplicates");
            } else if header.count < newest.count {
                return self.count("late");
            }
            self.error = error;
        }
        self.newest = Some(header);
        self.last_at = at;
    }

    fn response(&mut self, bytes: &[u8]) {
        let open = &mut self.open;
        let mut used = Vec::new();
        self.responses.read(bytes, |message| {
            let place = match message {
                Message::TimeResponse(response) if response.run == EPOCH => {
                    open.iter().position(|number| *number == response.number)
                }
                _ => None,
            };
            used.push(place.map(|place| open.remove(place)).is_some());
        });
        for is_used in used {
            self.count(if is_used {
                "exchanges"
            } else {
                "responses_refused"
            });
        }
    }

    fn request(&mut self, at: Instant<Machine>) -> Vec<u8> {
        let mut body = [0; TIME_REQUEST_CAPACITY];
        self.asked += 1;
        self.open.push(self.asked);
        let ideal = coaxle_os::machine::local(at);
        let length =
            encode_time_request(sender_id(&self.name), EPOCH, self.asked, ideal, &mut body);
        let mut sealed = Vec::new();
        let seal = KeySeal::new(&self.played.channel_key(Channel::TimeRequests));
        seal.seal(&body[..length], Some(Span::ZERO), &mut sealed);
        sealed
    }

    fn status(&self) -> Map<String, Value> {
        let mut far = json!(self.counters);
        far["epoch"] = json!(self.newest.map(|header| header.epoch));
        far["count"] = json!(self.newest.map(|header| header.count));
        let status = json!({ "node": self.name, "epoch": format!("{EPOCH:016x}"),
            "far": { self.played.as_str(): far },
            "axes": { "axis": { "node": self.played, "id": 3, "received_error": self.error } } });
        status.as_object().unwrap().clone()
    }
}

/// Plays the script to a receiver; `spoil` changes each status.
fn play(asks: bool, spoil: impl Fn(&mut Map<String, Value>)) -> Vec<RuleFinding> {
    let name = |name: &str| NodeName::new(name).unwrap();
    let (played, receiver) = (name("belt"), name("saw"));
    let mut toy = Toy::new(&played, &receiver);
    let start = Instant::from_nanos(5_000_000_000);
    let part = PlayedRole {
        played,
        axis: 3,
        receiver,
        cycle_time: CycleTime::new(Span::from_millis(10)).unwrap(),
        epoch: 0x1234,
    };
    let mut player = Player::new(part, start);
    player.seen_by(true);
    for tick in 0..20_000 {
        if player.is_done() {
            break;
        }
        let now = start + Span::from_millis(10) * tick;
        if tick % 10 == 3 && asks {
            let request = toy.request(now);
            player.request(now, &request);
        }
        for (channel, frame) in player.cycle(now) {
            match channel {
                Channel::Axes => toy.frame(now, &frame),
                _ => toy.response(&frame),
            }
        }
        if tick % 25 == 0 {
            let mut status = toy.status();
            spoil(&mut status);
            player.status(now, &status);
        }
    }
    assert!(player.is_done(), "it comes to an end");
    player.findings()
}

fn broken(findings: &[RuleFinding]) -> Vec<&'static str> {
    let broken = findings.iter().filter(|finding| finding.is_broken());
    broken.map(|finding| finding.rule.name).collect()
}

#[test]
fn a_receiver_as_it_should_be_keeps_every_rule() {
    let findings = play(true, |_| {});
    assert_eq!(findings.len(), SCRIPT.len() + 2);
    for (n, finding) in findings.iter().enumerate() {
        assert_eq!(finding.rule.number, format!("R{}", n + 1));
        let is_kept = matches!(finding.outcome, RuleOutcome::Kept { .. });
        assert!(is_kept, "{finding:?}");
    }
}

#[test]
fn one_that_counts_nothing_is_found_and_the_rest_is_not() {
    for (counter, rules) in [
        ("rejected_truncated", vec!["truncated"]),
        ("rejected_implausible", vec!["implausible"]),
        ("late", vec!["late"]),
        (
            "foreign_frames",
            vec!["other-run", "other-cycle-time", "other-count"],
        ),
        ("responses_refused", vec!["bad-responses"]),
    ] {
        let findings = play(true, |status| status["far"]["belt"][counter] = json!(0));
        assert_eq!(broken(&findings), rules, "{counter}");
    }
    let findings = play(true, |status| {
        status["axes"]["axis"]["received_error"] = json!(0)
    });
    assert_eq!(broken(&findings), ["error-code"]);
}

#[test]
fn what_a_status_does_not_tell_is_not_seen() {
    let findings = play(true, |status| {
        let far = status["far"]["belt"].as_object_mut().unwrap();
        far.remove("rejected_malformed");
    });
    assert_eq!(broken(&findings), Vec::<&str>::new());
    let unseen: Vec<_> = findings
        .iter()
        .filter(|finding| matches!(finding.outcome, RuleOutcome::NotSeen { .. }))
        .map(|finding| finding.rule.name)
        .collect();
    assert_eq!(unseen, ["malformed"]);
}

#[test]
fn who_never_asks_for_the_time_breaks_nothing() {
    let findings = play(false, |_| {});
    assert_eq!(broken(&findings), Vec::<&str>::new());
    let of_requests = ["requests", "responses", "bad-responses"];
    let unseen = findings
        .iter()
        .filter(|finding| of_requests.contains(&finding.rule.name));
    for finding in unseen {
        let is_unseen = matches!(finding.outcome, RuleOutcome::NotSeen { .. });
        assert!(is_unseen, "{finding:?}");
    }
}
