//! Position of a field in the text of its file, and its name for people.

use std::fmt::{self, Write};
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

/// A line and a column, both from 1; the column in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    line: usize,
    column: usize,
}

impl Position {
    /// The position of a byte of a text.
    pub(super) fn of(text: &str, byte: usize) -> Self {
        // `get`: an offset within a character must not panic.
        let before = text.get(..byte).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |end| end + 1);
        Self {
            line: 1 + before.matches('\n').count(),
            // Characters, as editors count. Bytes would be off behind an umlaut.
            column: 1 + before[line_start..].chars().count(),
        }
    }
}

impl Position {
    /// Moves past this text.
    fn pass(&mut self, text: &str) {
        let last = text.rsplit('\n').next().unwrap_or_default().chars().count();
        let lines = text.matches('\n').count();
        self.line += lines;
        // Behind a line break the column counts from 1.
        self.column = if lines > 0 {
            1 + last
        } else {
            self.column + last
        };
    }
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.line, self.column)
    }
}

/// Positions of the elements of a list at this path of keys; empty if there is no such list.
pub fn elements_of(text: &str, path: &[&str]) -> Vec<Position> {
    let Ok(root) = DeTable::parse(text) else {
        return Vec::new();
    };
    let root = DeValue::Table(root.into_inner());
    let list = path
        .iter()
        .try_fold(&root, |at, key| Some(at.get(*key)?.get_ref()));
    let Some(DeValue::Array(list)) = list else {
        return Vec::new();
    };
    // Moved on from element to element: a search from the beginning for each would take time with the square of their number.
    let mut position = Position { line: 1, column: 1 };
    let mut done = 0;
    let places = list.iter().map(|element| {
        let start = element.span().start.max(done);
        position.pass(text.get(done..start).unwrap_or_default());
        done = start;
        position
    });
    places.collect()
}

/// A field that was looked up in its file.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// Position of the field, or of its parent if it is missing; none for the file itself.
    pub(super) position: Option<Position>,
    /// The field, elements of lists by their names.
    pub(super) field: String,
    /// The reason without the field that it began with.
    pub(super) reason: String,
}

impl Place {
    /// Looks a field up by its path, such as `receiver[1].slave[0].gear`. Checks of a part of a
    /// file put the path relative to it at the beginning of their reason: `slave[0].gear: received
    /// …`. None if the text is not TOML.
    pub(super) fn find(text: &str, field: &str, reason: &str) -> Option<Self> {
        let root = DeValue::Table(DeTable::parse(text).ok()?.into_inner());
        let mut walk = Walk::new(&root);
        walk.follow(field);
        let mut reason = reason;
        // A reason may begin with several fields: of a part, and of a part of that part.
        while let Some((more, rest)) = reason.split_once(": ") {
            // A colon may belong to the reason itself, as behind an NC code or a file.
            if !(walk.leads_to(more) || says_what_is_wrong(more, rest)) {
                break;
            }
            walk.follow(more);
            reason = rest;
        }
        // After the walk: the reason without fields says if the key or the value is wrong.
        let position = walk.byte(reason).map(|byte| Position::of(text, byte));
        Some(Self {
            position,
            reason: walk
                .several_variants(reason)
                .unwrap_or_else(|| reason.to_owned()),
            field: walk.called,
        })
    }
}

/// True if a reason begins with the name of the field concerned.
fn says_what_is_wrong(field: &str, reason: &str) -> bool {
    // A code such as 0x4b32, or a file's name, is no field.
    let is_field = field.starts_with(|c: char| c.is_ascii_lowercase())
        && field
            .chars()
            .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-');
    let says = ["received ", "expected ", "missing"];
    is_field && says.iter().any(|start| reason.starts_with(start))
}

/// A walk through a document along the path of a field.
struct Walk<'d> {
    /// The current value; none once the path leaves the document.
    at: Option<&'d DeValue<'d>>,
    /// Spans of the last key and the last value in the document.
    key: Option<Range<usize>>,
    value: Option<Range<usize>>,
    /// The last key: the kind of the elements of a list.
    kind: &'d str,
    called: String,
}

impl<'d> Walk<'d> {
    fn new(root: &'d DeValue<'d>) -> Self {
        Self {
            at: Some(root),
            key: None,
            value: None,
            kind: "",
            called: String::new(),
        }
    }

    /// Follows a path as far as the document contains it.
    fn follow(&mut self, path: &str) {
        let mut path = path;
        while let Some(rest) = self.step(path) {
            path = rest;
        }
        let path = path.trim_start_matches('.');
        if !path.is_empty() {
            // Out of the document from here on: the parent's place stays.
            self.at = None;
            self.call(path);
        }
    }

    /// True if the document has the first step of a path from here.
    fn leads_to(&self, path: &str) -> bool {
        self.key_of(path).is_some() || self.element_of(path).is_some()
    }

    /// Takes one step; returns the rest of the path.
    fn step<'p>(&mut self, path: &'p str) -> Option<&'p str> {
        let path = path.strip_prefix('.').unwrap_or(path);
        if let Some((key, value, rest)) = self.key_of(path) {
            self.call(key.get_ref());
            self.key = Some(key.span());
            self.kind = key.get_ref();
            self.arrive(value);
            return Some(rest);
        }
        let (number, element, rest) = self.element_of(path)?;
        match name_of(element.get_ref(), self.kind) {
            // An error in the name itself is not labelled by the name.
            Some(name) if rest != ".name" => {
                let _ = write!(self.called, " {name:?}");
            }
            _ => {
                let _ = write!(self.called, "[{number}]");
            }
        }
        self.key = Some(element.span());
        self.arrive(element);
        Some(rest)
    }

    fn arrive(&mut self, value: &'d Spanned<DeValue<'d>>) {
        self.value = Some(value.span());
        self.at = Some(value.get_ref());
    }

    fn call(&mut self, key: &str) {
        // A number of an element follows its list without a point.
        if !self.called.is_empty() && !key.starts_with(['[', ',']) {
            self.called.push('.');
        }
        self.called.push_str(key);
    }

    /// The longest key of this table that a path begins with: a key may have dots in it.
    fn key_of<'p>(&self, path: &'p str) -> Option<Entry<'d, 'p>> {
        let Some(DeValue::Table(table)) = self.at else {
            return None;
        };
        let entries = table.iter().filter_map(|(key, value)| {
            let rest = path.strip_prefix(key.get_ref().as_ref())?;
            // `far` must not match `far-axes`.
            (rest.is_empty() || rest.starts_with(['.', '['])).then_some((key, value, rest))
        });
        entries.max_by_key(|(key, ..)| key.get_ref().len())
    }

    /// The element of this list that a path begins with: `[2]`.
    fn element_of<'p>(&self, path: &'p str) -> Option<(usize, &'d Spanned<DeValue<'d>>, &'p str)> {
        let Some(DeValue::Array(list)) = self.at else {
            return None;
        };
        let (number, rest) = path.strip_prefix('[')?.split_once(']')?;
        let number = number.parse().ok()?;
        Some((number, list.get(number)?, rest))
    }

    /// Reason for a table with several variants where exactly one is allowed, with their names.
    fn several_variants(&self, reason: &str) -> Option<String> {
        let Some(DeValue::Table(table)) = self.at else {
            return None;
        };
        // serde counts the variants of an enum, and does not name them.
        let keys: Vec<_> = table.keys().map(|key| key.get_ref().as_ref()).collect();
        let is_so = reason.starts_with("wanted exactly 1 element") && keys.len() > 1;
        is_so.then(|| {
            format!(
                "received {}, expected one of them alone",
                keys.join(" and ")
            )
        })
    }

    /// Offset of the error: the key if that is wrong, otherwise the value.
    fn byte(&self, reason: &str) -> Option<usize> {
        let span = match reason.starts_with("unknown field") {
            // An unknown field is wrong by its name.
            true => &self.key,
            false => &self.value,
        };
        span.as_ref().map(|span| span.start)
    }
}

/// A key of a table, its value, and the rest of a path.
type Entry<'d, 'p> = (&'d Spanned<DeString<'d>>, &'d Spanned<DeValue<'d>>, &'p str);

/// Name of an element of a list.
fn name_of<'d>(element: &'d DeValue<'d>, kind: &str) -> Option<&'d str> {
    let key = match kind {
        // Elements of these lists have no name of their own.
        "far" => "node",
        "step" => "label",
        _ => "name",
    };
    let name = element.get(key)?.get_ref().as_str()?;
    (!name.is_empty()).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "title = 'é'\n[[receiver]]\nname = 'saw'\nmode = 'pt2'\n[[receiver.slave]]\n  gear.ratio = 0\n\
        [[receiver]]\n[settings]\n'a.b' = 1\n";

    fn found(field: &str, reason: &str) -> String {
        let place = Place::find(TEXT, field, reason).unwrap();
        let at = place.position.map(|position| position.to_string());
        format!(
            "{}|{}|{}",
            at.unwrap_or_default(),
            place.field,
            place.reason
        )
    }

    #[test]
    fn a_field_is_found_by_its_path_and_elements_are_called_by_their_names() {
        for (field, expected) in [
            ("", "||wrong"),
            ("title", "1:9|title|wrong"),
            ("receiver", "2:1|receiver|wrong"),
            ("receiver[0].mode", "4:8|receiver \"saw\".mode|wrong"),
            // The name is wrong itself, so that the number names the element.
            ("receiver[0].name", "3:8|receiver[0].name|wrong"),
            (
                "receiver[0].slave[0].gear.ratio",
                "6:16|receiver \"saw\".slave[0].gear.ratio|wrong",
            ),
            ("receiver[1]", "7:1|receiver[1]|wrong"),
            ("settings.a.b", "9:9|settings.a.b|wrong"),
        ] {
            assert_eq!(found(field, "wrong"), expected);
        }
    }

    #[test]
    fn what_is_not_there_is_where_it_should_be() {
        assert_eq!(
            found("receiver[1].name.x", "wrong"),
            "7:1|receiver[1].name.x|wrong"
        );
        assert_eq!(found("receiver[7]", "wrong"), "2:1|receiver[7]|wrong");
        assert_eq!(found("seed", "wrong"), "|seed|wrong");
    }

    #[test]
    fn a_field_at_the_beginning_of_the_reason_is_one() {
        for (field, reason, expected) in [
            (
                "receiver[0]",
                "slave[0].gear.ratio: received 0",
                "6:16|receiver \"saw\".slave[0].gear.ratio|received 0",
            ),
            (
                "receiver[1]",
                "name: received none, expected one",
                "7:1|receiver[1].name|received none, expected one",
            ),
            (
                "title",
                "0x4b32: received 3: expected 4",
                "1:9|title|0x4b32: received 3: expected 4",
            ),
            (
                "title",
                "other.csv: received 3",
                "1:9|title|other.csv: received 3",
            ),
        ] {
            assert_eq!(found(field, reason), expected);
        }
    }

    #[test]
    fn elements_are_where_a_look_from_the_beginning_finds_them() {
        let text = "# é\n[table]\nrows = [[0, 0], [1, 'é'], [2, 3],\n  [4, 5]]\n[[point]]\na = 1\n[[point]]\n";
        let rows = elements_of(text, &["table", "rows"]);
        let rows: Vec<_> = rows.iter().map(Position::to_string).collect();
        // `é` is a single column, so that the third is at 27 and not 28.
        assert_eq!(rows, ["3:9", "3:17", "3:27", "4:3"]);
        let points = elements_of(text, &["point"]);
        let points: Vec<_> = points.iter().map(Position::to_string).collect();
        assert_eq!(points, ["5:1", "7:1"]);
        assert_eq!(elements_of(text, &["table"]), []);
        assert_eq!(elements_of("a = = 1", &["a"]), []);
    }

    #[test]
    fn several_variants_are_named() {
        let text = "[network]\njitter = { exponential-us = 20, normal-us = 5 }";
        let place = Place::find(
            text,
            "network.jitter",
            "wanted exactly 1 element, more than 1 element",
        );
        let reason = place.unwrap().reason;
        assert_eq!(
            reason,
            "received exponential-us and normal-us, expected one of them alone"
        );
    }

    #[test]
    fn an_unknown_field_is_its_key() {
        assert_eq!(
            found("receiver[0].mode", "unknown field `mode`"),
            "4:1|receiver \"saw\".mode|unknown field `mode`"
        );
    }
}
