//! Random delays for tests.

/// Xorshift: the same numbers on every machine.
#[derive(Clone)]
pub(in crate::observer) struct Random(u64);

impl Random {
    pub(in crate::observer) const fn of_state(state: u64) -> Self {
        Self(state)
    }

    pub(in crate::observer) fn of_seed(seed: u64) -> Self {
        let mut random = Self((seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
        // Neighbouring seeds begin alike.
        for _ in 0..16 {
            let _ = random.uniform();
        }
        random
    }

    pub(in crate::observer) fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// Normal variable of standard deviation 1.
    pub(in crate::observer) fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(self.uniform()));
        radius * libm::cos(core::f64::consts::TAU * self.uniform())
    }

    /// Exponential variable of mean 1.
    pub(in crate::observer) fn exponential(&mut self) -> f64 {
        -libm::log(self.uniform())
    }
}

/// A delay whose neighbouring values are alike.
#[derive(Clone, Copy)]
pub(in crate::observer) enum Correlated {
    /// Two levels, the upper one at `height`, each held for this mean time, s.
    Telegraph {
        height: f64,
        held: f64,
        upper: bool,
        remaining: f64,
    },
    /// The magnitude of a first-order autoregressive process of this standard deviation and time
    /// constant, s. The value is in standard deviations.
    HalfNormal { width: f64, time: f64, value: f64 },
}

impl Correlated {
    pub(in crate::observer) const fn telegraph(height: f64, held: f64) -> Self {
        Self::Telegraph {
            height,
            held,
            upper: true,
            remaining: 0.0,
        }
    }

    pub(in crate::observer) const fn half_normal(width: f64, time: f64) -> Self {
        Self::HalfNormal {
            width,
            time,
            value: 1.0,
        }
    }

    /// The delay `passed` seconds after the previous one.
    pub(in crate::observer) fn after(&mut self, passed: f64, random: &mut Random) -> f64 {
        match self {
            Self::Telegraph {
                height,
                held,
                upper,
                remaining,
            } => {
                *remaining -= passed;
                if *remaining <= 0.0 {
                    *upper = !*upper;
                    *remaining = *held * random.exponential();
                }
                if *upper { *height } else { 0.0 }
            }
            Self::HalfNormal { width, time, value } => {
                let kept = libm::exp(-passed / *time);
                *value = kept * *value + libm::sqrt(1.0 - kept * kept) * random.normal();
                *width * libm::fabs(*value)
            }
        }
    }
}
