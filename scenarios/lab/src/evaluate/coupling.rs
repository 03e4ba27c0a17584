//! Times and positions at which a slave is coupled and released.

use coaxle_axis::AxisStatus;
use coaxle_clock::Span;
use coaxle_receiver::signals::SlaveSignals;
use coaxle_slave::CouplingPhase;

use crate::summary::CouplingSummary;

/// Follows the phases of a slave's coupling.
#[derive(Debug, Default)]
pub(super) struct CouplingJudge {
    before: Option<CouplingCycle>,
    /// The synchronisation, or the release, under way.
    under_way: Option<CouplingPath>,
    summary: CouplingSummary,
}

/// A slave and its master in one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CouplingCycle {
    at_ns: i64,
    has_power: bool,
    phase: Option<CouplingPhase>,
    master: f64,
    slave: f64,
}

/// The way of a slave since a moment.
#[derive(Clone, Copy, Debug)]
struct CouplingPath {
    from: CouplingCycle,
    lowest: f64,
    highest: f64,
}

impl CouplingPath {
    fn between(from: &CouplingCycle, to: &CouplingCycle) -> Self {
        let way = Self {
            from: *from,
            lowest: from.slave,
            highest: from.slave,
        };
        way.and_to(to)
    }

    fn and_to(self, to: &CouplingCycle) -> Self {
        Self {
            lowest: self.lowest.min(to.slave),
            highest: self.highest.max(to.slave),
            ..self
        }
    }
}

/// Phases as counted: sync, and the way there, count before the master's synchronisation position as after it. A slave
/// that falls behind after sync is not synchronised again on catching up. Before its first sync, it is on its way.
const fn as_it_counts(phase: CouplingPhase, before: Option<CouplingPhase>) -> CouplingPhase {
    match (phase, before) {
        (CouplingPhase::InSyncBeforeSyncPosition, _)
        | (CouplingPhase::Behind, Some(CouplingPhase::InSync)) => CouplingPhase::InSync,
        (CouplingPhase::Behind | CouplingPhase::SynchronizingAfterSyncPosition, _) => {
            CouplingPhase::Synchronizing
        }
        _ => phase,
    }
}

impl CouplingJudge {
    /// Takes the next cycle; `master` is the slave's position of its master.
    pub(super) fn push(&mut self, at_ns: i64, master: Option<f64>, slave: &SlaveSignals) {
        // Without a position of both there is no way to measure. The last cycle with both stays the one before.
        let (Some(master), Some(position)) = (master, slave.position) else {
            return;
        };
        let before = self.before.and_then(|before| before.phase);
        let now = CouplingCycle {
            at_ns,
            has_power: slave.state != AxisStatus::Disabled,
            phase: slave.phase.map(|phase| as_it_counts(phase, before)),
            master,
            slave: position,
        };
        if let Some(before) = self.before.replace(now) {
            self.went_on(&before, &now);
        }
    }

    fn went_on(&mut self, before: &CouplingCycle, now: &CouplingCycle) {
        // Taken, so that each change of the phase ends the way unless it is put back.
        let way = self.under_way.take().map(|way| way.and_to(now));
        if before.phase == now.phase {
            self.under_way = way;
            return;
        }
        // A way begins with the cycle before its first one: a saw is coupled between the two.
        let last_step = CouplingPath::between(before, now);
        match (before.phase, now.phase) {
            // Its master turned round before it was released.
            (Some(CouplingPhase::Releasing), Some(CouplingPhase::InSync)) => {}
            (
                Some(CouplingPhase::Releasing),
                Some(CouplingPhase::Released | CouplingPhase::Waiting),
            ) => self.was_released(&way.unwrap_or(last_step), now),
            (Some(CouplingPhase::Synchronizing), Some(CouplingPhase::InSync)) => {
                self.came_in_sync(&way.unwrap_or(last_step), now);
            }
            // Coupled from the start, at any position.
            (_, Some(CouplingPhase::InSync)) if !before.has_power => {}
            // A coupling may be in sync at once, without a way there.
            (_, Some(CouplingPhase::InSync)) => self.came_in_sync(&last_step, now),
            _ => self.under_way = Some(last_step),
        }
    }

    fn came_in_sync(&mut self, way: &CouplingPath, now: &CouplingCycle) {
        let (from, summary) = (&way.from, &mut self.summary);
        summary.synchronisations += 1;
        summary.sync_duration_s = Some(Span::from_nanos(now.at_ns - from.at_ns).as_secs_f64());
        summary.sync_master_way = Some(now.master - from.master);
        summary.sync_slave_way = Some(now.slave - from.slave);
        summary.sync_master_position = Some(now.master);
        summary.sync_slave_position = Some(now.slave);
        summary.sync_position_min = Some(way.lowest);
        summary.sync_position_max = Some(way.highest);
    }

    fn was_released(&mut self, way: &CouplingPath, now: &CouplingCycle) {
        let (from, summary) = (&way.from, &mut self.summary);
        summary.release_master_way = Some(now.master - from.master);
        summary.release_slave_way = Some(now.slave - from.slave);
        summary.release_master_position = Some(now.master);
        summary.release_slave_position = Some(now.slave);
    }

    pub(super) const fn finish(self) -> CouplingSummary {
        self.summary
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slave in these phases, at half its master's way, a millisecond each.
    fn judged(course: &[(Option<CouplingPhase>, f64)]) -> CouplingSummary {
        let mut judge = CouplingJudge::default();
        for (n, (phase, master)) in course.iter().enumerate() {
            let slave = SlaveSignals {
                position: Some(0.5 * master),
                phase: *phase,
                state: AxisStatus::SynchronizedMotion,
                ..SlaveSignals::default()
            };
            judge.push(n as i64 * 1_000_000, Some(*master), &slave);
        }
        judge.finish()
    }

    #[test]
    fn a_synchronisation_counts_from_where_it_was_commanded() {
        let synchronizing = Some(CouplingPhase::Synchronizing);
        let summary = judged(&[
            (None, 8.0),
            (None, 10.0),
            (synchronizing, 12.0),
            (synchronizing, 14.0),
            (Some(CouplingPhase::InSync), 16.0),
            (Some(CouplingPhase::InSync), 18.0),
        ]);
        assert_eq!(
            summary,
            CouplingSummary {
                synchronisations: 1,
                // From the cycle at 10.0 on, the last one before the synchronisation: three cycles, and a way of 16 - 10.
                sync_duration_s: Some(0.003),
                sync_master_way: Some(6.0),
                sync_slave_way: Some(3.0),
                sync_master_position: Some(16.0),
                sync_slave_position: Some(8.0),
                sync_position_min: Some(5.0),
                sync_position_max: Some(8.0),
                ..CouplingSummary::default()
            }
        );
    }

    #[test]
    fn one_that_is_broken_off_does_not_count() {
        let summary = judged(&[
            (None, 10.0),
            (Some(CouplingPhase::Synchronizing), 12.0),
            (None, 14.0),
        ]);
        assert_eq!(summary, CouplingSummary::default());
    }

    #[test]
    fn one_that_falls_behind_is_not_synchronised_once_more() {
        let behind = Some(CouplingPhase::Behind);
        let in_sync = Some(CouplingPhase::InSync);
        let caught_up = judged(&[
            (None, 10.0),
            (Some(CouplingPhase::Synchronizing), 12.0),
            (behind, 14.0),
            (in_sync, 16.0),
            (behind, 18.0),
            (in_sync, 20.0),
        ]);
        assert_eq!(caught_up.synchronisations, 1);
        assert_eq!(caught_up.sync_duration_s, Some(0.003));
        assert_eq!(caught_up.sync_master_position, Some(16.0));
        let never_there = judged(&[(None, 10.0), (behind, 12.0), (behind, 14.0)]);
        assert_eq!(never_there, CouplingSummary::default());
    }

    #[test]
    fn what_couples_a_slave_from_the_start_does_not_count() {
        let mut judge = CouplingJudge::default();
        let off = SlaveSignals {
            position: Some(0.0),
            ..SlaveSignals::default()
        };
        judge.push(0, Some(500.0), &off);
        let coupled = SlaveSignals {
            position: Some(500.0),
            phase: Some(CouplingPhase::InSync),
            state: AxisStatus::SynchronizedMotion,
            ..SlaveSignals::default()
        };
        judge.push(1_000_000, Some(500.0), &coupled);
        assert_eq!(judge.finish(), CouplingSummary::default());
    }

    #[test]
    fn a_release_counts_when_the_slave_stands() {
        for stands in [CouplingPhase::Released, CouplingPhase::Waiting] {
            let summary = judged(&[
                (Some(CouplingPhase::InSync), 10.0),
                (Some(CouplingPhase::Releasing), 12.0),
                (Some(CouplingPhase::Releasing), 14.0),
                (Some(stands), 16.0),
            ]);
            assert_eq!(summary.release_master_way, Some(6.0));
            assert_eq!(summary.release_slave_position, Some(8.0));
        }
        let turned_round = judged(&[
            (None, 10.0),
            (Some(CouplingPhase::InSync), 10.0),
            (Some(CouplingPhase::Releasing), 12.0),
            (Some(CouplingPhase::InSync), 10.0),
        ]);
        assert_eq!(turned_round.release_master_way, None);
        assert_eq!(turned_round.synchronisations, 1);
    }
}
