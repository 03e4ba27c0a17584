//! Processes that do nothing but keep processors busy.

use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

/// The command, not shown in the help, that makes this program one of them.
pub const COMMAND: &str = "keep-busy";

/// Running busy processes. They end with this value, and with this program even if it is killed: the
/// pipe to their standard input closes.
#[derive(Debug, Default)]
pub(crate) struct Busy(Vec<Child>);

impl Busy {
    /// Starts this many processes.
    ///
    /// # Errors
    /// A process cannot be started.
    pub(crate) fn start(number: u16) -> anyhow::Result<Self> {
        let program = std::env::current_exe().context("cannot find this program")?;
        // Filled one by one: if a start fails, the drop ends those before.
        let mut busy = Self::default();
        for _ in 0..number {
            let process = Command::new(&program)
                .arg(COMMAND)
                .stdin(Stdio::piped())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .context("cannot start a busy process")?;
            busy.0.push(process);
        }
        Ok(busy)
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        for process in &mut self.0 {
            let _ = process.kill();
            let _ = process.wait();
        }
    }
}

/// Keeps one processor busy until standard input ends.
///
/// # Errors
/// Standard input cannot be watched.
pub fn keep_busy() -> anyhow::Result<()> {
    // Static, as the thread may outlive this function.
    static ENDED: AtomicBool = AtomicBool::new(false);
    std::thread::Builder::new()
        .name("stdin".to_owned())
        .spawn(|| {
            let mut nothing = [0];
            // A read of 0 bytes is the end of the pipe: the starting program is gone.
            while std::io::stdin().read(&mut nothing).is_ok_and(|n| n > 0) {}
            ENDED.store(true, Ordering::Relaxed);
        })
        .context("cannot watch standard input")?;
    while !ENDED.load(Ordering::Relaxed) {
        // Never sleeps: a load that gives up the processor would not compete with the nodes.
        std::hint::spin_loop();
    }
    Ok(())
}
