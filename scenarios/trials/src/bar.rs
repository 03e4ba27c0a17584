//! Progress on a terminal.

use std::io::{self, IsTerminal};

use coaxle_lab::finished::Progress;
use coaxle_os::Interrupt;
use indicatif::{ProgressBar, ProgressStyle};

/// A progress bar, on a terminal only; Ctrl-C ends the task it shows.
pub struct Bar {
    bar: ProgressBar,
    interrupt: Interrupt,
}

/// The bar's resolution.
// Finer than the forty cells and the whole percents of the bar.
const STEPS: u64 = 1_000;

impl Bar {
    /// A bar with this message behind the share.
    ///
    /// # Errors
    /// Signals that cannot be listened to.
    pub fn new(message: String) -> anyhow::Result<Self> {
        let bar = match io::stderr().is_terminal() {
            true => ProgressBar::new(STEPS),
            false => ProgressBar::hidden(),
        };
        let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}  {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style);
        bar.set_message(message);
        let interrupt = Interrupt::listen()?;
        Ok(Self { bar, interrupt })
    }

    /// Removes the bar from the screen.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn at(&mut self, share: f64) -> bool {
        // Truncated: the last step is reached only by a whole task.
        self.bar.set_position((share * STEPS as f64) as u64);
        !self.interrupt.is_received()
    }
}
