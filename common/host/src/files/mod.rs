//! Files of a run: traces and recordings that overwrite nothing and survive a power failure.

#[cfg(test)]
mod example;
pub(crate) mod inputs;
mod new_file;
mod recording;
mod row_stream;
mod rows;
mod synced_file;

pub use inputs::InputRecord;
pub use new_file::{create_new, create_next};
pub use recording::{Attached, Recording};
pub use rows::Rows;
pub use synced_file::SyncedFile;
