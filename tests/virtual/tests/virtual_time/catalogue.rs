//! Every scenario that comes with the tool keeps its promises in virtual time, and its figures.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::LazyLock;

use coaxle_lab::catalog::{self, CATALOG};
use coaxle_lab::summary::{ReceiverSummary, RouterSummary, SlaveSummary, Summary};

/// Runs of every scenario, in the order of the catalogue: some take seconds, so they run only once.
static RUNS: LazyLock<Vec<Summary>> = LazyLock::new(|| {
    let run = |(name, _): &(&str, &str)| crate::common::run(name, &[]);
    CATALOG.iter().map(run).collect()
});

#[test]
fn every_scenario_meets_its_expectations() {
    let mut failures = Vec::new();
    for summary in RUNS.iter() {
        let name = &summary.scenario;
        // A scenario without expectations would pass whatever its run does.
        assert!(!summary.expectations.is_empty(), "{name} expects nothing");
        failures.extend(summary.failed().map(|verdict| format!("{name}: {verdict}")));
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Scenarios that raise errors, warnings or events, with the reasons.
const RAISES: &[(&str, &str)] = &[
    ("drift-change", "a drift that changes by more than half"),
    ("sender-restart", "a sender restarts"),
    ("twin-sender", "a second sender of the same name"),
    ("line-shaft", "the belt's node restarts"),
    ("delay-step", "the delay steps, twice"),
    ("delay-step-large", "likewise, by more"),
    ("sender-stop-resume", "a sender is stopped for a while"),
    ("hot-standby", "lines fall silent, standbys take over"),
    ("saw-recovery", "a sender is frozen for a second"),
    ("rollback-8", "a drive cannot stop within a cycle"),
    ("plant", "two routers fail"),
    ("coupled-stop", "a slave runs into its software limit"),
    (
        "planned-partition",
        "a receiver without a plan loses its master",
    ),
];

#[test]
fn a_clean_run_raises_nothing() {
    let mut wrong = Vec::new();
    for summary in RUNS.iter() {
        let scenario = &summary.scenario;
        let raised: Vec<_> = (summary.receivers.iter())
            .flat_map(|(name, receiver)| raised(name, receiver))
            .collect();
        let is_meant = RAISES.iter().any(|(name, _)| name == scenario);
        match (raised.is_empty(), is_meant) {
            (false, false) => wrong.push(format!("{scenario}: {}", raised.join(", "))),
            // Otherwise an exception would hide a later fault of a scenario that no longer needs it.
            (true, true) => wrong.push(format!("{scenario} raises nothing: it is no exception")),
            _ => {}
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Faults that a receiver reported, once it was up.
fn raised(name: &str, receiver: &ReceiverSummary) -> Vec<String> {
    let far = &receiver.last.far;
    // Shifts and relocks of the first lock-in belong to it, and are no events of the run.
    let up = receiver.evaluated_from_s.unwrap_or(f64::INFINITY);
    let after_start = |times: &[f64]| times.iter().filter(|at| **at > up).count() as u64;
    let of_slaves = receiver.slaves.values().map(|slave| slave.errors).sum();
    let counts = [
        ("errors", receiver.errors),
        ("warnings", receiver.warnings),
        ("errors of slaves", of_slaves),
        ("shifts", after_start(&receiver.shift_times_s)),
        ("relocks", after_start(&receiver.relock_times_s)),
        // Totals of the whole run: no start-up excuses any of these.
        ("restarts", far.restarts),
        ("take-overs", far.take_overs),
        ("foreign frames", far.foreign_frames),
        ("rejected frames", far.rejected),
    ];
    let raised = counts.iter().filter(|(_, count)| *count > 0);
    raised
        .map(|(what, count)| format!("{name} {count} {what}"))
        .collect()
}

/// Figures that a change of the structure must not affect. After an intended change, review the table and
/// accept it.
#[test]
fn the_figures_of_every_scenario() {
    insta::assert_snapshot!(figures(|receiver| receiver.mode != "observer"));
}

/// Figures of the phase observer, kept apart as work on it changes them.
#[test]
fn the_figures_of_every_observer() {
    insta::assert_snapshot!(figures(|receiver| receiver.mode == "observer"));
}

/// Traffic that routers forwarded.
#[test]
fn the_figures_of_every_router() {
    let mut lines = BTreeMap::new();
    for summary in RUNS.iter() {
        let scenario = &summary.scenario;
        let routers = summary.routers.iter();
        lines.extend(
            routers.map(|(name, router)| (format!("{scenario}/{name}"), of_router(router))),
        );
    }
    insta::assert_snapshot!(table(&lines));
}

/// Most receivers of a scenario that have a line each: none but one of very many has more far axes.
const MOST_LINES: usize = 60;

/// Two tables with a line per receiver and one per slave.
fn figures(is_wanted: impl Fn(&ReceiverSummary) -> bool) -> String {
    let (mut receivers, mut slaves) = (BTreeMap::new(), BTreeMap::new());
    for summary in RUNS.iter() {
        let scenario = &summary.scenario;
        // A selection of very many similar ones.
        let every = summary.receivers.len().div_ceil(MOST_LINES);
        let wanted = summary.receivers.iter().step_by(every.max(1));
        for (name, receiver) in wanted.filter(|(_, receiver)| is_wanted(receiver)) {
            receivers.insert(format!("{scenario}/{name}"), of_receiver(receiver));
            for (slave, figures) in &receiver.slaves {
                slaves.insert(format!("{scenario}/{name}/{slave}"), of_slave(figures));
            }
        }
    }
    table(&receivers) + "\n" + &table(&slaves)
}

/// A figure's name, and the figure.
type Cell = (&'static str, String);

fn table<const N: usize>(lines: &BTreeMap<String, [Cell; N]>) -> String {
    let Some(any) = lines.values().next() else {
        return String::new();
    };
    let header = any.each_ref().map(|(name, _)| (*name).to_owned());
    let rows = lines.iter().map(|(name, line)| {
        let figures = line.each_ref().map(|(_, figure)| figure.clone());
        (name.as_str(), figures)
    });
    let rows: Vec<_> = std::iter::once(("", header)).chain(rows).collect();
    let widest = |column: usize| {
        let cells = rows.iter().map(|(_, cells)| cells[column].chars().count());
        cells.max().unwrap_or(0)
    };
    let widths: [usize; N] = std::array::from_fn(widest);
    let longest = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for (name, cells) in &rows {
        let _ = write!(text, "{name:longest$}");
        for (cell, width) in cells.iter().zip(widths) {
            let _ = write!(text, "  {cell:>width$}");
        }
        text.push('\n');
    }
    text
}

fn of_receiver(r: &ReceiverSummary) -> [Cell; 15] {
    [
        ("mode", r.mode.to_owned()),
        ("received", r.last.far.received.to_string()),
        ("lost", r.last.far.lost.to_string()),
        ("errors", r.errors.to_string()),
        ("error", text(r.last_error.as_ref())),
        ("sync s", digits(r.time_to_sync_s)),
        (
            "synced",
            format!("{}{}", r.synced_times, mark(r.synced_at_end)),
        ),
        ("beats", r.last.far.beats.to_string()),
        ("drift ppm", digits(r.last.far.drift_ppm)),
        ("ripple", digits(r.velocity_ripple_ratio)),
        ("rms µs", digits(r.corrected_time_error_rms_us)),
        ("max µs", digits(r.corrected_time_error_max_us)),
        ("lag µs", digits(r.lag_us)),
        ("lagmax µs", digits(r.lag_error_max_us)),
        ("delay µs", digits(r.last.far.delay_us)),
    ]
}

fn of_router(r: &RouterSummary) -> [Cell; 7] {
    let to_middle = r.links.values().map(|link| link.messages_per_s).sum();
    [
        ("in 1/s", digits(Some(r.received_per_s))),
        ("in B/s", digits(Some(r.received_bytes_per_s))),
        ("nodes 1/s", digits(Some(r.to_nodes_per_s))),
        ("nodes B/s", digits(Some(r.to_nodes_bytes_per_s))),
        ("routers 1/s", digits(Some(to_middle))),
        ("routers B/s", digits(Some(r.to_routers_bytes_per_s))),
        ("dropped", r.dropped.to_string()),
    ]
}

fn of_slave(s: &SlaveSummary) -> [Cell; 16] {
    let (coupling, cuts) = (&s.coupling, &s.cuts);
    [
        ("state", s.last.state.name().to_owned()),
        ("errors", s.errors.to_string()),
        ("error", text(s.last_error.as_ref())),
        ("refusal", text(s.last_refusal.as_ref())),
        ("step", text(s.last.program_step.as_ref())),
        ("in sync", digits(Some(s.in_sync_share))),
        ("position", digits(s.last.position)),
        ("jump", digits(Some(s.position_jump_max))),
        ("velocity", digits(Some(s.velocity_max))),
        ("acc", digits(Some(s.acceleration_max))),
        ("following", digits(Some(s.following_error_max))),
        ("syncs", coupling.synchronisations.to_string()),
        ("sync s", digits(coupling.sync_duration_s)),
        ("sync way", digits(coupling.sync_slave_way)),
        ("cuts", cuts.cuts.to_string()),
        (
            "cutmax µm",
            digits(cuts.cut_position_error_max.map(|mm| 1e3 * mm)),
        ),
    ]
}

/// Three significant digits.
fn digits(figure: Option<f64>) -> String {
    match figure {
        None => "-".to_owned(),
        // Rounding errors around zero.
        Some(figure) if figure.abs() < 1e-9 => "0".to_owned(),
        Some(figure) => {
            let rounded: f64 = format!("{figure:.2e}").parse().expect("a number");
            match figure.abs() {
                // Longer numbers would widen the column of every scenario.
                1e-3..1e6 => rounded.to_string(),
                _ => format!("{rounded:e}"),
            }
        }
    }
}

fn text<T: ToString>(value: Option<&T>) -> String {
    value.map_or_else(|| "-".to_owned(), T::to_string)
}

/// Mark of a receiver that was not in sync at the end.
const fn mark(synced: bool) -> &'static str {
    if synced { "" } else { ", lost" }
}

/// Columns of a trace: third-party tools read it.
#[test]
fn the_columns_of_a_trace() {
    let source = coaxle_lab::catalog::find("rotary-knife").expect("a scenario of the catalogue");
    let out = tempfile::tempdir().expect("a scratch folder");
    let sets = ["duration-s=0.1", "expect=[]"];
    crate::common::run_into(&source, &sets, Some(1), out.path());
    let trace = std::fs::read_to_string(out.path().join("trace.csv")).expect("a trace");
    let header = trace.lines().next().expect("a header");
    insta::assert_snapshot!(header.replace(',', "\n"));
}

#[test]
fn the_shipped_files_and_the_catalogue_are_the_same() {
    let mut files = [files_of(""), files_of("faults/")].concat();
    files.sort();
    let mut names: Vec<String> = catalog::all().map(|(name, _)| name.to_owned()).collect();
    names.sort();
    assert_eq!(files, names);
}

/// Names of the scenarios in a folder of the catalogue.
fn files_of(folder: &str) -> Vec<String> {
    let catalogue = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/catalog/");
    std::fs::read_dir(format!("{catalogue}{folder}"))
        .expect("the catalogue's folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .filter_map(|path| Some(format!("{folder}{}", path.file_stem()?.to_str()?)))
        .collect()
}
