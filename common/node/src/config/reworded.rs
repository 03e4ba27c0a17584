//! Rewording of serde's errors.

use crate::guess::did_you_mean;

/// True if serde reports a missing field.
pub(super) fn is_missing(reason: &str) -> bool {
    reason.trim().starts_with("missing field ")
}

/// True if serde reports an unknown field.
pub(super) fn is_unknown(reason: &str) -> bool {
    reason.trim().starts_with("unknown field ")
}

/// Rewords a reason of serde's; other reasons stay as they are.
pub(super) fn reworded(reason: &str) -> String {
    let reason = reason.trim();
    if let Some(rest) = ["invalid type: ", "invalid value: "]
        .iter()
        .find_map(|start| reason.strip_prefix(start))
        // From the right: a received text may hold the same words.
        && let Some((received, expected)) = rest.rsplit_once(", expected ")
    {
        return format!("received {}, expected {}", value(received), kind(expected));
    }
    if let Some(field) = reason
        .strip_prefix("missing field `")
        .and_then(|rest| rest.strip_suffix('`'))
    {
        return format!("{field}: missing, expected one");
    }
    for start in ["unknown variant ", "unknown field "] {
        if let Some((received, expected)) = reason
            .strip_prefix(start)
            .and_then(|rest| rest.split_once(", expected "))
        {
            let meant = did_you_mean(received.trim_matches('`'), ticked(expected));
            return match start {
                "unknown variant " => {
                    format!(
                        "received {:?}, expected {expected}{meant}",
                        received.trim_matches('`')
                    )
                }
                _ => format!("{reason}{meant}"),
            };
        }
    }
    reason.to_owned()
}

/// Texts between backticks.
fn ticked(text: &str) -> impl Iterator<Item = &str> {
    // Every other piece lies between backticks.
    text.split('`').skip(1).step_by(2)
}

/// A value as serde calls it: ``integer `3` ``, `string "x"`.
fn value(received: &str) -> String {
    // serde writes the kind, a blank, and the value.
    let (kind, value) = received.split_once(' ').unwrap_or((received, ""));
    match (kind, value) {
        ("string", text) => format!("the text {text}"),
        ("map", "") => "a table".to_owned(),
        ("sequence", "") => "a list".to_owned(),
        ("integer" | "boolean", value) => value.trim_matches('`').to_owned(),
        ("floating", value) => value
            .trim_start_matches("point ")
            .trim_matches('`')
            .to_owned(),
        _ => received.to_owned(),
    }
}

/// Words for the type that serde expects.
fn kind(expected: &str) -> String {
    let kind = match expected {
        "f64" | "f32" => "a number",
        "u8" => "a whole number from 0 to 255",
        "u16" => "a whole number from 0 to 65535",
        "u32" => "a whole number from 0 to 4294967295",
        "u64" | "usize" => "a whole number of at least 0",
        "i32" | "i64" => "a whole number",
        "a nonzero u16" => "a whole number from 1 to 65535",
        "a nonzero u32" => "a whole number from 1 to 4294967295",
        "a boolean" => "true or false",
        "a string" | "string or map" | "path string" => "a text",
        "a sequence" => "a list",
        "a map" => "a table",
        other if other.starts_with("struct ") => "a table",
        other => other,
    };
    kind.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn serdes_words_become_ours() {
        for (serde, ours) in [
            (
                "invalid type: string \"fast\", expected f64",
                "received the text \"fast\", expected a number",
            ),
            (
                "invalid type: floating point `1.5`, expected u32",
                "received 1.5, expected a whole number from 0 to 4294967295",
            ),
            (
                "invalid value: integer `-1`, expected u64",
                "received -1, expected a whole number of at least 0",
            ),
            (
                "invalid type: sequence, expected struct GearConfig",
                "received a list, expected a table",
            ),
            ("missing field `jerk`", "jerk: missing, expected one"),
            (
                "unknown variant `pt2`, expected one of `bypass`, `pt1`, `sync`",
                "received \"pt2\", expected one of `bypass`, `pt1`, `sync`; did you mean \"pt1\"?",
            ),
            (
                "unknown field `drift`, expected `drift-ppm` or `jitter`",
                "unknown field `drift`, expected `drift-ppm` or `jitter`; did you mean \"drift-ppm\"?",
            ),
            ("received 3, expected 4", "received 3, expected 4"),
        ] {
            assert_eq!(reworded(serde), ours);
        }
    }

    #[test]
    fn only_what_is_much_alike_may_be_meant() {
        let known = ["conveyor", "belt", "carriage"];
        for (received, meant) in [
            ("conveyer", "; did you mean \"conveyor\"?"),
            ("Belt", "; did you mean \"belt\"?"),
            ("cariage", "; did you mean \"carriage\"?"),
            ("saw", ""),
            // Too far from all of them.
            ("", ""),
        ] {
            assert_eq!(did_you_mean(received, known), meant, "{received}");
        }
    }
}
