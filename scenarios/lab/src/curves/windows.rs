//! Parts of a run that are kept cycle by cycle: those around events.

use coaxle_axis::AxisStatus;

use crate::record::ReceiverCycle;

/// Event that is worth a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowEvent {
    /// The first message.
    Start,
    /// The clock is known.
    Sync,
    /// The clock is no longer known.
    SyncLost,
    /// A beat was counted.
    Beat,
    /// The delay jumped.
    Shift,
    /// The observer restarted its lock.
    Relock,
    /// Another node took over.
    TakeOver,
    /// Another run of the far node is followed.
    Restart,
    /// An error was raised.
    Error,
    /// A slave is in another state.
    SlaveState,
}

impl WindowEvent {
    /// In a few words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Start => "first data",
            Self::Sync => "lock-in",
            Self::SyncLost => "sync lost",
            Self::Beat => "beat",
            Self::Shift => "jump of the delay",
            Self::Relock => "locks anew",
            Self::TakeOver => "take-over",
            Self::Restart => "restart",
            Self::Error => "error",
            Self::SlaveState => "slave's state",
        }
    }

    /// Number of cycles kept before and after. A beat is counted a plateau later; a lock-in takes its time.
    const fn cycles(self) -> (f64, f64) {
        match self {
            // The second after sync is the lock-in, at cycles of a millisecond.
            Self::Sync => (500.0, 1_000.0),
            Self::Start => (20.0, 480.0),
            // A beat lies 90 cycles before its detection, with a blend of as many after it.
            _ => (400.0, 300.0),
        }
    }
}

/// A part of a run that is kept cycle by cycle, of every receiver.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveWindow {
    /// Beginning, s.
    pub from_s: f64,
    /// End, s.
    pub to_s: f64,
    /// Event that opened it.
    pub what: WindowEvent,
}

/// Signals of one receiver by which events are detected.
#[derive(Clone, Debug, Default)]
pub(super) struct EventWatch {
    had_data: bool,
    synced: bool,
    beats: u32,
    shifts: u32,
    relocks: u32,
    take_overs: u64,
    epoch: Option<u64>,
    error: u16,
    slaves: Vec<AxisStatus>,
    /// Number of windows for each kind of event.
    opened: Vec<(WindowEvent, u32)>,
}

/// Most windows for each kind of event of a receiver: the first ones show it as well as all.
const MOST_OF_A_KIND: u32 = 5;

impl EventWatch {
    /// Opens a window if an event happened in this cycle.
    pub(super) fn look(
        &mut self,
        t_s: f64,
        cycle_s: f64,
        record: &ReceiverCycle,
    ) -> Option<CurveWindow> {
        let what = self.event_of(record);
        self.remember(record);
        let what = what?;
        let known = self.opened.iter_mut().find(|(known, _)| *known == what);
        match known {
            Some((_, times)) if *times >= MOST_OF_A_KIND => return None,
            Some((_, times)) => *times += 1,
            None => self.opened.push((what, 1)),
        }
        let (before, after) = what.cycles();
        Some(CurveWindow {
            from_s: t_s - before * cycle_s,
            to_s: t_s + after * cycle_s,
            what,
        })
    }

    fn event_of(&self, record: &ReceiverCycle) -> Option<WindowEvent> {
        let (far, axis) = (&record.far, &record.axis);
        let slaves = record.slaves.iter().map(|slave| slave.state);
        // The first that applies names the window: a take-over brings another run and other counters with it.
        let all = [
            (!self.had_data && far.count.is_some(), WindowEvent::Start),
            (far.take_overs > self.take_overs, WindowEvent::TakeOver),
            (
                self.epoch.is_some() && far.epoch.is_some() && far.epoch != self.epoch,
                WindowEvent::Restart,
            ),
            (
                axis.error != 0 && axis.error != self.error,
                WindowEvent::Error,
            ),
            (axis.synced && !self.synced, WindowEvent::Sync),
            (!axis.synced && self.synced, WindowEvent::SyncLost),
            (far.relocks > self.relocks, WindowEvent::Relock),
            (far.shifts > self.shifts, WindowEvent::Shift),
            (far.beats > self.beats, WindowEvent::Beat),
            (
                self.had_data && !slaves.eq(self.slaves.iter().copied()),
                WindowEvent::SlaveState,
            ),
        ];
        let mut all = all.into_iter();
        all.find_map(|(is_so, what)| is_so.then_some(what))
    }

    fn remember(&mut self, record: &ReceiverCycle) {
        let (far, axis) = (&record.far, &record.axis);
        self.had_data |= far.count.is_some();
        self.synced = axis.synced;
        self.beats = far.beats;
        self.shifts = far.shifts;
        self.relocks = far.relocks;
        self.take_overs = far.take_overs;
        // A node that is silent for a while has no epoch, and may come back as another run.
        self.epoch = far.epoch.or(self.epoch);
        self.error = axis.error;
        self.slaves.clear();
        self.slaves
            .extend(record.slaves.iter().map(|slave| slave.state));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_each_kind_have_windows() {
        let mut watch = EventWatch::default();
        let mut record = ReceiverCycle::default();
        let mut windows = Vec::new();
        for cycle in 0..2_000_u32 {
            record.far.count = (cycle >= 10).then(|| u64::from(cycle));
            record.far.beats = cycle / 100;
            record.axis.synced = cycle >= 250;
            windows.extend(watch.look(1e-3 * f64::from(cycle), 1e-3, &record));
        }
        let whats: Vec<_> = windows.iter().map(|window| window.what).collect();
        let expected = [
            WindowEvent::Start,
            WindowEvent::Beat,
            WindowEvent::Beat,
            WindowEvent::Sync,
            WindowEvent::Beat,
            WindowEvent::Beat,
            WindowEvent::Beat,
        ];
        assert_eq!(whats, expected);
        let beat = &windows[1];
        // The first beat is at 0.1 s: 400 cycles before it, and 300 after it.
        assert!((beat.from_s + 0.3).abs() < 1e-9 && (beat.to_s - 0.4).abs() < 1e-9);
    }
}
