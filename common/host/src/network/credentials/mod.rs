//! A secure profile folder, as `coaxle secure init` writes it: the identity of a node or an
//! operator, and the authority it trusts.

mod authority;
mod certificate;
mod error;
mod timing_keys;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use coaxle_node::keys::NodeName;
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};
use coaxle_os::exit::wrong_file;
use rustls::client::ClientConfig;
use rustls::crypto::{CryptoProvider, ring};
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, UnixTime};
use rustls::server::WebPkiClientVerifier;
use rustls::sign::CertifiedKey;
use rustls::{CertificateError, RootCertStore};

pub use authority::{Authority, Issued, Validity};
pub(crate) use certificate::common_name;
pub use certificate::{common_name_in_pem, date};
pub use error::{BadCredentials, CredentialsFault};
pub use timing_keys::{OLD_TIMING_KEY_FILE, TIMING_KEYS_FILE, TimingKeys, timing_keys};
pub use zenoh_link_tls::{REVOKED_FILE, RevocationList, RevocationWatch};

/// The Zenoh config of the profile, with the access control rules.
pub const PROFILE_FILE: &str = "zenoh.json5";
/// The certificate of the trusted authority.
pub const AUTHORITY_FILE: &str = "ca.pem";
/// The own certificate.
pub const CERTIFICATE_FILE: &str = "cert.pem";
/// The private key of that certificate.
pub const KEY_FILE: &str = "key.pem";

/// Time before its end from which a certificate should be renewed.
// A month: the new folders are carried to each PC by hand.
pub const RENEW_WITHIN: Duration = Duration::from_secs(30 * 24 * 60 * 60);

/// Returns the nodes whose status the holder of a folder may read: those named in the rules of its
/// profile.
///
/// # Errors
/// A profile that cannot be read, or that names no node.
pub fn known_nodes(folder: &Path) -> anyhow::Result<Vec<NodeName>> {
    let file = folder.join(PROFILE_FILE);
    let text = text_file::read(&file, MOST_CONFIG_BYTES)?;
    // The rules name each key in quotes. A parser of JSON5 would bring a dependency for this one list.
    let quoted = text.split('"').filter(|word| word.ends_with("/status"));
    // A set: a node is named in several rules.
    let nodes: BTreeSet<_> = quoted.filter_map(NodeName::of_key).collect();
    if nodes.is_empty() {
        return wrong_file(format!(
            "{}: received a profile that may hear the status of no node, expected that of an operator",
            file.display()
        ));
    }
    Ok(nodes.into_iter().collect())
}

/// The contents of a secure profile folder.
#[derive(Debug)]
pub struct Credentials {
    folder: PathBuf,
    name: NodeName,
    not_after: SystemTime,
    authorities: RootCertStore,
    chain: Vec<CertificateDer<'static>>,
    key: PrivateKeyDer<'static>,
}

impl Credentials {
    /// Reads a folder. Its certificate may be not valid yet or expired: see [`Self::check`].
    ///
    /// # Errors
    /// [`BadCredentials`] names the file that is missing or has other contents.
    pub fn open(folder: &Path) -> Result<Self, BadCredentials> {
        let mut authorities = RootCertStore::empty();
        // The file may hold several: certificates of any of them are trusted.
        for authority in certificates(&folder.join(AUTHORITY_FILE))? {
            let added = authorities.add(authority);
            added.map_err(|error| BadCredentials::new(folder.join(AUTHORITY_FILE), error))?;
        }
        let file = folder.join(CERTIFICATE_FILE);
        let chain = certificates(&file)?;
        // The first certificate of a chain is that of the holder, by the order of TLS.
        let facts = certificate::facts(&chain[0]);
        let facts = facts.map_err(|reason| BadCredentials::new(file.clone(), reason))?;
        let name = NodeName::new(facts.common_name);
        let file = folder.join(KEY_FILE);
        Ok(Self {
            folder: folder.to_owned(),
            name: name
                // Names of nodes are parts of keys: a certificate with any other name could not be addressed.
                .map_err(|error| BadCredentials::new(folder.join(CERTIFICATE_FILE), error))?,
            not_after: facts.not_after,
            authorities,
            chain,
            key: PrivateKeyDer::from_pem_file(&file)
                .map_err(|error| BadCredentials::new(file, error))?,
        })
    }

    /// The holder's name as access control sees it.
    #[must_use]
    pub const fn name(&self) -> &NodeName {
        &self.name
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// End of the certificate's validity.
    #[must_use]
    pub const fn not_after(&self) -> SystemTime {
        self.not_after
    }

    /// Checks that others can trust the certificate at this time.
    ///
    /// # Errors
    /// [`CredentialsFault`]: of another authority, expired, or a key that belongs to another certificate.
    pub fn check(&self, at: SystemTime) -> Result<(), CredentialsFault> {
        let key = provider()
            .key_provider
            .load_private_key(self.key.clone_key());
        // A key that cannot be loaded is treated as that of another certificate: either way the file is replaced.
        let key = key.map_err(|_| CredentialsFault::OtherKey)?;
        let certified = CertifiedKey::new(self.chain.clone(), key);
        certified
            .keys_match()
            .map_err(|_| CredentialsFault::OtherKey)?;
        let authorities = Arc::new(self.authorities.clone());
        // The own certificate is verified as other nodes would verify it: as that of a client.
        let verifier = WebPkiClientVerifier::builder_with_provider(authorities, provider());
        let verifier = verifier.build();
        let verifier = verifier.map_err(|error| CredentialsFault::Unusable(error.to_string()))?;
        let at = at.duration_since(UNIX_EPOCH).unwrap_or_default();
        let at = UnixTime::since_unix_epoch(at);
        match verifier.verify_client_cert(&self.chain[0], &self.chain[1..], at) {
            Ok(_) => Ok(()),
            Err(rustls::Error::InvalidCertificate(error)) => Err(self.fault(&error)),
            Err(error) => Err(CredentialsFault::Unusable(error.to_string())),
        }
    }

    fn fault(&self, error: &CertificateError) -> CredentialsFault {
        use CertificateError as Of;
        match error {
            Of::Expired | Of::ExpiredContext { .. } => {
                CredentialsFault::Expired(date(self.not_after))
            }
            Of::NotValidYet | Of::NotValidYetContext { .. } => CredentialsFault::NotYet,
            // A wrong signature: the authority has the same name, and another key.
            Of::UnknownIssuer | Of::BadSignature => CredentialsFault::OtherAuthority,
            other => CredentialsFault::Unusable(other.to_string()),
        }
    }

    /// Returns the client config with which the holder connects to a node.
    ///
    /// # Errors
    /// A key that belongs to another certificate.
    pub(crate) fn client_config(&self) -> Result<ClientConfig, rustls::Error> {
        ClientConfig::builder_with_provider(provider())
            // Nodes of the profile refuse TLS 1.2, since mutual TLS is on.
            .with_protocol_versions(&[&rustls::version::TLS13])?
            .with_root_certificates(self.authorities.clone())
            .with_client_auth_cert(self.chain.clone(), self.key.clone_key())
    }
}

/// The cryptography provider that Zenoh uses, too.
pub(crate) fn provider() -> Arc<CryptoProvider> {
    Arc::new(ring::default_provider())
}

/// The certificates of a file, at least one.
fn certificates(file: &Path) -> Result<Vec<CertificateDer<'static>>, BadCredentials> {
    let bad = |error| BadCredentials::new(file.to_owned(), error);
    let read = CertificateDer::pem_file_iter(file).map_err(bad)?;
    let certificates: Vec<_> = read.collect::<Result<_, _>>().map_err(bad)?;
    if certificates.is_empty() {
        return Err(BadCredentials::new(
            file.to_owned(),
            "holds no certificate in PEM",
        ));
    }
    Ok(certificates)
}

#[cfg(test)]
mod tests;
