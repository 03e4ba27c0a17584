//! Plays the script, and judges the receiver's reaction. Nothing here sends or receives: cycles, statuses and requests
//! are handed in with their times, messages to send are handed out.

use coaxle_axis::{NcToPlcAxis, StateWord};
use coaxle_clock::{CycleIndex, CycleTime, Instant, Span};
use coaxle_node::Channel;
use coaxle_node::keys::NodeName;
use coaxle_os::Machine;
use serde_json::{Map, Value};

use super::frames::{FrameContent, FrameWriter};
use super::reading::ReceiverReading;
use super::requests::{ResponseCycle, TimeResponder};
use super::script::{ERROR, Expect, Play, SCRIPT, SEEN_BY, ScriptStep};
use crate::conform::rule::{RuleFinding, RuleOutcome};

/// A status covers the last frame of a step if it comes this much later …
const SETTLED: Span = Span::from_millis(300);
/// … and must come within this time.
const STATUS_TIMEOUT: Span = Span::from_secs(4);
/// An exchange needs a clock that is known.
const EXCHANGE_TIMEOUT: Span = Span::from_secs(15);
/// The silence before another run.
const SILENCE: Span = Span::from_millis(1_500);
/// Presentation delay of the frames that have one.
const PRESENT_AFTER: Span = Span::from_millis(30);
/// Velocity of the axis, u/s.
const VELOCITY: f64 = 10.0;

/// The nodes, axis and cycle time of a play.
#[derive(Clone, Debug)]
pub(super) struct PlayedRole {
    /// The node that is played, as which the receiver follows it.
    pub(super) played: NodeName,
    /// The axis that the receiver follows.
    pub(super) axis: u32,
    /// The node that is tried.
    pub(super) receiver: NodeName,
    /// The cycle time of the node that is played.
    pub(super) cycle_time: CycleTime,
    /// Epoch of its first run.
    pub(super) epoch: u64,
}

/// A message to send.
pub(super) type OutgoingMessage = (Channel, Vec<u8>);

/// The node that is played.
#[derive(Debug)]
pub(super) struct Player {
    part: PlayedRole,
    writer: FrameWriter,
    requests: TimeResponder,
    epoch: u64,
    /// The ideal start of the run's cycle 0.
    start: Instant<Machine>,
    /// The next count.
    count: u64,
    step: usize,
    phase: PlayPhase,
    /// Frames of the step that are to be counted.
    played: u64,
    /// The newest count of a step that was played.
    newest: u64,
    held_back: Option<Vec<u8>>,
    before: Option<ReceiverReading>,
    latest: Option<ReceiverReading>,
    receiver_epoch: Option<u64>,
    is_seen: bool,
    findings: Vec<RuleFinding>,
}

#[derive(Clone, Copy, Debug)]
enum PlayPhase {
    /// Playing, with this number of cycles left.
    Playing(u64),
    /// Sending nothing.
    Silent { until: Instant<Machine> },
    /// Sending good frames only since then, and waiting for a status.
    Judging { since: Instant<Machine> },
}

impl Player {
    /// A player that begins at `start`.
    pub(super) fn new(part: PlayedRole, start: Instant<Machine>) -> Self {
        Self {
            writer: FrameWriter::new(&part.played),
            requests: TimeResponder::new(&part.played, &part.receiver),
            epoch: part.epoch,
            start,
            count: 0,
            step: 0,
            phase: PlayPhase::Playing(SCRIPT[0].cycles),
            played: 0,
            newest: 0,
            held_back: None,
            before: None,
            latest: None,
            receiver_epoch: None,
            is_seen: false,
            findings: Vec::new(),
            part,
        }
    }

    /// Time of the next cycle.
    pub(super) fn due(&self) -> Instant<Machine> {
        self.start + self.part.cycle_time.span() * self.count as i64
    }

    /// Epoch of the present run of the node that is played.
    pub(super) const fn epoch(&self) -> u64 {
        self.epoch
    }

    /// True at the end of the script.
    pub(super) const fn is_done(&self) -> bool {
        self.step >= SCRIPT.len()
    }

    /// Takes a time request.
    pub(super) fn request(&mut self, at: Instant<Machine>, bytes: &[u8]) {
        self.requests.take(at, bytes, self.receiver_epoch);
    }

    /// Takes the receiver's token that it receives the played node, or its end.
    pub(super) fn seen_by(&mut self, is_seen: bool) {
        self.is_seen |= is_seen;
    }

    /// Takes a status of the receiver.
    pub(super) fn status(&mut self, at: Instant<Machine>, status: &Map<String, Value>) {
        let epoch = status.get("epoch").and_then(Value::as_str);
        self.receiver_epoch = epoch.and_then(|epoch| u64::from_str_radix(epoch, 16).ok());
        let Some(reading) = ReceiverReading::of(status, &self.part.played, self.part.axis) else {
            return;
        };
        self.before.get_or_insert_with(|| reading.clone());
        self.latest = Some(reading);
        self.judge(at);
    }

    /// Runs the cycle that is due at `now`, or a later one. Returns the messages to send.
    pub(super) fn cycle(&mut self, now: Instant<Machine>) -> Vec<OutgoingMessage> {
        let Some(step) = SCRIPT.get(self.step) else {
            return Vec::new();
        };
        self.skip_missed(now);
        let sent = match self.phase {
            // Without a first status there is nothing to compare with.
            PlayPhase::Playing(_) if self.before.is_none() => {
                vec![(Channel::Axes, self.writer.frame(&self.content(now)))]
            }
            PlayPhase::Playing(left) => self.play(step, left, now),
            PlayPhase::Silent { until } => {
                if now >= until {
                    self.begin_run(now, step.cycles);
                }
                return self.next(Vec::new());
            }
            PlayPhase::Judging { since } => {
                self.give_up(step, since, now);
                self.good(step, now)
            }
        };
        self.next(sent)
    }

    /// Findings, in the order of the rules.
    pub(super) fn findings(mut self) -> Vec<RuleFinding> {
        let key = self.part.played.seen_by_key(&self.part.receiver);
        let seen = match self.is_seen {
            true => RuleOutcome::kept(key),
            false => RuleOutcome::broken("no token", format!("a liveliness token {key}")),
        };
        self.findings.push(RuleFinding::new(&SEEN_BY, seen));
        self.findings.push(self.requests.finding());
        self.findings.sort_by_key(|finding| {
            let number = finding.rule.number.get(1..);
            number.and_then(|number| number.parse::<u32>().ok())
        });
        self.findings
    }

    fn next(&mut self, sent: Vec<OutgoingMessage>) -> Vec<OutgoingMessage> {
        self.count += 1;
        sent
    }

    /// Skips missed cycles, as a sender does.
    fn skip_missed(&mut self, now: Instant<Machine>) {
        let cycle = self.part.cycle_time.span();
        let due = (now - self.start).div_floor(cycle);
        self.count = self.count.max(u64::try_from(due).unwrap_or(0));
    }

    /// A cycle of a step.
    fn play(
        &mut self,
        step: &ScriptStep,
        left: u64,
        now: Instant<Machine>,
    ) -> Vec<OutgoingMessage> {
        if matches!(step.play, Play::NewRun) && left == step.cycles && self.played == 0 {
            self.phase = PlayPhase::Silent {
                until: now + SILENCE,
            };
            return Vec::new();
        }
        let mut content = self.content(now);
        self.newest = content.count;
        self.phase = match left {
            1 => PlayPhase::Judging { since: now },
            left => PlayPhase::Playing(left - 1),
        };
        let mut frames = self.answers(now, matches!(step.play, Play::BadResponses));
        let axes = match step.play {
            Play::Good | Play::NewRun | Play::BadResponses => self.used(&content),
            Play::Beside(bad) => {
                let mut frames = bad(&self.writer, &content);
                self.played += frames.len() as u64;
                frames.push(self.writer.frame(&content));
                frames
            }
            Play::AnyIndex => {
                content.index = content.index.wrapping_mul(7_919).wrapping_add(left as u16);
                self.used(&content)
            }
            Play::AnyStamp => {
                content.stamp = any_stamp(left, content.stamp);
                self.used(&content)
            }
            Play::Presented => {
                content.present_after_ns = PRESENT_AFTER.as_nanos() as u32;
                self.used(&content)
            }
            Play::ErrorCode => {
                content.axis.error_code = ERROR;
                content.axis.state_word |= StateWord::ERROR;
                self.used(&content)
            }
            Play::Twice => {
                self.played += 1;
                vec![self.writer.frame(&content); 2]
            }
            Play::Late => self.late(&content),
        };
        frames.extend(axes.into_iter().map(|frame| (Channel::Axes, frame)));
        frames
    }

    /// A good frame, which counts.
    fn used(&mut self, content: &FrameContent) -> Vec<Vec<u8>> {
        self.played += u64::from(!matches!(SCRIPT[self.step].play, Play::BadResponses));
        vec![self.writer.frame(content)]
    }

    /// Sends each second frame behind the one after it.
    fn late(&mut self, content: &FrameContent) -> Vec<Vec<u8>> {
        let frame = self.writer.frame(content);
        match self.held_back.take() {
            None => {
                self.held_back = Some(frame);
                Vec::new()
            }
            Some(late) => {
                self.played += 1;
                vec![frame, late]
            }
        }
    }

    /// A cycle between steps: the axis keeps the state that the receiver's status is to show.
    fn good(&mut self, step: &ScriptStep, now: Instant<Machine>) -> Vec<OutgoingMessage> {
        let mut content = self.content(now);
        if matches!(step.play, Play::ErrorCode) {
            content.axis.error_code = ERROR;
            content.axis.state_word |= StateWord::ERROR;
        }
        let mut sent = self.answers(now, false);
        sent.push((Channel::Axes, self.writer.frame(&content)));
        sent
    }

    fn answers(&mut self, now: Instant<Machine>, bad: bool) -> Vec<OutgoingMessage> {
        let cycle = ResponseCycle {
            epoch: self.epoch,
            count: self.count,
            cycle_time: self.part.cycle_time,
            start: self.start,
            now,
        };
        let (frames, wrong) = self.requests.respond(&cycle, bad);
        self.played += wrong;
        let frames = frames.into_iter();
        frames
            .map(|frame| (Channel::TimeResponses, frame))
            .collect()
    }

    fn content(&self, now: Instant<Machine>) -> FrameContent {
        let cycle = self.part.cycle_time.span();
        let passed = cycle * self.count as i64;
        let position = VELOCITY * passed.as_secs_f64();
        FrameContent {
            sender: FrameContent::sender_of(&self.part.played),
            epoch: self.epoch,
            index: CycleIndex::of_count(self.count).0,
            count: self.count,
            cycle_time_ns: cycle.as_nanos() as u32,
            present_after_ns: 0,
            stamp: Some(now - (self.start + passed)),
            axis: NcToPlcAxis {
                axis_id: self.part.axis,
                state_word: StateWord::OPERATIONAL
                    | StateWord::HOMED
                    | StateWord::of_velocity(VELOCITY),
                actual_position: position,
                set_position: position,
                actual_velocity: VELOCITY,
                set_velocity: VELOCITY,
                ..NcToPlcAxis::default()
            },
        }
    }

    fn begin_run(&mut self, now: Instant<Machine>, cycles: u64) {
        self.epoch = self.epoch.rotate_left(17) ^ now.as_nanos().unsigned_abs();
        self.start = now;
        self.count = 0;
        self.requests.forget();
        // Prevents another silence.
        self.played = 1;
        self.phase = PlayPhase::Playing(cycles);
    }

    /// Judges the step by the newest status.
    fn judge(&mut self, at: Instant<Machine>) {
        let (Some(step), PlayPhase::Judging { since }) = (SCRIPT.get(self.step), self.phase) else {
            return;
        };
        if at - since < SETTLED {
            return;
        }
        if let Some(outcome @ RuleOutcome::Kept { .. }) = self.outcome(step) {
            self.end_step(step, outcome);
        }
    }

    fn outcome(&self, step: &ScriptStep) -> Option<RuleOutcome> {
        let (before, latest) = (self.before.as_ref()?, self.latest.as_ref()?);
        let newest = (self.epoch, self.newest);
        let needs_requests =
            matches!(step.expect, Expect::Some(_)) || matches!(step.play, Play::BadResponses);
        if needs_requests && !self.requests.any() {
            return Some(RuleOutcome::not_seen("no time request came"));
        }
        if matches!(step.play, Play::BadResponses) && self.played == 0 {
            return Some(RuleOutcome::not_seen("no time request came for a while"));
        }
        Some(latest.outcome(before, step.expect, self.played, newest))
    }

    /// Ends the step after its timeout.
    fn give_up(&mut self, step: &ScriptStep, since: Instant<Machine>, now: Instant<Machine>) {
        let patience = match step.expect {
            Expect::Some(_) if self.requests.any() => EXCHANGE_TIMEOUT,
            _ => STATUS_TIMEOUT,
        };
        if now - since < patience {
            return;
        }
        let none = || RuleOutcome::not_seen("no status of the receiver came");
        let outcome = self.outcome(step).unwrap_or_else(none);
        self.end_step(step, outcome);
    }

    fn end_step(&mut self, step: &ScriptStep, outcome: RuleOutcome) {
        self.findings.push(RuleFinding::new(step.rule, outcome));
        self.before.clone_from(&self.latest);
        self.played = 0;
        self.step += 1;
        if let Some(next) = SCRIPT.get(self.step) {
            self.phase = PlayPhase::Playing(next.cycles);
        }
    }
}

/// Absent, extreme, zero and right stamps in rotation.
fn any_stamp(n: u64, right: Option<Span>) -> Option<Span> {
    match n % 6 {
        0 => None,
        1 => Some(Span::MAX),
        2 => Some(Span::from_nanos(i64::MIN)),
        3 => Some(Span::ZERO),
        _ => right,
    }
}
