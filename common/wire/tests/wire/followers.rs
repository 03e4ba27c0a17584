//! Reports of followers: round trip, refusals, and the document against the code.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use crate::document::{assert_consistent, example_dump};
use assert_no_alloc::assert_no_alloc;
use coaxle_clock::Span;
use coaxle_curve::profile::Limits;
use coaxle_wire::followers::{MAX_REPORTS, REPORTS_CAPACITY, encode_reports};
use coaxle_wire::frame::{KeySeal, sender_id};
use coaxle_wire::keys::NodeName;
use coaxle_wire::{
    FollowerReport, FollowerState, Message, PresentAfter, Reader, ReceivedReport, Rejection,
    ReportIntake, RunCycle,
};
use proptest::prelude::*;

const REPORT: &str = "## Worked report";

fn name(name: &str) -> NodeName {
    NodeName::new(name).unwrap()
}

fn seal() -> KeySeal {
    KeySeal::new("coaxle/saw/followers")
}

fn header() -> RunCycle {
    RunCycle {
        sender: sender_id(&name("saw")),
        epoch: 0x1122_3344_5566_7788,
        count: 12_000,
    }
}

fn report() -> FollowerReport {
    FollowerReport {
        node: sender_id(&name("press")),
        run: 0x0123_4567_89ab_cdef,
        axis_id: 300,
        state: FollowerState {
            slaves: 2,
            in_sync: 1,
            in_error: 0,
            distance: 0.25,
            limits: Limits::new(750.0, 4_000.0, 3_000.0, 75_000.0).unwrap(),
            wanted_delay: PresentAfter::new(Span::from_millis(24)),
        },
    }
}

fn body(header: &RunCycle, reports: &[FollowerReport]) -> Vec<u8> {
    let mut body = [0; REPORTS_CAPACITY];
    let length = encode_reports(header, reports, &mut body);
    body[..length].to_vec()
}

fn sealed(body: &[u8]) -> Vec<u8> {
    let mut payload = Vec::new();
    seal().seal(body, Some(Span::from_micros(71)), &mut payload);
    payload
}

/// The messages to `press`.
fn read(payload: &[u8]) -> Vec<Message<'static>> {
    let mut messages = Vec::new();
    let mut reader = Reader::from(ReportIntake::new(&name("saw"), &name("press")));
    reader.read(payload, |message| messages.push(message.split().0));
    messages
}

#[test]
fn the_table_covers_the_dump_and_the_rules_give_its_values() {
    assert_consistent(REPORT);
}

#[test]
fn the_crate_reads_and_writes_the_documented_bytes() {
    let mut reports = Vec::new();
    let read = seal().open_reports(&example_dump(REPORT), |report| reports.push(*report));
    assert_eq!((read, &reports[..]), (Ok(header()), &[report()][..]));
    assert_eq!(sealed(&body(&header(), &reports)), example_dump(REPORT));
}

#[test]
fn a_node_gets_what_concerns_it() {
    let other = FollowerReport {
        node: 1,
        ..report()
    };
    let FollowerReport {
        run,
        axis_id,
        state,
        ..
    } = report();
    let RunCycle { epoch, count, .. } = header();
    let expected = Message::FollowerReport(ReceivedReport {
        epoch,
        count,
        run,
        axis_id,
        state,
    });
    let payload = sealed(&body(&header(), &[other, report()]));
    assert_eq!(read(&payload), [expected]);
}

#[test]
fn a_message_that_is_no_report_is_refused_with_its_reason() {
    let good = sealed(&body(&header(), &[report()]));
    let changed = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut payload = good.clone();
        change(&mut payload);
        read(&payload)
    };
    let stated = |change: &dyn Fn(&mut FollowerState)| {
        let mut report = report();
        change(&mut report.state);
        read(&sealed(&body(&header(), &[report])))
    };
    let foreign = RunCycle {
        sender: 1,
        ..header()
    };
    let mut seventeen = body(&header(), &[report()]);
    // Behind version, sender, epoch and count.
    let number = 1 + 5 + 9 + 2;
    assert_eq!(seventeen[number], 1);
    seventeen[number] = MAX_REPORTS as u8 + 1;
    let mut long = body(&header(), &[report()]);
    long.push(0);
    let mut none = body(&header(), &[report()]);
    // The last limit, before the delay.
    let end = none.len() - 4;
    none[end - 8..end].fill(0);
    // 2^32 - 1 ns.
    let mut late = body(&header(), &[report()]);
    late.truncate(end);
    late.extend([0xff, 0xff, 0xff, 0xff, 0x0f]);
    for (messages, reason) in [
        (changed(&|it| it[0] = 2), Rejection::WrongVersion),
        (changed(&|it| it.truncate(40)), Rejection::Truncated),
        (read(&[]), Rejection::Truncated),
        (changed(&|it| it[30] ^= 1), Rejection::WrongChecksum),
        (read(&sealed(&seventeen)), Rejection::Malformed),
        (
            read(&sealed(&body(&foreign, &[report()]))),
            Rejection::ForeignSender,
        ),
        (stated(&|it| it.in_sync = 3), Rejection::Implausible),
        (
            stated(&|it| (it.in_sync, it.in_error) = (2, u16::MAX)),
            Rejection::Implausible,
        ),
        (stated(&|it| it.distance = -0.1), Rejection::Implausible),
        (stated(&|it| it.distance = f64::NAN), Rejection::Implausible),
        (read(&sealed(&none)), Rejection::Implausible),
        (read(&sealed(&late)), Rejection::Implausible),
    ] {
        assert_eq!(messages, [Message::Rejected(reason)]);
    }
    let refused = read(&sealed(&long));
    assert!(matches!(refused[..], [Message::Rejected(_)]), "{refused:?}");
}

proptest! {
    #[test]
    fn any_reports_come_back_and_nothing_is_allocated(
        reports in prop::collection::vec((any::<u32>(), any::<u64>(), any::<u32>(), any::<u16>(), 0_u16..10, 0_f64..1e9, 0_i64..5_000_000_000), 0..=MAX_REPORTS),
    ) {
        let reports: Vec<_> = reports
            .into_iter()
            .map(|(node, run, axis_id, slaves, errors, distance, delay)| FollowerReport {
                node,
                run,
                axis_id,
                state: FollowerState {
                    slaves,
                    in_sync: slaves - errors.min(slaves),
                    in_error: errors.min(slaves),
                    distance,
                    wanted_delay: PresentAfter::new(Span::from_nanos(delay)),
                    ..report().state
                },
            })
            .collect();
        let payload = sealed(&body(&header(), &reports));
        let mut back = Vec::with_capacity(MAX_REPORTS);
        let seal = seal();
        let read = assert_no_alloc(|| seal.open_reports(&payload, |report| back.push(*report)));
        prop_assert_eq!(read, Ok(header()));
        prop_assert_eq!(back, reports);
    }

    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        for payload in [sealed(&bytes), bytes] {
            let _ = read(&payload);
        }
    }
}
