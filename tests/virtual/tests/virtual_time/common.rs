//! Running scenarios in virtual time, for all tests.

use std::path::Path;

use coaxle_lab::catalog::{self, Source};
use coaxle_lab::run::{self, Options, TraceFormat};
use coaxle_lab::stage::VirtualTime;
use coaxle_lab::summary::{ReceiverSummary, Summary};
use coaxle_report::reported::{self, Presentation};

/// A scenario of the catalogue with some fields set.
pub(crate) fn run(name: &str, overrides: &[&str]) -> Summary {
    let source = catalog::find(name).expect("a scenario of the catalogue");
    run_source(&source, overrides)
}

/// A scenario with some fields set.
pub(crate) fn run_source(source: &Source, overrides: &[&str]) -> Summary {
    let out = tempfile::tempdir().expect("a scratch folder");
    run_into(source, overrides, None, out.path())
}

/// A scenario of the catalogue with only some of its receivers, and every file of the run in `out`.
pub(crate) fn trace_into(name: &str, overrides: &[&str], receivers: &[&str], out: &Path) {
    let source = catalog::find(name).expect("a scenario of the catalogue");
    let options = Options {
        receivers: receivers.iter().map(|&name| name.to_owned()).collect(),
        trace: Some(TraceFormat::Csv),
        ..options(overrides, None, out)
    };
    let _ = run_with(&source, &options);
}

/// Runs a scenario, with the files left in `out`.
pub(crate) fn run_into(
    source: &Source,
    overrides: &[&str],
    seed: Option<u64>,
    out: &Path,
) -> Summary {
    run_with(source, &options(overrides, seed, out))
}

fn options(overrides: &[&str], seed: Option<u64>, out: &Path) -> Options {
    Options {
        seed,
        overrides: overrides.iter().map(|&set| set.to_owned()).collect(),
        receivers: Vec::new(),
        out: out.to_owned(),
        // Tests that read the files choose a seed, and only these need a trace.
        trace: seed.map(|_| TraceFormat::Csv),
    }
}

fn run_with(source: &Source, options: &Options) -> Summary {
    let scenario = run::prepare(source, options).expect("the scenario is right");
    reported::run(
        &source.name,
        &scenario,
        options,
        &Presentation::default(),
        &VirtualTime,
        &mut (),
    )
    .expect("the scenario runs")
    .summary
}

/// Figures of one receiver.
pub(crate) fn figures<'a>(summary: &'a Summary, receiver: &str) -> &'a ReceiverSummary {
    &summary.receivers[receiver]
}
