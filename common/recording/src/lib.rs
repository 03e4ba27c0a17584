//! Rows of signals, log lines and status in an [MCAP](https://mcap.dev) file.
//!
//! A [`Table`] has a name and its signals. A [`RowEncoder`] makes messages of rows, and a [`Writer`] puts
//! them into a file that describes itself: each instance of a group of signals is a channel, each group a
//! Protocol Buffers schema in the file. A [`Reader`] returns the rows by those schemas, also from an
//! unfinished file, and [`recover()`] finishes one. [`Pieces`] are for observers during a recording, and
//! [`Join`] makes one recording of them. `export` makes tables of it, with the feature of that name.
//! Nothing here knows a clock, a thread or a file: bytes go to any writer and come from any reader.
//!
//! ```
//! use coaxle_node::signal::Instance;
//! use coaxle_recording::{Facts, Item, Reader, RowEncoder, Table, Value, Writer};
//!
//! coaxle_node::signals! {
//!     /// A boiler.
//!     pub struct BoilerSignals of Node {
//!         /// Temperature of the water; none before it was measured.
//!         temperature: Option<f64> ["°C"],
//!         /// Times it went off.
//!         offs: u64 [""],
//!     }
//! }
//! let table = Table {
//!     name: "boiler".to_owned(),
//!     role: "boiler".to_owned(),
//!     instances: vec![Instance::of::<BoilerSignals>("")],
//! };
//! let mut encoder = RowEncoder::of(&table);
//! let mut writer = Writer::create(Vec::new(), &[table], &Facts::new(), 0)?;
//! let row = BoilerSignals { temperature: None, offs: 3 };
//! writer.row(0, &encoder.encode(1_000_000, 1_000_700, &row)?)?;
//! let file = writer.finish()?;
//!
//! let mut reader = Reader::new(file.as_slice());
//! let Some(Ok(Item::Facts(_))) = reader.next() else { panic!() };
//! let Some(Ok(Item::Row(row))) = reader.next() else { panic!() };
//! assert_eq!((row.at_ns, row.woke_ns), (1_000_000, 1_000_700));
//! assert_eq!(row.values, [None, Some(Value::Count(3))]);
//! assert_eq!(reader.tables()[0].columns[0].unit, "°C");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod claims;
mod damage_list;
mod encoded_row;
#[cfg(test)]
mod example;
#[cfg(feature = "export")]
pub mod export;
mod format;
mod growth;
mod inputs;
mod join;
mod log;
mod pieces;
mod protobuf;
mod read_table;
mod reader;
mod records;
mod recover;
mod row_assembly;
mod row_serializer;
mod schema;
mod table;
#[cfg(test)]
mod tests;
mod value;
mod writer;

pub use claims::TooLongPart;
pub use damage_list::DamageList;
pub use encoded_row::{EncodedRow, RowError};
pub use growth::Growth;
pub use join::{Join, JoinError, JoinedNode};
pub use log::{Level, LogLine};
pub use pieces::Pieces;
pub use read_table::{Column, ReadTable, Row};
pub use reader::{Item, Reader};
pub use records::{Damage, Fault};
pub use recover::{Recovered, recover};
pub use table::{RowEncoder, Table};
pub use value::Value;
pub use writer::{FLUSH_PERIOD_NS, Facts, WriteError, Writer};
