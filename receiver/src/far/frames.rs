//! The axes of waiting frames: a few frames of them, for any number of waiting messages.
//!
//! Only the newest frame that a cycle takes in is needed with its axes, so few are kept. If more
//! wait, those that will not be needed are dropped: of all that the next cycle takes in, any but
//! the newest; of frames that an injected delay holds back over many cycles, some in between;
//! otherwise the first to arrive.

use coaxle_clock::{Instant, Local};
use coaxle_node::{AxisSample, Frame, FrameHeader, PresentAfter};

use super::held_back::{self, WaitingFrame};

/// Room for the axes of some frames.
#[derive(Debug)]
pub(super) struct Frames {
    axes: usize,
    /// Frame in each place.
    kept: Box<[Option<Kept>]>,
    /// Samples, place after place.
    samples: Box<[Option<AxisSample>]>,
}

#[derive(Clone, Copy, Debug)]
struct Kept {
    at: Instant<Local>,
    /// Start of the next cycle when it was kept.
    due: Instant<Local>,
    epoch: u64,
    count: u64,
    present_after: Option<PresentAfter>,
    /// True once a cycle has taken it in as a frame of the run that is followed.
    is_taken: bool,
}

/// A frame that a cycle has taken in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TakenFrame<'a> {
    pub(super) count: u64,
    pub(super) present_after: Option<PresentAfter>,
    pub(super) samples: &'a [Option<AxisSample>],
}

impl Kept {
    const fn waiting(&self) -> WaitingFrame {
        WaitingFrame {
            at: self.at,
            due: self.due,
            count: self.count,
        }
    }

    /// Order of two frames, the newer one last.
    fn age(&self, other: &Self) -> std::cmp::Ordering {
        if self.epoch == other.epoch {
            // Within a run the count decides, because messages overtake each other.
            self.count.cmp(&other.count)
        } else {
            // Counts of two runs have no common origin.
            self.at.cmp(&other.at)
        }
    }
}

impl Frames {
    /// Creates room for this number of frames and axes.
    pub(super) fn new(frames: usize, axes: usize) -> Self {
        Self {
            axes,
            kept: vec![None; frames].into(),
            samples: vec![None; frames * axes].into(),
        }
    }

    /// Keeps the axes of a frame that arrived at `at`, if they can still be needed. The next cycle
    /// takes in at least all that arrives until `due`.
    pub(super) fn keep(&mut self, at: Instant<Local>, frame: &Frame<'_>, due: Instant<Local>) {
        let new = Kept {
            at,
            due,
            epoch: frame.header.epoch,
            count: frame.header.count,
            present_after: frame.header.present_after,
            is_taken: false,
        };
        // A copy between slices of two lengths would panic.
        if frame.axes.len() != self.axes {
            return;
        }
        if let Some(place) = self.place_for(&new, due) {
            self.kept[place] = Some(new);
            self.at_mut(place).copy_from_slice(frame.axes);
        }
    }

    /// The axes of a frame, if they were kept.
    pub(super) fn find(&self, header: &FrameHeader) -> Option<&[Option<AxisSample>]> {
        self.place_of(header).map(|place| self.at(place))
    }

    /// Marks a frame that this cycle takes in.
    pub(super) fn take_in(&mut self, header: &FrameHeader) {
        if let Some(place) = self.place_of(header)
            && let Some(kept) = &mut self.kept[place]
        {
            kept.is_taken = true;
        }
    }

    /// The frames of a run that this cycle has taken in, in any order.
    pub(super) fn taken_in(&self, epoch: u64) -> impl Iterator<Item = TakenFrame<'_>> {
        let kept = (0..).zip(self.kept.iter());
        kept.filter_map(move |(place, kept)| {
            let kept = kept.filter(|kept| kept.is_taken && kept.epoch == epoch)?;
            Some(TakenFrame {
                count: kept.count,
                present_after: kept.present_after,
                samples: self.at(place),
            })
        })
    }

    fn place_of(&self, header: &FrameHeader) -> Option<usize> {
        let is_it = |kept: &Option<Kept>| {
            kept.is_some_and(|kept| kept.epoch == header.epoch && kept.count == header.count)
        };
        self.kept.iter().position(is_it)
    }

    /// Ends a cycle that took in all that arrived until `cycle_start`.
    pub(super) fn forget_until(&mut self, cycle_start: Instant<Local>) {
        for place in &mut self.kept {
            // Only what that cycle took in: a frame that arrived after its start belongs to the next one.
            let _ = place.take_if(|kept| kept.at <= cycle_start);
        }
    }

    /// A free place, or that of the least needed frame; none if that is the new one.
    fn place_for(&self, new: &Kept, due: Instant<Local>) -> Option<usize> {
        if let Some(free) = self.kept.iter().position(Option::is_none) {
            return Some(free);
        }
        let kept = || (0..).zip(self.kept.iter().flatten());
        // The next cycle has at most one image: of the frames that arrive until its start the newest.
        let is_due = |kept: &Kept| kept.at <= due;
        let all_due = kept().filter(|(_, kept)| is_due(kept));
        match all_due.min_by(|(_, a), (_, b)| a.age(b)) {
            // Two are due: the older one is not needed.
            Some((oldest, kept)) if is_due(new) => kept.age(new).is_lt().then_some(oldest),
            Some((oldest, _)) if kept().filter(|(_, kept)| is_due(kept)).count() > 1 => {
                Some(oldest)
            }
            // At most one is due, and the image of the next cycle is not given up for a later one.
            _ => {
                let later = || kept().filter(|(_, kept)| !is_due(kept));
                let waiting = later().map(|(place, kept)| (place, kept.waiting()));
                if let Some(spare) = held_back::spare(waiting, due) {
                    return Some(spare);
                }
                let (first, kept) =
                    later().min_by(|(_, a), (_, b)| a.at.cmp(&b.at).then_with(|| a.age(b)))?;
                (is_due(new) || kept.at <= new.at).then_some(first)
            }
        }
    }

    fn at(&self, place: usize) -> &[Option<AxisSample>] {
        let start = place * self.axes;
        &self.samples[start..start + self.axes]
    }

    fn at_mut(&mut self, place: usize) -> &mut [Option<AxisSample>] {
        let start = place * self.axes;
        &mut self.samples[start..start + self.axes]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::{CycleIndex, CycleTime, Span};

    fn at(micros: i64) -> Instant<Local> {
        Instant::EPOCH + Span::from_micros(micros)
    }

    fn header(count: u64) -> FrameHeader {
        FrameHeader {
            sender: 1,
            epoch: 1,
            index: CycleIndex::of_count(count),
            count,
            cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
            present_after: None,
            send_stamp: None,
        }
    }

    fn sample(count: u64) -> Option<AxisSample> {
        Some(AxisSample {
            error_code: count as u32,
            ..AxisSample::default()
        })
    }

    fn keep(frames: &mut Frames, micros: i64, count: u64, due: i64) {
        let frame = Frame {
            header: header(count),
            axes: &[sample(count), None],
        };
        frames.keep(at(micros), &frame, at(due));
    }

    fn counts(frames: &Frames) -> Vec<u64> {
        (0..2_000)
            .filter(|count| frames.find(&header(*count)).is_some())
            .collect()
    }

    #[test]
    fn axes_are_found_by_their_frame_until_their_cycle_is_over() {
        let mut frames = Frames::new(4, 2);
        keep(&mut frames, 900, 1, 1_000);
        keep(&mut frames, 1_100, 2, 1_000);
        assert_eq!(frames.find(&header(1)), Some(&[sample(1), None][..]));
        frames.forget_until(at(1_000));
        assert_eq!(counts(&frames), [2]);
    }

    #[test]
    fn all_frames_that_a_cycle_takes_in_are_given_with_their_axes() {
        let mut frames = Frames::new(8, 2);
        for count in 1..=4 {
            keep(&mut frames, 900, count, 1_000);
        }
        // Another run, and one that was not taken in.
        let other = Frame {
            header: FrameHeader {
                epoch: 2,
                ..header(9)
            },
            axes: &[sample(9), None],
        };
        frames.keep(at(900), &other, at(1_000));
        for count in [3, 1, 2] {
            frames.take_in(&header(count));
        }
        frames.take_in(&other.header);
        let taken: Vec<_> = frames.taken_in(1).collect();
        let expected = [1, 2, 3].map(|count| (count, [sample(count), None]));
        let expected = expected.each_ref().map(|(count, axes)| TakenFrame {
            count: *count,
            present_after: None,
            samples: axes,
        });
        assert_eq!(taken, expected);
        frames.forget_until(at(1_000));
        assert_eq!(frames.taken_in(1).count(), 0);
    }

    #[test]
    fn the_newest_of_all_that_are_due_is_never_given_up() {
        let mut frames = Frames::new(3, 2);
        for count in 0..1_000 {
            keep(&mut frames, 500, count, 1_000);
        }
        assert!(counts(&frames).contains(&999));
        // Later frames in any number leave it there.
        for count in 1_000..1_100 {
            keep(&mut frames, 1_001 + count as i64, count, 1_000);
        }
        let kept = counts(&frames);
        assert!(kept.len() == 3 && kept.contains(&1_099), "{kept:?}");
        assert!(kept.contains(&999), "{kept:?}");
    }

    #[test]
    fn the_only_one_that_is_due_stays_and_finds_room_among_later_ones() {
        for room in [1, 3] {
            // First, and then later ones in any number.
            let mut frames = Frames::new(room, 2);
            keep(&mut frames, 900, 1, 1_000);
            for count in 2..20 {
                keep(&mut frames, 1_000 + count as i64, count, 1_000);
            }
            assert!(counts(&frames).contains(&1), "{:?}", counts(&frames));
            // Last: it overtook those that arrive in later cycles.
            let mut frames = Frames::new(room, 2);
            for count in 2..20 {
                keep(&mut frames, 2_000 + count as i64, count, 1_000);
            }
            keep(&mut frames, 950, 1, 1_000);
            assert!(counts(&frames).contains(&1), "{:?}", counts(&frames));
        }
    }

    #[test]
    fn a_straggler_does_not_push_out_a_newer_one() {
        let mut frames = Frames::new(1, 2);
        keep(&mut frames, 500, 8, 1_000);
        keep(&mut frames, 600, 7, 1_000);
        assert_eq!(counts(&frames), [8]);
    }

    /// The longest run of cycles without a frame, when each of a frame per cycle is kept at once and due `latency`
    /// cycles later.
    fn longest_gap(frames: &mut Frames, latency: i64) -> i64 {
        let (mut renewed, mut longest) = (latency, 0);
        for cycle in 0..10 * latency {
            let now = 1_000 * cycle;
            keep(frames, now + 1_000 * latency, cycle as u64, now);
            if cycle >= latency {
                let is_renewed = frames.find(&header((cycle - latency) as u64)).is_some();
                if is_renewed {
                    renewed = cycle;
                }
                longest = longest.max(cycle - renewed);
            }
            frames.forget_until(at(now));
        }
        longest
    }

    #[test]
    fn frames_held_back_for_longer_than_there_is_room_still_renew_the_image() {
        for (room, latency, expected) in
            [(128, 100, 0), (128, 200, 1), (128, 1_000, 15), (8, 50, 15)]
        {
            let gap = longest_gap(&mut Frames::new(room, 2), latency);
            assert!(gap <= expected, "{room} {latency}: {gap}");
        }
    }
}
