//! Files and messages of the longest permitted length, and longer ones.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write as _};

use coaxle_cam::MOST_POINTS_REPLACED_IN_USE;
use coaxle_clock::Span;
use coaxle_host::network::credentials::{TIMING_KEYS_FILE, timing_keys};
use coaxle_node::CommandOrder;
use coaxle_node::audit::{
    AuditDoor, AuditEntry, AuditExcerpt, AuditOutcome, AuditQuery, AuditTime, AuditTrail,
};
use coaxle_node::circles::CircleWatch;
use coaxle_node::command::{
    MAX_ORDER_BYTES, MAX_PLATE_ORDER_BYTES, MAX_POINTS_READ, MAX_VALUES_READ,
};
use coaxle_node::keys::NodeName;
use serde_json::json;

use crate::page::ProbedRow;
use crate::{AXIS, Bench, run, shown};

const MIB: u64 = 1 << 20;

pub(crate) const ROWS: &[ProbedRow] = &[
    (
        "config of a node, scenario, saw file, Zenoh config",
        "1 MiB",
        configs,
    ),
    ("cam file", "4 MiB", cam_files),
    (
        "CSV file of a cam table or of a cam's points, or of a term of a drift or delay",
        "64 MiB, 1 000 000 rows, 4096 bytes in a line",
        tables,
    ),
    (
        "recorded motion of an axis (`replay`)",
        "128 MiB, 4 000 000 rows, 4096 bytes in a line; numbers from −1e100 to 1e100, rows at least a nanosecond apart",
        motions,
    ),
    (
        "recording (`replay` of a `.mcap`, `coaxle recover`, `export`, `info`)",
        "any length, read in pieces; 64 MiB in a record or chunk, and of all descriptions in it; of a replayed axis 4 000 000 rows as above",
        recordings,
    ),
    (
        "file of arrivals (`record-arrivals --from`)",
        "4 GiB, 4096 bytes in a line",
        arrivals,
    ),
    (
        "order over the network",
        "4096 bytes; with a cam plate (`cam-table-select`) 1 MiB",
        orders,
    ),
    (
        "upstream axes in the status of a followed node (`circles.upstream`)",
        "4096, over 64 hops",
        upstream,
    ),
    (
        "points, or rows of values, in a response about a cam plate",
        "4096",
        values_read,
    ),
    (
        "points of a cam plate that is replaced while a slave is on it",
        "4096",
        replaced_points,
    ),
    (
        "a point table of `coaxle cam import`",
        "64 MiB, a million points or rows; a result beyond the 4 MiB of a cam file is written to a CSV file beside it",
        imports,
    ),
    ("timing keys of a node (`timing.keys`)", "1 MiB", keys),
    (
        "records of an [audit](SECURE.md#audit) that a node keeps; a reply about them; a name and a reason in them",
        "1024; 512 KiB; 64 and 240 characters",
        audit,
    ),
    (
        "requests to a page (`scope`, `--page`, `cam edit`, `saw edit`)",
        "32 connections; the head within 5 s, a body of 2 MiB within 10 s; 1000 signals",
        |_| crate::door::is_probed(),
    ),
];

/// The text with a comment behind it, to this length.
fn padded(text: &str, bytes: u64, comment: &str) -> String {
    let mut text = format!("{text}\n{comment}");
    let missing = bytes as usize - text.len();
    text.extend(std::iter::repeat_n('x', missing));
    text
}

fn configs(bench: &Bench) {
    let sender = format!("name = 's'\ncycle-time-us = 1000\n{AXIS}");
    let scenario = format!(
        "title = 't'\nduration-s = 1\n[[sender]]\nname = 's'\ncycle-time-us = 1000\n{}",
        AXIS.replace("axis", "sender.axis")
    );
    let saw = crate::memory::shipped("scenarios/saws/saw-position-1.toml");
    for (text, words) in [
        (sender.as_str(), &["sender", "FILE", "--check"][..]),
        (scenario.as_str(), &["check", "FILE"]),
        (saw.as_str(), &["saw", "plan", "FILE"]),
    ] {
        for (bytes, is_taken) in [(MIB, true), (MIB + 1, false)] {
            let file = bench.file("long.toml", padded(text, bytes, "#"));
            let words: Vec<_> = words
                .iter()
                .map(|word| if *word == "FILE" { file.as_str() } else { word })
                .collect();
            let end = run(&words);
            match is_taken {
                true => end.is_taken(),
                false => end.is_refused("received 1048577 bytes, expected at most 1048576"),
            }
        }
    }
    bench.file("zenoh.json5", padded("{}", MIB + 1, "//"));
    let config = format!("cycle-time-us = 1000\ntransport = {{ file = 'zenoh.json5' }}\n{AXIS}");
    bench
        .sender(&config)
        .is_refused("received 1048577 bytes, expected at most 1048576");
}

fn cam_files(bench: &Bench) {
    let cam =
        "[[point]]\nlaw = 'polynom5'\nmaster = 0\nslave = 0\n[[point]]\nmaster = 1\nslave = 1\n";
    bench.cam(&padded(cam, 4 * MIB, "#")).is_taken();
    bench
        .cam(&padded(cam, 4 * MIB + 1, "#"))
        .is_refused("received 4194305 bytes, expected at most 4194304");
}

/// Numbered lines of a CSV file.
fn lines(
    bench: &Bench,
    name: &str,
    head: &str,
    rows: usize,
    line: impl Fn(usize) -> String,
) -> String {
    let path = bench.path(name);
    let mut file = BufWriter::new(File::create(&path).expect("a file"));
    write!(file, "{head}").expect("a head");
    for row in 0..rows {
        writeln!(file, "{}", line(row)).expect("a row");
    }
    file.flush().expect("a file");
    shown(&path)
}

fn tables(bench: &Bench) {
    let cam = |csv: &str, section: &str| bench.cam(&format!("[{section}]\ncsv = '{csv}'\n"));
    let too_many = "received more than 1000000 rows, expected at most that many";
    let long = lines(bench, "rows.csv", "", 1_000_001, |row| format!("{row},0"));
    cam(&long, "table").is_refused(too_many);
    let clock = format!(
        "cycle-time-us = 1000\nlab.clock.drift-terms-ppm = [{{ file = {{ path = '{long}' }} }}]\n{AXIS}"
    );
    bench.sender_in_lab(&clock).is_refused(too_many);
    let wide = bench.file("wide.csv", format!("0,0\n1,{}\n", "1".repeat(4095)));
    cam(&wide, "table")
        .is_refused("received more than 4096 bytes, expected at most that many in a line");
    let large = bench.zeros("large.csv", 64 * MIB + 1);
    for section in ["table", "points"] {
        cam(&large, section).is_refused("received 67108865 bytes, expected at most 67108864");
    }
}

fn motions(bench: &Bench) {
    let replay = |csv: &str| {
        let axis = format!("[[axis]]\nid = 1\nname = 'a'\nreplay = {{ file = '{csv}' }}\n");
        bench.sender(&format!("cycle-time-us = 1000\n{axis}"))
    };
    let motion = |rows: &str| replay(&bench.file("motion.csv", format!("time_s,position\n{rows}")));
    motion("0,-1e100\n1,1e100\n").is_taken();
    motion("0,0\n1,2e100\n").is_refused("2e100");
    motion("0,0\n5e-10,1\n").is_refused("expected");
    motion(&format!("0,0\n1,{}\n", "1".repeat(4095))).is_refused("received more than 4096 bytes");
    replay(&bench.zeros("large.csv", 128 * MIB + 1))
        .is_refused("received 134217729 bytes, expected at most 134217728");
    let long = lines(bench, "rows.csv", "time_s,position\n", 4_000_001, |row| {
        format!("{row},0")
    });
    replay(&long).is_refused("received more than 4000000 rows, expected at most that many");
}

fn recordings(bench: &Bench) {
    for words in [&["info"][..], &["recover"], &["export", "csv"]] {
        let file = bench.file("long.mcap", crate::memory::record_of(64 * MIB + 1));
        let end = run(&[words, &[file.as_str()]].concat());
        end.has_not_crashed();
        assert!(
            end.says("received a record of 67108865 bytes, expected at most 67108864"),
            "{}",
            end.text
        );
        // Written by `recover`.
        let _ = std::fs::remove_file(bench.path("long-recovered.mcap"));
    }
}

fn arrivals(bench: &Bench) {
    let out = shown(&bench.path("out"));
    let from = |file: &str| run(&["record-arrivals", "--from", file, "--out", &out]);
    from(&bench.zeros("large.csv", (4 << 30) + 1))
        .is_refused("received 4294967297 bytes, expected at most 4294967296");
    let head = "at_ns,cycle,cycle_start_ns,epoch,count,cycle_time_ns,arrival_ns,send_stamp_ns\n";
    // More than is read at once, so that the header has been read before.
    let rows: String = (0..1_000)
        .map(|k| format!("9,1,1,5,{k},1000000,{},-4\n", 300 + k))
        .collect();
    let wide = bench.file("wide.csv", format!("{head}{rows}{}\n", "1".repeat(4097)));
    from(&wide).is_refused("received more than 4096 bytes, expected at most that many in a line");
}

fn orders(_: &Bench) {
    let order = r#"{"version":1,"slave":"a","command":{"power":true}"#;
    let plate = r#"{"version":1,"cams":true,"command":{"cam-table-select":{"table":1,"plate":{"point":[]}}}"#;
    for (order, most) in [(order, MAX_ORDER_BYTES), (plate, MAX_PLATE_ORDER_BYTES)] {
        let of = |bytes: usize| {
            let mut text = order.to_owned();
            text.extend(std::iter::repeat_n(' ', bytes - order.len() - 1));
            text.push('}');
            CommandOrder::from_json(text.as_bytes()).map_err(|error| error.to_string())
        };
        let says = |bytes: usize| of(bytes).err().unwrap_or_default();
        assert!(
            !says(most).contains("bytes, expected at most"),
            "{}",
            says(most)
        );
        assert!(
            says(most + 1).contains("bytes, expected at most"),
            "{}",
            says(most + 1)
        );
    }
    assert_eq!((MAX_ORDER_BYTES, MAX_PLATE_ORDER_BYTES), (4096, 1 << 20));
}

fn upstream(_: &Bench) {
    let name = |name: &str| NodeName::new(name).expect("a name");
    // Axes that a neighbour passes on, each of which follows the next, as many hops away: of these, those that are passed
    // on further.
    let passed_on = |axes: usize, hops: u64| {
        let entry = |n: usize| {
            let follows = [format!("far/slaves/{}", n + 1)];
            json!({ "axis": format!("far/slaves/{n}"), "follows": follows, "coupled": true, "hops": hops })
        };
        let entries: Vec<_> = (1..=axes).map(entry).collect();
        let status = json!({ "circles": { "upstream": entries } });
        let mut watch = CircleWatch::new(name("saw"), [name("belt")]);
        watch.take(&name("belt"), status.as_object().expect("an object"));
        let own = json!({ "slaves": { "gear": { "id": 1, "follows": ["far/slaves/1"] } } });
        let found = watch.look(own.as_object().expect("an object")).to_json();
        found["upstream"].as_array().map(Vec::len)
    };
    assert_eq!(passed_on(4096, 1), Some(4096));
    assert_eq!(passed_on(5000, 1), Some(4096));
    assert_eq!((passed_on(1, 63), passed_on(1, 64)), (Some(1), Some(0)));
}

fn keys(bench: &Bench) {
    let saw = NodeName::new("saw").expect("a name");
    let read = |bytes| {
        bench.file(TIMING_KEYS_FILE, padded("", bytes, "#"));
        let keys = timing_keys(&bench.path("."), &saw, []);
        keys.map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(read(MIB), Ok(()));
    let refused = read(MIB + 1).expect_err("too long");
    assert!(
        refused.contains("received 1048577 bytes, expected at most 1048576"),
        "{refused}"
    );
}

fn audit(_: &Bench) {
    let mut trail = AuditTrail::new(NodeName::new("saw").expect("a name"), 1);
    for n in 0..1100 {
        let at = AuditTime {
            wall_us: n,
            since_start: Span::from_millis(n),
        };
        let (name, reason) = ("n".repeat(1000), "ü".repeat(1000));
        let entry = AuditEntry::new(
            AuditDoor::Order,
            Some(&name),
            "MC_Power",
            AuditOutcome::Accepted,
        );
        trail.note(at, entry.because(&reason), &mut |_| {});
    }
    let kept: Vec<_> = trail.after(0).collect();
    assert_eq!(kept.len(), 1024);
    let text = kept[0].to_json();
    // And the sign that something was cut off.
    assert!(text.contains(&format!("\"{}…\"", "n".repeat(64))), "{text}");
    assert!(
        text.contains(&format!("\"{}…\"", "ü".repeat(240))),
        "{text}"
    );
    let query = AuditQuery {
        newest: Some(1024),
        ..AuditQuery::default()
    };
    let reply = AuditExcerpt::of(&trail, &query);
    assert!(reply.records.len() < 1024);
    let length = reply.to_json().len();
    assert!(length > 500 << 10 && length < 513 << 10, "{length}");
}

fn values_read(_: &Bench) {
    // `wire/tests/wire/cam_orders.rs` reads one more of each.
    assert_eq!((MAX_POINTS_READ, MAX_VALUES_READ), (4096, 4096));
}

fn replaced_points(_: &Bench) {
    // `cam/src/tests/select.rs` replaces a longer plate in use.
    assert_eq!(MOST_POINTS_REPLACED_IN_USE, 4096);
}

fn imports(bench: &Bench) {
    let import = |table: &str| {
        run(&[
            "cam",
            "import",
            table,
            "-o",
            &shown(&bench.path("out.toml")),
        ])
    };
    import(&bench.zeros("large.csv", 64 * MIB + 1))
        .is_refused("received 67108865 bytes, expected at most 67108864");
    let long = lines(bench, "rows.csv", "", 1_000_001, |row| format!("{row},0"));
    import(&long).is_refused("received more than 1000000 rows, expected at most that many");
    // Some 6 MiB as TOML.
    let wide = lines(bench, "wide.csv", "", 300_000, |row| format!("{row},0"));
    import(&wide).is_taken();
    let mut files = String::new();
    for entry in std::fs::read_dir(bench.path(""))
        .expect("a folder")
        .flatten()
    {
        let _ = write!(files, "{} ", entry.file_name().to_string_lossy());
    }
    assert!(files.contains("out.csv"), "{files}");
}
