//! The error of every cut: the tool's true meeting with the material, against the marks on it.

use coaxle_clock::{Instant, Span};
use coaxle_node::config::Unit;
use coaxle_receiver::SlaveConfig;
use coaxle_receiver::config::{MarksConfig, ToolConfig};
use coaxle_receiver::signals::SlaveSignals;

use super::moments::Moments;
use crate::row::Reference;
use crate::summary::{Cut, CutsSummary};

/// Follows the cuts of a slave.
#[derive(Debug)]
pub(super) struct CutsJudge {
    tool: ToolConfig,
    marks: Option<MarksConfig>,
    before: Option<SlaveCycle>,
    position_errors: Moments,
    length_errors: Moments,
    summary: CutsSummary,
}

/// A slave in one cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlaveCycle {
    pub(super) at: Instant<Reference>,
    /// Number of cuts so far in this run of the receiver.
    cuts: u64,
    /// Set position of the slave, u.
    slave: Option<f64>,
    /// Set position of its master, if that is a slave too, u.
    local_master: Option<f64>,
}

impl SlaveCycle {
    pub(super) fn new(slave: &SlaveSignals, at_ns: i64, local_master: Option<f64>) -> Self {
        Self {
            at: Instant::from_nanos(at_ns),
            cuts: slave.cuts,
            slave: slave.position,
            local_master,
        }
    }
}

/// Meeting of a tool with the material, at or beyond the slave's position 0.
#[derive(Clone, Copy, Debug)]
struct ToolContact {
    /// Time, from the cycle before (0) to this one (1).
    share: f64,
    /// Distance beyond the slave's position 0 along the material, u of the master.
    along: f64,
}

/// Truth as far as known.
pub(super) trait TrueMotion {
    /// True position of the far axis, u.
    fn far_position(&self, at: Instant<Reference>) -> Option<f64>;
    /// Time after the start of the run, s.
    fn time(&self, at: Instant<Reference>) -> f64;
}

impl CutsJudge {
    /// The judge of a slave whose master is in `unit`.
    pub(super) fn new(config: &SlaveConfig, unit: Unit) -> Self {
        Self {
            tool: config.tool,
            marks: config.marks,
            before: None,
            position_errors: Moments::default(),
            length_errors: Moments::default(),
            summary: CutsSummary {
                cut_unit: unit,
                ..CutsSummary::default()
            },
        }
    }

    /// Takes the next cycle. `follows_far`: the slave's master is the far axis.
    pub(super) fn push(&mut self, now: SlaveCycle, follows_far: bool, truth: &impl TrueMotion) {
        let before = self.before.replace(now).unwrap_or(now);
        // A restarted receiver counts from 0 again.
        let cuts = now.cuts.checked_sub(before.cuts).unwrap_or(now.cuts);
        if cuts == 0 {
            return;
        }
        self.summary.cuts += cuts;
        let meeting = self.meeting(&before, &now);
        let at = between(
            before.at,
            now.at,
            meeting.map_or(1.0, |meeting| meeting.share),
        );
        let position = meeting.and_then(|meeting| {
            let master = if follows_far {
                truth.far_position(at)?
            } else {
                let (from, to) = (before.local_master?, now.local_master?);
                from + meeting.share * (to - from)
            };
            Some(master - meeting.along)
        });
        self.note(truth.time(at), position);
    }

    /// Time of the cut. A tool that cuts by itself does so between two cycles, in which its drive moves
    /// in a straight line from one set position to the next.
    fn meeting(&self, before: &SlaveCycle, now: &SlaveCycle) -> Option<ToolContact> {
        let to = now.slave?;
        let Some(every) = self.tool.cuts_every else {
            return Some(ToolContact {
                share: 1.0,
                along: to / self.tool.ratio,
            });
        };
        let (from, every) = (before.slave?, every.get());
        // The last multiple of a turn that is not beyond the higher end, as the tool may turn either way.
        let passed = every * (from.max(to) / every).floor();
        // A tool that stands gives 0/0, which no range contains, and so no meeting.
        let share = (passed - from) / (to - from);
        (0.0..=1.0)
            .contains(&share)
            .then_some(ToolContact { share, along: 0.0 })
    }

    fn note(&mut self, t_s: f64, position: Option<f64>) {
        let mut cut = Cut {
            number: self.summary.cuts,
            t_s,
            position,
            mark: None,
            position_error: None,
            length_error: None,
        };
        if let (Some(marks), Some(position)) = (&self.marks, position) {
            let mark = marks.closest_to(position);
            let error = position - marks.position(mark);
            cut.mark = Some(mark);
            cut.position_error = Some(error);
            self.position_errors.push(error);
            // Only two successive cuts make a piece: where the one before is not known, neither is its length.
            let last = self.summary.cut_list.last();
            if let Some(before) = last.and_then(|last| last.position_error) {
                cut.length_error = Some(error - before);
                self.length_errors.push(error - before);
            }
        }
        self.summary.cut_list.push(cut);
    }

    pub(super) fn finish(mut self) -> CutsSummary {
        let summary = &mut self.summary;
        let known = |moments: &Moments, figure: fn(&Moments) -> f64| {
            // Extremes of no values are infinite.
            (moments.count > 0).then(|| figure(moments))
        };
        summary.cut_position_error_max = known(&self.position_errors, Moments::largest_magnitude);
        summary.cut_position_error_rms = known(&self.position_errors, Moments::root_mean_square);
        summary.cut_length_error_max = known(&self.length_errors, Moments::largest_magnitude);
        summary.cut_length_error_rms = known(&self.length_errors, Moments::root_mean_square);
        self.summary
    }
}

fn between(from: Instant<Reference>, to: Instant<Reference>, share: f64) -> Instant<Reference> {
    let way = (to - from).as_nanos() as f64 * share;
    // Truncated, cuts would be early by half a nanosecond in the mean.
    from + Span::from_nanos(way.round() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A far axis at a constant velocity, u/s.
    struct Uniform(f64);

    impl TrueMotion for Uniform {
        fn far_position(&self, at: Instant<Reference>) -> Option<f64> {
            Some(self.0 * self.time(at))
        }

        fn time(&self, at: Instant<Reference>) -> f64 {
            at.since_epoch().as_secs_f64()
        }
    }

    struct Unknown;

    impl TrueMotion for Unknown {
        fn far_position(&self, _at: Instant<Reference>) -> Option<f64> {
            None
        }

        fn time(&self, at: Instant<Reference>) -> f64 {
            at.since_epoch().as_secs_f64()
        }
    }

    fn slave(text: &str) -> SlaveConfig {
        coaxle_node::config::parse("slave", text).expect("a slave")
    }

    const KNIFE: &str = "tool = { cuts-every = 360 }\nmarks = { first = 600, spacing = 600, \
                         sensor-distance = 700 }";
    const MILLISECOND: i64 = 1_000_000;

    fn moment(at_ns: i64, cuts: u64, slave: f64) -> SlaveCycle {
        SlaveCycle {
            at: Instant::from_nanos(at_ns),
            cuts,
            slave: Some(slave),
            local_master: None,
        }
    }

    /// Cuts of a knife that turns once per 600 u, `ahead` of the far axis.
    fn knife(velocity: f64, ahead: f64, cycles: i64) -> CutsSummary {
        let mut judge = CutsJudge::new(&slave(KNIFE), Unit::default());
        for n in 0..cycles {
            let at_ns = n * MILLISECOND + 300_000;
            let far = velocity * at_ns as f64 * 1e-9;
            let position = (far + ahead) * 360.0 / 600.0;
            // Before 300, none was in sync.
            let cuts = (position / 360.0).floor().max(0.0) as u64;
            judge.push(moment(at_ns, cuts, position), true, &Uniform(velocity));
        }
        judge.finish()
    }

    proptest! {
        #[test]
        fn a_cut_between_two_cycles_is_exact_for_a_uniform_motion(
            velocity in 100.0..3_000.0,
            ahead in -1.0..1.0,
        ) {
            let summary = knife(velocity, ahead, 10_000);
            // The last of the 10 000 cycles is at 9.999 s, and each begins 0.3 ms late.
            let expected = ((velocity * 9.9993 + ahead) / 600.0).floor() as u64;
            prop_assert_eq!(summary.cuts, expected);
            prop_assert_eq!(summary.cut_list.len() as u64, expected);
            // An instant is a whole nanosecond.
            let resolution = velocity * 0.5e-9 + 1e-9;
            for cut in &summary.cut_list {
                prop_assert_eq!(cut.mark, Some(cut.number - 1));
                let error = cut.position_error.unwrap();
                prop_assert!((error + ahead).abs() <= resolution, "{:?}", cut);
            }
            if expected > 1 {
                prop_assert!(summary.cut_length_error_max.unwrap() <= 2.0 * resolution);
            }
        }
    }

    fn thousandths(error: f64) -> f64 {
        (1e3 * error).round()
    }

    #[test]
    fn a_piece_is_as_long_as_its_cuts_are_apart() {
        let saw = slave("tool.ratio = 2\nmarks = { spacing = 500, sensor-distance = 700 }");
        let mut judge = CutsJudge::new(&saw, Unit::default());
        // A saw at the far axis's position, then 0.002, then 0.005 u beyond it.
        for (n, off) in [(0, 0.0), (1, 0.002), (2, 0.005)] {
            let at_ns = (n * 500 + 40) * MILLISECOND;
            let position = 2.0 * (40.0 - off);
            judge.push(
                moment(at_ns - MILLISECOND, n as u64, 0.0),
                true,
                &Uniform(1e3),
            );
            judge.push(moment(at_ns, n as u64 + 1, position), true, &Uniform(1e3));
        }
        let summary = judge.finish();
        let errors: Vec<_> = summary
            .cut_list
            .iter()
            .map(|cut| (cut.mark, cut.position_error.map(thousandths)))
            .collect();
        let expected = [(0, 0.0), (1, 2.0), (2, 5.0)].map(|(n, e)| (Some(n), Some(e)));
        assert_eq!(errors, expected);
        assert_eq!(summary.cut_length_error_max.map(thousandths), Some(3.0));
    }

    #[test]
    fn of_a_local_master_its_own_set_position_is_the_truth() {
        let mut judge = CutsJudge::new(&slave(KNIFE), Unit::default());
        for (n, position, master, cuts) in [(0, 359.0, 599.0, 0), (1, 361.0, 603.0, 1)] {
            let now = SlaveCycle {
                local_master: Some(master),
                ..moment(n * MILLISECOND, cuts, position)
            };
            judge.push(now, false, &Unknown);
        }
        let summary = judge.finish();
        // Halfway from 359° to 361°, and so halfway from 599 to 603.
        assert_eq!(summary.cut_list[0].position, Some(601.0));
        assert_eq!(summary.cut_position_error_max, Some(1.0));
        assert_eq!(summary.cut_length_error_max, None);
        assert_eq!(summary.cut_list[0].t_s, 0.0005);
    }

    #[test]
    fn a_cut_is_counted_where_nobody_knows_where_it_was() {
        let without_marks = slave("tool = { cuts-every = 360 }");
        for config in [slave(KNIFE), without_marks] {
            let mut judge = CutsJudge::new(&config, Unit::default());
            judge.push(moment(0, 0, 359.0), true, &Unknown);
            judge.push(moment(MILLISECOND, 1, 361.0), true, &Unknown);
            let summary = judge.finish();
            assert_eq!(summary.cuts, 1);
            assert_eq!(summary.cut_list.len(), 1);
            assert_eq!(summary.cut_position_error_max, None);
        }
    }

    #[test]
    fn a_receiver_that_was_started_anew_counts_from_the_beginning() {
        let mut judge = CutsJudge::new(&slave(KNIFE), Unit::default());
        for (n, cuts) in [(0, 5), (1, 6), (2, 0), (3, 1)] {
            judge.push(moment(n * MILLISECOND, cuts, 0.0), true, &Unknown);
        }
        // 6 - 5 before the restart, and 1 after it.
        assert_eq!(judge.finish().cuts, 2);
    }
}
