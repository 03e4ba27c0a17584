//! Contents of configs and scenarios: lists of the greatest permitted length, numbers at the ends of their ranges, and
//! those beyond.

use crate::root;

use crate::page::ProbedRow;
use crate::{AXIS, Bench, run, shown};

pub(crate) const ROWS: &[ProbedRow] = &[
    (
        "axes of a sender; virtual axes, and slaves, of a receiver; followed axes of one node",
        "128, as in a frame",
        axes,
    ),
    (
        "followed nodes of a receiver, including standbys",
        "128",
        followed_nodes,
    ),
    ("steps of a slave's program", "1000", program_steps),
    (
        "cam plates of a receiver, shared by its slaves",
        "255, by their numbers; 4 000 000 points and rows together",
        plates,
    ),
    (
        "positions and distances of an axis's program, u",
        "±1e12",
        positions,
    ),
    ("limits of an axis's program", "1e15", axis_limits),
    ("loops within loops of an axis's program", "8", loops),
    ("numbers of a cam plate", "±1e15", plate_numbers),
    ("cycle time", "100 µs to 100 ms", cycle_times),
    ("steps of a clock", "128, of up to 100 s each", clock_steps),
    ("count of a first cycle", "40 000 000 000", first_counts),
    (
        "terms of a clock's drift; of a link's delay",
        "16; those of a drift 300 000 ppm in sum",
        terms,
    ),
    (
        "senders and receivers of a scenario",
        "1000; 1000 of a group, and 16 MiB of all groups once expanded",
        scenario_nodes,
    ),
    ("routers of a scenario", "128", routers),
    ("duration of a scenario", "1 000 000 s", durations),
    (
        "points of a sweep, times seeds",
        "10 000, and 16 MiB of the scenario at all points together",
        sweeps,
    ),
    ("keys in a path of `--set`", "32", set_paths),
    ("rows of `coaxle cam values`", "10 000 000", cam_values),
];

const SENDER: &str = "cycle-time-us = 1000\n";

/// The axis with this number.
fn axis(id: usize) -> String {
    AXIS.replace("id = 1", &format!("id = {id}"))
        .replace("'a'", &format!("'a{id}'"))
}

fn times(count: usize, of: impl Fn(usize) -> String) -> String {
    (1..=count).map(of).collect()
}

fn axes(bench: &Bench) {
    let sender = |count| bench.sender(&format!("{SENDER}{}", times(count, axis)));
    sender(128).is_taken();
    sender(129).is_refused("received 129 axes, expected 1 to 128");
    let virtual_axes = |count| {
        bench.receiver(
            &times(count, axis)
                .replace("[[axis]]", "[[virtual-axis]]")
                .replace("[axis.", "[virtual-axis."),
        )
    };
    virtual_axes(128).is_taken();
    virtual_axes(129).is_refused("virtual-axis: received 129, expected at most 128");
    let slave = |n: usize| {
        format!(
            "[[slave]]\nname = 's{n}'\nlimits = {{ velocity = 1000, acceleration = 1000, jerk = 10000 }}\n"
        )
    };
    let slaves = |count| {
        bench.receiver(&format!(
            "master = {{ node = 'a', axis = 1 }}\n{}",
            times(count, slave)
        ))
    };
    slaves(128).is_taken();
    slaves(129).is_refused("received 129 slaves, expected at most 128");
    let followed = |count: usize| {
        let ids = times(count, |id| format!("{id}, "));
        bench.receiver(&format!("[[far]]\nnode = 'a'\naxes = [{ids}]\n"))
    };
    followed(128).is_taken();
    followed(129).is_refused("received 129 axes, expected at most 128");
}

fn followed_nodes(bench: &Bench) {
    let far = |n: usize| format!("[[far]]\nnode = 'a{n}'\naxes = [1]\n");
    bench.receiver(&times(128, far)).is_taken();
    bench
        .receiver(&times(129, far))
        .is_refused("far: received more than 128, expected at most that many");
}

fn program_steps(bench: &Bench) {
    let steps = |count| {
        let head = "master = { node = 'a', axis = 1 }\n[[slave]]\nname = 's'\n\
                    limits = { velocity = 1000, acceleration = 1000, jerk = 10000 }\n";
        let step = |_| "[[slave.step]]\ndo = { power = true }\n".to_owned();
        bench.receiver(&format!("{head}{}", times(count, step)))
    };
    steps(1000).is_taken();
    steps(1001).is_refused("received 1001 steps, expected at most 1000");
}

/// Two points, the second one at this master and slave.
fn points(master: &str, slave: &str) -> String {
    format!(
        "[[point]]\nlaw = 'polynom5'\nmaster = 0\nslave = 0\n[[point]]\nmaster = {master}\nslave = {slave}\n"
    )
}

fn plates(bench: &Bench) {
    // All of them together: `receiver/src/slaves/plates.rs` tests their points and rows.
    let plate = |id: usize| {
        bench.file(
            &format!("{id}.toml"),
            format!("table-id = {id}\n{}", points("1", "1")),
        )
    };
    let receiver = |ids: usize| {
        let files: Vec<_> = (1..=ids).map(|id| format!("'{}'", plate(id))).collect();
        bench.receiver(&format!(
            "master = {{ node = 'a', axis = 1 }}\ncams = [{}]\n",
            files.join(", ")
        ))
    };
    receiver(255).is_taken();
    receiver(256).is_refused("256");
}

fn positions(bench: &Bench) {
    let starts = |position: &str| {
        let axis = AXIS.replace("limits", &format!("start-position = {position}\nlimits"));
        bench.sender(&format!("{SENDER}{axis}"))
    };
    starts("-1e12").is_taken();
    starts("1.001e12").is_refused("program.start-position: received 1001000000000, expected a number from -1000000000000 to 1000000000000");
}

fn axis_limits(bench: &Bench) {
    let limited = |velocity: &str| {
        bench.sender(&format!(
            "{SENDER}{}",
            AXIS.replace("velocity = 1000.0", &format!("velocity = {velocity}"))
        ))
    };
    limited("1e15").is_taken();
    limited("1.001e15").is_refused("program.limits.velocity: received 1.001e15, expected");
}

fn loops(bench: &Bench) {
    let nested = |depth: usize| {
        let inner = (0..depth).fold("{ halt = {} }".to_owned(), |inner, _| {
            format!("{{ loop = {{ count = 2, steps = [{inner}] }} }}")
        });
        bench.sender(&format!(
            "{SENDER}{AXIS}steps = [{{ enable = true }}, {inner}]\n"
        ))
    };
    nested(8).is_taken();
    nested(9).is_refused("received a loop nested 9 deep, expected at most 8");
}

fn plate_numbers(bench: &Bench) {
    bench.cam(&points("1e15", "-1e15")).is_taken();
    for (master, slave) in [("1.001e15", "0"), ("1", "-1.001e15")] {
        bench
            .cam(&points(master, slave))
            .is_refused("expected a number from -1e15 to 1e15");
    }
}

fn cycle_times(bench: &Bench) {
    let of = |micros: &str| bench.sender(&format!("cycle-time-us = {micros}\n{AXIS}"));
    for micros in ["100", "100000"] {
        of(micros).is_taken();
    }
    for micros in ["99.9", "100001"] {
        of(micros).is_refused("expected 100 to 100000");
    }
}

/// A sender whose clock is as in `lab.clock`.
fn clock(bench: &Bench, fields: &str) -> crate::ToolEnd {
    bench.sender_in_lab(&format!("{SENDER}{AXIS}[lab.clock]\n{fields}\n"))
}

fn clock_steps(bench: &Bench) {
    let steps = |count, phase_us: &str| {
        let step = |n: usize| format!("{{ at-s = {n}, phase-us = {phase_us} }}, ");
        clock(bench, &format!("steps = [{}]", times(count, step)))
    };
    steps(128, "1").is_taken();
    steps(129, "1").is_refused("received more than 128, expected at most that many");
    steps(1, "-1e8").is_taken();
    steps(1, "1.001e8").is_refused("expected a number from -100000000 to 100000000");
}

fn first_counts(bench: &Bench) {
    clock(bench, "first-count = 40000000000").is_taken();
    clock(bench, "first-count = 40000000001").is_refused("expected a count of at most 40000000000");
}

fn terms(bench: &Bench) {
    let drift = |count, ppm: u32| {
        let term = |_| format!("{{ constant = {ppm} }}, ");
        clock(
            bench,
            &format!("drift-terms-ppm = [{}]", times(count, term)),
        )
    };
    drift(16, 1).is_taken();
    drift(17, 1).is_refused("received more than 16, expected at most that many");
    drift(3, 100_000).is_taken();
    drift(4, 100_000)
        .is_refused("received terms that come to 400000 in sum, expected at most 300000");
    let delay = |count| {
        let term = |_| "{ constant = 1 }, ".to_owned();
        scenario(
            bench,
            &format!("[network]\ndelay-terms-us = [{}]\n", times(count, term)),
        )
    };
    delay(16).is_taken();
    delay(17).is_refused("received more than 16, expected at most that many");
}

const SCENARIO_SENDER: &str = "[[sender]]\nname = 's'\ncycle-time-us = 1000\n";

/// A scenario of a sender and this.
fn scenario(bench: &Bench, text: &str) -> crate::ToolEnd {
    let axis = AXIS
        .replace("[[axis", "[[sender.axis")
        .replace("[axis", "[sender.axis");
    bench.scenario(&format!("duration-s = 1\n{text}{SCENARIO_SENDER}{axis}"))
}

fn scenario_nodes(bench: &Bench) {
    let group = |count: usize, more: &str| {
        let axis = AXIS
            .replace("[[axis", "[[group.sender.axis")
            .replace("[axis", "[group.sender.axis");
        let sender = "[[group.sender]]\nname = 'g{n}'\ncycle-time-us = 1000\n";
        scenario(
            bench,
            &format!("[[group]]\ncount = {count}\n{sender}{axis}{more}"),
        )
    };
    group(999, "").is_taken();
    group(1000, "").is_refused("received 1001 senders and receivers, expected at most 1000");
    group(1001, "").is_refused("received 1001, expected 1 to 1000");
    let title = "x".repeat(20_000);
    let long = format!("[[group.expect]]\nreceiver = '{title}'\nfield = 'x'\nequals = 1\n");
    group(999, &long).is_refused("bytes of TOML once written out, expected at most 16777216");
}

fn routers(bench: &Bench) {
    let of = |count: usize| {
        let router = |n: usize| {
            let (nodes, to) = if n == 1 {
                ("'s'", String::new())
            } else {
                ("", format!("'r{}'", n - 1))
            };
            format!("[[router]]\nname = 'r{n}'\nnodes = [{nodes}]\nto = [{to}]\n")
        };
        scenario(bench, &times(count, router))
    };
    of(128).is_taken();
    of(129).is_refused("received 129, expected at most 128");
}

fn durations(bench: &Bench) {
    let of = |seconds: &str| {
        let axis = AXIS
            .replace("[[axis", "[[sender.axis")
            .replace("[axis", "[sender.axis");
        bench.scenario(&format!("duration-s = {seconds}\n{SCENARIO_SENDER}{axis}"))
    };
    of("1000000").is_taken();
    of("1000001").is_refused("1000000");
}

fn sweeps(bench: &Bench) {
    let out = shown(&bench.path("out"));
    let seeds = |seeds: &str, over: &str| {
        let words = [
            "sweep", "beat", "--seeds", seeds, "--over", over, "--out", &out,
        ];
        run(&words)
    };
    seeds("10001", "duration-s=1").is_refused("received 10001, expected 1 to 10000");
    seeds("5001", "duration-s=1,2").is_refused("received a grid of more than 10000 points");
    let long =
        std::fs::read_to_string(root().join("scenarios/catalog/beat.toml")).expect("a scenario");
    let long = bench.file(
        "long.toml",
        format!("{long}\n#{}", "x".repeat(1 << 20 >> 1)),
    );
    let over = format!(
        "seed={}",
        (0..40).map(|n| n.to_string()).collect::<Vec<_>>().join(",")
    );
    run(&["sweep", &long, "--over", &over, "--out", &out])
        .is_refused("expected at most 16777216 bytes at all of them together");
}

fn set_paths(bench: &Bench) {
    let out = shown(&bench.path("out"));
    let set = |keys: usize| {
        let path = vec!["a"; keys].join(".");
        run(&["run", "beat", "--out", &out, "--set", &format!("{path}=1")])
    };
    set(33).is_refused("received --set with a path of 33 keys, expected at most 32");
    let known = set(32);
    assert!(!known.says("with a path of"), "{}", known.text);
}

fn cam_values(bench: &Bench) {
    let file = bench.file("c.toml", points("1e7", "1"));
    // One more than the steps.
    run(&["cam", "values", &file, "--increment", "0.99999"]).is_refused("expected");
}
