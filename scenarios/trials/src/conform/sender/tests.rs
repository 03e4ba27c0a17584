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

use super::judge::{Requester, SenderJudge};
use crate::conform::rule::{RuleFinding, RuleOutcome};

const EPOCH: u64 = 0x0123_4567_89ab_cdef;
const CYCLE: Span = Span::from_millis(10);
const START: Instant<Machine> = Instant::from_nanos(1_000_000_000_000);
const REQUESTER: Requester = Requester { id: 5, run: 6 };

/// A node that publishes for four seconds, and the changes applied to its messages.
struct Bench {
    node: NodeName,
    judge: SenderJudge,
    frame: fn(u64, &mut FrameHeader, &mut Vec<NcToPlcAxis>),
    bytes: fn(u64, Vec<u8>) -> Vec<Vec<u8>>,
    /// Arrival of a message.
    at: fn(u64, Instant<Machine>) -> Instant<Machine>,
    delivery: Delivery,
    reply: fn(&mut TimeResponsesHeader, &mut ReceivedRequest) -> Span,
    status: fn(&mut Value),
    tokens: fn(&NodeName) -> Vec<String>,
}

impl Bench {
    fn new() -> Self {
        let node = NodeName::new("belt").unwrap();
        Self {
            judge: SenderJudge::new(&node, Channel::Axes, REQUESTER, START),
            node,
            frame: |_, _, _| {},
            bytes: |_, bytes| vec![bytes],
            at: |_, at| at,
            delivery: Delivery {
                priority: 1,
                is_dropped: true,
                is_express: false,
            },
            reply: |_, _| Span::from_micros(300),
            status: |_| {},
            tokens: |node| vec![node.alive_key(), node.run_key(EPOCH)],
        }
    }

    fn with(change: impl FnOnce(&mut Self)) -> Self {
        let mut bench = Self::new();
        change(&mut bench);
        bench
    }

    fn findings(mut self) -> Vec<RuleFinding> {
        for key in (self.tokens)(&self.node) {
            self.judge.token(&key, true);
        }
        for count in 0..400 {
            self.cycle(count);
        }
        self.judge.findings(START + CYCLE * 400)
    }

    fn cycle(&mut self, count: u64) {
        let due = START + CYCLE * count as i64;
        let at = (self.at)(count, due + Span::from_micros(200));
        for bytes in (self.bytes)(count, self.sealed(count)) {
            self.judge.frame(at, &bytes, Some(self.delivery));
        }
        if count % 10 == 5 {
            self.exchange(count, due + Span::from_millis(3));
        }
        if count % 25 == 7 {
            let mut status = json!({ "node": "belt", "role": "sender", "health": "ok",
                "epoch": format!("{EPOCH:016x}"), "uptime_s": 1.0, "cycle": count, "cycle_time_us": 10_000.0 });
            (self.status)(&mut status);
            let text = match &status {
                Value::String(text) => text.clone(),
                status => status.to_string(),
            };
            self.judge.status(at, text.as_bytes());
        }
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
        (self.frame)(count, &mut header, &mut axes);
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
        let stamp = (self.reply)(&mut header, &mut reply);
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
    let findings = Bench::new().findings();
    assert_eq!(findings.len(), 32);
    for (n, finding) in findings.iter().enumerate() {
        assert_eq!(finding.rule.number, format!("S{}", n + 1));
        let is_kept = matches!(finding.outcome, RuleOutcome::Kept { .. });
        assert!(is_kept, "{finding:?}");
    }
}

/// Expects exactly this rule to be broken.
#[track_caller]
fn finds(rule: &str, change: impl FnOnce(&mut Bench)) -> RuleOutcome {
    let findings = Bench::with(change).findings();
    assert_eq!(broken(&findings), [rule], "{findings:#?}");
    let found = findings.into_iter().find(RuleFinding::is_broken);
    found.expect("one is broken").outcome
}

/// Length of the stamp of 50 µs and of the check sum.
const STAMP_AND_SUM: usize = 4 + 4;

/// A frame of this body, with a right check sum.
fn sealed_again(body: &[u8]) -> Vec<u8> {
    let key = NodeName::new("belt").unwrap().channel_key(Channel::Axes);
    let mut sealed = Vec::new();
    KeySeal::new(&key).seal(body, Some(Span::from_micros(50)), &mut sealed);
    sealed
}

#[test]
fn a_node_whose_frames_are_shown_later_keeps_every_rule() {
    let bench = Bench::with(|bench| {
        bench.frame = |_, header, _| {
            header.present_after = PresentAfter::new(Span::from_millis(8));
        };
    });
    assert_eq!(broken(&bench.findings()), Vec::<&str>::new());
}

#[test]
fn frames_that_are_none_are_found() {
    finds("version", |bench| {
        bench.bytes = |_, mut bytes| {
            bytes[0] = 3;
            vec![bytes]
        }
    });
    finds("fields", |bench| {
        bench.bytes = |_, bytes| vec![bytes[..20].to_vec()]
    });
    finds("fields", |bench| {
        // Version 2 without its field.
        bench.bytes = |_, bytes| {
            let mut body = bytes[..bytes.len() - STAMP_AND_SUM].to_vec();
            body[0] = 2;
            vec![sealed_again(&body)]
        }
    });
    finds("present-after", |bench| {
        bench.frame = |_, header, _| {
            header.present_after = PresentAfter::new(Span::from_millis(8));
        };
        bench.bytes = |_, bytes| {
            // 8 000 000 as a number of four bytes becomes 4 000 000 001, of five.
            let at = bytes
                .windows(4)
                .position(|four| four == [0x80, 0xA4, 0xE8, 0x03]);
            let (before, after) = bytes[..bytes.len() - STAMP_AND_SUM].split_at(at.unwrap());
            let late = [0x81, 0xD0, 0xAC, 0xF3, 0x0E];
            vec![sealed_again(&[before, &late, &after[4..]].concat())]
        }
    });
    finds("check-sum", |bench| {
        bench.bytes = |_, mut bytes| {
            *bytes.last_mut().unwrap() ^= 4;
            vec![bytes]
        }
    });
    finds("sender-id", |bench| {
        bench.frame = |_, header, _| header.sender = 7
    });
}

#[test]
fn what_is_wrong_with_a_run_is_found() {
    let epoch = finds("epoch", |bench| {
        bench.frame = |count, header, _| {
            if (100..120).contains(&count) {
                header.epoch = EPOCH ^ 1;
            }
        };
    });
    assert!(
        matches!(epoch, RuleOutcome::Broken { received, .. } if received.contains("though the count goes on"))
    );
    finds("cycle-time", |bench| {
        bench.frame = |count, header, _| {
            if count % 20 == 9 {
                header.cycle_time = CycleTime::new(CYCLE * 2).unwrap();
            }
        }
    });
    finds("count", |bench| {
        bench.bytes = |count, bytes| vec![bytes; if count == 9 { 2 } else { 1 }]
    });
    finds("index", |bench| {
        bench.frame = |_, header, _| header.index = CycleIndex(3)
    });
}

#[test]
fn a_restart_has_another_epoch() {
    let restarted = |epoch: u64| {
        let node = NodeName::new("belt").unwrap();
        let mut runs = super::runs::RunChecks::default();
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
            let _ = runs.take(&header(EPOCH, count));
        }
        for count in 0..200 {
            let _ = runs.take(&header(epoch, count));
        }
        let findings = runs.findings();
        broken(&findings)
    };
    assert_eq!(restarted(EPOCH ^ 1), Vec::<&str>::new());
    assert_eq!(restarted(EPOCH), ["epoch"]);
}

#[test]
fn frames_that_come_at_other_times_than_their_counts_say_are_found() {
    // Both pace and stamps are two per cent slow.
    finds("pace", |bench| {
        bench.at = |count, at| at + Span::from_micros(200) * count as i64
    });
    finds("every-cycle", |bench| {
        bench.bytes = |count, bytes| {
            if count % 2 == 0 {
                vec![bytes]
            } else {
                Vec::new()
            }
        };
    });
    finds("no-bursts", |bench| {
        bench.frame = |count, header, _| {
            header.send_stamp =
                Some(CYCLE * (9 - (count % 10) as i64) + Span::from_nanos(count as i64));
        }
    });
    finds("no-bursts", |bench| {
        bench.frame = |_, header, _| header.send_stamp = None;
        bench.at = |count, _| START + CYCLE * (count / 10 * 10 + 10) as i64;
    });
}

#[test]
fn stamps_that_say_nothing_are_found() {
    finds("stamp-present", |bench| {
        bench.frame = |count, header, _| {
            if count % 3 == 0 {
                header.send_stamp = None;
            }
        }
    });
    finds("stamp-range", |bench| {
        bench.frame = |_, header, _| header.send_stamp = Some(Span::ZERO)
    });
    finds("stamp-range", |bench| {
        bench.frame = |_, header, _| header.send_stamp = Some(Span::from_secs(2))
    });
    finds("stamp-order", |bench| {
        bench.frame = |count, header, _| {
            header.send_stamp = Some(CYCLE * (if count % 2 == 0 { 8 } else { -8 }) / 10);
        }
    });
    let findings =
        Bench::with(|bench| bench.frame = |_, header, _| header.send_stamp = None).findings();
    assert_eq!(
        broken(&findings),
        Vec::<&str>::new(),
        "a client that does not know has none"
    );
}

#[test]
fn axes_that_cannot_be_are_found() {
    finds("axis-ids", |bench| {
        bench.frame = |_, _, axes| axes[1].axis_id = 1
    });
    finds("axis-order", |bench| {
        bench.frame = |count, _, axes| {
            if count % 2 == 1 {
                axes.swap(0, 1);
            }
        }
    });
    finds("axis-numbers", |bench| {
        bench.frame = |count, _, axes| {
            if count == 50 {
                axes[1].actual_velocity = f64::NAN;
            }
        }
    });
    finds("axis-state", |bench| {
        bench.frame = |_, _, axes| {
            axes[0].state_word |= StateWord::NEGATIVE_DIRECTION;
        }
    });
    finds("axis-state", |bench| {
        bench.frame = |_, _, axes| axes[0].state_word = StateWord::ERROR
    });
    finds("axis-velocity", |bench| {
        bench.frame = |_, _, axes| axes[0].set_velocity *= 60.0
    });
}

#[test]
fn responses_that_are_none_are_found() {
    const STAMP: Span = Span::from_micros(300);
    finds("answer-frame", |bench| {
        bench.reply = |header, _| {
            header.epoch ^= 1;
            STAMP
        }
    });
    finds("answer-echo", |bench| {
        bench.reply = |_, reply| {
            reply.request.requested += 1;
            STAMP
        }
    });
    finds("answer-stamps", |bench| {
        bench.reply = |_, reply| {
            reply.received += Span::from_millis(20);
            STAMP
        }
    });
    finds("answer-stamps", |bench| {
        bench.reply = |_, reply| {
            reply.received += Span::from_secs(100);
            Span::from_secs(100)
        }
    });
    let findings = Bench::with(|bench| {
        bench.reply = |header, reply| {
            header.epoch = EPOCH;
            reply.request.requester = 99;
            STAMP
        }
    })
    .findings();
    assert_eq!(
        broken(&findings),
        Vec::<&str>::new(),
        "what others asked is theirs"
    );
}

#[test]
fn what_is_wrong_with_status_tokens_and_delivery_is_found() {
    finds("status-json", |bench| {
        bench.status = |status| *status = json!("{")
    });
    finds("status-fields", |bench| {
        bench.status = |status| status["epoch"] = json!("12")
    });
    finds("status-true", |bench| {
        bench.status = |status| status["cycle"] = json!(5_000)
    });
    finds("alive", |bench| {
        bench.tokens = |node| vec![node.run_key(EPOCH)]
    });
    finds("run-token", |bench| {
        bench.tokens = |node| vec![node.alive_key(), node.run_key(5)]
    });
    finds("qos", |bench| bench.delivery.priority = 5);
    finds("qos", |bench| bench.delivery.is_dropped = false);
}
