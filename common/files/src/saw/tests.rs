use coaxle_saw::{GearInSyncMode, Ratio, SawForm, SyncMask};

use super::*;

/// A file with additions by the test at its beginning and its end.
fn saw(head: &str, tail: &str) -> String {
    format!(
        "{head}\n\
         [master]\nposition = 0\nvelocity = 100\n\
         [slave]\nposition = 10\nvelocity = 0\n\
         [axis]\nvelocity = 500\nacceleration = 2000\njerk = 20000\n\
         {tail}"
    )
}

const VELO: &str = "[gear-in-velo]\nratio.numerator = 1";
const POS: &str =
    "[gear-in-pos]\nratio.numerator = 1\nmaster-sync-position = 200\nslave-sync-position = 110\n";

fn parse(text: &str) -> Result<SawFile, ConfigError> {
    SawFile::parse("saws/t.toml", text)
}

fn refusal(text: &str) -> String {
    parse(text).expect_err("no saw").to_string()
}

#[test]
fn a_file_is_a_moment_and_a_command() {
    let head = "title = 'x'\nmaster-unit = 'mm'\nslave-axis = 3";
    let tail = format!(
        "min-position = -5\n[encoder]\nscaling = 0.01\ncycle-time-us = 2000\n{POS}\
         sync-mode.mask = ['max-velo', 'rollback-lock']\nlimits.jerk = 5000"
    );
    let saw = parse(&saw(head, &tail)).unwrap();
    // 253 is the table of axis 3: 256 − 3.
    assert_eq!((saw.title.as_str(), saw.table_id), ("x", 253));
    assert_eq!(
        (saw.master_unit.as_str(), saw.slave_unit.as_str()),
        ("mm", "u")
    );
    let moment = &saw.moment;
    assert_eq!(moment.master.velocity, 100.0);
    assert_eq!(moment.slave.position, 10.0);
    assert_eq!(moment.axis.dynamics.deceleration(), 2000.0);
    assert_eq!(moment.axis.min_position, Some(-5.0));
    assert_eq!(moment.axis.max_position, None);
    assert_eq!(moment.encoder.unwrap().cycle.0, 0.002);
    let SawCommand::GearInPos(command) = &saw.command else {
        panic!("a synchronisation to position was written");
    };
    let mask = SyncMask::MAX_VELO | SyncMask::ROLLBACK_LOCK;
    assert_eq!(command.sync_mode.mask, mask);
    assert_eq!(command.limits.jerk, Some(5000.0));
    assert_eq!(command.limits.velocity, None);
    assert_eq!(saw.plan().unwrap().form(), SawForm::Quintic);
}

#[test]
fn a_change_of_velocity_may_be_over_time() {
    let tail = format!("{VELO}\nsync-mode.base = 'time-based'");
    let saw = parse(&saw("", &tail)).unwrap();
    let SawCommand::GearInVelo(command) = &saw.command else {
        panic!("a synchronisation to velocity was written");
    };
    assert_eq!(command.sync_mode.base, GearInSyncMode::TimeBased);
    assert_eq!(command.ratio, Ratio::of(1.0));
    assert_eq!(saw.plan().unwrap().form(), SawForm::JerkPhases);
}

#[test]
fn an_angle_makes_the_gear_steeper() {
    let tail = "[gear-in-velo]\nratio = { numerator = 3, denominator = 2 }";
    let saw = parse(&saw("angle-degrees = 60", tail)).unwrap();
    // 1.5 / cos 60°.
    let ratio = saw.plan().unwrap().line().ratio;
    assert!((ratio - 3.0).abs() < 1e-14, "{ratio}");
}

#[test]
fn a_start_distance_is_waited_for() {
    let text = saw("", &format!("{POS}master-start-distance = 50"));
    let waiting = parse(&text).unwrap();
    let plan = waiting.plan().unwrap();
    // 50 before the synchronous position of 200.
    assert_eq!(plan.master_start(), 150.0);
    // Another motion of the master would belong to another moment.
    let SawRemedy {
        master_distance,
        master_speed,
        ..
    } = waiting.remedy();
    assert_eq!((master_distance, master_speed), (None, None));
    let at_once = parse(&saw("", POS)).unwrap().plan().unwrap();
    assert_eq!(at_once.master_start(), 0.0);
}

#[test]
fn a_refused_command_has_a_remedy() {
    let tail = format!("{POS}limits.jerk = 100\nsync-mode.mask = ['max-jerk']");
    let refused = parse(&saw("", &tail)).unwrap();
    assert_eq!(refused.plan().unwrap_err().code(), 0x42df);
    let remedy = refused.remedy();
    assert!(
        remedy
            .master_distance
            .is_some_and(|distance| distance != 200.0)
    );
    // The jerk grows with v³ / d²: time is d / v, and the jerk v over its square.
    assert!(remedy.master_speed.is_some_and(|speed| speed < 100.0));
}

#[test]
fn errors_name_the_field_what_was_received_and_what_is_expected() {
    for (text, expected) in [
        ("", "t.toml: master: missing"),
        (&saw("", ""), "command: received none, expected either"),
        (&saw("", &format!("{POS}{VELO}")), "command: received both"),
        (
            &saw("", VELO).replace("velocity = 100", "velocity = inf"),
            "master.velocity: received inf, expected a finite number",
        ),
        (
            &saw("", VELO).replace("velocity = 0", ""),
            "slave.velocity: missing",
        ),
        (
            &saw("", &format!("min-position = 5\nmax-position = 5\n{VELO}")),
            "axis.max-position: received 5, expected above min-position, which is 5",
        ),
        (
            &saw("", &format!("deceleration = -1\n{VELO}")),
            "axis.deceleration: received -1, expected a finite number above 0",
        ),
        (
            &saw("slave-axis = 0", VELO),
            "slave-axis: 0x4a00: axis id 0, expected 1 to 255",
        ),
        (
            &saw("angle-degrees = -90", VELO),
            "angle-degrees: 0x4b06: angle -90°, expected a finite angle other than ±90°",
        ),
        (
            &saw(
                "",
                &format!("[encoder]\nscaling = 1\ncycle-time-us = 1\n{VELO}"),
            ),
            "encoder.cycle-time-us: received 1, expected 100 to 100000 µs",
        ),
        (
            &saw("", &format!("{VELO}\nmaster-sync-position = 1")),
            "gear-in-velo.master-sync-position: unknown field `master-sync-position`",
        ),
        (
            &saw("", &format!("{VELO}\nsync-mode.base = 'timed'")),
            "gear-in-velo.sync-mode.base: received \"timed\", expected",
        ),
        (
            &saw("", &format!("{VELO}\nratio.denominator = -1")),
            "gear-in-velo.ratio.denominator: received -1",
        ),
        (
            // Column 10: the second equals sign.
            "title = 'x'\n\nmaster = = 1",
            "t.toml:3:10: is not valid TOML: ",
        ),
    ] {
        let message = refusal(text);
        assert!(message.starts_with("saws/t.toml:"), "{message}");
        assert!(message.contains(expected), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

#[test]
fn a_file_that_is_no_text_is_refused() {
    for path in ["no/such.toml", "/"] {
        let error = SawFile::load(Path::new(path)).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{path}: cannot be read: ")));
    }
}
