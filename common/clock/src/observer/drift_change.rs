//! Messages that come later and later: attribution of the change, and restart of the line.

use super::events::{Attributed, DriftStep};
use super::far_line::FarLine;
use super::line::Estimate;
use super::stream::Line;
use super::{LARGEST_DRIFT, PhaseObserver};
use crate::instant::{Instant, Local, Seconds, Span};
use crate::numbers::rounded;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the attribution of a change of the drift.
    DriftChangeTuning {
        /// Time within which exchanges show the cause of a change of the drift, or nothing is done about it.
        longest_doubt: Span = Span::from_secs(3),
        /// Time within which a change must be seen again, or that of `seen_again_within_windows`, if longer.
        seen_again_within: Span = Span::from_millis(500),
        /// Windows of its scale within which it must be seen again.
        // One may be missed.
        seen_again_within_windows: f64 = 2.5,
        /// Time for which a change that is the path's is not suspected again.
        leave_drift_for: Span = Span::from_secs(1),
        /// Factor that makes a standard deviation of a doubt.
        // The uncertainty covers three of them.
        doubted: f64 = 0.4,
        /// Seconds of the change by which the line may be off until it is settled.
        unsettled: f64 = 0.3,
        /// Time for which the line is moved a little after the drift changed at once.
        settling: Span = Span::from_secs(2),
        /// Seconds of a wrong rate by which the line may be off.
        wrong_for: f64 = 1.0,
        /// Part of the window of before below which a change is seen on a finer scale.
        // Those are half as long.
        finer: f64 = 0.75,
        /// Part of the change of before from which it is that one …
        like_least: f64 = 0.5,
        /// … up to this multiple.
        like_greatest: f64 = 2.0,
    }
}

/// Messages come later and later, or earlier and earlier, than the line says. Either the sender's clock has another
/// drift, or the path's delay grows or shrinks.
#[derive(Clone, Copy, Debug)]
pub struct SuspectedDrift {
    /// Approximate beginning.
    pub since: Instant<Local>,
    /// Increase of the lateness per second, s/s.
    pub change: f64,
    /// The line that the last messages are on.
    pub line: FarLine,
}

/// Changes of the drift.
#[derive(Clone, Debug)]
pub(super) struct DriftChange {
    /// Number of changes at once.
    pub(super) steps: u32,
    /// Size of the last one, s/s.
    last: f64,
    /// See [`FarLine::taken_back`].
    pub(super) taken_back: Seconds,
    pub(super) attributed: Attributed,
    /// Time from which the line is taken for known again.
    pub(super) settled_from: Instant<Local>,
    suspect: Option<Suspect>,
    /// Change taken for the path's, and the end of that.
    left: Option<(SuspectedDrift, Instant<Local>)>,
}

impl DriftChange {
    pub(super) fn new() -> Self {
        Self {
            steps: 0,
            last: 0.0,
            taken_back: Seconds::ZERO,
            attributed: Attributed::default(),
            settled_from: Instant::from_nanos(i64::MIN),
            suspect: None,
            left: None,
        }
    }

    /// Forgets the suspicion, as another run begins.
    pub(super) fn forget_suspicion(&mut self) {
        self.suspect = None;
        self.left = None;
    }

    /// Change that is taken for the path's at that time.
    fn left_at(&self, at: Instant<Local>) -> Option<&SuspectedDrift> {
        let left = self.left.as_ref().filter(|(_, until)| at < *until);
        left.map(|(drift, _)| drift)
    }
}

/// A drift that may have changed.
#[derive(Clone, Debug)]
pub(super) struct Suspect {
    drift: SuspectedDrift,
    /// The change when it was `seen` last.
    step: DriftStep,
    noticed: Instant<Local>,
    seen: Instant<Local>,
}

impl Suspect {
    fn seen_again_within(&self) -> Span {
        TUNING.seen_again_within.max(Span::from_secs_f64(
            TUNING.seen_again_within_windows * self.step.window,
        ))
    }

    /// True if it is this change, seen again. A change seen in finer windows is younger.
    fn is_like(&self, step: &DriftStep) -> bool {
        let is_finer = step.window < TUNING.finer * self.step.window;
        !is_finer
            && (TUNING.like_least..TUNING.like_greatest)
                .contains(&(step.change / self.drift.change))
    }
}

impl PhaseObserver {
    /// Returns the suspected change that makes messages come later and later. As long as exchanges attribute it (see
    /// [`leave_steps_to_exchanges`](Self::leave_steps_to_exchanges)), nothing is done about it until
    /// [`attribute_drift`](Self::attribute_drift) is called.
    #[must_use]
    pub const fn suspected_drift(&self) -> Option<&SuspectedDrift> {
        match &self.drift_change.suspect {
            Some(suspect) => Some(&suspect.drift),
            None => None,
        }
    }

    /// Attributes the suspected change to the sender's clock, or to the path's delay.
    pub fn attribute_drift(&mut self, to_sender: bool) {
        let Some(suspect) = self.drift_change.suspect.take() else {
            return;
        };
        if to_sender {
            self.follow_drift_step(&suspect.step);
        } else {
            self.drift_change.left = Some((suspect.drift, suspect.seen + TUNING.leave_drift_for));
        }
    }

    /// Possible error of the line if the suspected change is the sender's, as a standard deviation, s.
    pub(super) fn drift_doubt(&self) -> f64 {
        let change = &self.drift_change;
        let Some(stream) = &self.stream else {
            return 0.0;
        };
        let now = stream.newest_arrival;
        let suspected = change.suspect.as_ref().map(|suspect| &suspect.drift);
        let doubted = match suspected.or(change.left_at(now)) {
            Some(drift) => {
                // The possible error grows with the time since the change began.
                let since = now - drift.since;
                libm::fabs(drift.change) * since.as_secs_f64().max(0.0)
            }
            None if now < change.settled_from => libm::fabs(change.last) * TUNING.unsettled,
            None => 0.0,
        };
        TUNING.doubted * doubted
    }

    /// Takes the newest phase. If the last ones lie on a line with another drift, exchanges attribute the change; without
    /// them it is the sender's.
    pub(super) fn suspect_drift_step(&mut self, time: f64, phase: f64, arrived: Instant<Local>) {
        if let Some(step) = self.take_drift_step(time, phase)
            && self.drift_change.left_at(arrived).is_none()
        {
            self.drift_change.suspect = self.suspicion(step, arrived);
        }
        let Some(suspect) = &self.drift_change.suspect else {
            return;
        };
        // First, as after a silence exchanges may not attribute it any more.
        if arrived - suspect.seen > suspect.seen_again_within() {
            self.drift_change.suspect = None;
        // Without exchanges far time follows the messages in any case.
        } else if !self.exchanges_tell {
            self.attribute_drift(true);
        // Doubt has an end: a path that goes on growing is suspected again a second later.
        } else if arrived - suspect.noticed > TUNING.longest_doubt {
            self.attribute_drift(false);
        }
    }

    /// Takes the newest phase; returns another drift if the last ones lie on a line with one.
    fn take_drift_step(&mut self, time: f64, phase: f64) -> Option<DriftStep> {
        let followed = self.followed()?;
        let stream = self.stream.as_mut()?;
        let ahead = time - followed.at as f64 * self.seconds_per_count;
        let Estimate { offset, drift, .. } = followed.estimate;
        let line = (offset + drift * ahead, drift);
        let cell = stream.resolution.cell().max(stream.resolution.polled());
        let step = stream.drift_steps.observe(time, phase, line, cell);
        // Before, the line is still being found.
        let is_plausible = |step: &DriftStep| libm::fabs(step.estimate.drift) < LARGEST_DRIFT;
        step.filter(|step| self.progress.is_synced() && is_plausible(step))
    }

    fn suspicion(&self, step: DriftStep, seen: Instant<Local>) -> Option<Suspect> {
        let before = self.drift_change.suspect.as_ref();
        let first_arrival = self.stream.as_ref()?.first_arrival;
        let since = first_arrival + Span::from_secs_f64(step.since + step.phase_then);
        let at = rounded(step.at / self.seconds_per_count);
        let drift = SuspectedDrift {
            since: match before {
                Some(before) if before.is_like(&step) => before.drift.since,
                _ => since,
            },
            change: step.change,
            line: self.line_of(&step.estimate, at)?,
        };
        Some(Suspect {
            drift,
            step,
            // Kept from the first notice, or a change that is seen again and again would be in doubt for ever.
            noticed: before.map_or(seen, |before| before.noticed),
            seen,
        })
    }

    /// Restarts both lines from the phases after the drift changed. The growth that the path's delay seemed to have
    /// meanwhile was the sender's clock.
    fn follow_drift_step(&mut self, step: &DriftStep) {
        let at = rounded(step.at / self.seconds_per_count);
        self.begin_line_anew(at, &step.estimate, step.change);
        self.take_back_since(step.since);
    }

    /// Leaves an edge that goes up again and again: the drift is another one, and was not noticed. Where that edge is followed, both lines
    /// restart from that of all messages.
    pub(super) fn leave_staircase(&mut self) {
        let stairs = (self.stream.as_ref()).and_then(|stream| stream.edge.staircase_from());
        let Some(since) = stairs else {
            return;
        };
        let found_again = self.new_edge();
        let Some(stream) = &mut self.stream else {
            return;
        };
        let edge = stream.edge.line().filter(|_| stream.choice.is_edge());
        if let (Some(edge), Some(line)) = (edge, &stream.line) {
            let (at, estimate) = (line.at, *line.bank.combined());
            let change = estimate.drift - edge.estimate.drift;
            self.begin_line_anew(at, &estimate, change);
            self.take_back_since(since);
        } else {
            stream.edge = found_again;
        }
    }

    /// Takes back the jumps since a time, s, that were taken for the path's.
    fn take_back_since(&mut self, time: f64) {
        let change = &mut self.drift_change;
        change.taken_back.0 += change.attributed.since(time);
        change.attributed.forget();
    }

    /// Follows a gain of the sender on the line per second, s/s, with this standard deviation, as exchanges prove it:
    /// both lines restart with that drift, from where they are.
    pub fn follow_drift(&mut self, gain: f64, sigma: f64) {
        let Some(followed) = self.followed() else {
            return;
        };
        let before = followed.estimate.drift;
        // Rates add, not drifts of phases: the rate of the far clock is 1/(1 + drift).
        let drift = 1.0 / (1.0 / (1.0 + before) + gain) - 1.0;
        // In this form a gain that is not a number is refused, too.
        if !(drift.abs() <= LARGEST_DRIFT && sigma.is_finite()) {
            return;
        }
        let off = self.jitter.width() + gain.abs() * TUNING.wrong_for;
        let estimate = Estimate {
            drift,
            offset_variance: off * off,
            // The offset is measured by messages and the drift by exchanges, whose errors are independent.
            covariance: 0.0,
            drift_variance: sigma * sigma,
            ..followed.estimate
        };
        self.drift_change.suspect = None;
        self.begin_line_anew(followed.at, &estimate, drift - before);
        // Jumps of before stay with the path: exchanges proved the rate, and nothing of those.
        self.drift_change.attributed.forget();
    }

    /// Restarts both lines from `estimate`, which is of the count `at`; the drift is another one by `change`.
    pub(super) fn begin_line_anew(&mut self, at: i64, estimate: &Estimate, change: f64) {
        let edge = self.new_edge();
        let Some(stream) = &mut self.stream else {
            return;
        };
        let Some(line) = &mut stream.line else {
            return;
        };
        line.at = at;
        line.bank.begin_anew(estimate);
        line.bounds = Line::bounds(&line.bank, &self.jitter);
        stream.filled = 0;
        stream.edge = edge;
        stream.choice.begin_anew();
        stream.calibration.begin_again();
        stream.drift_steps.forget_points();
        self.detector.clear();
        let of_drift = &mut self.drift_change;
        of_drift.steps = of_drift.steps.saturating_add(1);
        of_drift.last = change;
        of_drift.settled_from = stream.newest_arrival + TUNING.settling;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cycle::CycleTime;
    use crate::observer::ObserverParameters;

    /// Ten seconds of a level line, and then as much of a drift of 200 ppm as it takes until something is suspected. Returns
    /// the next count, too.
    fn suspicious() -> (PhaseObserver, u64) {
        let cycle = CycleTime::new(Span::from_millis(1)).unwrap();
        let mut observer = PhaseObserver::new(cycle, ObserverParameters::default()).unwrap();
        for count in 0..11_000 {
            observer.leave_steps_to_exchanges(true);
            observe(&mut observer, 7, count);
            if observer.suspected_drift().is_some() {
                assert!(count > 10_000 && observer.drift_doubt() > 0.0);
                return (observer, count + 1);
            }
        }
        panic!("nothing is suspected");
    }

    /// The next message, and the cycle after it.
    fn observe(observer: &mut PhaseObserver, epoch: u64, count: u64) {
        let late = count.wrapping_mul(2_654_435_761) >> 8 & 0x3fff;
        let drifted = 200 * count.saturating_sub(10_000);
        let nanos = 1_000_000 * count + late + drifted;
        let arrived = Instant::from_nanos(nanos as i64);
        observer.observe(epoch, count, arrived, None);
        let _ = observer.cycle(arrived + Span::from_micros(500));
    }

    #[test]
    fn what_exchanges_say_of_it_is_done() {
        let (mut observer, _) = suspicious();
        observer.attribute_drift(true);
        assert!(observer.suspected_drift().is_none());
        assert_eq!(observer.line().unwrap().drift_steps, 1);
        let (mut observer, count) = suspicious();
        observer.attribute_drift(false);
        observe(&mut observer, 7, count);
        assert!(observer.suspected_drift().is_none() && observer.drift_doubt() > 0.0);
        assert_eq!(observer.line().unwrap().drift_steps, 0);
    }

    #[test]
    fn what_exchanges_prove_is_followed_from_where_the_line_is() {
        let (mut observer, count) = suspicious();
        let at = Instant::from_nanos(1_000_000 * count as i64);
        let before = observer.line().unwrap();
        observer.follow_drift(-150e-6, 1e-6);
        let after = observer.line().unwrap();
        assert!((after.rate - before.rate + 150e-6).abs() < 1e-12);
        assert!(after.at(at).since(before.at(at).instant).0.abs() < 300e-6);
        assert_eq!(
            (after.drift_steps, after.synced),
            (before.drift_steps + 1, false)
        );
        assert!(observer.suspected_drift().is_none());
        // A rate that no clock has is not followed.
        for gain in [0.5, -0.5, f64::NAN, f64::INFINITY] {
            observer.follow_drift(gain, 1e-6);
        }
        let rate = observer.line().unwrap().rate;
        assert!((rate - after.rate).abs() < 1e-12);
    }

    #[test]
    fn where_a_rate_was_wrong_for_a_second_the_line_may_be_off_by_that() {
        for gain in [-500e-6, 500e-6] {
            let (mut observer, _) = suspicious();
            observer.follow_drift(gain, 1e-6);
            let variance = observer.followed().unwrap().estimate.offset_variance;
            let sigma = libm::sqrt(variance);
            assert!((450e-6..600e-6).contains(&sigma), "{gain}: {sigma}");
        }
    }

    #[test]
    fn a_change_that_is_half_or_twice_as_large_is_another_one() {
        let (observer, _) = suspicious();
        let suspect = observer.drift_change.suspect.clone().unwrap();
        let is_like = |times: f64| {
            suspect.is_like(&DriftStep {
                change: times * suspect.drift.change,
                ..suspect.step
            })
        };
        assert!(is_like(1.0) && is_like(0.55) && is_like(1.8));
        assert!(!is_like(0.45) && !is_like(2.2) && !is_like(-1.0));
    }

    #[test]
    fn doubt_ends_after_seconds_in_which_exchanges_say_nothing() {
        let (mut observer, first) = suspicious();
        let ends = (first..first + 10_000).find(|count| {
            observer.leave_steps_to_exchanges(true);
            observe(&mut observer, 7, *count);
            observer.suspected_drift().is_none()
        });
        let after = ends.expect("it ends") - first;
        assert!((2_500..3_500).contains(&after), "{after}");
        assert_eq!(observer.line().unwrap().drift_steps, 0);
    }

    #[test]
    fn a_change_of_long_windows_may_be_missed_in_one_of_them() {
        for (silence, is_suspected) in [(850, true), (1_150, false)] {
            let (mut observer, count) = suspicious();
            let suspect = observer.drift_change.suspect.as_mut().unwrap();
            suspect.step.window = 0.4;
            observer.leave_steps_to_exchanges(true);
            observe(&mut observer, 7, count + silence);
            let is_still = observer.suspected_drift().is_some();
            assert_eq!(is_still, is_suspected, "{silence} ms");
        }
    }

    #[test]
    fn what_was_suspected_before_a_silence_is_not_done_after_it() {
        let (mut observer, count) = suspicious();
        observer.leave_steps_to_exchanges(false);
        observe(&mut observer, 7, count + 4_000);
        assert!(observer.suspected_drift().is_none());
        assert_eq!(observer.line().unwrap().drift_steps, 0);
    }

    #[test]
    fn nothing_is_suspected_of_another_run() {
        for attribute in [false, true] {
            let (mut observer, count) = suspicious();
            if attribute {
                observer.attribute_drift(false);
            }
            observe(&mut observer, 8, count + 100);
            assert!(observer.suspected_drift().is_none());
            assert_eq!(observer.drift_doubt(), 0.0);
        }
    }
}
