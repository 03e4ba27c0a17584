//! Commands that README and docs show: the tool knows each of them, and those that need no other node end well.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use clap::Parser;
use coaxle::cli::Cli;
use coaxle_lab::catalog;

use crate::shared::text;

const CHECKOUT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// A text that begins like a command: WIRE.md, keys of timing channels.
const KEY_TEXT: &str = "coaxle timing channel 1";

/// A command of a page.
#[derive(Debug)]
struct DocumentedCommand {
    /// The page and the line that it begins in.
    place: String,
    /// From `coaxle` on.
    words: Vec<String>,
    /// File that its output goes to.
    to: Option<String>,
}

#[test]
fn every_documented_command_is_one_that_the_tool_knows() {
    let mut wrong = Vec::new();
    let mut known = 0;
    for page in pages() {
        for command in in_blocks(&page).into_iter().chain(in_sentences(&page)) {
            known += 1;
            // Of a placeholder nothing is known, but the names before it are.
            let words = command.words.iter().filter(|word| !word.contains('…'));
            let parsed = Cli::try_parse_from(words).map(drop);
            let error = parsed.as_ref().err().and_then(real);
            wrong.extend(error.map(|error| format!("{}: {error}", command.place)));
            wrong.extend(unknown_scenario(&command));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} wrong\n{}",
        wrong.len(),
        wrong.join("\n")
    );
    assert!(known > 150, "{known} commands found");
}

#[test]
fn documented_commands_that_need_no_other_node_end_well() {
    let mut ran = 0;
    for page in pages() {
        // Of each page its own folder: a reader follows one from the top down.
        let folder = tempfile::tempdir().expect("a scratch folder");
        for inside in ["scenarios", "sender", "receiver"] {
            let from = Path::new(CHECKOUT).join(inside);
            std::os::unix::fs::symlink(from, folder.path().join(inside)).expect("a link");
        }
        for command in in_blocks(&page).into_iter().filter(needs_no_node) {
            run(&command, folder.path());
            ran += 1;
        }
    }
    assert!(ran >= 25, "{ran} commands ran");
}

fn run(command: &DocumentedCommand, folder: &Path) {
    let to = command.to.as_ref().map_or_else(Stdio::piped, |file| {
        File::create(folder.join(file))
            .expect("a scratch file")
            .into()
    });
    let ended = Command::new(env!("CARGO_BIN_EXE_coaxle"))
        .args(
            command.words[1..]
                .iter()
                .flat_map(|word| expanded(word, folder)),
        )
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(to)
        .output()
        .expect("the tool starts");
    let (said, complaint) = (text(&ended.stdout), text(&ended.stderr));
    assert!(
        ended.status.success(),
        "{}: {}: {}\n{said}{complaint}",
        command.place,
        command.words.join(" "),
        ended.status
    );
}

/// A word, or the files that it stands for by a star in their name, as of a shell.
fn expanded(word: &str, folder: &Path) -> Vec<String> {
    let Some((before, after)) = word.split_once('*') else {
        return vec![word.to_owned()];
    };
    let files = fs::read_dir(folder.join(before)).expect("a folder before the star");
    let names = files.map(|file| {
        file.expect("a file")
            .file_name()
            .to_string_lossy()
            .into_owned()
    });
    let fitting = names.filter(|name| name.ends_with(after));
    fitting.map(|name| format!("{before}{name}")).collect()
}

/// True if a command works on files alone, and takes moments.
fn needs_no_node(command: &DocumentedCommand) -> bool {
    let words: Vec<&str> = command.words.iter().map(String::as_str).collect();
    match &words[1..] {
        ["cam" | "saw" | "gear", kind, ..] => *kind != "edit",
        ["list" | "show" | "example" | "schema", ..] | ["secure", "init", ..] => true,
        ["init", rest @ ..] => !rest.is_empty(),
        ["gateway" | "opcua" | "receiver" | "sender", .., "--check"] => !words[2].starts_with('/'),
        _ => false,
    }
}

/// README and the pages, with their text.
fn pages() -> Vec<(String, String)> {
    let folder = fs::read_dir(Path::new(CHECKOUT).join("docs")).expect("the docs");
    let mut files: Vec<PathBuf> = folder
        .map(|entry| entry.expect("the docs").path())
        .collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "md"));
    files.push(Path::new(CHECKOUT).join("README.md"));
    files.sort();
    let read = |file: PathBuf| {
        let name = file.file_name().expect("a name").to_string_lossy();
        let text = fs::read_to_string(&file).expect("a page");
        (name.into_owned(), text)
    };
    files.into_iter().map(read).collect()
}

/// Commands of the blocks of a page that are for a shell.
fn in_blocks((name, text): &(String, String)) -> Vec<DocumentedCommand> {
    let mut commands = Vec::new();
    let mut is_shell = false;
    let mut continued = String::new();
    for (line, content) in text.lines().enumerate() {
        if let Some(kind) = content.strip_prefix("```") {
            is_shell = !is_shell && kind == "sh";
        } else if let Some(part) = content.strip_suffix('\\').filter(|_| is_shell) {
            continued.push_str(part);
        } else if is_shell {
            let whole = std::mem::take(&mut continued) + content;
            commands.extend(commands_of(&whole, &format!("{name}:{}", line + 1)));
        }
    }
    commands
}

/// Commands in the sentences of a page, each between two backticks.
fn in_sentences((name, text): &(String, String)) -> Vec<DocumentedCommand> {
    let mut commands = Vec::new();
    for (line, content) in text.lines().enumerate() {
        let place = format!("{name}:{}", line + 1);
        for code in content.split('`').skip(1).step_by(2) {
            if code.starts_with("coaxle ") && code != KEY_TEXT {
                // In a table, a bar is masked.
                commands.extend(commands_of(&code.replace("\\|", "|"), &place));
            }
        }
    }
    commands
}

/// Commands of this tool in a line of a shell.
fn commands_of(line: &str, place: &str) -> Vec<DocumentedCommand> {
    let Some(words) = shlex::split(line) else {
        return Vec::new();
    };
    let mut parts = vec![Vec::new()];
    for word in words {
        let ends = word.strip_suffix(';').map(str::to_owned);
        let is_between = matches!(word.as_str(), "&&" | "&" | "|" | ";");
        if let (false, Some(part)) = (is_between, parts.last_mut()) {
            part.push(ends.clone().unwrap_or(word));
        }
        if is_between || ends.is_some() {
            parts.push(Vec::new());
        }
    }
    let command = |part: Vec<String>| {
        let begin = usize::from(part.first()? == "sudo");
        (part.get(begin)? == "coaxle").then_some(())?;
        let mut words = part[begin..].iter();
        let own = words.by_ref().take_while(|word| *word != ">").cloned();
        Some(DocumentedCommand {
            place: place.to_owned(),
            words: own.collect(),
            to: words.next().cloned(),
        })
    };
    parts.into_iter().filter_map(command).collect()
}

/// Fault of a command line; none if it asks for help, stops where a placeholder was, or needs something of the reader's own.
fn real(error: &clap::Error) -> Option<String> {
    use clap::error::ErrorKind;
    let text = error.to_string();
    let value = text.split('\'').nth(1).unwrap_or_default();
    let is_placeholder = !value.is_empty() && value.chars().all(|c| c.is_ascii_uppercase());
    let is_fine = match error.kind() {
        ErrorKind::DisplayHelp
        | ErrorKind::DisplayVersion
        | ErrorKind::MissingRequiredArgument
        | ErrorKind::MissingSubcommand
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => true,
        ErrorKind::ValueValidation => is_placeholder,
        _ => false,
    };
    let first = text.lines().next().unwrap_or_default();
    (!is_fine && !first.contains("cannot be read")).then(|| first.to_owned())
}

/// A scenario that a command plays or shows, if there is none of that name.
fn unknown_scenario(command: &DocumentedCommand) -> Option<String> {
    let words: Vec<&str> = command.words.iter().map(String::as_str).collect();
    let ["coaxle", "run" | "show" | "sweep", name, ..] = words[..] else {
        return None;
    };
    // A file of the reader's own, a placeholder, an option.
    let is_name = name
        .chars()
        .all(|c| c.is_ascii_lowercase() || "-/0123456789".contains(c));
    let is_unknown = is_name && !name.starts_with('-') && catalog::find(name).is_err();
    is_unknown.then(|| format!("{}: there is no scenario {name}", command.place))
}
