//! The axis structure as the 128 bytes that a controller keeps in its memory.

use super::{AxisState, CoupleState, NcToPlcAxis, StateWord};

/// Length of an axis image, bytes.
pub const IMAGE_LEN: usize = 128;

/// Controller of an image: both are packed and little-endian, and differ in the meaning of the
/// bytes at 40…43 and 104…127.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImageLayout {
    /// `NCTOPLC_AXLESTRUCT` of TS5066: these bytes are reserved. They are written as zero and
    /// ignored on reading.
    #[doc(alias = "NCTOPLC_AXLESTRUCT")]
    TwinCat2,
    /// `AXIS_REF.NcToPlc`: these bytes hold the control loops, the target position, the modulo set
    /// position and the current command.
    #[doc(alias = "NCTOPLC_AXIS_REF")]
    AxisRef,
}

impl NcToPlcAxis {
    /// The axis as the bytes of a controller's memory. Every field of the layout is kept, including
    /// unnamed bits and codes.
    #[must_use]
    pub fn to_image(&self, layout: ImageLayout) -> [u8; IMAGE_LEN] {
        let mut image = [0; IMAGE_LEN];
        self.write_common(&mut image);
        match layout {
            ImageLayout::TwinCat2 => {}
            ImageLayout::AxisRef => self.write_named_by_axis_ref(&mut image),
        }
        image
    }

    /// Reads the axis from the bytes of a controller's memory. Every image is an axis;
    /// [`Self::implausible_field`] checks its kinematic values.
    #[must_use]
    pub fn from_image(layout: ImageLayout, image: &[u8; IMAGE_LEN]) -> Self {
        let mut axis = Self::read_common(image);
        match layout {
            ImageLayout::TwinCat2 => {}
            ImageLayout::AxisRef => axis.read_named_by_axis_ref(image),
        }
        axis
    }

    /// Reads the axis from bytes of any length.
    ///
    /// # Errors
    /// [`ImageLengthError`] unless there are exactly [`IMAGE_LEN`] bytes.
    pub fn from_image_slice(layout: ImageLayout, bytes: &[u8]) -> Result<Self, ImageLengthError> {
        bytes
            .try_into()
            .map(|image| Self::from_image(layout, image))
            .map_err(|_| ImageLengthError {
                received: bytes.len(),
            })
    }

    fn write_common(&self, image: &mut [u8; IMAGE_LEN]) {
        put(image, 0, self.state_word.bits().to_le_bytes());
        put(image, 4, self.error_code.to_le_bytes());
        put(image, 8, u32::from(self.axis_state).to_le_bytes());
        put(image, 12, self.axis_mode.to_le_bytes());
        put(image, 16, self.calibration_state.to_le_bytes());
        put(image, 20, u32::from(self.couple_state).to_le_bytes());
        put(image, 24, self.svb_entries.to_le_bytes());
        put(image, 28, self.saf_entries.to_le_bytes());
        put(image, 32, self.axis_id.to_le_bytes());
        put(image, 36, self.op_mode.to_le_bytes());
        // Packed: 44 is no multiple of 8, so the bytes are copied and no struct is laid over them.
        put(image, 44, self.actual_position.to_le_bytes());
        put(image, 52, self.modulo_actual_position.to_le_bytes());
        put(image, 60, self.modulo_actual_turns.to_le_bytes());
        put(image, 64, self.actual_velocity.to_le_bytes());
        put(image, 72, self.following_error.to_le_bytes());
        put(image, 80, self.set_position.to_le_bytes());
        put(image, 88, self.set_velocity.to_le_bytes());
        put(image, 96, self.set_acceleration.to_le_bytes());
    }

    fn read_common(image: &[u8; IMAGE_LEN]) -> Self {
        Self {
            state_word: StateWord::from_bits_retain(u32_at(image, 0)),
            error_code: u32_at(image, 4),
            axis_state: AxisState::from(u32_at(image, 8)),
            axis_mode: u32_at(image, 12),
            calibration_state: u32_at(image, 16),
            couple_state: CoupleState::from(u32_at(image, 20)),
            svb_entries: u32_at(image, 24),
            saf_entries: u32_at(image, 28),
            axis_id: u32_at(image, 32),
            op_mode: u32_at(image, 36),
            actual_position: f64_at(image, 44),
            modulo_actual_position: f64_at(image, 52),
            modulo_actual_turns: i32_at(image, 60),
            actual_velocity: f64_at(image, 64),
            following_error: f64_at(image, 72),
            set_position: f64_at(image, 80),
            set_velocity: f64_at(image, 88),
            set_acceleration: f64_at(image, 96),
            ..Self::default()
        }
    }

    fn write_named_by_axis_ref(&self, image: &mut [u8; IMAGE_LEN]) {
        put(image, 40, self.active_control_loop.to_le_bytes());
        put(image, 42, self.control_loop.to_le_bytes());
        put(image, 104, self.target_position.to_le_bytes());
        put(image, 112, self.modulo_set_position.to_le_bytes());
        put(image, 120, self.modulo_set_turns.to_le_bytes());
        put(image, 124, self.command_number.to_le_bytes());
        put(image, 126, self.command_state.to_le_bytes());
    }

    fn read_named_by_axis_ref(&mut self, image: &[u8; IMAGE_LEN]) {
        self.active_control_loop = u16_at(image, 40);
        self.control_loop = u16_at(image, 42);
        self.target_position = f64_at(image, 104);
        self.modulo_set_position = f64_at(image, 112);
        self.modulo_set_turns = i32_at(image, 120);
        self.command_number = u16_at(image, 124);
        self.command_state = u16_at(image, 126);
    }
}

/// Bytes that are not an axis image, because of their number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("axis image: received {received} bytes, expected {IMAGE_LEN}")]
pub struct ImageLengthError {
    /// Number of bytes received.
    pub received: usize,
}

fn put<const N: usize>(image: &mut [u8; IMAGE_LEN], offset: usize, bytes: [u8; N]) {
    // Offsets are constants of this file, which a test proves to fill the image exactly.
    image[offset..offset + N].copy_from_slice(&bytes);
}

fn take<const N: usize>(image: &[u8; IMAGE_LEN], offset: usize) -> [u8; N] {
    core::array::from_fn(|i| image[offset + i])
}

fn u16_at(image: &[u8; IMAGE_LEN], offset: usize) -> u16 {
    u16::from_le_bytes(take(image, offset))
}

fn u32_at(image: &[u8; IMAGE_LEN], offset: usize) -> u32 {
    u32::from_le_bytes(take(image, offset))
}

fn i32_at(image: &[u8; IMAGE_LEN], offset: usize) -> i32 {
    i32::from_le_bytes(take(image, offset))
}

fn f64_at(image: &[u8; IMAGE_LEN], offset: usize) -> f64 {
    f64::from_le_bytes(take(image, offset))
}

#[cfg(test)]
mod tests {
    use super::ImageLayout::{AxisRef, TwinCat2};
    use super::*;
    use proptest::prelude::*;
    use std::string::ToString;
    use std::vec::Vec;

    /// The manuals' structures as data: PLC name, first byte, and an axis in which only that field
    /// holds the bytes 01, 02, 03 …
    struct Field {
        name: &'static str,
        offset: usize,
        len: usize,
        axis: NcToPlcAxis,
    }

    macro_rules! fields {
        ($($name:literal $offset:literal $len:literal $field:ident = $value:expr;)*) => {
            [$(Field {
                name: $name,
                offset: $offset,
                len: $len,
                axis: NcToPlcAxis { $field: $value, ..NcToPlcAxis::default() },
            },)*]
        };
    }

    const U16: u16 = 0x0201;
    const U32: u32 = 0x0403_0201;
    const I32: i32 = 0x0403_0201;

    fn real() -> f64 {
        // Bytes 01 to 08 in little-endian order: a field at a wrong offset or reversed shows.
        f64::from_bits(0x0807_0605_0403_0201)
    }

    fn fields_of_both() -> [Field; 18] {
        fields! {
            "nStateDWord" 0 4 state_word = StateWord::from_bits_retain(U32);
            "nErrorCode" 4 4 error_code = U32;
            "nAxisState" 8 4 axis_state = AxisState::Other(U32);
            "nAxisModeCon" 12 4 axis_mode = U32;
            "nCalibrationState" 16 4 calibration_state = U32;
            "nCoupleState" 20 4 couple_state = CoupleState::Other(U32);
            "nSvbEntries" 24 4 svb_entries = U32;
            "nSafEntries" 28 4 saf_entries = U32;
            "nAxisId" 32 4 axis_id = U32;
            "nOpModeDWord" 36 4 op_mode = U32;
            "fPosIst" 44 8 actual_position = real();
            "fModuloPosIst" 52 8 modulo_actual_position = real();
            "nModuloTurns" 60 4 modulo_actual_turns = I32;
            "fVeloIst" 64 8 actual_velocity = real();
            "fPosDiff" 72 8 following_error = real();
            "fPosSoll" 80 8 set_position = real();
            "fVeloSoll" 88 8 set_velocity = real();
            "fAccSoll" 96 8 set_acceleration = real();
        }
    }

    fn fields_of_axis_ref_only() -> [Field; 7] {
        fields! {
            "nActiveControlLoopIndex" 40 2 active_control_loop = U16;
            "nControlLoopIndex" 42 2 control_loop = U16;
            "TargetPos" 104 8 target_position = real();
            "ModuloSetPos" 112 8 modulo_set_position = real();
            "ModuloSetTurns" 120 4 modulo_set_turns = I32;
            "CmdNo" 124 2 command_number = U16;
            "CmdState" 126 2 command_state = U16;
        }
    }

    fn image_of(field: &Field) -> [u8; IMAGE_LEN] {
        let mut image = [0; IMAGE_LEN];
        for i in 0..field.len {
            image[field.offset + i] = i as u8 + 1;
        }
        image
    }

    #[test]
    fn every_field_lies_at_its_offset_and_nowhere_else() {
        for field in fields_of_both() {
            for layout in [TwinCat2, AxisRef] {
                let (name, image) = (field.name, image_of(&field));
                assert_eq!(field.axis.to_image(layout), image, "{name} {layout:?}");
                assert_eq!(
                    NcToPlcAxis::from_image(layout, &image),
                    field.axis,
                    "{name}"
                );
            }
        }
        for field in fields_of_axis_ref_only() {
            let (name, image) = (field.name, image_of(&field));
            assert_eq!(field.axis.to_image(AxisRef), image, "{name}");
            assert_eq!(
                NcToPlcAxis::from_image(AxisRef, &image),
                field.axis,
                "{name}"
            );
        }
    }

    #[test]
    fn the_fields_fill_the_image_without_gap_or_overlap() {
        let mut covered = [0; IMAGE_LEN];
        for field in fields_of_both().iter().chain(&fields_of_axis_ref_only()) {
            for byte in &mut covered[field.offset..field.offset + field.len] {
                *byte += 1;
            }
        }
        assert_eq!(covered, [1; IMAGE_LEN]);
    }

    #[test]
    fn what_the_older_layout_reserves_is_zero_on_writing_and_ignored_on_reading() {
        for field in fields_of_axis_ref_only() {
            assert_eq!(
                field.axis.to_image(TwinCat2),
                [0; IMAGE_LEN],
                "{}",
                field.name
            );
            let read = NcToPlcAxis::from_image(TwinCat2, &image_of(&field));
            assert_eq!(read, NcToPlcAxis::default(), "{}", field.name);
        }
    }

    #[test]
    fn a_wrong_length_says_what_came_and_what_fits() {
        let bytes = [0; IMAGE_LEN + 1];
        assert!(NcToPlcAxis::from_image_slice(AxisRef, &bytes[..IMAGE_LEN]).is_ok());
        for len in [0, IMAGE_LEN - 1, IMAGE_LEN + 1] {
            let error = NcToPlcAxis::from_image_slice(AxisRef, &bytes[..len]).unwrap_err();
            assert_eq!(error, ImageLengthError { received: len });
        }
        assert_eq!(
            ImageLengthError { received: 127 }.to_string(),
            "axis image: received 127 bytes, expected 128"
        );
    }

    fn any_image() -> impl Strategy<Value = [u8; IMAGE_LEN]> {
        let bytes = proptest::collection::vec(any::<u8>(), IMAGE_LEN);
        bytes.prop_map(|bytes: Vec<u8>| bytes.try_into().unwrap())
    }

    proptest! {
        #[test]
        fn every_image_comes_back_bit_for_bit(image in any_image()) {
            let axis = NcToPlcAxis::from_image(AxisRef, &image);
            prop_assert_eq!(axis.to_image(AxisRef), image);
        }

        #[test]
        fn the_older_layout_loses_only_what_it_reserves(image in any_image()) {
            let axis = NcToPlcAxis::from_image(TwinCat2, &image);
            let mut kept = image;
            kept[40..44].fill(0);
            kept[104..].fill(0);
            prop_assert_eq!(axis.to_image(TwinCat2), kept);
        }
    }
}
