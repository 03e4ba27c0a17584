use super::*;

/// Judges both lines once per look.
struct Looks {
    choice: Choice,
    number: u32,
    /// Amplitude of the line of all messages, and depth of the edge below it, s.
    wobble: f64,
    below: f64,
    edge_variance: f64,
    largest_carry: f64,
}

const AT_MOST: f64 = 50e-6;

impl Looks {
    fn new() -> Self {
        Self {
            choice: Choice::new(),
            number: 0,
            wobble: 8e-6,
            below: 20e-6,
            edge_variance: 1e-14,
            largest_carry: AT_MOST,
        }
    }

    const fn estimate(offset: f64, offset_variance: f64) -> Estimate {
        Estimate {
            offset,
            drift: 0.0,
            offset_variance,
            covariance: 0.0,
            drift_variance: 1e-16,
        }
    }

    /// Looks for half a minute, long enough for a late change.
    fn settle(&mut self) {
        for _ in 0..60 {
            let _ = self.look();
        }
    }

    /// Lines of which the edge is followed, as delays came to be correlated.
    fn on_the_edge() -> Self {
        let mut looks = Self::new();
        looks.settle();
        looks.choice.assume_correlated();
        let _ = looks.until_changed();
        assert!(looks.choice.is_edge());
        looks
    }

    /// Offset of the line of all messages at the last look.
    fn all(&self) -> f64 {
        let turn = core::f64::consts::TAU * f64::from(self.number) / 16.0;
        self.wobble * libm::sin(turn)
    }

    fn look(&mut self) -> f64 {
        self.number += 1;
        let time = 0.5 * f64::from(self.number);
        let all = Self::estimate(self.all(), 1e-14);
        let edge = edge::Line {
            at: time,
            estimate: Self::estimate(-self.below, self.edge_variance),
        };
        self.choice
            .judge(time, time, &all, &edge, self.largest_carry)
    }

    /// Offset of the line that is followed.
    fn offset(&self) -> f64 {
        let line = if self.choice.is_edge() {
            -self.below
        } else {
            self.all()
        };
        line + self.choice.carry()
    }

    /// Looks until the line is changed; returns the number of looks, and the jump of the last.
    fn until_changed(&mut self) -> (u32, f64) {
        let (before, first) = (self.choice.is_edge(), self.number);
        loop {
            let jump = self.look();
            if self.choice.is_edge() != before {
                return (self.number - first, jump);
            }
            assert_eq!(jump, 0.0);
            assert!(self.number - first < 1_000, "never");
        }
    }
}

#[test]
fn independent_messages_are_followed_however_they_wobble() {
    let mut looks = Looks::new();
    for _ in 0..200 {
        assert_eq!(looks.look(), 0.0);
        assert!(!looks.choice.is_edge());
    }
}

#[test]
fn correlated_messages_are_followed_where_they_are_steadier() {
    let mut looks = Looks {
        wobble: 0.0,
        ..Looks::new()
    };
    for _ in 0..40 {
        let _ = looks.look();
    }
    looks.choice.assume_correlated();
    for _ in 0..100 {
        assert_eq!(looks.look(), 0.0);
        assert!(!looks.choice.is_edge());
    }
}

#[test]
fn as_long_as_nothing_is_known_the_edge_is_followed_at_once() {
    let mut looks = Looks::new();
    let _ = looks.look();
    looks.choice.assume_correlated();
    let before = looks.choice.carry() + looks.all();
    let (waited, jump) = looks.until_changed();
    assert_eq!(waited, 1);
    assert_eq!(looks.choice.carry(), 0.0);
    let step = looks.offset() - before;
    assert!((jump - step).abs() < looks.wobble, "{jump} {step}");
}

#[test]
fn a_late_change_hesitates_and_carries_the_offset_over() {
    let mut looks = Looks::new();
    looks.settle();
    looks.choice.assume_correlated();
    let (waited, jump) = looks.until_changed();
    assert_eq!((waited, jump), (u32::from(TUNING.looks), 0.0));
    let step = looks.offset() - looks.all();
    assert!(step.abs() < 1e-12, "{step}");
    assert!(looks.choice.carry() > 0.0);

    // Where the edge is lost in noise it is left, after more looks, and again without a jump.
    looks.wobble = 0.0;
    looks.edge_variance = 1e-10;
    let before = looks.offset();
    let (waited, jump) = looks.until_changed();
    assert!(waited >= u32::from(TUNING.looks_from_edge), "{waited}");
    assert_eq!(jump, 0.0);
    assert!((looks.offset() - before).abs() < 1e-12);
}

#[test]
fn too_far_a_change_jumps() {
    let mut looks = Looks {
        largest_carry: 10e-6,
        ..Looks::new()
    };
    looks.settle();
    looks.choice.assume_correlated();
    let (_, jump) = looks.until_changed();
    assert!((jump + looks.below + looks.all()).abs() < 1e-12, "{jump}");
    assert_eq!(looks.choice.carry(), 0.0);
}

#[test]
fn the_line_that_is_followed_is_no_surer_than_it_misses_itself() {
    let mut looks = Looks::new();
    looks.settle();
    let sure = looks.choice.sigma(1e-14);
    assert!((sure - 1e-7).abs() < 1e-12, "{sure}");
    looks.choice.assume_correlated();
    assert!(looks.choice.sigma(1e-14) > 0.3 * looks.wobble);
    let _ = looks.until_changed();
    let sure = looks.choice.sigma(1e-14);
    assert!((sure - TUNING.edge_doubt * 1e-7).abs() < 1e-12, "{sure}");
}

#[test]
fn a_calm_spell_is_no_reason_to_leave_the_edge() {
    let mut looks = Looks::on_the_edge();
    // The edge is a little less sure than a line of all messages that does not wobble any more.
    looks.wobble = 0.0;
    looks.edge_variance = 2e-12;
    for _ in 0..120 {
        let _ = looks.look();
        assert!(looks.choice.is_edge());
    }
    let (waited, _) = looks.until_changed();
    assert!(waited < 1_000, "{waited}");
}

#[test]
fn a_jump_of_the_edge_is_doubt_for_a_while() {
    let mut looks = Looks::new();
    looks.settle();
    let sigma = |looks: &Looks| looks.choice.sigma(1e-14);
    let before = sigma(&looks);
    looks.choice.edge_jumped(20e-6);
    assert_eq!(sigma(&looks), before, "the edge is not followed");
    looks.choice.assume_correlated();
    let _ = looks.until_changed();
    looks.choice.edge_jumped(-20e-6);
    looks.choice.edge_jumped(0.0);
    assert!(sigma(&looks) > TUNING.jumped * 20e-6);
    for _ in 0..200 {
        let _ = looks.look();
    }
    let after = sigma(&looks);
    assert!((after - TUNING.edge_doubt * 1e-7).abs() < 1e-9, "{after}");
}

/// Delays of two levels are suspected before they are taken to be correlated.
#[test]
fn a_suspicion_counts_for_the_uncertainty() {
    let mut looks = Looks::new();
    looks.settle();
    let calm = looks.choice.sigma(1e-14);
    let mut level = 0;
    while looks.choice.correlation.ratio() < TUNING.probable {
        level += 1;
        for n in 0..2_048 {
            let jitter = if (n * 7) % 16 < 8 { 20e-6 } else { -20e-6 };
            let upper = if level % 2 == 0 { 15e-6 } else { 0.0 };
            looks.choice.observe(jitter + upper);
        }
        assert!(level < 1_000, "never");
    }
    assert!(!looks.choice.is_correlated());
    let suspected = looks.choice.sigma(1e-14);
    assert!(suspected > 10.0 * calm, "{suspected} {calm}");
}

/// True if an edge of this standard deviation, s, is left for a line of all messages that has become surer.
fn is_left(sigma: f64) -> bool {
    let mut looks = Looks::on_the_edge();
    // The storm is forgotten.
    looks.wobble = 0.0;
    for _ in 0..4_000 {
        let _ = looks.look();
    }
    looks.edge_variance = sigma * sigma;
    for _ in 0..100 {
        let _ = looks.look();
    }
    !looks.choice.is_edge()
}

#[test]
fn an_edge_that_is_good_enough_is_not_left() {
    assert!(!is_left(0.4e-6));
    assert!(is_left(0.5e-6));
}

/// The number of small jumps, `every` seconds, after which delays count as correlated; none of twenty.
fn suspected_after(every: f64) -> Option<u32> {
    let mut choice = Choice::new();
    (1..=20).find(|n| {
        let by = if n % 2 == 0 { -20e-6 } else { 20e-6 };
        choice.suspect_small_shift(100.0 + every * f64::from(*n), by);
        choice.is_correlated()
    })
}

#[test]
fn jumps_that_return_within_seconds_are_correlated_delays() {
    assert_eq!(suspected_after(5.0), Some(3));
    assert_eq!(suspected_after(9.0), Some(3));
    assert_eq!(suspected_after(20.0), None);
}

#[test]
fn a_jump_back_ends_at_the_level_of_before() {
    for (back, level) in [(-48e-6, 0.0), (-44e-6, 16e-6)] {
        let mut choice = Choice::new();
        choice.suspect_small_shift(100.0, 60e-6);
        choice.suspect_small_shift(104.0, back);
        assert!((choice.level_at(105.0) - level).abs() < 1e-12, "{back}");
        // One that nothing followed was for good.
        assert_eq!(choice.level_at(150.0), 0.0);
    }
}
