//! Information of a message about the jitter's location and widths, as a function of their ratio.

use super::hazard::Hazard;

/// Means over the jitter's own distribution.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Information {
    /// Curvature of the log-likelihood in the location, per squared normal width.
    pub(super) curvature: f64,
    /// Change of the score of the location with the logarithm of the normal width.
    pub(super) normal_pull: f64,
    /// Change of the score of the location with the logarithm of the exponential width.
    pub(super) exponential_pull: f64,
    /// About the logarithm of the normal width,
    pub(super) normal: f64,
    /// of the exponential one,
    pub(super) exponential: f64,
    /// and about both.
    pub(super) both: f64,
}

// Thirty ratios from 0.004 to 3.2, each 1.26 times the one before: blended linearly, the information is right to 3 %.
const POINTS: usize = 30;
const LEAST_RATIO: f64 = 0.004;
/// Natural logarithm of the least ratio.
const LOG_OF_LEAST: f64 = -5.521_460_917_862_246;
const STEP: f64 = 0.23;

/// The information at logarithmic steps of `normal / exponential`.
#[derive(Clone, Debug)]
pub(super) struct InformationTable {
    points: [Information; POINTS],
}

impl InformationTable {
    pub(super) fn new(hazard: &Hazard) -> Self {
        let mut points = [Information::default(); POINTS];
        for (i, point) in points.iter_mut().enumerate() {
            *point = integrated(hazard, LEAST_RATIO * libm::exp(STEP * i as f64));
        }
        Self { points }
    }

    /// Information at a ratio that has this logarithm.
    pub(super) fn at(&self, logarithm: f64) -> Information {
        let position = (logarithm - LOG_OF_LEAST) * (1.0 / STEP);
        // Not up to the last point itself, as the next one is read, too.
        let position = position.clamp(0.0, (POINTS - 2) as f64 + 0.999);
        let i = position as usize;
        let part = position - i as f64;
        self.points[i].blend(&self.points[i + 1], part)
    }
}

impl Information {
    fn blend(&self, other: &Self, part: f64) -> Self {
        let mix = |a: f64, b: f64| a + part * (b - a);
        Self {
            curvature: mix(self.curvature, other.curvature),
            normal_pull: mix(self.normal_pull, other.normal_pull),
            exponential_pull: mix(self.exponential_pull, other.exponential_pull),
            normal: mix(self.normal, other.normal),
            exponential: mix(self.exponential, other.exponential),
            both: mix(self.both, other.both),
        }
    }
}

/// Scores of one message, its part in all that is learned, at the standardised residual `z`, the residual in normal
/// widths less the ratio of the widths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scores {
    pub(super) slope: f64,
    pub(super) normal: f64,
    pub(super) exponential: f64,
}

impl Scores {
    pub(super) fn new(ratio: f64, z: f64, h: f64) -> Self {
        let slope = h * (z + h);
        Self {
            slope,
            normal: (ratio - h) * (ratio - h) - slope,
            exponential: ratio * (z + h) - 1.0,
        }
    }
}

/// Residual from which the hazard is negligible and the rest an exponential tail.
const TAIL: f64 = 6.0;

fn integrated(hazard: &Hazard, ratio: f64) -> Information {
    const WIDTH: f64 = 0.0625;
    let mut sum = Information::default();
    // Midpoint rule from z = −8 to 6 in sixteenths, weighted with the density of the jitter itself.
    for i in 0..224 {
        let z = TAIL - (f64::from(i) + 0.5) * WIDTH;
        let below = 0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2);
        let weight = WIDTH * ratio * libm::exp(-0.5 * ratio * ratio - ratio * z) * below;
        let h = hazard.at(z);
        let scores = Scores::new(ratio, z, h);
        sum.curvature += weight * scores.slope;
        sum.normal_pull += weight * (h - scores.slope * (z + 2.0 * ratio));
        sum.exponential_pull += weight * ratio * (scores.slope - 1.0);
        sum.normal += weight * scores.normal * scores.normal;
        sum.exponential += weight * scores.exponential * scores.exponential;
        sum.both += weight * scores.normal * scores.exponential;
    }
    // Beyond, the hazard is 0 and the integrals of an exponential are known in closed form.
    let begin = ratio * TAIL;
    let weight = libm::exp(-0.5 * ratio * ratio - begin);
    sum.exponential_pull -= weight * ratio;
    sum.normal += weight * ratio * ratio * ratio * ratio;
    sum.exponential += weight * (begin * begin + 1.0);
    sum.both += weight * ratio * ratio * begin;
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Density of the jitter with a normal width of 1.
    fn density(ratio: f64, residual: f64) -> f64 {
        let below = 0.5 * libm::erfc((ratio - residual) * core::f64::consts::FRAC_1_SQRT_2);
        ratio * libm::exp(0.5 * ratio * ratio - ratio * residual) * below
    }

    #[test]
    fn the_table_has_the_fisher_information_of_the_density() {
        let table = InformationTable::new(&Hazard::new());
        for ratio in [0.02, 0.05, 0.25, 1.0, 2.5] {
            let step = 1e-3;
            let (mut fisher, mut residual) = (0.0, -7.0);
            while residual < 12.0 + 20.0 / ratio {
                let slope = density(ratio, residual + step) - density(ratio, residual - step);
                let slope = slope / (2.0 * step);
                let here = density(ratio, residual).max(1e-300);
                fisher += slope * slope / here * 0.01;
                residual += 0.01;
            }
            let curvature = table.at(libm::log(ratio)).curvature;
            assert!(
                (curvature / fisher - 1.0).abs() < 0.03,
                "{ratio}: {curvature} {fisher}"
            );
        }
    }

    #[test]
    fn a_pure_exponential_tells_its_width_as_one_over_its_square() {
        assert_eq!(LOG_OF_LEAST, libm::log(LEAST_RATIO));
        let information = InformationTable::new(&Hazard::new()).at(LOG_OF_LEAST);
        assert!((information.exponential - 1.0).abs() < 0.02);
        assert!(information.normal < 0.02);
    }
}
