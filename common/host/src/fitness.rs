//! How fit this PC is for cycles: what the operating system is set to, what it permits, and how late it wakes a thread.

use anyhow::Context;
use coaxle_clock::Span;
use coaxle_node::config::RealTimeConfig;

use crate::machine;
use crate::os::{Facts, Os, System};
use crate::real_time::{self, Denied};

/// Something about this PC.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Whether cycles profit from a change.
    pub is_good: bool,
    /// What it is.
    pub text: String,
    /// What would be better, and how.
    pub remedy: Option<&'static str>,
}

/// How late a thread was woken, beside an absolute time: the cycle of a node begins no earlier.
#[derive(Clone, Debug, PartialEq)]
pub struct WakeUps {
    /// How often.
    pub count: usize,
    /// Half of them were no later than this.
    pub median: Span,
    /// 999 of 1000 were not.
    pub nearly_all: Span,
    /// None was.
    pub most: Span,
    /// So many came a whole cycle late, or more: a node skips those.
    pub missed: usize,
    /// What the thread asked for and did not get.
    pub denied: Vec<Denied>,
}

/// The settings of this PC that matter.
#[must_use]
pub fn examine() -> Vec<Finding> {
    match Os::facts() {
        Some(facts) => findings(&facts),
        None => vec![unknown_system()],
    }
}

/// Wakes a thread with this cycle for so long, with the real-time priority that nodes are advised to have, if it is
/// permitted.
///
/// # Errors
/// The system gives no thread.
pub fn wake_ups(cycle: Span, time: Span, priority: Option<u8>) -> anyhow::Result<WakeUps> {
    let wishes = RealTimeConfig {
        priority,
        ..RealTimeConfig::default()
    };
    let Lateness { late, denied } = lateness(cycle, time, wishes)?;
    Ok(summary(late, cycle, denied))
}

/// How late each wake-up of a thread was that does nothing but sleep, to deadlines a cycle apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lateness {
    /// Of each deadline, in order. One that had passed before the thread could sleep counts, too.
    pub late: Vec<Span>,
    /// What the thread asked for and did not get.
    pub denied: Vec<Denied>,
}

/// Wakes a thread with this cycle for so long, as those wishes of a node would have it, in a bare loop: what no cycle can
/// beat here.
///
/// # Errors
/// The system gives no thread.
pub fn lateness(cycle: Span, time: Span, wishes: RealTimeConfig) -> anyhow::Result<Lateness> {
    let thread = std::thread::Builder::new().name("wake-ups".to_owned());
    let measuring = thread.spawn(move || measure(cycle, time, &wishes));
    let measured = measuring.context("cannot start a thread")?.join();
    measured.map_err(|_| anyhow::anyhow!("the measuring thread panicked"))
}

fn measure(cycle: Span, time: Span, wishes: &RealTimeConfig) -> Lateness {
    let denied = real_time::apply(wishes);
    let spin = Span::from_micros(i64::from(wishes.spin_us));
    let count = time.div_floor(cycle).max(1);
    let mut late = Vec::with_capacity(count as usize);
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
        let place = (part * (late.len() - 1) as f64).round() as usize;
        late.get(place).copied().unwrap_or(Span::ZERO)
    };
    WakeUps {
        count: late.len(),
        median: at(0.5),
        nearly_all: at(0.999),
        most: at(1.0),
        missed: late.iter().filter(|late| **late >= cycle).count(),
        denied,
    }
}

/// Clocks that are read without a call into the kernel.
const QUICK_CLOCKS: [&str; 3] = ["tsc", "kvm-clock", "arch_sys_counter"];
/// Enough for a node and what it maps.
const ENOUGH_MEMORY: u64 = 256 << 20;
/// What docs/SERVICE.md gives a node.
const WANTED_PRIORITY: u64 = 80;

fn unknown_system() -> Finding {
    Finding {
        is_good: false,
        text: format!(
            "nothing is known of how {} is set for cycles",
            std::env::consts::OS
        ),
        remedy: Some("for motion take Linux, best with PREEMPT_RT; docs/INSTALL.md"),
    }
}

fn findings(facts: &Facts) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut say = |is_good: bool, text: String, remedy: &'static str| {
        let remedy = (!is_good).then_some(remedy);
        findings.push(Finding {
            is_good,
            text,
            remedy,
        });
    };
    let kind = match facts.is_real_time_kernel {
        true => "with PREEMPT_RT",
        false => "without PREEMPT_RT",
    };
    say(
        facts.is_real_time_kernel,
        format!("kernel {} {kind}", facts.kernel),
        "a kernel with PREEMPT_RT (Debian: linux-image-rt-amd64) wakes threads within some 50 µs under any load",
    );
    if facts.is_virtual {
        let text = "a virtual machine: its host decides when it runs".to_owned();
        say(
            false,
            text,
            "for motion, use the machine itself; jumps and stops of the clock are the host's",
        );
    }
    let clock = &facts.clock_source;
    say(
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
    say(
        isolated || facts.processors < 4,
        format!("{} processors, isolated: {which}", facts.processors),
        "with four or more, keep one for the cycle: isolcpus=3 nohz_full=3 at boot, and cpu = 3 in [real-time]",
    );
    if !facts.governor.is_empty() {
        say(
            facts.governor == "performance",
            format!("frequency governor {}", facts.governor),
            "processors that slow down wake late: cpupower frequency-set -g performance",
        );
    }
    let priority = facts
        .priority
        .map_or("any".to_owned(), |most| most.to_string());
    say(
        facts.priority.is_none_or(|most| most >= WANTED_PRIORITY),
        format!("real-time priority up to {priority}"),
        "LimitRTPRIO=80 in the unit of the service, or rtprio 80 in /etc/security/limits.conf; docs/SERVICE.md",
    );
    let memory = facts.memory.map_or("all memory".to_owned(), |most| {
        format!("{} MiB", most >> 20)
    });
    say(
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
        let good = Facts {
            kernel: "6.12.1".to_owned(),
            is_real_time_kernel: true,
            is_virtual: false,
            clock_source: "tsc".to_owned(),
            processors: 8,
            isolated: "3".to_owned(),
            governor: "performance".to_owned(),
            priority: Some(99),
            memory: None,
        };
        let all = findings(&good);
        assert!(
            all.iter()
                .all(|finding| finding.is_good && finding.remedy.is_none()),
            "{all:?}"
        );
        let bad = Facts {
            is_virtual: true,
            clock_source: "hpet".to_owned(),
            processors: 8,
            governor: "powersave".to_owned(),
            priority: Some(0),
            memory: Some(8 << 20),
            ..Facts::default()
        };
        let all = findings(&bad);
        assert!(
            all.iter()
                .all(|finding| !finding.is_good && finding.remedy.is_some()),
            "{all:?}"
        );
        assert!(all.iter().any(|finding| finding.text.contains("hpet")));
        assert!(!examine().is_empty(), "of whatever machine this is");
    }

    #[test]
    fn wake_ups_are_sorted_into_usual_rare_and_missed_ones() {
        let late = (0..1_000).map(Span::from_micros).rev().collect();
        let all = summary(late, Span::from_micros(990), Vec::new());
        assert_eq!((all.count, all.missed), (1_000, 10));
        assert_eq!(
            (all.median, all.most),
            (Span::from_micros(500), Span::from_micros(999))
        );
        assert_eq!(all.nearly_all, Span::from_micros(998));
    }

    #[test]
    fn a_thread_is_woken_as_often_as_was_asked_and_never_early() {
        let all = wake_ups(Span::from_micros(500), Span::from_millis(20), None).unwrap();
        assert_eq!(all.count, 40);
        assert!(
            all.median > Span::ZERO && all.median <= all.nearly_all && all.nearly_all <= all.most
        );
    }
}
