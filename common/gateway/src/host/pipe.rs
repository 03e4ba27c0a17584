//! Records on standard input and output: as lines of CSV, or as bytes.

use std::io::{BufRead, BufReader, Read, Write};
use std::sync::Arc;
use std::thread::JoinHandle;

use coaxle_os::machine;

use super::port::{OutputSlot, PlcEnd, PlcLink, PlcOutputs, Samples, StopFlag};
use super::thread;
use super::udp::write_record;
use crate::config::{GatewayConfig, OutputAxisConfig, PipeConfig, PipeFormat};
use crate::record::{read_record, record_len};
use crate::record_line::{head_line, read_line, write_line};
use crate::{PlcOutput, PlcSample};

/// A line that is longer is none.
// 128 axes with three numbers of 25 characters have less than 10 kB.
const MOST_LINE_BYTES: u64 = 64 * 1024;

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
        let mut line = String::new();
        let mut number = 0_u64;
        loop {
            line.clear();
            // A line without an end would otherwise fill the memory.
            let length = input.by_ref().take(MOST_LINE_BYTES).read_line(&mut line)?;
            // Right after the read: parsing is not part of the arrival.
            let at = machine::now();
            number += 1;
            let text = line.trim_end();
            if length == 0 {
                return Ok(());
            }
            // A head line may be first.
            // Only the first line: a later one is a mistake, and counted.
            if text.is_empty() || number == 1 && text.starts_with("index") {
                continue;
            }
            let taken = self.samples.send(at, |sample: &mut PlcSample| {
                sample.index = read_line(text, &mut sample.axes)?;
                Ok::<_, crate::record_line::RecordLineError>(())
            });
            if let Err(error) = taken
                // The first refusal only: a thousand lines a second would be refused in the same way.
                && self.link.count_refused()
            {
                tracing::warn!(
                    "standard input, line {number}: {error}; others may be refused, too"
                );
            }
        }
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
