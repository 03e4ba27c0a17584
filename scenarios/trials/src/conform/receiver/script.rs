//! The steps to play, and the reaction expected to each.

use super::frames::{BadFrames, FrameWriter};
use super::rules;
use crate::conform::rule::Rule;

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
    /// Good frames and nothing else.
    Good,
    /// Bad frames beside the good ones.
    Beside(BadFrames),
    /// Good ones whose index is unrelated to their count.
    AnyIndex,
    /// Good ones with stamps of all kinds, and without.
    AnyStamp,
    /// Every frame twice.
    Twice,
    /// Every second frame behind the one after it.
    Late,
    /// The axis has an error.
    ErrorCode,
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
    /// The axis shows this error.
    Error(u32),
    /// The new run is followed.
    Run,
    /// Any increase of this counter.
    Some(&'static str),
}

/// The error that an axis has for once.
pub(super) const ERROR: u32 = 0x4650;

const FEW: u64 = 3;
const MANY: u64 = 25;

/// The whole script, in its order: steps that disturb a receiver's clock come before the run that restarts.
pub(super) static SCRIPT: [ScriptStep; 21] = [
    step(&rules::FOLLOWS, Play::Good, MANY, Expect::Used),
    refused(
        &rules::WRONG_VERSION,
        FrameWriter::versions,
        "rejected_wrong_version",
    ),
    refused(
        &rules::TRUNCATED,
        FrameWriter::truncated,
        "rejected_truncated",
    ),
    refused(
        &rules::WRONG_CHECKSUM,
        FrameWriter::check_sums,
        "rejected_wrong_checksum",
    ),
    refused(
        &rules::MALFORMED,
        FrameWriter::malformed,
        "rejected_malformed",
    ),
    refused(
        &rules::TRAILING_BYTES,
        FrameWriter::trailing,
        "rejected_trailing_bytes",
    ),
    refused(
        &rules::CYCLE_TIME_RANGE,
        FrameWriter::cycle_times,
        "rejected_cycle_time_out_of_range",
    ),
    refused(
        &rules::FOREIGN_SENDER,
        FrameWriter::senders,
        "rejected_foreign_sender",
    ),
    refused(
        &rules::AXIS_MISSING,
        FrameWriter::axes,
        "rejected_axis_missing",
    ),
    refused(
        &rules::IMPLAUSIBLE,
        FrameWriter::numbers,
        "rejected_implausible",
    ),
    step(&rules::ANY_INDEX, Play::AnyIndex, MANY, Expect::Used),
    step(
        &rules::DUPLICATES,
        Play::Twice,
        FEW,
        Expect::Counted("duplicates"),
    ),
    step(&rules::LATE, Play::Late, 2 * FEW, Expect::Counted("late")),
    step(
        &rules::ERROR_CODE,
        Play::ErrorCode,
        MANY,
        Expect::Error(ERROR),
    ),
    refused(&rules::OTHER_RUN, FrameWriter::runs, "foreign_frames"),
    refused(
        &rules::OTHER_CYCLE_TIME,
        FrameWriter::other_cycle_times,
        "foreign_frames",
    ),
    refused(&rules::OTHER_COUNT, FrameWriter::counts, "foreign_frames"),
    step(&rules::ANY_STAMP, Play::AnyStamp, MANY, Expect::Used),
    step(&rules::TAKE_OVER, Play::NewRun, MANY, Expect::Run),
    step(
        &rules::RESPONSES,
        Play::Good,
        MANY,
        Expect::Some("exchanges"),
    ),
    step(
        &rules::BAD_RESPONSES,
        Play::BadResponses,
        2 * MANY,
        Expect::Counted("responses_refused"),
    ),
];

const fn step(rule: &'static Rule, play: Play, cycles: u64, expect: Expect) -> ScriptStep {
    ScriptStep {
        rule,
        play,
        cycles,
        expect,
    }
}

const fn refused(rule: &'static Rule, bad: BadFrames, counter: &'static str) -> ScriptStep {
    step(rule, Play::Beside(bad), FEW, Expect::Counted(counter))
}
