//! Pages that the tool gives out on this PC: who may ask, what the answers are like, and how long it lasts.
//!
//! What a page shows and what it may be told are those of the command that gives it out. All of them draw with the same
//! [axes](coaxle_report::plotting).

mod answers;
mod guard;

use std::net::{SocketAddr, TcpListener};

use anyhow::Context;
use axum::Router;

pub(crate) use answers::{as_json, file, wrong};

/// Colours, type, buttons and tables of every page.
pub(crate) const BASE_CSS: &str = include_str!("base.css");

/// A page that is given out, until it is dropped.
pub(crate) struct Served {
    address: SocketAddr,
    /// None when it is over.
    runtime: Option<tokio::runtime::Runtime>,
}

impl Served {
    /// Gives out what is at these routes, to whoever asks for this host by its address or as `localhost`; what changes
    /// anything, to the page itself alone.
    ///
    /// # Errors
    /// The address is not to be had.
    pub(crate) fn open(at: SocketAddr, routes: Router) -> anyhow::Result<Self> {
        let listener =
            listen(at).with_context(|| format!("--page: cannot give out a page at {at}"))?;
        let address = listener.local_addr()?;
        // Last, as a runtime that is dropped within another one panics.
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("page")
            .enable_all()
            .build()
            .context("cannot start the page's runtime")?;
        let guarded = routes
            .layer(axum::middleware::from_fn(guard::own_changes))
            .layer(axum::middleware::from_fn(guard::own_host));
        runtime.spawn(serve(listener, guarded));
        Ok(Self {
            address,
            runtime: Some(runtime),
        })
    }

    /// Where it is.
    pub(crate) const fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Served {
    /// Whoever drops it may be in a runtime itself, where nobody may wait.
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

fn listen(address: SocketAddr) -> std::io::Result<TcpListener> {
    let listener = TcpListener::bind(address)?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

async fn serve(listener: TcpListener, routes: Router) {
    let served = match tokio::net::TcpListener::from_std(listener) {
        Ok(listener) => axum::serve(listener, routes).await,
        Err(error) => Err(error),
    };
    if let Err(error) = served {
        tracing::error!("the page is gone: {error}");
    }
}
