//! `coaxle scope`: a page on this PC that shows the rows of running nodes as they come, their status, and their slaves with
//! the commands for them.
//!
//! The page is three files in this folder that the tool carries with it; it loads nothing else. [`server`] serves it and
//! its requests, [`stream`] turns the pieces that a node publishes into the page's drawing data. A node's only change by
//! being watched is that it publishes its rows.

mod server;
mod stream;
#[cfg(test)]
mod tests;

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use coaxle_host::cli::NetworkArgs;
use coaxle_host::client::{Commander, Watcher};
use coaxle_host::network::transport::Transport;
use coaxle_host::node::{StartService, TransportService};
use coaxle_node::keys::NodeName;
use coaxle_os::Interrupt;
use coaxle_os::exit::Exit;
use coaxle_report::inspect;

use crate::web::{PageServer, PageToken};
use server::ScopePage;

/// The nodes, and the page.
#[derive(Debug, Args)]
pub(crate) struct ScopeArgs {
    /// The nodes [default: all that are there]
    #[arg(value_name = "NODE", value_parser = |name: &str| NodeName::new(name))]
    nodes: Vec<NodeName>,
    #[command(flatten)]
    page: PageArgs,
    #[command(flatten)]
    network: NetworkArgs,
}

/// Address of the page, and its commands.
#[derive(Clone, Debug, Args)]
pub(crate) struct PageArgs {
    /// Serve the page here; port 0 is any that is free
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:7480")]
    pub(crate) page: SocketAddr,
    /// Give the page buttons that command slaves, for those who open the address with the token that is printed
    #[arg(long)]
    pub(crate) commands: bool,
}

/// The page that a node serves of itself, and of the nodes that it sees.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct OwnPageArgs {
    /// Serve a page here that shows the node's state, such as 127.0.0.1:7480: docs/SCOPE.md
    #[arg(long, value_name = "ADDRESS", conflicts_with = "check")]
    page: Option<SocketAddr>,
    /// Give that page buttons that command slaves, for those who open the address with the token that is logged
    #[arg(long, requires = "page")]
    commands: bool,
}

impl OwnPageArgs {
    /// Page that runs beside the node on its transport, if it has one.
    pub(crate) fn transport_service(&self) -> Option<TransportService> {
        let page = PageArgs {
            page: self.page?,
            commands: self.commands,
        };
        let start: StartService = Box::new(move |transport| {
            // Over the node's own session: a second one would need a port and rights of its own.
            // Orders of the node's own page have its name in the log.
            let commander = page.commands.then(|| Commander::of_page(&transport));
            let commander = commander.transpose()?;
            let scope = Scope::open(Watcher::over(transport, &[])?, commander, &page)?;
            tracing::info!("the page is at {}", scope.url());
            Ok(Box::new(scope))
        });
        Some(TransportService {
            files: PageServer::MOST_FILES,
            threads: PageServer::MOST_THREADS,
            start,
        })
    }
}

/// Polling interval of the interrupt.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Serves the page until Ctrl-C.
///
/// # Errors
/// A network that cannot be joined, or an address that is not available.
pub(crate) fn scope(args: &ScopeArgs) -> anyhow::Result<Exit> {
    // Before the page is there, so that Ctrl-C is not missed meanwhile.
    let interrupt = Interrupt::listen()?;
    let watcher = args.network.watch(&args.nodes)?;
    let secure = args.network.transport()?.secure;
    let transport: &Arc<dyn Transport> = watcher.transport();
    // Not made without the option, so that no route can send an order by mistake.
    let commander = (args.page.commands)
        .then(|| Commander::over(Arc::clone(transport), secure.as_deref()))
        .transpose()?;
    let scope = Scope::open(watcher, commander, &args.page)?;
    inspect::print_text(&format!("the page is at {}", scope.url()))?;
    while !interrupt.is_received() {
        std::thread::park_timeout(POLL_INTERVAL);
    }
    scope.watcher.transport().close();
    Ok(Exit::Done)
}

/// A page that is served.
pub(crate) struct Scope {
    watcher: Arc<Watcher>,
    served: PageServer,
}

impl Scope {
    /// Serves a page of the watched nodes; its orders are sent by this commander, if they carry the token of the page.
    ///
    /// # Errors
    /// The address is not available.
    pub(crate) fn open(
        watcher: Watcher,
        commander: Option<Commander>,
        page: &PageArgs,
    ) -> anyhow::Result<Self> {
        if !page.page.ip().is_loopback() {
            tracing::warn!(
                "everybody who reaches {} sees all{}",
                page.page,
                if commander.is_some() {
                    ", and everybody who sees its traffic commands slaves"
                } else {
                    ""
                }
            );
        }
        let watcher = Arc::new(watcher);
        // Any process of this PC reaches a page on loopback.
        let token = commander.is_some().then(PageToken::draw).transpose()?;
        let routes = ScopePage {
            watcher: Arc::clone(&watcher),
            commander: commander.map(Arc::new),
        };
        let served = PageServer::open(page.page, token, routes)?;
        Ok(Self { watcher, served })
    }

    /// Address of the page, with the token of its commands.
    pub(crate) fn url(&self) -> String {
        self.served.url()
    }

    /// Socket address of the page.
    #[cfg(test)]
    pub(crate) const fn address(&self) -> SocketAddr {
        self.served.address()
    }
}
