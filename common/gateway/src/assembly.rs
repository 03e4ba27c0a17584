//! Samples out of cyclic notifications: parts with equal stamps are of the same cycle.

/// Assembles the parts of a sample: the index is part 0, the images of the axes follow.
///
/// A PLC gives one stamp to all values of a cycle. A part with another stamp than those before begins
/// another sample; the previous one, if incomplete, is dropped.
#[derive(Clone, Debug)]
pub struct Assembly {
    parts: Box<[Vec<u8>]>,
    has: Box<[bool]>,
    stamp: Option<u64>,
    is_done: bool,
    torn: u64,
}

impl Assembly {
    /// Makes an assembly of parts of these lengths, bytes.
    #[must_use]
    pub fn of(lengths: &[usize]) -> Self {
        Self {
            parts: lengths.iter().map(|length| vec![0; *length]).collect(),
            has: vec![false; lengths.len()].into(),
            stamp: None,
            is_done: false,
            torn: 0,
        }
    }

    /// Takes a part with this stamp; true if it completes the sample.
    ///
    /// # Errors
    /// [`WrongPart`] if its length is wrong, or the part does not exist.
    pub fn take(&mut self, stamp: u64, part: usize, bytes: &[u8]) -> Result<bool, WrongPart> {
        // A part that does not exist has no bytes, so that it fits nothing.
        let expected = self.parts.get(part).map_or(0, Vec::len);
        if bytes.len() != expected || expected == 0 {
            let received = bytes.len();
            return Err(WrongPart {
                part,
                received,
                expected,
            });
        }
        if self.stamp != Some(stamp) {
            // Only a sample that has begun, and was never whole, is torn.
            self.torn += u64::from(self.stamp.is_some() && !self.is_done);
            self.stamp = Some(stamp);
            self.is_done = false;
            // Parts of the earlier stamp would be mixed with those of this cycle.
            self.has.fill(false);
        }
        self.parts[part].copy_from_slice(bytes);
        self.has[part] = true;
        // A PLC may send a value twice in a cycle: only the first time makes the sample whole.
        let is_whole = !self.is_done && self.has.iter().all(|has| *has);
        self.is_done |= is_whole;
        Ok(is_whole)
    }

    /// Returns the parts of the last complete sample.
    #[must_use]
    pub fn parts(&self) -> &[Vec<u8>] {
        &self.parts
    }

    /// Returns the number of samples that were never complete.
    #[must_use]
    pub const fn torn(&self) -> u64 {
        self.torn
    }
}

/// A notification of something else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("part {part} of a sample: {received} bytes came, expected {expected}")]
pub struct WrongPart {
    /// Number of the part: 0 is the index.
    pub part: usize,
    /// Bytes received.
    pub received: usize,
    /// Bytes expected.
    pub expected: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_whole_when_all_its_parts_came_with_one_stamp() {
        let mut assembly = Assembly::of(&[2, 3]);
        assert_eq!(assembly.take(10, 1, &[1, 2, 3]), Ok(false));
        assert_eq!(assembly.take(10, 0, &[9, 0]), Ok(true));
        assert_eq!(assembly.parts(), [vec![9, 0], vec![1, 2, 3]]);
        // A repeated part does not complete the sample again.
        assert_eq!(assembly.take(10, 0, &[9, 0]), Ok(false));
        assert_eq!(assembly.take(20, 0, &[10, 0]), Ok(false));
        // The sample of stamp 20 has one part only when stamp 30 begins.
        assert_eq!(assembly.take(30, 1, &[4, 5, 6]), Ok(false));
        assert_eq!(assembly.torn(), 1);
        assert_eq!(assembly.take(30, 0, &[11, 0]), Ok(true));
        assert_eq!(assembly.torn(), 1);
    }

    #[test]
    fn what_is_of_another_length_or_no_part_is_refused() {
        let mut assembly = Assembly::of(&[2]);
        for (part, bytes) in [(0, &[1][..]), (0, &[1, 2, 3]), (1, &[1, 2]), (1, &[])] {
            let error = assembly.take(1, part, bytes).unwrap_err();
            assert_eq!((error.part, error.received), (part, bytes.len()));
        }
        assert_eq!(assembly.take(1, 0, &[1, 2]), Ok(true));
    }
}
