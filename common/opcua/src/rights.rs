//! Right to command.

use std::fmt;

use coaxle_node::keys::NodeName;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Clients that may command.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct RightsConfig {
    /// Clients that may command, by the names in their certificates. None by default.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub commanders: Vec<NodeName>,
    /// Everybody who reaches the port may command: only with `security = "none"`. False by default.
    pub anonymous_commands: bool,
}

/// Client of a session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OpcuaClient {
    /// Client of an endpoint without security.
    Anonymous,
    /// Name in the certificate that the session was opened with.
    Named(String),
}

impl fmt::Display for OpcuaClient {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Anonymous => f.write_str("anonymous"),
            Self::Named(name) => f.write_str(name),
        }
    }
}

impl RightsConfig {
    /// Checks that a client may command.
    ///
    /// # Errors
    /// The reason in words.
    pub fn check(&self, client: &OpcuaClient) -> Result<(), String> {
        match client {
            OpcuaClient::Anonymous if self.anonymous_commands => Ok(()),
            OpcuaClient::Anonymous => Err("rights.anonymous-commands is false".to_owned()),
            OpcuaClient::Named(name)
                if self.commanders.iter().any(|known| known.as_str() == name) =>
            {
                Ok(())
            }
            OpcuaClient::Named(_) => {
                let known: Vec<_> = self.commanders.iter().map(NodeName::as_str).collect();
                Err(match known[..] {
                    [] => "rights.commanders names nobody".to_owned(),
                    _ => format!("rights.commanders names {} only", known.join(", ")),
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_is_not_named_may_not_command() {
        let mut rights = RightsConfig::default();
        let anna = OpcuaClient::Named("anna".to_owned());
        assert!(rights.check(&anna).is_err() && rights.check(&OpcuaClient::Anonymous).is_err());
        rights.commanders.push(NodeName::new("anna").unwrap());
        assert!(rights.check(&anna).is_ok());
        let refused = rights.check(&OpcuaClient::Named("bert".to_owned()));
        assert_eq!(refused, Err("rights.commanders names anna only".to_owned()));
    }
}
