//! Translations of the README: sections, commands, links and numbers are those of the English one.

use std::collections::BTreeSet;

use super::pages::Page;

const ENGLISH: &str = "README.md";
const TRANSLATIONS: [&str; 2] = ["README.de.md", "README.zh.md"];

fn page(name: &str) -> Page {
    Page::read(&std::fs::read_to_string(super::root().join(name)).expect("a README"))
}

#[test]
fn translations_are_made_from_the_english_readme() {
    let english = page(ENGLISH);
    // An empty page differs in nothing from an empty one.
    assert!(english.code.len() > 2 && english.table_numbers.len() > 10);
    let mut found = Vec::new();
    for name in TRANSLATIONS {
        let differences = differences(&english, &page(name)).into_iter();
        found.extend(differences.map(|difference| format!("{name}: {difference}")));
    }
    assert!(
        found.is_empty(),
        "change the translations with {ENGLISH}:\n{}",
        found.join("\n")
    );
}

#[test]
fn each_readme_links_the_other_languages() {
    let all = [ENGLISH].into_iter().chain(TRANSLATIONS);
    for name in all.clone() {
        let page = page(name);
        let linked: BTreeSet<_> = page.links.iter().map(|link| link.target.as_str()).collect();
        let languages: Vec<_> = all.clone().filter(|other| linked.contains(other)).collect();
        let others: Vec<_> = all.clone().filter(|other| *other != name).collect();
        assert_eq!(languages, others, "links of {name} to other languages");
    }
}

/// The kinds in which a translation differs from the English page, each with both values.
fn differences(english: &Page, translation: &Page) -> Vec<String> {
    let pairs = views(english).into_iter().zip(views(translation));
    let differing = pairs.filter(|(expected, received)| expected != received);
    differing
        .map(|((what, expected), (_, received))| {
            format!("{what}: {}", first_difference(&expected, &received))
        })
        .collect()
}

/// Parts of a page that are the same in all languages.
fn views(page: &Page) -> [(&'static str, Vec<String>); 5] {
    let levels = page
        .headings
        .iter()
        .map(|heading| heading.level.to_string());
    let mut numbers = page.numbers.clone();
    // A sentence in another language has them in another order.
    numbers.sort();
    [
        ("levels of headings", levels.collect()),
        ("commands", commands(page)),
        ("targets of links", targets(page)),
        ("numbers of tables", page.table_numbers.clone()),
        ("numbers of sentences", numbers),
    ]
}

/// The first place where two lists part.
fn first_difference(expected: &[String], received: &[String]) -> String {
    let same = expected.iter().zip(received).take_while(|(a, b)| a == b);
    let at = same.count();
    let entry = |list: &[String]| {
        list.get(at)
            .map_or("the end".to_owned(), |s| format!("{s:?}"))
    };
    format!(
        "entry {}: received {}, expected {}",
        at + 1,
        entry(received),
        entry(expected)
    )
}

/// The lines of the blocks of code without comments, which are translated.
fn commands(page: &Page) -> Vec<String> {
    let command = |line: &str| {
        // Within a word, the character begins no comment.
        let comment = line.starts_with('#').then_some(0);
        let end = comment.or_else(|| line.find(" #")).unwrap_or(line.len());
        line[..end].trim_end().to_owned()
    };
    let blocks = page.code.iter().enumerate();
    let lines = blocks.flat_map(|(block, code)| {
        code.lines()
            .map(move |line| format!("{}: {}", block + 1, command(line)))
    });
    lines.collect()
}

/// The targets of the links, except those of the line of languages.
fn targets(page: &Page) -> Vec<String> {
    let all = page.links.iter().map(|link| link.target.as_str());
    let content = all.filter(|target| *target != ENGLISH && !TRANSLATIONS.contains(target));
    let once: BTreeSet<_> = content.map(str::to_owned).collect();
    once.into_iter().collect()
}

#[cfg(test)]
mod planted {
    use super::{Page, differences};

    const TEXT: &str =
        "# A\n\n5 to [b](b.md)\n\n```sh\nrun a#b  # runs\n```\n\n## C\n\n| 1.5 | 2 |\n|--|--|\n";

    fn with(from: &str, to: &str) -> Vec<String> {
        assert!(TEXT.contains(from), "{from}");
        differences(&Page::read(TEXT), &Page::read(&TEXT.replace(from, to)))
    }

    #[test]
    fn words_comments_and_decimal_commas_may_differ() {
        let none: [String; 0] = [];
        assert_eq!(with("# runs", "# läuft"), none);
        assert_eq!(with("5 to [b](b.md)", "[B](b.md), 5. [A](README.md)"), none);
        assert_eq!(with("1.5", "1,5"), none);
    }

    #[test]
    fn a_difference_of_each_kind_is_found() {
        let cases = [
            (
                "## C",
                "### C",
                "levels of headings: entry 2: received \"3\", expected \"2\"",
            ),
            (
                "## C",
                "C",
                "levels of headings: entry 2: received the end, expected \"2\"",
            ),
            (
                "run a#b",
                "run a#c",
                "commands: entry 1: received \"1: run a#c\", expected \"1: run a#b\"",
            ),
            (
                "b.md",
                "c.md",
                "targets of links: entry 1: received \"c.md\", expected \"b.md\"",
            ),
            (
                "1.5",
                "1.6",
                "numbers of tables: entry 1: received \"1.6\", expected \"1.5\"",
            ),
            (
                "5 to",
                "6 to",
                "numbers of sentences: entry 1: received \"6\", expected \"5\"",
            ),
        ];
        for (from, to, expected) in cases {
            assert_eq!(with(from, to), [expected]);
        }
    }
}
