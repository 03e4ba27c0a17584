//! A PLC as a node: its axes are published as a sender's, and what a receiver makes of far axes is handed back to it.
//!
//! A PLC tells its axes as 128-byte images of `NCTOPLC_AXLESTRUCT`, with a cycle index, a `WORD`, that goes up by
//! one each PLC cycle. [`Gateway`] is the node: it takes [`PlcSample`]s out of a [`Port`], finds out which cycle each is of
//! ([`index_counter`]), follows the PLC's clock ([`plc_clock`]), and publishes each new index once, in frames whose count, send
//! stamps and time responses are those of the PLC's cycles. The other way it hands the axes of a receiver to the
//! [`Port`].
//!
//! [`ams`] is what a Beckhoff PLC speaks, as bytes. [`polled`] reads an index, images, and the index again,
//! until both are of one cycle; [`assembly`] puts notifications together by their stamps; [`record`] and [`record_line`]
//! are what datagrams and pipes carry; [`Retry`] says when to try a lost PLC again. All I/O is elsewhere.
//!
//! | PLC name | here |
//! |--|--|
//! | `NCTOPLC_AXLESTRUCT`, `AXIS_REF.NcToPlc` | [`coaxle_axis::NcToPlcAxis`] in an [`config::ImageKind::NcToPlc`] |
//! | `MC_ExtSetPointGenFeed` | what it is fed: [`external_set_values`] |
//! | `iCycleIndex` (TS5066) | [`coaxle_clock::CycleIndex`], counted by [`IndexCounter`] |

pub mod ams;
pub mod assembly;
pub mod config;
pub mod external_set_values;
pub mod index_counter;
mod node;
pub mod plc_clock;
pub mod polled;
mod port;
pub mod record;
pub mod record_line;
mod retry;
pub mod signals;
mod snapshot;

pub use index_counter::IndexCounter;
pub use node::Gateway;
pub use port::{LinkState, PlcOutput, PlcSample, Port};
pub use retry::Retry;
pub use snapshot::{GatewayRow, GatewaySnapshot};
