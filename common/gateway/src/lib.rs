//! A PLC as a node: its axes are published like a sender's, and far axes corrected by a receiver are
//! written to it.
//!
//! A PLC provides its axes as 128-byte images of `NCTOPLC_AXLESTRUCT`, with a cycle index, a `WORD`, that
//! increases by one each PLC cycle. [`Gateway`] is the node. It takes [`PlcSample`]s out of a [`Port`],
//! determines the cycle of each ([`index_counter`]) and follows the PLC's clock ([`plc_clock`]). It
//! publishes each new index once, in frames whose count, send stamps and time responses are those of the
//! PLC's cycles. In the other direction it passes the axes of a receiver to the [`Port`].
//!
//! [`ams`] is the protocol of a Beckhoff PLC, as bytes. [`polled`] reads an index, images, and the index
//! again, until both are of one cycle; [`assembly`] puts notifications together by their stamps;
//! [`record`] and [`record_line`] are the contents of datagrams and pipes; [`Retry`] schedules
//! reconnections to a lost PLC. All I/O is in [`host`].
//!
//! | PLC name | here |
//! |--|--|
//! | `NCTOPLC_AXLESTRUCT`, `AXIS_REF.NcToPlc` | [`coaxle_axis::NcToPlcAxis`] in an [`config::ImageKind::NcToPlc`] |
//! | `MC_ExtSetPointGenFeed` | its input: [`external_set_values`] |
//! | `iCycleIndex` (TS5066) | [`coaxle_clock::CycleIndex`], counted by [`IndexCounter`] |

pub mod ams;
pub mod assembly;
pub mod config;
pub mod external_set_values;
#[cfg(feature = "host")]
pub mod host;
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
