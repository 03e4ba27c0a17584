//! A record: the cycle index and the images of one cycle, in datagrams and binary pipes.
//!
//! The index is two bytes, lowest first, and the images follow it without gaps: a structure of a `UINT` and the
//! images in a PLC, packed to one byte (`{attribute 'pack_mode' := '1'}`).

use coaxle_axis::{IMAGE_LEN, ImageLayout, NcToPlcAxis};
use coaxle_clock::CycleIndex;

use crate::config::ImageKind;
use crate::external_set_values::{EXTERNAL_SET_VALUES_LEN, external_set_values};

/// Bytes of the index.
const INDEX_LEN: usize = 2;

/// Returns the length of a record of this number of axes, bytes.
#[must_use]
pub const fn record_len(axes: usize) -> usize {
    INDEX_LEN + axes * IMAGE_LEN
}

/// Reads the index and the axes of a record of `axes.len()` axes.
///
/// # Errors
/// [`RecordLengthError`] if its length is wrong.
pub fn read_record(
    layout: ImageLayout,
    bytes: &[u8],
    axes: &mut [NcToPlcAxis],
) -> Result<CycleIndex, RecordLengthError> {
    let wrong = RecordLengthError {
        received: bytes.len(),
        expected: record_len(axes.len()),
    };
    // Wholly, before any axis is changed: half a record would mix two cycles.
    if bytes.len() != wrong.expected {
        return Err(wrong);
    }
    let (index, images) = bytes.split_at(INDEX_LEN);
    for (axis, image) in axes.iter_mut().zip(images.chunks_exact(IMAGE_LEN)) {
        // `chunks_exact` gives images of the right length only.
        *axis = NcToPlcAxis::from_image_slice(layout, image).map_err(|_| wrong)?;
    }
    Ok(CycleIndex(u16::from_le_bytes([index[0], index[1]])))
}

/// Appends the image of an axis to a record.
pub fn write_image(kind: ImageKind, layout: ImageLayout, axis: &NcToPlcAxis, out: &mut Vec<u8>) {
    match kind {
        ImageKind::NcToPlc => out.extend_from_slice(&axis.to_image(layout)),
        ImageKind::ExternalSetValues => out.extend_from_slice(&external_set_values(axis)),
    }
}

/// Returns the length of an image of this kind, bytes.
#[must_use]
pub const fn image_len(kind: ImageKind) -> usize {
    match kind {
        ImageKind::NcToPlc => IMAGE_LEN,
        ImageKind::ExternalSetValues => EXTERNAL_SET_VALUES_LEN,
    }
}

/// Error of bytes that are not a record of the axes of the config.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a record of {received} bytes came, expected {expected}: the cycle index and the images of the axes"
)]
pub struct RecordLengthError {
    /// Bytes received.
    pub received: usize,
    /// Bytes expected.
    pub expected: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_the_index_and_then_the_images() {
        let axis = |id| NcToPlcAxis {
            axis_id: id,
            set_position: f64::from(id) * 0.5,
            ..NcToPlcAxis::default()
        };
        let axes = [axis(3), axis(4)];
        let mut bytes = vec![0x34, 0x12];
        for axis in &axes {
            write_image(ImageKind::NcToPlc, ImageLayout::TwinCat2, axis, &mut bytes);
        }
        assert_eq!(bytes.len(), record_len(2));
        let mut read = [NcToPlcAxis::default(); 2];
        let index = read_record(ImageLayout::TwinCat2, &bytes, &mut read);
        assert_eq!(index, Ok(CycleIndex(0x1234)));
        assert_eq!(read, axes);
        // A byte less, nothing, and a byte more.
        for wrong in [&bytes[..257], &[][..], &[&bytes[..], &[0]].concat()] {
            let error = read_record(ImageLayout::TwinCat2, wrong, &mut read).unwrap_err();
            let received = wrong.len();
            // Two bytes, and twice 128.
            let expected = 258;
            assert_eq!(error, RecordLengthError { received, expected });
        }
    }
}
