//! The rows of a node for live viewers.

use coaxle_clock::{Instant, Span};
use coaxle_os::machine::Machine;
use coaxle_recording::{LogLine, Pieces, RowEncoder, Table, WriteError};
use serde::Serialize;

use crate::network::transport::Publisher;

/// Length of a piece: twenty a second look like motion, and the overhead of each stays small.
// A thousand messages a second would each carry the overhead of a whole recording.
pub(crate) const PIECE: Span = Span::from_millis(50);

/// Rows, log lines and status of a node, published in small recordings while there is a subscriber.
/// Without one, no row is encoded. The stream never waits: data that the network cannot take is
/// lost, and the gap shows in the sequence numbers of the rows.
pub(crate) struct RowStream {
    encoder: RowEncoder,
    pieces: Pieces,
    publisher: Box<dyn Publisher>,
    is_watched: bool,
    /// Start of the current piece.
    began: Option<Instant<Machine>>,
    is_broken: bool,
}

impl RowStream {
    /// Creates the stream of a table; the pieces carry `facts`, and `publisher` publishes them.
    pub(crate) fn new(table: &Table, pieces: Pieces, publisher: Box<dyn Publisher>) -> Self {
        Self {
            encoder: RowEncoder::of(table),
            pieces,
            publisher,
            is_watched: false,
            began: None,
            is_broken: false,
        }
    }

    /// Takes the row of a cycle, and publishes a full piece.
    pub(crate) fn row(
        &mut self,
        at: Instant<Machine>,
        woke: Instant<Machine>,
        row: &impl Serialize,
    ) {
        // The first row begins a piece, whatever its instant: the cycles of a node begin anywhere.
        if self.began.is_none_or(|began| at - began >= PIECE) {
            self.send();
            self.began = Some(at);
            // Asked once per piece: the transport's answer takes a call into the session, too much for each row.
            self.is_watched = !self.is_broken && self.publisher.has_subscriber();
        }
        if !self.is_watched {
            return;
        }
        match self.encoder.encode(at.as_nanos(), woke.as_nanos(), row) {
            Ok(row) => self.put(|pieces| pieces.row(&row)),
            Err(error) => self.break_off(&error.to_string()),
        }
    }

    /// Takes a line of the node's log.
    pub(crate) fn log(&mut self, line: &LogLine) {
        if self.is_watched {
            self.put(|pieces| pieces.log(line));
        }
    }

    /// Takes a status of the node, as JSON.
    pub(crate) fn status(&mut self, at: Instant<Machine>, json: &str) {
        if self.is_watched {
            self.put(|pieces| pieces.status(at.as_nanos(), json));
        }
    }

    /// Publishes the current piece.
    pub(crate) fn send(&mut self) {
        match self.pieces.take() {
            Ok(Some(piece)) => {
                if let Err(error) = self.publisher.publish(piece) {
                    tracing::debug!(%error, "the transport refused rows");
                }
            }
            Ok(None) => {}
            Err(error) => self.break_off(&error.to_string()),
        }
    }

    fn put(&mut self, what: impl FnOnce(&mut Pieces) -> Result<(), WriteError>) {
        if let Err(error) = what(&mut self.pieces) {
            self.break_off(&error.to_string());
        }
    }

    fn break_off(&mut self, error: &str) {
        tracing::error!("nobody can look on any more: {error}");
        // A table that cannot be encoded will not become encodable: the rest of the run goes on without viewers.
        self.is_broken = true;
        self.is_watched = false;
    }
}
