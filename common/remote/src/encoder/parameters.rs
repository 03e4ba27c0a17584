//! Parameters of an encoder master, checked once.

use coaxle_clock::time_sync::WrongParameter;
use coaxle_clock::{Seconds, Span};

use super::smoothing::Smoothing;

/// Parameters of an [`EncoderMaster`](super::EncoderMaster). If only the increment is known, leave
/// the rest at its defaults. The defaults of speeds, accelerations and jerks are for axes in
/// millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct EncoderParameters {
    /// Length of one count, u. Above 0; there is no default.
    pub increment: f64,
    /// Cycle time in which the counter is read, s; 0: the task's. At most 0.1 s.
    #[cfg_attr(feature = "serde", serde(rename = "sampling-time-s"))]
    pub sampling_time: Seconds,
    /// Smoothing of the counts.
    pub smoothing: Smoothing,
    /// Speed that the axis never exceeds, u/s; above 0. A jump of the counter beyond 1.5 times this
    /// speed is refused.
    pub max_speed: f64,
    /// Standard deviation of the shaft's vibration, u; at least 0. A reversal counts as one from
    /// 1 + ⌈10 · vibration / increment⌉ counts on, at least from 2. From a quarter of an increment on
    /// the counts are averaged instead of waiting for edges.
    pub vibration: f64,
    /// Standard deviation of the instants at which the counter is read, s; at least 0.
    #[cfg_attr(feature = "serde", serde(rename = "timing-sigma-s"))]
    pub timing_sigma: Seconds,
    /// Largest acceleration of the set values, u/s²; above 0. The axis's acceleration must be below it.
    pub acceleration_limit: f64,
    /// Largest jerk of the set values, u/s³; above 0. Several times that of the axis: set values
    /// with no more jerk than the axis cannot catch up with it while it uses its full jerk.
    pub jerk_limit: f64,
    /// Largest speed at which a master at rest too far ahead walks back, u/s; above 0.
    pub trim_speed: f64,
    /// Width of the counter, 8 to 64 bits. A position is a counter of 64 bits.
    pub counter_bits: u8,
}

/// Coarser increments than this, in mm, give a master with errors of tenths of a millimetre: worth
/// a warning on reading a config.
pub const COARSE_INCREMENT_MM: f64 = 0.02;

impl Default for EncoderParameters {
    fn default() -> Self {
        Self {
            increment: 0.0,
            sampling_time: Seconds::ZERO,
            smoothing: Smoothing::Auto,
            // At this speed a jump of more than 7.5 mm in 1 ms is refused, by the margin of 1.5.
            max_speed: 5_000.0,
            vibration: 0.0,
            // Jitter of a latched reading in the table's runs; at 5 m/s it is 1 µm.
            timing_sigma: Seconds(2e-7),
            // 2.5 times the axis of the table, 2000 mm/s²: the master must catch up after its lag.
            acceleration_limit: 5_000.0,
            // Limit at which the table of this module was measured.
            jerk_limit: 1e5,
            trim_speed: 5.0,
            counter_bits: 64,
        }
    }
}

/// Valid parameters for a cycle time of the task, and the values derived from them.
#[derive(Clone, Copy, Debug)]
pub struct CheckedEncoder {
    pub(super) given: EncoderParameters,
    /// The cycle time of the counter, s.
    pub(super) sampling: f64,
    /// The cycle time of the set values, s.
    pub(super) cycle: f64,
    /// Bandwidth of estimator and tracker, rad/s.
    pub(super) bandwidth: f64,
    /// Spectral density of the noise of a position, u²s.
    pub(super) noise: f64,
    /// Retreat that is a reversal, counts.
    pub(super) hysteresis: i64,
}

impl EncoderParameters {
    /// Checks every parameter. `task_cycle_time` is the cycle time of the set values: the receiver's.
    ///
    /// # Errors
    /// [`WrongParameter`] (0x4b56) names the parameter that is out of its range.
    pub fn checked(self, task_cycle_time: Span) -> Result<CheckedEncoder, WrongParameter> {
        let cycle = task_cycle_time.as_secs_f64();
        self.check(cycle)?;
        let sampling = match self.sampling_time {
            Seconds(time) if time > 0.0 => time,
            _ => cycle,
        };
        let noise = self.noise(sampling);
        Ok(CheckedEncoder {
            sampling,
            cycle,
            bandwidth: self.smoothing.bandwidth(sampling, noise, self.jerk_limit)?,
            noise,
            hysteresis: self.hysteresis()?,
            given: self,
        })
    }

    fn check(&self, cycle: f64) -> Result<(), WrongParameter> {
        const ABOVE_ZERO: &str = "a finite number above 0";
        const AT_LEAST_ZERO: &str = "a finite number of at least 0";
        const TIME: &str = "at most 0.1 s, above 0";
        // Both are false for NaN, which a comparison the other way round would let pass.
        let above_zero = |x: f64| x.is_finite() && x > 0.0;
        let at_least_zero = |x: f64| x.is_finite() && x >= 0.0;
        let Seconds(sampling) = self.sampling_time;
        let Seconds(timing) = self.timing_sigma;
        let bits = self.counter_bits;
        let limits = [
            ("max-speed", self.max_speed),
            ("acceleration-limit", self.acceleration_limit),
            ("jerk-limit", self.jerk_limit),
            ("trim-speed", self.trim_speed),
        ]
        .map(|(name, value)| (name, value, above_zero(value), ABOVE_ZERO));
        let others = [
            (
                "increment",
                self.increment,
                above_zero(self.increment),
                ABOVE_ZERO,
            ),
            ("task-cycle-time", cycle, cycle > 0.0 && cycle <= 0.1, TIME),
            (
                "sampling-time-s",
                sampling,
                (0.0..=0.1).contains(&sampling),
                TIME,
            ),
            (
                "vibration",
                self.vibration,
                at_least_zero(self.vibration),
                AT_LEAST_ZERO,
            ),
            (
                "timing-sigma-s",
                timing,
                at_least_zero(timing),
                AT_LEAST_ZERO,
            ),
            (
                "counter-bits",
                bits.into(),
                (8..=64).contains(&bits),
                "8 to 64",
            ),
        ];
        // A single list in one order: the first wrong parameter is reported, whichever others are wrong too.
        for (parameter, received, good, expected) in others.into_iter().chain(limits) {
            if !good {
                return Err(WrongParameter {
                    parameter,
                    received,
                    expected,
                });
            }
        }
        Ok(())
    }

    /// A reading is at any position in its increment, and at top speed its instant counts as well.
    fn noise(&self, sampling: f64) -> f64 {
        let by_instant = self.max_speed * self.timing_sigma.0;
        // Variance of a uniform distribution over one increment: q²/12. Independent variances add up.
        let of_one = self.increment * self.increment / 12.0
            + by_instant * by_instant
            + self.vibration * self.vibration;
        // A variance per sample is a density of variance times sampling time.
        sampling * of_one
    }

    fn hysteresis(&self) -> Result<i64, WrongParameter> {
        // Counts of this size are exact in f64 and far from the range of i64, whatever is added.
        const MOST: f64 = 1e6;
        // Five standard deviations to either side: a normal vibration exceeds them in 6e-7 of the samples.
        let counts = libm::ceil(10.0 * self.vibration / self.increment);
        if counts > MOST {
            return Err(WrongParameter {
                parameter: "vibration",
                received: self.vibration,
                expected: "at most 100000 increments",
            });
        }
        // A retreat of one count is a flicker at a border, even without vibration.
        Ok((1 + counts as i64).max(2))
    }
}

impl CheckedEncoder {
    /// Bandwidth of the smoothing in force, rad/s.
    #[must_use]
    pub const fn bandwidth(&self) -> f64 {
        self.bandwidth
    }

    /// Smallest retreat that counts as a reversal, counts.
    #[must_use]
    pub const fn hysteresis(&self) -> i64 {
        self.hysteresis
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: Span = Span::from_millis(1);

    fn of(increment: f64) -> EncoderParameters {
        EncoderParameters {
            increment,
            timing_sigma: Seconds::ZERO,
            ..EncoderParameters::default()
        }
    }

    #[test]
    fn the_automatic_bandwidth_falls_with_the_increment() {
        for (increment, bandwidth) in [(0.001, 350.0), (0.01, 198.0), (0.05, 125.0), (0.1, 103.0)] {
            let checked = of(increment).checked(CYCLE).unwrap();
            assert!((checked.bandwidth() - bandwidth).abs() < 1.0, "{checked:?}");
        }
    }

    #[test]
    fn a_time_of_smoothing_is_taken_as_it_is() {
        let smoothing = Smoothing::Time(Seconds(0.02));
        let checked = EncoderParameters {
            smoothing,
            ..of(0.01)
        }
        .checked(CYCLE);
        assert!((checked.unwrap().bandwidth() - 50.0).abs() < 1e-9);
        for time in [0.0, 0.002, 0.3, f64::NAN] {
            let smoothing = Smoothing::Time(Seconds(time));
            let refused = EncoderParameters {
                smoothing,
                ..of(0.01)
            }
            .checked(CYCLE);
            assert_eq!(refused.unwrap_err().parameter, "smoothing");
        }
    }

    #[test]
    fn ten_sigmas_of_vibration_are_no_reversal() {
        for (vibration, counts) in [(0.0, 2), (0.0005, 2), (0.001, 2), (0.0011, 3), (0.01, 11)] {
            let checked = EncoderParameters {
                vibration,
                ..of(0.01)
            }
            .checked(CYCLE);
            assert_eq!(checked.unwrap().hysteresis(), counts, "{vibration}");
        }
    }

    #[test]
    fn a_wrong_parameter_is_named() {
        let good = of(0.01);
        let wrong = [
            ("increment", of(0.0)),
            ("increment", of(f64::NAN)),
            (
                "max-speed",
                EncoderParameters {
                    max_speed: 0.0,
                    ..good
                },
            ),
            (
                "vibration",
                EncoderParameters {
                    vibration: -1.0,
                    ..good
                },
            ),
            (
                "vibration",
                EncoderParameters {
                    vibration: 1e9,
                    ..good
                },
            ),
            (
                "jerk-limit",
                EncoderParameters {
                    jerk_limit: f64::INFINITY,
                    ..good
                },
            ),
            (
                "acceleration-limit",
                EncoderParameters {
                    acceleration_limit: 0.0,
                    ..good
                },
            ),
            (
                "trim-speed",
                EncoderParameters {
                    trim_speed: -5.0,
                    ..good
                },
            ),
            (
                "counter-bits",
                EncoderParameters {
                    counter_bits: 7,
                    ..good
                },
            ),
            (
                "counter-bits",
                EncoderParameters {
                    counter_bits: 65,
                    ..good
                },
            ),
            (
                "sampling-time-s",
                EncoderParameters {
                    sampling_time: Seconds(0.2),
                    ..good
                },
            ),
            (
                "timing-sigma-s",
                EncoderParameters {
                    timing_sigma: Seconds(-1.0),
                    ..good
                },
            ),
        ];
        for (name, parameters) in wrong {
            assert_eq!(parameters.checked(CYCLE).unwrap_err().parameter, name);
        }
        assert!(good.checked(Span::ZERO).is_err());
    }
}
