//! Ctrl-C during the work of a tool: it ends by itself, with its results so far.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

use crate::exit::Exit;
use crate::{EndSignals, Os, System};

/// Flag of a received Ctrl-C, SIGTERM or SIGHUP.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on, for the rest of the process. A second signal ends the process at once.
    ///
    /// # Errors
    /// The system refuses a thread or the signals.
    pub fn listen() -> anyhow::Result<Self> {
        let interrupt = Self::default();
        let received = Arc::clone(&interrupt.0);
        // A runtime of its own: a tool has none, and signals must arrive while it works.
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .build();
        let runtime = runtime.context("cannot listen for signals")?;
        let mut signals = {
            // Signals register with the runtime that is entered, here before the thread: no signal is missed.
            let _entered = runtime.enter();
            Os::end_signals().context("cannot listen for signals")?
        };
        let listening = move || {
            runtime.block_on(async {
                let _ = signals.next().await;
                // A flag alone, which orders no other data: relaxed suffices.
                received.store(true, Ordering::Relaxed);
                let _ = signals.next().await;
            });
            std::process::exit(Exit::Interrupted as i32);
        };
        let thread = std::thread::Builder::new().name("signals".to_owned());
        thread
            .spawn(listening)
            .context("cannot listen for signals")?;
        Ok(interrupt)
    }

    /// True if a signal has been received.
    #[must_use]
    pub fn is_received(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
