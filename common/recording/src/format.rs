//! The names by which a file says what is in it.

/// The metadata record about the recording as a whole.
pub(crate) const ABOUT: &str = "coaxle";
/// In it, the version of what is described here.
pub(crate) const FORMAT: &str = "format";
pub(crate) const VERSION: &str = "1";
/// In it, what the wall clock shows when the clock of the rows shows 0, ns.
pub(crate) const CLOCK_OFFSET: &str = "clock-offset-ns";
/// In it, the run of the node.
pub(crate) const EPOCH: &str = "epoch";
/// In it, which piece of a recording it is, from 0.
pub(crate) const PIECE: &str = "piece";

/// The last part of the topic of what a node was told, and how that is encoded: no schema says it.
pub(crate) const INPUTS: &str = "inputs";
pub(crate) const INPUTS_ENCODING: &str = "coaxle-scan";

// In the metadata of a channel:

/// Whose it is.
pub(crate) const TABLE: &str = "table";
/// What that is.
pub(crate) const ROLE: &str = "role";
/// The instance; empty for the node itself. Channels without it have no rows.
pub(crate) const INSTANCE: &str = "instance";
/// What it is: far node, axis …
pub(crate) const GROUP: &str = "group";
/// Its place in a row, from 0.
pub(crate) const PLACE: &str = "place";
/// How many instances a row has.
pub(crate) const INSTANCES: &str = "instances";
/// In front of the name of a signal: its unit.
pub(crate) const UNIT: &str = "unit.";
