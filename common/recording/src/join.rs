//! A single recording of the pieces that nodes publish.

use std::collections::BTreeMap;
use std::io::{BufWriter, Write};

use mcap::McapError;
use mcap::records::{Channel, MessageHeader, Metadata, Record};
use mcap::write::NoSeek;

use crate::format::{ABOUT, CLOCK_OFFSET, EPOCH, FORMAT, INSTANCE, PIECE, PLACE, TABLE, VERSION};
use crate::records::{Damage, RecordReader};
use crate::writer::{FLUSH_PERIOD_NS, Facts, WriteError, options};

/// A recording that grows by [`Pieces`](crate::Pieces), of one node or of several.
pub struct Join<W: Write> {
    mcap: mcap::Writer<NoSeek<BufWriter<W>>>,
    of_many: bool,
    nodes: BTreeMap<String, NodeState>,
    flushed_ns: Option<u64>,
}

/// Joined part of a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JoinedNode {
    /// Name of the node.
    pub name: String,
    /// Number of its rows.
    pub rows: u64,
    /// Rows missing between them.
    pub missing: u64,
}

/// Error of a piece that cannot be joined. The part joined before is valid.
#[derive(Debug, thiserror::Error)]
pub enum JoinError {
    /// An error of writing the file.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Damaged bytes, or bytes that are not a piece.
    #[error("received something that is no piece of a recording: {0}")]
    Damage(#[from] Damage),
    /// A piece of another node.
    #[error("received a piece of {received:?}, expected one of {expected:?}")]
    Foreign {
        /// Node named in the piece.
        received: String,
        /// Node that sent it.
        expected: String,
    },
    /// A change of the node's signals: it was restarted with another config. A file has room for one.
    #[error("{node} shows other signals than before")]
    Changed {
        /// The node.
        node: String,
    },
}

impl<W: Write> Join<W> {
    /// Begins a recording. For `of_many` nodes the topics begin with the node's name, and its clock is
    /// the time of day: each PC has a monotonic clock of its own.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn create(out: W, of_many: bool) -> Result<Self, WriteError> {
        let mut join = Self {
            mcap: options().create(NoSeek::new(BufWriter::new(out)))?,
            of_many,
            nodes: BTreeMap::new(),
            flushed_ns: None,
        };
        if of_many {
            // Times of pieces are times of day already: monotonic clocks of several PCs have no common offset.
            join.write_metadata([(CLOCK_OFFSET, "0")])?;
        }
        Ok(join)
    }

    /// Adds a piece from a node of this name.
    ///
    /// # Errors
    /// [`JoinError`]: nothing of the piece has been added then, unless writing failed.
    pub fn piece(&mut self, name: &str, piece: &[u8]) -> Result<(), JoinError> {
        let piece = ReadPiece::read(piece)?;
        if let Some(received) = piece.foreign(name) {
            let expected = name.to_owned();
            return Err(JoinError::Foreign { received, expected });
        }
        // Taken out, because adding borrows the whole recording.
        let mut node = match self.nodes.remove(name) {
            Some(node) => node,
            None => self.add_node(name, &piece)?,
        };
        // A file has one schema for each channel, and other signals would be read by the wrong one.
        let is_changed = node.channels != piece.channels;
        let added = match is_changed {
            true => Ok(()),
            false => self.add(name, &mut node, &piece),
        };
        // Put back in every case, also after an error: the part before it is in the file.
        self.nodes.insert(name.to_owned(), node);
        match is_changed {
            true => Err(JoinError::Changed {
                node: name.to_owned(),
            }),
            false => Ok(added?),
        }
    }

    /// Nodes joined so far, by name.
    #[must_use]
    pub fn nodes(&self) -> Vec<JoinedNode> {
        let joined = |(name, node): (&String, &NodeState)| JoinedNode {
            name: name.clone(),
            rows: node.rows,
            missing: node.missing,
        };
        self.nodes.iter().map(joined).collect()
    }

    /// Ends the recording with its summary, and returns its destination.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn finish(mut self) -> Result<W, WriteError> {
        for node in self.nodes() {
            // At the end, when the number is final; the last fact of a name counts.
            let key = self.fact_of(&node.name, "missing");
            self.write_metadata([(key.as_str(), node.missing.to_string().as_str())])?;
        }
        self.mcap.finish()?;
        let written = self.mcap.into_inner().into_inner().into_inner();
        Ok(written.map_err(|error| McapError::Io(error.into_error()))?)
    }

    /// Adds the channels of a new node.
    fn add_node(&mut self, name: &str, piece: &ReadPiece) -> Result<NodeState, WriteError> {
        let mut to = Vec::new();
        for TypedChannel { channel, schema } in &piece.channels {
            let schema = (self.mcap).add_schema(&schema.name, &schema.encoding, &schema.data)?;
            let topic = match self.of_many {
                true => format!("{name}/{}", channel.topic),
                false => channel.topic.clone(),
            };
            let (encoding, metadata) = (&channel.message_encoding, &channel.metadata);
            to.push(self.mcap.add_channel(schema, &topic, encoding, metadata)?);
        }
        Ok(NodeState {
            channels: piece.channels.clone(),
            to,
            ..NodeState::default()
        })
    }

    fn add(
        &mut self,
        name: &str,
        node: &mut NodeState,
        piece: &ReadPiece,
    ) -> Result<(), WriteError> {
        if node.epoch != piece.facts.get(EPOCH).cloned() {
            node.epoch = piece.facts.get(EPOCH).cloned();
            // A new run counts from its own beginning.
            node.next_row = None;
            self.write_facts(name, &piece.facts)?;
        }
        for (header, data) in &piece.messages {
            let known = node.channels.iter().zip(&node.to);
            let mut known = known.map(|(described, to)| (&described.channel, to));
            // A message of a channel that is not described in the piece cannot be read by anybody.
            let Some((channel, to)) = known.find(|(known, _)| known.id == header.channel_id) else {
                continue;
            };
            if begins_a_row(channel) {
                let expected = node.next_row.unwrap_or(header.sequence);
                // Wrapping as the numbers do, which reach the end of u32 after seven weeks at 1 kHz.
                node.missing += u64::from(header.sequence.wrapping_sub(expected));
                node.next_row = Some(header.sequence.wrapping_add(1));
                node.rows += 1;
            }
            let mut header = *header;
            header.channel_id = *to;
            self.mcap.write_to_known_channel(&header, data)?;
            self.flush_at(header.log_time)?;
        }
        Ok(())
    }

    /// Writes the facts of a piece about the node and its run.
    fn write_facts(&mut self, name: &str, facts: &Facts) -> Result<(), WriteError> {
        // Facts about a piece are none about the joined recording, which has its own format.
        let is_ours = |key: &str| [FORMAT, PIECE].contains(&key);
        let of_many = self.of_many;
        let written = facts.iter().filter(|(key, _)| !is_ours(key));
        // The offset of one PC's clock would shift the times of all others.
        let written = written.filter(|(key, _)| !of_many || *key != CLOCK_OFFSET);
        let written: Vec<_> = written
            .map(|(key, fact)| (self.fact_of(name, key), fact.as_str()))
            .collect();
        self.write_metadata(written.iter().map(|(key, fact)| (key.as_str(), *fact)))
    }

    fn fact_of(&self, node: &str, key: &str) -> String {
        match self.of_many {
            true => format!("{node}.{key}"),
            false => key.to_owned(),
        }
    }

    fn write_metadata<'a>(
        &mut self,
        facts: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<(), WriteError> {
        let facts = facts.into_iter().chain([(FORMAT, VERSION)]);
        let metadata = facts.map(|(key, fact)| (key.to_owned(), fact.to_owned()));
        Ok(self.mcap.write_metadata(&Metadata {
            name: ABOUT.to_owned(),
            metadata: metadata.collect(),
        })?)
    }

    fn flush_at(&mut self, log_time: u64) -> Result<(), WriteError> {
        let flushed = *self.flushed_ns.get_or_insert(log_time);
        // Clocks of several nodes differ: behind the time of a fast one a signed difference stays below the period
        // for long.
        if log_time.abs_diff(flushed) >= FLUSH_PERIOD_NS.unsigned_abs() {
            self.flushed_ns = Some(log_time);
            self.mcap.flush()?;
        }
        Ok(())
    }
}

/// A node that sends pieces.
#[derive(Default)]
struct NodeState {
    channels: Vec<TypedChannel>,
    /// Destination channel of the messages of each.
    to: Vec<u16>,
    epoch: Option<String>,
    /// The sequence number of its next row.
    next_row: Option<u32>,
    rows: u64,
    missing: u64,
}

/// True for the first message of a row, which is of the first instance.
fn begins_a_row(channel: &Channel) -> bool {
    let of = &channel.metadata;
    // Once per row, or a row of n instances would count n times.
    of.contains_key(INSTANCE) && of.get(PLACE).is_some_and(|place| place == "0")
}

/// A piece, parsed.
#[derive(Default)]
struct ReadPiece {
    facts: Facts,
    channels: Vec<TypedChannel>,
    messages: Vec<(MessageHeader, Vec<u8>)>,
}

/// A channel and the type of its messages.
#[derive(Clone, PartialEq)]
struct TypedChannel {
    channel: Channel,
    schema: ChannelSchema,
}

#[derive(Clone, Default, PartialEq)]
struct ChannelSchema {
    name: String,
    encoding: String,
    data: Vec<u8>,
}

impl ReadPiece {
    fn read(bytes: &[u8]) -> Result<Self, Damage> {
        let mut piece = Self::default();
        let mut schemas = BTreeMap::new();
        for record in RecordReader::new(bytes) {
            match record? {
                Record::Metadata(about) if about.name == ABOUT => piece.facts = about.metadata,
                Record::Schema { header, data } => {
                    let schema = ChannelSchema {
                        name: header.name,
                        encoding: header.encoding,
                        data: data.into_owned(),
                    };
                    schemas.insert(header.id, schema);
                }
                Record::Channel(channel) => {
                    // A channel may have no schema, as that of the inputs.
                    let schema = schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                    piece.channels.push(TypedChannel { channel, schema });
                }
                Record::Message { header, data } => {
                    piece.messages.push((header, data.into_owned()));
                }
                _ => {}
            }
        }
        Ok(piece)
    }

    /// Returns the name of the node in a piece, if it is another one.
    fn foreign(&self, name: &str) -> Option<String> {
        let tables = self.channels.iter();
        let mut tables = tables.map(|described| described.channel.metadata.get(TABLE));
        // A channel without a table belongs to no node, which is foreign as well.
        let other = tables.find(|table| table.is_none_or(|table| table != name))?;
        Some(other.cloned().unwrap_or_default())
    }
}
