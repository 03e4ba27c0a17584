//! A sequence lock: a block of words that one side writes and another reads, whole or not at all.

use std::sync::atomic::{AtomicU64, Ordering, fence};

/// Number of reads before a block counts as torn.
// A write is ten stores at most: four torn reads in a row mean a writer that was interrupted, or died.
const TRIES: usize = 4;

/// Writes the words behind the sequence. Only one writer is allowed.
pub(super) fn write<const N: usize>(sequence: &AtomicU64, words: &[AtomicU64], values: [u64; N]) {
    // Odd from here on, even if an earlier writer died in the middle.
    // `| 1` repairs an odd number left by a dead writer: adding one to it would make it even while writing.
    let open = sequence.load(Ordering::Relaxed).wrapping_add(1) | 1;
    sequence.store(open, Ordering::Relaxed);
    // A reader that sees one of the new values sees the odd number too.
    // The words themselves are stored relaxed: the fence orders all of them after the odd number.
    fence(Ordering::Release);
    for (word, value) in words.iter().zip(values) {
        word.store(value, Ordering::Relaxed);
    }
    // A reader that sees the even number sees all of the new values.
    sequence.store(open.wrapping_add(1), Ordering::Release);
}

/// Reads the words behind the sequence as one consistent write; none while they are being written.
pub(super) fn read<const N: usize>(sequence: &AtomicU64, words: &[AtomicU64]) -> Option<[u64; N]> {
    (0..TRIES).find_map(|_| {
        let before = sequence.load(Ordering::Acquire);
        if before % 2 == 1 {
            return None;
        }
        let mut values = [0; N];
        for (value, word) in values.iter_mut().zip(words) {
            *value = word.load(Ordering::Relaxed);
        }
        // The values are read before the sequence is read again.
        fence(Ordering::Acquire);
        // An equal sequence on both sides: no write began or ended between the two loads.
        (sequence.load(Ordering::Relaxed) == before).then_some(values)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicBool;

    fn words<const N: usize>() -> [AtomicU64; N] {
        std::array::from_fn(|_| AtomicU64::new(0))
    }

    #[test]
    fn what_is_being_written_is_not_read() {
        let (sequence, words) = (AtomicU64::new(0), words::<3>());
        write(&sequence, &words, [1, 2, 3]);
        assert_eq!(read(&sequence, &words), Some([1, 2, 3]));
        // Odd, as by a writer that died between the two stores.
        sequence.fetch_add(1, Ordering::Relaxed);
        assert_eq!(read::<3>(&sequence, &words), None);
        // The next writer repairs it.
        write(&sequence, &words, [4, 5, 6]);
        assert_eq!(read(&sequence, &words), Some([4, 5, 6]));
    }

    #[test]
    fn what_is_read_was_written_together() {
        let (sequence, words) = (AtomicU64::new(0), words::<8>());
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                // As many as take some milliseconds: the reader meets writers at all of their steps.
                for n in 0..200_000 {
                    write(&sequence, &words, [n; 8]);
                }
                over.store(true, Ordering::Relaxed);
            });
            let mut last = 0;
            while !over.load(Ordering::Relaxed) {
                let Some(values) = read::<8>(&sequence, &words) else {
                    continue;
                };
                assert!(values.iter().all(|value| *value == values[0]), "{values:?}");
                // Values only grow: an older block after a newer one would be a stale read.
                assert!(values[0] >= last);
                last = values[0];
            }
        });
        assert_eq!(read(&sequence, &words), Some([199_999; 8]));
    }
}
