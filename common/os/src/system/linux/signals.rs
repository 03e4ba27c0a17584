//! SIGINT, SIGTERM and SIGHUP.

use std::io;

use tokio::signal::unix::{Signal, SignalKind, signal};

use crate::EndReason;
use crate::EndSignals;

/// Signals that end a program.
#[derive(Debug)]
pub struct EndSignalListener {
    interrupt: Signal,
    terminate: Signal,
    /// SIGHUP; none if the process was started to outlive its terminal.
    hang_up: Option<Signal>,
}

impl EndSignalListener {
    pub(super) fn listen() -> io::Result<Self> {
        let hang_up = (!ignores_hang_up()).then(|| signal(SignalKind::hangup()));
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            hang_up: hang_up.transpose()?,
        })
    }
}

impl EndSignals for EndSignalListener {
    async fn next(&mut self) -> EndReason {
        let hang_up = async {
            match &mut self.hang_up {
                Some(signal) => signal.recv().await,
                // Never ready, so that the branch below never wins.
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            _ = self.interrupt.recv() => EndReason::Interrupted,
            _ = self.terminate.recv() => EndReason::Terminated,
            _ = hang_up => EndReason::HungUp,
        }
    }
}

/// True if this process was started with SIGHUP ignored, as `nohup` does: listening would undo that.
fn ignores_hang_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    // SIGHUP is number 1, the lowest bit.
    ignored_signals(&status).is_some_and(|mask| mask & 1 != 0)
}

/// Returns a bit for each signal, from number 1 on.
fn ignored_signals(status: &str) -> Option<u64> {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    u64::from_str_radix(mask?.trim(), 16).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_bit_of_the_ignored_signals_is_that_of_sighup() {
        let status =
            |mask: &str| format!("SigBlk:\t0000000000000001\nSigIgn:\t{mask}\nSigCgt:\t1\n");
        assert_eq!(ignored_signals(&status("0000000000001001")), Some(0x1001));
        assert_eq!(ignored_signals(&status("0000000000001000")), Some(0x1000));
        assert_eq!(ignored_signals("Name:\tx\n"), None);
    }
}
