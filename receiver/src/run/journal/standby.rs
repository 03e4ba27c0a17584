//! Log events of take-overs and standbys.

use coaxle_remote::{AxisSyncParameters, FilterMode};

use super::{Level, Note};
use crate::config::ReceiverConfig;
use crate::signals::FarNodeSignals;
use crate::snapshot::ReceiverSnapshot;

/// A node received from.
#[derive(Debug)]
pub(super) struct Heard {
    pub(super) name: String,
    /// Number of the far node, or of the one that it stands by for.
    far: usize,
    pub(super) is_standby: bool,
    /// Own cycles without new data that the config permits: an order may have changed it, and cycle times raise it.
    pub(super) age_limit: u32,
    /// Those that an ordinary PC needs.
    pub(super) ordinary_limit: u32,
}

/// Every node received from, by its number.
pub(super) fn heard(config: &ReceiverConfig) -> Vec<Heard> {
    let cycle_time = config.cycle_time_us.0.span();
    let limit = |parameters: &AxisSyncParameters, mode| {
        parameters.age_limit(mode, cycle_time).unwrap_or_default()
    };
    let heard = config.received_nodes().into_iter();
    heard
        .map(|heard| Heard {
            name: heard.node.to_string(),
            far: heard.far,
            is_standby: heard.place > 0,
            age_limit: limit(&config.far[heard.far].sync, config.far[heard.far].mode),
            // What the observer bridges by default, for that very reason.
            ordinary_limit: limit(&AxisSyncParameters::default(), FilterMode::Observer),
        })
        .collect()
}

/// Log line on a take-over among a far node and its standbys, at the far node.
pub(super) fn taken_over(
    before: &ReceiverSnapshot,
    now: &ReceiverSnapshot,
    heard: &[Heard],
    n: usize,
) -> Option<Note> {
    let [was, is] = [before, now].map(|snapshot| &snapshot.signals.far);
    // All nodes of a group show the same count: only the node itself has the line.
    if heard[n].is_standby || is[n].take_overs <= was[n].take_overs {
        return None;
    }
    let name_in = |signals: &[FarNodeSignals]| {
        let mut nodes = heard.iter().zip(signals);
        let is_it = |(node, signals): &(&Heard, &FarNodeSignals)| {
            node.far == heard[n].far && signals.followed
        };
        nodes.find(is_it).map_or("", |(node, _)| &*node.name)
    };
    let (before, next) = (name_in(was), name_in(is));
    let text = format!("{next} takes over, for {before} is silent");
    Some(Note::new(Level::Warning, text))
}

/// Log line on a node that has become able to take over, or unable.
pub(super) fn standing_by(before: &FarNodeSignals, now: &FarNodeSignals) -> Option<Note> {
    // A node that takes over stands by no longer, which the line on the take-over says.
    if now.followed || now.stands_by == before.stands_by {
        return None;
    }
    Some(match now.stands_by {
        true => Note::new(Level::Info, "stands by"),
        false => Note::new(
            Level::Warning,
            "cannot take over: it is silent, or its clock is not known",
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::health::Health;
    use crate::run::journal::Journal;
    use coaxle_clock::{Instant, Span};
    use coaxle_node::config::parse;

    fn config() -> ReceiverConfig {
        let text = "name = 'saw'\ncycle-time-us = 1000\n\
                    [[far]]\nnode = 'line-a'\nstandby = ['line-b']\n[[far]]\nnode = 'press'";
        parse("r", text).unwrap()
    }

    /// The nodes are line-a, press and line-b.
    fn snapshot(followed: usize, stands_by: Option<usize>, health: Health) -> ReceiverSnapshot {
        let mut snapshot = ReceiverSnapshot::new(&config(), Instant::EPOCH);
        for (n, signals) in snapshot.signals.far.iter_mut().enumerate() {
            signals.followed = n == 1 || n == followed;
            signals.stands_by = Some(n) == stands_by;
            signals.take_overs = u64::from(followed == 2 && n != 1);
        }
        snapshot.far_health.fill(Health::Ok);
        snapshot.far_health[0] = health;
        snapshot
    }

    #[test]
    fn who_takes_over_and_stands_by_is_told_once() {
        let life = [
            snapshot(0, None, Health::NoStandby),
            snapshot(0, Some(2), Health::Ok),
            snapshot(2, None, Health::OnStandby),
            snapshot(2, Some(0), Health::OnStandby),
            snapshot(2, None, Health::OnStandby),
        ];
        let mut journal = Journal::new(&config());
        let mut told = Vec::new();
        for (k, snapshot) in (0..).zip(&life) {
            let at = |millis| Instant::EPOCH + Span::from_millis(millis);
            told.extend(journal.take(at(1_000 * k), snapshot));
            assert_eq!(journal.take(at(1_000 * k + 1), snapshot), []);
        }
        let told: Vec<_> = told.iter().map(|n| (n.level, n.text.as_str())).collect();
        assert_eq!(
            told,
            [
                (Level::Info, "line-a: ok"),
                (Level::Info, "line-b: stands by"),
                (
                    Level::Warning,
                    "line-a: line-b takes over, for line-a is silent"
                ),
                (Level::Info, "line-a: stands by"),
                (
                    Level::Warning,
                    "line-a: cannot take over: it is silent, or its clock is not known"
                ),
            ]
        );
    }
}
