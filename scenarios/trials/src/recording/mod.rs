//! `coaxle record-arrivals`: arrivals of messages between real nodes, in the format that the
//! estimators of a far clock are judged by.

mod busy;
mod convert;
mod format;
mod live;
mod raw;
mod summary;

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use coaxle_clock::Span;
use coaxle_node::config::{CycleMicros, DurationSeconds};

pub use busy::{COMMAND as KEEP_BUSY, keep_busy};
use coaxle_lab::finished::Progress;

use crate::processes::Protocol;
use convert::{TimeScale, convert};
use format::{ArrivalRecording, RecordingFiles};
use live::RecordingSettings;
use raw::Raw;
use summary::{RecordingOrigin, RecordingSummary};

/// Settings and destination of a recording.
#[derive(Debug, Args)]
#[command(after_long_help = FORMAT)]
pub struct RecordArrivalsArgs {
    /// The recording: DIR/NAME gives DIR/NAME.i32, DIR/NAME-exchanges.csv and DIR/NAME.json
    #[arg(long, value_name = "DIR/NAME")]
    out: PathBuf,
    /// Duration, s
    #[arg(long, default_value = "60", value_parser = duration)]
    seconds: DurationSeconds,
    /// Cycle time of both nodes, µs: 100 to 100000
    #[arg(long, value_name = "MICROS", default_value = "1000", value_parser = cycle_micros)]
    cycle_us: CycleMicros,
    /// Transport protocol between the nodes
    #[arg(long, value_enum, default_value_t = Protocol::Tcp)]
    transport: Protocol,
    /// Start this number of processes beside the nodes, at most 256, that only keep processors busy
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(..=256))]
    busy: u16,
    /// Ask for SCHED_FIFO, priority 80, for the cycles of both nodes, and keep their memory in RAM;
    /// requests that are not permitted are left out with a warning
    #[arg(long)]
    real_time: bool,
    /// Record nothing, but convert a receiver's file of --arrivals or the one beside its --trace
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = ["seconds", "cycle_us", "transport", "busy", "real_time"]
    )]
    from: Option<PathBuf>,
}

/// The end of the long help.
const FORMAT: &str = "\
Without --from a sender and a receiver run as processes of this machine, over Zenoh on loopback,
with nothing wrong with their clocks or their link on purpose. Both read the machine's monotonic
clock, so delays are true, and an estimator should find a drift of 0.

With --from the file may be of two PCs whose clocks nobody compared. A straight line is fitted to
the earliest messages of each second: its slope is the drift of the receiver's clock against the
sender's, and what deviates from it is recorded as the delay. So the drift is taken away, the least
delay is 0, and what the clocks did beside the line (temperature, a random walk) is in the delays:
an estimator that follows the clocks well follows that too, and its error is to be read
accordingly. Of several runs of the sender the longest is taken.

NAME.i32 has a row of four little-endian 32-bit integers per message, in the order of arrival:
  count       the sender's cycle; 0 is the first recorded one
  send stamp  how late after its ideal start, count times the cycle time, it was sent, ns;
              0 where the sender does not say
  delay       arrival minus send, ns
  0           the delay by the kernel's receive stamp, which Zenoh does not show
NAME-exchanges.csv has the stamps of each time exchange, t1_ns, t2_ns, t3_ns and t4_ns, from the
same zero. NAME.json says how it was recorded, the cycle time, and quantiles of the delays.";

fn duration(text: &str) -> Result<DurationSeconds, String> {
    let number: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    DurationSeconds::new(number).map_err(|wrong| wrong.to_string())
}

fn cycle_micros(text: &str) -> Result<CycleMicros, String> {
    let number: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    CycleMicros::try_from(number).map_err(|wrong| wrong.to_string())
}

impl RecordArrivalsArgs {
    /// Expected time, s; none if nothing is recorded.
    pub fn seconds(&self) -> Option<f64> {
        self.from.is_none().then(|| self.seconds.get())
    }
}

/// Records or converts, and describes the recording.
///
/// # Errors
/// A node that does not start or ends badly, a file that cannot be read or written.
pub fn run(args: &RecordArrivalsArgs, progress: &mut dyn Progress) -> anyhow::Result<String> {
    let files = RecordingFiles::of(&args.out);
    // Before a recording of perhaps hours, which a missing folder would lose at its end.
    make_folder_of(&files.messages)?;
    let (recording, summary) = match &args.from {
        Some(file) => converted(file)?,
        None => recorded(args, progress)?,
    };
    recording.write(&files)?;
    write_json(&files.summary, &summary)?;
    let written = files.messages.display();
    Ok(format!("{}recording: {written}", summary.text()))
}

fn converted(file: &Path) -> anyhow::Result<(ArrivalRecording, RecordingSummary)> {
    let raw = Raw::read(file)?;
    // A warning and no error: the longest run is a whole recording by itself.
    if raw.other_runs > 0 {
        let others = raw.other_runs;
        tracing::warn!("the sender was started anew: {others} shorter runs are left out");
    }
    let scale = TimeScale::fitted(&raw);
    // The drift goes into the file, because it is no longer in the delays.
    let origin = RecordingOrigin::Fitted {
        file: file.display().to_string(),
        drift_ppm: scale.drift_ppm(),
    };
    Ok(summarised(&raw, &scale, origin))
}

fn recorded(
    args: &RecordArrivalsArgs,
    progress: &mut dyn Progress,
) -> anyhow::Result<(ArrivalRecording, RecordingSummary)> {
    let settings = RecordingSettings {
        duration: Span::from_secs_f64(args.seconds.get()),
        cycle_us: args.cycle_us.into(),
        protocol: args.transport,
        busy: args.busy,
        real_time: args.real_time,
    };
    let folder = nodes_folder(&args.out);
    let live::RecordingResult {
        raw,
        scale,
        warnings,
    } = live::record(&settings, &folder, progress)
        .with_context(|| format!("the nodes' files are left in {}", folder.display()))?;
    for warning in warnings {
        tracing::warn!("a node says: {warning}");
    }
    let origin = RecordingOrigin::Processes {
        transport: args.transport.name(),
        busy: args.busy,
        real_time: args.real_time,
    };
    let summarised = summarised(&raw, &scale, origin);
    // Only after a success: on a failure the logs are the explanation.
    std::fs::remove_dir_all(&folder)
        .with_context(|| format!("cannot remove {}", folder.display()))?;
    Ok(summarised)
}

fn summarised(
    raw: &Raw,
    scale: &TimeScale,
    origin: RecordingOrigin,
) -> (ArrivalRecording, RecordingSummary) {
    let recording = convert(raw, scale);
    let summary = RecordingSummary::of(&recording, origin, raw.sent_first().cycle_time_ns);
    (recording, summary)
}

/// Folder of the nodes' configs, logs and traces while they run.
fn nodes_folder(out: &Path) -> PathBuf {
    let mut folder = out.as_os_str().to_owned();
    // Beside the recording and not in a temporary folder: the traces of an hour are large.
    folder.push("-nodes");
    folder.into()
}

fn make_folder_of(file: &Path) -> anyhow::Result<()> {
    let folder = file.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))
}

fn write_json(path: &Path, summary: &RecordingSummary) -> anyhow::Result<()> {
    let mut text = serde_json::to_string_pretty(summary).context("cannot write the summary")?;
    text.push('\n');
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}
