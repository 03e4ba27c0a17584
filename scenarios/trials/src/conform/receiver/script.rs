//! The rules for nodes that follow axes, by name, and the steps that try them: frames to play, and the reaction
//! expected to them. docs/WIRE.md has the list of rules, too.

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{CycleIndex, Span};
use coaxle_node::PresentAfter;
use coaxle_node::frame::PRESENTED_VERSION;

use self::Expect::{Any, Counted, Error, Run, Used};
use self::Play::{BadResponses, Beside, Good, Late, NewRun, Twice};
use super::frames::Mutation::{Bare, Body, Bytes, Fields, OtherKey};
use super::frames::{AXES, CYCLE_TIME, Mutation, PlayedFrame, present_after, remove_axes, replace};
use crate::conform::rule::Rule;

const REFUSED: &str = "what-a-receiver-refuses";
const GOOD: &str = "what-a-receiver-makes-of-good-frames";
const EXCHANGE: &str = "time-requests-and-responses";

/// Rules that the whole play tries, rather than a step.
pub(super) static SEEN_BY: Rule = Rule::new("R2", "seen-by", "keys");
pub(super) static REQUESTS: Rule = Rule::new("R21", "requests", EXCHANGE);

/// A step.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScriptStep {
    pub(super) rule: &'static Rule,
    pub(super) play: Play,
    /// Number of cycles.
    pub(super) cycles: u64,
    pub(super) expect: Expect,
}

/// Frames and responses of a step. Good frames continue throughout, except where noted.
#[derive(Clone, Copy, Debug)]
pub(super) enum Play {
    /// Good frames, changed so that they stay good, by the number of cycles left.
    Good(fn(&mut PlayedFrame, u64)),
    /// Bad frames beside the good ones.
    Beside(&'static [Mutation]),
    /// Every frame twice.
    Twice,
    /// Every second frame behind the one after it.
    Late,
    /// Silence, and then another run.
    NewRun,
    /// Wrong responses, beside good ones.
    BadResponses,
}

/// Expected reaction, by the receiver's status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Expect {
    /// Every frame was used.
    Used,
    /// The increase of this counter of the far node equals the number of frames played, without other rejections.
    Counted(&'static str),
    /// The axis shows this error. It keeps it until the step is judged.
    Error(u32),
    /// The new run is followed.
    Run,
    /// Any increase of this counter.
    Any(&'static str),
}

const FEW: u64 = 3;
const MANY: u64 = 25;

/// The error that an axis has for once.
const ERROR: u32 = 0x4650;
/// A sender's id in more bytes than any number may have.
const TOO_LONG: [u8; 8] = [1, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 1];

/// A row is a rule with its section, the frames to play in a number of cycles, and the reaction to them.
macro_rules! script {
    ($($number:literal $name:literal $section:ident => $play:expr, $cycles:expr, $expect:expr;)*) => {
        /// The whole script, in its order: steps that disturb a receiver's clock come before the run that restarts.
        pub(super) static SCRIPT: &[ScriptStep] = &[$(ScriptStep {
            rule: &Rule::new($number, $name, $section),
            play: $play,
            cycles: $cycles,
            expect: $expect,
        }),*];
    };
}

script! {
    "R1"  "follows"             GOOD     => Good(|_, _| {}), MANY, Used;
    "R3"  "wrong-version"       REFUSED  => Beside(&[
        Body(|body| body[0] = 0), Body(|body| body[0] = PRESENTED_VERSION + 1), Body(|body| body[0] = 255),
    ]), FEW, Counted("rejected_wrong_version");
    "R4"  "truncated"           REFUSED  => Beside(&[
        Bytes(Vec::clear), Bytes(|bytes| bytes.truncate(4)), Bytes(|bytes| bytes.truncate(bytes.len() / 2)),
        Bare(|body| body.truncate(body.len() - 9)),
    ]), FEW, Counted("rejected_truncated");
    "R5"  "wrong-checksum"      REFUSED  => Beside(&[Bytes(|bytes| flip(bytes)), OtherKey]), FEW, Counted("rejected_wrong_checksum");
    "R6"  "malformed"           REFUSED  => Beside(&[
        Bare(|body| drop(body.splice(0..0, TOO_LONG))), Bare(|body| body.push(2)), Bare(|body| replace(body, AXES, 129)),
    ]), FEW, Counted("rejected_malformed");
    // An absent stamp; sealing puts another one behind it.
    "R7"  "trailing-bytes"      REFUSED  => Beside(&[Bare(|body| body.push(0))]), FEW, Counted("rejected_trailing_bytes");
    "R8"  "cycle-time-range"    REFUSED  => Beside(&[
        Body(|body| replace(body, CYCLE_TIME, 0)), Body(|body| replace(body, CYCLE_TIME, 99_999)),
        Body(|body| replace(body, CYCLE_TIME, 100_000_001)),
    ]), FEW, Counted("rejected_cycle_time_out_of_range");
    "R24" "present-after-range" REFUSED  => Beside(&[
        Body(|body| present_after(body, 4_000_000_001)), Body(|body| present_after(body, u32::MAX.into())),
    ]), FEW, Counted("rejected_present_after_out_of_range");
    "R9"  "foreign-sender"      REFUSED  => Beside(&[Fields(|frame| frame.header.sender ^= 1)]), FEW, Counted("rejected_foreign_sender");
    "R10" "axis-missing"        REFUSED  => Beside(&[
        Fields(|frame| frame.axis.axis_id = frame.axis.axis_id.wrapping_add(1_000)), Body(remove_axes),
    ]), FEW, Counted("rejected_axis_missing");
    "R11" "implausible"         REFUSED  => Beside(&[
        Fields(|frame| frame.axis.set_position = f64::NAN), Fields(|frame| frame.axis.set_velocity = f64::INFINITY),
        Fields(|frame| frame.axis.actual_position = -2.0 * NcToPlcAxis::LARGEST),
    ]), FEW, Counted("rejected_implausible");
    "R12" "any-index"           GOOD     => Good(any_index), MANY, Used;
    "R14" "duplicates"          GOOD     => Twice, FEW, Counted("duplicates");
    "R15" "late"                GOOD     => Late, 2 * FEW, Counted("late");
    "R16" "error-code"          GOOD     => Good(|frame, _| frame.fail(ERROR)), MANY, Error(ERROR);
    "R17" "other-run"           GOOD     => Beside(&[Fields(|frame| frame.header.epoch ^= 0x5555)]), FEW, Counted("foreign_frames");
    "R18" "other-cycle-time"    GOOD     => Beside(&[Fields(PlayedFrame::change_cycle_time)]), FEW, Counted("foreign_frames");
    "R19" "other-count"         GOOD     => Beside(&[Fields(PlayedFrame::leap)]), FEW, Counted("foreign_frames");
    "R13" "any-stamp"           GOOD     => Good(any_stamp), MANY, Used;
    "R25" "presented"           GOOD     => Good(|frame, _| {
        frame.header.present_after = PresentAfter::new(Span::from_millis(30));
    }), MANY, Used;
    "R20" "take-over"           GOOD     => NewRun, MANY, Run;
    "R22" "responses"           EXCHANGE => Good(|_, _| {}), MANY, Any("exchanges");
    "R23" "bad-responses"       EXCHANGE => BadResponses, 2 * MANY, Counted("responses_refused");
}

/// Flips a bit in the middle.
fn flip(bytes: &mut [u8]) {
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
}

/// An index unrelated to the count.
fn any_index(frame: &mut PlayedFrame, n: u64) {
    let index = frame.header.index.0.wrapping_mul(7_919);
    frame.header.index = CycleIndex(index.wrapping_add(n as u16));
}

/// Absent, extreme, zero and right stamps in rotation.
fn any_stamp(frame: &mut PlayedFrame, n: u64) {
    let stamp = &mut frame.header.send_stamp;
    match n % 6 {
        0 => *stamp = None,
        1 => *stamp = Some(Span::MAX),
        2 => *stamp = Some(Span::from_nanos(i64::MIN)),
        3 => *stamp = Some(Span::ZERO),
        _ => {}
    }
}
