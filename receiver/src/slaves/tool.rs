//! A tool that cuts by position.

use crate::config::ToolConfig;

/// Counts the cuts of a tool that cuts at each multiple of a distance.
#[derive(Debug)]
pub(super) struct Tool {
    every: Option<f64>,
    cuts: u64,
    /// Number of multiples behind it in the previous cycle, if it moved with its master.
    behind: Option<f64>,
}

impl Tool {
    pub(super) fn new(config: &ToolConfig) -> Self {
        Self {
            every: config.cuts_every.map(|every| every.get()),
            cuts: 0,
            behind: None,
        }
    }

    /// Runs one cycle with the set position; none unless the slave moves with its master, because
    /// other passes are not cuts.
    pub(super) fn is_at(&mut self, position: Option<f64>) {
        let Some(every) = self.every else {
            return;
        };
        // Floor and no cast, which rounds towards 0 and would make one wide interval around it.
        let behind = position.map(|position| (position / every).floor());
        if let (Some(before), Some(now)) = (self.behind, behind) {
            // All multiples that it passed: a short distance or a long cycle has several.
            self.cuts += (now - before).abs() as u64;
        }
        // Without a value while out of sync, so that the way back to the master counts no cut when it ends.
        self.behind = behind;
    }

    pub(super) const fn cuts(&self) -> u64 {
        self.cuts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cuts(positions: impl IntoIterator<Item = Option<f64>>) -> u64 {
        let config = coaxle_node::config::parse("tool", "cuts-every = 360").expect("a tool");
        let mut tool = Tool::new(&config);
        positions.into_iter().for_each(|p| tool.is_at(p));
        tool.cuts()
    }

    #[test]
    fn every_turn_is_a_cut() {
        assert_eq!(cuts((0..=1_000).map(|n| Some(f64::from(n) * 3.6))), 10);
        assert_eq!(cuts([Some(359.0), Some(360.0), Some(361.0)]), 1);
        assert_eq!(cuts([Some(-1.0), Some(1.0), Some(-1.0)]), 2);
    }

    #[test]
    fn every_multiple_passed_in_a_cycle_is_a_cut() {
        assert_eq!(cuts([Some(0.0), Some(1_000.0)]), 2);
        assert_eq!(cuts([Some(1_000.0), Some(0.0)]), 2);
        // 0, −360 and −720.
        assert_eq!(cuts([Some(1.0), Some(-1_000.0)]), 3);
    }

    #[test]
    fn what_is_passed_on_the_way_to_the_master_is_no_cut() {
        assert_eq!(cuts([Some(359.0), None, Some(361.0), Some(362.0)]), 0);
    }
}
