//! `docs/WIRE.md` against the code: its worked question and answer.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

mod document;

use coaxle_clock::delay::Answer;
use coaxle_clock::{CycleTime, Instant, Span};
use coaxle_wire::exchange::{
    ANSWERS_CAPACITY, AnswerHeader, QUESTION_CAPACITY, Question, Reply, encode_answers,
    encode_question,
};
use coaxle_wire::frame::{KeySeal, sender_id};
use coaxle_wire::keys::NodeName;
use document::{assert_consistent, example_dump};

const QUESTION: &str = "## Worked question";
const ANSWER: &str = "## Worked answer";

fn id(name: &str) -> u32 {
    sender_id(&NodeName::new(name).unwrap())
}

fn question() -> Question {
    Question {
        asker: id("saw"),
        run: 0x0FED_CBA9_8765_4321,
        number: 300,
        asked: 12_345_061_500,
    }
}

#[test]
fn the_tables_cover_the_dumps_and_the_rules_give_their_values() {
    assert_consistent(QUESTION);
    assert_consistent(ANSWER);
}

#[test]
fn the_crate_reads_the_documented_values() {
    let seal = KeySeal::new("coaxle/press/questions");
    let read = seal.open_question(&example_dump(QUESTION));
    assert_eq!(read, Ok(question()));

    let seal = KeySeal::new("coaxle/press/answers");
    let mut answers = Vec::new();
    seal.open_answers(&example_dump(ANSWER), id("press"), id("saw"), |answer| {
        answers.push(*answer);
    })
    .unwrap();
    let answer = Answer {
        run: question().run,
        number: 300,
        asked: Instant::from_nanos(12_345_061_500),
        epoch: 0x0123_4567_89ab_cdef,
        heard: Span::from_nanos(140_001_337_250),
        answered: Span::from_nanos(140_002_071_000),
    };
    assert_eq!(answers, [answer]);
}

#[test]
fn the_crate_writes_the_documented_bytes() {
    let mut payload = Vec::new();
    let mut body = [0; QUESTION_CAPACITY];
    let ideal_start = Instant::from_nanos(12_345_000_000);
    let Question {
        asker, run, number, ..
    } = question();
    let length = encode_question(asker, run, number, ideal_start, &mut body);
    let stamp = Some(Span::from_nanos(61_500));
    KeySeal::new("coaxle/press/questions").seal(&body[..length], stamp, &mut payload);
    assert_eq!(payload, example_dump(QUESTION));

    let header = AnswerHeader {
        sender: id("press"),
        epoch: 0x0123_4567_89ab_cdef,
        count: 70_001,
        cycle_time: CycleTime::new(Span::from_millis(2)).unwrap(),
    };
    let reply = Reply {
        question: question(),
        heard: Span::from_nanos(140_001_337_250),
    };
    let mut body = [0; ANSWERS_CAPACITY];
    let length = encode_answers(&header, &[reply], &mut body);
    let stamp = Some(Span::from_nanos(71_000));
    KeySeal::new("coaxle/press/answers").seal(&body[..length], stamp, &mut payload);
    assert_eq!(payload, example_dump(ANSWER));
}
