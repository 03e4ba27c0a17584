//! Size of a trace, estimated before much is written.

use super::TraceFormat;
use crate::scenario::Scenario;
use crate::topology::Topology;

/// Bytes of a row with its slaves, as measured: `coaxle run beat`, and within a factor of two for others.
const fn row_bytes(format: TraceFormat) -> f64 {
    match format {
        TraceFormat::Mcap => 205.0,
        TraceFormat::Csv => 590.0,
    }
}

/// Size that is worth a warning.
// An hour of one receiver at 1 ms as MCAP is 740 MB. Ten seconds of `beat` with its four receivers are 8 MB.
const MUCH: f64 = 500e6;

/// Warning about the trace before the run, if it becomes large.
#[must_use]
pub fn warning(scenario: &Scenario, format: TraceFormat) -> Option<String> {
    let bytes = row_bytes(format) * rows(scenario)?;
    let gigabytes = bytes * 1e-9;
    (bytes > MUCH)
        .then(|| format!("its trace will take about {gigabytes:.1} GB; --no-trace leaves it out"))
}

/// Number of rows: one per cycle of a receiver and axis of it.
fn rows(scenario: &Scenario) -> Option<f64> {
    let topology = Topology::of(scenario).ok()?;
    let seconds = scenario.duration_s.get();
    let views = topology.views().iter();
    let cycles = views.map(|view| {
        let cycle = scenario.receivers[view.receiver].cycle_time_us.0.span();
        seconds / cycle.as_secs_f64()
    });
    Some(cycles.sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog;

    fn said(sets: &[&str], format: TraceFormat) -> Option<String> {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let scenario = catalog::find("beat").unwrap().read(&sets).unwrap();
        warning(&scenario, format)
    }

    #[test]
    fn a_trace_of_gigabytes_is_said_before() {
        assert_eq!(said(&["duration-s=10"], TraceFormat::Csv), None);
        // Four receivers, cycles of a millisecond.
        let day = said(&["duration-s=86400"], TraceFormat::Mcap);
        // 86 400 s · 1000/s · 4 · 205 bytes.
        let expected = "its trace will take about 70.8 GB; --no-trace leaves it out";
        assert_eq!(day.as_deref(), Some(expected));
    }
}
