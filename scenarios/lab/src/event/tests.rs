use super::*;
use coaxle_axis::{Awaits, AxisStatus};
use coaxle_node::command::{CommandOutcome, SlaveView};
use coaxle_node::config::parse;
use coaxle_slave::Refusal;

fn event(text: &str) -> Result<Event, String> {
    parse::<Event>("e", text).map_err(|error| error.to_string())
}

const HALT: &str = "at-s = 1.5\nnode = 'saw'\nslave = 'carriage'\ncommand = { halt = {} }";

#[test]
fn an_event_is_written_as_it_is_read() {
    for text in [
        "at-s = 1\nnode = 'saw'\naction = 'freeze'\nfor-s = 0.5",
        HALT,
        &format!("{HALT}\nexpect-refusal = 0x422a\ndry-run = true"),
        "at-s = 1\nnode = 'saw'\nslave = 'knife'\ncommand = { cam-info = { table = 1 } }",
        "at-s = 1\nnode = 'saw'\nslave = 'knife'\ncommand = { cam-table-select = { table = 1, plate = { point = [{ law = \
         'polynom5', master = 0, slave = 0 }, { master = 1, slave = 1 }] } } }",
        "at-s = 1\nnode = 'saw'\nfar = 'belt'\ncommand = { filter-mode = 'pt1' }",
        "at-s = 1\nnode = 'saw'\nfar = 'belt'\ncommand = { set-parameters = { time-sync = { age-of-data-limit = 9 } } }",
        "at-s = 1\nnode = 'saw'\nfar = 'belt'\ncommand = { set-delay = { fixed-us = 12.5 } }",
    ] {
        let read = event(text).unwrap();
        let written = toml::to_string(&read).unwrap();
        assert_eq!(event(&written), Ok(read));
    }
}

#[test]
fn times_are_written_as_people_write_them() {
    // Every millisecond of twenty seconds: a division is exact for some and not for others.
    for millis in 0..20_000 {
        let seconds = f64::from(ScenarioTime { millis });
        assert_eq!(ScenarioTime::try_from(seconds), Ok(ScenarioTime { millis }));
        let decimals = seconds
            .to_string()
            .split_once('.')
            .map_or(0, |(_, d)| d.len());
        assert!(decimals <= 3, "{seconds}");
    }
}

#[test]
fn a_command_is_for_who_it_can_be_for() {
    let head = "at-s = 1\nnode = 'saw'\n";
    for (rest, expected) in [
        ("slave = 'x'\ncommand = { disable = {} }", "far beside"),
        ("far = 'x'\ncommand = { halt = {} }", "slave beside"),
        (
            "far = 'x'\nslave = 'x'\ncommand = { halt = {} }",
            "slave beside",
        ),
        ("slave = 'x'\ncommand = { dance = {} }", "dance"),
        (
            "slave = 'x'\ncommand = { home = { position = 'x' } }",
            "command.home.position",
        ),
        (
            "far = 'x'\ncommand = { set-parameters = { time-sync = { age = 1 } } }",
            "command.set-parameters.time-sync.age",
        ),
        ("far = 'x'\ncommand = 'disable'", "a command, such as"),
    ] {
        let error = event(&format!("{head}{rest}")).unwrap_err();
        assert!(error.contains(expected), "{rest}: {error}");
    }
}

#[test]
fn half_of_an_event_is_none() {
    for text in [
        "at-s = 1\nnode = 'saw'",
        "at-s = 1\nnode = 'saw'\naction = 'freeze'",
        "at-s = 1\nnode = 'saw'\nslave = 'carriage'",
        &format!("{HALT}\nfor-s = 1"),
    ] {
        let error = event(text).unwrap_err();
        assert!(
            error.contains("expected either action and for-s"),
            "{error}"
        );
    }
}

#[test]
fn a_command_meets_what_is_expected_of_it() {
    let slave = SlaveView {
        status: AxisStatus::Disabled,
        coupling: None,
        position: 0.0,
        velocity: 0.0,
    };
    let refusal = Refusal::NoMaster;
    let outcomes = [
        Some(CommandOutcome::Accepted {
            job: None,
            awaits: Awaits::empty(),
            slave,
            sync_positions: None,
            saw: None,
        }),
        Some(CommandOutcome::Refused {
            refusal,
            slave,
            saw: None,
        }),
        None,
    ];
    for (text, expected) in [
        (HALT.to_owned(), [true, false, false]),
        (
            format!("{HALT}\nexpect-refusal = 0x4b09"),
            [false, true, false],
        ),
        (
            format!("{HALT}\nexpect-refusal = 0x4b05"),
            [false, false, false],
        ),
    ] {
        let event = event(&text).unwrap();
        let EventKind::Command(commanded) = &event.what else {
            panic!("no command");
        };
        let met = outcomes.map(|outcome| {
            let answer = outcome.map(|o| CommandAnswer::new(&commanded.order, &o));
            commanded.judge(&event, answer.as_ref()).met
        });
        assert_eq!(met, expected, "{text}");
    }
    let event = event(HALT).unwrap();
    let EventKind::Command(commanded) = &event.what else {
        panic!("no command");
    };
    let verdict = commanded.judge(&event, None);
    let text = "saw.carriage.MC_Halt at 1.5 s is \"no answer\", expected accepted";
    assert_eq!(verdict.to_string(), text);
}
