//! Markdown pages of the repository: headings with their anchors, links, code and numbers, read by the rules of CommonMark.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::process::Command;

use pulldown_cmark::{CowStr, Event, Options, Parser, Tag, TagEnd};

/// A page, as far as a test compares it.
#[derive(Default)]
pub(crate) struct Page {
    pub(crate) headings: Vec<Heading>,
    /// Links and pictures.
    pub(crate) links: Vec<Link>,
    /// Content of each block of code.
    pub(crate) code: Vec<String>,
    /// Numbers of the tables, in their order.
    pub(crate) table_numbers: Vec<String>,
    /// Numbers of headings, sentences and lists, in their order.
    pub(crate) numbers: Vec<String>,
}

/// A heading of a page.
pub(crate) struct Heading {
    /// From 1, that of the title, to 6.
    pub(crate) level: usize,
    /// Fragment by which GitHub links to it.
    pub(crate) anchor: String,
}

/// A link or a picture of a page.
pub(crate) struct Link {
    pub(crate) line: usize,
    pub(crate) target: String,
}

impl Page {
    pub(crate) fn read(text: &str) -> Self {
        let mut page = Self::default();
        let mut seen = BTreeMap::new();
        // Text of the open heading.
        let mut heading: Option<String> = None;
        let (mut is_code, mut is_table) = (false, false);
        for (event, range) in Parser::new_ext(text, Options::ENABLE_TABLES).into_offset_iter() {
            match event {
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(level)) => {
                    let anchor = anchor_of(&heading.take().unwrap_or_default(), &mut seen);
                    let level = level as usize;
                    page.headings.push(Heading { level, anchor });
                }
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    let line = 1 + text[..range.start].matches('\n').count();
                    let target = dest_url.into_string();
                    page.links.push(Link { line, target });
                }
                Event::Start(Tag::CodeBlock(_)) => {
                    is_code = true;
                    page.code.push(String::new());
                }
                Event::End(TagEnd::CodeBlock) => is_code = false,
                Event::Start(Tag::Table(_)) => is_table = true,
                Event::End(TagEnd::Table) => is_table = false,
                Event::Text(part) if is_code => {
                    // The block was opened before its text.
                    page.code.last_mut().expect("a block").push_str(&part);
                }
                Event::Text(part) | Event::Code(part) => {
                    page.add_numbers(&part, is_table);
                    if let Some(heading) = &mut heading {
                        heading.push_str(&part);
                    }
                }
                _ => {}
            }
        }
        page
    }

    fn add_numbers(&mut self, text: &CowStr<'_>, is_table: bool) {
        let numbers = if is_table {
            &mut self.table_numbers
        } else {
            &mut self.numbers
        };
        let parts = text.split(|c: char| !c.is_ascii_digit() && c != '.' && c != ',');
        let parts = parts.map(|part| part.trim_matches(['.', ',']));
        // A decimal comma is a decimal point elsewhere.
        numbers.extend(
            parts
                .filter(|part| !part.is_empty())
                .map(|part| part.replace(',', ".")),
        );
    }

    pub(crate) fn has_anchor(&self, anchor: &str) -> bool {
        self.headings.iter().any(|heading| heading.anchor == anchor)
    }
}

/// The fragment that GitHub gives a heading: letters, digits, `_` and `-` in lower case, `-` for a space, and a number from the second of
/// its kind on.
fn anchor_of(heading: &str, seen: &mut BTreeMap<String, usize>) -> String {
    let kept = heading.chars().filter_map(|c| match c {
        ' ' => Some('-'),
        '-' | '_' => Some(c),
        // No superscripts, which are numeric but not digits.
        c if c.is_alphabetic() || c.is_ascii_digit() => Some(c),
        _ => None,
    });
    let anchor = kept.collect::<String>().to_lowercase();
    let times = seen.entry(anchor.clone()).or_insert(0);
    *times += 1;
    match *times {
        1 => anchor,
        times => format!("{anchor}-{}", times - 1),
    }
}

/// Every file that git tracks, as a path from the root; of an archive without git all files.
pub(crate) fn tracked_files() -> BTreeSet<String> {
    let root = super::root();
    if !root.join(".git").exists() {
        let files = super::file_sizes::files_below(&root);
        let from_root = |file: PathBuf| Some(file.strip_prefix(&root).ok()?.display().to_string());
        return files.into_iter().filter_map(from_root).collect();
    }
    let listed = Command::new("git")
        .args(["ls-files", "-z"])
        .current_dir(&root)
        .output()
        .expect("git starts");
    let complaint = String::from_utf8_lossy(&listed.stderr);
    assert!(listed.status.success(), "git ls-files: {complaint}");
    let names = String::from_utf8(listed.stdout).expect("names in UTF-8");
    names
        .split_terminator('\0')
        // One that was removed and not yet committed is no target.
        .filter(|name| root.join(name).exists())
        .map(str::to_owned)
        .collect()
}

#[cfg(test)]
mod planted {
    use super::Page;

    #[test]
    fn a_heading_has_the_anchor_of_github() {
        let text = "# Über `a_b`: [the](x.md) *way*, m/s²\n\n## To add …\n\n## Same\n\n### Same\n\n```sh\n# none\n```\n";
        let anchors: Vec<_> = Page::read(text)
            .headings
            .into_iter()
            .map(|heading| (heading.level, heading.anchor))
            .collect();
        let expected = [
            (1, "über-a_b-the-way-ms"),
            (2, "to-add-"),
            (2, "same"),
            (3, "same-1"),
        ];
        assert_eq!(
            anchors,
            expected.map(|(level, anchor)| (level, anchor.to_owned()))
        );
    }

    #[test]
    fn links_and_pictures_are_found_but_not_in_code() {
        let text = "[`a`](a.md#x)\n\n![b [c](c.md)](b.png) `[d](d.md)`\n\n```\n[e](e.md)\n```\n| |\n|--|\n| [f](f.md) |\n";
        let links: Vec<_> = Page::read(text)
            .links
            .into_iter()
            .map(|link| (link.line, link.target))
            .collect();
        let expected = [(1, "a.md#x"), (3, "b.png"), (3, "c.md"), (10, "f.md")];
        assert_eq!(
            links,
            expected.map(|(line, target)| (line, target.to_owned()))
        );
    }

    #[test]
    fn numbers_are_the_same_with_a_decimal_comma() {
        let page = Page::read(
            "TS5055, 100 ms.\n\n```\n3\n```\n\n| `1` ms |\n|--|\n| 0,87 to 2.3, 5 m/s² |\n",
        );
        assert_eq!(page.numbers, ["5055", "100"]);
        assert_eq!(page.table_numbers, ["1", "0.87", "2.3", "5"]);
        assert_eq!(page.code, ["3\n"]);
    }
}
