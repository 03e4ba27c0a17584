//! Starts of nodes without enough of what the system has to give.

use coaxle_tests::ports::free_port;

use crate::{AXIS, Bench, program_memory, run_with};

fn node(bench: &Bench) -> String {
    // A port that nobody else has, and no node to connect to.
    let config = format!(
        "name = 's'\ncycle-time-us = 1000\ntransport.listen = ['tcp/127.0.0.1:{}']\n{AXIS}",
        free_port()
    );
    bench.file("s.toml", config)
}

#[test]
fn a_node_without_descriptors_ends_with_the_cause() {
    let bench = Bench::new();
    let node = node(&bench);
    for most in [8, 10, 12, 14, 16, 20, 24, 32] {
        let Some(end) = run_with(&[("-n", most)], &["sender", &node, "--for", "1s"]) else {
            return;
        };
        end.has_not_crashed();
        assert_eq!(end.code, Some(1), "{most}: {}", end.text);
        end.is_refused("error: ");
        assert!(
            end.says("open files: received a limit that leaves"),
            "{most}: {}",
            end.text
        );
        assert!(end.says("`ulimit -n`"), "{most}: {}", end.text);
    }
    // As many as a shell gives by default.
    if let Some(end) = run_with(&[("-n", 1024)], &["sender", &node, "--for", "1s"]) {
        end.is_taken();
    }
}

#[test]
fn a_node_without_memory_ends_with_the_cause() {
    let bench = Bench::new();
    let node = node(&bench);
    let Some(program) = program_memory() else {
        return;
    };
    // Beyond what the program itself takes, in uneven steps: where it ends differs from each to the next.
    for beyond in [
        4_000, 7_000, 12_000, 17_000, 22_000, 37_000, 52_000, 67_000, 77_000,
    ] {
        let most = program + beyond;
        let Some(end) = run_with(&[("-v", most)], &["sender", &node, "--for", "1s"]) else {
            return;
        };
        end.has_not_crashed();
        assert_eq!(end.code, Some(1), "{most}: {}", end.text);
        assert!(
            end.says("memory: received a limit that leaves less than"),
            "{most}: {}",
            end.text
        );
        assert!(end.says("`ulimit -v`"), "{most}: {}", end.text);
    }
    // It either runs, or says why not.
    for most in [170_000, 200_000, 250_000, 350_000, 500_000, 700_000] {
        if let Some(end) = run_with(&[("-v", most)], &["sender", &node, "--for", "1s"]) {
            end.has_not_crashed();
            assert!(
                // Without memory for a stack it is the thread that is missing.
                end.code == Some(0)
                    || end.says("memory: received")
                    || end.says("threads: received"),
                "{most}: {}",
                end.text
            );
        }
    }
    if let Some(end) = run_with(&[("-v", 2_000_000)], &["sender", &node, "--for", "1s"]) {
        end.is_taken();
    }
}
