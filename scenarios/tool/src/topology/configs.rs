//! Nodes from their config files.

use std::path::{Path, PathBuf};

use coaxle_clock::Span;
use coaxle_node::config::{ConfigError, parse_table};
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};
use coaxle_topology::{AxisOrigin, PlantAnalysis, PlantFinding, PlantNode, WayOrigin, WaySource};

use crate::node_config::{NodeConfig, NodeKind};

/// Reads the nodes. A way without a known delay has the one that is `assumed`.
pub(crate) fn nodes(files: &[PathBuf], assumed: Option<Span>) -> anyhow::Result<Vec<PlantNode>> {
    let mut nodes = Vec::with_capacity(files.len());
    for file in files {
        let mut node = node(file)?;
        for axis in &mut node.axes {
            if let (Some(delay), AxisOrigin::Far(far)) = (assumed, &mut axis.origin)
                && far.way == WaySource::Unknown
            {
                far.way = WaySource::Constant {
                    delay,
                    origin: WayOrigin::Assumed,
                };
            }
        }
        nodes.push(node);
    }
    Ok(nodes)
}

fn node(file: &Path) -> Result<PlantNode, ConfigError> {
    let name = file.display().to_string();
    let folder = file.parent().unwrap_or(Path::new(""));
    let checked = |checked: Result<(), coaxle_node::config::Wrong>| {
        checked.map_err(|wrong| wrong.in_file(&name))
    };
    Ok(match NodeConfig::load(file)?.kind {
        NodeKind::Sender(config) => config.plant_node(&name),
        NodeKind::Receiver(mut config) => {
            // The files of a link are read where its delay is looked at.
            config.relative_to(folder);
            checked(config.check_files())?;
            config.plant_node(&name)
        }
        NodeKind::Gateway(config) => {
            checked(config.check())?;
            config.plant_node(&name)
        }
    })
}

/// Names the fields as the files have them: one with a `master` has no `far`.
pub(super) fn with_written_fields(mut plant: PlantAnalysis, files: &[PathBuf]) -> PlantAnalysis {
    let short: Vec<_> = files.iter().filter(|file| is_short(file)).collect();
    let short: Vec<_> = short
        .iter()
        .map(|file| file.display().to_string())
        .collect();
    let all = plant.findings.iter_mut().chain(&mut plant.notes);
    for PlantFinding { file, field, .. } in all {
        if short.contains(file) {
            *field = short_form(field);
        }
    }
    plant
}

fn is_short(file: &Path) -> bool {
    let text = text_file::read(file, MOST_CONFIG_BYTES).unwrap_or_default();
    let table = parse_table("", &text).unwrap_or_default();
    table.contains_key("master")
}

/// A field of the one far node in the short form.
fn short_form(field: &str) -> String {
    let Some(rest) = field.strip_prefix("far[0].") else {
        return field.to_owned();
    };
    match rest {
        // Those of the node stand beside `master`.
        "lag-ms" => rest.to_owned(),
        "axes" => "master.axis".to_owned(),
        rest => {
            let rest = rest.strip_prefix("axes[0].").unwrap_or(rest);
            format!("master.{rest}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_named_as_the_short_form_has_them() {
        for (field, expected) in [
            ("far[0].node", "master.node"),
            ("far[0].axes", "master.axis"),
            ("far[0].axes[0].unit", "master.unit"),
            ("far[0].lag-ms", "lag-ms"),
            ("cycle-time-us", "cycle-time-us"),
        ] {
            assert_eq!(short_form(field), expected);
        }
    }
}
