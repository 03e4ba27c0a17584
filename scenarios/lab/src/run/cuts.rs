//! `cuts.csv`: every cut of every slave.

use std::path::Path;

use anyhow::Context;
use serde::Serialize;

use crate::summary::{Cut, Summary};

/// A line.
#[derive(Serialize)]
struct CutLine<'a> {
    receiver: &'a str,
    slave: &'a str,
    number: u64,
    t_s: f64,
    position: Option<f64>,
    mark: Option<u64>,
    position_error: Option<f64>,
    length_error: Option<f64>,
}

/// Writes the file, if any slave cut.
pub(super) fn write(path: &Path, summary: &Summary) -> anyhow::Result<()> {
    let lines: Vec<_> = lines(summary).collect();
    // A file of a header alone would look like cuts that were lost.
    if lines.is_empty() {
        return Ok(());
    }
    let written = || -> csv::Result<()> {
        let mut csv = csv::Writer::from_path(path)?;
        for line in &lines {
            csv.serialize(line)?;
        }
        Ok(csv.flush()?)
    };
    written().with_context(|| format!("cannot write {}", path.display()))
}

fn lines(summary: &Summary) -> impl Iterator<Item = CutLine<'_>> {
    summary.receivers.iter().flat_map(|(receiver, figures)| {
        figures.slaves.iter().flat_map(move |(slave, figures)| {
            let cuts = figures.cuts.cut_list.iter();
            cuts.map(move |cut| line(receiver, slave, cut))
        })
    })
}

fn line<'a>(receiver: &'a str, slave: &'a str, cut: &Cut) -> CutLine<'a> {
    let Cut {
        number,
        t_s,
        position,
        mark,
        position_error,
        length_error,
    } = *cut;
    CutLine {
        receiver,
        slave,
        number,
        t_s,
        position,
        mark,
        position_error,
        length_error,
    }
}
