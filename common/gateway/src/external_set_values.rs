//! Input of `MC_ExtSetPointGenFeed`: external set values for an axis of the PLC.

use coaxle_axis::NcToPlcAxis;

/// Length of that image, bytes: three `LREAL` and a `DINT`.
pub const EXTERNAL_SET_VALUES_LEN: usize = 28;

/// Returns `ExtSetPos`, `ExtSetVelo`, `ExtSetAcc` and `ExtSetDirection`: the bytes of `PLCTONC_AXIS_REF`
/// for external set value generation, without gaps, lowest byte first. The others (enabling, override)
/// are for the PLC's own program.
///
/// Position in u, velocity in u/s, acceleration in u/s²; the direction is 1, 0 or −1, that of the velocity.
#[doc(alias = "MC_ExtSetPointGenFeed")]
#[doc(alias = "PLCTONC_AXIS_REF")]
#[must_use]
pub fn external_set_values(axis: &NcToPlcAxis) -> [u8; EXTERNAL_SET_VALUES_LEN] {
    let velocity = axis.set_velocity;
    // Not `signum`: that of 0.0 is 1, and the block would take a direction at standstill.
    let direction = i32::from(velocity > 0.0) - i32::from(velocity < 0.0);
    let mut image = [0; EXTERNAL_SET_VALUES_LEN];
    image[..8].copy_from_slice(&axis.set_position.to_le_bytes());
    image[8..16].copy_from_slice(&velocity.to_le_bytes());
    image[16..24].copy_from_slice(&axis.set_acceleration.to_le_bytes());
    image[24..].copy_from_slice(&direction.to_le_bytes());
    image
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_direction_is_that_of_the_velocity() {
        for (velocity, direction) in [(2.5, 1), (0.0, 0), (-0.1, -1)] {
            let axis = NcToPlcAxis {
                set_position: 1.5,
                set_velocity: velocity,
                set_acceleration: -4.0,
                ..NcToPlcAxis::default()
            };
            let image = external_set_values(&axis);
            assert_eq!(image[..8], 1.5_f64.to_le_bytes());
            assert_eq!(image[8..16], velocity.to_le_bytes());
            assert_eq!(image[16..24], (-4.0_f64).to_le_bytes());
            assert_eq!(image[24..], i32::to_le_bytes(direction));
        }
    }
}
