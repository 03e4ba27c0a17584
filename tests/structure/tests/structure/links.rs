//! Links of the Markdown pages: each relative one leads to a file of the repository, each anchor to a heading, and the table of contents of
//! the docs to every page of them.

use std::collections::{BTreeMap, BTreeSet};

use super::pages::{self, Link, Page};

/// The table of contents of the docs.
const CONTENTS: &str = "docs/SUMMARY.md";

/// The Markdown pages among these files, by their paths.
fn pages_of(files: &BTreeSet<String>) -> BTreeMap<String, Page> {
    let names = files.iter().filter(|name| name.ends_with(".md"));
    let read = |name: &String| {
        let text = std::fs::read_to_string(super::root().join(name)).expect("a page");
        (name.clone(), Page::read(&text))
    };
    names.map(read).collect()
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let files = pages::tracked_files();
    let pages = pages_of(&files);
    let found = broken(&pages, &files);
    assert!(
        found.is_empty(),
        "links that lead nowhere:\n{}",
        found.join("\n")
    );
    // A list without pages has no broken links either.
    let links: usize = pages.values().map(|page| page.links.len()).sum();
    assert!(pages.len() > 40 && links > 800, "{} {links}", pages.len());
}

#[test]
fn the_contents_have_every_page_of_the_docs_once() {
    let pages = pages_of(&pages::tracked_files());
    let found = amiss_in_contents(&pages);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Links that lead nowhere, each with its place and what was expected.
fn broken(pages: &BTreeMap<String, Page>, files: &BTreeSet<String>) -> Vec<String> {
    let mut found = Vec::new();
    for (name, page) in pages {
        for link in page.links.iter().filter(|link| !is_external(&link.target)) {
            if let Err(expected) = follow(name, &link.target, pages, files) {
                found.push(line(name, link, &expected));
            }
        }
    }
    found
}

fn line(page: &str, Link { line, target }: &Link, expected: &str) -> String {
    format!("{page}:{line}: link {target}: expected {expected}")
}

/// Reports whether a target begins with a scheme, such as `https:`.
fn is_external(target: &str) -> bool {
    let scheme = target.split_once(':').map(|(scheme, _)| scheme);
    scheme.is_some_and(|scheme| {
        scheme
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    })
}

/// Follows a link from a page; an error is what should be there.
fn follow(
    page: &str,
    target: &str,
    pages: &BTreeMap<String, Page>,
    files: &BTreeSet<String>,
) -> Result<(), String> {
    let (path, anchor) = match target.split_once('#') {
        Some((path, anchor)) => (path, Some(anchor)),
        None => (target, None),
    };
    let to = if path.is_empty() {
        page.to_owned()
    } else {
        resolved(page, path).ok_or("a path that stays in the repository")?
    };
    let mut inside = files.range(format!("{to}/")..);
    let is_folder = inside
        .next()
        .is_some_and(|file| file.starts_with(&format!("{to}/")));
    if !files.contains(&to) && !is_folder {
        return Err(format!("a file that git tracks at {to}"));
    }
    let Some(anchor) = anchor else { return Ok(()) };
    match pages.get(&to) {
        Some(page) if page.has_anchor(anchor) => Ok(()),
        Some(page) => Err(format!(
            "a heading of {to} with the anchor {anchor}; it has {}",
            anchors(page)
        )),
        None => Err(format!("no anchor, as {to} is no Markdown page")),
    }
}

/// The anchors of a page for a message, the first ones of many.
fn anchors(page: &Page) -> String {
    let anchors = page.headings.iter().map(|heading| heading.anchor.as_str());
    // As many as a reader looks through.
    let first: Vec<_> = anchors.take(20).collect();
    let more = if page.headings.len() > first.len() {
        ", …"
    } else {
        ""
    };
    format!("{}{more}", first.join(", "))
}

/// The path from the root of what a page names by a path from itself.
fn resolved(page: &str, path: &str) -> Option<String> {
    let mut parts: Vec<&str> = page.split('/').collect();
    parts.pop();
    for part in path.trim_end_matches('/').split('/') {
        match part {
            "." => {}
            ".." => {
                parts.pop()?;
            }
            // A path from the root of a site, or two slashes.
            "" => return None,
            part => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

/// Pages of the docs that the table of contents lacks or has twice.
fn amiss_in_contents(pages: &BTreeMap<String, Page>) -> Vec<String> {
    let Some(contents) = pages.get(CONTENTS) else {
        return vec![format!("expected {CONTENTS}")];
    };
    let mut times = BTreeMap::new();
    for link in &contents.links {
        *times.entry(resolved(CONTENTS, &link.target)).or_insert(0) += 1;
    }
    let of_docs = pages
        .keys()
        .filter(|name| name.starts_with("docs/") && *name != CONTENTS);
    let amiss = of_docs.filter_map(|name| match times.get(&Some(name.clone())) {
        Some(1) => None,
        times => Some(format!(
            "{CONTENTS}: {name} is there {} times, expected once",
            times.unwrap_or(&0)
        )),
    });
    amiss.collect()
}

#[cfg(test)]
mod planted {
    use super::{BTreeMap, BTreeSet, Page, amiss_in_contents, broken};

    fn pages_of(texts: &[(&str, &str)]) -> BTreeMap<String, Page> {
        let read = |(name, text): &(&str, &str)| ((*name).to_owned(), Page::read(text));
        texts.iter().map(read).collect()
    }

    fn broken_in(text: &str) -> Vec<String> {
        let pages = pages_of(&[("docs/A.md", text), ("B.md", "# B\n")]);
        let files = ["docs/A.md", "B.md", "tests/src/lib.rs"];
        let files: BTreeSet<_> = files.map(str::to_owned).into();
        broken(&pages, &files)
    }

    #[test]
    fn good_links_pass() {
        let good = "# A\n\n[a](#a) [b](../B.md#b) [c](../tests/src/lib.rs) [d](../tests) [e](../tests/src/) [f](https://a.b/c) [g](A.md)\n";
        assert_eq!(broken_in(good), Vec::<String>::new());
    }

    #[test]
    fn a_link_to_nothing_of_each_kind_is_found_with_its_place() {
        let cases = [
            (
                "[x](B.md)",
                "B.md: expected a file that git tracks at docs/B.md",
            ),
            (
                "[x](../test)",
                "../test: expected a file that git tracks at test",
            ),
            (
                "![x](a.png)",
                "a.png: expected a file that git tracks at docs/a.png",
            ),
            (
                "[x](../../C.md)",
                "../../C.md: expected a path that stays in the repository",
            ),
            (
                "[x](/B.md)",
                "/B.md: expected a path that stays in the repository",
            ),
            (
                "[x](#b)",
                "#b: expected a heading of docs/A.md with the anchor b; it has a",
            ),
            (
                "[x](../B.md#a)",
                "../B.md#a: expected a heading of B.md with the anchor a; it has b",
            ),
            (
                "[x](../tests/src/lib.rs#a)",
                "../tests/src/lib.rs#a: expected no anchor, as tests/src/lib.rs is no Markdown page",
            ),
        ];
        for (link, expected) in cases {
            let found = broken_in(&format!("# A\n\n{link}\n"));
            assert_eq!(found, [format!("docs/A.md:3: link {expected}")]);
        }
    }

    #[test]
    fn a_page_that_the_contents_lack_or_have_twice_is_found() {
        let contents = "# Contents\n\n- [A](A.md)\n- [B](B.md)\n- [B](B.md)\n";
        let pages = pages_of(&[
            ("docs/SUMMARY.md", contents),
            ("docs/A.md", ""),
            ("docs/B.md", ""),
            ("docs/C.md", ""),
            ("D.md", ""),
        ]);
        let expected = [
            "docs/SUMMARY.md: docs/B.md is there 2 times, expected once",
            "docs/SUMMARY.md: docs/C.md is there 0 times, expected once",
        ];
        assert_eq!(amiss_in_contents(&pages), expected);
    }
}
