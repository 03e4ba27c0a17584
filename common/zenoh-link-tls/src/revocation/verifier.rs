//! Handshakes of clients whose certificate is revoked end with the alert that says so.

use std::sync::Arc;

use rustls::client::danger::HandshakeSignatureValid;
use rustls::pki_types::{CertificateDer, UnixTime};
use rustls::server::danger::{ClientCertVerified, ClientCertVerifier};
use rustls::{CertificateError, DigitallySignedStruct, DistinguishedName, Error, SignatureScheme};

use super::watch::RevocationWatch;
use crate::certificate::CertifiedPeer;
use crate::events::{LinkEventKind, report};

/// Verifies clients as another verifier does, and refuses those with a revoked certificate.
#[derive(Debug)]
pub(crate) struct UnrevokedClients {
    verifier: Arc<dyn ClientCertVerifier>,
    watch: Arc<RevocationWatch>,
}

impl UnrevokedClients {
    pub(crate) fn new(verifier: Arc<dyn ClientCertVerifier>, watch: Arc<RevocationWatch>) -> Self {
        Self { verifier, watch }
    }
}

impl ClientCertVerifier for UnrevokedClients {
    fn offer_client_auth(&self) -> bool {
        self.verifier.offer_client_auth()
    }

    fn client_auth_mandatory(&self) -> bool {
        self.verifier.client_auth_mandatory()
    }

    fn root_hint_subjects(&self) -> &[DistinguishedName] {
        self.verifier.root_hint_subjects()
    }

    fn verify_client_cert(
        &self,
        certificate: &CertificateDer<'_>,
        intermediates: &[CertificateDer<'_>],
        now: UnixTime,
    ) -> Result<ClientCertVerified, Error> {
        // First the authority: the name in a certificate of somebody else means nothing.
        let verified = (self.verifier).verify_client_cert(certificate, intermediates, now)?;
        let peer = CertifiedPeer::of(Some(std::slice::from_ref(certificate)));
        let peer = peer.map_err(|_| Error::InvalidCertificate(CertificateError::BadEncoding))?;
        match self.watch.list().revocation(&peer) {
            None => Ok(verified),
            Some(reason) => {
                // The listener reports the address only: TLS tells it no name.
                let name = peer.name.as_deref().unwrap_or_default();
                report(name, LinkEventKind::Refused, &reason);
                Err(Error::InvalidCertificate(CertificateError::Revoked))
            }
        }
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        (self.verifier).verify_tls12_signature(message, certificate, signature)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        (self.verifier).verify_tls13_signature(message, certificate, signature)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.verifier.supported_verify_schemes()
    }
}
