//! Drawing data of the page: its wanted signals, out of the pieces that a node publishes.
//!
//! A block is a head in JSON and then numbers, all little-endian: the length of the head (u32), the head, padding to a multiple
//! of eight bytes, the time of each row (f64, s since 1970), and for each signal its value in each row (f64, NaN where it is not
//! known). Words are numbers, which the heads explain.

use std::collections::BTreeMap;

use coaxle_node::signal::Kind;
use coaxle_recording::{Column, Item, Level, ReadTable, Reader, Value};
use serde::Serialize;

/// A signal as the page has it.
#[derive(Clone, Debug, Serialize)]
pub(super) struct SignalInfo {
    pub(super) name: String,
    instance: String,
    group: String,
    unit: String,
    is_word: bool,
}

impl SignalInfo {
    fn of(column: &Column) -> Self {
        Self {
            name: column.name(),
            instance: column.instance.clone(),
            group: column.group.clone(),
            unit: column.unit.clone(),
            is_word: column.kind == Kind::Text,
        }
    }
}

/// The signals of a piece; none of a malformed one.
pub(super) fn signals_of(piece: &[u8]) -> Vec<SignalInfo> {
    let mut reader = Reader::new(piece);
    reader.by_ref().for_each(drop);
    let tables = reader.tables().iter();
    let columns = tables.flat_map(|table| &table.columns);
    columns.map(SignalInfo::of).collect()
}

/// Makes blocks of pieces.
#[derive(Default)]
pub(super) struct Blocks {
    wanted: Vec<String>,
    /// Distinct words of each wanted signal so far, and how many of them the page knows.
    words: Vec<Vec<String>>,
    known_words: Vec<usize>,
    epoch: String,
    piece: u64,
}

/// In front of the numbers.
#[derive(Debug, Serialize)]
struct BlockHead<'a> {
    rows: usize,
    signals: usize,
    /// The run of the node, and which of its pieces it is.
    epoch: &'a str,
    piece: u64,
    /// For each wanted signal that has new words: the number of the first one, and they.
    words: BTreeMap<usize, (usize, &'a [String])>,
    log: Vec<BlockLogLine>,
    /// Wanted signals that the node does not have.
    unknown: Vec<&'a str>,
}

#[derive(Debug, Serialize)]
struct BlockLogLine {
    at: f64,
    level: &'static str,
    text: String,
}

/// Greatest number of distinct words of a signal: states have some ten.
// A signal whose words never repeat would grow the table for as long as the page is open.
const MOST_WORDS: usize = 1000;
const NANOS: f64 = 1e9;

impl Blocks {
    pub(super) fn of(wanted: Vec<String>) -> Self {
        Self {
            words: vec![Vec::new(); wanted.len()],
            known_words: vec![0; wanted.len()],
            wanted,
            epoch: String::new(),
            piece: 0,
        }
    }

    /// The block of a piece; none of a malformed or empty one.
    pub(super) fn block(&mut self, piece: &[u8]) -> Option<Vec<u8>> {
        let mut reader = Reader::new(piece);
        let mut places: Option<Vec<Option<usize>>> = None;
        let (mut times, mut offset) = (Vec::new(), 0);
        let mut values = vec![Vec::new(); self.wanted.len()];
        let mut log = Vec::new();
        let seconds = |at_ns: i64, offset: i64| at_ns.saturating_add(offset) as f64 / NANOS;
        while let Some(item) = reader.next() {
            // A damaged piece is left out as a whole: the page then misses its number.
            match item.ok()? {
                Item::Facts(facts) => {
                    let number = |name: &str| -> Option<i64> { facts.get(name)?.parse().ok() };
                    offset = number("clock-offset-ns").unwrap_or(offset);
                    self.piece = number("piece").unwrap_or_default().unsigned_abs();
                    self.epoch = facts.get("epoch").cloned().unwrap_or_default();
                }
                Item::Row(row) => {
                    // Once for each piece, as its columns are known only with its first row.
                    let places = places.get_or_insert_with(|| self.places(reader.tables()));
                    times.push(seconds(row.at_ns, offset));
                    for (n, place) in places.iter().enumerate() {
                        let value = place.and_then(|place| row.values.get(place)?.clone());
                        values[n].push(self.number(n, value));
                    }
                }
                Item::Log(line) => log.push(BlockLogLine {
                    at: seconds(line.at_ns, offset),
                    level: level(line.level),
                    text: line.text,
                }),
                Item::Attachment { .. }
                | Item::Status { .. }
                | Item::Audit { .. }
                | Item::Inputs { .. } => {}
            }
        }
        // Between rows there may be pieces with log lines alone.
        if times.is_empty() && log.is_empty() {
            return None;
        }
        let places = places.unwrap_or_else(|| self.places(reader.tables()));
        let block = self.put(&times, &values, log, &places);
        for (known_words, words) in self.known_words.iter_mut().zip(&self.words) {
            *known_words = words.len();
        }
        Some(block)
    }

    fn put(
        &self,
        times: &[f64],
        values: &[Vec<f64>],
        log: Vec<BlockLogLine>,
        places: &[Option<usize>],
    ) -> Vec<u8> {
        let new = self.words.iter().zip(&self.known_words).enumerate();
        let new = new.filter(|(_, (words, known_words))| words.len() > **known_words);
        let unknown = self.wanted.iter().zip(places);
        let unknown = unknown.filter(|(_, place)| place.is_none());
        let head = BlockHead {
            rows: times.len(),
            signals: values.len(),
            epoch: &self.epoch,
            piece: self.piece,
            words: new
                .map(|(n, (words, known_words))| (n, (*known_words, &words[*known_words..])))
                .collect(),
            log,
            unknown: unknown.map(|(name, _)| name.as_str()).collect(),
        };
        // Nothing in it can fail to be JSON.
        let head = serde_json::to_vec(&head).unwrap_or_default();
        let mut block = Vec::with_capacity(16 + head.len() + 8 * times.len() * (values.len() + 1));
        // A head has some kilobytes, far below 4 GiB.
        block.extend((head.len() as u32).to_le_bytes());
        block.extend(head);
        // A `Float64Array` over the bytes may begin at a multiple of eight only.
        block.resize(block.len().next_multiple_of(8), 0);
        let numbers = times.iter().chain(values.iter().flatten());
        block.extend(numbers.flat_map(|number| number.to_le_bytes()));
        block
    }

    /// Column of each wanted signal in a row.
    fn places(&self, tables: &[ReadTable]) -> Vec<Option<usize>> {
        // A node publishes one table.
        let columns = tables.first().map_or(&[][..], |table| &table.columns);
        let names: Vec<_> = columns.iter().map(Column::name).collect();
        let place = |wanted: &String| names.iter().position(|name| name == wanted);
        self.wanted.iter().map(place).collect()
    }

    fn number(&mut self, signal: usize, value: Option<Value>) -> f64 {
        match value {
            None => f64::NAN,
            Some(Value::Number(number)) => number,
            // Exact up to 2^53; the page has doubles only.
            Some(Value::Count(count)) => count as f64,
            Some(Value::Integer(integer)) => integer as f64,
            Some(Value::Flag(flag)) => f64::from(u8::from(flag)),
            Some(Value::Text(word)) => self.word(signal, word),
        }
    }

    fn word(&mut self, signal: usize, word: String) -> f64 {
        let words = &mut self.words[signal];
        match words.iter().position(|known| *known == word) {
            Some(number) => number as f64,
            None if words.len() < MOST_WORDS => {
                words.push(word);
                (words.len() - 1) as f64
            }
            None => f64::NAN,
        }
    }
}

const fn level(level: Level) -> &'static str {
    match level {
        Level::Info => "info",
        Level::Warning => "warning",
        Level::Error => "error",
    }
}
