//! The server in the real world: the network of the nodes on one side, clients of OPC UA on the other.

mod audit;
mod calls;
mod certificates;
mod followed;
mod nodes;
mod server;
mod space;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use clap::Args;
use coaxle_clock::Span;
use coaxle_host::cli::{parse_duration, report_valid};
use coaxle_host::client::{Commander, Watcher};
use coaxle_host::network::credentials::{Credentials, known_nodes};
use coaxle_host::network::transport::zenoh_config;
use coaxle_node::config::{ConfigError, TransportConfig, load};
use coaxle_node::keys::NodeName;
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};
use coaxle_os::Interrupt;
use coaxle_os::exit::Exit;

use crate::config::{EndpointSecurity, OpcuaConfig};
use calls::Caller;
use nodes::ShownNodes;
use server::RunningServer;

/// The config of the server, and its actions.
#[derive(Debug, Args)]
pub struct OpcuaArgs {
    /// The server's config file (TOML)
    config: PathBuf,
    /// Only check the config and the files it names: print "CONFIG: ok" or the errors
    #[arg(long, conflicts_with_all = ["run_for", "certificates"])]
    check: bool,
    /// Make the certificates of the server, and those of these clients, in the folder endpoint.certificates of the config
    #[arg(long, value_delimiter = ',', value_name = "CLIENTS", value_parser = |name: &str| NodeName::new(name))]
    certificates: Vec<NodeName>,
    /// Stop after this time: 10s, 500ms, 2min … [default: run until Ctrl-C]
    #[arg(long = "for", value_name = "DURATION", value_parser = parse_duration)]
    run_for: Option<Span>,
}

/// Checks the config, makes certificates, or serves until Ctrl-C.
///
/// # Errors
/// A wrong config (file, field, received, expected), certificates that cannot be read or written, a port that is in use, or a
/// network that cannot be joined. A node that is not there is no error: it is waited for.
pub fn run(args: &OpcuaArgs) -> anyhow::Result<Exit> {
    let config = args.load()?;
    if !args.certificates.is_empty() {
        return certificates::make(&config, &args.certificates).map(|()| Exit::Done);
    }
    if let Some(folder) = &config.endpoint.certificates {
        certificates::check(folder).map_err(|error| args.wrong(format!("{error:#}")))?;
    }
    if args.check {
        return report_valid(&args.config.display()).map(|()| Exit::Done);
    }
    serve(args, &config)
}

fn serve(args: &OpcuaArgs, config: &OpcuaConfig) -> anyhow::Result<Exit> {
    let interrupt = Interrupt::listen()?;
    // Before the network is joined: of two servers the second one ends at once.
    let listener = server::listen(config)?;
    let watcher = watch(config)?;
    let transport = Arc::clone(watcher.transport());
    let commander = Commander::over(Arc::clone(&transport), config.transport.secure.as_deref())?;
    let caller = Caller::new(config, commander);
    let server = RunningServer::start(config, listener, caller)?;
    let at = server.url();
    tracing::info!("OPC UA at {at}; {}", watcher.whereabouts());
    warn_of_open_door(config);
    let mut nodes = ShownNodes::new(watcher, config, server);
    nodes.run(&interrupt, args.run_for);
    // First the clients go, then the network.
    drop(nodes);
    transport.close();
    Ok(Exit::Done)
}

impl OpcuaArgs {
    /// Reads the config, with its paths relative to the file.
    fn load(&self) -> anyhow::Result<OpcuaConfig> {
        let mut config: OpcuaConfig = load(&self.config)?;
        config.check().map_err(|wrong| self.wrong(wrong))?;
        config.relative_to(self.config.parent().unwrap_or(Path::new("")));
        self.check_transport(&config.transport)?;
        Ok(config)
    }

    fn check_transport(&self, transport: &TransportConfig) -> anyhow::Result<()> {
        // The built config is dropped: the check alone counts, so that `--check` finds what a start would refuse.
        zenoh_config(transport).map_err(|error| self.wrong(format!("{error:#}")))?;
        if let Some(folder) = &transport.secure {
            let field = || format!("transport.secure: {}", folder.display());
            let of_operator = Credentials::open(folder)
                .map_err(anyhow::Error::from)
                .and_then(|_| known_nodes(folder));
            of_operator
                .with_context(field)
                .map_err(|error| self.wrong(format!("{error:#}")))?;
        }
        Ok(())
    }

    /// Error in the config file from a check whose text begins with the field, with its line.
    fn wrong(&self, reason: impl ToString) -> ConfigError {
        let file = self.config.display().to_string();
        let error = ConfigError::whole(&file, reason);
        match text_file::read(&self.config, MOST_CONFIG_BYTES) {
            Ok(text) => error.in_text(&file, &text),
            Err(_) => error,
        }
    }
}

fn watch(config: &OpcuaConfig) -> anyhow::Result<Watcher> {
    let nodes = match (&config.transport.secure, &config.nodes[..]) {
        // Access control answers a wildcard with silence: each known node is named instead.
        (Some(folder), []) => known_nodes(folder)?,
        (_, nodes) => nodes.to_vec(),
    };
    Watcher::open(&config.transport, &nodes)
}

fn warn_of_open_door(config: &OpcuaConfig) {
    let at = config.endpoint.listen;
    if config.endpoint.security == EndpointSecurity::None && !at.ip().is_loopback() {
        let may = match config.rights.anonymous_commands {
            true => "see and command all nodes",
            false => "see all nodes",
        };
        tracing::warn!(
            "{at} is reached from other PCs without certificates: all who reach it may {may}"
        );
    }
}
