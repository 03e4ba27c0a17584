//! `coaxle signals CONFIG`: the signals of a node.

use std::io::Write;
use std::path::Path;

use coaxle_node::signal::{Instance, Signal};
use coaxle_report::inspect;

use crate::node_config::{NodeConfig, NodeKind};

/// Prints every signal of the node of a config: its column of the trace, unit and meaning.
pub(crate) fn signals(file: &Path) -> anyhow::Result<bool> {
    let instances = instances_of(file)?;
    inspect::print(|out| {
        for instance in &instances {
            list(instance, out)?;
        }
        Ok(true)
    })
}

fn instances_of(file: &Path) -> anyhow::Result<Vec<Instance>> {
    Ok(match NodeConfig::load(file)?.kind {
        NodeKind::Sender(config) => config.instances(),
        NodeKind::Receiver(config) => config.instances(),
        NodeKind::Gateway(config) => config.instances(),
    })
}

fn list(instance: &Instance, out: &mut dyn Write) -> anyhow::Result<()> {
    match instance.name.as_str() {
        "" => writeln!(out, "{}", instance.group)?,
        name => writeln!(out, "\n{} {name}", instance.group)?,
    }
    let columns: Vec<String> = instance.columns().collect();
    let width = |cells: &mut dyn Iterator<Item = usize>| cells.max().unwrap_or(0);
    // Characters, not bytes: names and units have `µ` and `²` in them.
    let longest = width(&mut columns.iter().map(|column| column.chars().count()));
    // `u` in the declaration of a signal stands for the unit of its axis.
    let unit = |s: &Signal| instance.unit.in_place_of_u(s.unit);
    let widest = width(&mut instance.signals.iter().map(|s| unit(s).chars().count()));
    for (column, signal) in columns.iter().zip(instance.signals) {
        let (unit, meaning) = (unit(signal), signal.meaning());
        writeln!(out, "  {column:longest$}  {unit:widest$}  {meaning}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_receiver::ReceiverConfig;

    #[test]
    fn every_signal_is_listed_as_its_column_with_unit_and_meaning() {
        let text = "name = 'line'\ncycle-time-us = 1000\n[[far]]\nnode = 'press'\naxes = [7]\nunit = 'mm'\n\
            [[slave]]\nname = 'ram'";
        let config: ReceiverConfig = coaxle_node::config::parse("r", text).unwrap();
        let mut out = Vec::new();
        for instance in config.instances() {
            list(&instance, &mut out).unwrap();
        }
        let text = String::from_utf8(out).unwrap();
        let line = |start: &str| {
            let found = text
                .lines()
                .find(|line| line.trim_start().starts_with(start));
            found.map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
        };
        assert_eq!(line("far axis"), Some("far axis press.7".to_owned()));
        let velocity = "press.7.corrected_velocity mm/s Corrected set velocity.";
        assert_eq!(
            line("press.7.corrected_velocity").as_deref(),
            Some(velocity)
        );
        let listed = text.lines().filter(|line| line.starts_with("  ")).count();
        // Without the two columns of time.
        assert_eq!(listed, config.columns().len() - 2);
    }
}
