//! The peer of a link, by its certificates.

use rustls::pki_types::CertificateDer;
use time::OffsetDateTime;
use x509_parser::prelude::{FromDer, X509Certificate};
use zenoh_result::{ZResult, zerror};

/// The peer of a link, and the end of its validity.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct CertifiedPeer {
    /// The common name of its certificate, used by Zenoh's access control. None without a certificate, or
    /// without a name in it.
    pub(crate) name: Option<String>,
    /// The beginning of the validity of its own certificate, seconds since 1970.
    pub(crate) issued: u64,
    /// The earliest end of validity in its chain; none without a certificate.
    pub(crate) expires: Option<OffsetDateTime>,
}

impl CertifiedPeer {
    /// Reads a chain, the certificate of the peer first.
    ///
    /// # Errors
    /// A certificate that cannot be read.
    pub(crate) fn of(chain: Option<&[CertificateDer<'_>]>) -> ZResult<Self> {
        let mut peer = Self::default();
        for (n, certificate) in chain.unwrap_or_default().iter().enumerate() {
            let (_, certificate) = X509Certificate::from_der(certificate)
                .map_err(|error| zerror!("certificate {n} of the chain: {error}"))?;
            let not_after = certificate.validity().not_after.to_datetime();
            // The link is valid as long as the whole chain: an authority may expire before its certificates.
            peer.expires = Some(peer.expires.map_or(not_after, |known| known.min(not_after)));
            // The first is the peer's own; the others only vouch for it.
            if n == 0 {
                let mut names = certificate.subject().iter_common_name();
                let name = names.next().and_then(|name| name.as_str().ok());
                peer.name = name.map(str::to_owned);
                let from = certificate.validity().not_before.timestamp();
                // Before 1970 there is no certificate.
                peer.issued = u64::try_from(from).unwrap_or_default();
            }
        }
        Ok(peer)
    }
}
