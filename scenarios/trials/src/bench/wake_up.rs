//! Lateness of threads at wake-up: the cycle of a node, a bare loop, and cyclictest.

use coaxle_clock::Span;
use coaxle_host::machine::fitness;
use serde::Serialize;

use super::cyclictest;
use super::plan::{CycleStamps, PeerPlan};
use super::process::Process;
use super::quantiles::{MedianRatio, TimeQuantiles};
use super::settings::BenchSettings;
use super::turns::BenchProgress;

/// Lateness of wake-ups.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct WakeUp {
    /// Cycle thread of a node.
    pub(super) node: Option<TimeQuantiles>,
    /// A loop that only sleeps, with these very settings.
    pub(super) bare: Option<TimeQuantiles>,
    /// Results of cyclictest; absent where it is not installed.
    pub(super) cyclictest: Option<TimeQuantiles>,
    /// Our node over the bare loop.
    pub(super) node_over_bare: Option<MedianRatio>,
    /// Requests for real time that the system did not grant.
    pub(super) denied: Vec<String>,
}

/// A node, a bare loop, cyclictest.
const CONTENDERS: i64 = 3;

/// Time after which a node ends by itself if it is not ended.
// A limit for a parent that hangs; the node is ended as soon as its turn is over.
const PATIENCE: Span = Span::from_secs(30);

/// Planned time of the measurement.
pub(super) fn planned(settings: &BenchSettings) -> Span {
    settings.planned(CONTENDERS, Span::ZERO)
}

/// # Errors
/// A thread or cyclictest cannot be started, or Ctrl-C came.
pub(super) fn measure(
    settings: &BenchSettings,
    turns: &mut BenchProgress<'_>,
) -> anyhow::Result<WakeUp> {
    let turn = settings.turn(CONTENDERS);
    let (mut node, mut bare, mut other) = (Vec::new(), Vec::new(), Vec::new());
    let mut denied = Vec::new();
    for _ in 0..settings.rounds {
        node.push(of_node(settings, turn, turns)?);
        let measured = fitness::lateness(settings.cycle, turn, settings.real_time)?;
        bare.push(measured.late.iter().map(|late| late.as_nanos()).collect());
        denied = measured.denied;
        // Only afterwards, as the call returns when its loop has ended.
        turns.passed(turn)?;
        other.extend(cyclictest::run(
            settings.cycle,
            turn,
            settings.real_time.priority,
        )?);
        turns.passed(turn)?;
    }
    let all = |rounds: &[Vec<i64>]| TimeQuantiles::of(rounds.concat());
    Ok(WakeUp {
        node: all(&node),
        bare: all(&bare),
        cyclictest: all(&other),
        node_over_bare: MedianRatio::of(&node, &bare),
        denied: denied.iter().map(ToString::to_string).collect(),
    })
}

/// Lateness of a node's cycle thread, for each deadline.
fn of_node(
    settings: &BenchSettings,
    time: Span,
    turns: &mut BenchProgress<'_>,
) -> anyhow::Result<Vec<i64>> {
    let config = settings.nodes(1).sender(None)?;
    let plan = PeerPlan::SenderAlone { config };
    let node = Process::start("sender", &plan, time + PATIENCE, &[])?;
    turns.wait(time)?;
    Ok(lateness(&node.end()?.cycles, settings.cycle))
}

/// Lateness for every deadline, including those that a node skips as too late: the bare loop does not skip.
fn lateness(cycles: &[CycleStamps], cycle: Span) -> Vec<i64> {
    let mut late = Vec::with_capacity(cycles.len());
    let mut due = cycles.first().map(|first| first.ideal);
    for CycleStamps { ideal, woke, .. } in cycles {
        // Deadlines that a late cycle skipped are all met at its wake-up, each by its own lateness.
        let mut at = due.unwrap_or(*ideal);
        while at <= *ideal {
            late.push(woke - at);
            at += cycle.as_nanos();
        }
        due = Some(at);
    }
    late
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deadlines_that_a_node_skipped_were_missed_all_the_same() {
        let cycle = |(ideal, woke)| CycleStamps {
            count: 0,
            ideal,
            woke,
            handed_over: 0,
        };
        let cycles = [(100, 103), (110, 114), (140, 149)].map(cycle);
        let late = lateness(&cycles, Span::from_nanos(10));
        // The deadlines 120 and 130 were skipped, and are met with that of 140 at 149.
        assert_eq!(late, [3, 4, 29, 19, 9]);
        assert!(lateness(&[], Span::from_nanos(10)).is_empty());
    }
}
