//! Editors: a TOML file on a page in a browser, drawn and changed there, and written back with its comments.
//!
//! A [`Design`] knows the meaning of a file: it makes the view of a text for the page, and another text of a change.
//! Texts, undoing and saving are common to all of them. Everything is computed here; the page draws it.

mod file;
mod history;
mod server;
pub(crate) mod toml_text;

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use coaxle_os::Interrupt;
use coaxle_os::exit::Exit;
use coaxle_report::inspect;
use serde_json::Value;

use crate::web::{PageServer, PageToken};
use file::EditedFile;
pub(crate) use server::PageParts;

/// The file, and the address of its page.
#[derive(Clone, Debug, Args)]
pub(crate) struct EditArgs {
    /// The file, TOML; it need not be there yet
    pub(crate) file: PathBuf,
    /// Serve the page here; port 0 is any that is free [default: 127.0.0.1:7481, or any free port if another designer has that]
    #[arg(long, value_name = "ADDRESS")]
    pub(crate) page: Option<SocketAddr>,
}

/// Port of the page unless it is taken.
const PORT: u16 = 7481;

impl EditArgs {
    fn address(&self) -> SocketAddr {
        self.page.unwrap_or_else(|| {
            let usual = SocketAddr::from((Ipv4Addr::LOCALHOST, PORT));
            // Two files are often designed at a time: a cam and the saw that it belongs to.
            let is_taken = TcpListener::bind(usual)
                .is_err_and(|error| error.kind() == io::ErrorKind::AddrInUse);
            SocketAddr::from((Ipv4Addr::LOCALHOST, if is_taken { 0 } else { PORT }))
        })
    }
}

/// A kind of file that is designed.
pub(crate) trait Design: Send + 'static {
    /// Most bytes of a file.
    const MOST_BYTES: u64;

    /// Text of a new file.
    fn template(&self) -> String;

    /// The view of a text, in the page's settings.
    fn view(&mut self, text: &str, asked: &Value) -> Value;

    /// The text with a change.
    ///
    /// # Errors
    /// The reason why the text stays as it is.
    fn changed(&mut self, text: &str, change: &Value, asked: &Value) -> Result<String, String>;

    /// Checks that the text can be saved.
    ///
    /// # Errors
    /// The first fault of the text.
    fn check(&self, text: &str) -> Result<(), String>;

    /// Does something else that the page wants, and returns the result in words.
    ///
    /// # Errors
    /// The reason why it is not done.
    fn act(&mut self, text: &str, wanted: &Value) -> Result<String, String>;
}

/// Polling interval of the interrupt.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Serves the page of a file until Ctrl-C.
///
/// # Errors
/// A file that cannot be read, or an address that is not available.
pub(crate) fn edit(args: &EditArgs, design: impl Design, parts: PageParts) -> anyhow::Result<Exit> {
    // Before the page is there, so that Ctrl-C is not missed meanwhile.
    let interrupt = Interrupt::listen()?;
    let served = open(args, design, parts)?;
    inspect::print_text(&format!("the page is at {}", served.url()))?;
    while !interrupt.is_received() {
        std::thread::park_timeout(POLL_INTERVAL);
    }
    Ok(Exit::Done)
}

/// Serves the page of a file.
///
/// # Errors
/// A file that cannot be read, or an address that is not available.
pub(crate) fn open<D: Design>(
    args: &EditArgs,
    design: D,
    parts: PageParts,
) -> anyhow::Result<PageServer> {
    // The token in the address is the right to write. It is not encrypted on its way.
    let address = args.address();
    if !address.ip().is_loopback() {
        tracing::warn!(
            "{address} can be reached by others, who see the file; those who see the traffic change it"
        );
    }
    // Before the port is taken: a file that cannot be read needs no page.
    let file = EditedFile::open(&args.file, D::MOST_BYTES)?;
    let token = PageToken::draw()?;
    PageServer::open(address, Some(token), server::routes(file, design, parts))
}

#[cfg(test)]
mod tests;
