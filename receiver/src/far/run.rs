//! The choice of a far node's run: one decision that inbox, clock and axes follow.
//!
//! A run is a start of the far node, identified by its epoch, with one cycle time and a count that
//! keeps pace with the own clock. The first one is followed at once, and kept as long as it is
//! received. Another one takes over only when it has arrived regularly and the previous one is
//! silent. A run that has ended returns only when no other was received for long: it may have been
//! taken over from while it was silent itself. Nor does one with the epoch of the run that is
//! followed, but another count or cycle time, take over sooner: within a run neither changes. Late
//! frames of the run that is followed are its backlog as long as they catch up with the time, or
//! any other arrives in time. So a stray frame, one repeated endlessly, a second node with this
//! name, a receiver that stood still, or a frame with a long delay has no effect.

use coaxle_clock::{CycleTime, Instant, Local, Span};
use coaxle_node::FrameHeader;

/// Largest lead of a count over the least delayed frame, s: a delay may shrink, and a clock be stepped …
const AHEAD: f64 = 0.1;
/// … and its growth per time since that frame: no delay stays the least permanently.
// Twice the largest pace that is followed (2 500 ppm), so that a fast sender never runs ahead of its own run.
const LEAK: f64 = 0.005;
/// Largest lag of a count behind the newest frame, s: a delay may grow, for a while.
// A later frame can still belong to the run, but shows no pace.
const BEHIND: f64 = 1.0;
/// Number of frames, each with a later count, after which another run is regular, …
const REGULAR: u32 = 5;
/// … number of cycles and time for which the one that is followed must be silent then, …
const SILENT_CYCLES: i64 = 4;
const SILENT: Span = Span::from_millis(10);
/// … and that time if both were received simultaneously: the link may only be bad.
const SILENT_RIVAL: Span = Span::from_secs(1);
/// Time for which a run that has ended, or another count in the epoch of the one that is followed,
/// must be received to be more than delayed or recorded frames of it.
const BACK: Span = Span::from_secs(1);
/// Late frames that gain this much on the time, s, are a backlog being drained: they are no regular run until they have
/// kept pace for [`BACK`]. Twice the jitter of a link that still counts as regular, a fortieth of the shortest backlog
/// that is beyond [`BEHIND`].
const CATCHES_UP: f64 = 0.025;
/// Time without frames after which a run is no duplicate any more.
const FORGOTTEN: Span = Span::from_secs(1);
/// Number of ended runs that are remembered.
const ENDED: usize = 8;

/// Class of a frame for its receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Admission {
    /// A frame of the run that is followed.
    Followed,
    /// The first of a run that is followed from now on.
    Begins,
    /// A frame of another run.
    Foreign,
}

/// The decision.
#[derive(Clone, Debug, Default)]
pub(super) struct RunChoice {
    followed: Option<Run>,
    other: Option<Other>,
    ended: [Option<u64>; ENDED],
    next_ended: usize,
    foreign: u64,
}

/// A frame, by its count and its arrival.
type Mark = (u64, Instant<Local>);

/// A run, and two of its frames.
#[derive(Clone, Copy, Debug)]
struct Run {
    epoch: u64,
    cycle_time: CycleTime,
    /// Newest count.
    count: u64,
    at: Instant<Local>,
    /// The frame with the least recent delay.
    least_delayed: Mark,
}

/// A run that is not followed, but might be.
#[derive(Clone, Copy, Debug)]
struct Other {
    run: Run,
    /// The frame since which it has kept pace.
    since: Mark,
    frames: u32,
    /// True if the run that is followed was received since.
    is_rival: bool,
}

impl Run {
    fn of(at: Instant<Local>, header: &FrameHeader) -> Self {
        Self {
            epoch: header.epoch,
            cycle_time: header.cycle_time,
            count: header.count,
            at,
            least_delayed: (header.count, at),
        }
    }

    /// True if a frame can belong to it: not ahead of its time. A late one may have had a long delay.
    fn has(&self, at: Instant<Local>, header: &FrameHeader) -> bool {
        let same = self.epoch == header.epoch && self.cycle_time == header.cycle_time;
        same && self.ahead_of(self.least_delayed, at, header) <= AHEAD + self.leak(at)
    }

    /// True if it also keeps pace.
    fn goes_on_with(&self, at: Instant<Local>, header: &FrameHeader) -> bool {
        self.has(at, header) && self.ahead_of((self.count, self.at), at, header) >= -BEHIND
    }

    /// Lead of the count over the time that has passed since a frame, s.
    fn ahead_of(&self, before: Mark, at: Instant<Local>, header: &FrameHeader) -> f64 {
        self.gained((before, (header.count, at)))
    }

    /// Gain of the counts of two frames over the time between them, s.
    fn gained(&self, ((before, since), (count, at)): (Mark, Mark)) -> f64 {
        // As floats, because the difference may be negative. Counts are exact there up to 2⁵³, which is 28 000 years
        // at 100 µs.
        let counted = count as f64 - before as f64;
        counted * self.cycle_time.as_secs_f64() - (at - since).as_secs_f64()
    }

    /// Delay beyond the least recent one that still counts as the least now, s.
    fn leak(&self, at: Instant<Local>) -> f64 {
        // Stamps of messages in a backlog may lie before that of the frame.
        LEAK * (at - self.least_delayed.1).as_secs_f64().max(0.0)
    }

    fn take(&mut self, at: Instant<Local>, header: &FrameHeader) {
        if self.ahead_of(self.least_delayed, at, header) + self.leak(at) >= 0.0 {
            self.least_delayed = (header.count, at);
        }
        // An overtaken frame moves neither the time nor the count back.
        self.at = self.at.max(at);
        self.count = self.count.max(header.count);
    }
}

impl Other {
    /// Creates a run of which only this frame is known.
    fn of(at: Instant<Local>, header: &FrameHeader) -> Self {
        Self {
            run: Run::of(at, header),
            since: (header.count, at),
            frames: 1,
            is_rival: false,
        }
    }

    fn take(&mut self, at: Instant<Local>, header: &FrameHeader) {
        let now = (header.count, at);
        self.frames = (self.frames).saturating_add(u32::from(header.count > self.run.count));
        self.run.take(at, header);
        if self.run.gained((self.since, now)) > CATCHES_UP {
            self.since = now;
        }
    }

    /// True if it is a backlog of the run that is followed: of one start, with one cycle time, and
    /// only later.
    fn is_backlog_of(&self, followed: &Run) -> bool {
        let (own, other) = (&self.run, followed);
        let same = (own.epoch, own.cycle_time) == (other.epoch, other.cycle_time);
        let newest = ((other.count, other.at), (own.count, own.at));
        same && own.gained(newest) <= 0.0
    }

    /// True if it has been received too long for a remainder of a run that ended.
    fn is_back(&self) -> bool {
        self.run.at - self.since.1 >= BACK
    }
}

impl RunChoice {
    /// Classifies a frame that arrived at `at`.
    pub(super) fn judge(&mut self, at: Instant<Local>, header: &FrameHeader) -> Admission {
        // A receiver without a run loses nothing by a wrong choice.
        let Some(followed) = &mut self.followed else {
            self.followed = Some(Run::of(at, header));
            return Admission::Begins;
        };
        // Before any other run is considered: a run that is received cannot be taken over from.
        if followed.goes_on_with(at, header) {
            followed.take(at, header);
            self.other = self.other.filter(|other| !other.is_backlog_of(followed));
            if let Some(other) = &mut self.other {
                other.is_rival = true;
            }
            return Admission::Followed;
        }
        // Determined before a change, which replaces the run that it compares with.
        let is_late = followed.has(at, header);
        if self.takes_over(at, header) {
            self.follow(at, header);
            return Admission::Begins;
        }
        if is_late {
            // A backlog of it, which the age gate counts.
            return Admission::Followed;
        }
        self.foreign = self.foreign.saturating_add(1);
        Admission::Foreign
    }

    /// True if a frame that arrives at `at` can belong to the run that is followed now.
    pub(super) fn can_be_followed(&self, at: Instant<Local>, header: &FrameHeader) -> bool {
        self.followed
            .is_none_or(|followed| followed.has(at, header))
    }

    /// Number of frames of other runs up to now that were not followed.
    pub(super) const fn foreign(&self) -> u64 {
        self.foreign
    }

    /// Another run that is received simultaneously with the one that is followed: a second node
    /// with this name.
    pub(super) fn rival(&self, now: Instant<Local>) -> Option<u64> {
        let (followed, other) = (self.followed?, self.other?);
        let is_heard = other.frames >= REGULAR && now - other.run.at <= FORGOTTEN;
        // A backlog of the run that is followed is no second node.
        let is_other = other.is_rival && other.run.epoch != followed.epoch;
        let is_left_over = self.has_ended(other.run.epoch) && !other.is_back();
        (is_heard && is_other && !is_left_over).then_some(other.run.epoch)
    }

    /// Notes a frame of another run; true if that run is to be followed now.
    fn takes_over(&mut self, at: Instant<Local>, header: &FrameHeader) -> bool {
        let Some(followed) = self.followed else {
            return false;
        };
        let Some(other) = self.note(at, header) else {
            return false;
        };
        let regular = other.frames >= REGULAR
            // A burst brings five frames at once. Regular ones take four cycles, here at least half of them.
            && at - other.since.1 >= other.run.cycle_time.span() * i64::from(REGULAR - 1) / 2;
        let is_old = self.has_ended(header.epoch) || header.epoch == followed.epoch;
        // A rival means that the link of the first may be bad, and an old run that its frames may be left over.
        let longest = if other.is_rival || is_old {
            SILENT_RIVAL
        } else {
            SILENT.max(followed.cycle_time.span() * SILENT_CYCLES)
        };
        regular && at - followed.at >= longest && (!is_old || other.is_back())
    }

    /// The run of the frame; none if another run is noted.
    fn note(&mut self, at: Instant<Local>, header: &FrameHeader) -> Option<Other> {
        let has_ended = self.has_ended(header.epoch);
        let other = match self.other {
            // After too long a silence it has not kept pace.
            Some(mut other)
                if other.run.goes_on_with(at, header) && at - other.run.at <= FORGOTTEN =>
            {
                other.take(at, header);
                other
            }
            // A run that is received is not replaced for a stray frame of a third, but remainders
            // of an ended one are for a new run.
            Some(other)
                if at - other.run.at < other.run.cycle_time.span() * SILENT_CYCLES
                    && (has_ended || !self.has_ended(other.run.epoch)) =>
            {
                return None;
            }
            _ => Other::of(at, header),
        };
        self.other = Some(other);
        Some(other)
    }

    fn follow(&mut self, at: Instant<Local>, header: &FrameHeader) {
        let before = self.followed.replace(Run::of(at, header));
        self.other = None;
        // A run that is followed again has not ended.
        for ended in &mut self.ended {
            *ended = ended.filter(|epoch| *epoch != header.epoch);
        }
        if let Some(before) = before.filter(|before| before.epoch != header.epoch) {
            // A ring of fixed size: nothing allocates on the cycle path.
            self.ended[self.next_ended] = Some(before.epoch);
            self.next_ended = (self.next_ended + 1) % ENDED;
        }
    }

    fn has_ended(&self, epoch: u64) -> bool {
        self.ended.contains(&Some(epoch))
    }
}

#[cfg(test)]
mod tests;
