//! Questions and answers on the wire: `docs/WIRE.md` describes every byte.
//!
//! Both are written like the frames of axes: a body in the cycle, and the send stamp and the check
//! sum by whoever publishes it, at the last moment ([`KeySeal::seal`]). So the send stamp of a
//! question is its `t1`, and that of a frame of answers their `t3`.

use coaxle_clock::delay::Answer;
use coaxle_clock::{CycleTime, Instant, Local, Span};
use serde::{Deserialize, Serialize};

use crate::frame::{FORMAT_VERSION, KeySeal, cycle_time, read, read_send_stamp, write};
use crate::rejection::Rejection;

/// Most answers in one frame.
pub const MAX_ANSWERS: usize = 16;

/// A buffer of this many bytes holds the body of every question.
pub const QUESTION_CAPACITY: usize = 1 + 5 + 10 + 5 + 10;

/// A buffer of this many bytes holds the body of every frame of answers.
pub const ANSWERS_CAPACITY: usize = 1 + 5 + 10 + 10 + 5 + 1 + MAX_ANSWERS * (5 + 10 + 5 + 10 + 10);

/// What does an asker's counterpart clock show? The counterpart keeps all of it as it is, for the
/// answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Question {
    /// Who asks: the CRC-32 of its node name.
    pub asker: u32,
    /// The asker's run.
    pub run: u64,
    /// Which question of that run.
    pub number: u32,
    /// When the question left, in nanoseconds of the asker's own clock: nobody else's business.
    pub asked: i64,
}

/// A question with what is said to it, but for when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reply {
    /// The question.
    pub question: Question,
    /// When it arrived, in the clock of who answers since the ideal start of its cycle 0.
    pub heard: Span,
}

/// Who answers, and in which cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AnswerHeader {
    /// The CRC-32 of its node name.
    pub sender: u32,
    /// Its run.
    pub epoch: u64,
    /// Its cycle count.
    pub count: u64,
    /// Its nominal cycle time.
    pub cycle_time: CycleTime,
}

/// Writes a question up to its send stamp into `out` and says how long that is. It leaves in the
/// cycle that ideally began at `ideal_start`.
pub fn encode_question(
    asker: u32,
    run: u64,
    number: u32,
    ideal_start: Instant<Local>,
    out: &mut [u8; QUESTION_CAPACITY],
) -> usize {
    let body = QuestionBody {
        version: FORMAT_VERSION,
        asker,
        run,
        number,
        ideal_start: ideal_start.as_nanos(),
    };
    write(&body, out).expect("the buffer holds the longest question")
}

/// Writes a frame of answers up to its send stamp into `out` and says how long that is. Of more than
/// [`MAX_ANSWERS`] the first are taken.
pub fn encode_answers(
    header: &AnswerHeader,
    replies: &[Reply],
    out: &mut [u8; ANSWERS_CAPACITY],
) -> usize {
    const ROOM: &str = "the buffer holds the longest answers";
    let replies = &replies[..replies.len().min(MAX_ANSWERS)];
    let prefix = AnswersPrefix {
        version: FORMAT_VERSION,
        sender: header.sender,
        epoch: header.epoch,
        count: header.count,
        // A cycle takes at most 100 ms.
        cycle_time_ns: header.cycle_time.span().as_nanos() as u32,
        answers: replies.len() as u32,
    };
    let mut used = write(&prefix, out).expect(ROOM);
    for reply in replies {
        let body = ReplyBody {
            asker: reply.question.asker,
            run: reply.question.run,
            number: reply.question.number,
            asked: reply.question.asked,
            heard: reply.heard,
        };
        used += write(&body, &mut out[used..]).expect(ROOM);
    }
    used
}

impl KeySeal {
    /// Checks and reads a question. Does not allocate.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies.
    pub fn open_question(&self, payload: &[u8]) -> Result<Question, Rejection> {
        let content = self.verify(payload, |content| read_question(content).map(drop))?;
        read_question(content)
    }

    /// Checks a frame of answers that `sender` gave, and hands out those for `asker`. Does not
    /// allocate.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies. Nothing is handed out then.
    pub fn open_answers(
        &self,
        payload: &[u8],
        sender: u32,
        asker: u32,
        mut each: impl FnMut(&Answer),
    ) -> Result<(), Rejection> {
        let content = self.verify(payload, |content| Answers::read(content).map(drop))?;
        let answers = Answers::read(content)?;
        if answers.sender != sender {
            return Err(Rejection::ForeignSender);
        }
        let mut rest = answers.replies;
        for _ in 0..answers.count {
            let reply;
            (reply, rest) = read::<ReplyBody>(rest)?;
            if reply.asker == asker {
                each(&Answer {
                    run: reply.run,
                    number: reply.number,
                    asked: Instant::from_nanos(reply.asked),
                    epoch: answers.epoch,
                    heard: reply.heard,
                    answered: answers.answered,
                });
            }
        }
        Ok(())
    }
}

#[derive(Serialize, Deserialize)]
struct QuestionBody {
    version: u8,
    asker: u32,
    run: u64,
    number: u32,
    ideal_start: i64,
}

#[derive(Serialize, Deserialize)]
struct AnswersPrefix {
    version: u8,
    sender: u32,
    epoch: u64,
    count: u64,
    cycle_time_ns: u32,
    answers: u32,
}

#[derive(Serialize, Deserialize)]
struct ReplyBody {
    asker: u32,
    run: u64,
    number: u32,
    asked: i64,
    heard: Span,
}

fn read_question(content: &[u8]) -> Result<Question, Rejection> {
    let (body, rest) = read::<QuestionBody>(content)?;
    let left = read_send_stamp(rest)?.ok_or(Rejection::Malformed)?;
    Ok(Question {
        asker: body.asker,
        run: body.run,
        number: body.number,
        asked: body.ideal_start.saturating_add(left.as_nanos()),
    })
}

/// A frame of answers that was read to its end.
struct Answers<'a> {
    sender: u32,
    epoch: u64,
    answered: Span,
    count: u32,
    /// Begins with the replies.
    replies: &'a [u8],
}

impl<'a> Answers<'a> {
    fn read(content: &'a [u8]) -> Result<Self, Rejection> {
        let (prefix, replies) = read::<AnswersPrefix>(content)?;
        if prefix.answers > MAX_ANSWERS as u32 {
            return Err(Rejection::Malformed);
        }
        let mut rest = replies;
        for _ in 0..prefix.answers {
            (_, rest) = read::<ReplyBody>(rest)?;
        }
        let left = read_send_stamp(rest)?.ok_or(Rejection::Malformed)?;
        let cycle_time = cycle_time(prefix.cycle_time_ns)?;
        Ok(Self {
            sender: prefix.sender,
            epoch: prefix.epoch,
            answered: cycle_time.span() * prefix.count as i64 + left,
            count: prefix.answers,
            replies,
        })
    }
}
