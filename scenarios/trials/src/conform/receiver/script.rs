//! The rules for nodes that follow axes, by name, and the steps that try them: frames to play, and the reaction
//! expected to them. docs/WIRE.md has the list of rules, too.

use super::frames::{BadFrames, FrameWriter};
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
    /// Good frames and nothing else.
    Good,
    /// Bad frames beside the good ones.
    Beside(BadFrames),
    /// Good ones whose index is unrelated to their count.
    AnyIndex,
    /// Good ones with stamps of all kinds, and without.
    AnyStamp,
    /// Good ones that are to be shown later.
    Presented,
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
    "R1"  "follows"          GOOD     => Play::Good, MANY, Expect::Used;
    "R3"  "wrong-version"    REFUSED  => bad(FrameWriter::versions), FEW, counted("rejected_wrong_version");
    "R4"  "truncated"        REFUSED  => bad(FrameWriter::truncated), FEW, counted("rejected_truncated");
    "R5"  "wrong-checksum"   REFUSED  => bad(FrameWriter::check_sums), FEW, counted("rejected_wrong_checksum");
    "R6"  "malformed"        REFUSED  => bad(FrameWriter::malformed), FEW, counted("rejected_malformed");
    "R7"  "trailing-bytes"   REFUSED  => bad(FrameWriter::trailing), FEW, counted("rejected_trailing_bytes");
    "R8"  "cycle-time-range" REFUSED  => bad(FrameWriter::cycle_times), FEW, counted("rejected_cycle_time_out_of_range");
    "R24" "present-after-range" REFUSED => bad(FrameWriter::delays), FEW, counted("rejected_present_after_out_of_range");
    "R9"  "foreign-sender"   REFUSED  => bad(FrameWriter::senders), FEW, counted("rejected_foreign_sender");
    "R10" "axis-missing"     REFUSED  => bad(FrameWriter::axes), FEW, counted("rejected_axis_missing");
    "R11" "implausible"      REFUSED  => bad(FrameWriter::numbers), FEW, counted("rejected_implausible");
    "R12" "any-index"        GOOD     => Play::AnyIndex, MANY, Expect::Used;
    "R14" "duplicates"       GOOD     => Play::Twice, FEW, counted("duplicates");
    "R15" "late"             GOOD     => Play::Late, 2 * FEW, counted("late");
    "R16" "error-code"       GOOD     => Play::ErrorCode, MANY, Expect::Error(ERROR);
    "R17" "other-run"        GOOD     => bad(FrameWriter::runs), FEW, counted("foreign_frames");
    "R18" "other-cycle-time" GOOD     => bad(FrameWriter::other_cycle_times), FEW, counted("foreign_frames");
    "R19" "other-count"      GOOD     => bad(FrameWriter::counts), FEW, counted("foreign_frames");
    "R13" "any-stamp"        GOOD     => Play::AnyStamp, MANY, Expect::Used;
    "R25" "presented"        GOOD     => Play::Presented, MANY, Expect::Used;
    "R20" "take-over"        GOOD     => Play::NewRun, MANY, Expect::Run;
    "R22" "responses"        EXCHANGE => Play::Good, MANY, Expect::Some("exchanges");
    "R23" "bad-responses"    EXCHANGE => Play::BadResponses, 2 * MANY, counted("responses_refused");
}

const fn bad(frames: BadFrames) -> Play {
    Play::Beside(frames)
}

const fn counted(counter: &'static str) -> Expect {
    Expect::Counted(counter)
}
