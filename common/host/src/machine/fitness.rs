//! Fitness of this PC for cycles: the settings and permissions of the operating system, and the
//! latency of wake-ups.

use anyhow::Context;
use coaxle_clock::Span;
use coaxle_node::config::RealTimeConfig;
use coaxle_os::machine;
use coaxle_os::{Firewall, Os, System, SystemFacts};

use super::clocks;
pub use super::finding::{Finding, Severity};
use crate::machine::real_time::{self, Denied};

/// Latency of wake-ups against absolute deadlines: the cycle of a node begins no earlier.
#[derive(Clone, Debug, PartialEq)]
pub struct WakeUps {
    /// Number of wake-ups.
    pub count: usize,
    /// Median latency.
    pub median: Span,
    /// Latency not exceeded by 999 of 1000 wake-ups.
    pub nearly_all: Span,
    /// Greatest latency.
    pub most: Span,
    /// Number of wake-ups late by a whole cycle or more: a node skips those cycles.
    pub missed: usize,
    /// Settings that the thread requested and did not get.
    pub denied: Vec<Denied>,
}

/// Examines the settings of this PC that matter for cycles.
#[must_use]
pub fn examine() -> Vec<Finding> {
    let facts = Os::facts();
    let mut all = match &facts {
        Some(facts) => findings(facts),
        // Systems other than Linux have no facts that are read: a note is all that can be said.
        None => vec![unknown_system()],
    };
    all.extend(clocks::examine(facts.as_ref()));
    all.push(of_firewall(Os::firewall()));
    all
}

/// Measures wake-ups with this cycle for this time, at the real-time priority that nodes are
/// advised to have, if permitted.
///
/// # Errors
/// The thread cannot be started.
pub fn wake_ups(cycle: Span, time: Span, priority: Option<u8>) -> anyhow::Result<WakeUps> {
    let wishes = RealTimeConfig {
        priority,
        ..RealTimeConfig::default()
    };
    // Only the priority: the bare loop shows what a node gets without further settings.
    let Lateness { late, denied } = lateness(cycle, time, wishes)?;
    Ok(summary(late, cycle, denied))
}

/// Latency of each wake-up of a thread that only sleeps, to deadlines a cycle apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lateness {
    /// Latency per deadline, in order. A deadline that passed before the thread could sleep counts, too.
    pub late: Vec<Span>,
    /// Settings that the thread requested and did not get.
    pub denied: Vec<Denied>,
}

/// Measures wake-ups with this cycle for this time in a bare loop with these real-time settings:
/// the lower bound for any node here.
///
/// # Errors
/// The thread cannot be started.
pub fn lateness(cycle: Span, time: Span, wishes: RealTimeConfig) -> anyhow::Result<Lateness> {
    let thread = std::thread::Builder::new().name("wake-ups".to_owned());
    let measuring = thread.spawn(move || measure(cycle, time, &wishes));
    let measured = measuring.context("cannot start a thread")?.join();
    measured.map_err(|_| anyhow::anyhow!("the measuring thread panicked"))
}

fn measure(cycle: Span, time: Span, wishes: &RealTimeConfig) -> Lateness {
    let denied = real_time::apply(wishes);
    // The spin is the node's own setting: a measurement without it would judge another loop.
    let spin = Span::from_micros(i64::from(wishes.spin_us));
    let count = time.div_floor(cycle).max(1);
    // Reserved at the start: an allocation in the loop would be measured as lateness.
    let mut late = Vec::with_capacity(count as usize);
    // Deadlines are counted from here, not from the last wake-up: lateness would add up otherwise.
    let begin = machine::now();
    for k in 1..=count {
        let deadline = begin + cycle * k;
        machine::sleep_then_spin_until(deadline, spin);
        late.push(machine::now() - deadline);
    }
    Lateness { late, denied }
}

fn summary(mut late: Vec<Span>, cycle: Span, denied: Vec<Denied>) -> WakeUps {
    late.sort_unstable();
    let at = |part: f64| {
        // Rounded to the nearest rank: with up to 500 wake-ups that of 999 in 1000 is the greatest one.
        let place = (part * (late.len() - 1) as f64).round() as usize;
        late.get(place).copied().unwrap_or(Span::ZERO)
    };
    WakeUps {
        count: late.len(),
        median: at(0.5),
        nearly_all: at(0.999),
        most: at(1.0),
        // As late as a cycle: the next deadline has passed before the thread could sleep for it.
        missed: late.iter().filter(|late| **late >= cycle).count(),
        denied,
    }
}

/// Greatest start latency of a cycle, and that of 999 of 1000, as fractions of the cycle; the rest
/// of the cycle is for the node and the network.
// Half of the cycle is left for the scan, the put of some 20 µs, and the way of some 100 µs at 1 kHz.
const LATE_AT_MOST: f64 = 0.5;
// At 1 kHz 100 µs: an idle machine without PREEMPT_RT wakes within 44 µs (median) to 163 µs (p99) at FIFO.
const LATE_USUALLY: f64 = 0.1;

impl WakeUps {
    /// Judges whether cycles of this length can be kept here, with a remedy if not.
    #[must_use]
    pub fn judge(&self, cycle: Span) -> Finding {
        let part = |late: Span| late.as_secs_f64() / cycle.as_secs_f64();
        // Missed cycles first: a cycle that does not run is worse than any late one.
        let (severity, text) = if self.missed > 0 {
            let text = format!(
                "not fit for cycles of {cycle}: {} of {} were missed",
                self.missed, self.count
            );
            (Severity::Unfit, text)
        } else if part(self.most) > LATE_AT_MOST {
            let text = format!(
                "hardly fit for cycles of {cycle}: one began {} late",
                self.most
            );
            (Severity::Unfit, text)
        } else if part(self.nearly_all) > LATE_USUALLY {
            let text = format!(
                "fit for cycles of {cycle}, with jitter: one of 1000 begins {} late",
                self.nearly_all
            );
            (Severity::Note, text)
        } else {
            (Severity::Good, format!("fit for cycles of {cycle}"))
        };
        Finding {
            severity,
            text,
            remedy: (severity != Severity::Good).then(|| self.remedy()),
        }
    }

    /// The first remedy.
    fn remedy(&self) -> &'static str {
        // A denied priority is the cheapest cause to cure, so that it is named first.
        match self.denied.is_empty() {
            false => {
                "let nodes have a real-time priority, which this was denied: LimitRTPRIO=80 in the unit; docs/SERVICE.md"
            }
            true => {
                "see the notes above: a kernel with PREEMPT_RT, a processor for the cycle alone, less load; or a longer cycle"
            }
        }
    }
}

fn of_firewall(known: Result<Firewall, String>) -> Finding {
    let (severity, text, remedy) = match known {
        // Without a rule that drops, nothing is kept out.
        Ok(Firewall { sources, drops, .. }) if !drops => {
            let sources = sources.join(", ");
            (
                Severity::Good,
                format!("firewall: nothing is kept out ({sources})"),
                None,
            )
        }
        Ok(firewall) => {
            let text = format!(
                "firewall: what no rule names is kept out ({})",
                firewall.sources.join(", ")
            );
            let remedy = "`coaxle doctor CONFIG` says whether others reach the ports that a config listens on";
            (Severity::Note, text, Some(remedy))
        }
        Err(reason) => {
            let remedy =
                "with sudo it can be; what is not reached from another PC may be kept out here";
            (
                Severity::Note,
                format!("firewall: cannot be read ({reason})"),
                Some(remedy),
            )
        }
    };
    Finding {
        severity,
        text,
        remedy,
    }
}

/// Clocks that are read without a call into the kernel.
// Read in user space by the vDSO; hpet and acpi_pm need a register of a device.
const QUICK_CLOCKS: [&str; 3] = ["tsc", "kvm-clock", "arch_sys_counter"];
/// Enough for a node and its mappings.
// Eight times the 32 MiB of records that wait for telemetry.
const ENOUGH_MEMORY: u64 = 256 << 20;
/// Priority that docs/SERVICE.md gives a node.
// Above the threaded interrupts of the kernel, which have 50.
const WANTED_PRIORITY: u64 = 80;

fn unknown_system() -> Finding {
    Finding {
        severity: Severity::Note,
        text: format!(
            "nothing is known of how {} is set for cycles",
            std::env::consts::OS
        ),
        remedy: Some("for motion take Linux, best with PREEMPT_RT; docs/INSTALL.md"),
    }
}

fn findings(facts: &SystemFacts) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut add = |is_good: bool, text: String, remedy: &'static str| {
        let remedy = (!is_good).then_some(remedy);
        findings.push(Finding {
            severity: if is_good {
                Severity::Good
            } else {
                Severity::Note
            },
            text,
            remedy,
        });
    };
    let kind = match facts.is_real_time_kernel {
        true => "with PREEMPT_RT",
        false => "without PREEMPT_RT",
    };
    add(
        facts.is_real_time_kernel,
        format!("kernel {} {kind}", facts.kernel),
        "a kernel with PREEMPT_RT (Debian: linux-image-rt-amd64) wakes threads within some 50 µs under any load",
    );
    if facts.is_virtual {
        let text = "a virtual machine: its host decides when it runs".to_owned();
        // Nothing on this machine cures it: always a note.
        add(
            false,
            text,
            "for motion, use the machine itself; jumps and stops of the clock are the host's",
        );
    }
    let clock = &facts.clock_source;
    add(
        QUICK_CLOCKS.contains(&clock.as_str()),
        format!(
            "clock source {}",
            if clock.is_empty() { "unknown" } else { clock }
        ),
        "tsc is read in 20 ns, hpet and acpi_pm take a microsecond: see dmesg for why tsc was given up",
    );
    let isolated = !facts.isolated.is_empty();
    let which = if isolated {
        facts.isolated.as_str()
    } else {
        "none"
    };
    add(
        // With fewer than four none is spared: Zenoh receives and sends on two threads, and frames are published by a third.
        isolated || facts.processors < 4,
        format!("{} processors, isolated: {which}", facts.processors),
        "with four or more, keep one for the cycle: isolcpus=3 nohz_full=3 at boot, and cpu = 3 in [real-time]",
    );
    // Virtual machines and many small boards have no governor: an empty text is no fault.
    if !facts.governor.is_empty() {
        add(
            facts.governor == "performance",
            format!("frequency governor {}", facts.governor),
            "processors that slow down wake late: cpupower frequency-set -g performance",
        );
    }
    let priority = facts
        .priority
        .map_or("any".to_owned(), |most| most.to_string());
    add(
        // No limit is best: `None` stands for an unlimited resource.
        facts.priority.is_none_or(|most| most >= WANTED_PRIORITY),
        format!("real-time priority up to {priority}"),
        "LimitRTPRIO=80 in the unit of the service, or rtprio 80 in /etc/security/limits.conf; docs/SERVICE.md",
    );
    let memory = facts.memory.map_or("all memory".to_owned(), |most| {
        format!("{} MiB", most >> 20)
    });
    add(
        facts.memory.is_none_or(|most| most >= ENOUGH_MEMORY),
        format!("{memory} may be locked"),
        "LimitMEMLOCK=infinity in the unit of the service, or memlock in /etc/security/limits.conf",
    );
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_well_set_is_told_and_what_is_not_has_a_remedy() {
        let good = SystemFacts {
            kernel: "6.12.1".to_owned(),
            is_real_time_kernel: true,
            is_virtual: false,
            clock_source: "tsc".to_owned(),
            processors: 8,
            isolated: "3".to_owned(),
            governor: "performance".to_owned(),
            priority: Some(99),
            memory: None,
            card_clocks: Vec::new(),
        };
        let all = findings(&good);
        assert!(
            all.iter()
                .all(|finding| finding.severity == Severity::Good && finding.remedy.is_none()),
            "{all:?}"
        );
        let bad = SystemFacts {
            is_virtual: true,
            clock_source: "hpet".to_owned(),
            processors: 8,
            governor: "powersave".to_owned(),
            priority: Some(0),
            memory: Some(8 << 20),
            ..SystemFacts::default()
        };
        let all = findings(&bad);
        assert!(
            all.iter()
                .all(|finding| finding.severity == Severity::Note && finding.remedy.is_some()),
            "{all:?}"
        );
        assert!(all.iter().any(|finding| finding.text.contains("hpet")));
        assert!(!examine().is_empty(), "of whatever machine this is");
    }

    #[test]
    fn wake_ups_are_sorted_into_usual_rare_and_missed_ones() {
        // 0 to 999 µs, in reverse, so that a missing sort shows.
        let late = (0..1_000).map(Span::from_micros).rev().collect();
        let all = summary(late, Span::from_micros(990), Vec::new());
        // Ten of them are 990 µs or later.
        assert_eq!((all.count, all.missed), (1_000, 10));
        assert_eq!(
            (all.median, all.most),
            // Rank 0.5 · 999 = 499.5 is rounded up.
            (Span::from_micros(500), Span::from_micros(999))
        );
        // Rank 0.999 · 999 = 998.001.
        assert_eq!(all.nearly_all, Span::from_micros(998));
    }

    #[test]
    fn the_verdict_is_by_the_cycle_and_has_a_remedy() {
        let of = |late_us: &[i64]| {
            let late = late_us.iter().map(|us| Span::from_micros(*us)).collect();
            let cycle = Span::from_millis(1);
            summary(late, cycle, Vec::new()).judge(cycle)
        };
        for (late_us, severity, told) in [
            // Up to a tenth of a millisecond is good, up to half of it jitter, beyond that unfit.
            (&[3, 5, 40][..], Severity::Good, "fit for cycles of 1 ms"),
            (&[3, 5, 140], Severity::Note, "begins 140 µs late"),
            (&[3, 5, 700], Severity::Unfit, "one began 700 µs late"),
            (&[3, 5, 1_700], Severity::Unfit, "1 of 3 were missed"),
        ] {
            let verdict = of(late_us);
            assert_eq!(verdict.severity, severity, "{verdict:?}");
            assert!(verdict.text.contains(told), "{verdict:?}");
            assert_eq!(verdict.remedy.is_none(), severity == Severity::Good);
        }
    }

    #[test]
    fn a_firewall_is_told_of_and_one_that_cannot_be_read_too() {
        let open = of_firewall(Ok(Firewall::default()));
        assert_eq!((open.severity, open.remedy), (Severity::Good, None));
        let shut = Firewall {
            drops: true,
            ..Firewall::default()
        };
        assert_eq!(of_firewall(Ok(shut)).severity, Severity::Note);
        let unread = of_firewall(Err("nft: you must be root".to_owned()));
        assert!(unread.text.contains("you must be root"), "{unread:?}");
        assert!(unread.remedy.is_some());
    }

    #[test]
    fn a_thread_is_woken_as_often_as_was_asked_and_never_early() {
        let all = wake_ups(Span::from_micros(500), Span::from_millis(20), None).unwrap();
        // 20 ms in steps of 0.5 ms.
        assert_eq!(all.count, 40);
        // An order that holds on any machine. Bounds in microseconds would depend on its load.
        assert!(
            all.median > Span::ZERO && all.median <= all.nearly_all && all.nearly_all <= all.most
        );
    }
}
