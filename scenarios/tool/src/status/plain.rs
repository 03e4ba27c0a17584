//! The status for people: each far clock and its accuracy, the counts of its messages, and the state of each slave.

use coaxle_clock::Instant;
use coaxle_host::client::SeenNode;
use coaxle_os::Machine;
use coaxle_report::inspect::{right, shown, table};
use comfy_table::{Cell, Table};

use super::reading::StatusFields;
use super::words::{UNKNOWN, beat_period, drift, micros, or_unknown, seconds};

/// Standard deviations of the line that the error of far time may reach, where no larger uncertainty of the delay is known.
// 99.7 % of a normal distribution.
pub(crate) const COVERED: f64 = 3.0;
/// A status that is older than this was the last one, s.
// Eight statuses of 250 ms have failed to come.
const OLD: f64 = 2.0;

/// Every node, one after the other.
pub(super) fn all(seen: &[SeenNode], now: Instant<Machine>) -> String {
    let one = |node: &SeenNode| match &node.status {
        Some((at, status)) => of(&StatusFields::of(status), (now - *at).as_secs_f64()),
        None => format!("{}: there, and has said nothing yet", node.name),
    };
    seen.iter().map(one).collect::<Vec<_>>().join("\n\n")
}

/// Text of a node with a status of this age, s.
fn of(status: &StatusFields<'_>, age: f64) -> String {
    let mut parts = vec![head(status, age)];
    if let Some(lab) = status.text("lab") {
        parts.push(format!(
            "started with --lab, for an experiment and no machine: {lab}"
        ));
    }
    if let Some(error) = status.fault("error") {
        parts.push(format!("error {error}"));
    }
    if let Some(fault) = status.part("last_fault") {
        let age = or_unknown(fault.number("age_s"), seconds);
        let text = fault.text("text").unwrap_or(UNKNOWN);
        parts.push(format!("last fault, {age} ago: {text}"));
    }
    let tables = [
        clocks(status),
        messages(status),
        far_axes(status),
        own_axes(status),
        slaves(status),
    ];
    parts.extend(tables.into_iter().flatten().map(|table| table.to_string()));
    parts.join("\n")
}

fn head(status: &StatusFields<'_>, age: f64) -> String {
    let text = |name| status.text(name).unwrap_or(UNKNOWN);
    let mut head = format!(
        "{}: {}, {}; up {}, run {}, {} cycles of {}, {} skipped",
        text("node"),
        text("role"),
        text("health"),
        or_unknown(status.number("uptime_s"), seconds),
        text("epoch"),
        status.count("cycles"),
        or_unknown(status.number("cycle_time_us"), micros),
        status.count("overruns"),
    );
    let hearers = status.names("seen_by");
    if !hearers.is_empty() {
        head += &format!("; heard by {hearers}");
    }
    if age > OLD {
        head += &format!("; said {} ago", seconds(age));
    }
    head
}

/// The clock of each far node, and its accuracy.
fn clocks(status: &StatusFields<'_>) -> Option<Table> {
    let mut table = table([
        "far node",
        "state",
        "its clock",
        "a beat every",
        "correction",
        "error rms",
        "at most",
        "delay",
        "data age",
    ]);
    let sources = status.part("sources");
    for (name, far) in status.parts("far") {
        let drift_ppm = far.number("drift_ppm");
        let beat = drift_ppm.zip(far.number("cycle_time_us"));
        let beat = beat.and_then(|(ppm, cycle)| beat_period(cycle, ppm));
        let source = sources.as_ref().and_then(|sources| sources.part(name));
        let age = source.and_then(|source| source.number("frame_age_ms"));
        let sigma = far.number("drift_sigma_ppm");
        table.add_row([
            Cell::new(name),
            Cell::new(state(&far)),
            right(&or_unknown(drift_ppm, |ppm| drift(ppm, sigma))),
            right(&or_unknown(beat, seconds)),
            right(&or_unknown(far.number("correction_us"), micros)),
            right(&or_unknown(far.number("offset_sigma_us"), micros)),
            right(&error_bound(&far)),
            right(&delay(&far)),
            right(&or_unknown(age, |ms| micros(ms * 1e3))),
        ]);
    }
    filled(table)
}

/// Largest error of far time, as far as the node knows, µs.
pub(super) fn largest_error(far: &StatusFields<'_>) -> Option<f64> {
    let sigma = far.number("offset_sigma_us")?;
    let known = match far.number("delay_uncertainty_us") {
        Some(uncertainty) => uncertainty.max(COVERED * sigma),
        None => COVERED * sigma,
    };
    // Far time is off by what is left of a correction that is spread over time.
    let slew = far.number("slew_remaining_us").unwrap_or_default();
    Some(known + slew.abs())
}

/// Largest error of far time in words, and the configured offset beside it.
pub(super) fn error_bound(far: &StatusFields<'_>) -> String {
    let error = or_unknown(largest_error(far), micros);
    match far.number("time_offset_us") {
        // Wanted, and so no error: the axes are as far ahead of the master, or behind it.
        Some(offset) if offset != 0.0 => {
            let way = if offset > 0.0 { "ahead" } else { "behind" };
            format!("{error} beside {} {way}", micros(offset.abs()))
        }
        _ => error,
    }
}

/// `observer, synced`, and whether another node is followed for it.
pub(super) fn state(far: &StatusFields<'_>) -> String {
    let mut words = Vec::new();
    match far.text("health") {
        Some("ok") | None => {}
        Some(health) => words.push(health),
    }
    if let Some(of) = far.text("standby_of") {
        words.push(match far.is("followed") {
            true => "followed for",
            false => "stands by for",
        });
        words.push(of);
    }
    words.push(far.text("mode").unwrap_or(UNKNOWN));
    words.push(match far.text("observer_state") {
        Some(state) => state,
        // Modes without an observer have no state of it.
        None if far.is("synced") => "synced",
        None => "not synced",
    });
    // The name behind "for" is a word of its own in the list.
    words.join(", ").replace(" for,", " for")
}

fn delay(far: &StatusFields<'_>) -> String {
    let delay = or_unknown(far.number("delay_us"), micros);
    let state = match far.text("delay_state") {
        None | Some("measured") => String::new(),
        Some(state) => format!(", {state}"),
    };
    match far.number("delay_uncertainty_us") {
        Some(uncertainty) => format!("{delay} ± {}{state}", micros(uncertainty)),
        None => format!("{delay}{state}"),
    }
}

/// Counts of the messages of each far node.
fn messages(status: &StatusFields<'_>) -> Option<Table> {
    let mut table = table([
        "messages of",
        "run",
        "received",
        "lost",
        "duplicate",
        "late",
        "too old",
        "foreign",
        "refused",
        "jitter",
        "beats",
    ]);
    for (name, far) in status.parts("far") {
        let count = |name| right(&far.count(name).to_string());
        let run = match far.number("epoch") {
            // In hexadecimal, as the status of that node and its keys have it.
            Some(_) => format!("{:016x}", far.count("epoch")),
            None => UNKNOWN.to_owned(),
        };
        table.add_row([
            Cell::new(name),
            Cell::new(run),
            count("received"),
            count("lost"),
            count("duplicates"),
            count("late"),
            count("stale"),
            count("foreign_frames"),
            right(&refused(&far)),
            right(&jitter(&far)),
            count("beats"),
        ]);
    }
    filled(table)
}

/// `3 (1 malformed, 2 wrong checksum)`
fn refused(far: &StatusFields<'_>) -> String {
    let reason = |(name, _): (&str, _)| {
        let reason = name.strip_prefix("rejected_")?;
        let count = far.count(name);
        // Any field of that prefix, so that a new reason of a newer node shows as well.
        (count > 0).then(|| format!("{count} {}", reason.replace('_', " ")))
    };
    let reasons: Vec<_> = far.fields().filter_map(reason).collect();
    let all = far.count("rejected");
    match reasons.as_slice() {
        [] => all.to_string(),
        reasons => format!("{all} ({})", reasons.join(", ")),
    }
}

fn jitter(far: &StatusFields<'_>) -> String {
    let parts = (far.number("normal_jitter_us")).zip(far.number("exponential_jitter_us"));
    // Standard deviations of independent parts add up as squares.
    or_unknown(parts.map(|(normal, late)| normal.hypot(late)), micros)
}

/// Far axes as received, and as corrected.
fn far_axes(status: &StatusFields<'_>) -> Option<Table> {
    let mut table = table(["far axis", "of", "state", "received", "corrected", "unit"]);
    for (name, axis) in status.parts("axes") {
        // A sender's own axes are under the same name, without a node.
        if axis.text("node").is_none() {
            continue;
        }
        let state = match (axis.fault("error"), axis.is("synced")) {
            (Some(error), _) => error,
            (None, true) => "synced".to_owned(),
            (None, false) => axis.text("state").unwrap_or("not synced").to_owned(),
        };
        table.add_row([
            Cell::new(name),
            Cell::new(axis.text("node").unwrap_or_default()),
            Cell::new(state),
            right(&or_unknown(axis.number("received_position"), shown)),
            right(&or_unknown(axis.number("corrected_position"), shown)),
            Cell::new(axis.text("unit").unwrap_or_default()),
        ]);
    }
    filled(table)
}

/// Axes that the node makes itself: a sender's, and virtual ones.
fn own_axes(status: &StatusFields<'_>) -> Option<Table> {
    let mut table = table(["axis", "position", "velocity", "unit", "error"]);
    let own = status.parts("axes").chain(status.parts("virtual_axes"));
    for (name, axis) in own.filter(|(_, axis)| axis.text("node").is_none()) {
        table.add_row([
            Cell::new(name),
            right(&or_unknown(axis.number("position"), shown)),
            right(&or_unknown(axis.number("velocity"), shown)),
            Cell::new(axis.text("unit").unwrap_or_default()),
            Cell::new(axis.fault("error").unwrap_or_default()),
        ]);
    }
    filled(table)
}

/// States of the slaves, and the conditions that their programs wait for.
fn slaves(status: &StatusFields<'_>) -> Option<Table> {
    let mut table = table([
        "slave",
        "state",
        "coupling",
        "position",
        "to the master",
        "unit",
        "program",
        "waits for",
        "fault",
    ]);
    for (name, slave) in status.parts("slaves") {
        let position = slave.number("position");
        let apart = position.zip(slave.number("master_position"));
        // The gravest one first: an error stops the slave, a refusal leaves it as it is.
        let fault = (slave.fault("error"))
            .or_else(|| slave.fault("program_error"))
            .or_else(|| slave.fault("refusal"));
        table.add_row([
            Cell::new(name),
            Cell::new(slave.text("state").unwrap_or(UNKNOWN)),
            Cell::new(slave.text("phase").unwrap_or(UNKNOWN)),
            right(&or_unknown(position, shown)),
            // Positive where the slave lags behind a master that runs forwards.
            right(&or_unknown(apart.map(|(own, master)| master - own), shown)),
            Cell::new(slave.text("unit").unwrap_or_default()),
            Cell::new(program(&slave)),
            Cell::new(slave.text("program_waits_for").unwrap_or(UNKNOWN)),
            Cell::new(fault.unwrap_or_default()),
        ]);
    }
    filled(table)
}

/// `waits, step 3 "cut"`
fn program(slave: &StatusFields<'_>) -> String {
    let Some(state) = slave.text("program") else {
        return UNKNOWN.to_owned();
    };
    let step = slave
        .number("program_step")
        .map(|step| format!(", step {step}"));
    let label = slave.text("label").map(|label| format!(" {label:?}"));
    format!(
        "{state}{}{}",
        step.unwrap_or_default(),
        label.unwrap_or_default()
    )
}

fn filled(table: Table) -> Option<Table> {
    (table.row_count() > 0).then_some(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status::samples::{RECEIVER, SENDER, object};

    fn lines(json: &str, age: f64) -> Vec<String> {
        let status = object(json);
        let text = of(&StatusFields::of(&status), age);
        let squeezed = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        text.lines().map(squeezed).collect()
    }

    #[test]
    fn a_receiver_tells_of_clocks_messages_axes_and_slaves() {
        let lines = lines(RECEIVER, 0.1);
        for expected in [
            "saw: receiver, error; up 25.0 s, run 0d5c1f6a90b3e427, 24995 cycles of 1.00 ms, 1 skipped",
            "error 0x4B52: no data",
            "last fault, 3.0 s ago: 1 frame lost",
            "conveyor observer, synced 500.10 ± 0.20 ppm fast 2.0 s -212.5 µs 0.1 µs 106.6 µs \
             131.2 µs ± 104.6 µs 410.0 µs",
            "conveyor 000000000000000b 25010 3 0 2 0 0 3 (1 malformed, 2 wrong checksum) 5.0 µs 4",
            "conveyor.3 conveyor synced 12598 12597.89375 mm",
            "slave synchronized-motion in-sync 12597.5 0.5 mm waiting, step 2 \"cut\" master-position",
        ] {
            assert!(
                lines.iter().any(|line| line == expected),
                "{expected}\n{lines:#?}"
            );
        }
    }

    #[test]
    fn a_node_of_an_experiment_says_so() {
        let json = SENDER.replace(
            "\"seen_by\"",
            "\"lab\": \"lab.clock.drift-ppm = 500\", \"seen_by\"",
        );
        let expected =
            "started with --lab, for an experiment and no machine: lab.clock.drift-ppm = 500";
        assert_eq!(lines(&json, 0.1)[1], expected);
    }

    #[test]
    fn a_sender_tells_who_hears_it_and_of_its_axes() {
        let lines = lines(SENDER, 12.0);
        assert!(
            lines[0].ends_with("; heard by saw; said 12.0 s ago"),
            "{lines:#?}"
        );
        assert!(
            lines.iter().any(|line| line == "conveyor 12478.5 500 mm"),
            "{lines:#?}"
        );
    }

    #[test]
    fn a_status_that_says_nothing_is_shown_as_that() {
        let lines = lines(
            r#"{ "node": "x", "far": { "y": {} }, "slaves": { "z": {} } }"#,
            0.0,
        );
        assert!(lines[0].starts_with("x: –, –; up –"), "{lines:#?}");
        assert!(
            lines
                .iter()
                .any(|line| line == "y –, not synced – – – – – – –"),
            "{lines:#?}"
        );
    }
}
