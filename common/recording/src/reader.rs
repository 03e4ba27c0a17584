//! Reading a recording: the rows back, by the schemas in the file.

use std::collections::BTreeMap;
use std::io::Read;
use std::sync::Arc;

use mcap::records::{Channel, MessageHeader, Record};

use crate::format::{
    ABOUT, AUDIT_SCHEMA, BARE_INPUTS, CLOCK_OFFSET, GROUP, INPUTS, INPUTS_SCHEMA, INSTANCE,
    INSTANCES, PLACE, ROLE, TABLE, UNIT,
};
use crate::inputs::scan_in;
use crate::log::{self, LogLine};
use crate::protobuf::InvalidMessage;
use crate::read_table::{Column, ReadTable, Row};
use crate::records::{Damage, Fault, MOST_BYTES, MOST_SIGNALS, RecordReader};
use crate::row_assembly::{OpenInstance, OpenTable};
use crate::schema::{SchemaField, fields_of};
use crate::writer::Facts;

/// Content of a recording, in its order.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// Facts about the recording as a whole. They may come more than once; the last ones count.
    Facts(Facts),
    /// A file in it.
    Attachment {
        /// Name of the file.
        name: String,
        /// Media type: `application/toml`.
        media_type: String,
        /// Content of the file.
        data: Vec<u8>,
    },
    /// A row.
    Row(Row),
    /// A line of the log.
    Log(LogLine),
    /// A status, as JSON.
    Status {
        /// Table that it belongs to.
        table: String,
        /// Time of the status, ns of the clock of the rows.
        at_ns: i64,
        /// The status.
        json: String,
    },
    /// A record of the audit of a node, as JSON.
    Audit {
        /// Name of the node.
        table: String,
        /// Time of the record, ns of the clock of the rows.
        at_ns: i64,
        /// The record.
        json: String,
    },
    /// Inputs of a node before a scan.
    Inputs {
        /// Name of the node.
        table: String,
        /// Ideal start of the cycle, ns of the clock of the rows.
        at_ns: i64,
        /// Real start of the cycle.
        woke_ns: i64,
        /// Bytes of a `coaxle_wire::NodeScan`.
        bytes: Vec<u8>,
    },
}

/// A recording that is being read. Of an unfinished or damaged file it returns the valid parts, and the
/// places of the damage. An error is not the end, unless nothing follows it.
pub struct Reader<R> {
    records: RecordReader<R>,
    clock_offset_ns: i64,
    schemas: BTreeMap<u16, (String, Vec<u8>)>,
    channels: BTreeMap<u16, ChannelContent>,
    tables: Vec<ReadTable>,
    open: Vec<OpenTable>,
    /// Number of signals of all channels.
    signals: usize,
    /// Length of the names of all columns.
    name_bytes: usize,
    /// Number of incomplete rows.
    incomplete: u64,
}

/// A channel by its content.
#[derive(Clone)]
enum ChannelContent {
    Instance {
        table: usize,
        place: usize,
        topic: Arc<str>,
    },
    Log,
    Status(Arc<str>),
    Audit(Arc<str>),
    Inputs(Arc<str>),
    BareInputs(Arc<str>),
    Other,
}

impl<R: Read> Reader<R> {
    /// Reads a recording from its beginning.
    pub const fn new(input: R) -> Self {
        Self {
            records: RecordReader::new(input),
            clock_offset_ns: 0,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            tables: Vec::new(),
            open: Vec::new(),
            signals: 0,
            name_bytes: 0,
            incomplete: 0,
        }
    }

    /// Returns the tables, as far as the file has been read: before a row comes, its table is complete.
    #[must_use]
    pub fn tables(&self) -> &[ReadTable] {
        &self.tables
    }

    /// Returns the number of incomplete rows so far, which are left out.
    #[must_use]
    pub const fn incomplete_rows(&self) -> u64 {
        self.incomplete
    }

    fn advance(&mut self) -> Option<Result<Item, Damage>> {
        loop {
            // Taken before the record is read: damage is reported at its beginning.
            let offset = self.records.offset();
            let record = match self.records.next()? {
                Ok(record) => record,
                Err(damage) => return Some(Err(damage)),
            };
            match self.take(record) {
                Ok(Some(item)) => return Some(Ok(item)),
                Ok(None) => {}
                Err(fault) => return Some(Err(Damage { offset, fault })),
            }
        }
    }

    fn take(&mut self, record: Record<'static>) -> Result<Option<Item>, Fault> {
        match record {
            Record::Schema { header, data } => {
                let schema = (header.name, data.into_owned());
                self.schemas.insert(header.id, schema);
            }
            Record::Channel(channel) => self.channel(channel)?,
            Record::Message { header, data } => return self.message(&header, &data),
            Record::Metadata(metadata) if metadata.name == ABOUT => {
                return Ok(Some(Item::Facts(self.facts(metadata.metadata))));
            }
            Record::Attachment { header, data, .. } => {
                return Ok(Some(Item::Attachment {
                    name: header.name,
                    media_type: header.media_type,
                    data: data.into_owned(),
                }));
            }
            _ => {}
        }
        Ok(None)
    }

    fn facts(&mut self, facts: Facts) -> Facts {
        let offset = facts.get(CLOCK_OFFSET).and_then(|ns| ns.parse().ok());
        // Facts without an offset, as those of `missing` at the end, leave the clock as it is.
        self.clock_offset_ns = offset.unwrap_or(self.clock_offset_ns);
        facts
    }

    fn channel(&mut self, channel: Channel) -> Result<(), Fault> {
        // MCAP permits a channel to be repeated, for example in each chunk; a second one would double its columns.
        if self.channels.contains_key(&channel.id) {
            return Ok(());
        }
        let content = self.content_of(&channel)?;
        self.channels.insert(channel.id, content);
        Ok(())
    }

    fn content_of(&mut self, channel: &Channel) -> Result<ChannelContent, Fault> {
        let schema = self.schemas.get(&channel.schema_id);
        let (schema, data) = schema.map_or(("", &[][..]), |(name, data)| (name, data));
        let Some(name) = channel.metadata.get(TABLE) else {
            return Ok(ChannelContent::Other);
        };
        if channel.metadata.contains_key(INSTANCE) {
            let fields = fields_of(schema, data).map_err(|InvalidMessage| Fault::Message {
                topic: channel.topic.clone(),
            })?;
            return self.instance(channel, fields);
        }
        if channel.message_encoding == BARE_INPUTS {
            return Ok(ChannelContent::BareInputs(name.as_str().into()));
        }
        // Channels of other programs are no error: any MCAP file can be read.
        Ok(match schema {
            "foxglove.Log" => ChannelContent::Log,
            "coaxle.Status" => ChannelContent::Status(name.as_str().into()),
            INPUTS_SCHEMA => ChannelContent::Inputs(name.as_str().into()),
            AUDIT_SCHEMA => ChannelContent::Audit(name.as_str().into()),
            _ => ChannelContent::Other,
        })
    }

    fn instance(
        &mut self,
        channel: &Channel,
        fields: Vec<SchemaField>,
    ) -> Result<ChannelContent, Fault> {
        let text = |key: &str| channel.metadata.get(key).cloned().unwrap_or_default();
        let count = |field: &'static str| {
            let received = text(field);
            // The number of channels is the limit.
            let count = received.parse::<u16>().map(usize::from);
            count.map_err(|_| Fault::Channel {
                topic: channel.topic.clone(),
                field,
                received,
                expected: "a number from 0 to 65535",
            })
        };
        let (place, of) = (count(PLACE)?, count(INSTANCES)?);
        self.signals += fields.len();
        // Before anything is allocated for them: a small file can describe very many.
        if self.signals > MOST_SIGNALS {
            return Err(Fault::TooManySignals);
        }
        self.count_names(channel, &fields)?;
        let table = self.table(&text(TABLE), &text(ROLE), of);
        let columns = fields.iter().map(|field| Column {
            instance: text(INSTANCE),
            group: text(GROUP),
            signal: field.name.clone(),
            unit: text(&unit_key(field)),
            kind: field.kind,
        });
        let instance = OpenInstance::new(columns.collect(), fields);
        let open = &mut self.open[table];
        // Two channels in one place would overwrite each other's values, and the row never be complete.
        if place >= open.expected || open.instances.contains_key(&place) {
            return Err(Fault::Channel {
                topic: channel.topic.clone(),
                field: PLACE,
                received: place.to_string(),
                expected: "a place of its own, less than `instances`",
            });
        }
        open.instances.insert(place, instance);
        open.lay_out(&mut self.tables[table]);
        let topic = channel.topic.as_str().into();
        Ok(ChannelContent::Instance {
            table,
            place,
            topic,
        })
    }

    /// Counts the names of the columns, each of which has those of its channel.
    fn count_names(&mut self, channel: &Channel, fields: &[SchemaField]) -> Result<(), Fault> {
        let length = |key: &str| channel.metadata.get(key).map_or(0, String::len);
        let of_channel = length(INSTANCE) + length(GROUP);
        let names = fields
            .iter()
            .map(|field| of_channel + field.name.len() + length(&unit_key(field)));
        self.name_bytes += names.sum::<usize>();
        // Before they are copied: one long name of a channel can stand in very many columns.
        if self.name_bytes > MOST_BYTES {
            return Err(Fault::TooManyDescriptions);
        }
        Ok(())
    }

    /// Returns the table of this name, a new one if there is none yet.
    fn table(&mut self, name: &str, role: &str, instances: usize) -> usize {
        // By name, because the channels of a table come in any order, one by one.
        if let Some(known) = self.tables.iter().position(|table| table.name == name) {
            return known;
        }
        self.tables.push(ReadTable {
            name: name.to_owned(),
            role: role.to_owned(),
            columns: Vec::new(),
        });
        self.open.push(OpenTable::of(instances));
        self.tables.len() - 1
    }

    fn message(&mut self, header: &MessageHeader, data: &[u8]) -> Result<Option<Item>, Fault> {
        let at_ns = self.clock_ns(header.log_time);
        // Messages of a lost channel are lost, too.
        let content = self.channels.get(&header.channel_id).cloned();
        Ok(match content.unwrap_or(ChannelContent::Other) {
            ChannelContent::Other => None,
            ChannelContent::Log => Some(Item::Log(log::decode(data, at_ns))),
            ChannelContent::Status(table) => Some(Item::Status {
                table: table.to_string(),
                at_ns,
                json: String::from_utf8_lossy(data).into_owned(),
            }),
            ChannelContent::Audit(table) => Some(Item::Audit {
                table: table.to_string(),
                at_ns,
                json: String::from_utf8_lossy(data).into_owned(),
            }),
            ChannelContent::BareInputs(table) => Some(self.inputs(&table, header, data)),
            ChannelContent::Inputs(table) => {
                let scan = scan_in(data).map_err(|InvalidMessage| Fault::Message {
                    topic: format!("{table}/{INPUTS}"),
                })?;
                Some(self.inputs(&table, header, scan))
            }
            ChannelContent::Instance {
                table,
                place,
                topic,
            } => {
                let open = &mut self.open[table];
                // Messages of a row share one number: another number means that the rest of the last row is lost.
                if open.sequence != Some(header.sequence) {
                    // After a complete row `received` is 0, so that only a row that has begun counts.
                    self.incomplete += u64::from(open.received > 0);
                    open.begin(header.sequence);
                    open.at_ns = at_ns;
                }
                open.put(place, data)
                    .map_err(|InvalidMessage| Fault::Message {
                        topic: topic.to_string(),
                    })?;
                let woke_ns = self.clock_ns(header.publish_time);
                let open = &mut self.open[table];
                open.woke_ns = woke_ns;
                open.take_row(table).map(Item::Row)
            }
        })
    }

    fn inputs(&self, table: &str, header: &MessageHeader, scan: &[u8]) -> Item {
        Item::Inputs {
            table: table.to_owned(),
            at_ns: self.clock_ns(header.log_time),
            woke_ns: self.clock_ns(header.publish_time),
            bytes: scan.to_vec(),
        }
    }

    /// Converts the time in the file to that of the clock of the rows.
    fn clock_ns(&self, time: u64) -> i64 {
        // A forged time must not overflow: u64 nanoseconds reach twice as far as i64.
        let time = i64::try_from(time).unwrap_or(i64::MAX);
        time.saturating_sub(self.clock_offset_ns)
    }
}

/// Key of a signal's unit in the metadata of its channel.
fn unit_key(field: &SchemaField) -> String {
    format!("{UNIT}{}", field.name)
}

impl<R: Read> Iterator for Reader<R> {
    type Item = Result<Item, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        self.advance()
    }
}
