//! The figures for people.

use coaxle_lab::number::significant;
use coaxle_report::inspect::{right, table};
use comfy_table::Table;

use super::end_to_end::EndToEnd;
use super::load::{ProcessorLoad, Sides};
use super::quantiles::{MedianRatio, TimeQuantiles};
use super::transports::{TransportResult, Transports};
use super::wake_up::WakeUp;

pub(super) fn wake_up(found: &WakeUp) -> String {
    let mut rows = times("wake-up late by, µs");
    add(&mut rows, "cycle thread of a node", found.node);
    add(&mut rows, "bare clock_nanosleep loop", found.bare);
    if found.cyclictest.is_some() {
        add(&mut rows, "cyclictest", found.cyclictest);
    }
    let mut text = denied(&found.denied) + &rows.trim_fmt();
    // Said, as a missing row could also be a measurement that failed.
    if found.cyclictest.is_none() {
        text += "\ncyclictest: not installed";
    }
    text + &ratio("node / bare loop", found.node_over_bare)
}

pub(super) fn end_to_end(found: &EndToEnd) -> String {
    let head = format!(
        "one way over loopback, {} {}, {} bytes, µs",
        found.axes,
        if found.axes == 1 { "axis" } else { "axes" },
        found.bytes
    );
    let mut rows = times(&head);
    add(&mut rows, "datagram, wake-up to arrival", found.udp);
    add(&mut rows, "Zenoh alone, wake-up to arrival", found.zenoh);
    add(&mut rows, "our nodes, wake-up to arrival", found.nodes);
    add(
        &mut rows,
        "Zenoh alone, put to arrival",
        found.zenoh_network,
    );
    add(
        &mut rows,
        "our nodes, publish to arrival",
        found.stages.network,
    );
    let stages = &found.stages;
    let mut path = times("the path between our nodes, µs");
    add(&mut path, "the cycle wakes late by", stages.wake_up);
    add(&mut path, "scan, to the frame in the outbox", stages.scan);
    add(&mut path, "hand-over, to the publisher", stages.hand_over);
    add(&mut path, "publish, Zenoh, to the stamp", stages.network);
    add(&mut path, "wait, to the scan that uses it", stages.wait);
    add(&mut path, "all, from wake-up to that scan", stages.to_scan);
    let ratios = &found.ratios;
    [
        denied(&found.denied) + &rows.trim_fmt(),
        ratio("our nodes / Zenoh alone, wake-up to arrival", ratios.nodes),
        ratio(
            "our nodes / Zenoh alone, publish to arrival",
            ratios.network,
        ),
        ratio("datagram / Zenoh alone, wake-up to arrival", ratios.udp),
        format!("\n\n{}", path.trim_fmt()),
    ]
    .concat()
}

pub(super) fn load(found: &ProcessorLoad) -> String {
    let head = format!(
        "load, {} axes in a frame of {} bytes",
        found.axes, found.bytes
    );
    let mut rows = table([head.as_str(), "sender", "receiver"]);
    for (name, sides) in [("our nodes", found.nodes), ("Zenoh alone", found.zenoh)] {
        let shares = match sides {
            Some(Sides { sender, receiver }) => [percent(sender), percent(receiver)],
            None => ["not known".to_owned(), "not known".to_owned()],
        };
        rows.add_row([name, &shares[0], &shares[1]].map(right));
    }
    let ratios = found
        .nodes
        .zip(found.zenoh)
        .map_or(String::new(), |(ours, bare)| {
            let over = |ours: f64, bare: f64| significant(ours / bare, 3);
            format!(
                "\nour nodes / Zenoh alone: sender {}, receiver {}",
                over(ours.sender, bare.sender),
                over(ours.receiver, bare.receiver)
            )
        });
    format!(
        "{}\nfollowed, and synchronised at the end: {} of {} axes{ratios}",
        rows.trim_fmt(),
        found.followed,
        found.axes
    )
}

pub(super) fn transports(found: &Transports) -> String {
    let head = format!("age of the newest message, {} bytes, µs", found.bytes);
    let mut rows = table([head.as_str(), "loss", "p50", "p99", "max", "came"]);
    for row in &found.rows {
        rows.add_row(cells(row).iter().map(|cell| right(cell)));
    }
    let mut lines = vec![rows.trim_fmt()];
    let failed = found
        .rows
        .iter()
        .filter_map(|row| Some((row, row.failed.as_ref()?)));
    lines.extend(failed.map(|(row, why)| {
        let loss = 100.0 * row.loss;
        format!("{} with {loss} % loss: {why}", row.transport)
    }));
    // Only without a namespace; then every row has a loss of 0.
    let missing = found.without_loss.iter();
    lines.extend(missing.map(|missing| format!("measured without loss only: {missing}")));
    lines.push(
        "not built, so not measured: QUIC datagrams (a feature of Zenoh), shared memory (unstable in Zenoh)".to_owned(),
    );
    lines.join("\n")
}

fn cells(row: &TransportResult) -> [String; 6] {
    let us = |of: fn(&TimeQuantiles) -> f64| {
        row.age
            .as_ref()
            .map_or("none".to_owned(), |age| format!("{:.1}", of(age)))
    };
    [
        row.transport.to_owned(),
        percent(row.loss),
        us(|age| age.p50_us),
        us(|age| age.p99_us),
        us(|age| age.max_us),
        row.came
            .map_or("none".to_owned(), |share| format!("{:.2} %", 100.0 * share)),
    ]
}

/// Percentage of one processor, or of all packets.
fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn times(what: &str) -> Table {
    table([what, "p50", "p99", "max", "of"])
}

fn add(rows: &mut Table, name: &str, found: Option<TimeQuantiles>) {
    let cells = match found {
        Some(q) => [q.p50_us, q.p99_us, q.max_us]
            .map(|us| format!("{us:.1}"))
            .into_iter()
            .chain([q.count.to_string()])
            .collect(),
        // A way without any message keeps its row: a lost connection must not look like a part left out.
        None => vec!["none came".to_owned(); 4],
    };
    let cells = std::iter::once(name).chain(cells.iter().map(String::as_str));
    rows.add_row(cells.map(right));
}

fn ratio(name: &str, found: Option<MedianRatio>) -> String {
    found.map_or(String::new(), |MedianRatio { p50, least, most }| {
        format!("\n{name}: {p50:.3} (rounds: {least:.3} to {most:.3})")
    })
}

fn denied(wishes: &[String]) -> String {
    wishes
        .iter()
        .map(|denied| format!("note: {denied}\n"))
        .collect()
}
