//! The language of the code, in figures: how doc comments open, words that the glossary replaces, type names that stand for several
//! things, how often code says why, and how large files are.
//!
//! What the bounds come from is in `docs/CONTRIBUTING.md`: the same figures of ntpd-rs, statime, str0m, quinn, smoltcp, ethercrab
//! and Zenoh.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Words with which a subordinate clause begins: a comment that opens so has no noun and no verb of its own.
const CLAUSES: [&str; 10] = [
    "What", "Whether", "How", "Who", "Whose", "Which", "Where", "When", "Why", "Whatever",
];

/// Words that stand for a noun which the comment does not name.
const PRONOUNS: [&str; 16] = [
    "It",
    "Its",
    "One",
    "None",
    "Of",
    "They",
    "Their",
    "These",
    "Those",
    "This",
    "That",
    "Nothing",
    "Something",
    "All",
    "Each",
    "Both",
];

/// Left column of the glossary, as far as a word alone is enough to tell.
const REPLACED: [&str; 12] = [
    "so many",
    "anew",
    "whoever",
    "what becomes of",
    "how it goes with",
    "told",
    "stands against",
    "gives out",
    "looks on",
    "clerk",
    "two-senders",
    "pretend",
];

/// A file of the workspace, tests left out.
pub(crate) struct Source {
    pub(crate) path: String,
    pub(crate) text: String,
}

/// The figures of a set of files.
#[derive(Default)]
pub(crate) struct Figures {
    pub(crate) doc_comments: usize,
    /// Doc comments that open with a subordinate clause.
    pub(crate) clauses: Vec<String>,
    /// Doc comments that open with a pronoun.
    pub(crate) pronouns: Vec<String>,
    /// Doc comments that open with "The same".
    pub(crate) repetitions: Vec<String>,
    /// Comments with a word that the glossary replaces.
    pub(crate) replaced: Vec<String>,
    pub(crate) code_lines: usize,
    /// Lines of comments beside the code, which say why.
    pub(crate) reasons: usize,
    /// `let x = …; let x = x.map_err(…)?`: a name that is used twice for want of another.
    pub(crate) rebound: Vec<String>,
    pub(crate) files: usize,
    /// Files of more than 400 lines.
    pub(crate) long: Vec<String>,
    /// Type names that several files define, with these files.
    pub(crate) shared_names: Vec<String>,
    types: BTreeMap<String, BTreeSet<String>>,
}

/// Reads the sources below a folder; tests, benches and what is built are left out.
pub(crate) fn sources_below(folder: &Path, root: &Path, into: &mut Vec<Source>) {
    let entries = std::fs::read_dir(folder).expect("a readable folder");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("a readable folder").path())
        .collect();
    paths.sort();
    for path in paths {
        let name = path.file_stem().unwrap_or_default();
        // By name, for files and folders alike.
        if name == "tests" || name == "benches" || name == "target" || name == "fuzz" {
            continue;
        }
        if path.is_dir() {
            sources_below(&path, root, into);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = std::fs::read_to_string(&path).expect("readable source");
            let shown = path.strip_prefix(root).unwrap_or(&path);
            into.push(Source {
                path: shown.display().to_string(),
                text,
            });
        }
    }
}

impl Figures {
    pub(crate) fn of(sources: &[Source]) -> Self {
        let mut figures = Self::default();
        for source in sources {
            figures.add(source);
        }
        let shared = figures.types.iter().filter(|(_, files)| files.len() > 1);
        let line = |(name, files): (&String, &BTreeSet<String>)| {
            let files: Vec<_> = files.iter().map(String::as_str).collect();
            format!("{name}: {}", files.join(", "))
        };
        figures.shared_names = shared.map(line).collect();
        figures
    }

    /// Share of the doc comments, %.
    pub(crate) fn percent(&self, found: &[String]) -> f64 {
        100.0 * found.len() as f64 / self.doc_comments.max(1) as f64
    }

    /// Number per 10 000 lines of code.
    pub(crate) fn per_ten_thousand(&self, found: usize) -> f64 {
        1e4 * found as f64 / self.code_lines.max(1) as f64
    }

    fn add(&mut self, source: &Source) {
        self.files += 1;
        let lines = without_tests(&source.text);
        // Bound of the project for a file (docs/CONTRIBUTING.md).
        if lines.len() > 400 {
            self.long.push(source.path.clone());
        }
        let mut documents = false;
        for (number, line) in lines.iter().enumerate() {
            let place = || format!("{}:{}: {}", source.path, number + 1, line.trim());
            let line = line.trim();
            let comment = line.strip_prefix("//");
            let doc = comment.and_then(|rest| rest.strip_prefix(['/', '!']));
            // Only the first line opens a comment.
            if let (Some(doc), false) = (doc, documents) {
                self.opening(doc.trim_start(), place);
            }
            documents = doc.is_some();
            match comment {
                Some(comment) => {
                    self.reasons += usize::from(doc.is_none());
                    let comment = comment.to_lowercase();
                    let replaced = REPLACED.iter().any(|word| has_word(&comment, word));
                    if replaced {
                        self.replaced.push(place());
                    }
                }
                None if !line.is_empty() => {
                    self.code_lines += 1;
                    // A comment behind the code says why as well.
                    self.reasons += usize::from(line.contains(" // "));
                    if rebinds(line, &lines[number + 1..]) {
                        self.rebound.push(place());
                    }
                }
                None => {}
            }
            if let Some(name) = defined_type(line) {
                let files = self.types.entry(name.to_owned()).or_default();
                files.insert(source.path.clone());
            }
        }
    }

    fn opening(&mut self, text: &str, place: impl Fn() -> String) {
        self.doc_comments += 1;
        let first = text.split(|c: char| !c.is_alphanumeric()).next();
        let first = first.unwrap_or_default();
        if CLAUSES.contains(&first) {
            self.clauses.push(place());
        } else if PRONOUNS.contains(&first) {
            self.pronouns.push(place());
        } else if (text.strip_prefix("The same"))
            .is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        {
            self.repetitions.push(place());
        }
    }
}

/// The lines before the tests of a file.
fn without_tests(text: &str) -> Vec<&str> {
    let lines: Vec<_> = text.lines().collect();
    // Tests are the last item of a file; from there on nothing counts.
    let tests = lines
        .windows(2)
        .position(|pair| pair[0] == "#[cfg(test)]" && begins_module(pair[1]));
    let end = tests.unwrap_or(lines.len());
    lines[..end].to_vec()
}

/// Reports whether a line begins a module with its content, of any visibility.
fn begins_module(line: &str) -> bool {
    let item = match line.strip_prefix("pub") {
        Some(rest) if rest.starts_with('(') => rest.split_once(')').map_or(rest, |(_, item)| item),
        Some(rest) => rest,
        None => line,
    };
    item.trim_start().starts_with("mod ") && line.ends_with('{')
}

/// Reports whether a text has the words, with no letter directly before or behind them. Names in backticks are left out.
fn has_word(text: &str, words: &str) -> bool {
    // Every second piece lies between backticks.
    let plain: String = text.split('`').step_by(2).collect::<Vec<_>>().join(" ");
    let is_letter = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    plain.match_indices(words).any(|(at, _)| {
        let before = plain[..at].chars().next_back();
        let behind = plain[at + words.len()..].chars().next();
        !is_letter(before) && !is_letter(behind)
    })
}

/// Reports whether a line has a name that was put together from a generic type and its parameter.
pub(crate) fn has_generated_name(line: &str) -> bool {
    let mut words = line.split(|c: char| !c.is_alphanumeric() && c != '_');
    words.any(|word| {
        let ends = ["Atdouble", "Ofdouble", "_for_double", "Atf64", "Off64"];
        ends.iter()
            .any(|end| word.ends_with(end) && word.len() > end.len())
    })
}

/// Reports whether a line binds a name which one of the next three binds again to hand its error on.
fn rebinds(line: &str, next: &[&str]) -> bool {
    let Some((name, _)) = line
        .strip_prefix("let ")
        .and_then(|rest| rest.split_once(" = "))
    else {
        return false;
    };
    let again = format!("let {name} = {name}");
    next.iter()
        // The second binding follows closely; farther away it is another thing of that name.
        .take(3)
        .any(|line| line.trim().starts_with(&again) && line.contains("map_err"))
}

/// The name of the type that a line defines.
fn defined_type(line: &str) -> Option<&str> {
    let rest = match line.strip_prefix("pub") {
        Some(rest) if rest.starts_with('(') => rest.split_once(") ")?.1,
        Some(rest) => rest.trim_start(),
        None => line,
    };
    // At the beginning of a line without indentation: types within functions are nobody else's.
    let rest = ["struct ", "enum ", "trait "]
        .iter()
        .find_map(|kind| rest.strip_prefix(kind))?;
    let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_'))?;
    (end > 0).then(|| &rest[..end])
}

#[cfg(test)]
mod planted {
    use super::{Figures, Source, has_generated_name};

    fn of(text: &str) -> Figures {
        let source = |path: &str, text: &str| Source {
            path: path.to_owned(),
            text: text.to_owned(),
        };
        Figures::of(&[source("a.rs", text), source("b.rs", "struct Row;\n")])
    }

    #[test]
    fn an_opening_of_each_kind_is_found() {
        let found = of("/// What it is.\n/// What follows is one comment with it.\nfn a() {}\n");
        assert_eq!((found.doc_comments, found.clauses.len()), (1, 1));
        assert_eq!(of("//! It is one.\n").pronouns.len(), 1);
        assert_eq!(of("/// The same of two.\n").repetitions.len(), 1);
        assert!(of("/// The samekind.\n").repetitions.is_empty());
        // Whole words only.
        let plain = of("/// Whatsoever, onesided, thesaurus: words that only begin so.\n");
        assert!(plain.clauses.is_empty() && plain.pronouns.is_empty());
    }

    #[test]
    fn a_word_of_the_glossary_is_found_and_a_name_is_not() {
        assert_eq!(of("// There are so many of them.\n").replaced.len(), 1);
        assert_eq!(of("/// Refuses what it is told.\n").replaced.len(), 1);
        assert!(of("/// Calls `told`; a manewver.\n").replaced.is_empty());
        assert!(of("fn told() {}\n").replaced.is_empty());
    }

    #[test]
    fn a_name_of_two_types_is_found() {
        let names = of("pub(crate) struct Row {}\nenum Only {}\n").shared_names;
        assert_eq!(names, ["Row: a.rs, b.rs"]);
    }

    #[test]
    fn a_generated_name_is_found() {
        assert!(has_generated_name(
            "| `gear` | [GearInPosAtdouble](#gearinposatdouble) |"
        ));
        assert!(!has_generated_name(
            "two doubles, `double`, at double speed"
        ));
    }

    #[test]
    fn a_name_bound_twice_for_its_error_is_found() {
        let text = "    let file = open(path);\n    let file = file.map_err(Wrong::from)?;\n";
        assert_eq!(of(text).rebound.len(), 1);
        assert!(
            of("    let file = open(path).map_err(Wrong::from)?;\n")
                .rebound
                .is_empty()
        );
    }

    #[test]
    fn a_long_file_and_reasons_are_counted_without_the_tests_in_it() {
        let long = "fn a() {} // because\n".repeat(401);
        let found = of(&long);
        assert_eq!(
            (found.long.len(), found.reasons, found.code_lines),
            (1, 401, 402)
        );
        // A single reason before the tests, 401 in them.
        for visibility in ["", "pub ", "pub(crate) ", "pub(in crate::a) "] {
            let tested =
                format!("// why\nfn a() {{}}\n#[cfg(test)]\n{visibility}mod tests {{\n{long}}}\n");
            let found = of(&tested);
            assert_eq!((found.long.len(), found.reasons), (0, 1), "{visibility}");
        }
    }
}
