//! `[lab]` of a sender.

use std::path::Path;

use coaxle_node::config::{ClockConfig, Wrong};
use coaxle_node::document::{Document, Misread};
use coaxle_node::lab::{LabTable, WithLab, check_lab_clock};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SenderConfig;

/// Faults injected into a sender, for experiments: a sender with this table starts with `--lab` only.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct SenderLab {
    /// Seeds whatever is random in its clock.
    pub seed: u64,
    /// Deviation injected into its clock.
    pub clock: ClockConfig,
}

impl LabTable for SenderLab {
    fn read(document: &Document) -> Result<Self, Misread> {
        Self::deserialize(document)
    }

    fn check_files(&self, folder: &Path) -> Result<(), Wrong> {
        check_lab_clock(&self.clock, folder)
    }
}

impl WithLab for SenderConfig {
    type Lab = SenderLab;

    fn read(document: &Document) -> Result<Self, Misread> {
        Self::deserialize(document)
    }

    fn set_lab(&mut self, SenderLab { seed, clock }: SenderLab) -> Result<(), Wrong> {
        // Every value of a lab table fits a sender, which has one clock.
        (self.seed, self.clock) = (seed, clock);
        Ok(())
    }

    fn lab(&self) -> SenderLab {
        let (seed, clock) = (self.seed, self.clock.clone());
        SenderLab { seed, clock }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::lab::NodeFile;

    const MACHINE: &str = "cycle-time-us = 1000\nname = 'a'\naxis = [{ id = 1, name = 'x', program = { \
        limits = { velocity = 1, acceleration = 1, jerk = 1 } } }]\n";

    fn read(lab: &str) -> Result<NodeFile<SenderConfig>, String> {
        NodeFile::parse("s.toml", &format!("{MACHINE}{lab}")).map_err(|error| error.to_string())
    }

    #[test]
    fn a_clock_is_injected_by_the_lab_table_alone() {
        let file = read("lab = { seed = 7, clock.drift-ppm = -300 }").unwrap();
        assert_eq!(
            (file.config.seed, file.config.clock.drift_ppm.get()),
            (7, -300.0)
        );
        let fields = file.lab.as_ref().map(ToString::to_string);
        let expected = "lab.clock.drift-ppm = -300, lab.seed = 7";
        assert_eq!(fields.as_deref(), Some(expected));
        assert_eq!(read("").unwrap().lab, None);
        for (old, expected) in [
            (
                "clock.drift-ppm = 500",
                "s.toml:4:1: clock: what is injected or simulated lives in [lab]: write lab.clock = { drift-ppm = 500 }, and start the node with --lab",
            ),
            (
                "seed = 7",
                "s.toml:4:8: seed: what is injected or simulated lives in [lab]: write lab.seed = 7, and start the node with --lab",
            ),
        ] {
            assert_eq!(read(old).unwrap_err(), expected);
        }
    }

    #[test]
    fn a_sender_of_a_scenario_is_written_as_a_file_of_its_own() {
        let text = format!("{MACHINE}seed = 7\nclock.drift-ppm = 500");
        let config: SenderConfig = coaxle_node::config::parse("scenario", &text).unwrap();
        let written = NodeFile::text_of(&config).unwrap();
        let read: NodeFile<SenderConfig> = NodeFile::parse("s", &written).unwrap();
        assert_eq!(read.config, config);
    }
}
