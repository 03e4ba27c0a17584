//! Properties of a Linux system.

use std::fs;
use std::path::Path;

use rustix::process::{Resource, getrlimit};

use crate::SystemFacts;

pub(super) fn read() -> SystemFacts {
    let version = line("/proc/sys/kernel/version");
    let processors = std::thread::available_parallelism();
    SystemFacts {
        kernel: line("/proc/sys/kernel/osrelease"),
        // Kernels with the patch also have a file, whatever their version says.
        is_real_time_kernel: version.contains("PREEMPT_RT") || line("/sys/kernel/realtime") == "1",
        // A flag of the processor on x86; other hypervisors have a folder.
        is_virtual: line("/proc/cpuinfo").contains(" hypervisor")
            || Path::new("/sys/hypervisor/type").exists(),
        clock_source: line("/sys/devices/system/clocksource/clocksource0/current_clocksource"),
        processors: processors.map_or(1, usize::from),
        isolated: line("/sys/devices/system/cpu/isolated"),
        governor: line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"),
        priority: getrlimit(Resource::Rtprio).current,
        memory: getrlimit(Resource::Memlock).current,
        card_clocks: card_clocks(),
    }
}

/// Lists the clocks that PTP can discipline, as the kernel has them.
fn card_clocks() -> Vec<String> {
    let folder = "/sys/class/ptp";
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut clocks: Vec<_> = entries
        .map(|entry| {
            let device = entry.file_name().display().to_string();
            let name = line(&format!("{folder}/{device}/clock_name"));
            format!("{device} ({name})")
        })
        .collect();
    clocks.sort();
    clocks
}

fn line(path: &str) -> String {
    let text = fs::read_to_string(path).unwrap_or_default();
    text.trim().to_owned()
}
