//! The axis as one controller shows it to another.

mod image;
mod nc_to_plc;
mod plcopen;
mod state;

pub use image::{IMAGE_LEN, ImageLayout, ImageLengthError};
pub use nc_to_plc::NcToPlcAxis;
pub use plcopen::{AxisStatus, Transition};
pub use state::{AxisState, CoupleState, StateWord};
