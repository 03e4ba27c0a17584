//! Reasons for the end of a run.

/// Reason for the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndReason {
    /// End of its configured time.
    TimeUp,
    /// Ctrl-C.
    Interrupted,
    /// SIGTERM.
    Terminated,
    /// SIGHUP: closed terminal.
    HungUp,
}
