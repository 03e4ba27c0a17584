//! Reading a PLC by polling: the index, the images, and the index again.
//!
//! Each read is of one moment, but between two reads the PLC may have begun its next cycle. So images
//! only count if the index before them and the index after them are equal.

use coaxle_clock::CycleIndex;

/// Greatest number of reads of the images in one poll, before it counts as torn.
// A third failure means that reading takes a whole cycle: another attempt would be torn as well.
const ATTEMPTS: u32 = 3;

/// The memory of a PLC, one read at a time.
pub trait PlcMemory {
    /// Error of a read.
    type Error;

    /// Reads the cycle index. An implementation keeps the time of the reply.
    ///
    /// # Errors
    /// A lost PLC, or its refusal.
    fn read_index(&mut self) -> Result<CycleIndex, Self::Error>;

    /// Reads all images.
    ///
    /// # Errors
    /// A lost PLC, or its refusal.
    fn read_images(&mut self) -> Result<(), Self::Error>;

    /// Keeps the read time of the newest index but one, which is that of the images.
    fn keep_arrival(&mut self);
}

/// Result of a poll.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Polled {
    /// The index is that of the previous poll.
    Nothing,
    /// The images of this cycle.
    Images(CycleIndex),
    /// Torn images: the PLC was faster in every attempt.
    Torn,
}

/// Reads the images of a cycle, unless it is the one of index `before`.
///
/// # Errors
/// Those of the memory.
pub fn poll<M: PlcMemory>(memory: &mut M, before: Option<CycleIndex>) -> Result<Polled, M::Error> {
    let mut index = memory.read_index()?;
    // The usual case: twice as many polls as cycles.
    if Some(index) == before {
        return Ok(Polled::Nothing);
    }
    for _ in 0..ATTEMPTS {
        // Again with each attempt: the arrival belongs to the index that the images are compared with.
        memory.keep_arrival();
        memory.read_images()?;
        let after = memory.read_index()?;
        if after == index {
            return Ok(Polled::Images(index));
        }
        // The later index may fit the next images.
        index = after;
    }
    Ok(Polled::Torn)
}

/// The pauses between polls, in parts of the period: from a half to one and a half, evenly distributed,
/// and never in step with the PLC.
///
/// Polls at constant intervals would lie at the same phase of the PLC's cycles for a long time, as both
/// are steady, and then jump by one interval: a beat from which no estimator can find the PLC's clock.
/// Distributed like this, each read has a random delay after the PLC's cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct PollPauses {
    phase: u32,
}

impl PollPauses {
    /// Returns the next pause.
    pub fn next_part(&mut self) -> f64 {
        // A congruential sequence of full period 2³² (Hull and Dobell: 5 − 1 is divisible by 4, and the increment 2³²/φ is odd).
        const GOLDEN: u32 = 2_654_435_769;
        self.phase = self.phase.wrapping_mul(5).wrapping_add(GOLDEN);
        // The low bits of such a sequence are poor, the high ones good.
        // 24 bits of a float: exact, and from 0.5 to below 1.5.
        0.5 + f64::from(self.phase >> 8) / f64::from(1_u32 << 24)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// A PLC whose index increases after this number of reads.
    struct Memory {
        reads: u32,
        reads_per_cycle: u32,
        images_of: u16,
        kept: u32,
    }

    impl Memory {
        const fn new(reads_per_cycle: u32) -> Self {
            Self {
                reads: 0,
                reads_per_cycle,
                images_of: 0,
                kept: 0,
            }
        }

        fn cycle(&mut self) -> u16 {
            self.reads += 1;
            ((self.reads - 1) / self.reads_per_cycle) as u16
        }
    }

    impl PlcMemory for Memory {
        type Error = Infallible;

        fn read_index(&mut self) -> Result<CycleIndex, Infallible> {
            Ok(CycleIndex(self.cycle()))
        }

        fn read_images(&mut self) -> Result<(), Infallible> {
            self.images_of = self.cycle();
            Ok(())
        }

        fn keep_arrival(&mut self) {
            self.kept += 1;
        }
    }

    #[test]
    fn images_are_of_the_cycle_of_the_index_however_the_reads_fall() {
        for reads_per_cycle in 2..12 {
            let mut memory = Memory::new(reads_per_cycle);
            let (mut before, mut found) = (None, 0);
            for _ in 0..200 {
                if let Polled::Images(index) = poll(&mut memory, before).unwrap() {
                    assert_eq!(memory.images_of, index.0, "{reads_per_cycle}");
                    before = Some(index);
                    found += 1;
                }
            }
            // With two reads per cycle index, images and index never fall into one cycle.
            let expected = if reads_per_cycle > 2 { 10 } else { 0 };
            assert!(found >= expected, "{reads_per_cycle}: {found}");
        }
    }

    #[test]
    fn a_plc_that_is_faster_than_three_reads_is_torn_and_does_not_hang() {
        let mut memory = Memory::new(1);
        assert_eq!(poll(&mut memory, None).unwrap(), Polled::Torn);
        assert_eq!(memory.kept, 3);
    }

    #[test]
    fn an_index_that_was_there_costs_one_read() {
        let mut memory = Memory::new(100);
        let first = CycleIndex(0);
        assert_eq!(poll(&mut memory, None).unwrap(), Polled::Images(first));
        assert_eq!(poll(&mut memory, Some(first)).unwrap(), Polled::Nothing);
        // Index, images and index of the first poll, and the index of the second.
        assert_eq!(memory.reads, 4);
    }

    #[test]
    fn pauses_are_spread_evenly_and_so_are_the_polls_within_a_cycle() {
        let mut pauses = PollPauses::default();
        let (mut of_pause, mut of_phase, mut at) = ([0_u32; 10], [0_u32; 10], 0.0);
        for _ in 0..10_000 {
            let part = pauses.next_part();
            assert!((0.5..1.5).contains(&part));
            of_pause[((part - 0.5) * 10.0) as usize] += 1;
            // The pauses are in parts of half a cycle.
            // A cycle takes two periods.
            at += part;
            of_phase[((at / 2.0 % 1.0) * 10.0) as usize] += 1;
        }
        for share in of_pause.iter().chain(&of_phase) {
            // 1000 in each tenth, with a fifth to either side.
            assert!((800..1_200).contains(share), "{of_pause:?} {of_phase:?}");
        }
    }
}
