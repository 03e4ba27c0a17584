//! A node that a signal killed although the scenario did not order it.

use std::fmt;
use std::process::ExitStatus;

use coaxle_clock::Instant;
use coaxle_lab::verdict::Verdict;
use coaxle_os::Machine;
use serde_json::json;

/// The death of a node by a signal: a crash, or an external signal. Nodes handle the signals that ask them to end, so
/// none of them kills one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Death {
    node: String,
    /// `signal: 11 (SIGSEGV)`, and whether a core was dumped.
    signal: String,
    /// Time at which it was noticed.
    at: Instant<Machine>,
    /// The last lines of its log.
    last_lines: String,
}

impl Death {
    /// Absent if the node ended by itself: then it has an exit code.
    pub(super) fn of(
        node: &str,
        status: ExitStatus,
        at: Instant<Machine>,
        last_lines: impl FnOnce() -> String,
    ) -> Option<Self> {
        // On Unix a process has an exit code or the signal that killed it, never both.
        status.code().is_none().then(|| Self {
            node: node.to_owned(),
            signal: status.to_string(),
            at,
            last_lines: last_lines(),
        })
    }

    /// The invariant of processes that does not hold: in a run that began at `start`.
    pub(super) fn verdict(&self, start: Instant<Machine>) -> Verdict {
        let t_s = (self.at - start).as_secs_f64();
        Verdict {
            receiver: self.node.clone(),
            slave: None,
            field: format!("process at {t_s:.3} s"),
            expected: format!(
                "to run until the scenario ends it; the last lines of its log: {}",
                self.last_lines
            ),
            received: json!(format!("killed by {}", self.signal)),
            // A death is always a failure: nodes handle the signals by which a scenario ends them.
            met: false,
        }
    }
}

impl fmt::Display for Death {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            node,
            signal,
            last_lines,
            ..
        } = self;
        write!(f, "{node} was killed by {signal}: {last_lines}")
    }
}

#[cfg(test)]
mod tests {
    use coaxle_clock::Span;

    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn a_death_names_the_node_the_signal_when_and_the_last_lines() {
        use std::os::unix::process::ExitStatusExt;

        let start = Instant::EPOCH;
        let at = start + Span::from_millis(3_214);
        let of = |status| Death::of("saw", status, at, || "running / locked".to_owned());
        assert_eq!(of(ExitStatus::from_raw(1 << 8)), None);
        let death = of(ExitStatus::from_raw(11)).expect("a signal");
        assert_eq!(
            death.verdict(start).to_string(),
            "saw.process at 3.214 s is \"killed by signal: 11 (SIGSEGV)\", expected to run until the scenario ends it; the last \
             lines of its log: running / locked"
        );
        assert_eq!(
            death.to_string(),
            "saw was killed by signal: 11 (SIGSEGV): running / locked"
        );
    }
}
