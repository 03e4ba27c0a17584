//! An authority and the certificates that it issues, as files.

use std::path::{Path, PathBuf};
use std::time::Duration;

use rcgen::{BasicConstraints, CertificateParams, DnType, IsCa, Issuer, KeyPair, SigningKey};
use tempfile::TempDir;
use time::OffsetDateTime;
use zenoh_link_tls::{REVOKED_FILE, RevocationList};
use zenoh_protocol::core::EndPoint;

pub(crate) struct Authority {
    issuer: Issuer<'static, KeyPair>,
    pem: String,
}

/// The certificate and key of a node, and its trusted authority.
pub(crate) struct Files {
    folder: TempDir,
}

impl Authority {
    pub(crate) fn new() -> Self {
        let key = KeyPair::generate().expect("a key");
        let mut params = CertificateParams::default();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        params
            .distinguished_name
            .push(DnType::CommonName, "authority");
        let certificate = params.self_signed(&key).expect("a certificate");
        Self {
            pem: certificate.pem(),
            issuer: Issuer::new(params, key),
        }
    }

    pub(crate) fn issue(&self, name: &str) -> Files {
        self.issue_for(name, &["127.0.0.1", "::1"])
    }

    pub(crate) fn issue_for(&self, name: &str, hosts: &[&str]) -> Files {
        self.write(
            name,
            hosts,
            OffsetDateTime::now_utc() + Duration::from_secs(86_400),
        )
    }

    pub(crate) fn issue_until(&self, name: &str, left: Duration) -> Files {
        self.write(name, &["127.0.0.1"], OffsetDateTime::now_utc() + left)
    }

    pub(crate) fn issue_expired(&self, name: &str) -> Files {
        self.write(
            name,
            &["127.0.0.1"],
            OffsetDateTime::now_utc() - Duration::from_secs(60),
        )
    }

    /// Issues a certificate that is valid from now on.
    pub(crate) fn renew(&self, name: &str) -> Files {
        let now = OffsetDateTime::now_utc();
        let until = now + Duration::from_secs(86_400);
        self.write_from(name, &["127.0.0.1"], now, until)
    }

    /// Writes the list beside the certificates of a node: those of these names from before now are revoked.
    pub(crate) fn revoke(&self, number: u64, names: &[&str], at: &Files) {
        let now = OffsetDateTime::now_utc().unix_timestamp().unsigned_abs();
        let entry = |name: &&str| ((*name).to_owned(), now);
        let list = RevocationList {
            number,
            before: names.iter().map(entry).collect(),
        };
        let signature = self.issuer.key().sign(list.unsigned().as_bytes());
        let text = list.signed(&signature.expect("a signature"));
        // By a rename, as the tool writes it: a reader sees the one or the other.
        let new = at.folder.path().join("revoked.new");
        std::fs::write(&new, text).expect("a file");
        std::fs::rename(&new, at.folder.path().join(REVOKED_FILE)).expect("its name");
    }

    fn write(&self, name: &str, hosts: &[&str], until: OffsetDateTime) -> Files {
        let from = OffsetDateTime::now_utc() - Duration::from_secs(86_400);
        self.write_from(name, hosts, from, until)
    }

    fn write_from(
        &self,
        name: &str,
        hosts: &[&str],
        from: OffsetDateTime,
        until: OffsetDateTime,
    ) -> Files {
        let hosts: Vec<_> = hosts.iter().map(|&host| host.to_owned()).collect();
        let mut params = CertificateParams::new(hosts).expect("names");
        params.distinguished_name.push(DnType::CommonName, name);
        params.not_before = from;
        params.not_after = until;
        let key = KeyPair::generate().expect("a key");
        let certificate = params.signed_by(&key, &self.issuer).expect("a certificate");
        let folder = tempfile::tempdir().expect("a folder");
        for (file, text) in [
            ("ca.pem", self.pem.clone()),
            ("cert.pem", certificate.pem()),
            ("key.pem", key.serialize_pem()),
        ] {
            std::fs::write(folder.path().join(file), text).expect("a file");
        }
        Files { folder }
    }
}

impl Files {
    /// Trusts this authority instead of its own.
    pub(crate) fn trusting(self, authority: &Authority) -> Self {
        std::fs::write(self.folder.path().join("ca.pem"), &authority.pem).expect("a file");
        self
    }

    /// Folder of the files.
    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Certificate of the authority, in PEM.
    pub(crate) fn authority(&self) -> String {
        std::fs::read_to_string(self.folder.path().join("ca.pem")).expect("a file")
    }

    /// Returns the endpoint with certificates of both ends. `more` has settings that replace previous
    /// ones.
    pub(crate) fn endpoint(&self, address: &str, more: &str) -> EndPoint {
        endpoint_of(self.folder.path(), address, more)
    }
}

/// Returns the endpoint with the certificates of a folder.
pub(crate) fn endpoint_of(folder: &Path, address: &str, more: &str) -> EndPoint {
    let file = |name: &str| -> PathBuf { folder.join(name) };
    let mut settings = vec![
        format!("root_ca_certificate_file={}", file("ca.pem").display()),
        format!("listen_certificate_file={}", file("cert.pem").display()),
        format!("listen_private_key_file={}", file("key.pem").display()),
        format!("connect_certificate_file={}", file("cert.pem").display()),
        format!("connect_private_key_file={}", file("key.pem").display()),
        "enable_mtls=true".to_owned(),
    ];
    if let Some((name, _)) = more.split_once('=') {
        settings.retain(|setting| !setting.starts_with(&format!("{name}=")));
        settings.push(more.to_owned());
    }
    let text = format!("tls/{address}#{}", settings.join(";"));
    text.parse().expect("an endpoint")
}
