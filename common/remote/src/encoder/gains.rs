//! Gains of a third-order loop, for any time between two corrections.

/// Parts of an error that correct position, velocity and acceleration.
///
/// The gains place the poles of the α-β-γ loop at e^(−ωτ), twice, and e^(−ωτ/2), for any time τ
/// since the last correction: a correction after a long gap is a strong one, and equals many small
/// ones. One exponential function gives all of them, so that no table is needed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gains {
    pub(super) position: f64,
    /// 1/s.
    pub(super) velocity: f64,
    /// 1/s².
    pub(super) acceleration: f64,
}

impl Gains {
    /// Calculates them for a bandwidth in rad/s and a time since the last correction above 0, in s.
    pub(super) fn new(bandwidth: f64, time: f64) -> Self {
        // The pole z of a loop with bandwidth ω is e^(-ωτ): l for the pair, m = √l for the slow third one.
        let m = libm::exp(-0.5 * bandwidth * time);
        let l = m * m;
        // From (z - l)²(z - m): the product of the poles is 1 - k₁, the value at z = 1 is K₃, …
        let position = 1.0 - l * l * m;
        let acceleration = (1.0 - l) * (1.0 - l) * (1.0 - m);
        // … and the sum of the poles 3 - k₁ - K₂ - K₃/2.
        let velocity = 3.0 - position - 0.5 * acceleration - 2.0 * l - m;
        let rate = 1.0 / time;
        Self {
            position,
            velocity: velocity * rate,
            acceleration: acceleration * rate * rate,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loop that is corrected every `time` follows a constant acceleration without lag.
    #[test]
    fn a_constant_acceleration_is_followed_exactly() {
        for time in [1e-3, 7e-3, 0.05, 0.25] {
            let gains = Gains::new(100.0, time);
            let (mut p, mut v, mut a) = (0.0, 0.0, 0.0);
            let mut error = 1.0;
            for step in 1..=(2.0 / time) as u32 + 20 {
                let t = f64::from(step) * time;
                p += v * time + 0.5 * a * time * time;
                v += a * time;
                error = 3.0 + 20.0 * t + 50.0 * t * t - p;
                p += gains.position * error;
                v += gains.velocity * error;
                a += gains.acceleration * error;
            }
            assert!(error.abs() < 1e-6, "{time}: {error}");
            assert!((a - 100.0).abs() < 1e-3, "{time}: {a}");
        }
    }
}
