//! Config file of a server.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use coaxle_node::config::{TransportConfig, Wrong};
use coaxle_node::keys::NodeName;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::rights::RightsConfig;

/// A server of OPC UA for running nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct OpcuaConfig {
    /// Name of the server, part of its application URI, `urn:coaxle:opcua:NAME`.
    pub name: NodeName,
    /// The nodes to show. All that are there by default.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<NodeName>,
    /// Transport to the nodes. `secure` is the folder of an operator.
    #[serde(default)]
    pub transport: TransportConfig,
    /// Access for clients of OPC UA.
    #[serde(default)]
    pub endpoint: EndpointConfig,
    /// Rights of these clients.
    #[serde(default)]
    pub rights: RightsConfig,
}

/// Access for clients of OPC UA.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct EndpointConfig {
    /// Address and port to listen on. `127.0.0.1:4840` by default; `0.0.0.0:4840` for all network interfaces.
    #[schemars(with = "String")]
    pub listen: SocketAddr,
    /// Host name or address that clients are given for this server. The address of `listen` by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub host: Option<String>,
    /// Security of connections.
    pub security: EndpointSecurity,
    /// Folder with the certificate of the server and those of its clients, as `coaxle opcua --certificates` writes it. Required
    /// with `security = "sign-and-encrypt"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certificates: Option<PathBuf>,
}

/// Security of connections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EndpointSecurity {
    /// Basic256Sha256, `SignAndEncrypt`, and certificates at both ends.
    #[default]
    SignAndEncrypt,
    /// No security, and anonymous clients: for networks without certificates.
    None,
}

impl Default for EndpointConfig {
    fn default() -> Self {
        Self {
            // The port that IANA has registered for opc.tcp.
            listen: SocketAddr::from(([127, 0, 0, 1], 4840)),
            host: None,
            security: EndpointSecurity::default(),
            certificates: None,
        }
    }
}

impl EndpointConfig {
    /// Host that clients are given.
    #[must_use]
    pub fn advertised_host(&self) -> String {
        let own = || match self.listen {
            // An IPv6 address in a URL has brackets.
            SocketAddr::V6(at) => format!("[{}]", at.ip()),
            SocketAddr::V4(at) => at.ip().to_string(),
        };
        self.host.clone().unwrap_or_else(own)
    }
}

impl OpcuaConfig {
    /// Application URI of the server.
    #[must_use]
    pub fn application_uri(&self) -> String {
        application_uri(&self.name)
    }

    /// Resolves the relative paths of its files from `folder`, the config's own.
    pub fn relative_to(&mut self, folder: &Path) {
        self.transport.relative_to(folder);
        if let Some(certificates) = &mut self.endpoint.certificates {
            *certificates = folder.join(&*certificates);
        }
    }

    /// Checks that its fields fit each other.
    ///
    /// # Errors
    /// [`Wrong`] with the field.
    pub fn check(&self) -> Result<(), Wrong> {
        let transport = &self.transport;
        if transport.connect.is_empty() && transport.secure.is_none() && transport.file.is_none() {
            let expected = "the endpoint of a node, such as \"tcp/127.0.0.1:7447\"";
            return Err(Wrong::of("transport.connect", "none", expected));
        }
        if self
            .endpoint
            .host
            .as_ref()
            .is_some_and(|host| !is_host(host))
        {
            let host = self.endpoint.host.as_deref().unwrap_or_default();
            let expected = "a host name or an address, without a port";
            return Err(Wrong::of(
                "endpoint.host",
                format_args!("{host:?}"),
                expected,
            ));
        }
        if self.endpoint.listen.port() == 0 {
            let expected = "a port from 1 to 65535, since clients connect to it";
            return Err(Wrong::of("endpoint.listen", "port 0", expected));
        }
        match self.endpoint.security {
            EndpointSecurity::SignAndEncrypt => self.check_secured(),
            EndpointSecurity::None => self.check_plain(),
        }
    }

    fn check_secured(&self) -> Result<(), Wrong> {
        if self.rights.anonymous_commands {
            let expected = "false beside security = \"sign-and-encrypt\": name the clients in rights.commanders";
            return Err(Wrong::of("rights.anonymous-commands", "true", expected));
        }
        if self.endpoint.certificates.is_none() {
            let expected =
                "a folder that `coaxle opcua CONFIG --certificates` fills, or security = \"none\"";
            return Err(Wrong::of("endpoint.certificates", "none", expected));
        }
        Ok(())
    }

    fn check_plain(&self) -> Result<(), Wrong> {
        // Everybody at the port would see and command a network that lets in nobody without a certificate.
        if self.transport.secure.is_some() {
            let expected = "\"sign-and-encrypt\" beside transport.secure";
            return Err(Wrong::of("endpoint.security", "\"none\"", expected));
        }
        if !self.rights.commanders.is_empty() {
            let expected = "none beside security = \"none\", where clients have no names: rights.anonymous-commands";
            return Err(Wrong::of("rights.commanders", "names", expected));
        }
        Ok(())
    }
}

/// Application URI of a server or a client with a name.
#[must_use]
pub fn application_uri(name: &NodeName) -> String {
    format!("urn:coaxle:opcua:{name}")
}

fn is_host(text: &str) -> bool {
    let is_of_a_host = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
    !text.is_empty() && text.chars().all(is_of_a_host)
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::parse;

    fn check(text: &str) -> Result<OpcuaConfig, String> {
        let config: OpcuaConfig = parse("t", text).map_err(|error| error.to_string())?;
        config.check().map_err(|wrong| wrong.to_string())?;
        Ok(config)
    }

    #[test]
    fn what_does_not_fit_is_named() {
        for (text, expected) in [
            (
                "name = 'a'",
                "transport.connect: received none, expected the endpoint",
            ),
            (
                "name = 'a'\ntransport.connect = ['tcp/127.0.0.1:1']",
                "endpoint.certificates: received none, expected a folder",
            ),
            (
                "name = 'a'\ntransport.secure = 'net/a'\nendpoint.security = 'none'",
                "endpoint.security: received \"none\", expected \"sign-and-encrypt\"",
            ),
            (
                "name = 'a'\ntransport.secure = 'net/a'\nendpoint.certificates = 'c'\nrights.anonymous-commands = true",
                "rights.anonymous-commands: received true",
            ),
            (
                "name = 'a'\ntransport.connect = ['tcp/127.0.0.1:1']\nendpoint.security = 'none'\nrights.commanders = ['b']",
                "rights.commanders: received names",
            ),
            (
                "name = 'a'\ntransport.secure = 'net/a'\nendpoint.host = 'opc.tcp://a'",
                "endpoint.host: received \"opc.tcp://a\"",
            ),
            (
                "name = 'a'\ntransport.secure = 'net/a'\nendpoint.listen = '127.0.0.1:0'",
                "endpoint.listen: received port 0",
            ),
            ("name = 'a'\nendpoint.listen = 'here'", "endpoint.listen"),
            ("name = 'a'\nnod = ['b']", "nod"),
        ] {
            let error = check(text).unwrap_err();
            assert!(error.contains(expected), "{expected}\n{error}");
        }
    }

    #[test]
    fn an_address_is_advertised_as_clients_write_it() {
        let config = check(
            "name = 'a'\ntransport.secure = 'n'\nendpoint = { listen = '[::1]:4841', certificates = 'c' }",
        );
        let config = config.unwrap();
        assert_eq!(config.endpoint.advertised_host(), "[::1]");
        assert_eq!(config.application_uri(), "urn:coaxle:opcua:a");
    }
}
