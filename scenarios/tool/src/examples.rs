//! `coaxle example`: configs of nodes to start from, carried in the tool.

use coaxle_os::exit::wrong_argument;
use coaxle_report::inspect;

/// Kind of node, name and text of each config.
const EXAMPLES: [(&str, &str, &str); 12] = [
    (
        "sender",
        "conveyor",
        // In the program: the tool works without a checkout.
        include_str!("../../../sender/configs/conveyor.toml"),
    ),
    (
        "sender",
        "lab-conveyor",
        include_str!("../../../sender/configs/lab-conveyor.toml"),
    ),
    (
        "receiver",
        "saw",
        include_str!("../../../receiver/configs/saw.toml"),
    ),
    (
        "receiver",
        "line",
        include_str!("../../../receiver/configs/line.toml"),
    ),
    (
        "receiver",
        "carriage",
        include_str!("../../../receiver/configs/carriage.toml"),
    ),
    (
        "receiver",
        "chained",
        include_str!("../../../receiver/configs/chained.toml"),
    ),
    (
        "receiver",
        "drive",
        include_str!("../../../receiver/configs/drive.toml"),
    ),
    (
        "receiver",
        "shaft",
        include_str!("../../../receiver/configs/shaft.toml"),
    ),
    (
        "receiver",
        "plc-axis",
        include_str!("../../../receiver/configs/plc-axis.toml"),
    ),
    (
        "gateway",
        "plc",
        include_str!("../../../common/gateway/configs/plc.toml"),
    ),
    (
        "gateway",
        "plc-udp",
        include_str!("../../../common/gateway/configs/plc-udp.toml"),
    ),
    (
        "opcua",
        "opcua",
        include_str!("../../../common/opcua/configs/opcua.toml"),
    ),
];

/// Prints a config, or without a name the list of them.
///
/// # Errors
/// No config has this name. The error lists those that exist.
pub(crate) fn print(name: Option<&str>) -> anyhow::Result<bool> {
    let text = match name {
        Some(name) => text(name)?.to_owned(),
        None => list(),
    };
    inspect::print_text(text.trim_end()).map(|()| true)
}

fn text(wanted: &str) -> anyhow::Result<&'static str> {
    let found = EXAMPLES.iter().find(|(_, name, _)| *name == wanted);
    match found {
        Some((_, _, text)) => Ok(text),
        None => {
            let names: Vec<_> = EXAMPLES.iter().map(|(_, name, _)| *name).collect();
            wrong_argument(format!(
                "received the name {wanted:?}, expected one of {}",
                names.join(", ")
            ))
        }
    }
}

fn list() -> String {
    let mut lines: Vec<_> = EXAMPLES.iter().map(line).collect();
    lines.push("\nStart from one with: coaxle example conveyor > conveyor.toml".to_owned());
    lines.join("\n")
}

/// Role and name of a config, with its first line, which describes it.
fn line((role, name, text): &(&str, &str, &str)) -> String {
    // From the file itself, so that list and config cannot differ.
    let about = text.lines().next().unwrap_or_default();
    format!(
        "{name:12} {role:9} {}",
        // Without the sign of a comment in TOML.
        about.trim_start_matches(['#', ' '])
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_gateway::config::GatewayConfig;
    use coaxle_node::config::parse;
    use coaxle_node::lab::{NodeFile, WithLab};
    use coaxle_opcua::config::OpcuaConfig;
    use coaxle_receiver::ReceiverConfig;
    use coaxle_sender::config::SenderConfig;

    #[test]
    fn every_shipped_config_is_carried_and_can_be_read() {
        for (role, place) in [
            ("sender", "sender"),
            ("receiver", "receiver"),
            ("gateway", "common/gateway"),
            ("opcua", "common/opcua"),
        ] {
            let folder = format!("{}/../../{place}/configs", env!("CARGO_MANIFEST_DIR"));
            for file in std::fs::read_dir(folder).unwrap() {
                let path = file.unwrap().path();
                let name = path.file_stem().unwrap().to_str().unwrap();
                let found = EXAMPLES
                    .iter()
                    .find(|(of, known, _)| (*of, *known) == (role, name));
                assert!(found.is_some(), "{role} {name}");
            }
        }
    }

    /// A file, of which only one of an experiment injects or simulates anything.
    fn read<C: WithLab>(name: &str, text: &str) -> C {
        let NodeFile { config, lab } = NodeFile::<C>::parse(name, text).unwrap();
        assert_eq!(lab.is_some(), name.starts_with("lab-"), "{name}: {lab:?}");
        config
    }

    #[test]
    fn no_shipped_config_injects_a_fault_unless_its_name_says_so() {
        for (role, name, text) in EXAMPLES {
            match role {
                "sender" => drop(read::<SenderConfig>(name, text)),
                "gateway" => {
                    let config: GatewayConfig = read(name, text);
                    assert_eq!(config.check(), Ok(()), "{name}");
                }
                "opcua" => {
                    let config: OpcuaConfig = parse(name, text).unwrap();
                    assert_eq!(config.check(), Ok(()), "{name}");
                }
                _ => drop(read::<ReceiverConfig>(name, text)),
            }
        }
    }

    #[test]
    fn they_are_listed_with_what_they_are_and_a_wrong_name_with_the_right_ones() {
        let list = list();
        assert!(
            list.lines().count() > EXAMPLES.len() && list.contains("saw"),
            "{list}"
        );
        let refused = text("conveior").unwrap_err().to_string();
        assert!(
            refused.contains("\"conveior\"") && refused.contains("conveyor, saw"),
            "{refused}"
        );
    }
}
