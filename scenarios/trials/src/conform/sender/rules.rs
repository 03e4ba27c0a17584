//! The rules for nodes that publish axes, by name. docs/WIRE.md has this list, too.

use crate::conform::rule::Rule;

const FIELDS: &str = "what-the-fields-mean";
const FRAME: &str = "the-frame";
const AXIS: &str = "an-axis";
const EXCHANGE: &str = "time-requests-and-responses";
const STATUS: &str = "every-node";
const KEYS: &str = "keys";

pub(crate) static VERSION: Rule = Rule::new("S1", "version", "versions");
pub(crate) static FRAME_FIELDS: Rule = Rule::new("S2", "fields", FRAME);
pub(crate) static CHECK_SUM: Rule = Rule::new("S3", "check-sum", "the-check-sum");
pub(crate) static SENDER_ID: Rule = Rule::new("S4", "sender-id", FIELDS);
pub(crate) static EPOCH: Rule = Rule::new("S5", "epoch", FIELDS);
pub(crate) static CYCLE_TIME: Rule = Rule::new("S6", "cycle-time", FIELDS);
pub(crate) static COUNT: Rule = Rule::new("S7", "count", FIELDS);
pub(crate) static INDEX: Rule = Rule::new("S8", "index", FIELDS);
pub(crate) static PACE: Rule = Rule::new("S9", "pace", FIELDS);
pub(crate) static EVERY_CYCLE: Rule = Rule::new("S10", "every-cycle", FIELDS);
pub(crate) static NO_BURSTS: Rule = Rule::new("S11", "no-bursts", FIELDS);
pub(crate) static STAMP_PRESENT: Rule = Rule::new("S12", "stamp-present", FIELDS);
pub(crate) static STAMP_RANGE: Rule = Rule::new("S13", "stamp-range", FIELDS);
pub(crate) static STAMP_ORDER: Rule = Rule::new("S14", "stamp-order", FIELDS);
pub(crate) static AXIS_IDS: Rule = Rule::new("S15", "axis-ids", AXIS);
pub(crate) static AXIS_ORDER: Rule = Rule::new("S16", "axis-order", AXIS);
pub(crate) static AXIS_NUMBERS: Rule = Rule::new("S17", "axis-numbers", AXIS);
pub(crate) static AXIS_STATE: Rule = Rule::new("S18", "axis-state", AXIS);
pub(crate) static AXIS_VELOCITY: Rule = Rule::new("S19", "axis-velocity", AXIS);
pub(crate) static ANSWER_FRAME: Rule = Rule::new("S20", "answer-frame", EXCHANGE);
pub(crate) static ANSWER_TIME: Rule = Rule::new("S21", "answer-time", EXCHANGE);
pub(crate) static ANSWER_ECHO: Rule = Rule::new("S22", "answer-echo", EXCHANGE);
pub(crate) static ANSWER_ONCE: Rule = Rule::new("S23", "answer-once", EXCHANGE);
pub(crate) static ANSWER_STAMPS: Rule = Rule::new("S24", "answer-stamps", EXCHANGE);
pub(crate) static STATUS_JSON: Rule = Rule::new("S25", "status-json", "status");
pub(crate) static STATUS_FIELDS: Rule = Rule::new("S26", "status-fields", STATUS);
pub(crate) static STATUS_TRUE: Rule = Rule::new("S27", "status-true", STATUS);
pub(crate) static STATUS_PACE: Rule = Rule::new("S28", "status-pace", "status");
pub(crate) static ALIVE: Rule = Rule::new("S29", "alive", KEYS);
pub(crate) static RUN_TOKEN: Rule = Rule::new("S30", "run-token", KEYS);
pub(crate) static QOS: Rule = Rule::new("S31", "qos", "quality-of-service");
pub(crate) static PRESENT_AFTER: Rule = Rule::new("S32", "present-after", FIELDS);
