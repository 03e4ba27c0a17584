//! Pages that the tool serves on this PC: admission of requests, responses, and lifetime of the server.
//!
//! A command defines what its page shows and which requests it takes. All pages draw with the same
//! [axes](coaxle_report::plotting).

mod answers;
mod connections;
mod guard;
mod request;
mod server;
#[cfg(test)]
mod tests;
mod token;
mod write_limit;

use std::net::{SocketAddr, TcpListener};

use anyhow::Context;

pub(crate) use answers::{
    CSS, HTML, JAVASCRIPT, Response, SVG, as_json, file, not_found, streamed, whole, wrong,
};
pub(crate) use request::{Verb, WebRequest};
pub(crate) use server::Routes;
pub(crate) use token::PageToken;

/// Colours, type, buttons and tables of every page.
pub(crate) const BASE_CSS: &str = include_str!("base.css");

/// Threads for requests that wait; further ones queue.
const MOST_WAITING_THREADS: usize = 4;

/// A page, served until dropped.
pub(crate) struct PageServer {
    address: SocketAddr,
    token: Option<PageToken>,
    /// Absent once shut down.
    runtime: Option<tokio::runtime::Runtime>,
}

impl PageServer {
    /// Descriptors of a page at most: its listener, its runtime, its connections, and one that is just accepted.
    pub(crate) const MOST_FILES: usize = connections::MOST_CONNECTIONS + 8;
    /// Threads of a page at most.
    pub(crate) const MOST_THREADS: usize = 1 + MOST_WAITING_THREADS;

    /// Serves these routes to requests that name the host by its address or as `localhost`. Changes are accepted from the
    /// page itself only, and with this token. Without a token the routes refuse them.
    ///
    /// # Errors
    /// The address is not available.
    pub(crate) fn open(
        at: SocketAddr,
        token: Option<PageToken>,
        routes: impl Routes,
    ) -> anyhow::Result<Self> {
        let listener =
            listen(at).with_context(|| format!("--page: cannot give out a page at {at}"))?;
        let address = listener.local_addr()?;
        // Last, as a runtime that is dropped within another one panics.
        let runtime = tokio::runtime::Builder::new_multi_thread()
            // A page has few users, and nodes on this PC need the processors.
            .worker_threads(1)
            // For requests that wait: for a node, or for a calculation.
            .max_blocking_threads(MOST_WAITING_THREADS)
            .thread_name("page")
            .enable_all()
            .build()
            .context("cannot start the page's runtime")?;
        runtime.spawn(server::serve(listener, token.clone(), routes));
        Ok(Self {
            address,
            token,
            runtime: Some(runtime),
        })
    }

    /// Address of the page, for a browser; with the token, if there is one.
    pub(crate) fn url(&self) -> String {
        let query = self.token.as_ref().map(PageToken::query);
        format!("http://{}{}", self.address, query.unwrap_or_default())
    }

    /// Socket address of the page.
    #[cfg(test)]
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
