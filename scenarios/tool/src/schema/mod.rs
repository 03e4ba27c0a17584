//! `coaxle schema`: JSON Schema of each kind of file, for editors and checks, made from the types that read it.

mod figures;
mod reference;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use coaxle_files::cam::CamFile;
use coaxle_files::gear::GearFile;
use coaxle_files::saw::SawFile;
use coaxle_gateway::config::GatewayConfig;
use coaxle_lab::scenario::Scenario;
use coaxle_node::config::schema::schema_of;
use coaxle_node::lab::NodeFile;
use coaxle_opcua::config::OpcuaConfig;
use coaxle_receiver::ReceiverConfig;
use coaxle_report::inspect::print_text;
use coaxle_sender::config::SenderConfig;
use schemars::Schema;
use schemars::transform::{RecursiveTransform, Transform};
use serde_json::Value;

/// Choice of schemas, and their destination.
#[derive(Debug, Args)]
pub struct SchemaArgs {
    /// The kind of file [default: all of them, with --out]
    #[arg(required_unless_present = "out")]
    kind: Option<FileKind>,
    /// Write the schema to this folder, as coaxle-KIND.schema.json
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FileKind {
    /// An experiment: senders, receivers, events and expectations
    Scenario,
    /// The config of a sender
    Sender,
    /// The config of a receiver
    Receiver,
    /// The config of a gateway to a PLC
    Gateway,
    /// The config of a server of OPC UA
    Opcua,
    /// A cam plate
    Cam,
    /// A flying saw at the moment of coupling
    Saw,
    /// A flying gear when it is enabled
    Gear,
}

impl FileKind {
    /// The kind, as the command line spells it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scenario => "scenario",
            Self::Sender => "sender",
            Self::Receiver => "receiver",
            Self::Gateway => "gateway",
            Self::Opcua => "opcua",
            Self::Cam => "cam",
            Self::Saw => "saw",
            Self::Gear => "gear",
        }
    }

    /// The schema of this kind.
    #[must_use]
    pub fn schema(self) -> Value {
        let mut schema = match self {
            Self::Scenario => schema_of::<Scenario>(),
            Self::Sender => NodeFile::<SenderConfig>::schema(),
            Self::Receiver => NodeFile::<ReceiverConfig>::schema(),
            Self::Gateway => NodeFile::<GatewayConfig>::schema(),
            Self::Opcua => schema_of::<OpcuaConfig>(),
            Self::Cam => schema_of::<CamFile>(),
            Self::Saw => schema_of::<SawFile>(),
            Self::Gear => schema_of::<GearFile>(),
        };
        // Only scenarios have groups: the configs of nodes are of single ones.
        if self == Self::Scenario {
            let mut with_numbers = RecursiveTransform(names_with_numbers);
            with_numbers.transform(&mut schema);
        }
        let title = format!("Coaxle: {}", self.name());
        // Editors show the title; the name of the Rust type would say nothing to a user.
        schema.insert("title".to_owned(), title.into());
        schema.to_value()
    }
}

/// Names in a group may hold those of numbers, in braces.
fn names_with_numbers(schema: &mut Schema) {
    if let Some(Value::String(pattern)) = schema.get_mut("pattern") {
        // A schema cannot know which names are in a group, so braces are allowed in all.
        *pattern = pattern.replace("[A-Za-z0-9._-]", "[A-Za-z0-9._{}-]");
    }
}

/// Prints a schema, or writes one or all of them to a folder.
///
/// # Errors
/// Names the file that cannot be written.
pub fn print(args: &SchemaArgs) -> anyhow::Result<()> {
    match (args.kind, &args.out) {
        (kind, Some(out)) => {
            let kinds = kind.map_or(FileKind::value_variants().to_vec(), |kind| vec![kind]);
            kinds.into_iter().try_for_each(|kind| write(kind, out))
        }
        (Some(kind), None) => print_text(&text(kind)?),
        // The command line does not let that through.
        (None, None) => Ok(()),
    }
}

fn write(kind: FileKind, out: &Path) -> anyhow::Result<()> {
    let path = out.join(format!("coaxle-{}.schema.json", kind.name()));
    let cannot = || format!("cannot write {}", path.display());
    std::fs::create_dir_all(out).with_context(cannot)?;
    std::fs::write(&path, text(kind)? + "\n").with_context(cannot)?;
    print_text(&format!("{}: {}", kind.name(), path.display()))
}

fn text(kind: FileKind) -> anyhow::Result<String> {
    serde_json::to_string_pretty(&kind.schema()).context("cannot write the schema as JSON")
}
