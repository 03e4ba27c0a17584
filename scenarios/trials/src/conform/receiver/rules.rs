//! The rules for nodes that follow axes, by name. docs/WIRE.md has this list, too.

use crate::conform::rule::Rule;

const REFUSED: &str = "what-a-receiver-refuses";
const GOOD: &str = "what-a-receiver-makes-of-good-frames";
const EXCHANGE: &str = "time-requests-and-responses";

pub(crate) static FOLLOWS: Rule = Rule::new("R1", "follows", GOOD);
pub(crate) static SEEN_BY: Rule = Rule::new("R2", "seen-by", "keys");
pub(crate) static WRONG_VERSION: Rule = Rule::new("R3", "wrong-version", REFUSED);
pub(crate) static TRUNCATED: Rule = Rule::new("R4", "truncated", REFUSED);
pub(crate) static WRONG_CHECKSUM: Rule = Rule::new("R5", "wrong-checksum", REFUSED);
pub(crate) static MALFORMED: Rule = Rule::new("R6", "malformed", REFUSED);
pub(crate) static TRAILING_BYTES: Rule = Rule::new("R7", "trailing-bytes", REFUSED);
pub(crate) static CYCLE_TIME_RANGE: Rule = Rule::new("R8", "cycle-time-range", REFUSED);
pub(crate) static FOREIGN_SENDER: Rule = Rule::new("R9", "foreign-sender", REFUSED);
pub(crate) static AXIS_MISSING: Rule = Rule::new("R10", "axis-missing", REFUSED);
pub(crate) static IMPLAUSIBLE: Rule = Rule::new("R11", "implausible", REFUSED);
pub(crate) static ANY_INDEX: Rule = Rule::new("R12", "any-index", GOOD);
pub(crate) static ANY_STAMP: Rule = Rule::new("R13", "any-stamp", GOOD);
pub(crate) static DUPLICATES: Rule = Rule::new("R14", "duplicates", GOOD);
pub(crate) static LATE: Rule = Rule::new("R15", "late", GOOD);
pub(crate) static ERROR_CODE: Rule = Rule::new("R16", "error-code", GOOD);
pub(crate) static OTHER_RUN: Rule = Rule::new("R17", "other-run", GOOD);
pub(crate) static OTHER_CYCLE_TIME: Rule = Rule::new("R18", "other-cycle-time", GOOD);
pub(crate) static OTHER_COUNT: Rule = Rule::new("R19", "other-count", GOOD);
pub(crate) static TAKE_OVER: Rule = Rule::new("R20", "take-over", GOOD);
pub(crate) static REQUESTS: Rule = Rule::new("R21", "requests", EXCHANGE);
pub(crate) static RESPONSES: Rule = Rule::new("R22", "responses", EXCHANGE);
pub(crate) static BAD_RESPONSES: Rule = Rule::new("R23", "bad-responses", EXCHANGE);
