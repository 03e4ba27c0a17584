//! A member whose certificate is revoked while the nodes run, and the record of it.

use std::path::Path;
use std::time::{Duration, SystemTime};

use coaxle_node::audit::AuditRecord;
use coaxle_test_process::{Process, until};
use coaxle_tests::ports::free_port;

use super::processes::{SLAVE, coaxle, output_of, start, write, write_line};

/// Time within which a list is obeyed, two looks of a second each, on a machine that does many other things.
const SOON: Duration = Duration::from_secs(10);

/// A node that logs errors only, and is recorded.
fn start_quiet(folder: &Path, role: &str, name: &str) -> Process {
    let line = format!("{role} {name}.toml --for 600s --quiet --record {name}.mcap");
    let mut command = coaxle(folder, &line);
    // An operator's wish, too, must not silence the audit.
    command.env("RUST_LOG", "off");
    Process::start(name, &mut command, &folder.join(format!("{name}.log")))
}

/// The records that the tool prints, as JSON.
fn records(folder: &Path, from: &str) -> Vec<AuditRecord> {
    let (text, good) = output_of(folder, &format!("audit {from} --json --newest 1024"));
    assert!(good, "{text}");
    let record = |line: &str| AuditRecord::from_json(line.as_bytes()).expect("a record");
    text.lines()
        .filter(|line| line.starts_with('{'))
        .map(record)
        .collect()
}

/// The status of a node.
fn status(folder: &Path, node: &str) -> serde_json::Value {
    let (text, good) = output_of(
        folder,
        &format!("status --secure net/anna {node} --format json"),
    );
    assert!(good, "{text}");
    let json = &text[text.find('[').expect("a list")..];
    // Log lines may follow: the text is of both streams.
    let mut values = serde_json::Deserializer::from_str(json).into_iter::<serde_json::Value>();
    let mut status = values.next().expect("a value").expect("a status");
    status[0].take()
}

/// Frames that the saw has received.
fn received_by_saw(folder: &Path) -> u64 {
    status(folder, "saw")["received"].as_u64().expect("a count")
}

#[test]
fn a_revoked_follower_is_out_within_seconds_and_nobody_else_is_touched() {
    let scratch = tempfile::tempdir().expect("a scratch folder");
    let folder = scratch.path();
    let [line, saw] = [(); 2].map(|()| free_port());
    write_line(folder, line);
    for name in ["mill", "saw"] {
        // Only the saw can be reached by anna.
        let listen = match name {
            "saw" => format!("listen = ['tls/127.0.0.1:{saw}']\n"),
            _ => String::new(),
        };
        write(
            folder,
            name,
            &format!(
                "{SLAVE}[transport]\nsecure = 'net/{name}'\n{listen}connect = ['tls/127.0.0.1:{line}']"
            ),
        );
    }
    let members = "line.toml mill.toml saw.toml --out net --operator anna";
    let (text, good) = output_of(folder, &format!("secure init {members}"));
    assert!(good, "{text}");
    let line_node = start_quiet(folder, "sender", "line");
    let (mill, saw) = (
        start(folder, "receiver", "mill"),
        start(folder, "receiver", "saw"),
    );
    until("both follow the line", || {
        status(folder, "line")["seen_by"] == serde_json::json!(["mill", "saw"])
    });
    let (text, good) = output_of(folder, "command --secure net/anna saw carriage power on");
    assert!(good, "{text}");
    let received = received_by_saw(folder);

    // The folders of the nodes are those that the tool writes: nothing has to be copied here.
    let (text, good) = output_of(
        folder,
        &format!("secure renew {members} --only anna --revoke mill"),
    );
    assert!(
        good && text.contains("certificates of mill are revoked"),
        "{text}"
    );
    let list = folder.join("net/line/revoked.list");
    let written = list.metadata().and_then(|facts| facts.modified());
    let written = written
        .expect("a list")
        .duration_since(SystemTime::UNIX_EPOCH);
    let written_us = written.expect("a time").as_micros() as i64;
    until("the line refuses the mill", || {
        line_node.logged("connection of \"mill\": handshake: refused")
    });
    until("the mill knows why", || {
        mill.logged("the certificate here is revoked")
    });

    let noted = records(folder, "--secure net/anna --node line");
    let of_mill = |what: &str| {
        let is_it = |record: &&AuditRecord| record.entry.to_string().starts_with(what);
        noted.iter().find(is_it).map(|record| record.at_us)
    };
    let revoked = "the certificate of \"mill\" is revoked";
    let ended = of_mill(&format!("connection of \"mill\": link: ended, {revoked}"));
    let ended = ended.unwrap_or_else(|| panic!("{noted:?}")) - written_us;
    println!("the link of the revoked member ended after {ended} us");
    assert!(ended < SOON.as_micros() as i64, "{ended} us");
    let refused = of_mill(&format!(
        "connection of \"mill\": handshake: refused, {revoked}"
    ));
    assert!(refused.is_some(), "{noted:?}");
    // Numbered from the start of the node, without gaps but for those that gave way.
    let numbers: Vec<_> = noted.iter().map(|record| record.number).collect();
    assert!(
        numbers.windows(2).all(|pair| pair[0] + 1 == pair[1]),
        "{numbers:?}"
    );
    // No option drops it: neither `--quiet` nor RUST_LOG.
    assert!(
        line_node.logged("audit 1: run of \"line\": start: accepted"),
        "{}",
        line_node.log()
    );
    assert!(!line_node.logged("health is"), "{}", line_node.log());

    // The saw goes on over its link of before, and anna, whose folder is new, commands it.
    until("the saw receives the line", || {
        received_by_saw(folder) > received + 100
    });
    for trouble in [
        "is not to be seen",
        "health is refused",
        "health is no-data",
        "link closed",
    ] {
        assert!(!saw.logged(trouble), "{trouble}: {}", saw.log());
    }
    let orders = records(folder, "--secure net/anna --node saw");
    let order = "order of \"anna\": MC_Power to \"carriage\": accepted";
    let is_it = |record: &AuditRecord| record.entry.to_string().starts_with(order);
    assert_eq!(
        orders.iter().filter(|record| is_it(record)).count(),
        1,
        "{orders:?}"
    );

    // The recording has the same records, also that of a node that was killed.
    line_node.kill();
    let recorded = records(folder, "line.mcap");
    assert_eq!(recorded.first(), noted.first());
    let ends = |record: &AuditRecord| record.entry.to_string().contains("link: ended");
    assert!(recorded.iter().any(ends), "{recorded:?}");
    let (text, good) = output_of(folder, "audit line.mcap --refused");
    assert!(
        good && text.contains(revoked) && !text.contains("accepted"),
        "{text}"
    );
}
