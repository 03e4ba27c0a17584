//! Values read from bytes: small inputs state long sequences, and any byte is a valid one.

/// The rest of an input.
pub(crate) struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    pub(crate) const fn new(data: &'a [u8]) -> Self {
        Self(data)
    }

    pub(crate) fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    pub(crate) fn bit(&mut self) -> Option<bool> {
        Some(self.byte()? & 1 == 1)
    }

    pub(crate) fn word(&mut self) -> Option<i16> {
        Some(i16::from_le_bytes([self.byte()?, self.byte()?]))
    }

    /// A number from -1 to 1, of 16 bits.
    pub(crate) fn share(&mut self) -> Option<f64> {
        Some(f64::from(self.word()?) / f64::from(i16::MAX))
    }

    /// A number in these decades, spread evenly over them, of 8 bits.
    pub(crate) fn decades(&mut self, from: f64, to: f64) -> Option<f64> {
        let share = f64::from(self.byte()?) / 255.0;
        Some(10_f64.powf(from + share * (to - from)))
    }

    /// A number or none.
    pub(crate) fn option(
        &mut self,
        number: impl FnOnce(&mut Self) -> Option<f64>,
    ) -> Option<Option<f64>> {
        Some(if self.bit()? {
            Some(number(self)?)
        } else {
            None
        })
    }

    pub(crate) fn one_of<T: Copy>(&mut self, these: &[T]) -> Option<T> {
        these.get(usize::from(self.byte()?) % these.len()).copied()
    }
}
