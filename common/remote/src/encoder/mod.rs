//! Encoder masters: from counts to a smooth position, velocity and acceleration.
//!
//! A measuring wheel gives counts, once per sampling cycle. Their differences are a velocity that jumps by an
//! increment per cycle; a slave coupled to that breaks its limits, or sees a reversal that never was. An
//! [`EncoderMaster`] makes set values of them whose jerk and acceleration are limited, whose lag is
//! compensated, and whose direction is certain:
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
//! All with the jerk limit of 1e5 mm/s³, which is what the larger ones are made of:
//!
//! * Stop and go uses all of it. From standstill the direction is certain after two increments q, that is after
//!   (12 q / jerk)^⅓ = 4.9, 10.6, 18.2 and 22.9 ms. Set values that start 2 ms later (horizon and sampling), with all
//!   the jerk there is, are 340, 790, 1580 and 2170 µm behind by the time they are as fast as the axis, and 410, 880, 1690
//!   and 2300 where the sample that decides is lost. No estimate makes that better.
//! * A ripple is one of 1 % of the speed at 0.5 Hz, and 0.13 % at 13 Hz: there a jerk of 1.8e4 mm/s³ at 2000 mm/s, of
//!   which a perfect estimate would miss 0.02 µm. The loops lag 18, 46, 90 and 122 µm; noise adds some 4.5 of its standard
//!   deviations, 0.4, 1.7, 6 and 11 µm, and from 0.05 mm on the beat of counts and samples, half an increment to and
//!   fro. Loops that lag less ask for more jerk, and noise has a standard deviation of 4e4 mm/s³ of that already.
//!
//! Three times the limit makes 13, 29, 94 and 165 µm of the ripple, and 126, 225, 617 and 920 of stop and go (200 runs).
//!
//! A speed at which a sample is a whole number of increments after the last leaves up to half an increment that
//! nothing can see, and a count that is wrong for good cannot be told from a way: only a mark could.
//! `cargo run --release -p coaxle-remote --example encoder_table` prints the figures, beside those of simpler methods.

mod counter;
mod estimate;
mod following;
mod gains;
mod gate;
mod parameters;
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

/// The master that an encoder is.
///
/// Positions are those of the shaft: a count c means anything from c to c + 1 increments. The set values go
/// with the instant that is `horizon` after the newest sample.
///
/// * For a dozen time constants after the first sample it follows its estimate without limits, not
///   yet [`acquired`](EncoderOutput::acquired): who starts beside a moving belt need not catch up with it.
/// * From standstill nothing moves until the direction is certain, which takes two increments.
/// * A master that came to rest more than half an increment ahead walks back slowly,
///   [`trimming`](EncoderOutput::trimming); else it never moves against its direction.
/// * Without samples it goes on as the last ones said, for a quarter of a second; then it stops, within
///   its limits, until there are new ones.
/// * A count that no motion explains is refused. Where the next ones agree with it the counter was set anew: the
///   position goes on as if it had not been.
#[derive(Clone, Debug)]
pub struct EncoderMaster {
    checked: CheckedEncoder,
    uncertainty: Uncertainty,
    counter: Counter,
    /// The first count, and what there is from then on.
    following: Option<(i64, Following)>,
}

/// What one cycle of an [`EncoderMaster`] gives.
#[must_use]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EncoderOutput {
    /// The set values; at rest at 0 before the first sample.
    pub set: Kinematics,
    /// Where the axis goes, or went last; none before it moved. Rollback monitors take this, never the
    /// sign of a velocity.
    pub direction: Option<TravelDirection>,
    /// No edge has come for a quarter of a second, or none that makes a motion.
    pub standstill: bool,
    /// The set values walk back to where the axis stands.
    pub trimming: bool,
    /// The set values have settled since the first sample and keep their limits from now on.
    pub acquired: bool,
    /// Standard deviation of the estimated position, u.
    pub position_sigma: f64,
    /// Standard deviation of the estimated velocity, u/s.
    pub velocity_sigma: f64,
    /// Counts that no motion explains, refused so far.
    pub refused_jumps: u32,
    /// How often the counter was set anew so far.
    pub counter_resets: u32,
}

impl EncoderMaster {
    /// A master that has seen no sample.
    #[must_use]
    pub fn new(checked: &CheckedEncoder) -> Self {
        Self {
            checked: *checked,
            uncertainty: Uncertainty::new(checked),
            counter: Counter::new(checked),
            following: None,
        }
    }

    /// One cycle. `sample` is what is new in it; none where nothing came. `horizon` is the time from the newest
    /// sample there was to the instant the set values are for: with every cycle without a sample
    /// it is a cycle longer; one that is not finite is taken for 0. `elapsed` counts the own cycles since the
    /// previous call.
    pub fn update(
        &mut self,
        sample: Option<EncoderSample>,
        horizon: Seconds,
        elapsed: u32,
    ) -> EncoderOutput {
        if let Some(sample) = sample.filter(|sample| sample.cycles > 0) {
            self.take(sample);
        }
        let Seconds(horizon) = horizon;
        let horizon = if horizon.is_finite() { horizon } else { 0.0 };
        if let Some((_, following)) = &mut self.following {
            following.advance(horizon, elapsed, self.checked.cycle);
        }
        self.output(horizon)
    }

    /// Forgets everything but how often counts were refused: the next sample is the first.
    pub fn restart(&mut self) {
        self.following = None;
        self.counter.restart();
    }

    fn take(&mut self, sample: EncoderSample) {
        let gap = f64::from(sample.cycles) * self.checked.sampling;
        let velocity = match &self.following {
            Some((_, following)) => following.velocity(),
            None => 0.0,
        };
        let counts_per_second = velocity / self.checked.given.increment;
        let Some(counted) = self.counter.update(sample.raw, gap, counts_per_second) else {
            return;
        };
        match (&mut self.following, counted.gap) {
            (Some((_, following)), Some(gap)) => following.take(counted.count, gap),
            _ => {
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
