//! What a system says of itself.

/// What the system says of itself; empty what it does not say.
#[derive(Clone, Debug, Default)]
pub struct Facts {
    /// Its name and version.
    pub kernel: String,
    /// Whether it was made for real time.
    pub is_real_time_kernel: bool,
    /// Whether another system runs it.
    pub is_virtual: bool,
    /// Where its clock comes from.
    pub clock_source: String,
    /// How many processors this process may run on.
    pub processors: usize,
    /// Those that nothing runs on but what is told to.
    pub isolated: String,
    /// How the frequency of a processor is chosen.
    pub governor: String,
    /// The highest real-time priority that is permitted; none: any.
    pub priority: Option<u64>,
    /// Memory that may be locked, bytes; none: all.
    pub memory: Option<u64>,
}
