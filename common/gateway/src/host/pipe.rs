//! Records on standard input and output: as lines of CSV, or as bytes.

use std::io::{BufRead, BufReader, Read, Write};
use std::sync::Arc;
use std::thread::JoinHandle;

use coaxle_clock::Instant;
use coaxle_os::{Machine, machine};

use super::port::{OutputSlot, PlcEnd, PlcLink, PlcOutputs, Samples, StopFlag};
use super::thread;
use super::udp::write_record;
use crate::config::{GatewayConfig, OutputAxisConfig, PipeConfig, PipeFormat};
use crate::record::{read_record, record_len};
use crate::record_line::{RecordLineError, head_line, read_line, write_line};
use crate::{PlcOutput, PlcSample};

/// A line that is longer is none.
// 128 axes with three numbers of 25 characters have less than 10 kB.
const MOST_LINE_BYTES: usize = 64 * 1024;

/// Reason why a line is not taken.
#[derive(Debug, thiserror::Error)]
enum BadLine {
    #[error("byte {byte} received is no UTF-8, expected text")]
    Encoding { byte: usize },
    #[error("received more than {MOST_LINE_BYTES} bytes, expected a line of at most that many")]
    Long,
    #[error(transparent)]
    Record(RecordLineError),
}

/// Starts to read and to write. The reading thread is not among those that can be ended: it waits for standard input,
/// and ends with the process.
pub(super) fn start(config: &GatewayConfig, end: PlcEnd) -> anyhow::Result<Vec<JoinHandle<()>>> {
    let PlcEnd {
        samples,
        outputs,
        link,
        stop,
    } = end;
    let format = format(config.pipe.as_ref());
    if config.axes.is_empty() {
        // Nothing on a pipe shows a PLC that only reads: it counts as connected from the start.
        let _ = link.connected();
    } else {
        let config = config.clone();
        let _reads = thread("plc-in", move || {
            let reading = PipeReader {
                samples,
                link,
                config,
            };
            reading.work(format, std::io::stdin());
        })?;
    }
    if config.outputs.is_empty() {
        return Ok(Vec::new());
    }
    let config = config.clone();
    let written = thread("plc-out", move || {
        write(&config, format, outputs, &stop);
    })?;
    Ok(vec![written])
}

fn format(pipe: Option<&PipeConfig>) -> PipeFormat {
    pipe.map_or_else(PipeFormat::default, |pipe| pipe.format)
}

struct PipeReader {
    samples: Samples,
    link: Arc<PlcLink>,
    config: GatewayConfig,
}

impl PipeReader {
    fn work(mut self, format: PipeFormat, input: impl Read) {
        let _ = self.link.connected();
        let mut input = BufReader::new(input);
        let ended = match format {
            PipeFormat::Csv => self.read_lines(&mut input),
            PipeFormat::Binary => self.read_records(&mut input),
        };
        self.link.disconnected();
        match ended {
            Ok(()) => tracing::info!("standard input has ended: no more axes come"),
            Err(error) => tracing::error!(%error, "standard input cannot be read any more"),
        }
    }

    fn read_lines(&mut self, input: &mut impl BufRead) -> std::io::Result<()> {
        let mut line = Vec::new();
        let mut number = 0_u64;
        while next_line(input, &mut line)? {
            // Right after the read: parsing is not part of the arrival.
            let at = machine::now();
            number += 1;
            // A byte that is no UTF-8 spoils its line only: `BufRead::read_line` would end the reading for good.
            let taken = match std::str::from_utf8(&line) {
                _ if line.len() > MOST_LINE_BYTES => Err(BadLine::Long),
                // A head line may be first.
                // Only the first line: a later one is a mistake, and counted.
                Ok(text)
                    if text.trim_end().is_empty() || number == 1 && text.starts_with("index") =>
                {
                    continue;
                }
                Err(error) => Err(BadLine::Encoding {
                    byte: error.valid_up_to() + 1,
                }),
                Ok(text) => self.take_line(at, text.trim_end()).map_err(BadLine::Record),
            };
            if let Err(error) = taken
                // The first refusal only: a thousand lines a second would be refused in the same way.
                && self.link.count_refused()
            {
                tracing::warn!(
                    "standard input, line {number}: {error}; others may be refused, too"
                );
            }
        }
        Ok(())
    }

    fn take_line(&mut self, at: Instant<Machine>, text: &str) -> Result<(), RecordLineError> {
        self.samples.send(at, |sample: &mut PlcSample| {
            sample.index = read_line(text, &mut sample.axes)?;
            Ok(())
        })
    }

    fn read_records(&mut self, input: &mut impl Read) -> std::io::Result<()> {
        let layout = self.config.layout.into();
        let mut record = vec![0; record_len(self.config.axes.len())];
        loop {
            // A pipe cuts records anywhere: a part of the last one ends with the pipe.
            match input.read_exact(&mut record) {
                Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => return Ok(()),
                other => other?,
            }
            let at = machine::now();
            // Its length is right.
            let _ = self.samples.send(at, |sample: &mut PlcSample| {
                sample.index = read_record(layout, &record, &mut sample.axes)?;
                Ok::<_, crate::record::RecordLengthError>(())
            });
        }
    }
}

/// Reads the next line, without its end, into `line`; false if the input has ended. A line of more than
/// [`MOST_LINE_BYTES`] is cut to one byte more than that, and its rest is passed over.
fn next_line(input: &mut impl BufRead, line: &mut Vec<u8>) -> std::io::Result<bool> {
    line.clear();
    // A line without an end would otherwise fill the memory.
    let most = MOST_LINE_BYTES + 1;
    let read = (input.by_ref().take(most as u64)).read_until(b'\n', line)?;
    if line.last() == Some(&b'\n') {
        line.pop();
    } else if read == most {
        // The rest could otherwise pass for a line of its own.
        input.skip_until(b'\n')?;
    }
    Ok(read > 0)
}

/// Writes each record once, at once.
fn write(config: &GatewayConfig, format: PipeFormat, mut outputs: PlcOutputs, stop: &StopFlag) {
    outputs.attach();
    let axes: Vec<&OutputAxisConfig> = config.output_axes().collect();
    let mut slot = OutputSlot::of(config);
    let (mut line, mut record) = (String::new(), Vec::new());
    if format == PipeFormat::Csv {
        line = head_line(config.output_names().iter().map(String::as_str)) + "\n";
        record.extend_from_slice(line.as_bytes());
        // Nobody reads: there is no place for outputs, and the node goes on.
        if put(&record).is_err() {
            return;
        }
    }
    while !stop.is_set() {
        if !outputs.next_into(&mut slot) {
            continue;
        }
        let is_whole = match format {
            PipeFormat::Csv => {
                line.clear();
                let OutputSlot {
                    number,
                    index,
                    axes,
                } = &slot;
                let output = PlcOutput {
                    number: *number,
                    index: *index,
                    axes,
                };
                write_line(&output, &mut line);
                record.clear();
                record.extend_from_slice(line.as_bytes());
                // A missing axis is an empty field of a line.
                true
            }
            // A record of bytes has no place for a missing axis.
            PipeFormat::Binary => write_record(&slot, &axes, config.layout.into(), &mut record),
        };
        if is_whole && let Err(error) = put(&record) {
            tracing::warn!(%error, "standard output takes no more: nothing is written any more");
            return;
        }
    }
}

fn put(record: &[u8]) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(record)?;
    // Flushed for each record: a reader in real time must not wait for a full buffer.
    out.flush()
}

#[cfg(test)]
mod tests {
    use coaxle_clock::Local;
    use coaxle_node::config::parse;

    use super::super::port::rings;
    use super::*;
    use crate::Port;

    /// Reads this input as lines; returns the indices of the samples, and the number of refused lines.
    fn read(input: &[u8]) -> (Vec<u16>, u64) {
        let text = "name = 'plc'\ncycle-time-us = 1000\n[pipe]\n[[axis]]\nid = 7\nname = 'belt'\n";
        let config: GatewayConfig = parse("g", text).unwrap();
        let (mut port, end) = rings(&config, Arc::default());
        let reader = PipeReader {
            samples: end.samples,
            link: end.link,
            config,
        };
        reader.work(PipeFormat::Csv, input);
        let mut sample = PlcSample::of_axes(1);
        let mut indices = Vec::new();
        while port.receive(Instant::<Local>::EPOCH, &mut sample) {
            indices.push(sample.index.0);
        }
        (indices, port.state().refused)
    }

    #[test]
    fn a_byte_that_is_no_text_spoils_its_line_only() {
        let text = b"index,belt\n\xff\n1,2,3,4\n2,\xc3,3,4\n\n3,2,3,4";
        assert_eq!(read(text), (vec![1, 3], 2));
    }

    #[test]
    fn a_line_that_is_too_long_is_passed_over_whole() {
        // Characters of two bytes from an odd place on: the cut is inside of one.
        let mut text = b"1,2,3,4\nx".to_vec();
        text.extend("é".repeat(MOST_LINE_BYTES).bytes());
        text.extend(b"\n2,2,3,4\n");
        // Digits: a rest of them must not be taken for a sample.
        text.extend(b"5".repeat(MOST_LINE_BYTES + 1));
        text.extend(b"9,2,3,4\n3,2,3,4\n");
        assert_eq!(read(&text), (vec![1, 2, 3], 2));
        // At the limit, with its end.
        let mut text = b"1,2,3,4".to_vec();
        text.resize(MOST_LINE_BYTES, b' ');
        text.extend(b"\n2,2,3,4\n");
        assert_eq!(read(&text), (vec![1, 2], 0));
    }
}
