//! Recovery of an unfinished or damaged file: its valid parts, with a summary.

use std::io::{BufWriter, Read, Write};

use mcap::records::Record;
use mcap::write::NoSeek;
use mcap::{Attachment, McapError};

use crate::damage_list::DamageList;
use crate::records::RecordReader;
use crate::writer::{WriteError, options};

/// Recovered part of a file.
#[derive(Debug, Default)]
pub struct Recovered {
    /// Messages: rows have one for each instance.
    pub messages: u64,
    /// Messages lost with their channels.
    pub lost: u64,
    /// Time range of the messages, ns since 1970 as in the file.
    pub span_ns: Option<(u64, u64)>,
    /// Damage with its places; the last one is the end of a truncated file.
    pub damage: DamageList,
}

impl Recovered {
    /// True if it was undamaged.
    #[must_use]
    pub const fn was_whole(&self) -> bool {
        self.damage.listed().is_empty()
    }

    fn keep(&mut self, time: u64) {
        self.messages += 1;
        let (start, end) = self.span_ns.unwrap_or((time, time));
        self.span_ns = Some((start.min(time), end.max(time)));
    }
}

/// Writes the valid parts of `from` to `to`, as a finished file.
///
/// # Errors
/// [`WriteError`]. Damage of `from` is not an error: it is in the result.
pub fn recover(from: impl Read, to: impl Write) -> Result<Recovered, WriteError> {
    let mut writer = options().create(NoSeek::new(BufWriter::new(to)))?;
    let mut recovered = Recovered::default();
    for record in RecordReader::new(from) {
        match record {
            Ok(record) => copy(record, &mut writer, &mut recovered)?,
            Err(damage) => recovered.damage.note(damage),
        }
    }
    writer.finish()?;
    let written = writer.into_inner().into_inner();
    written
        .into_inner()
        .map_err(|error| McapError::Io(error.into_error()))?;
    Ok(recovered)
}

fn copy<W: Write>(
    record: Record<'static>,
    writer: &mut mcap::Writer<NoSeek<W>>,
    recovered: &mut Recovered,
) -> Result<(), McapError> {
    let copied = match record {
        // Numbers are kept: messages refer to them, and some may come before a repeated schema.
        Record::Schema { header, data } => writer
            .add_schema_with_id(header.id, &header.name, &header.encoding, &data)
            .map(|_| ()),
        Record::Channel(channel) => writer
            .add_channel_with_id(
                channel.id,
                channel.schema_id,
                &channel.topic,
                &channel.message_encoding,
                &channel.metadata,
            )
            .map(|_| ()),
        Record::Message { header, data } => {
            let written = writer.write_to_known_channel(&header, &data);
            // Counted after writing, so that the range covers only messages that can be read again.
            if written.is_ok() {
                recovered.keep(header.log_time);
            }
            written
        }
        Record::Metadata(metadata) => writer.write_metadata(&metadata),
        Record::Attachment { header, data, .. } => writer.attach(&Attachment {
            log_time: header.log_time,
            create_time: header.create_time,
            name: header.name,
            media_type: header.media_type,
            data,
        }),
        _ => Ok(()),
    };
    match copied {
        // Records that refer to a lost record, or contradict it, are lost.
        Err(
            McapError::UnknownChannel(..)
            | McapError::UnknownSchema(..)
            | McapError::InvalidSchemaId
            | McapError::ConflictingSchemas(_)
            | McapError::ConflictingChannels(_),
        ) => {
            recovered.lost += 1;
            Ok(())
        }
        other => other,
    }
}
