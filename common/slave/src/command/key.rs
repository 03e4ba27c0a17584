//! Keys of commands, from the names of their variants at compile time, by the rule of serde's
//! `kebab-case`: a variant states its key, and no list repeats it.

/// Length of the key: a hyphen before each capital but the first.
#[must_use]
pub const fn length(variant: &str) -> usize {
    let letters = variant.as_bytes();
    let mut length = letters.len();
    let mut n = 1;
    while n < letters.len() {
        length += letters[n].is_ascii_uppercase() as usize;
        n += 1;
    }
    length
}

/// Letters of the key, as many as [`length`] says.
#[must_use]
pub const fn of<const LENGTH: usize>(variant: &str) -> [u8; LENGTH] {
    let letters = variant.as_bytes();
    let mut key = [b'-'; LENGTH];
    let (mut from, mut to) = (0, 0);
    while from < letters.len() {
        to += (from > 0 && letters[from].is_ascii_uppercase()) as usize;
        key[to] = letters[from].to_ascii_lowercase();
        from += 1;
        to += 1;
    }
    key
}

/// The key as text.
///
/// # Panics
/// At compile time, for a variant that is not ASCII.
#[must_use]
pub const fn text(key: &'static [u8]) -> &'static str {
    match core::str::from_utf8(key) {
        Ok(text) => text,
        Err(_) => panic!("a variant is ASCII"),
    }
}
