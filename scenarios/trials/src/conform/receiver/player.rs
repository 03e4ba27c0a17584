//! Plays the script, and judges the receiver's reaction. Nothing here sends or receives: cycles, statuses and requests
//! are handed in with their times, messages to send are handed out.

use coaxle_axis::{NcToPlcAxis, StateWord};
use coaxle_clock::{CycleIndex, CycleTime, Instant, Span};
use coaxle_node::frame::sender_id;
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, FrameHeader};
use coaxle_os::Machine;
use serde_json::{Map, Value};

use super::frames::{FrameWriter, PlayedFrame};
use super::reading::{Playback, ReceiverReading};
use super::requests::TimeResponder;
use super::script::{Expect, Play, REQUESTS, SCRIPT, SEEN_BY, ScriptStep};
use crate::conform::rule::{RuleFinding, RuleOutcome};

/// A status covers the last frame of a step if it comes this much later …
const SETTLED: Span = Span::from_millis(300);
/// … and must come within this time.
const STATUS_TIMEOUT: Span = Span::from_secs(4);
/// An exchange needs a clock that is known.
const EXCHANGE_TIMEOUT: Span = Span::from_secs(15);
/// The silence before another run.
const SILENCE: Span = Span::from_millis(1_500);
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
        let reading = ReceiverReading::of(status, &self.part.played, self.part.axis);
        let Some(reading) = reading else { return };
        self.before.get_or_insert_with(|| reading.clone());
        self.latest = Some(reading);
        self.judge(at);
    }

    /// Runs the cycle that is due at `now`, or a later one. Returns the messages to send.
    pub(super) fn cycle(&mut self, now: Instant<Machine>) -> Vec<OutgoingMessage> {
        let Some(step) = SCRIPT.get(self.step) else {
            return Vec::new();
        };
        // Missed cycles are skipped, as a sender does.
        let due = (now - self.start).div_floor(self.part.cycle_time.span());
        self.count = self.count.max(u64::try_from(due).unwrap_or(0));
        let sent = match self.phase {
            // Without a first status there is nothing to compare with.
            PlayPhase::Playing(_) if self.before.is_none() => {
                vec![(Channel::Axes, self.writer.frame(&self.frame(now)))]
            }
            PlayPhase::Playing(left) => self.play(step, left, now),
            PlayPhase::Silent { until } => {
                if now >= until {
                    self.begin_run(now, step.cycles);
                }
                Vec::new()
            }
            PlayPhase::Judging { since } => {
                self.give_up(step, since, now);
                self.play_on(step, now)
            }
        };
        self.count += 1;
        sent
    }

    /// Findings, in the order of the rules.
    pub(super) fn findings(mut self) -> Vec<RuleFinding> {
        let key = self.part.played.seen_by_key(&self.part.receiver);
        let seen = match self.is_seen {
            true => RuleOutcome::kept(key),
            false => RuleOutcome::broken("no token", format!("a liveliness token {key}")),
        };
        self.findings.push(RuleFinding::new(&SEEN_BY, seen));
        let requests = RuleFinding::new(&REQUESTS, self.requests.outcome());
        self.findings.push(requests);
        self.findings.sort_by_key(|finding| {
            let number = finding.rule.number.get(1..);
            number.and_then(|number| number.parse::<u32>().ok())
        });
        self.findings
    }

    /// A cycle of a step.
    fn play(
        &mut self,
        step: &ScriptStep,
        left: u64,
        now: Instant<Machine>,
    ) -> Vec<OutgoingMessage> {
        if matches!(step.play, Play::NewRun) && left == step.cycles && self.played == 0 {
            let until = now + SILENCE;
            self.phase = PlayPhase::Silent { until };
            return Vec::new();
        }
        let mut frame = self.frame(now);
        self.newest = frame.header.count;
        self.phase = match left {
            1 => PlayPhase::Judging { since: now },
            left => PlayPhase::Playing(left - 1),
        };
        let mut sent = self.respond(&frame.header, matches!(step.play, Play::BadResponses));
        if let Play::Good(change) = step.play {
            change(&mut frame, left);
        }
        let mut axes = vec![self.writer.frame(&frame)];
        match step.play {
            Play::Good(_) | Play::NewRun => self.played += 1,
            Play::BadResponses => {}
            Play::Beside(mutations) => {
                let bad = mutations
                    .iter()
                    .map(|bad| self.writer.mutated(&frame, *bad));
                axes.splice(0..0, bad);
                self.played += mutations.len() as u64;
            }
            Play::Twice => {
                axes.extend_from_within(..);
                self.played += 1;
            }
            Play::Late => match self.held_back.take() {
                None => self.held_back = axes.pop(),
                Some(late) => {
                    axes.push(late);
                    self.played += 1;
                }
            },
        }
        sent.extend(axes.into_iter().map(|frame| (Channel::Axes, frame)));
        sent
    }

    /// A cycle between steps: the axis keeps the error that the receiver's status is to show.
    fn play_on(&mut self, step: &ScriptStep, now: Instant<Machine>) -> Vec<OutgoingMessage> {
        let mut frame = self.frame(now);
        if let Expect::Error(code) = step.expect {
            frame.fail(code);
        }
        let mut sent = self.respond(&frame.header, false);
        sent.push((Channel::Axes, self.writer.frame(&frame)));
        sent
    }

    fn respond(&mut self, header: &FrameHeader, bad: bool) -> Vec<OutgoingMessage> {
        let (frames, wrong) = self.requests.respond(header, self.start, bad);
        self.played += wrong;
        let frames = frames.into_iter();
        frames
            .map(|frame| (Channel::TimeResponses, frame))
            .collect()
    }

    fn frame(&self, now: Instant<Machine>) -> PlayedFrame {
        let passed = self.part.cycle_time.span() * self.count as i64;
        let position = VELOCITY * passed.as_secs_f64();
        PlayedFrame {
            header: FrameHeader {
                sender: sender_id(&self.part.played),
                epoch: self.epoch,
                index: CycleIndex::of_count(self.count),
                count: self.count,
                cycle_time: self.part.cycle_time,
                present_after: None,
                send_stamp: Some(now - (self.start + passed)),
            },
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
        if at - since >= SETTLED
            && let Some(outcome @ RuleOutcome::Kept { .. }) = self.outcome(step)
        {
            self.end_step(step, outcome);
        }
    }

    fn outcome(&self, step: &ScriptStep) -> Option<RuleOutcome> {
        let (before, latest) = (self.before.as_ref()?, self.latest.as_ref()?);
        let has_bad_responses = matches!(step.play, Play::BadResponses);
        let needs_requests = has_bad_responses || matches!(step.expect, Expect::Any(_));
        if needs_requests && !self.requests.any() {
            return Some(RuleOutcome::not_seen("no time request came"));
        }
        if has_bad_responses && self.played == 0 {
            return Some(RuleOutcome::not_seen("no time request came for a while"));
        }
        let playback = Playback {
            played: self.played,
            epoch: self.epoch,
            count: self.newest,
        };
        Some(latest.outcome(before, step.expect, &playback))
    }

    /// Ends the step after its timeout.
    fn give_up(&mut self, step: &ScriptStep, since: Instant<Machine>, now: Instant<Machine>) {
        let timeout = match step.expect {
            Expect::Any(_) if self.requests.any() => EXCHANGE_TIMEOUT,
            _ => STATUS_TIMEOUT,
        };
        if now - since >= timeout {
            let none = || RuleOutcome::not_seen("no status of the receiver came");
            let outcome = self.outcome(step).unwrap_or_else(none);
            self.end_step(step, outcome);
        }
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
