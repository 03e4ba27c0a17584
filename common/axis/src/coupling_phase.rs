//! How far a coupling is, whatever couples.

/// How far a coupling is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum CouplingPhase {
    /// The slave waits for its master.
    Waiting,
    /// The slave is led to the master's motion.
    Synchronizing,
    /// The slave moves with its master.
    InSync,
    /// The slave is led away from the master's motion.
    Releasing,
    /// The slave is released and stands.
    Released,
}
