//! Random numbers, reproducible by seed.

/// SplitMix64.
#[derive(Clone, Debug)]
pub(super) struct Random(u64);

impl Random {
    pub(super) const fn seeded(seed: u64) -> Self {
        Self(seed.wrapping_mul(0xD134_2543_DE82_EF95))
    }

    fn next(&mut self) -> u64 {
        // 2⁶⁴ divided by the golden ratio, as in Steele, Lea, Flood: Fast splittable pseudorandom number
        // generators (2014).
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number between two others.
    pub(super) fn between(&mut self, from: f64, to: f64) -> f64 {
        // 53 bits, as many as a double has.
        from + (to - from) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number between two others, with every decade equally likely.
    pub(super) fn decades(&mut self, from: f64, to: f64) -> f64 {
        libm::pow(10.0, self.between(libm::log10(from), libm::log10(to)))
    }

    /// True with this probability in percent.
    pub(super) fn percent(&mut self, times: u32) -> bool {
        self.next() % 100 < u64::from(times)
    }

    /// A number below another.
    pub(super) fn below(&mut self, number: u32) -> u32 {
        (self.next() % u64::from(number)) as u32
    }
}
