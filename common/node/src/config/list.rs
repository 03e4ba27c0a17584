//! Lists with a checked length.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};

use super::wrong::Wrong;

/// Reads a list of at most `MOST` elements, for serde's `deserialize_with`: elements beyond the
/// limit are not read, so that a short file cannot request much memory.
///
/// # Errors
/// More elements, or an invalid one.
pub fn at_most<'de, const MOST: usize, T, D>(deserializer: D) -> Result<Vec<T>, D::Error>
where
    T: Deserialize<'de>,
    D: Deserializer<'de>,
{
    deserializer.deserialize_seq(Bounded::<MOST, T>(PhantomData))
}

struct Bounded<const MOST: usize, T>(PhantomData<T>);

impl<'de, const MOST: usize, T: Deserialize<'de>> Visitor<'de> for Bounded<MOST, T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of at most {MOST}")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<T>, A::Error> {
        let mut elements = Vec::new();
        // Read before it is refused: serde gives no length of a sequence in advance.
        while let Some(element) = list.next_element()? {
            if elements.len() == MOST {
                let received = format!("more than {MOST}");
                let wrong = Wrong::value(received, "at most that many");
                return Err(A::Error::custom(wrong));
            }
            elements.push(element);
        }
        Ok(elements)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse;

    #[derive(Debug, serde::Deserialize, schemars::JsonSchema)]
    struct Config {
        #[serde(default, deserialize_with = "at_most::<3, _, _>")]
        list: Vec<u8>,
    }

    #[test]
    fn a_list_has_its_most_elements_and_no_more() {
        let list = |text: &str| parse::<Config>("t.toml", text).map(|config| config.list);
        assert!(list("").unwrap().is_empty());
        assert_eq!(list("list = [1, 2, 3]").unwrap(), [1, 2, 3]);
        for (text, expected) in [
            (
                "list = [1, 2, 3, 4]",
                "t.toml:1:8: list: received more than 3, expected at most that many",
            ),
            (
                "list = [1, 300]",
                "t.toml:1:12: list[1]: received 300, expected a whole number from 0 to 255",
            ),
            (
                "list = 1",
                "t.toml:1:8: list: received 1, expected a list of at most 3",
            ),
        ] {
            assert_eq!(list(text).unwrap_err().to_string(), expected);
        }
    }
}
