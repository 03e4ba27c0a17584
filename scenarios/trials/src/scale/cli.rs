//! The command line, its table and its files.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, ensure};
use clap::{Args, ValueEnum};
use coaxle_lab::number::significant;
use coaxle_lab::results_folder::ResultsFolder;
use coaxle_os::exit::Exit;
use coaxle_report::inspect::{print_text, right, table};
use comfy_table::Table;

use super::cost::Cost;
use super::plot;
use super::size::{Size, SizeSeries};

/// Arguments of `coaxle scale`.
#[derive(Debug, Args)]
pub struct ScaleArgs {
    /// Only these series [default: all]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "SERIES")]
    series: Vec<SizeSeries>,
    /// Folder for scale.csv, scale.json and scale.svg
    #[arg(long, value_name = "DIR", default_value = "out/scale")]
    out: PathBuf,
    /// Format of the output
    #[arg(long, value_enum, default_value_t)]
    format: ScaleFormat,
    /// Measure this size alone, in this process, and print it as JSON
    #[arg(long, hide = true, value_name = "SERIES:COUNT")]
    size: Option<Size>,
}

/// Format of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum ScaleFormat {
    /// For people
    #[default]
    Table,
    /// As scale.csv has it
    Csv,
    /// As scale.json has it
    Json,
}

/// Measures every size and leaves table and plot.
///
/// # Errors
/// A size that cannot be measured, a file that cannot be written.
pub fn scale(args: &ScaleArgs) -> anyhow::Result<Exit> {
    if let Some(size) = args.size {
        print_text(&serde_json::to_string(&Cost::of(size)?)?)?;
        return Ok(Exit::Done);
    }
    // Before the measurement: a folder in use is refused now and not after all sizes.
    let folder = ResultsFolder::hold(&args.out)?;
    let all = match args.series.as_slice() {
        [] => SizeSeries::ALL.to_vec(),
        some => some.to_vec(),
    };
    let sizes = all.iter().flat_map(|series| series.sizes());
    let costs: Vec<_> = sizes.map(measured).collect::<Result<_, _>>()?;
    let (csv, json) = (csv(&costs)?, serde_json::to_string_pretty(&costs)?);
    for (name, text) in [("scale.csv", &csv), ("scale.json", &json)] {
        let path = folder.file(name);
        std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    let path = folder.file("scale.svg");
    plot::write(&path, &costs)?;
    match args.format {
        ScaleFormat::Csv => print_text(csv.trim_end())?,
        ScaleFormat::Json => print_text(&json)?,
        ScaleFormat::Table => {
            print_text(&tables(&costs))?;
            print_text(&format!("\nplot: {}", path.display()))?;
        }
    }
    Ok(Exit::Done)
}

/// Measures a size in a process of its own.
fn measured(size: Size) -> anyhow::Result<Cost> {
    let what = format!("{}:{}", size.series.name(), size.count);
    let program = std::env::current_exe().context("cannot find this program")?;
    // In sequence: processes at the same time would slow each other down.
    let output = Command::new(program)
        // The option is hidden: it makes this program the process of a single size.
        .args(["scale", "--size", &what])
        .output()
        .context("cannot start this program")?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{what}: {}", said.trim());
    serde_json::from_slice(&output.stdout).with_context(|| format!("{what} was not measured"))
}

/// A row of scale.csv.
#[derive(serde::Serialize)]
struct ScaleRow {
    series: &'static str,
    count: usize,
    nodes: usize,
    axes: usize,
    senders_us: f64,
    intake_us: f64,
    receivers_us: f64,
    per_axis_us: f64,
    further_axis_us: Option<f64>,
    memory_bytes: Option<u64>,
    further_axis_bytes: Option<f64>,
    published_per_cycle: f64,
    delivered_per_cycle: f64,
}

fn csv(costs: &[Cost]) -> anyhow::Result<String> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    for cost in costs {
        let first = first_of(costs, cost.size.series);
        csv.serialize(ScaleRow {
            series: cost.size.series.name(),
            count: cost.size.count,
            nodes: cost.nodes,
            axes: cost.axes,
            senders_us: cost.senders_us,
            intake_us: cost.intake_us,
            receivers_us: cost.receivers_us,
            per_axis_us: cost.per_axis_us(),
            further_axis_us: first.and_then(|first| cost.further_axis_us(first)),
            memory_bytes: cost.memory_bytes,
            further_axis_bytes: first.and_then(|first| cost.further_axis_bytes(first)),
            published_per_cycle: cost.published_per_cycle,
            delivered_per_cycle: cost.delivered_per_cycle,
        })?;
    }
    Ok(String::from_utf8(csv.into_inner()?)?)
}

/// The smallest size of a series with one axis per node, which has only the fixed costs beside it.
fn first_of(costs: &[Cost], series: SizeSeries) -> Option<&Cost> {
    let mut of = costs.iter().filter(|cost| cost.size.series == series);
    // Only that series has more axes in a node: the others grow by nodes, and have no further axes.
    of.find(|cost| cost.size.count == 1 && series == SizeSeries::Axes)
}

fn tables(costs: &[Cost]) -> String {
    let tables = SizeSeries::ALL.map(|series| {
        let of: Vec<_> = (costs.iter())
            .filter(|cost| cost.size.series == series)
            .collect();
        (!of.is_empty()).then(|| table_of(series, &of).trim_fmt())
    });
    let tables: Vec<_> = tables.into_iter().flatten().collect();
    tables.join("\n\n")
}

fn table_of(series: SizeSeries, costs: &[&Cost]) -> Table {
    let mut table = table([
        series.name(),
        "nodes",
        "senders, µs",
        "intake, µs",
        "receivers, µs",
        "per axis, µs",
        "each further axis, µs",
        "memory, MiB",
        "each further axis, KiB",
        "messages a cycle",
    ]);
    let first = costs
        .first()
        .filter(|first| series == SizeSeries::Axes && first.size.count == 1);
    let digits = |value: Option<f64>| match value {
        Some(value) => right(&significant(value, 3)),
        // Unknown is not 0: the smallest size has no further axis, and not every system reports memory.
        None => right("–"),
    };
    for cost in costs {
        let further = first.and_then(|first| cost.further_axis_us(first));
        let bytes = first.and_then(|first| cost.further_axis_bytes(first));
        table.add_row([
            right(&cost.size.count.to_string()),
            right(&cost.nodes.to_string()),
            digits(Some(cost.senders_us)),
            digits(Some(cost.intake_us)),
            digits(Some(cost.receivers_us)),
            digits(Some(cost.per_axis_us())),
            digits(further),
            digits(
                cost.memory_bytes
                    .map(|bytes| bytes as f64 / f64::from(1 << 20)),
            ),
            digits(bytes.map(|bytes| bytes / 1024.0)),
            digits(Some(cost.delivered_per_cycle)),
        ]);
    }
    table
}
