//! Names of slaves and far nodes.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::keys::NodeName;

macro_rules! name {
    ($(#[$meta:meta])* $name:ident: $of:literal) => {
        $(#[$meta])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[cfg_attr(
            feature = "schema",
            derive(schemars::JsonSchema),
            schemars(inline, extend(
        "pattern" = "^[A-Za-z0-9._-]{1,64}$",
        "x-kind" = "a name of 1 to 64 letters, digits, `-`, `_` or `.`"
    ))
        )]
        #[serde(try_from = "String", into = "String")]
        pub struct $name {
            bytes: [u8; Self::MAX_LEN],
            length: u8,
        }

        impl $name {
            /// Greatest length of a name, in bytes.
            pub const MAX_LEN: usize = NodeName::MAX_LEN;

            /// # Errors
            /// [`InvalidName`] unless the name is 1 to 64 letters, digits, `-`, `_` or `.`.
            pub fn new(name: &str) -> Result<Self, InvalidName> {
                let fits = (1..=Self::MAX_LEN).contains(&name.len());
                let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
                if !fits || !name.chars().all(plain) {
                    return Err(InvalidName {
                        received: name.to_owned(),
                        of: $of,
                    });
                }
                let mut bytes = [0; Self::MAX_LEN];
                bytes[..name.len()].copy_from_slice(name.as_bytes());
                Ok(Self {
                    bytes,
                    length: name.len() as u8,
                })
            }

            /// Returns the name.
            #[must_use]
            pub fn as_str(&self) -> &str {
                std::str::from_utf8(&self.bytes[..usize::from(self.length)])
                    .expect("only ASCII letters are taken")
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.as_str())
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Debug::fmt(self.as_str(), f)
            }
        }

        impl TryFrom<String> for $name {
            type Error = InvalidName;
            fn try_from(name: String) -> Result<Self, InvalidName> {
                Self::new(&name)
            }
        }

        impl From<$name> for String {
            fn from(name: $name) -> Self {
                name.as_str().to_owned()
            }
        }

        impl std::str::FromStr for $name {
            type Err = InvalidName;
            fn from_str(name: &str) -> Result<Self, InvalidName> {
                Self::new(name)
            }
        }
    };
}

name! {
    /// Name of a slave, in a type that the cycle may copy. Every name of a node is also valid for a
    /// slave.
    SlaveName: "slave name"
}

name! {
    /// The name of a node that is followed, in a type that the cycle may copy.
    FarName: "name of a far node"
}

/// Text that is not a valid name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{received:?} is no {of}, expected 1 to 64 letters, digits, '-', '_' or '.'")]
pub struct InvalidName {
    /// Text received.
    pub received: String,
    /// Kind of thing to name.
    pub of: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_kept_as_they_are() {
        for name in ["x", "carriage", "tool-2", &"n".repeat(SlaveName::MAX_LEN)] {
            let kept = SlaveName::new(name).unwrap();
            assert_eq!(kept.as_str(), name);
            assert_eq!(String::from(kept).parse(), Ok(kept));
        }
    }

    #[test]
    fn what_is_no_name_is_quoted() {
        for name in ["", "a b", "ä", "a/b", &"n".repeat(SlaveName::MAX_LEN + 1)] {
            let error = SlaveName::new(name).unwrap_err().to_string();
            assert!(error.contains(&format!("{name:?}")), "{error}");
        }
    }
}
