//! Movement of the most likely location when the widths of the jitter are learned better.

use super::information::Information;

/// Measured change of the mean score of the location with the logarithm of each width, beside the one of the table,
/// which holds only once the widths are right.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pull {
    pub(super) curvature: f64,
    pub(super) normal: f64,
    pub(super) exponential: f64,
}

impl Pull {
    /// Makes the first guess, half of what the table says, which is wrong.
    pub(super) fn beside(information: &Information) -> Self {
        Self {
            curvature: 0.0,
            normal: -0.5 * information.normal_pull,
            exponential: -0.5 * information.exponential_pull,
        }
    }

    /// Takes the sums over `n` messages.
    pub(super) fn approach(&mut self, sums: &Self, table: &Information, n: f64, part: f64) {
        // Kept beside the table: what is measured converges to the difference, and the table follows the widths at once.
        self.curvature += part * (sums.curvature - n * (table.curvature + self.curvature));
        self.normal += part * (sums.normal - n * (table.normal_pull + self.normal));
        self.exponential +=
            part * (sums.exponential - n * (table.exponential_pull + self.exponential));
    }

    /// Movement of the location in normal widths when the widths grow by these parts.
    pub(super) fn shift(&self, table: &Information, normal: f64, exponential: f64) -> f64 {
        // The measured part may be more negative than the table is positive, after few messages.
        let curvature = (table.curvature + self.curvature).max(0.1 * table.curvature);
        let pull = (table.normal_pull + self.normal) * normal
            + (table.exponential_pull + self.exponential) * exponential;
        pull / curvature
    }
}
