//! The records of a file, also of an unfinished or damaged one as far as possible.
//!
//! A file is a sequence of records, each with its length in front; most are in compressed chunks. The
//! check sum of a chunk is verified before its content is used. Of a damaged chunk nothing is used, but
//! what follows it is; after a damaged length nothing can be found.

use std::collections::BTreeMap;
use std::io::{self, Read};

use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError, parse_record};

use crate::claims::{self, TooLongPart};

/// The greatest length of a record, of the content of a chunk, and of all descriptions in a file together, that is
/// read: chunks of ours are a sixteenth of it.
pub(crate) const MOST_BYTES: usize = 64 << 20;

/// Greatest number of signals that are read of a file: some times those of the largest node.
pub(crate) const MOST_SIGNALS: usize = 200_000;

/// Damage of a file and its place.
#[derive(Debug, thiserror::Error)]
#[error("byte {offset}: {fault}")]
pub struct Damage {
    /// Offset of the damaged record.
    pub offset: u64,
    /// Kind of the damage.
    pub fault: Fault,
}

/// Damage of a record.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// An error of the system on reading the file.
    #[error("cannot be read: {0}")]
    System(#[from] io::Error),
    /// A file that does not begin with MCAP's magic bytes.
    #[error("received other bytes, expected those that an MCAP file begins with")]
    NoMcap,
    /// End of the file within the record.
    #[error("the file ends within a record")]
    CutOff,
    /// End of the file without an end record.
    #[error("the file ends without its summary: its writer did not end it")]
    Unfinished,
    /// A length that no record has.
    #[error("received a record of {0} bytes, expected at most {MOST_BYTES}")]
    TooLong(u64),
    /// A part of a record that reaches beyond it.
    #[error("{0}")]
    TooLongPart(#[from] TooLongPart),
    /// More schemas, channels, metadata and names of files than any recording has.
    #[error(
        "received descriptions of more than {MOST_BYTES} bytes, expected at most that many in all"
    )]
    TooManyDescriptions,
    /// An invalid record.
    #[error("{0}")]
    Record(#[from] McapError),
    /// More signals than any recording has.
    #[error(
        "received more than {MOST_SIGNALS} signals, expected at most that many in all channels"
    )]
    TooManySignals,
    /// A message that does not fit its schema.
    #[error("{topic}: received a message that is none of its schema")]
    Message {
        /// The channel.
        topic: String,
    },
    /// A channel with invalid metadata.
    #[error("{topic}: {field}: received {received:?}, expected {expected}")]
    Channel {
        /// The channel.
        topic: String,
        /// The field of its metadata.
        field: &'static str,
        /// Value received.
        received: String,
        /// Permitted values.
        expected: &'static str,
    },
}

/// The records of a file.
pub(crate) struct RecordReader<R> {
    input: R,
    offset: u64,
    chunk: ChunkRecords,
    descriptions: Descriptions,
    state: ReadState,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum ReadState {
    Start,
    Data,
    /// End of the records: the last one has been read, or no more can be found.
    Over,
}

impl<R: Read> RecordReader<R> {
    pub(crate) const fn new(input: R) -> Self {
        Self {
            input,
            offset: 0,
            chunk: ChunkRecords::NONE,
            descriptions: Descriptions::NONE,
            state: ReadState::Start,
        }
    }

    /// Returns the offset of the next record of the file.
    pub(crate) const fn offset(&self) -> u64 {
        self.offset
    }

    fn advance(&mut self) -> Option<Result<Record<'static>, Damage>> {
        loop {
            let offset = self.offset;
            let read = match self.chunk.next() {
                Some(record) => record.map(Some),
                None if self.state == ReadState::Over => return None,
                None => self.read_on(),
            };
            // Kept by every user of the records, in whatever chunk they are.
            match read.and_then(|record| self.descriptions.admit(record)) {
                Ok(Some(record)) => return Some(Ok(record)),
                Ok(None) => {}
                Err(fault) => return Some(Err(Damage { offset, fault })),
            }
        }
    }

    /// Reads one record of the file. Returns none for a chunk, whose records are queued, and for one
    /// without content.
    fn read_on(&mut self) -> Result<Option<Record<'static>>, Fault> {
        if self.state == ReadState::Start {
            return self.begin().map(|()| None);
        }
        let frame = self.frame();
        let Ok((opcode, data)) = frame else {
            // Records form a chain of lengths: after a failed one the beginning of the next is unknown.
            self.state = ReadState::Over;
            return frame.map(|_| None);
        };
        match opcode {
            op::DATA_END => {
                // Only the summary follows, which repeats what has been read.
                self.state = ReadState::Over;
                Ok(None)
            }
            op::CHUNK => {
                // The last chunk's memory before this one's.
                self.chunk = ChunkRecords::NONE;
                // On damage the chunk is skipped as a whole and reading goes on behind it: its length was good.
                self.chunk = ChunkRecords::of(&data)?;
                Ok(None)
            }
            op::METADATA | op::ATTACHMENT | op::SCHEMA | op::CHANNEL | op::MESSAGE => {
                Ok(Some(parse(opcode, &data)?.into_owned()))
            }
            // Indexes serve seeking, and unknown records are to be ignored by the specification of MCAP.
            _ => Ok(None),
        }
    }

    fn begin(&mut self) -> Result<(), Fault> {
        // Set first, so that every early return below ends the reading.
        self.state = ReadState::Over;
        let mut magic = [0; MAGIC.len()];
        match self.fill(&mut magic) {
            // An empty or very short file is none of MCAP, rather than an unfinished one.
            Err(Fault::CutOff | Fault::Unfinished) => return Err(Fault::NoMcap),
            other => other?,
        }
        if magic != *MAGIC {
            return Err(Fault::NoMcap);
        }
        self.state = ReadState::Data;
        Ok(())
    }

    /// Reads the next record: its opcode, and its bytes.
    fn frame(&mut self) -> Result<(u8, Vec<u8>), Fault> {
        let mut head = [0; 9];
        self.fill(&mut head)?;
        let [opcode, length @ ..] = head;
        let length = u64::from_le_bytes(length);
        // Checked before reading: a damaged length may be any number of 64 bits.
        if length > MOST_BYTES as u64 {
            return Err(Fault::TooLong(length));
        }
        // Not filled with zeros first: the file may be shorter than the length.
        let mut data = Vec::new();
        let read = self.input.by_ref().take(length).read_to_end(&mut data)?;
        self.offset += read as u64;
        if read as u64 == length {
            Ok((opcode, data))
        } else {
            Err(Fault::CutOff)
        }
    }

    /// Fills the buffer; no bytes at all are the end of an unfinished file.
    fn fill(&mut self, buffer: &mut [u8]) -> Result<(), Fault> {
        let length = buffer.len();
        let mut filled = 0;
        while filled < length {
            match self.input.read(&mut buffer[filled..]) {
                // Between two records the file is unfinished, within one it is cut off.
                Ok(0) if filled == 0 => return Err(Fault::Unfinished),
                Ok(0) => return Err(Fault::CutOff),
                Ok(read) => filled += read,
                // A signal during the read is no error of the file.
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error.into()),
            }
        }
        self.offset += length as u64;
        Ok(())
    }
}

impl<R: Read> Iterator for RecordReader<R> {
    type Item = Result<Record<'static>, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        self.advance()
    }
}

/// Parses a record whose lengths are checked first.
fn parse(opcode: u8, data: &[u8]) -> Result<Record<'_>, Fault> {
    claims::check(opcode, data)?;
    Ok(parse_record(opcode, data)?)
}

/// Records of a chunk that have been checked, in the form of the file.
// Parsed one by one: 64 MiB of small records would be ten times as many bytes once parsed.
struct ChunkRecords {
    bytes: Vec<u8>,
    next: usize,
}

/// Length of a record's opcode and length.
const HEAD_BYTES: usize = 1 + 8;

impl ChunkRecords {
    const NONE: Self = Self {
        bytes: Vec::new(),
        next: 0,
    };

    /// Takes the records of a chunk completely, or none: its check sum is verified first.
    fn of(chunk: &[u8]) -> Result<Self, Fault> {
        // The chunk is parsed as a file of its own, without the magic bytes around it.
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MOST_BYTES);
        let mut reader = LinearReader::new_with_options(options);
        // Opcode and length were consumed by the frame, but the reader of the library expects them.
        let head = [&[op::CHUNK], (chunk.len() as u64).to_le_bytes().as_slice()].concat();
        let mut input = head.as_slice().chain(chunk);
        let mut records = Self::NONE;
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(need) => {
                    // The request is by the lengths in the chunk; no more is read than there is.
                    let need = need.min(head.len() + chunk.len());
                    let read = input.read(reader.insert(need))?;
                    reader.notify_read(read);
                }
                LinearReadEvent::Record { opcode, data } => {
                    parse(opcode, data)?;
                    records.bytes.push(opcode);
                    let length = data.len() as u64;
                    records.bytes.extend_from_slice(&length.to_le_bytes());
                    records.bytes.extend_from_slice(data);
                }
            }
        }
        Ok(records)
    }
}

impl Iterator for ChunkRecords {
    type Item = Result<Record<'static>, Fault>;

    fn next(&mut self) -> Option<Self::Item> {
        let rest = self.bytes.get(self.next..)?;
        let ([opcode, length @ ..], behind) = rest.split_first_chunk::<HEAD_BYTES>()?;
        // Written above, and so neither damaged nor longer than the rest.
        let length = u64::from_le_bytes(*length) as usize;
        self.next += HEAD_BYTES + length;
        Some(parse(*opcode, behind.get(..length)?).map(Record::into_owned))
    }
}

/// Sizes of what a reader keeps of a file, however long the file is.
struct Descriptions {
    /// Schemas and channels by their numbers: repeated ones count once.
    numbered: BTreeMap<(u8, u16), usize>,
    bytes: usize,
}

/// Size of a number and of the places in which a description is kept.
const KEPT_BYTES: usize = 64;

impl Descriptions {
    const NONE: Self = Self {
        numbered: BTreeMap::new(),
        bytes: 0,
    };

    /// Counts a description; any other record passes.
    fn admit(&mut self, record: Option<Record<'static>>) -> Result<Option<Record<'static>>, Fault> {
        let Some(record) = record else {
            return Ok(None);
        };
        let opcode = record.opcode();
        let (number, bytes) = match &record {
            Record::Schema { header, data } => {
                let bytes = header.name.len() + header.encoding.len() + data.len();
                (Some(header.id), bytes)
            }
            Record::Channel(channel) => {
                let bytes = channel.topic.len() + channel.message_encoding.len();
                (Some(channel.id), bytes + length_of(&channel.metadata))
            }
            Record::Metadata(metadata) => {
                (None, metadata.name.len() + length_of(&metadata.metadata))
            }
            Record::Attachment { header, .. } => {
                (None, header.name.len() + header.media_type.len())
            }
            _ => return Ok(Some(record)),
        };
        let bytes = bytes + KEPT_BYTES;
        let before = number.and_then(|number| self.numbered.get(&(opcode, number)));
        let sum = self.bytes - before.copied().unwrap_or(0) + bytes;
        if sum > MOST_BYTES {
            return Err(Fault::TooManyDescriptions);
        }
        if let Some(number) = number {
            self.numbered.insert((opcode, number), bytes);
        }
        self.bytes = sum;
        Ok(Some(record))
    }
}

fn length_of(texts: &BTreeMap<String, String>) -> usize {
    let pairs = texts.iter();
    pairs
        .map(|(key, text)| key.len() + text.len() + KEPT_BYTES)
        .sum()
}
