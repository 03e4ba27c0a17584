//! `cyclictest` of rt-tests, beside our own figures where it is installed.

use std::io::ErrorKind;
use std::process::{Command, Stdio};

use anyhow::{Context, bail};
use coaxle_clock::Span;

/// Upper end of the histogram, µs.
// Nearly two hundred times the median of a busy virtual machine, 105 µs (docs/SPEED.md). The output has a line per µs.
const MOST_US: u32 = 20_000;

/// Runs it with one thread for this time. Returns the latencies, ns; none where it is not installed.
///
/// # Errors
/// It does not run, or its output cannot be read.
pub(super) fn run(
    cycle: Span,
    time: Span,
    priority: Option<u8>,
) -> anyhow::Result<Option<Vec<i64>>> {
    let mut command = Command::new("cyclictest");
    command
        // Without `--default-system` cyclictest forbids the processors to save power, which no node does.
        .args(["--quiet", "--threads=1", "--default-system"])
        .arg(format!("--interval={}", cycle.as_nanos() / 1_000))
        // At least one: cyclictest takes 0 for an endless run.
        .arg(format!("--loops={}", time.div_floor(cycle).max(1)))
        .arg(format!("--histogram={MOST_US}"))
        .args(priority.map(|priority| format!("--priority={priority}")))
        .stdin(Stdio::null());
    let output = match command.output() {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        // Any other error is a real one: only a missing program leaves the comparison out.
        output => output.context("cannot start cyclictest")?,
    };
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let line = said.lines().last().unwrap_or("it did not say why");
        bail!("cyclictest ended badly ({}): {line}", output.status);
    }
    measured(&String::from_utf8_lossy(&output.stdout)).map(Some)
}

/// The latencies of a histogram of whole microseconds, ns. Those beyond the histogram are all taken for the worst, which
/// alone is known.
fn measured(text: &str) -> anyhow::Result<Vec<i64>> {
    let mut latencies = Vec::new();
    let (mut most_us, mut beyond) = (0, 0);
    for line in text.lines() {
        if let Some(said) = line.strip_prefix("# Max Latencies:") {
            most_us = first_number(said).context("the worst latency")?;
        } else if let Some(said) = line.strip_prefix("# Histogram Overflows:") {
            beyond = first_number(said).context("the overflows")?;
        } else if !line.starts_with('#')
            && let Some((us, count)) = line.split_once(char::is_whitespace)
            && let (Some(us), Some(count)) = (first_number(us), first_number(count))
        {
            latencies.extend(std::iter::repeat_n(us * 1_000, count as usize));
        }
    }
    latencies.extend(std::iter::repeat_n(most_us * 1_000, beyond as usize));
    if latencies.is_empty() {
        bail!("received no histogram of cyclictest, expected one");
    }
    Ok(latencies)
}

fn first_number(text: &str) -> Option<i64> {
    let number = text.split_whitespace().next()?.parse().ok();
    // A latency below 0 would be a fault of the clock, and as a count it would become huge in `as usize`.
    number.filter(|number| *number >= 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As version 2.4 of rt-tests writes it.
    const SAID: &str = "\
# /dev/cpu_dma_latency set to 0us
# Histogram
000000 000000
000001 000002
000002 000000
000003 000001
# Total: 000000003
# Min Latencies: 00001
# Avg Latencies: 00162
# Max Latencies: 09519
# Histogram Overflows: 00002
# Histogram Overflow at cycle number:
# Thread 0: 00004 00008
";

    #[test]
    fn a_histogram_gives_every_latency() {
        assert_eq!(
            measured(SAID).unwrap(),
            [1_000, 1_000, 3_000, 9_519_000, 9_519_000]
        );
    }

    #[test]
    fn what_is_no_histogram_is_an_error() {
        for text in [
            "",
            "# Histogram\n",
            "000000 000000\n",
            "# Max Latencies: soon\n",
        ] {
            measured(text).unwrap_err();
        }
    }
}
