//! Questions and answers: what goes in comes out, the answering part, and what is refused.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use coaxle_clock::cycle::Turn;
use coaxle_clock::delay::Answer;
use coaxle_clock::{CycleTime, Instant, Local, Span};
use coaxle_wire::exchange::{
    ANSWERS_CAPACITY, AnswerHeader, MAX_ANSWERS, QUESTION_CAPACITY, Question, Reply,
    encode_answers, encode_question,
};
use coaxle_wire::frame::{FORMAT_VERSION, KeySeal, sender_id};
use coaxle_wire::keys::NodeName;
use coaxle_wire::{Answering, Channel, Message, Reader, Rejection};
use proptest::prelude::*;

fn name(name: &str) -> NodeName {
    NodeName::new(name).unwrap()
}

fn seal_of(channel: Channel) -> KeySeal {
    KeySeal::new(&name("press").channel_key(channel))
}

fn questions() -> Reader {
    Reader::questions_to(&name("press"))
}

fn answers() -> Reader {
    Reader::answers_of(&name("press"), &name("saw"))
}

fn read(reader: &Reader, payload: &[u8]) -> Vec<Message<'static>> {
    let mut messages = Vec::new();
    let mut reader = reader.clone();
    reader.read(payload, |message| messages.push(message.split().0));
    messages
}

fn cycle_time() -> CycleTime {
    CycleTime::new(Span::from_millis(1)).unwrap()
}

fn question_frame(question: &Question, stamp: Option<Span>) -> Vec<u8> {
    let mut body = [0; QUESTION_CAPACITY];
    let left = stamp.unwrap_or(Span::ZERO).as_nanos();
    let ideal_start = Instant::from_nanos(question.asked.saturating_sub(left));
    let Question {
        asker, run, number, ..
    } = *question;
    let length = encode_question(asker, run, number, ideal_start, &mut body);
    let mut payload = Vec::new();
    seal_of(Channel::Questions).seal(&body[..length], stamp, &mut payload);
    payload
}

fn answers_frame(header: &AnswerHeader, replies: &[Reply], stamp: Option<Span>) -> Vec<u8> {
    let mut body = [0; ANSWERS_CAPACITY];
    let length = encode_answers(header, replies, &mut body);
    let mut payload = Vec::new();
    seal_of(Channel::Answers).seal(&body[..length], stamp, &mut payload);
    payload
}

fn header() -> AnswerHeader {
    AnswerHeader {
        sender: sender_id(&name("press")),
        epoch: 9,
        count: 50,
        cycle_time: cycle_time(),
    }
}

fn question(asker: &str, number: u32) -> Question {
    Question {
        asker: sender_id(&name(asker)),
        run: 77,
        number,
        asked: -5_000,
    }
}

fn at(micros: i64) -> Instant<Local> {
    Instant::EPOCH + Span::from_micros(micros)
}

fn with_checksum(channel: Channel, content: &[u8]) -> Vec<u8> {
    let key = name("press").channel_key(channel);
    let sum = crc32fast::hash(&[key.as_bytes(), content].concat());
    [content, &sum.to_le_bytes()].concat()
}

#[test]
fn the_capacities_hold_the_longest_frames() {
    let question = Question {
        asker: u32::MAX,
        run: u64::MAX,
        number: u32::MAX,
        asked: i64::MIN,
    };
    let heard = Span::from_nanos(i64::MIN);
    let header = AnswerHeader {
        sender: u32::MAX,
        epoch: u64::MAX,
        count: u64::MAX,
        cycle_time: CycleTime::new(CycleTime::MAX).unwrap(),
    };
    let mut body = [0; ANSWERS_CAPACITY];
    let replies = [Reply { question, heard }; MAX_ANSWERS];
    let length = encode_answers(&header, &replies, &mut body);
    // The cycle time's bound of 100 ms leaves a byte unused.
    assert_eq!(length, ANSWERS_CAPACITY - 1);
    let mut body = [0; QUESTION_CAPACITY];
    let ideal_start = Instant::from_nanos(i64::MIN);
    let length = encode_question(u32::MAX, u64::MAX, u32::MAX, ideal_start, &mut body);
    assert_eq!(length, QUESTION_CAPACITY);
}

#[test]
fn a_node_answers_in_its_next_cycle_what_had_come_by_then() {
    let start = at(10_000);
    let mut answering = Answering::new(header().sender, 9, start, cycle_time());
    answering.hear(at(59_700), &question("saw", 1));
    answering.hear(at(59_900), &question("drill", 2));
    answering.hear(at(60_500), &question("saw", 3));
    let turn = Turn {
        count: 50,
        ideal_start: at(60_000),
        elapsed: 1,
    };
    answering.answer(&turn, at(60_040));
    let outgoing = answering.transmit().expect("answers");
    assert_eq!(outgoing.channel, Channel::Answers);
    assert_eq!(outgoing.ideal_start, turn.ideal_start);
    let mut payload = Vec::new();
    let stamp = Some(Span::from_micros(55));
    seal_of(Channel::Answers).seal(outgoing.body, stamp, &mut payload);
    let expected = Answer {
        run: 77,
        number: 1,
        asked: Instant::from_nanos(-5_000),
        epoch: 9,
        heard: Span::from_micros(49_700),
        answered: Span::from_micros(50_055),
    };
    assert_eq!(read(&answers(), &payload), [Message::Answer(expected)]);
    assert!(answering.transmit().is_none(), "once");

    let turn = Turn {
        count: 51,
        ideal_start: at(61_000),
        elapsed: 1,
    };
    answering.answer(&turn, at(61_000));
    assert!(answering.transmit().is_some(), "the third question");
    answering.answer(&turn, at(62_000));
    assert!(answering.transmit().is_none(), "nothing more");
    assert_eq!(answering.counters().answered, 3);
}

#[test]
fn a_flood_of_questions_is_cut_off() {
    let mut answering = Answering::new(1, 9, at(0), cycle_time());
    for number in 0..100 {
        answering.hear(at(0), &question("saw", number));
    }
    let turn = Turn {
        count: 1,
        ideal_start: at(1_000),
        elapsed: 1,
    };
    answering.answer(&turn, at(1_000));
    let counters = answering.counters();
    let most = MAX_ANSWERS as u64;
    assert_eq!((counters.answered, counters.dropped), (most, 100 - most));
}

#[test]
fn without_a_stamp_neither_is_of_use() {
    let payload = question_frame(&question("saw", 1), None);
    let malformed = [Message::Rejected(Rejection::Malformed)];
    assert_eq!(read(&questions(), &payload), malformed);
    let payload = answers_frame(&header(), &[], None);
    assert_eq!(read(&answers(), &payload), malformed);
}

#[test]
fn what_does_not_belong_here_is_refused() {
    let stamp = Some(Span::ZERO);
    let good = answers_frame(&header(), &[], stamp);
    assert_eq!(read(&answers(), &good), []);
    let reason = |reader: &Reader, payload: &[u8]| match read(reader, payload)[..] {
        [Message::Rejected(reason)] => reason,
        ref other => panic!("{other:?}"),
    };
    let mut foreign = header();
    foreign.sender += 1;
    let foreign = answers_frame(&foreign, &[Reply::default()], stamp);
    assert_eq!(reason(&answers(), &foreign), Rejection::ForeignSender);
    assert_eq!(reason(&questions(), &good), Rejection::WrongChecksum);
    assert_eq!(reason(&questions(), &[]), Rejection::Truncated);
    assert_eq!(reason(&questions(), &[2]), Rejection::WrongVersion);
    for (reader, whole) in [
        (questions(), question_frame(&question("saw", 1), stamp)),
        (
            answers(),
            answers_frame(&header(), &[Reply::default()], stamp),
        ),
    ] {
        for length in 0..whole.len() {
            assert_eq!(reason(&reader, &whole[..length]), Rejection::Truncated);
        }
        for place in 1..whole.len() {
            let mut damaged = whole.clone();
            damaged[place] ^= 0x40;
            let reason = reason(&reader, &damaged);
            let damage = [Rejection::WrongChecksum, Rejection::Truncated];
            assert!(damage.contains(&reason), "{reason:?} at {place}");
        }
    }
    let content = &good[..good.len() - 4];
    let longer = with_checksum(Channel::Answers, &[content, &[0]].concat());
    assert_eq!(reason(&answers(), &longer), Rejection::TrailingBytes);
    // 17 answers claimed: the fields before are version, sender, epoch, count, cycle time.
    let place = content.len() - 3;
    let mut many = content.to_vec();
    assert_eq!(many[place], 0, "the number of answers");
    many[place] = 17;
    let many = with_checksum(Channel::Answers, &many);
    assert_eq!(reason(&answers(), &many), Rejection::Malformed);
}

proptest! {
    #[test]
    fn what_goes_in_comes_out(
        asked in prop::collection::vec(any::<(bool, u64, u32, i64, i64)>(), 0..=MAX_ANSWERS),
        epoch in any::<u64>(),
        count in 0..1_000_000_000_u64,
        stamp in -1_000_000_000..1_000_000_000_i64,
    ) {
        let stamp = Span::from_nanos(stamp);
        let replies: Vec<_> = asked
            .iter()
            .map(|&(mine, run, number, asked, heard)| Reply {
                question: Question {
                    asker: sender_id(&name(if mine { "saw" } else { "drill" })),
                    run,
                    number,
                    asked,
                },
                heard: Span::from_nanos(heard),
            })
            .collect();
        let header = AnswerHeader { epoch, count, ..header() };
        let payload = answers_frame(&header, &replies, Some(stamp));
        let expected: Vec<_> = replies
            .iter()
            .filter(|reply| reply.question.asker == sender_id(&name("saw")))
            .map(|reply| Message::Answer(Answer {
                run: reply.question.run,
                number: reply.question.number,
                asked: Instant::from_nanos(reply.question.asked),
                epoch,
                heard: reply.heard,
                answered: cycle_time().span() * count as i64 + stamp,
            }))
            .collect();
        prop_assert_eq!(read(&answers(), &payload), expected);
        for reply in &replies {
            let mut question = reply.question;
            question.asked = question.asked.clamp(i64::MIN / 2, i64::MAX / 2);
            let payload = question_frame(&question, Some(stamp));
            prop_assert_eq!(read(&questions(), &payload), [Message::Question(question)]);
        }
    }

    #[test]
    fn random_bytes_never_panic(content in prop::collection::vec(any::<u8>(), 0..300)) {
        for (reader, channel) in [
            (questions(), Channel::Questions),
            (answers(), Channel::Answers),
        ] {
            let refused =
                |payload: &[u8]| matches!(read(&reader, payload)[..], [Message::Rejected(_)]);
            prop_assert!(refused(&content));
            // Under a right check sum they may even mean something.
            let content = [&[FORMAT_VERSION][..], &content].concat();
            let _ = refused(&with_checksum(channel, &content));
        }
    }
}
