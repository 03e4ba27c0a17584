use super::*;

const FILE: &str = "title = 'x'\n[master]\nposition = 800\nvelocity = -200\n[slave]\nposition = 500\n\
    [axis]\nvelocity = 500\nacceleration = 5000\njerk = 100000\n\
    [flying-gear]\nratio = 1\nmaster-sync-position = 460\nslave-sync-position = 450\n\
    slave-desync-position = 450\nslave-stop-position = 500\n";

#[test]
fn a_file_is_a_gear_at_the_moment_it_is_enabled() {
    let file = GearFile::parse("t.toml", FILE).unwrap();
    assert_eq!((file.title.as_str(), file.master_unit.as_str()), ("x", "u"));
    // The deceleration is that of the acceleration by default, the cycle a millisecond.
    assert_eq!((file.limits.deceleration(), file.cycle.0), (5000.0, 1e-3));
    // The slave takes 50 u at half of the final velocity: the master comes from 100 u before 460, at falling positions.
    assert_eq!(file.gear().unwrap().start_position(), 560.0);
    // The slave would have to follow with 600, above its 500.
    let fast = FILE.replace("velocity = -200", "velocity = -600");
    assert_eq!(
        GearFile::parse("t.toml", &fast)
            .unwrap()
            .gear()
            .unwrap_err()
            .code(),
        0x42dd
    );
    // Falling positions: at 500 the master has passed 560.
    let past = FILE.replace("position = 800", "position = 500");
    assert_eq!(
        GearFile::parse("t.toml", &past)
            .unwrap()
            .gear()
            .unwrap_err()
            .code(),
        0x421a
    );
}

#[test]
fn errors_name_the_field_what_was_received_and_what_is_expected() {
    for (from, to, expected) in [
        (
            "velocity = -200",
            "velocity = inf",
            "master.velocity: received inf",
        ),
        (
            "jerk = 100000",
            "jerk = 0",
            "axis.jerk: received 0, expected a finite number above 0",
        ),
        ("ratio = 1", "", "flying-gear.ratio: missing"),
        ("ratio = 1", "ratio = 1\nangle = 3", "unknown field `angle`"),
        (
            "title = 'x'",
            "cycle-time-us = 1",
            "cycle-time-us: received 1, expected 100 to 100000 µs",
        ),
    ] {
        let error = GearFile::parse("t.toml", &FILE.replacen(from, to, 1))
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("t.toml:") && error.contains(expected),
            "{error}"
        );
    }
}
