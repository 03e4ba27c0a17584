//! Which run of a far node is followed: one decision, which inbox, clock and axes obey.
//!
//! A run is a start of the far node, told by its epoch, with one cycle time and a count that keeps pace with
//! the own clock. The first one is followed at once, and kept as long as it is heard. Another one takes over only
//! when it has come regularly and the one before is silent. A run that has ended comes back only when nothing
//! else was heard for long: it may have been taken over from while it was silent itself. Nor does one with the
//! epoch of the run that is followed, but another count or cycle time, take over sooner: within a run neither
//! changes. So a stray frame, one that is repeated for ever, a second node of the same name, or a frame that was
//! on its way for long, moves nothing.

use coaxle_clock::{CycleTime, Instant, Local, Span};
use coaxle_node::FrameHeader;

/// Its count may be ahead of what came with the least delay by so much: a delay may shrink, and a clock be stepped …
const AHEAD: f64 = 0.1;
/// … and by such a share of the time since then: no delay stays the least for ever.
const LEAK: f64 = 0.005;
/// It may be behind the newest frame by so much, s: a delay may grow, for a while.
const BEHIND: f64 = 1.0;
/// Another run must have come with so many frames, each with a later count, …
const REGULAR: u32 = 5;
/// … and the one that is followed be silent for so many of its cycles, and for so long, …
const SILENT_CYCLES: i64 = 4;
const SILENT: Span = Span::from_millis(10);
/// … or for so long, if both were heard at the same time: then it may be but a bad link.
const SILENT_RIVAL: Span = Span::from_secs(1);
/// A run that has ended, or another count in the epoch of the one that is followed, must have come for so long to be
/// more than what was left of it on its way, or was recorded of it.
const BACK: Span = Span::from_secs(1);
/// One that has not been heard for so long is no rival any more.
const FORGOTTEN: Span = Span::from_secs(1);
/// So many ended runs are remembered.
const ENDED: usize = 8;

/// What a frame is to its receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Admission {
    /// One of the run that is followed.
    Followed,
    /// The first of a run that is followed from now on.
    Begins,
    /// One of another run.
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

/// A run, and two of its frames.
#[derive(Clone, Copy, Debug)]
struct Run {
    epoch: u64,
    cycle_time: CycleTime,
    /// The newest.
    count: u64,
    at: Instant<Local>,
    /// The one that came with the least delay of late.
    least_delayed: (u64, Instant<Local>),
}

/// A run that is not followed, but might be.
#[derive(Clone, Copy, Debug)]
struct Other {
    run: Run,
    since: Instant<Local>,
    frames: u32,
    /// The run that is followed was heard since.
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

    /// Whether a frame can be one of it: not ahead of its time. One that is late may be on its way for long.
    fn has(&self, at: Instant<Local>, header: &FrameHeader) -> bool {
        let same = self.epoch == header.epoch && self.cycle_time == header.cycle_time;
        same && self.ahead_of(self.least_delayed, at, header) <= AHEAD + self.leak(at)
    }

    /// Whether it also keeps pace.
    fn goes_on_with(&self, at: Instant<Local>, header: &FrameHeader) -> bool {
        self.has(at, header) && self.ahead_of((self.count, self.at), at, header) >= -BEHIND
    }

    /// By how much the count is ahead of the time that has passed since a frame, s.
    fn ahead_of(
        &self,
        (count, since): (u64, Instant<Local>),
        at: Instant<Local>,
        header: &FrameHeader,
    ) -> f64 {
        let counted = header.count as f64 - count as f64;
        counted * self.cycle_time.as_secs_f64() - (at - since).as_secs_f64()
    }

    /// How much more than the least delay of late counts as that now, s.
    fn leak(&self, at: Instant<Local>) -> f64 {
        LEAK * (at - self.least_delayed.1).as_secs_f64().max(0.0)
    }

    fn take(&mut self, at: Instant<Local>, header: &FrameHeader) {
        if self.ahead_of(self.least_delayed, at, header) + self.leak(at) >= 0.0 {
            self.least_delayed = (header.count, at);
        }
        self.at = self.at.max(at);
        self.count = self.count.max(header.count);
    }
}

impl Other {
    /// Whether it has come for so long that it is no left-over of a run that ended.
    fn is_back(&self) -> bool {
        self.run.at - self.since >= BACK
    }
}

impl RunChoice {
    /// What a frame is that arrived at `at`.
    pub(super) fn judge(&mut self, at: Instant<Local>, header: &FrameHeader) -> Admission {
        let Some(followed) = &mut self.followed else {
            self.followed = Some(Run::of(at, header));
            return Admission::Begins;
        };
        if followed.goes_on_with(at, header) {
            followed.take(at, header);
            if let Some(other) = &mut self.other {
                other.is_rival = true;
            }
            return Admission::Followed;
        }
        let is_late = followed.has(at, header);
        if self.takes_over(at, header) {
            self.follow(at, header);
            return Admission::Begins;
        }
        if is_late {
            // A backlog of it, which whoever judges ages counts.
            return Admission::Followed;
        }
        self.foreign = self.foreign.saturating_add(1);
        Admission::Foreign
    }

    /// Whether a frame that arrives at `at` can be one of the run that is followed now.
    pub(super) fn can_be_followed(&self, at: Instant<Local>, header: &FrameHeader) -> bool {
        self.followed
            .is_none_or(|followed| followed.has(at, header))
    }

    /// Frames of other runs so far that were not followed.
    pub(super) const fn foreign(&self) -> u64 {
        self.foreign
    }

    /// Another run that is heard besides the one that is followed: a second node of the same name.
    pub(super) fn rival(&self, now: Instant<Local>) -> Option<u64> {
        let (followed, other) = (self.followed?, self.other?);
        let is_heard = other.frames >= REGULAR && now - other.run.at <= FORGOTTEN;
        // A backlog of the run that is followed is no second node.
        let is_other = other.is_rival && other.run.epoch != followed.epoch;
        let is_left_over = self.has_ended(other.run.epoch) && !other.is_back();
        (is_heard && is_other && !is_left_over).then_some(other.run.epoch)
    }

    /// Notes a frame of another run; whether that is the one to follow now.
    fn takes_over(&mut self, at: Instant<Local>, header: &FrameHeader) -> bool {
        let Some(followed) = self.followed else {
            return false;
        };
        let Some(other) = self.note(at, header) else {
            return false;
        };
        let regular = other.frames >= REGULAR
            && at - other.since >= other.run.cycle_time.span() * i64::from(REGULAR - 1) / 2;
        let is_old = self.has_ended(header.epoch) || header.epoch == followed.epoch;
        let longest = if other.is_rival || is_old {
            SILENT_RIVAL
        } else {
            SILENT.max(followed.cycle_time.span() * SILENT_CYCLES)
        };
        regular && at - followed.at >= longest && (!is_old || other.is_back())
    }

    /// The run that it is one of; none if another one is noted.
    fn note(&mut self, at: Instant<Local>, header: &FrameHeader) -> Option<Other> {
        let has_ended = self.has_ended(header.epoch);
        let other = match self.other {
            Some(mut other) if other.run.goes_on_with(at, header) => {
                let is_later = header.count > other.run.count;
                other.run.take(at, header);
                other.frames = other.frames.saturating_add(u32::from(is_later));
                other
            }
            // One that is heard is not given up for a stray frame of a third, but for a new run what is left of
            // an ended one is.
            Some(other)
                if at - other.run.at < other.run.cycle_time.span() * SILENT_CYCLES
                    && (has_ended || !self.has_ended(other.run.epoch)) =>
            {
                return None;
            }
            _ => Other {
                run: Run::of(at, header),
                since: at,
                frames: 1,
                is_rival: false,
            },
        };
        self.other = Some(other);
        Some(other)
    }

    fn follow(&mut self, at: Instant<Local>, header: &FrameHeader) {
        let before = self.followed.replace(Run::of(at, header));
        self.other = None;
        for ended in &mut self.ended {
            *ended = ended.filter(|epoch| *epoch != header.epoch);
        }
        if let Some(before) = before.filter(|before| before.epoch != header.epoch) {
            self.ended[self.next_ended] = Some(before.epoch);
            self.next_ended = (self.next_ended + 1) % ENDED;
        }
    }

    fn has_ended(&self, epoch: u64) -> bool {
        self.ended.contains(&Some(epoch))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Admission::{Begins, Followed, Foreign};
    use coaxle_clock::CycleIndex;

    fn header(epoch: u64, count: u64) -> FrameHeader {
        with_cycle_time(epoch, count, 1)
    }

    fn with_cycle_time(epoch: u64, count: u64, millis: i64) -> FrameHeader {
        FrameHeader {
            sender: 1,
            epoch,
            index: CycleIndex::of_count(count),
            count,
            cycle_time: CycleTime::new(Span::from_millis(millis)).unwrap(),
            send_stamp: None,
        }
    }

    fn at(millis: i64) -> Instant<Local> {
        Instant::EPOCH + Span::from_millis(millis)
    }

    /// A run from its count 0 at `start` on, a frame per millisecond; what its frames were.
    fn run(choice: &mut RunChoice, epoch: u64, start: i64, from: i64, to: i64) -> Vec<Admission> {
        let judged = (from..to).map(|now| {
            let header = header(epoch, (now - start) as u64);
            choice.judge(at(now), &header)
        });
        judged.collect()
    }

    #[test]
    fn the_first_run_is_followed_at_once() {
        let mut choice = RunChoice::default();
        let judged = run(&mut choice, 1, 0, 0, 100);
        assert_eq!(judged[0], Begins);
        assert!(judged[1..].iter().all(|one| *one == Followed));
    }

    #[test]
    fn a_new_run_takes_over_when_the_one_before_is_silent() {
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 100);
        let judged = run(&mut choice, 2, 100, 100, 200);
        let begins = judged.iter().position(|one| *one == Begins);
        assert_eq!(begins, Some(9), "silent for 10 ms");
        assert!(judged[10..].iter().all(|one| *one == Followed));
        // What is left of the first one on its way.
        assert_eq!(choice.judge(at(200), &header(1, 99)), Foreign);
        assert_eq!(choice.rival(at(200)), None);
    }

    #[test]
    fn a_second_node_is_named_and_not_followed_until_the_first_is_silent() {
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 100);
        for now in 100..3_000 {
            assert_eq!(choice.judge(at(now), &header(1, now as u64)), Followed);
            assert_eq!(choice.judge(at(now), &header(7, now as u64 + 50)), Foreign);
        }
        assert_eq!(choice.rival(at(3_000)), Some(7));
        let judged = run(&mut choice, 7, -50, 3_000, 5_000);
        let begins = judged.iter().position(|one| *one == Begins);
        assert_eq!(begins, Some(999), "after a second");
        // The first one is back: as a rival, but an ended one.
        assert_eq!(choice.judge(at(5_000), &header(1, 5_000)), Foreign);
        assert_eq!(choice.judge(at(5_000), &header(7, 5_050)), Followed);
    }

    #[test]
    fn a_run_that_was_taken_over_from_is_followed_again_when_nothing_else_is_heard() {
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 100);
        // It is silent for a while, and a second node takes over, beside which it goes on.
        assert!(run(&mut choice, 7, 100, 200, 300).contains(&Begins));
        for now in 300..2_000 {
            assert_eq!(
                choice.judge(at(now), &header(7, now as u64 - 100)),
                Followed
            );
            assert_eq!(choice.judge(at(now), &header(1, now as u64)), Foreign);
        }
        assert_eq!(choice.rival(at(2_000)), Some(1));
        let judged = run(&mut choice, 1, 0, 2_000, 4_000);
        let begins = judged.iter().position(|one| *one == Begins);
        assert_eq!(begins, Some(999), "after a second");
        assert!(judged[1_000..].iter().all(|one| *one == Followed));
        // It is taken over from again as any other.
        assert!(run(&mut choice, 8, 4_000, 4_010, 4_100).contains(&Begins));
    }

    #[test]
    fn what_is_left_of_an_ended_run_keeps_no_new_one_from_taking_over_and_is_no_rival() {
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 100);
        assert!(run(&mut choice, 2, 100, 110, 200).contains(&Begins));
        // The node is started a third time; frames of its first run come between.
        let mut begins = None;
        for now in 300..900 {
            assert_eq!(choice.judge(at(now), &header(1, now as u64 - 250)), Foreign);
            if choice.judge(at(now), &header(3, now as u64 - 300)) == Begins {
                begins = begins.or(Some(now - 300));
            }
            assert_eq!(choice.rival(at(now)), None);
        }
        assert_eq!(begins, Some(4));
    }

    #[test]
    fn a_second_node_that_falls_silent_is_forgotten() {
        let mut choice = RunChoice::default();
        for now in 0..100 {
            choice.judge(at(now), &header(1, now as u64));
            choice.judge(at(now), &header(7, now as u64));
        }
        assert_eq!(choice.rival(at(1_000)), Some(7));
        assert_eq!(choice.rival(at(1_200)), None);
    }

    #[test]
    fn stray_frames_move_nothing() {
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 100);
        for stray in [
            header(3, 5),
            header(1, 1_000_000_000_000),
            header(1, u64::MAX),
            with_cycle_time(1, 100, 2),
        ] {
            assert_eq!(choice.judge(at(100), &stray), Foreign);
        }
        assert_eq!(choice.judge(at(100), &header(1, 100)), Followed);
        // One while the node is silent for a while.
        assert_eq!(choice.judge(at(900), &header(3, 6)), Foreign);
        assert_eq!(choice.judge(at(901), &header(1, 901)), Followed);
    }

    #[test]
    fn a_count_that_is_ahead_of_all_that_came_is_no_frame_of_the_run() {
        for ahead in [150, 1_000, 100_000] {
            let mut choice = RunChoice::default();
            run(&mut choice, 1, 0, 0, 100);
            for now in 100..2_000 {
                let forged = header(1, (now + ahead) as u64);
                assert_eq!(choice.judge(at(now), &forged), Foreign);
                assert_eq!(choice.judge(at(now), &header(1, now as u64)), Followed);
            }
        }
    }

    #[test]
    fn a_delay_that_shrinks_or_was_long_for_a_while_is_none_of_another_run() {
        // Fifty milliseconds less than ever.
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 50, 50, 1_000);
        assert_eq!(run(&mut choice, 1, 0, 1_000, 3_000), vec![Followed; 2_000]);
        // Nine hundred more for three seconds, then as before.
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 1_000);
        let late = run(&mut choice, 1, 900, 1_900, 4_000);
        assert_eq!(late, vec![Followed; 2_100]);
        assert_eq!(run(&mut choice, 1, 0, 4_000, 5_000), vec![Followed; 1_000]);
    }

    #[test]
    fn a_clock_that_is_off_by_a_tenth_keeps_its_run() {
        for micros in [900, 1_100] {
            let mut choice = RunChoice::default();
            let judged = (0..100_000).map(|count| {
                let at = Instant::EPOCH + Span::from_micros(micros * count as i64);
                choice.judge(at, &header(1, count))
            });
            assert_eq!(judged.filter(|one| *one == Begins).count(), 1, "{micros}");
        }
    }

    #[test]
    fn a_backlog_is_left_to_who_judges_ages() {
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 100);
        for count in 100..3_000 {
            assert_eq!(choice.judge(at(3_100), &header(1, count)), Followed);
        }
        assert_eq!(choice.judge(at(3_100), &header(1, 3_100)), Followed);
    }

    #[test]
    fn a_backlog_is_no_second_node() {
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 100);
        for count in 100..3_000 {
            choice.judge(at(3_100), &header(1, count));
        }
        run(&mut choice, 1, 0, 3_100, 3_200);
        assert_eq!(choice.rival(at(3_200)), None);
    }

    #[test]
    fn a_stray_frame_does_not_take_over_in_place_of_a_new_run() {
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 100);
        let judged = run(&mut choice, 2, 100, 100, 109);
        assert!(judged.iter().all(|one| *one == Foreign), "not yet");
        // Now the first run is silent for long enough.
        assert_eq!(choice.judge(at(110), &header(3, 7)), Foreign);
        assert_eq!(choice.judge(at(110), &header(2, 10)), Begins);
    }

    #[test]
    fn another_cycle_time_or_count_is_followed_once_it_came_regularly_for_a_second() {
        for first in [5_000_000, 5] {
            let mut choice = RunChoice::default();
            let far = run(&mut choice, 1, -3_000_000, 0, 100);
            assert_eq!(far[99], Followed);
            let judged = run(&mut choice, 1, -first, 100, 2_100);
            let begins = judged.iter().position(|one| *one == Begins);
            assert_eq!(begins, Some(1_000));
            assert_eq!(judged[1_001..], vec![Followed; 999]);
        }
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 100);
        let judged = (0..1_000).map(|n| {
            let header = with_cycle_time(1, 50 + n as u64, 2);
            choice.judge(at(100 + 2 * n), &header)
        });
        let judged: Vec<_> = judged.collect();
        assert_eq!(judged.iter().position(|one| *one == Begins), Some(500));
        assert_eq!(judged[501..], vec![Followed; 499]);
    }

    #[test]
    fn a_frame_that_is_repeated_for_ever_is_no_run() {
        for (epoch, count) in [(1, 0), (1, 1_000_000), (2, 0)] {
            let mut choice = RunChoice::default();
            run(&mut choice, 1, 0, 0, 100);
            // While the run is silent, and no matter for how long.
            for now in 5_000..9_000 {
                let judged = choice.judge(at(now), &header(epoch, count));
                assert_ne!(judged, Begins, "{epoch} {count} at {now}");
            }
            assert_eq!(choice.judge(at(9_000), &header(1, 9_000)), Followed);
        }
    }

    #[test]
    fn of_two_others_the_one_that_is_heard_takes_over() {
        let mut choice = RunChoice::default();
        run(&mut choice, 1, 0, 0, 100);
        let mut begun = 0;
        for now in 100..200 {
            for epoch in [4, 5] {
                let judged = choice.judge(at(now), &header(epoch, now as u64));
                begun += u32::from(judged == Begins);
            }
        }
        assert_eq!(begun, 1);
        let now = at(200);
        assert!(choice.can_be_followed(now, &header(4, 200)));
        assert!(!choice.can_be_followed(now, &header(5, 200)));
    }
}
