//! `coaxle saw` as a user starts it.

use crate::inspect::Tool;
use crate::shared::{text, written};
use serde_json::Value;

const SAW: Tool = Tool {
    command: "saw",
    files: "saws",
};

/// The plan of a shipped file.
fn plan(file: &str) -> Value {
    let output = SAW.run(&["plan", &SAW.shipped(file), "--json"]);
    assert!(output.status.success(), "{file}: {}", text(&output.stdout));
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// A characteristic value by its name.
fn value(plan: &Value, name: &str) -> f64 {
    let values = plan["characteristics"].as_array().expect("a list");
    let named = values.iter().find(|value| value["name"] == name);
    number(&named.expect("there is one of that name")["value"])
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// The larger magnitude of two characteristic values.
fn peak(plan: &Value, names: [&str; 2]) -> f64 {
    let [low, high] = names.map(|name| value(plan, name).abs());
    low.max(high)
}

/// Checks all digits of the manual's number against the value.
fn printed(value: f64, expected: &str) {
    let decimals = expected.split_once('.').map_or(0, |(_, d)| d.len());
    assert_eq!(format!("{value:.decimals$}"), expected);
}

/// Duration, peak acceleration, peak jerk.
fn demands(plan: &Value, expected: [&str; 3]) {
    printed(number(&plan["duration"]), expected[0]);
    printed(peak(plan, ["fSlaveAccMin", "fSlaveAccMax"]), expected[1]);
    printed(peak(plan, ["fSlaveJerkMin", "fSlaveJerkMax"]), expected[2]);
}

#[test]
fn synchronisations_to_velocity_have_the_manuals_numbers() {
    for (file, expected, length) in [
        (
            "saw-velocity-1",
            ["0.948683", "1185.85", "5000.00"],
            "474.342",
        ),
        (
            "saw-velocity-2",
            ["1.095445", "1369.31", "5000.00"],
            "547.723",
        ),
        (
            "saw-velocity-3",
            ["1.039230", "1299.04", "5000.00"],
            "519.615",
        ),
    ] {
        let plan = plan(&format!("{file}.toml"));
        assert_eq!(plan["form"], "ramp");
        demands(&plan, expected);
        printed(number(&plan["master_distance"]), length);
    }
    let first = plan("saw-velocity-1.toml");
    printed(value(&first, "fSlavePosEnd"), "118.585");
}

#[test]
fn time_based_synchronisations_have_the_manuals_numbers() {
    for (file, expected) in [
        ("saw-velocity-1-time", ["0.774597", "1936.49", "5000.00"]),
        ("saw-velocity-2-time", ["0.894427", "2236.07", "5000.00"]),
        ("saw-velocity-3-time", ["0.848528", "2121.32", "5000.00"]),
    ] {
        let plan = plan(&format!("{file}.toml"));
        assert_eq!(plan["form"], "jerk-phases");
        demands(&plan, expected);
    }
    let first = plan("saw-velocity-1-time.toml");
    printed(number(&first["slave_distance"]), "96.8246");
}

#[test]
fn synchronisations_to_position_have_the_manuals_numbers() {
    let free = plan("saw-position-1.toml");
    assert_eq!(free["form"], "quintic");
    demands(&free, ["3.000000", "175.046", "444.444"]);
    printed(value(&free, "fSlaveVeloMax"), "506.000");
    let place = value(&free, "fMPosAtSVeloMax") - value(&free, "fMasterPosStart");
    printed(place, "1200.000");

    let checked = plan("saw-position-1-checked.toml");
    assert_eq!(checked["form"], "quintic-line");
    demands(&checked, ["3.000000", "187.500", "375.000"]);
    printed(number(&checked["phases"][0]["master_distance"]), "1000.000");
    printed(value(&checked, "fSlaveVeloMin"), "250.000000");
    printed(value(&checked, "fSlaveVeloMax"), "500.000000");

    let reversing = plan("saw-position-2.toml");
    assert_eq!(reversing["form"], "quintic");
    demands(&reversing, ["3.000000", "568.755", "1222.22"]);
    printed(value(&reversing, "fSlavePosMin"), "-620.638");
}

#[test]
fn a_plan_has_its_phases_31_values_and_the_tables_header() {
    let plan = plan("saw-position-1-checked.toml");
    let phases = plan["phases"].as_array().unwrap();
    let laws = phases.iter().map(|phase| &phase["law"]);
    assert!(laws.eq(["polynom5-mm", "polynom1"]));
    assert_eq!(phases[0]["end"], phases[1]["start"]);
    printed(number(&phases[1]["start"]["master"]), "500.000000");
    assert_eq!(phases[1]["end"]["velocity"], 500.0);
    let values = plan["characteristics"].as_array().unwrap();
    assert_eq!(values.len(), 31);
    assert!(values.iter().all(|value| value["unit"].is_string()));
    assert_eq!(values[30]["name"], "fSlaveAccEff");
    let table = &plan["table"];
    assert_eq!((&table["id"], &table["rows"]), (&254.into(), &3.into()));
    assert_eq!(table["table_type"], "motion-function");
    assert_eq!(plan["synchronous"]["ratio"], 1.0);
}

#[test]
fn a_refusal_is_told_in_full_and_fails() {
    let file = SAW.shipped("saw-position-2-checked.toml");
    let output = SAW.run(&["plan", &file, "--json"]);
    assert_eq!(output.status.code(), Some(4));
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let refusal = &answer["refusal"];
    assert_eq!(refusal["code"], 0x4377);
    let violation = &refusal["violation"];
    assert_eq!(violation["checked_by"], "undershoot-pos");
    assert_eq!(violation["limit"], -500.0);
    assert_eq!(violation["unit"], "mm");
    printed(number(&violation["measured"]), "-620.638");
    printed(number(&violation["excess"]), "120.638");
    let accepted = plan("saw-position-2.toml");
    assert_eq!(
        number(&violation["master_position"]),
        value(&accepted, "fMPosAtSPosMin")
    );

    let output = SAW.run(&["plan", &file]);
    assert_eq!(output.status.code(), Some(4));
    let said = text(&output.stdout);
    assert!(said.contains("refused: 0x4377: "), "{said}");
    assert!(said.contains("undershoot-pos"), "{said}");
}

#[test]
fn a_remedy_passes_when_it_is_applied() {
    let file = SAW.shipped("too-close.toml");
    let output = SAW.run(&["plan", &file, "--json"]);
    assert_eq!(output.status.code(), Some(4));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let remedy = &answer["refusal"]["remedy"];
    let distance = number(&remedy["master_distance"]);
    let speed = number(&remedy["master_speed"]);
    assert!(distance > 200.0 && speed < 500.0);

    let given = std::fs::read_to_string(&file).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let passes = |from: &str, to: &str| {
        let changed = given.replace(from, to);
        assert_ne!(changed, given);
        let changed = written(folder.path(), "changed.toml", changed.as_bytes());
        SAW.run(&["plan", changed.to_str().expect("a plain path")])
            .status
            .success()
    };
    let sync = "master-sync-position = 200";
    let at = |distance: f64| format!("master-sync-position = {distance}");
    assert!(passes(sync, &at(distance)));
    assert!(!passes(sync, &at(distance * 0.999)));
    let velocity = "velocity = 500";
    let at = |speed: f64| format!("velocity = {speed}");
    assert!(passes(velocity, &at(speed)));
    assert!(!passes(velocity, &at(speed * 1.001)));
}

#[test]
fn a_plot_is_written_where_it_is_wanted() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("plot.html");
    let page_name = page.to_str().unwrap();
    let output = SAW.run(&["plot", &SAW.shipped("saw-velocity-1.toml"), "-o", page_name]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(text(&output.stdout), format!("plot: {page_name}\n"));
    let text_of_page = std::fs::read_to_string(&page).unwrap();
    assert!(text_of_page.contains("id=\"saw-figure\"") && text_of_page.ends_with("</html>\n"));
    assert!(text_of_page.len() < 200_000, "{}", text_of_page.len());

    std::fs::remove_file(&page).unwrap();
    let refused = SAW.run(&["plot", &SAW.shipped("too-close.toml"), "-o", page_name]);
    assert_eq!(refused.status.code(), Some(4));
    assert!(text(&refused.stdout).contains("refused: "));
    assert!(!page.exists());
    let good = SAW.shipped("saw-velocity-1.toml");
    SAW.refused(&["plot", &good, "-o", "/no/such/plot.html"], "cannot write");
}

#[test]
fn a_broken_file_fails_every_command_with_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    let good = std::fs::read_to_string(SAW.shipped("saw-position-1.toml")).unwrap();
    let with = |from: &str, to: &str| {
        let changed = good.replace(from, to);
        assert_ne!(changed, good, "{from}");
        changed.into_bytes()
    };
    let mask = |name: &str| {
        with(
            "[gear-in-pos]",
            &format!("[gear-in-pos]\nsync-mode.mask = ['{name}']"),
        )
    };
    for (name, bytes, expected) in [
        (
            "nan",
            with("position = -500", "position = nan"),
            "master.position: received NaN",
        ),
        (
            "sync-nan",
            with("master-sync-position = 1000", "master-sync-position = nan"),
            "0x4b06: master-sync-position: received NaN",
        ),
        (
            "check",
            mask("max-speed"),
            "gear-in-pos.sync-mode.mask[0]: received the text \"max-speed\", expected one of min-pos",
        ),
        (
            "denominator",
            with("numerator = 1", "numerator = 1, denominator = 0"),
            "0x4b06: ratio denominator 0",
        ),
        (
            "ratio",
            with("numerator = 1", "numerator = 0"),
            "0x421b: ratio numerator 0",
        ),
        (
            "missing",
            with("velocity = 500\n", ""),
            "master.velocity: missing, expected a number: velocity, u/s",
        ),
        (
            "unknown",
            with("[slave]", "[slave]\nspeed = 1"),
            "slave.speed: unknown field `speed`",
        ),
        (
            "limit",
            with("jerk = 50000", "jerk = 0"),
            "axis.jerk: received 0, expected a finite number above 0",
        ),
        (
            "command-limit",
            with("jerk = 5000 ", "jerk = -5 "),
            "0x42dd: jerk: received -5",
        ),
        (
            "axis-id",
            with("slave-axis = 2", "slave-axis = 256"),
            "slave-axis: 0x4a00: axis id 256, expected 1 to 255",
        ),
        (
            "angle",
            with("slave-axis = 2", "angle-degrees = 90"),
            "angle-degrees: 0x4b06: angle 90°",
        ),
        (
            "syntax",
            b"[master]\nposition = = 1\n".to_vec(),
            "syntax.toml:2:12: is not valid TOML: ",
        ),
        (
            "binary",
            vec![0, 159, 146, 150, 255, 0, 7],
            "cannot be read",
        ),
    ] {
        let file = written(folder.path(), &format!("{name}.toml"), &bytes);
        let file = file.to_str().unwrap();
        SAW.refused(&["plan", file], expected);
        SAW.refused(&["plot", file, "-o", "/no/such/plot.html"], expected);
    }
    let empty = written(folder.path(), "empty.toml", b"");
    let output = SAW.run(&["plan", empty.to_str().unwrap()]);
    let said = text(&output.stderr);
    let missing: Vec<_> = said
        .lines()
        .filter_map(|line| line.split(": ").nth(2))
        .collect();
    assert_eq!(missing, ["master", "slave", "axis"], "{said}");
    SAW.refused(
        &["plan", "no/such/saw.toml"],
        "no/such/saw.toml: cannot be read",
    );
}

#[test]
fn a_wrong_command_says_what_is_wrong() {
    for (arguments, expected) in [
        (vec!["plan"], "<FILE>"),
        (vec!["plot", "saw.toml"], "--output"),
        (vec!["cut"], "cut"),
    ] {
        let output = SAW.run(&arguments);
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(expected));
    }
}
