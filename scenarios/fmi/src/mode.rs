//! Mode of an instance, which decides what is allowed.

use serde::{Deserialize, Serialize};

/// Mode of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum InstanceMode {
    /// Parameters and start values can be set.
    Instantiated,
    /// As before, and outputs have their values of the start.
    Initialization,
    /// Steps can be done.
    Step,
    /// Values can still be read.
    Terminated,
    /// A step has failed.
    Failed,
}

impl InstanceMode {
    /// The mode in a sentence.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization mode",
            Self::Initialization => "in initialization mode",
            Self::Step => "in step mode",
            Self::Terminated => "after its end",
            Self::Failed => "after a failed step",
        }
    }
}
