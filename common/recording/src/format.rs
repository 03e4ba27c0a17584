//! The names of the metadata in a file.

/// The metadata record about the recording as a whole.
pub(crate) const ABOUT: &str = "coaxle";
/// In it, the version of this format.
pub(crate) const FORMAT: &str = "format";
pub(crate) const VERSION: &str = "1";
/// In it, the wall clock at time 0 of the clock of the rows, ns.
pub(crate) const CLOCK_OFFSET: &str = "clock-offset-ns";
/// In it, the run of the node.
pub(crate) const EPOCH: &str = "epoch";
/// In it, the number of a piece of a recording, from 0.
pub(crate) const PIECE: &str = "piece";

/// The last part of the topic of a node's inputs, and the schema of their messages.
pub(crate) const INPUTS: &str = "inputs";
pub(crate) const INPUTS_SCHEMA: &str = "coaxle.Inputs";
/// Number of the bytes of a scan in them.
pub(crate) const SCAN_FIELD: u32 = 1;
/// Encoding of inputs without a schema, which earlier versions wrote: the bytes of the scan alone.
pub(crate) const BARE_INPUTS: &str = "coaxle-scan";

/// The last part of the topic of a node's audit, and the schema of its records.
pub(crate) const AUDIT: &str = "audit";
pub(crate) const AUDIT_SCHEMA: &str = "coaxle.Audit";

// In the metadata of a channel:

/// Name of its table.
pub(crate) const TABLE: &str = "table";
/// Role of that table.
pub(crate) const ROLE: &str = "role";
/// The instance; empty for the node itself. Channels without it have no rows.
pub(crate) const INSTANCE: &str = "instance";
/// Group of the instance: far node, axis …
pub(crate) const GROUP: &str = "group";
/// Place of the instance in a row, from 0.
pub(crate) const PLACE: &str = "place";
/// Number of instances in a row.
pub(crate) const INSTANCES: &str = "instances";
/// In front of the name of a signal: its unit.
pub(crate) const UNIT: &str = "unit.";
