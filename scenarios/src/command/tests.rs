use super::*;
use clap::Parser;
use coaxle_axis::{Awaits, AxisStatus};
use coaxle_node::command::{CommandOutcome, FarRefusal, NotTaken};
use coaxle_slave as slave;
use coaxle_slave::{Dynamics, Refusal};

#[derive(Debug, Parser)]
struct Cli {
    #[command(flatten)]
    args: CommandArgs,
}

fn parsed(line: &[&str]) -> Result<CommandArgs, clap::Error> {
    let line = ["command", "saw", "carriage"].iter().chain(line);
    Cli::try_parse_from(line).map(|cli| cli.args)
}

#[test]
fn commands_are_spelled_out_or_given_as_json() {
    let expected = slave::Command::MoveAbsolute {
        position: -100.0,
        velocity: Some(200.0),
        dynamics: Dynamics {
            jerk: Some(5e3),
            ..Dynamics::default()
        },
    };
    let json = r#"{ "move-absolute": { "position": -100, "velocity": 200, "dynamics": { "jerk": 5e3 } } }"#;
    for line in [
        &[
            "move-absolute",
            "--position",
            "-100",
            "--velocity=200",
            "--jerk",
            "5e3",
            "--dry-run",
        ][..],
        &["--dry-run", "--order", json],
    ] {
        let args = parsed(line).unwrap();
        let CommandOrder::Slave(order) = args.order().unwrap() else {
            panic!("another order");
        };
        assert_eq!(order.command, expected);
        assert!(args.dry_run && order.dry_run);
        assert_eq!(
            (args.node.as_str(), args.slave.map(String::from)),
            ("saw", Some("carriage".to_owned()))
        );
    }
}

#[test]
fn exactly_one_command_is_expected() {
    for (line, expected) in [
        (&[][..], "expected a command"),
        (
            &["--order", "{\"halt\":{}}", "reset"][..],
            "expected one of them",
        ),
        (&["--order", "{\"dance\":{}}"][..], "dance"),
    ] {
        let error = parsed(line).unwrap().order().unwrap_err();
        assert!(format!("{error:#}").contains(expected), "{error:#}");
    }
}

#[test]
fn answers_are_one_line() {
    let order = SlaveOrder {
        slave: SlaveName::new("carriage").unwrap(),
        command: slave::Command::Reset {},
        dry_run: false,
    };
    let slave = SlaveView {
        status: AxisStatus::Standstill,
        coupling: None,
        position: 12.5,
        velocity: 0.0,
    };
    let refusal = Refusal::NoMaster;
    for (dry_run, outcome, expected) in [
        (
            false,
            CommandOutcome::Accepted {
                job: Some(7),
                awaits: Awaits::JUMP | Awaits::FINITE,
                slave,
                sync_positions: None,
                saw: None,
            },
            "accepted, job 7; checked when it is due: no-jump, finite; the slave is in standstill at 12.5, velocity 0",
        ),
        (
            true,
            CommandOutcome::Refused {
                refusal,
                slave,
                saw: None,
            },
            "would be refused, 0x4b09: no master to couple to; the slave is in standstill",
        ),
        (
            false,
            CommandOutcome::NotTaken(NotTaken::NoSlaves),
            "not taken: the node has no slaves",
        ),
    ] {
        let order = SlaveOrder { dry_run, ..order }.into();
        let words = in_words(&CommandAnswer::new(&order, &outcome));
        assert!(words.starts_with(expected), "{words}");
    }
}

fn far(line: &[&str]) -> Result<CommandOrder, String> {
    let line = ["command", "saw", "--far", "belt"].iter().chain(line);
    let cli = Cli::try_parse_from(line).map_err(|error| error.to_string())?;
    cli.args.order().map_err(|error| format!("{error:#}"))
}

#[test]
fn a_far_node_is_commanded_with_far_and_a_slave_without() {
    let expected = FarOrder {
        far: FarName::new("belt").unwrap(),
        command: FarCommand::FilterMode(Mode::Pt1.into()),
        dry_run: true,
    };
    for line in [
        &["filter-mode", "pt1", "--dry-run"][..],
        &["--dry-run", "--order", "{ \"filter-mode\": \"pt1\" }"],
    ] {
        assert_eq!(far(line), Ok(expected.into()));
    }
    let error = far(&["halt"]).unwrap_err();
    assert!(error.contains("expected a slave for it"), "{error}");
    let error = parsed(&["disable"]).unwrap().order().unwrap_err();
    assert!(error.to_string().contains("expected --far"), "{error}");
    assert!(far(&["carriage", "halt"]).is_err(), "not both");
    assert!(Cli::try_parse_from(["command", "saw", "halt"]).is_err());
}

#[test]
fn answers_about_far_nodes_too() {
    let order = far(&["disable"]).unwrap();
    let view = FarView {
        enabled: true,
        mode: Mode::Sync.into(),
        synced: false,
        delay: FarDelay::FixedUs(120.5),
    };
    let state = "the far node is enabled, mode sync, not synchronised, delay 120.5 µs";
    for (outcome, expected) in [
        (
            CommandOutcome::FarAccepted { far: view },
            format!("accepted; {state}"),
        ),
        (
            CommandOutcome::FarRefused {
                refusal: FarRefusal::Delay { received: 2e6 },
                far: view,
            },
            format!(
                "refused, 0x4b56: fixed-us: received 2000000, expected a number from -1000000 to \
                 1000000; {state}"
            ),
        ),
    ] {
        assert_eq!(in_words(&CommandAnswer::new(&order, &outcome)), expected);
    }
}
