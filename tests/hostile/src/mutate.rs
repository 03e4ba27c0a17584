//! Changes of good inputs into hostile ones, deterministic for a seed.

use std::ops::Range;

use coaxle_node::faults::Random;

use crate::Kind;

/// Longest input that is made, bytes.
pub const MOST_BYTES: usize = 1 << 16;

/// Replacements of a number.
const NUMBERS: &[&str] = &[
    "0",
    "-0.0",
    "-1",
    "1",
    "2",
    // Near the smallest normal number, the smallest at all, and the largest position.
    "1e-308",
    "5e-324",
    "1e15",
    "-1e15",
    // Finite and, multiplied by anything, infinite; the next is infinite as read.
    "1e308",
    "-1e308",
    "1e309",
    "nan",
    "inf",
    "-inf",
    "0.1",
    "1e-9",
    // Limits of the integer types, and of the number of axes (128), each with its neighbours.
    "127",
    "128",
    "129",
    "255",
    "256",
    "65535",
    "65536",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "9223372036854775808",
    "18446744073709551615",
    "1000000",
    "1000000000",
    // Notations that TOML and JSON read differently from numbers in Rust.
    "0x7fffffff",
    "1_000",
    "1979-05-27",
    "true",
    "\"\"",
    "[]",
    "{}",
    "null",
];

/// Replacements of a text.
const TEXTS: &[&str] = &[
    "",
    " ",
    ".",
    "..",
    "/",
    "a/b",
    // A file without an end, which must not be read to it.
    "/dev/zero",
    "/dev/null",
    // Wildcards of Zenoh's keys, which a name must not bring into one.
    "*",
    "**",
    "$*",
    "é",
    "\\u0000",
    "\\n",
    // Escapes of a terminal, and a mark that reverses the direction of text.
    "\\u001b[2J",
    "\\u202e",
    "slave",
    "conveyor",
    // Ranges of ids: written out, they would fill the memory.
    "1-4294967295",
    "128-1",
    "1-1000000000",
    "tcp/0.0.0.0:99999",
    "0",
    "nan",
];

/// Pieces to insert anywhere.
const PIECES: &[&str] = &[
    "[",
    "]",
    "[[",
    "]]",
    "{",
    "}",
    "\"",
    "'",
    "\"\"\"",
    "=",
    ",",
    ".",
    "\n",
    "\r\n",
    "\0",
    "#",
    // A byte order mark, which some editors write.
    "\u{feff}",
    "[[slave]]\n",
    "[[axis]]\n",
    "[[far]]\n",
    "[[point]]\n",
    "[[slave.step]]\n",
    "[[event]]\n",
    "[[expect]]\n",
    "[[sweep]]\n",
    "a.a.a.a.a = 1\n",
];

/// Pieces to insert many times over.
const NESTED: &[&str] = &[
    "[", "{\"a\":", "{a=", "a.", "[[a]]\n", "(", "-", "9", "\"", "é", ";", ",",
];

/// Makes hostile inputs of good ones.
#[derive(Debug)]
pub struct Mutator {
    random: Random,
    kind: Kind,
}

impl Mutator {
    /// The mutator of a seed.
    #[must_use]
    pub fn new(seed: u64, kind: Kind) -> Self {
        let random = Random::new(seed);
        Self { random, kind }
    }

    /// Mutates one of the inputs by up to four changes, which may splice in parts of another.
    pub fn next(&mut self, inputs: &[Vec<u8>]) -> Vec<u8> {
        let mut data = inputs[self.below(inputs.len())].clone();
        let other = &inputs[self.below(inputs.len())];
        let changes = if self.random.chance(0.6) {
            // A single change mostly: several at once end at the first refusal.
            1
        } else {
            2 + self.below(3)
        };
        for _ in 0..changes {
            match self.kind {
                // Most texts stay valid in their syntax, so that the checks behind the parser are reached.
                Kind::Text if self.random.chance(0.8) => self.change_text(&mut data, other),
                Kind::Text | Kind::Bytes => self.change_bytes(&mut data, other),
            }
            // After each change, of which several multiply the length.
            data.truncate(MOST_BYTES);
        }
        data
    }

    fn below(&mut self, end: usize) -> usize {
        (self.random.uniform() * end as f64) as usize
    }

    fn one_of<T: Copy>(&mut self, these: &[T]) -> T {
        these[self.below(these.len())]
    }

    /// A range, mostly a short one.
    fn range(&mut self, length: usize) -> Range<usize> {
        let start = self.below(length + 1);
        let most = length - start;
        // A long range destroys all structure; a short one changes a field.
        let count = match self.below(3) {
            0 => self.below(most + 1),
            _ => self.below(most.min(16) + 1),
        };
        start..start + count
    }

    fn change_bytes(&mut self, data: &mut Vec<u8>, other: &[u8]) {
        match self.below(8) {
            0 | 1 if !data.is_empty() => {
                let at = self.below(data.len());
                data[at] ^= 1 << self.below(8);
            }
            2 => {
                let length = self.below(data.len() + 1);
                data.truncate(length);
            }
            3 => {
                let range = self.range(data.len());
                data.drain(range);
            }
            4 => {
                let (into, from) = (self.range(data.len()), self.range(other.len()));
                data.splice(into, other[from].iter().copied());
            }
            5 => {
                let range = self.range(data.len());
                let times = 1 + self.below(16);
                let part = data[range.clone()].repeat(times);
                data.splice(range, part);
            }
            6 => {
                let range = self.range(data.len());
                // Limits of a byte, signed and unsigned, and of a varint.
                let with = self.one_of(&[0, 1, 0x7f, 0x80, 0xff]);
                data[range].fill(with);
            }
            _ => {
                let at = self.below(data.len() + 1);
                let number = self.extreme();
                // Over existing bytes, so that the fields behind keep their places.
                let end = (at + 8).min(data.len());
                data.splice(at..end, number.to_le_bytes());
            }
        }
    }

    /// The bits of a number at some limit.
    fn extreme(&mut self) -> u64 {
        let real = [
            f64::NAN,
            f64::INFINITY,
            1e15,
            // Just beyond the largest position that a frame may have.
            1.000_001e15,
            f64::MAX,
            -f64::MAX,
            f64::MIN_POSITIVE,
            -0.0,
        ];
        let whole = [
            0,
            1,
            u64::MAX,
            u64::MAX >> 1,
            1 << 63,
            1 << 32,
            0xffff,
            // A varint that never ends.
            0x8080_8080_8080_8080,
        ];
        match self.below(2) {
            0 => self.one_of(&real).to_bits(),
            _ => self.one_of(&whole),
        }
    }

    fn change_text(&mut self, data: &mut Vec<u8>, other: &[u8]) {
        match self.below(10) {
            0..=3 => self.change_number(data),
            4 => self.change_quoted(data),
            5 => {
                let at = self.below(data.len() + 1);
                let piece = self.one_of(PIECES);
                data.splice(at..at, piece.bytes());
            }
            6 => self.nest(data),
            7 => self.change_lines(data),
            8 => self.repeat_lines(data),
            _ => {
                let (into, from) = (self.line(data), self.line(other));
                data.splice(into, other[from].iter().copied());
            }
        }
    }

    fn change_number(&mut self, data: &mut Vec<u8>) {
        let numbers = tokens(data, |byte| {
            byte.is_ascii_digit() || b".-+_".contains(&byte)
        });
        if numbers.is_empty() {
            return;
        }
        let at = numbers[self.below(numbers.len())].clone();
        let number = self.one_of(NUMBERS);
        data.splice(at, number.bytes());
    }

    fn change_quoted(&mut self, data: &mut Vec<u8>) {
        let quotes: Vec<usize> = (0..data.len())
            .filter(|at| b"\"'".contains(&data[*at]))
            .collect();
        if quotes.len() < 2 {
            return;
        }
        let first = self.below(quotes.len() - 1);
        let within = quotes[first] + 1..quotes[first + 1];
        // Length has its own faults, but would crowd out the others.
        if self.below(6) == 0 {
            let length = self.below(MOST_BYTES);
            data.splice(within, std::iter::repeat_n(b'a', length));
        } else {
            let text = self.one_of(TEXTS);
            data.splice(within, text.bytes());
        }
    }

    /// Inserts a piece so often that a reader which recurses too deep, or keeps all of it, fails.
    fn nest(&mut self, data: &mut Vec<u8>) {
        let at = self.below(data.len() + 1);
        // Up to 16 384 levels: a recursion per level uses up the stack.
        let times = 1 << self.below(15);
        let piece = self.one_of(NESTED).repeat(times);
        data.splice(at..at, piece.bytes());
    }

    /// A line, with its end.
    fn line(&mut self, data: &[u8]) -> Range<usize> {
        let at = self.below(data.len() + 1);
        let start = data[..at]
            .iter()
            .rposition(|byte| *byte == b'\n')
            .map_or(0, |end| end + 1);
        let end = data[at..].iter().position(|byte| *byte == b'\n');
        start..end.map_or(data.len(), |end| at + end + 1)
    }

    /// Removes a line, or swaps two.
    fn change_lines(&mut self, data: &mut Vec<u8>) {
        let (one, two) = (self.line(data), self.line(data));
        // Overlapping lines have no order to swap.
        if self.below(2) == 0 || one.end > two.start {
            data.drain(one);
            return;
        }
        let (first, second) = (data[one.clone()].to_vec(), data[two.clone()].to_vec());
        // The later one first, which leaves the places of the earlier one.
        data.splice(two, first);
        data.splice(one, second);
    }

    /// Repeats some lines many times over, as a list with thousands of elements does.
    fn repeat_lines(&mut self, data: &mut Vec<u8>) {
        let (one, two) = (self.line(data), self.line(data));
        let lines = one.start.min(two.start)..one.end.max(two.end);
        let times = 1 << self.below(13);
        let times = times.min(1 + MOST_BYTES / lines.len().max(1));
        let part = data[lines.clone()].repeat(times);
        data.splice(lines, part);
    }
}

/// The longest stretches of such bytes.
fn tokens(data: &[u8], is_part: impl Fn(u8) -> bool) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for (at, byte) in data.iter().enumerate() {
        match found.last_mut() {
            Some(token) if token.end == at && is_part(*byte) => token.end += 1,
            _ if is_part(*byte) => found.push(at..at + 1),
            _ => {}
        }
    }
    found
}
