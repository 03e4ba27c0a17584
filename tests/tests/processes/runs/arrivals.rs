//! Arrivals of real messages, recorded with their true delays.

use std::path::Path;

use serde_json::Value;

use super::{alone, coaxle};

#[test]
fn arrivals_are_recorded_with_true_delays_and_nobody_is_left_busy() {
    let _alone = alone();
    let out = tempfile::tempdir().expect("a scratch folder");
    let name = out.path().join("loopback");
    let name = name.to_str().expect("a plain path");
    let output = coaxle(&[
        "record-arrivals",
        "--seconds=3",
        "--cycle-us=2000",
        "--transport=udp",
        "--busy=1",
        "--out",
        name,
    ]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert_eq!(busy_processes(), 0);

    let bytes = std::fs::read(format!("{name}.i32")).expect("a recording");
    let (rows, rest) = bytes.as_chunks::<16>();
    assert!(rest.is_empty());
    // 1500 if nothing is lost, and some at the very end.
    assert!((300..=1_600).contains(&rows.len()), "{}", rows.len());
    let number = |row: &[u8; 16], n: usize| row.as_chunks::<4>().0[n];
    let column = |n: usize| {
        rows.iter()
            .map(move |row| i32::from_le_bytes(number(row, n)))
    };
    assert_eq!(column(0).next(), Some(0));
    // No message arrives before it is sent; on loopback it takes some microseconds at least.
    let mut delays: Vec<i32> = column(2).collect();
    delays.sort_unstable();
    assert!(delays[0] > 1_000, "{} ns", delays[0]);
    assert!(delays[delays.len() / 2] < 50_000_000, "{delays:?}");
    assert!(column(3).all(|kernel| kernel == 0));

    let exchanges = std::fs::read_to_string(format!("{name}-exchanges.csv")).expect("exchanges");
    let mut lines = exchanges.lines();
    assert_eq!(lines.next(), Some("t1_ns,t2_ns,t3_ns,t4_ns"));
    let mut number_of_exchanges = 0;
    for line in lines {
        let stamps: Vec<i64> = line.split(',').map(|t| t.parse().expect("ns")).collect();
        assert!(stamps.is_sorted(), "one clock runs forward: {line}");
        number_of_exchanges += 1;
    }
    assert!(number_of_exchanges > 10, "{number_of_exchanges}");

    let summary = std::fs::read(format!("{name}.json")).expect("a summary");
    let summary: Value = serde_json::from_slice(&summary).expect("JSON");
    assert_eq!(summary["origin"]["transport"], "udp");
    assert_eq!(summary["cycle_time_us"], 2_000.0);
    assert_eq!(summary["messages"], rows.len());
    assert!(!out.path().join("loopback-nodes").exists());
}

/// Processes of the tool under test that keep processors busy.
fn busy_processes() -> usize {
    let tool = Path::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
    let processes = std::fs::read_dir("/proc").expect("Linux");
    processes
        .flatten()
        .filter(|process| {
            let path = process.path();
            std::fs::read_link(path.join("exe")).is_ok_and(|exe| exe == tool)
                && std::fs::read(path.join("cmdline"))
                    // Arguments end with zeros in this file.
                    .is_ok_and(|line| line.ends_with(b"keep-busy\0"))
        })
        .count()
}
