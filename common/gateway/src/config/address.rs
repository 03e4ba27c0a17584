//! Address of a PLC.

use coaxle_node::config::Wrong;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A host and a port, `192.168.1.20:48898`, or a host alone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(inline, extend("minLength" = 1))]
pub struct HostPort {
    host: String,
    port: Option<u16>,
}

/// An AMS net id, `5.12.34.56.1.1`: six numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(inline, with = "String", extend("pattern" = r"^[0-9]{1,3}(\.[0-9]{1,3}){5}$"))]
pub struct NetId(pub [u8; 6]);

impl HostPort {
    /// Returns the host.
    #[must_use]
    pub fn host(&self) -> &str {
        &self.host
    }

    /// Returns the port, if it is given.
    #[must_use]
    pub const fn port(&self) -> Option<u16> {
        self.port
    }
}

impl TryFrom<String> for HostPort {
    type Error = Wrong;
    fn try_from(text: String) -> Result<Self, Wrong> {
        // From the right: the port is behind the last colon.
        let (host, port) = match text.rsplit_once(':') {
            Some((host, port)) => (host, Some(port)),
            None => (text.as_str(), None),
        };
        // A blank or a slash is a slip of the keyboard, which the resolver would report as an unknown host.
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
        let number = port.map(str::parse::<u16>).transpose();
        match number {
            Ok(port) if !host.is_empty() && host.chars().all(plain) => Ok(Self {
                host: host.to_owned(),
                port,
            }),
            _ => {
                let expected = "a host or host:port, such as \"192.168.1.20:48898\"";
                Err(Wrong::value(format_args!("{text:?}"), expected))
            }
        }
    }
}

impl From<HostPort> for String {
    fn from(HostPort { host, port }: HostPort) -> Self {
        match port {
            Some(port) => format!("{host}:{port}"),
            None => host,
        }
    }
}

impl TryFrom<String> for NetId {
    type Error = Wrong;
    fn try_from(text: String) -> Result<Self, Wrong> {
        // `u8` refuses numbers beyond 255, and `try_into` any other number of them.
        let numbers: Result<Vec<u8>, _> = text.split('.').map(str::parse).collect();
        let six = numbers.ok().and_then(|numbers| numbers.try_into().ok());
        let expected = "six numbers from 0 to 255, such as \"5.12.34.56.1.1\"";
        six.map(Self)
            .ok_or_else(|| Wrong::value(format_args!("{text:?}"), expected))
    }
}

impl From<NetId> for String {
    fn from(NetId(id): NetId) -> Self {
        id.map(|number| number.to_string()).join(".")
    }
}
