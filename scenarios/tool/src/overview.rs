//! Overview of the commands, in groups: the help of the tool.

use std::fmt::Write as _;

use clap::Command;

/// Groups of commands, with the most common ones first.
const GROUPS: [(&str, &[&str]); 6] = [
    (
        "Run",
        &[
            "demo", "sender", "receiver", "gateway", "ros2", "opcua", "run", "sweep", "soak",
        ],
    ),
    (
        "Look",
        &[
            "nodes",
            "status",
            "get",
            "why",
            "when",
            "audit",
            "wait-sync",
            "scope",
            "record",
            "info",
            "export",
            "replay",
            "recover",
        ],
    ),
    ("Command", &["command"]),
    (
        "Files",
        &[
            "init", "example", "list", "show", "check", "topology", "cam", "saw", "gear", "fmu",
            "signals", "schema",
        ],
    ),
    ("Measure", &["bench", "scale", "conform", "record-arrivals"]),
    ("Install", &["doctor", "secure", "completions", "man"]),
];

/// Width of the column of names.
// The longest name is `record-arrivals`, 15 letters.
const NAMES: usize = 17;

/// Adds the groups of its commands to the help of the tool.
pub(crate) fn in_groups(command: Command) -> Command {
    let groups = groups(&command);
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}Options:\n{{options}}{{after-help}}"
    );
    command.help_template(template)
}

fn groups(command: &Command) -> String {
    let mut text = String::new();
    for (heading, names) in GROUPS {
        text += heading;
        text += ":\n";
        for name in names {
            // From the command itself, so that overview and help cannot differ.
            let about = command.find_subcommand(name).and_then(Command::get_about);
            let about = about.map(ToString::to_string).unwrap_or_default();
            let _ = writeln!(text, "  {name:NAMES$}{}", in_short(&about));
        }
        text.push('\n');
    }
    text
}

/// The statement of a description, without the details behind it.
fn in_short(about: &str) -> &str {
    // Behind it are references to documents and conditions, which would break the column.
    let end = about.find([':', ';']).unwrap_or(about.len());
    &about[..end]
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use clap::CommandFactory;

    use super::*;
    use crate::cli::Cli;

    #[test]
    fn every_command_is_in_one_group() {
        let command = Cli::command();
        let shown = command
            .get_subcommands()
            .filter(|command| !command.is_hide_set());
        let shown: BTreeSet<_> = shown.map(Command::get_name).collect();
        let grouped: Vec<_> = GROUPS
            .iter()
            .flat_map(|(_, names)| *names)
            .copied()
            .collect();
        assert_eq!(grouped.len(), shown.len());
        assert_eq!(grouped.into_iter().collect::<BTreeSet<_>>(), shown);
    }

    #[test]
    fn the_overview_has_each_command_with_its_description() {
        let text = in_groups(Cli::command()).render_help().to_string();
        for line in [
            "Run:", "Look:", "Command:", "Files:", "Measure:", "Install:", "Options:",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}: {text}");
        }
        assert!(
            text.contains("  wait-sync        Wait until a receiver knows"),
            "{text}"
        );
        assert!(text.lines().count() < 80, "{text}");
    }
}
