//! Notifications: samples with the stamps of the PLC.

use super::u32_at;

/// A value sent by the PLC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotifiedSample<'a> {
    /// Time stamp of the PLC: 100 ns since 1601. Values sent in one cycle have equal stamps.
    pub stamp: u64,
    /// The handle of the notification.
    pub handle: u32,
    /// The value.
    pub data: &'a [u8],
}

/// Passes on each sample of a notification. Returns false if the notification ends in the middle of one;
/// the samples before it have been passed on.
pub fn notified(data: &[u8], mut each: impl FnMut(&NotifiedSample<'_>)) -> bool {
    walk(data, &mut each).is_some()
}

fn walk(data: &[u8], each: &mut impl FnMut(&NotifiedSample<'_>)) -> Option<()> {
    // The first number is the length of the rest, which is known.
    // Bounded by the bytes themselves: a count of 2³² stamps ends with the first one that is not there.
    let stamps = u32_at(data, 4)?;
    let mut rest = data.get(8..)?;
    for _ in 0..stamps {
        let (low, high) = (u32_at(rest, 0)?, u32_at(rest, 4)?);
        // Two halves: the crate reads numbers of four bytes only, and the stamp has eight.
        let stamp = u64::from(low) | u64::from(high) << 32;
        let samples = u32_at(rest, 8)?;
        rest = rest.get(12..)?;
        for _ in 0..samples {
            let (handle, length) = (u32_at(rest, 0)?, u32_at(rest, 4)? as usize);
            let data = rest.get(8..)?.get(..length)?;
            // The slice was taken above, so that the rest is not shorter.
            rest = &rest[8 + length..];
            each(&NotifiedSample {
                stamp,
                handle,
                data,
            });
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Two stamps, of two samples and of one.
    // Each number has its lowest byte first, as in Beckhoff's *ADS commands*, "ADS Device Notification".
    const TWO: [u8; 68] = [
        64, 0, 0, 0, 2, 0, 0, 0, // length, stamps
        1, 2, 3, 4, 5, 6, 7, 8, 2, 0, 0, 0, // stamp, samples
        10, 0, 0, 0, 2, 0, 0, 0, 0xaa, 0xbb, // handle, length, data
        11, 0, 0, 0, 4, 0, 0, 0, 1, 2, 3, 4, //
        2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, //
        10, 0, 0, 0, 6, 0, 0, 0, 9, 8, 7, 6, 5, 4,
    ];

    #[test]
    fn every_sample_is_shown_with_its_stamp() {
        let mut shown = Vec::new();
        assert!(notified(&TWO, |sample| {
            shown.push((sample.stamp, sample.handle, sample.data.len()));
        }));
        let first = 0x0807_0605_0403_0201;
        assert_eq!(shown, [(first, 10, 2), (first, 11, 4), (2, 10, 6)]);
    }

    #[test]
    fn one_that_ends_too_early_says_so() {
        // Also without the last byte: a value cut at its end is no value.
        for length in 0..TWO.len() {
            assert!(!notified(&TWO[..length], |_| {}), "{length}");
        }
    }

    proptest! {
        #[test]
        fn no_bytes_do_harm(bytes in proptest::collection::vec(any::<u8>(), 0..100)) {
            let _ = notified(&bytes, |_| {});
        }
    }
}
