//! Writing a recording.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{BufWriter, Write};

use coaxle_node::signal::Instance;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, McapError, WriteOptions};

use crate::encoded_row::EncodedRow;
use crate::format::{
    ABOUT, AUDIT, AUDIT_SCHEMA, CLOCK_OFFSET, FORMAT, GROUP, INPUTS, INSTANCE, INSTANCES, PLACE,
    ROLE, TABLE, UNIT, VERSION,
};
use crate::inputs;
use crate::log::{self, LogLine};
use crate::schema::Schema;
use crate::table::Table;

/// Period of flushing, ns of the clock of the rows, so that a killed process leaves a usable file.
pub const FLUSH_PERIOD_NS: i64 = 250_000_000;

/// Greatest length of a chunk, before compression. Rows of a flush period are less, but for the largest
/// nodes.
const CHUNK_BYTES: u64 = 4 << 20;

/// Failure of writing: no space, or no file any more.
#[derive(Debug, thiserror::Error)]
#[error("cannot be written: {0}")]
pub struct WriteError(#[from] McapError);

/// Facts about a recording as a whole, by name: scenario, seed, version, node, role.
pub type Facts = BTreeMap<String, String>;

/// Schema of the records of the audit, for viewers that make columns of it: the fields of docs/WIRE.md.
const AUDIT_JSON_SCHEMA: &[u8] = br#"{"type":"object","properties":{"version":{"type":"integer"},"node":{"type":"string"},"run":{"type":"string"},"number":{"type":"integer"},"at_us":{"type":"integer"},"door":{"type":"string"},"actor":{"type":"string"},"action":{"type":"string"},"object":{"type":"string"},"outcome":{"type":"string"},"reason":{"type":"string"},"count":{"type":"integer"}}}"#;

/// A recording that is being written. Flushed rows remain if the process is killed.
pub struct Writer<W: Write> {
    mcap: mcap::Writer<NoSeek<BufWriter<W>>>,
    clock_offset_ns: i64,
    tables: Vec<Channels>,
    /// Time of the last flush, on the clock of the rows.
    flushed_ns: Option<i64>,
    /// The last message of inputs, kept for its memory.
    message: Vec<u8>,
}

/// Channels of the messages of a table.
struct Channels {
    instances: Vec<u16>,
    log: u16,
    status: u16,
    /// Channel of the inputs; none before the first ones.
    inputs: Option<u16>,
    /// Channel of the audit; none before the first record.
    audit: Option<u16>,
    /// Topic and metadata of both.
    name: String,
    metadata: BTreeMap<String, String>,
    written: WrittenCount,
}

/// Number of messages of each kind of a table so far: their sequence numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WrittenCount {
    rows: u32,
    statuses: u32,
    lines: u32,
    inputs: u32,
    audit: u32,
}

impl WrittenCount {
    pub(crate) const NOTHING: Self = Self {
        rows: 0,
        statuses: 0,
        lines: 0,
        inputs: 0,
        audit: 0,
    };
}

/// Returns the options of our files.
pub(crate) fn options() -> WriteOptions {
    WriteOptions::new()
        .compression(Some(Compression::Lz4))
        .chunk_size(Some(CHUNK_BYTES))
        .library(concat!("coaxle ", env!("CARGO_PKG_VERSION")))
        // The destination need not seek, and what was flushed must be readable without later corrections.
        .disable_seeking(true)
}

impl<W: Write> Writer<W> {
    /// Begins a recording of these tables. `clock_offset_ns` is the wall clock, ns since 1970, at time 0
    /// of the clock of the rows. The times in the file are the sum, so that recordings of several PCs can
    /// be compared.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn create(
        out: W,
        tables: &[Table],
        facts: &Facts,
        clock_offset_ns: i64,
    ) -> Result<Self, WriteError> {
        Self::with_options(options(), out, tables, facts, clock_offset_ns)
    }

    /// Begins a recording with these options of MCAP.
    pub(crate) fn with_options(
        options: WriteOptions,
        out: W,
        tables: &[Table],
        facts: &Facts,
        clock_offset_ns: i64,
    ) -> Result<Self, WriteError> {
        let mcap = options.create(NoSeek::new(BufWriter::new(out)))?;
        let mut writer = Self {
            mcap,
            clock_offset_ns,
            tables: Vec::new(),
            flushed_ns: None,
            message: Vec::new(),
        };
        writer.facts(facts)?;
        let mut schemas = Schemas::default();
        for table in tables {
            let prefix = match tables {
                // The usual file of one node has short topics; several need the name to tell them apart.
                [_] => String::new(),
                _ => format!("{}/", table.name),
            };
            let channels = writer.channels(table, &prefix, &mut schemas)?;
            writer.tables.push(channels);
        }
        // A reader of a file without rows thus knows its channels.
        writer.mcap.flush()?;
        Ok(writer)
    }

    /// Adds facts about the recording as a whole.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn facts(&mut self, facts: &Facts) -> Result<(), WriteError> {
        let mut metadata = facts.clone();
        metadata.insert(FORMAT.to_owned(), VERSION.to_owned());
        metadata.insert(CLOCK_OFFSET.to_owned(), self.clock_offset_ns.to_string());
        let name = ABOUT.to_owned();
        Ok(self.mcap.write_metadata(&Metadata { name, metadata })?)
    }

    /// Puts a file into the recording: a config, a scenario.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), WriteError> {
        // An attachment has no time of its own; that of the last flush keeps the file's range as it is.
        let time = self.log_time(self.flushed_ns.unwrap_or_default());
        Ok(self.mcap.attach(&Attachment {
            log_time: time,
            create_time: time,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: Cow::Borrowed(data),
        })?)
    }

    /// Adds a row of the n-th table, and flushes rows older than [`FLUSH_PERIOD_NS`].
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn row(&mut self, table: usize, row: &EncodedRow) -> Result<(), WriteError> {
        let (log_time, publish_time) = (self.log_time(row.at_ns), self.log_time(row.woke_ns));
        let Some(channels) = self.tables.get_mut(table) else {
            return Ok(());
        };
        for (channel, message) in channels.instances.iter().zip(row.messages()) {
            let header = MessageHeader {
                channel_id: *channel,
                sequence: channels.written.rows,
                log_time,
                publish_time,
            };
            self.mcap.write_to_known_channel(&header, message)?;
        }
        // After all messages of the row, which share the number. It wraps after seven weeks at 1 kHz.
        channels.written.rows = channels.written.rows.wrapping_add(1);
        self.flush_at(row.at_ns)
    }

    /// Adds a line of the log of the n-th table.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn log(&mut self, table: usize, line: &LogLine) -> Result<(), WriteError> {
        let time = self.log_time(line.at_ns);
        let Some(channels) = self.tables.get_mut(table) else {
            return Ok(());
        };
        let header = MessageHeader {
            channel_id: channels.log,
            sequence: channels.written.lines,
            log_time: time,
            publish_time: time,
        };
        channels.written.lines = channels.written.lines.wrapping_add(1);
        let message = log::encode(line, time);
        Ok(self.mcap.write_to_known_channel(&header, &message)?)
    }

    /// Adds a status of the n-th table, as JSON.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn status(&mut self, table: usize, at_ns: i64, json: &str) -> Result<(), WriteError> {
        let time = self.log_time(at_ns);
        let Some(channels) = self.tables.get_mut(table) else {
            return Ok(());
        };
        let header = MessageHeader {
            channel_id: channels.status,
            sequence: channels.written.statuses,
            log_time: time,
            publish_time: time,
        };
        channels.written.statuses = channels.written.statuses.wrapping_add(1);
        Ok(self.mcap.write_to_known_channel(&header, json.as_bytes())?)
    }

    /// Adds the inputs of the n-th table's node before a scan, as the bytes of a `coaxle_wire::NodeScan`.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn inputs(
        &mut self,
        table: usize,
        at_ns: i64,
        woke_ns: i64,
        bytes: &[u8],
    ) -> Result<(), WriteError> {
        let (log_time, publish_time) = (self.log_time(at_ns), self.log_time(woke_ns));
        let Some(channels) = self.tables.get_mut(table) else {
            return Ok(());
        };
        let channel_id = match channels.inputs {
            Some(channel) => channel,
            // Added with the first inputs: only a receiver that records itself has any.
            None => {
                let Schema { name, data } = inputs::schema();
                let schema = self.mcap.add_schema(&name, "protobuf", &data)?;
                let topic = format!("{}/{INPUTS}", channels.name);
                let metadata = &channels.metadata;
                let added = (self.mcap).add_channel(schema, &topic, "protobuf", metadata)?;
                *channels.inputs.insert(added)
            }
        };
        let header = MessageHeader {
            channel_id,
            sequence: channels.written.inputs,
            log_time,
            publish_time,
        };
        channels.written.inputs = channels.written.inputs.wrapping_add(1);
        self.message.clear();
        inputs::put(&mut self.message, bytes);
        Ok((self.mcap).write_to_known_channel(&header, &self.message)?)
    }

    /// Adds a record of the audit of the n-th table, as JSON.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn audit(&mut self, table: usize, at_ns: i64, json: &str) -> Result<(), WriteError> {
        let time = self.log_time(at_ns);
        let Some(channels) = self.tables.get_mut(table) else {
            return Ok(());
        };
        let channel_id = match channels.audit {
            Some(channel) => channel,
            // Added with the first record: runs in virtual time have none, and their files stay as they are.
            None => {
                let schema =
                    (self.mcap).add_schema(AUDIT_SCHEMA, "jsonschema", AUDIT_JSON_SCHEMA)?;
                let topic = format!("{}/{AUDIT}", channels.name);
                let metadata = &channels.metadata;
                let added = self.mcap.add_channel(schema, &topic, "json", metadata)?;
                *channels.audit.insert(added)
            }
        };
        let header = MessageHeader {
            channel_id,
            sequence: channels.written.audit,
            log_time: time,
            publish_time: time,
        };
        channels.written.audit = channels.written.audit.wrapping_add(1);
        Ok(self.mcap.write_to_known_channel(&header, json.as_bytes())?)
    }

    /// Ends the recording with its summary, and returns its destination.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn finish(mut self) -> Result<W, WriteError> {
        self.mcap.finish()?;
        let written = self.mcap.into_inner().into_inner().into_inner();
        Ok(written.map_err(|error| McapError::Io(error.into_error()))?)
    }

    /// Returns the number of messages of the n-th table.
    pub(crate) fn written(&self, table: usize) -> WrittenCount {
        let channels = self.tables.get(table);
        channels.map_or(WrittenCount::NOTHING, |channels| channels.written)
    }

    /// Continues the count of the messages of the n-th table from there.
    pub(crate) fn count_on(&mut self, table: usize, written: WrittenCount) {
        if let Some(channels) = self.tables.get_mut(table) {
            channels.written = written;
        }
    }

    fn flush_at(&mut self, at_ns: i64) -> Result<(), WriteError> {
        let flushed = *self.flushed_ns.get_or_insert(at_ns);
        // Rows of several tables may come some cycles apart; a clock that was set back further restarts
        // the period.
        if at_ns.abs_diff(flushed) >= FLUSH_PERIOD_NS.unsigned_abs() {
            self.flushed_ns = Some(at_ns);
            self.mcap.flush()?;
        }
        Ok(())
    }

    /// Returns the time in the file: MCAP knows no time before 1970.
    fn log_time(&self, at_ns: i64) -> u64 {
        let time = at_ns.saturating_add(self.clock_offset_ns);
        u64::try_from(time).unwrap_or_default()
    }

    fn channels(
        &mut self,
        table: &Table,
        prefix: &str,
        schemas: &mut Schemas,
    ) -> Result<Channels, WriteError> {
        let mut instances = Vec::new();
        for (place, instance) in table.instances.iter().enumerate() {
            let schema = schemas.of(instance, &table.role);
            let schema = self.schema(&schema, "protobuf")?;
            let topic = topic(table, instance, prefix);
            let mut metadata = units(instance);
            metadata.extend(table_metadata(table));
            let pairs = [
                (INSTANCE, instance.name.clone()),
                (GROUP, instance.group.to_string()),
                (PLACE, place.to_string()),
                (INSTANCES, table.instances.len().to_string()),
            ];
            metadata.extend(pairs.map(|(key, value)| (key.to_owned(), value)));
            instances.push(
                self.mcap
                    .add_channel(schema, &topic, "protobuf", &metadata)?,
            );
        }
        let metadata = table_metadata(table).into();
        let log = self.schema(&log::schema(), "protobuf")?;
        let topic = format!("{}/log", table.name);
        let log = self.mcap.add_channel(log, &topic, "protobuf", &metadata)?;
        let object = Schema {
            name: "coaxle.Status".to_owned(),
            data: br#"{"type":"object"}"#.to_vec(),
        };
        let status = self.schema(&object, "jsonschema")?;
        let topic = format!("{}/status", table.name);
        let status = self.mcap.add_channel(status, &topic, "json", &metadata)?;
        Ok(Channels {
            instances,
            log,
            status,
            inputs: None,
            audit: None,
            name: table.name.clone(),
            metadata,
            written: WrittenCount::NOTHING,
        })
    }

    fn schema(&mut self, schema: &Schema, encoding: &str) -> Result<u16, WriteError> {
        Ok(self.mcap.add_schema(&schema.name, encoding, &schema.data)?)
    }
}

/// Returns the topic of an instance; that of the node itself is the node's name.
fn topic(table: &Table, instance: &Instance, prefix: &str) -> String {
    let is_taken = |name: &str| table.instances.iter().any(|other| other.name == name);
    match instance.name.as_str() {
        // An axis may be named like its node, and two channels of one topic would be merged by viewers.
        "" if is_taken(&table.name) => format!("{prefix}{} (node)", table.name),
        "" => format!("{prefix}{}", table.name),
        name => format!("{prefix}{name}"),
    }
}

/// Returns the metadata common to the channels of a table.
fn table_metadata(table: &Table) -> [(String, String); 2] {
    let pairs = [(TABLE, &table.name), (ROLE, &table.role)];
    pairs.map(|(key, value)| (key.to_owned(), value.clone()))
}

/// Returns the unit of each signal that has one, with the unit of the axis inserted.
fn units(instance: &Instance) -> BTreeMap<String, String> {
    let unit = |signal: &coaxle_node::signal::Signal| {
        let unit = instance.unit.in_place_of_u(signal.unit);
        (!unit.is_empty()).then(|| (format!("{UNIT}{}", signal.name), unit))
    };
    instance.signals.iter().filter_map(unit).collect()
}

/// The schemas so far: groups with equal signals share one, others need another name.
#[derive(Default)]
struct Schemas(BTreeMap<String, Vec<u8>>);

impl Schemas {
    fn of(&mut self, instance: &Instance, role: &str) -> Schema {
        let mut variant = 0;
        loop {
            let schema = Schema::of(instance, role, variant);
            let taken = self.0.entry(schema.name.clone());
            // The name is in the schema: another variant differs from this one by it, and is compared with its own.
            if *taken.or_insert_with(|| schema.data.clone()) == schema.data {
                return schema;
            }
            variant += 1;
        }
    }
}
