//! Properties of a system.

/// Properties of the system; empty if it does not report them.
#[derive(Clone, Debug, Default)]
pub struct SystemFacts {
    /// Name and version.
    pub kernel: String,
    /// True if it is a real-time kernel.
    pub is_real_time_kernel: bool,
    /// True if it runs in a virtual machine.
    pub is_virtual: bool,
    /// Clock source.
    pub clock_source: String,
    /// Number of processors on which this process may run.
    pub processors: usize,
    /// Processors isolated from the scheduler.
    pub isolated: String,
    /// Frequency governor of a processor.
    pub governor: String,
    /// The greatest real-time priority permitted; none: any.
    pub priority: Option<u64>,
    /// Memory that may be locked, bytes; none: all.
    pub memory: Option<u64>,
    /// Clocks of network cards: device and name of each.
    pub card_clocks: Vec<String>,
}
