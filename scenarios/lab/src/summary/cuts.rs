//! The cuts of a slave, in figures.

use coaxle_node::config::Unit;
use schemars::JsonSchema;
use serde::Serialize;

/// The cuts of a slave, each against the mark that is closest to it.
/// Errors are in the unit of the slave's master. They are null without marks, and where the master's true position is
/// unknown.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct CutsSummary {
    /// Cuts done.
    pub cuts: u64,
    /// Unit of the errors.
    pub cut_unit: Unit,
    /// Largest distance of a cut from its mark.
    pub cut_position_error_max: Option<f64>,
    /// Root mean square of that distance.
    pub cut_position_error_rms: Option<f64>,
    /// Largest difference between the distance of two following cuts and that of their marks.
    pub cut_length_error_max: Option<f64>,
    /// Root mean square of that difference.
    pub cut_length_error_rms: Option<f64>,
    /// Every cut, as `cuts.csv` has it too.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cut_list: Vec<Cut>,
}

/// A cut.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Cut {
    /// Number of the cut, from 1.
    pub number: u64,
    /// Time, s after the start of the run, of true time.
    pub t_s: f64,
    /// Position on the material: the master's true position when it is at the slave's position 0, u of
    /// the master.
    pub position: Option<f64>,
    /// The closest mark, from 0.
    pub mark: Option<u64>,
    /// Distance beyond its mark, u of the master.
    pub position_error: Option<f64>,
    /// Excess of the piece since the cut before over the distance of their marks, u of the
    /// master.
    pub length_error: Option<f64>,
}
