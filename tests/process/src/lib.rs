//! Programs started by a test, which watches them while it waits.
//!
//! A test that waits for something in the log of a node waits in vain once that node is gone, and reports a time-out where there
//! was a crash. So every wait of this crate ([`until`], [`output()`], [`Process::wait`]) also watches every [`Process`] that the
//! same thread has started. An unexpected end of one fails the test at once, with its exit status and the last lines of
//! its log:
//!
//! ```should_panic
//! use coaxle_test_process::{Process, until};
//! use std::process::Command;
//!
//! let folder = std::env::temp_dir();
//! let mut command = Command::new("sh");
//! command.args(["-c", "echo out of tune >&2; kill -SEGV $$"]);
//! let _node = Process::start("line", &mut command, &folder.join("line.log"));
//! // line was killed by signal: 11 (SIGSEGV), while the test waited: the saw follows the line
//! // the last lines of its log:
//! //   out of tune
//! until("the saw follows the line", || false);
//! ```

mod output;
mod process;

use std::time::{Duration, Instant};

pub use output::output;
pub use process::{Process, assert_alive};

/// Timeout of a wait: the machine may be very busy.
pub const WAIT_TIMEOUT: Duration = Duration::from_secs(120);
/// Interval between two checks of the condition: far below the second within which a death is to be reported.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Waits until a condition holds.
///
/// # Panics
/// The condition does not hold within [`WAIT_TIMEOUT`], or a process that this thread has started is gone.
#[expect(
    clippy::disallowed_methods,
    reason = "a wait for processes, by which nothing is measured"
)]
pub fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begin = Instant::now();
    loop {
        // Before the condition is checked: the last effects of a process count.
        let deaths = process::deaths();
        if is_so() {
            return;
        }
        deaths.report(what);
        assert!(
            begin.elapsed() < WAIT_TIMEOUT,
            "waited {WAIT_TIMEOUT:?} in vain: {what}\n{}",
            process::logs().join("\n")
        );
        std::thread::park_timeout(POLL_INTERVAL);
    }
}
