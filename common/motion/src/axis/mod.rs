//! The axis as one controller shows it to another.

mod command_state;
mod coupling_phase;
mod dynamics;
pub mod guard;
mod guard_error;
mod image;
mod nc_to_plc;
mod plcopen;
mod state;

pub use command_state::CommandState;
pub use coupling_phase::CouplingPhase;
pub use dynamics::Dynamics;
pub use image::{IMAGE_LEN, ImageLayout, ImageLengthError};
pub use nc_to_plc::NcToPlcAxis;
pub use plcopen::{AxisStatus, Transition};
pub use state::{AxisState, CoupleState, StateWord};
