//! `[slave.marks]`: registration marks on the material that the master moves.

use coaxle_node::config::{AtLeastZero, Finite, Positive, Wrong};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registration marks, and a simulated sensor that detects them, like the simulated drive.
///
/// The mark `n` is at the slave's position 0 when the master is at `first + n·spacing +
/// spacing-drift·n·(n − 1)/2`, plus the swing's additions to the spacings before it. All lengths
/// are in units of the master, which moves the material forwards.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct MarksConfig {
    /// Position of the master when the first mark is at the slave's position 0, u of the master.
    #[serde(default)]
    pub first: Finite,
    /// Distance from the first mark to the next, u of the master.
    pub spacing: Positive,
    /// Increase of each spacing over the one before, u of the master.
    #[serde(default)]
    pub spacing_drift: AtLeastZero,
    /// Periodic variation of the spacing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing_swing: Option<SpacingSwing>,
    /// Distance of the sensor before the slave's position 0, u of the master.
    pub sensor_distance: Positive,
}

/// A swing of the spacing: `amplitude · sin(2π·n/marks)` is added to the spacing after mark `n`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct SpacingSwing {
    /// The amplitude, u of the master; less than the spacing.
    pub amplitude: AtLeastZero,
    /// Period of the swing in marks, 2 or more.
    pub marks: u32,
}

impl MarksConfig {
    /// # Errors
    /// [`Wrong`]: marks that no material can have.
    pub fn check(&self) -> Result<(), Wrong> {
        let Some(swing) = &self.spacing_swing else {
            return Ok(());
        };
        let (received, spacing) = (swing.amplitude.get(), self.spacing.get());
        // At a spacing of 0 or less a mark would not lie beyond the one before.
        if received >= spacing {
            let expected = format!("less than the spacing, {spacing}");
            return Err(Wrong::of("spacing-swing.amplitude", received, expected));
        }
        if swing.marks < 2 {
            return Err(Wrong::of("spacing-swing.marks", swing.marks, "2 or more"));
        }
        Ok(())
    }

    /// Position of the master when a mark is at the slave's position 0, u of the master. Marks
    /// count from 0, and each lies beyond the one before.
    #[must_use]
    pub fn position(&self, mark: u64) -> f64 {
        let n = mark as f64;
        // The sum 0 + 1 + … + (n − 1), times the drift.
        let drift = self.spacing_drift.get() * n * (n - 1.0) * 0.5;
        let swing = self.spacing_swing.map_or(0.0, |swing| swing.sum(mark));
        self.first.get() + n * self.spacing.get() + drift + swing
    }

    /// The first mark beyond a position.
    #[must_use]
    pub fn first_beyond(&self, position: f64) -> u64 {
        let swing = self.spacing_swing.map_or(0.0, |s| s.amplitude.get());
        let closest = self.spacing.get() - swing;
        // At most the number of marks that fit at the least spacing, one for rounding and one for
        // the first. The cast saturates.
        let fit = ((position - self.first.get()) / closest) as u64;
        let mut after = fit.saturating_add(2);
        let mut first = 0;
        while first < after {
            let middle = first + (after - first) / 2;
            if self.position(middle) > position {
                after = middle;
            } else {
                first = middle + 1;
            }
        }
        first
    }

    /// The mark that is closest to a position.
    #[must_use]
    pub fn closest_to(&self, position: f64) -> u64 {
        // Positions of marks increase, so that only the two neighbours can be the closest.
        let beyond = self.first_beyond(position);
        let off = |mark: u64| (self.position(mark) - position).abs();
        match beyond.checked_sub(1) {
            Some(before) if off(before) <= off(beyond) => before,
            _ => beyond,
        }
    }
}

impl SpacingSwing {
    /// The swing's addition to all spacings before a mark.
    fn sum(&self, mark: u64) -> f64 {
        let marks = u64::from(self.marks);
        // A whole period adds zero. The sum of sines has a closed form.
        let n = (mark % marks) as f64;
        // Σ sin(2πk/m) for k < n is sin(nπ/m)·sin((n − 1)π/m)/sin(π/m).
        let half_turn = core::f64::consts::PI / marks as f64;
        let sum = libm::sin(n * half_turn) * libm::sin((n - 1.0) * half_turn);
        self.amplitude.get() * sum / libm::sin(half_turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn marks(text: &str) -> MarksConfig {
        coaxle_node::config::parse("marks", text).expect("marks")
    }

    const WANDERING: &str = "first = 250\nspacing = 600\nspacing-drift = 0.01\n\
        spacing-swing = { amplitude = 1.8, marks = 40 }\nsensor-distance = 700";

    #[test]
    fn each_spacing_is_what_the_config_says() {
        let marks = marks(WANDERING);
        assert_eq!(marks.position(0), 250.0);
        for n in 0..1_000 {
            let turn = core::f64::consts::TAU * f64::from(n) / 40.0;
            let expected = 600.0 + 0.01 * f64::from(n) + 1.8 * turn.sin();
            let n = u64::from(n as u32);
            let spacing = marks.position(n + 1) - marks.position(n);
            assert!((spacing - expected).abs() < 1e-8, "{n}: {spacing}");
        }
    }

    #[test]
    fn marks_that_change_places_are_refused() {
        for (swing, expected) in [
            (
                "{ amplitude = 600, marks = 40 }",
                "spacing-swing.amplitude: received 600, expected less than the spacing, 600",
            ),
            (
                "{ amplitude = 1, marks = 1 }",
                "spacing-swing.marks: received 1, expected 2 or more",
            ),
        ] {
            let text = format!("spacing = 600\nsensor-distance = 700\nspacing-swing = {swing}");
            let error = marks(&text).check().unwrap_err();
            assert_eq!(error.to_string(), expected);
        }
        assert_eq!(marks(WANDERING).check(), Ok(()));
    }

    proptest! {
        #[test]
        fn marks_are_found_by_their_positions(
            first in -1e4..1e4,
            spacing in 1.0..1e3,
            drift in 0.0..1.0,
            swing in 0.0..0.9,
            period in 2u32..100,
            mark in 0u64..100_000,
            share in 0.001..0.999,
        ) {
            let marks = MarksConfig {
                first: Finite::new(first).expect("finite"),
                spacing: Positive::new(spacing).expect("positive"),
                spacing_drift: AtLeastZero::new(drift).expect("positive"),
                spacing_swing: Some(SpacingSwing {
                    amplitude: AtLeastZero::new(swing * spacing).expect("positive"),
                    marks: period,
                }),
                sensor_distance: Positive::new(1.0).expect("positive"),
            };
            let (this, next) = (marks.position(mark), marks.position(mark + 1));
            prop_assert!(next > this);
            prop_assert_eq!(marks.first_beyond(this), mark + 1);
            prop_assert_eq!(marks.first_beyond(this + share * (next - this)), mark + 1);
            let closest = if share < 0.5 { mark } else { mark + 1 };
            prop_assert_eq!(marks.closest_to(this + share * (next - this)), closest);
            prop_assert_eq!(marks.first_beyond(first - 1.0), 0);
        }
    }
}
