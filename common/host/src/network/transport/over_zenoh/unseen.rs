//! Finding out why a node is not visible, by dialling its possible endpoints.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use coaxle_node::config::TransportConfig;
use rustls::{ClientConfig, RootCertStore};
use zenoh::Config;

use super::dial::{DialResult, dial};
use super::exposure::endpoints;
use crate::network::credentials::{Credentials, provider};
use crate::network::transport::InvisibilityReason;

/// Endpoints and credentials of a session.
#[derive(Debug)]
pub(super) struct SessionEndpoints {
    endpoints: Vec<String>,
    secure: Option<PathBuf>,
}

impl SessionEndpoints {
    pub(super) fn of(config: &Config, transport: &TransportConfig) -> Self {
        Self {
            // Only endpoints that it connects to: a node that connects to this one is at an unknown address.
            endpoints: endpoints(config, "connect"),
            secure: transport.secure.clone(),
        }
    }

    /// True with a secure profile.
    pub(super) const fn is_secure(&self) -> bool {
        self.secure.is_some()
    }

    /// Dials every endpoint; none if that shows no reason.
    pub(super) fn invisibility_reason(&self, node: &str) -> Option<InvisibilityReason> {
        // A folder that has become unreadable leaves no way to ask, and the session itself reports it.
        let config = client_config(self.secure.as_deref())?;
        let dialled = self.endpoints.iter().filter_map(|endpoint| {
            // Sockets of this machine and datagrams have no TLS over TCP to ask with.
            let has_tcp = endpoint.starts_with("tls/") || endpoint.starts_with("tcp/");
            has_tcp.then(|| (endpoint.as_str(), dial(endpoint, Arc::clone(&config))))
        });
        judge(node, self.secure.is_some(), &dialled.collect::<Vec<_>>())
    }
}

/// Client config of the profile; without one, a client that has no certificate and trusts none.
fn client_config(secure: Option<&Path>) -> Option<Arc<ClientConfig>> {
    let config = match secure {
        Some(folder) => Credentials::open(folder).ok()?.client_config().ok()?,
        None => ClientConfig::builder_with_provider(provider())
            // TLS 1.3 alone: its alert comes after the handshake, where the dial looks for it.
            .with_protocol_versions(&[&rustls::version::TLS13])
            .ok()?
            .with_root_certificates(RootCertStore::empty())
            .with_no_client_auth(),
    };
    Some(Arc::new(config))
}

fn judge(
    node: &str,
    is_secure: bool,
    dialled: &[(&str, DialResult)],
) -> Option<InvisibilityReason> {
    // The node's own name first: a refusal by another node of the list says nothing about this one.
    let is_it = |found: &&(&str, DialResult)| found.1 == DialResult::Trusted(Some(node.to_owned()));
    if let Some((endpoint, _)) = dialled.iter().find(is_it) {
        return Some(InvisibilityReason::Refused(format!(
            "{endpoint} is {node} and lets this end in, but shows it nothing: the zenoh.json5 of one of \
             them gives no rights to the other"
        )));
    }
    let refusal_text = |endpoint: &str, what: &DialResult| match what {
        // Without a profile this end trusts nobody: its own refusal says nothing about the other end.
        DialResult::Refused(_) if !is_secure => Some(format!(
            "{endpoint} wants TLS and a certificate, and this end is not part of a secure network"
        )),
        DialResult::Refused(why) => Some(format!("{endpoint}: {why}")),
        // Plain TCP is in order for a node without a profile.
        DialResult::WithoutTls if is_secure => Some(format!("{endpoint} has no TLS")),
        _ => None,
    };
    let refusals = dialled
        .iter()
        .filter_map(|(endpoint, what)| refusal_text(endpoint, what));
    let refusals: Vec<_> = refusals.collect();
    if !refusals.is_empty() {
        // A refusal is more than an unreachable endpoint: it shows a node that is there.
        return Some(InvisibilityReason::Refused(refusals.join("; ")));
    }
    let elsewhere = dialled.iter().filter_map(|(endpoint, what)| match what {
        DialResult::Unreachable(why) => Some(format!("{endpoint}: {why}")),
        DialResult::Trusted(Some(name)) => Some(format!("{endpoint} is {name}")),
        _ => None,
    });
    let elsewhere: Vec<_> = elsewhere.collect();
    (!elsewhere.is_empty()).then(|| InvisibilityReason::Unreachable(elsewhere.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: &str = "tls/10.0.0.1:7447";
    const PRESS: &str = "tls/10.0.0.2:7447";

    fn believed(name: &str) -> DialResult {
        DialResult::Trusted(Some(name.to_owned()))
    }

    fn unreachable() -> DialResult {
        DialResult::Unreachable("refused".to_owned())
    }

    #[test]
    fn what_is_told_is_what_concerns_the_node() {
        let expired = DialResult::Refused("it has expired".to_owned());
        let of_line = |dialled: &[(&str, DialResult)]| judge("line", true, dialled).unwrap();
        let no_rights = of_line(&[(PRESS, expired.clone()), (LINE, believed("line"))]);
        assert!(
            matches!(no_rights, InvisibilityReason::Refused(_)),
            "{no_rights:?}"
        );
        assert!(no_rights.reason().contains("gives no rights"));
        assert_eq!(
            of_line(&[(PRESS, believed("press")), (LINE, expired)]),
            InvisibilityReason::Refused(format!("{LINE}: it has expired"))
        );
        assert_eq!(
            of_line(&[(PRESS, believed("press")), (LINE, unreachable())]),
            InvisibilityReason::Unreachable(format!("{PRESS} is press; {LINE}: refused"))
        );
        assert_eq!(
            of_line(&[(LINE, DialResult::WithoutTls)]),
            InvisibilityReason::Refused(format!("{LINE} has no TLS"))
        );
        assert_eq!(judge("line", true, &[]), None);
    }

    #[test]
    fn who_has_no_certificate_is_told_that_one_is_wanted() {
        let plain = |dialled| judge("line", false, &[("tcp/10.0.0.1:7447", dialled)]);
        let other_authority =
            DialResult::Refused("its certificate is of another authority".to_owned());
        let wanted = plain(other_authority).unwrap();
        assert!(
            wanted.reason().contains("wants TLS and a certificate"),
            "{wanted:?}"
        );
        // A plain node at a plain endpoint: there is no refusal to be found.
        assert_eq!(plain(DialResult::WithoutTls), None, "as it ought to be");
        assert!(matches!(
            plain(unreachable()),
            Some(InvisibilityReason::Unreachable(_))
        ));
    }
}
