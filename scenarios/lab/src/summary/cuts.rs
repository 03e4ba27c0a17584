//! The cuts of a slave, in figures.

use coaxle_node::config::Unit;
use schemars::JsonSchema;
use serde::Serialize;

/// The cuts of a slave, each against the mark that is closest to it.
///
/// Errors are in the unit of the slave's master. They are null without marks, and where nobody knows
/// where the master truly was.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct CutsSummary {
    /// Cuts done.
    pub cuts: u64,
    /// What the errors are in.
    pub cut_unit: Unit,
    /// Largest distance of a cut from its mark.
    pub cut_position_error_max: Option<f64>,
    /// The same, root mean square.
    pub cut_position_error_rms: Option<f64>,
    /// Largest difference between the distance of two following cuts and that of their marks.
    pub cut_length_error_max: Option<f64>,
    /// The same, root mean square.
    pub cut_length_error_rms: Option<f64>,
    /// Every cut, as `cuts.csv` has it too.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cut_list: Vec<Cut>,
}

/// A cut.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Cut {
    /// Its number, from 1.
    pub number: u64,
    /// When, s after the start of the run, of true time.
    pub t_s: f64,
    /// Where on the material: where the master truly is when that is at the slave's position 0, u of
    /// the master.
    pub position: Option<f64>,
    /// The closest mark, from 0.
    pub mark: Option<u64>,
    /// How far beyond its mark, u of the master.
    pub position_error: Option<f64>,
    /// By how much the piece from the cut before is longer than the distance of their marks,
    /// likewise.
    pub length_error: Option<f64>,
}
