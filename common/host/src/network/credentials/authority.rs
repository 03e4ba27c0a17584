//! The certificate authority of a network, which signs the certificates of nodes and operators.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::Context;
use coaxle_node::keys::NodeName;
use rcgen::{
    BasicConstraints, CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa,
    Issuer, KeyPair, KeyUsagePurpose, PKCS_ECDSA_P256_SHA256, SanType, SigningKey,
};
use time::OffsetDateTime;
use zenoh_link_tls::RevocationList;

use super::certificate::common_name_in_pem;

/// An authority that signs certificates.
pub struct Authority {
    certificate: String,
    issuer: Issuer<'static, KeyPair>,
}

/// A certificate with its key, both in PEM.
pub struct Issued {
    /// The certificate, public.
    pub certificate: String,
    /// The private key, for its holder only.
    pub key: String,
}

/// The validity period of a certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Validity {
    /// Start of the validity.
    pub from: SystemTime,
    /// End of the validity.
    pub until: SystemTime,
}

const DAY: Duration = Duration::from_secs(24 * 60 * 60);

impl Validity {
    /// Validity of this number of days from now, starting a day ago because clocks differ.
    #[must_use]
    pub fn days(now: SystemTime, days: u16) -> Self {
        Self {
            from: now - DAY,
            until: now + DAY * u32::from(days),
        }
    }

    /// Start of the validity in seconds since 1970, as a certificate has it.
    #[must_use]
    pub fn from_s(self) -> u64 {
        self.from
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default()
            .as_secs()
    }

    fn dates(self) -> anyhow::Result<[OffsetDateTime; 2]> {
        let date = |at: SystemTime| {
            // Before 1970 there is no certificate: such a time becomes the epoch.
            let seconds = at.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
            OffsetDateTime::from_unix_timestamp(i64::try_from(seconds)?)
                .map_err(anyhow::Error::from)
        };
        let dates = [date(self.from), date(self.until)];
        let [from, until] = dates.map(|date| date.context("the validity of a certificate"));
        Ok([from?, until?])
    }
}

impl Authority {
    /// Creates an authority with a unique name.
    ///
    /// # Errors
    /// The system provides no random numbers.
    pub fn new(validity: Validity) -> anyhow::Result<Self> {
        // P-256: TLS 1.3 obliges every implementation to support it (RFC 8446, 9.1).
        let key = KeyPair::generate_for(&PKCS_ECDSA_P256_SHA256).context("the authority's key")?;
        let number: String = key
            .public_key_raw()
            // The last eight bytes: the names of two authorities agree with a probability of 2⁻⁶⁴.
            .iter()
            .rev()
            .take(8)
            .fold(String::with_capacity(16), |text, byte| {
                text + &format!("{byte:02x}")
            });
        let mut params = authority_params(&format!("Coaxle authority {number}"));
        [params.not_before, params.not_after] = validity.dates()?;
        let certificate = params
            .self_signed(&key)
            .context("the authority's certificate")?;
        Ok(Self {
            certificate: certificate.pem(),
            issuer: Issuer::new(params, key),
        })
    }

    /// Reads an authority from its certificate and key, both in PEM.
    ///
    /// # Errors
    /// Either is not valid PEM, or the certificate has no name.
    pub fn read(certificate: &str, key: &str) -> anyhow::Result<Self> {
        let key = KeyPair::from_pem(key).context("the authority's key")?;
        let name = common_name_in_pem(certificate);
        let name = name.context("the authority's certificate has no common name, or is none")?;
        Ok(Self {
            certificate: certificate.to_owned(),
            issuer: Issuer::new(authority_params(&name), key),
        })
    }

    /// The authority's certificate, for all who are to trust it.
    #[must_use]
    pub fn certificate(&self) -> &str {
        &self.certificate
    }

    /// The authority's private key, to be kept secret.
    #[must_use]
    pub fn key(&self) -> String {
        self.issuer.key().serialize_pem()
    }

    /// Signs a list of revoked certificates, and returns its file.
    ///
    /// # Errors
    /// The system provides no random numbers.
    pub fn sign(&self, list: &RevocationList) -> anyhow::Result<String> {
        let signature = self.issuer.key().sign(list.unsigned().as_bytes());
        let signature = signature.context("the signature of the revoked certificates")?;
        Ok(list.signed(&signature))
    }

    /// Issues a certificate for a node or an operator that is reached under these addresses.
    ///
    /// # Errors
    /// An address that is neither an IP address nor a host name.
    pub fn issue(
        &self,
        name: &NodeName,
        hosts: &[String],
        validity: Validity,
    ) -> anyhow::Result<Issued> {
        let key = KeyPair::generate_for(&PKCS_ECDSA_P256_SHA256).context("a key")?;
        let mut params = CertificateParams::default();
        params.distinguished_name = called(name.as_str());
        params.subject_alt_names = hosts
            .iter()
            .map(|host| alternative(host))
            .collect::<Result<_, _>>()?;
        // A leaf that could sign would make every stolen node folder an authority.
        params.is_ca = IsCa::ExplicitNoCa;
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        // Every node is a server to some nodes and a client to others.
        params.extended_key_usages = vec![
            ExtendedKeyUsagePurpose::ServerAuth,
            ExtendedKeyUsagePurpose::ClientAuth,
        ];
        // Without the identifier, verifiers have to try every authority of the same name.
        params.use_authority_key_identifier_extension = true;
        [params.not_before, params.not_after] = validity.dates()?;
        let signed = params.signed_by(&key, &self.issuer);
        let certificate = signed.with_context(|| format!("the certificate of {name}"))?;
        Ok(Issued {
            certificate: certificate.pem(),
            key: key.serialize_pem(),
        })
    }
}

fn authority_params(name: &str) -> CertificateParams {
    let mut params = CertificateParams::default();
    params.distinguished_name = called(name);
    // Length 0: the authority signs leaves, and none of those signs further.
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    params
}

fn called(name: &str) -> DistinguishedName {
    let mut called = DistinguishedName::new();
    called.push(DnType::CommonName, name);
    called
}

/// An IPv6 address may be in brackets, as in an endpoint.
fn alternative(host: &str) -> anyhow::Result<SanType> {
    // A host name has no brackets, so that trimming does no harm to it.
    let bare = host.trim_start_matches('[').trim_end_matches(']');
    // An address needs an entry of its own kind: clients compare addresses with addresses only.
    if let Ok(address) = bare.parse() {
        return Ok(SanType::IpAddress(address));
    }
    let name = host.try_into();
    let name =
        name.with_context(|| format!("received {host:?}, expected an address or a host name"))?;
    Ok(SanType::DnsName(name))
}
