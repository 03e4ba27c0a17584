//! A slave of a running receiver that the plate is loaded into.

use clap::Args;
use coaxle_files::cam::CamFile;
use coaxle_host::cli::NetworkArgs;
use coaxle_host::client::Commander;
use coaxle_node::CommandOrder;
use coaxle_node::command::{PlateOrder, SlaveName};
use coaxle_node::keys::NodeName;
use serde_json::{Value, json};

use crate::command::in_words;

/// The node and its slave.
#[derive(Debug, Args)]
pub(super) struct TargetArgs {
    /// A running receiver: gives the page buttons that load the plate into it and couple its slave. Anyone who reaches the
    /// page can use them
    #[arg(long, requires = "slave", value_parser = |name: &str| NodeName::new(name))]
    node: Option<NodeName>,
    /// Slave of that node
    #[arg(long, requires = "node")]
    slave: Option<SlaveName>,
    /// The number of the plate there [default: the file's table-id, or 1]
    #[arg(long, requires = "node", value_parser = clap::value_parser!(u8).range(1..))]
    table: Option<u8>,
    #[command(flatten)]
    network: NetworkArgs,
}

impl TargetArgs {
    pub(super) fn open(&self) -> anyhow::Result<Option<CommandTarget>> {
        let (Some(node), Some(slave)) = (&self.node, self.slave) else {
            return Ok(None);
        };
        Ok(Some(CommandTarget {
            commander: Commander::open(&self.network.transport()?)?,
            node: node.clone(),
            slave: json!(slave),
            table: self.table,
        }))
    }
}

/// A slave, and the client that commands it.
pub(super) struct CommandTarget {
    commander: Commander,
    node: NodeName,
    slave: Value,
    table: Option<u8>,
}

impl CommandTarget {
    /// Name for people.
    pub(super) fn name(&self) -> String {
        format!("{}/{}", self.node, self.slave.as_str().unwrap_or_default())
    }

    /// The number of the plate there.
    pub(super) fn table(&self, cam: &CamFile) -> u8 {
        let of_file = || cam.table_id.map(|id| id.get());
        // Numbers of plates begin at 1.
        self.table.or_else(of_file).unwrap_or(1)
    }

    /// Sends the page's command to the slave, and returns the response.
    ///
    /// # Errors
    /// The node is not there, does not respond, or refuses.
    pub(super) fn act(&self, cam: &CamFile, wanted: &Value) -> Result<String, String> {
        let table = self.table(cam);
        let activation = match &wanted["activation"] {
            Value::String(mode) => json!({ "mode": mode }),
            _ => json!({ "mode": "next-cycle" }),
        };
        let commands = match wanted["do"].as_str().unwrap_or_default() {
            "load" => {
                let plate = PlateOrder::new(cam.source(), None);
                // First the mode: otherwise the select would change a coupled plate in the mode of before.
                let mode = json!({ "set-cam-online-change-mode": { "table": table, "mode": { "activation": activation } } });
                let select = json!({ "cam-table-select": { "table": table, "replace": true, "plate": plate } });
                // Before there is a plate there is no mode of changing it.
                if self.send(&mode).is_ok_and(|(is_accepted, _)| is_accepted) {
                    vec![select]
                } else {
                    vec![select, mode]
                }
            }
            "power" => vec![json!({ "power": true })],
            "couple" => vec![json!({ "cam-in": { "table": table, "activation": activation } })],
            "uncouple" => vec![json!({ "cam-out": {} })],
            "halt" => vec![json!({ "halt": {} })],
            "info" => vec![json!({ "cam-info": { "table": table } })],
            other => {
                return Err(format!(
                    "received {other:?}, expected load, power, couple, uncouple, halt or info"
                ));
            }
        };
        let mut text = String::new();
        for command in &commands {
            let (is_accepted, words) = self.send(command)?;
            let words = format!("{}: {words}", self.name());
            if !is_accepted {
                return Err(words);
            }
            // The first of several responses is the one to the page's command.
            if text.is_empty() {
                text = words;
            }
        }
        Ok(text)
    }

    fn send(&self, command: &Value) -> Result<(bool, String), String> {
        let order = json!({ "version": 1, "slave": self.slave, "command": command });
        // Through JSON, so that the page's orders pass the same checks as those of the network.
        let order = CommandOrder::from_json(order.to_string().as_bytes());
        let order = order.map_err(|error| error.to_string())?;
        let answer = self.commander.send(&self.node, &order);
        let answer = answer.map_err(|error| format!("{error:#}"))?;
        Ok((answer.is_accepted(), in_words(&answer)))
    }
}
