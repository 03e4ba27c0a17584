//! `[lab]` of a gateway.

use std::path::Path;

use coaxle_node::config::{ClockConfig, Wrong};
use coaxle_node::document::{Document, Misread};
use coaxle_node::lab::{LabTable, WithLab, check_lab_clock};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::GatewayConfig;

/// Faults injected into a gateway, for experiments: a gateway with this table starts with `--lab` only.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct GatewayLab {
    /// Deviation injected into the gateway's own clock.
    pub clock: ClockConfig,
}

impl LabTable for GatewayLab {
    fn read(document: &Document) -> Result<Self, Misread> {
        Self::deserialize(document)
    }

    fn check_files(&self, folder: &Path) -> Result<(), Wrong> {
        check_lab_clock(&self.clock, folder)
    }
}

impl WithLab for GatewayConfig {
    type Lab = GatewayLab;

    fn read(document: &Document) -> Result<Self, Misread> {
        Self::deserialize(document)
    }

    fn set_lab(&mut self, GatewayLab { clock }: GatewayLab) -> Result<(), Wrong> {
        self.clock = clock;
        Ok(())
    }

    fn lab(&self) -> GatewayLab {
        let clock = self.clock.clone();
        GatewayLab { clock }
    }
}
