//! Encoder masters: from counts to a smooth position, velocity and acceleration.
//!
//! A measuring wheel gives counts, once per sampling cycle. Their differences are a velocity that
//! jumps by an increment per cycle; a slave coupled to that breaks its limits, or sees a reversal
//! that did not occur. An [`EncoderMaster`] calculates set values from them with limited jerk and
//! acceleration, a compensated lag, and a certain direction:
//!
//! ```text
//! count ─▶ counter ─▶ gate ─▶ estimator ─▶ extrapolation ─▶ tracker ─▶ set values
//!          turns      edges   p, v, a      by the horizon    limits
//! ```
//!
//! Largest errors at a sampling time of 1 ms, a horizon of 2 ms, speeds of 5 to 2000 mm/s and 1 % of the samples lost,
//! 500 runs each, in µm:
//!
//! | increment, mm | constant speed | ripple to 13 Hz | ramp, jerk 1e4 | stop and go, jerk 1e5 | standing |
//! |--|--|--|--|--|--|
//! | 0.001 | 2 | 20 | 19 | 400 (1200 at 50 mm/s) | 1 |
//! | 0.01 | 13 | 50 | 75 | 850 (1300) | 10 |
//! | 0.05 | 63 | 147 | 273 | 1700 | 50 |
//! | 0.1 | 125 | 229 | 479 | 2300 | 100 |
//!
//! All with the jerk limit of 1e5 mm/s³, which causes the larger ones:
//!
//! * Stop and go uses all of it. From standstill the direction is certain after two increments q,
//!   that is after (12 q / jerk)^⅓ = 4.9, 10.6, 18.2 and 22.9 ms. Set values that start 2 ms later
//!   (horizon and sampling), with the full jerk, are 340, 790, 1580 and 2170 µm behind by the time
//!   they are as fast as the axis, and 410, 880, 1690 and 2300 if the decisive sample is lost. No
//!   estimate improves that.
//! * A ripple is one of 1 % of the speed at 0.5 Hz, and 0.13 % at 13 Hz: there a jerk of 1.8e4
//!   mm/s³ at 2000 mm/s, of which a perfect estimate would miss 0.02 µm. The loops lag 18, 46, 90
//!   and 122 µm; noise adds some 4.5 of its standard deviations, 0.4, 1.7, 6 and 11 µm, and from
//!   0.05 mm on the beat of counts and samples, half an increment in both directions. Loops that
//!   lag less need more jerk, and noise has a standard deviation of 4e4 mm/s³ of that already.
//!
//! Three times the limit reduces the ripple to 13, 29, 94 and 165 µm, and stop and go to 126, 225,
//! 617 and 920 (200 runs).
//!
//! A speed at which a sample is a whole number of increments after the last leaves up to half an
//! increment unobservable, and a permanently wrong count cannot be distinguished from a way without
//! a mark. `cargo run --release -p coaxle-remote --example encoder_table` prints the figures and
//! those of simpler methods.

mod counter;
mod estimate;
mod following;
mod gains;
mod gate;
mod parameters;
mod recent_range;
mod sample;
mod smoothing;
mod tracker;
mod uncertainty;
mod walk;

use coaxle_axis::TravelDirection;
use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

use counter::Counter;
use following::Following;
use uncertainty::Uncertainty;

pub use parameters::{COARSE_INCREMENT_MM, CheckedEncoder, EncoderParameters};
pub use sample::EncoderSample;
pub use smoothing::Smoothing;

/// The master of an encoder.
///
/// Positions are those of the shaft: a count c means any position from c to c + 1 increments. The
/// set values belong to the instant `horizon` after the newest sample.
///
/// * For a dozen time constants after the first sample it follows its estimate without limits, not
///   yet [`acquired`](EncoderOutput::acquired): a start at a moving belt needs no catching up.
/// * From standstill nothing moves until the direction is certain, which takes two increments.
/// * A master at rest more than half an increment ahead walks back slowly,
///   [`trimming`](EncoderOutput::trimming); otherwise it never moves against its direction.
/// * Without samples it continues by the last ones for a quarter of a second; then it stops, within
///   its limits, until there are new ones.
/// * A count that no motion explains is refused. If the next ones agree with it the counter was
///   preset: the position continues as if it had not been.
#[derive(Clone, Debug)]
pub struct EncoderMaster {
    checked: CheckedEncoder,
    uncertainty: Uncertainty,
    counter: Counter,
    /// The first count, and the state from then on.
    following: Option<(i64, Following)>,
}

/// Output of one cycle of an [`EncoderMaster`].
#[must_use]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EncoderOutput {
    /// The set values; at rest at 0 before the first sample.
    pub set: Kinematics,
    /// Current or last direction of the axis; none before it moved. Rollback monitors take this,
    /// never the sign of a velocity.
    pub direction: Option<TravelDirection>,
    /// No edge has occurred for a quarter of a second, or none that is a motion.
    pub standstill: bool,
    /// The set values walk back to the axis's position at rest.
    pub trimming: bool,
    /// The set values have settled since the first sample and keep their limits from now on.
    pub acquired: bool,
    /// Standard deviation of the estimated position, u.
    pub position_sigma: f64,
    /// Standard deviation of the estimated velocity, u/s.
    pub velocity_sigma: f64,
    /// Number of refused counts that no motion explains.
    pub refused_jumps: u32,
    /// Number of presets of the counter up to now.
    pub counter_resets: u32,
}

impl EncoderMaster {
    /// Creates a master without a sample.
    #[must_use]
    pub fn new(checked: &CheckedEncoder) -> Self {
        Self {
            checked: *checked,
            uncertainty: Uncertainty::new(checked),
            counter: Counter::new(checked),
            following: None,
        }
    }

    /// Runs one cycle. `sample` is the new one in it; none without a new one. `horizon` is the time
    /// from the newest sample to the instant of the set values: with every cycle without a sample
    /// it is a cycle longer; one that is not finite is taken for 0. `elapsed` counts the own cycles
    /// since the previous call.
    pub fn update(
        &mut self,
        sample: Option<EncoderSample>,
        horizon: Seconds,
        elapsed: u32,
    ) -> EncoderOutput {
        // A sample of 0 cycles is the last one read again; its gap of 0 s would divide by 0.
        if let Some(sample) = sample.filter(|sample| sample.cycles > 0) {
            self.take(sample);
        }
        let Seconds(horizon) = horizon;
        // A NaN would stay in the tracker's state for ever.
        let horizon = if horizon.is_finite() { horizon } else { 0.0 };
        if let Some((_, following)) = &mut self.following {
            following.advance(horizon, elapsed, self.checked.cycle);
        }
        self.output(horizon)
    }

    /// Clears everything except the number of refused counts: the next sample is the first.
    pub fn restart(&mut self) {
        self.following = None;
        // The refusals are figures of the machine, which an operator watches across restarts.
        self.counter.restart();
    }

    fn take(&mut self, sample: EncoderSample) {
        let gap = f64::from(sample.cycles) * self.checked.sampling;
        let velocity = match &self.following {
            Some((_, following)) => following.velocity(),
            None => 0.0,
        };
        let counts_per_second = velocity / self.checked.given.increment;
        // A refused count counts as a lost sample: the next gap is longer.
        let Some(counted) = self.counter.update(sample.raw, gap, counts_per_second) else {
            return;
        };
        match (&mut self.following, counted.gap) {
            (Some((_, following)), Some(gap)) => following.take(counted.count, gap),
            _ => {
                // Positions in the loop start at 0: a count of 64 bits may leave a float no fraction of an increment.
                let following = Following::new(&self.checked, counted.count);
                self.following = Some((counted.count, following));
            }
        }
    }

    fn output(&self, horizon: f64) -> EncoderOutput {
        let refused_jumps = self.counter.refused();
        let counter_resets = self.counter.resets();
        let Some((origin, following)) = &self.following else {
            return EncoderOutput {
                standstill: true,
                refused_jumps,
                counter_resets,
                ..EncoderOutput::default()
            };
        };
        let (position_sigma, velocity_sigma) = following.sigmas(&self.uncertainty, horizon);
        let set = *following.set();
        EncoderOutput {
            set: Kinematics {
                position: *origin as f64 * self.checked.given.increment + set.position,
                ..set
            },
            direction: following.direction(),
            standstill: following.is_standstill(),
            trimming: following.is_trimming(),
            acquired: following.is_acquired(),
            position_sigma,
            velocity_sigma,
            refused_jumps,
            counter_resets,
        }
    }
}

#[cfg(test)]
mod tests;
