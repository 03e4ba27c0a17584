//! Hostile input: no target panics, takes long, or refuses it without one clear line.
//!
//! `HOSTILE_CASES` and `HOSTILE_SEED` set the number of mutations of each target in the long run, and the first seed.

use coaxle_test_hostile::trial::{corpus_outcomes, mutations, processor_time};
use coaxle_test_hostile::{Kind, TARGETS, Target, target};

#[test]
fn what_is_shipped_is_taken() {
    for target in TARGETS {
        for (name, data) in (target.seeds)() {
            let outcome = target.examine(&data);
            assert!(
                // Examples of refusals are shipped with the saw and gear files.
                outcome.is_ok() || ["saw-file", "gear-file"].contains(&target.name),
                "{}: {name}: {outcome:?}",
                target.name
            );
        }
    }
}

/// Runs each input of the corpus, and lists the outcomes.
#[test]
fn the_stored_corpus_holds() {
    let table: String = TARGETS.iter().map(corpus_outcomes).collect();
    insta::assert_snapshot!(table);
}

/// Mutations of each target in the ordinary tests: seconds in all.
const fn cases(target: &Target) -> usize {
    match (target.name.as_bytes(), target.kind) {
        // A receiver runs for a thousand cycles each time.
        (b"arrivals" | b"far-frames", _) => 1_000,
        // A gateway runs for a cycle for each sample.
        (b"ads" | b"plc-datagrams" | b"plc-lines", _) => 1_000,
        // An axis runs for some hundred cycles, and a plate is scanned.
        (b"axis-orders" | b"plate", _) => 10_000,
        (_, Kind::Bytes) => 50_000,
        (_, Kind::Text) => 3_000,
    }
}

macro_rules! mutations_hold {
    ($($test:ident: $name:literal,)*) => {
        $(
            #[test]
            fn $test() {
                // A test for each target: they run in parallel, and a failure names its own.
                let target = target($name);
                mutations(target, cases(target), 1);
            }
        )*

        #[test]
        fn every_target_is_tried() {
            let tried = [$($name),*];
            // A new target without a test fails here.
            assert!(TARGETS.iter().map(|target| target.name).eq(tried));
        }
    };
}

mutations_hold! {
    frames: "frame",
    time_requests: "time-request",
    time_responses: "time-response",
    plans: "plans",
    reports: "reports",
    arrivals: "arrivals",
    orders: "order",
    sender_configs: "sender-config",
    receiver_configs: "receiver-config",
    scenarios: "scenario",
    cam_files: "cam-file",
    cam_tables: "cam-table",
    point_tables: "point-table",
    plc_arrays: "plc-array",
    saw_files: "saw-file",
    gear_files: "gear-file",
    recordings: "recording",
    ros_trajectories: "ros-trajectory",
    ads: "ads",
    plc_datagrams: "plc-datagrams",
    plc_lines: "plc-lines",
    axis_orders: "axis-orders",
    far_frames: "far-frames",
    plates: "plate",
}

#[test]
#[ignore = "as long as HOSTILE_CASES says"]
fn many_mutations() {
    let number = |name: &str| {
        std::env::var(name)
            .ok()
            .map(|text| text.parse::<u64>().unwrap())
    };
    let only = std::env::var("HOSTILE_TARGET").ok();
    // Seed 1 is that of the ordinary tests, so 2 tries new inputs.
    let seed = number("HOSTILE_SEED").unwrap_or(2);
    for target in TARGETS {
        // A target that fails is run again without the hours of the others.
        if only.as_ref().is_some_and(|only| only != target.name) {
            continue;
        }
        let more = number("HOSTILE_CASES").map(|cases| cases as usize);
        let cases = more.unwrap_or(10 * cases(target));
        let begin = processor_time();
        let tally = mutations(target, cases, seed);
        let took = processor_time() - begin;
        eprintln!("{}: {cases} in {took:.1?}: {tally:?}", target.name);
    }
}
