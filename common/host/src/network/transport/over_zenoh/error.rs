//! Zenoh's errors in readable form.

use anyhow::anyhow;

/// Zenoh's error, without the places in its source code.
pub(super) fn zenoh_error(error: zenoh::Error) -> anyhow::Error {
    anyhow!(without_source_places(&error.to_string()))
}

/// Reason of an insertion error, which Zenoh gives only in debug form, `Str("…")` or
/// `Json5Err(Message { msg: "…" …`.
pub(super) fn insertion_reason(debug: &str) -> String {
    // Both forms end the reason with a quotation mark; a reason that holds one itself is cut there.
    let quoted = debug.split_once("msg: \"").or(debug.split_once("Str(\""));
    match quoted.and_then(|(_, rest)| rest.split_once('"')) {
        Some((reason, _)) => reason.to_owned(),
        None => without_source_places(debug),
    }
}

/// Removes each ` at <file>.rs:<line>.` that Zenoh's errors carry.
// Places in Zenoh's source say nothing to an operator, and name a folder of the machine it was built on.
fn without_source_places(message: &str) -> String {
    let mut words: Vec<String> = Vec::new();
    for word in message.split_whitespace() {
        // The word before the place is "at", which goes with it.
        match (after_source_place(word), words.last().map(String::as_str)) {
            (Some(rest), Some("at")) => {
                words.pop();
                if let Some(last) = words.last_mut() {
                    last.push_str(rest);
                }
            }
            _ => words.push(word.to_owned()),
        }
    }
    words.join(" ")
}

/// Text after `<file>.rs:<line>.` in a word that begins with it, such as a bracket.
fn after_source_place(word: &str) -> Option<&str> {
    let (_, line) = word.split_once(".rs:")?;
    let rest = line.trim_start_matches(|c: char| c.is_ascii_digit());
    // Without a line number the word was no place.
    (rest.len() < line.len()).then(|| rest.trim_start_matches('.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_lose_their_places_in_zenohs_source() {
        assert_eq!(
            without_source_places(
                "Bind failed: [10.0.0.1: in use at /root/io/tcp.rs:12.] at 10.0.0.1 at src/x.rs:7. - Caused by it"
            ),
            "Bind failed: [10.0.0.1: in use] at 10.0.0.1 - Caused by it"
        );
    }
}
