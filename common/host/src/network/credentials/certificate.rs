//! Contents of certificates.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::PemObject;
use x509_parser::prelude::{FromDer, X509Certificate};
use x509_parser::time::ASN1Time;

/// Facts read from a certificate.
pub(super) struct Facts {
    pub(super) common_name: String,
    pub(super) not_after: SystemTime,
}

pub(super) fn facts(certificate: &CertificateDer<'_>) -> Result<Facts, String> {
    let (_, read) = X509Certificate::from_der(certificate).map_err(|error| error.to_string())?;
    // A date before 1970 counts as expired long ago.
    let not_after = u64::try_from(read.validity().not_after.timestamp()).unwrap_or_default();
    Ok(Facts {
        common_name: common_name(certificate).ok_or("has no common name")?,
        not_after: UNIX_EPOCH + Duration::from_secs(not_after),
    })
}

/// The holder of a certificate for access control: its first common name.
#[must_use]
pub(crate) fn common_name(certificate: &CertificateDer<'_>) -> Option<String> {
    let (_, read) = X509Certificate::from_der(certificate).ok()?;
    // The first, as in Zenoh's access control: a second one must not give other rights.
    let name = read.subject().iter_common_name().next()?;
    name.as_str().ok().map(str::to_owned)
}

/// Common name of the first certificate in a PEM text.
#[must_use]
pub fn common_name_in_pem(pem: &str) -> Option<String> {
    let certificate = CertificateDer::from_pem_slice(pem.as_bytes()).ok()?;
    common_name(&certificate)
}

/// A day and time in readable form.
#[must_use]
pub fn date(time: SystemTime) -> String {
    let seconds = time
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default()
        .as_secs();
    // A time beyond the calendar is shown in seconds instead of an error.
    let seconds = i64::try_from(seconds).unwrap_or(i64::MAX);
    ASN1Time::from_timestamp(seconds).map_or_else(|_| format!("{seconds} s"), |t| t.to_string())
}
