//! Pages that the tool serves on this PC: admission of requests, responses, and lifetime of the server.
//!
//! A command defines what its page shows and which requests it takes. All pages draw with the same
//! [axes](coaxle_report::plotting).

mod answers;
mod guard;

use std::net::{SocketAddr, TcpListener};

use anyhow::Context;
use axum::Router;

pub(crate) use answers::{as_json, file, wrong};

/// Colours, type, buttons and tables of every page.
pub(crate) const BASE_CSS: &str = include_str!("base.css");

/// A page, served until dropped.
pub(crate) struct PageServer {
    address: SocketAddr,
    /// Absent once shut down.
    runtime: Option<tokio::runtime::Runtime>,
}

impl PageServer {
    /// Serves these routes to requests that name the host by its address or as `localhost`. Changes are accepted from the
    /// page itself only.
    ///
    /// # Errors
    /// The address is not available.
    pub(crate) fn open(at: SocketAddr, routes: Router) -> anyhow::Result<Self> {
        let listener =
            listen(at).with_context(|| format!("--page: cannot give out a page at {at}"))?;
        let address = listener.local_addr()?;
        // Last, as a runtime that is dropped within another one panics.
        let runtime = tokio::runtime::Builder::new_multi_thread()
            // A page has few users, and nodes on this PC need the processors.
            .worker_threads(1)
            .thread_name("page")
            .enable_all()
            .build()
            .context("cannot start the page's runtime")?;
        let guarded = routes
            .layer(axum::middleware::from_fn(guard::own_changes))
            // The layer added last runs first: a wrong host is refused before anything else.
            .layer(axum::middleware::from_fn(guard::own_host));
        runtime.spawn(serve(listener, guarded));
        Ok(Self {
            address,
            runtime: Some(runtime),
        })
    }

    /// Address of the page.
    pub(crate) const fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for PageServer {
    /// Shuts down in the background: a drop inside a runtime must not block.
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

fn listen(address: SocketAddr) -> std::io::Result<TcpListener> {
    // Bound here and not in the task: a port in use is an error of the command.
    let listener = TcpListener::bind(address)?;
    // tokio requires it of a listener of the standard library.
    listener.set_nonblocking(true)?;
    Ok(listener)
}

async fn serve(listener: TcpListener, routes: Router) {
    let served = match tokio::net::TcpListener::from_std(listener) {
        Ok(listener) => axum::serve(listener, routes).await,
        Err(error) => Err(error),
    };
    if let Err(error) = served {
        // The node beside it continues: a page is never a reason to stop an axis.
        tracing::error!("the page is gone: {error}");
    }
}
