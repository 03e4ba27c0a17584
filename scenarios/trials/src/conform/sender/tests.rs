//! A correct node, and variants with one fault each: exactly the rule about that fault is broken.

use coaxle_axis::{NcToPlcAxis, StateWord};
use coaxle_clock::{CycleIndex, CycleTime, Instant, Span};
use coaxle_host::network::transport::Delivery;
use coaxle_node::exchange::{
    ReceivedRequest, TIME_RESPONSES_CAPACITY, TimeResponsesHeader, encode_time_responses,
};
use coaxle_node::frame::{KeySeal, body_capacity, encode_body, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, FrameHeader, PresentAfter, TimeRequest};
use coaxle_os::Machine;
use serde_json::{Value, json};

use self::Fault::{Arrival, Bytes, Frame, Reply, Status, Tokens};
use super::judge::rules::{RULES, Tallies};
use super::judge::runs::RunChecks;
use super::judge::{Requester, SenderJudge};
use crate::conform::rule::{RuleFinding, RuleOutcome};

const EPOCH: u64 = 0x0123_4567_89ab_cdef;
const CYCLE: Span = Span::from_millis(10);
const START: Instant<Machine> = Instant::from_nanos(1_000_000_000_000);
const REQUESTER: Requester = Requester { id: 5, run: 6 };

/// Fault of a node, by the number of its cycle.
#[derive(Clone, Copy)]
enum Fault {
    Frame(fn(u64, &mut FrameHeader, &mut Vec<NcToPlcAxis>)),
    /// Frames that are sent in place of one.
    Bytes(fn(u64, Vec<u8>) -> Vec<Vec<u8>>),
    Arrival(fn(u64, &mut Instant<Machine>)),
    Delivery(fn(&mut Delivery)),
    /// A response, and its stamp.
    Reply(fn(&mut TimeResponsesHeader, &mut ReceivedRequest, &mut Span)),
    Status(fn(&mut Value)),
    Tokens(fn(&NodeName) -> Vec<String>),
}

/// A node that publishes for four seconds, with its faults.
struct Bench {
    node: NodeName,
    judge: SenderJudge,
    faults: Vec<Fault>,
    delivery: Delivery,
}

impl Bench {
    fn with(faults: &[Fault]) -> Self {
        let node = NodeName::new("belt").unwrap();
        let mut delivery = Delivery {
            priority: 1,
            is_dropped: true,
            is_express: false,
        };
        for fault in faults {
            if let Fault::Delivery(change) = fault {
                change(&mut delivery);
            }
        }
        Self {
            judge: SenderJudge::new(&node, Channel::Axes, REQUESTER, START),
            node,
            faults: faults.to_vec(),
            delivery,
        }
    }

    fn findings(mut self) -> Vec<RuleFinding> {
        let mut tokens = vec![self.node.alive_key(), self.node.run_key(EPOCH)];
        for fault in &self.faults {
            if let Tokens(others) = fault {
                tokens = others(&self.node);
            }
        }
        for key in tokens {
            self.judge.token(&key, true);
        }
        for count in 0..400 {
            self.cycle(count);
        }
        self.judge.findings(START + CYCLE * 400)
    }

    fn cycle(&mut self, count: u64) {
        let due = START + CYCLE * count as i64;
        let mut at = due + Span::from_micros(200);
        let mut frames = vec![self.sealed(count)];
        for fault in &self.faults {
            match fault {
                Arrival(change) => change(count, &mut at),
                Bytes(others) => frames = others(count, frames.remove(0)),
                _ => {}
            }
        }
        for bytes in frames {
            self.judge.frame(at, &bytes, Some(self.delivery));
        }
        if count % 10 == 5 {
            self.exchange(count, due + Span::from_millis(3));
        }
        if count % 25 == 7 {
            self.status(count, at);
        }
    }

    fn status(&mut self, count: u64, at: Instant<Machine>) {
        let mut status = json!({ "node": "belt", "role": "sender", "health": "ok",
            "epoch": format!("{EPOCH:016x}"), "uptime_s": 1.0, "cycle": count, "cycle_time_us": 10_000.0 });
        for fault in &self.faults {
            if let Status(change) = fault {
                change(&mut status);
            }
        }
        let text = match &status {
            Value::String(text) => text.clone(),
            status => status.to_string(),
        };
        self.judge.status(at, text.as_bytes());
    }

    fn sealed(&self, count: u64) -> Vec<u8> {
        let mut header = FrameHeader {
            sender: sender_id(&self.node),
            epoch: EPOCH,
            index: CycleIndex::of_count(count),
            count,
            cycle_time: CycleTime::new(CYCLE).unwrap(),
            present_after: None,
            send_stamp: Some(Span::from_micros(50)),
        };
        let position = 0.1 * count as f64;
        let axis = |axis_id| NcToPlcAxis {
            axis_id,
            state_word: StateWord::POSITIVE_DIRECTION,
            set_position: position,
            set_velocity: 10.0,
            ..NcToPlcAxis::default()
        };
        let mut axes = vec![axis(1), axis(2)];
        for fault in &self.faults {
            if let Frame(change) = fault {
                change(count, &mut header, &mut axes);
            }
        }
        let mut body = vec![0; body_capacity(axes.len())];
        let length = encode_body(&header, &axes, &mut body).unwrap();
        let mut sealed = Vec::new();
        let seal = KeySeal::new(&self.node.channel_key(Channel::Axes));
        seal.seal(&body[..length], header.send_stamp, &mut sealed);
        sealed
    }

    /// A request at `asked`, and its response in the next cycle.
    fn exchange(&mut self, count: u64, asked: Instant<Machine>) {
        let request = TimeRequest {
            requester: REQUESTER.id,
            run: REQUESTER.run,
            number: count as u32,
            requested: asked.as_nanos(),
        };
        self.judge.request_sent(asked, request, true);
        let mut header = TimeResponsesHeader {
            sender: sender_id(&self.node),
            epoch: EPOCH,
            count: count + 1,
            cycle_time: CycleTime::new(CYCLE).unwrap(),
        };
        let mut reply = ReceivedRequest {
            request,
            received: asked + Span::from_micros(150) - START,
        };
        let mut stamp = Span::from_micros(300);
        for fault in &self.faults {
            if let Reply(change) = fault {
                change(&mut header, &mut reply, &mut stamp);
            }
        }
        let mut body = [0; TIME_RESPONSES_CAPACITY];
        let length = encode_time_responses(&header, &[reply], &mut body);
        let mut sealed = Vec::new();
        let seal = KeySeal::new(&self.node.channel_key(Channel::TimeResponses));
        seal.seal(&body[..length], Some(stamp), &mut sealed);
        let at = START + CYCLE * (count + 1) as i64 + Span::from_micros(500);
        self.judge.responses(at, &sealed, Some(self.delivery));
    }
}

fn broken(findings: &[RuleFinding]) -> Vec<&'static str> {
    let broken = findings.iter().filter(|finding| finding.is_broken());
    broken.map(|finding| finding.rule.name).collect()
}

#[test]
fn a_node_as_it_should_be_keeps_every_rule() {
    let findings = Bench::with(&[]).findings();
    assert_eq!(findings.len(), 32);
    for (n, finding) in findings.iter().enumerate() {
        assert_eq!(finding.rule.number, format!("S{}", n + 1));
        let is_kept = matches!(finding.outcome, RuleOutcome::Kept { .. });
        assert!(is_kept, "{finding:?}");
    }
}

/// Expects exactly this rule to be broken.
#[track_caller]
fn finds(rule: &str, faults: &[Fault]) -> RuleOutcome {
    let findings = Bench::with(faults).findings();
    assert_eq!(broken(&findings), [rule], "{findings:#?}");
    let found = findings.into_iter().find(RuleFinding::is_broken);
    found.expect("one is broken").outcome
}

/// Expects no rule to be broken.
#[track_caller]
fn finds_nothing(faults: &[Fault], reason: &str) {
    let findings = Bench::with(faults).findings();
    assert_eq!(broken(&findings), Vec::<&str>::new(), "{reason}");
}

/// Length of the stamp of 50 µs and of the check sum.
const STAMP_AND_SUM: usize = 4 + 4;

/// A frame of this body, with a right check sum.
fn sealed_again(body: &[u8]) -> Vec<Vec<u8>> {
    let key = NodeName::new("belt").unwrap().channel_key(Channel::Axes);
    let mut sealed = Vec::new();
    KeySeal::new(&key).seal(body, Some(Span::from_micros(50)), &mut sealed);
    vec![sealed]
}

/// Frames that are shown 8 ms later.
const SHOWN_LATER: Fault = Frame(|_, header, _| {
    header.present_after = PresentAfter::new(Span::from_millis(8));
});

#[test]
fn a_node_whose_frames_are_shown_later_keeps_every_rule() {
    finds_nothing(&[SHOWN_LATER], "version 2 is as good as version 1");
}

#[test]
fn frames_that_are_none_are_found() {
    let version = Bytes(|_, mut bytes| {
        bytes[0] = 3;
        vec![bytes]
    });
    finds("version", &[version]);
    finds("fields", &[Bytes(|_, bytes| vec![bytes[..20].to_vec()])]);
    let version_2_without_its_field = Bytes(|_, bytes| {
        let mut body = bytes[..bytes.len() - STAMP_AND_SUM].to_vec();
        body[0] = 2;
        sealed_again(&body)
    });
    finds("fields", &[version_2_without_its_field]);
    let shown_too_late = Bytes(|_, bytes| {
        // 8 000 000 as a number of four bytes becomes 4 000 000 001, of five.
        let delay = [0x80, 0xA4, 0xE8, 0x03];
        let at = bytes.windows(4).position(|four| four == delay).unwrap();
        let (before, after) = bytes[..bytes.len() - STAMP_AND_SUM].split_at(at);
        sealed_again(&[before, &[0x81, 0xD0, 0xAC, 0xF3, 0x0E], &after[4..]].concat())
    });
    finds("present-after", &[SHOWN_LATER, shown_too_late]);
    let check_sum = Bytes(|_, mut bytes| {
        *bytes.last_mut().unwrap() ^= 4;
        vec![bytes]
    });
    finds("check-sum", &[check_sum]);
    finds("sender-id", &[Frame(|_, header, _| header.sender = 7)]);
}

#[test]
fn what_is_wrong_with_a_run_is_found() {
    let other_run = Frame(|count, header, _| {
        if (100..120).contains(&count) {
            header.epoch = EPOCH ^ 1;
        }
    });
    let epoch = finds("epoch", &[other_run]);
    assert!(
        matches!(epoch, RuleOutcome::Broken { received, .. } if received.contains("though the count goes on"))
    );
    let other_cycle_time = Frame(|count, header, _| {
        if count % 20 == 9 {
            header.cycle_time = CycleTime::new(CYCLE * 2).unwrap();
        }
    });
    finds("cycle-time", &[other_cycle_time]);
    let twice = Bytes(|count, bytes| vec![bytes; if count == 9 { 2 } else { 1 }]);
    finds("count", &[twice]);
    finds(
        "index",
        &[Frame(|_, header, _| header.index = CycleIndex(3))],
    );
}

#[test]
fn a_restart_has_another_epoch() {
    let restarted = |epoch: u64| {
        let node = NodeName::new("belt").unwrap();
        let (mut runs, mut tallies) = (RunChecks::default(), Tallies::default());
        let header = |epoch, count| FrameHeader {
            sender: sender_id(&node),
            epoch,
            index: CycleIndex::of_count(count),
            count,
            cycle_time: CycleTime::new(CYCLE).unwrap(),
            present_after: None,
            send_stamp: None,
        };
        for count in 0..200 {
            let _ = runs.take(&header(EPOCH, count), &mut tallies);
        }
        for count in 0..200 {
            let _ = runs.take(&header(epoch, count), &mut tallies);
        }
        let rules = RULES.iter().zip(tallies.iter());
        let findings = rules.map(|(rule, tally)| RuleFinding::new(rule, tally.outcome("", "")));
        broken(&findings.collect::<Vec<_>>())
    };
    assert_eq!(restarted(EPOCH ^ 1), Vec::<&str>::new());
    assert_eq!(restarted(EPOCH), ["epoch"]);
}

#[test]
fn frames_that_come_at_other_times_than_their_counts_say_are_found() {
    // Both pace and stamps are two per cent slow.
    let slow = Arrival(|count, at| *at += Span::from_micros(200) * count as i64);
    finds("pace", &[slow]);
    let half = Bytes(|count, bytes| vec![bytes; (count % 2 == 0).into()]);
    finds("every-cycle", &[half]);
    let in_bursts = Frame(|count, header, _| {
        let stamp = CYCLE * (9 - (count % 10) as i64) + Span::from_nanos(count as i64);
        header.send_stamp = Some(stamp);
    });
    finds("no-bursts", &[in_bursts]);
    let in_tens = Arrival(|count, at| *at = START + CYCLE * (count / 10 * 10 + 10) as i64);
    finds("no-bursts", &[WITHOUT_STAMP, in_tens]);
}

const WITHOUT_STAMP: Fault = Frame(|_, header, _| header.send_stamp = None);

#[test]
fn stamps_that_say_nothing_are_found() {
    let now_and_then = Frame(|count, header, _| {
        if count % 3 == 0 {
            header.send_stamp = None;
        }
    });
    finds("stamp-present", &[now_and_then]);
    let zero = Frame(|_, header, _| header.send_stamp = Some(Span::ZERO));
    finds("stamp-range", &[zero]);
    let late = Frame(|_, header, _| header.send_stamp = Some(Span::from_secs(2)));
    finds("stamp-range", &[late]);
    let crossed = Frame(|count, header, _| {
        header.send_stamp = Some(CYCLE * (if count % 2 == 0 { 8 } else { -8 }) / 10);
    });
    finds("stamp-order", &[crossed]);
    finds_nothing(&[WITHOUT_STAMP], "a client that does not know has none");
}

#[test]
fn axes_that_cannot_be_are_found() {
    finds("axis-ids", &[Frame(|_, _, axes| axes[1].axis_id = 1)]);
    let swapped = Frame(|count, _, axes| axes.swap(0, (count % 2) as usize));
    finds("axis-order", &[swapped]);
    let not_a_number = Frame(|count, _, axes| {
        if count == 50 {
            axes[1].actual_velocity = f64::NAN;
        }
    });
    finds("axis-numbers", &[not_a_number]);
    let both_ways = Frame(|_, _, axes| axes[0].state_word |= StateWord::NEGATIVE_DIRECTION);
    finds("axis-state", &[both_ways]);
    let silent_error = Frame(|_, _, axes| axes[0].state_word = StateWord::ERROR);
    finds("axis-state", &[silent_error]);
    let per_minute = Frame(|_, _, axes| axes[0].set_velocity *= 60.0);
    finds("axis-velocity", &[per_minute]);
}

#[test]
fn responses_that_are_none_are_found() {
    finds("answer-frame", &[Reply(|header, _, _| header.epoch ^= 1)]);
    let other_time = Reply(|_, reply, _| reply.request.requested += 1);
    finds("answer-echo", &[other_time]);
    let before_asked = Reply(|_, reply, _| reply.received += Span::from_millis(20));
    finds("answer-stamps", &[before_asked]);
    let other_clock = Reply(|_, reply, stamp| {
        reply.received += Span::from_secs(100);
        *stamp = Span::from_secs(100);
    });
    finds("answer-stamps", &[other_clock]);
    let to_others = Reply(|header, reply, _| {
        header.epoch = EPOCH;
        reply.request.requester = 99;
    });
    finds_nothing(&[to_others], "what others asked is theirs");
}

#[test]
fn what_is_wrong_with_status_tokens_and_delivery_is_found() {
    finds("status-json", &[Status(|status| *status = json!("{"))]);
    let short = Status(|status| status["epoch"] = json!("12"));
    finds("status-fields", &[short]);
    let elsewhere = Status(|status| status["cycle"] = json!(5_000));
    finds("status-true", &[elsewhere]);
    finds("alive", &[Tokens(|node| vec![node.run_key(EPOCH)])]);
    let other_run = Tokens(|node| vec![node.alive_key(), node.run_key(5)]);
    finds("run-token", &[other_run]);
    finds("qos", &[Fault::Delivery(|delivery| delivery.priority = 5)]);
    let waited_for = Fault::Delivery(|delivery| delivery.is_dropped = false);
    finds("qos", &[waited_for]);
}
