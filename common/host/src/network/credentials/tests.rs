use super::*;

use rcgen::{BasicConstraints, CertificateParams, DnType, IsCa, Issuer, KeyPair};

const DAY: Duration = Duration::from_secs(24 * 60 * 60);

struct Authority {
    pem: String,
    issuer: Issuer<'static, KeyPair>,
}

fn named(name: &str) -> CertificateParams {
    let mut params = CertificateParams::default();
    params.distinguished_name = rcgen::DistinguishedName::new();
    params.distinguished_name.push(DnType::CommonName, name);
    // A fixed year, and a fixed instant in it below: the tests do not depend on today.
    params.not_before = rcgen::date_time_ymd(2026, 1, 1);
    params.not_after = rcgen::date_time_ymd(2027, 1, 1);
    params
}

fn authority(name: &str) -> Authority {
    let key = KeyPair::generate().unwrap();
    let mut params = named(name);
    params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    let pem = params.self_signed(&key).unwrap().pem();
    Authority {
        pem,
        issuer: Issuer::new(params, key),
    }
}

/// A folder with a certificate of `by` and the certificate of the authority `beside`.
fn folder(name: &str, by: &Authority, beside: &Authority) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let key = KeyPair::generate().unwrap();
    let certificate = named(name).signed_by(&key, &by.issuer).unwrap();
    for (file, text) in [
        (AUTHORITY_FILE, beside.pem.clone()),
        (CERTIFICATE_FILE, certificate.pem()),
        (KEY_FILE, key.serialize_pem()),
    ] {
        std::fs::write(folder.path().join(file), text).unwrap();
    }
    folder
}

/// In the middle of 2026.
fn summer() -> SystemTime {
    // 2026-06-21, by 1 782 000 000 s since 1970.
    UNIX_EPOCH + Duration::from_secs(1_782_000_000)
}

#[test]
fn a_folder_says_whose_it_is_and_until_when() {
    let authority = authority("ours");
    let folder = folder("saw", &authority, &authority);
    let credentials = Credentials::open(folder.path()).unwrap();
    assert_eq!(credentials.name().as_str(), "saw");
    let end = date(credentials.not_after());
    assert!(end.contains("2027"), "{end}");
    assert_eq!(credentials.check(summer()), Ok(()));
    assert!(credentials.client_config().is_ok());
}

#[test]
fn what_nobody_would_believe_is_said() {
    let (ours, theirs) = (authority("ours"), authority("theirs"));
    let good = folder("saw", &ours, &ours);
    let credentials = Credentials::open(good.path()).unwrap();
    // A year later the certificate of 2026 is over, a year earlier it has not begun.
    let late = credentials.check(summer() + 365 * DAY).unwrap_err();
    assert!(matches!(late, CredentialsFault::Expired(_)), "{late}");
    let early = credentials.check(summer() - 365 * DAY);
    assert_eq!(early, Err(CredentialsFault::NotYet));

    let mixed = folder("saw", &theirs, &ours);
    // Signed by one authority, with the certificate of the other beside it.
    let credentials = Credentials::open(mixed.path()).unwrap();
    let fault = credentials.check(summer());
    assert_eq!(fault, Err(CredentialsFault::OtherAuthority));

    let other = folder("saw", &ours, &ours);
    let key = |folder: &tempfile::TempDir| folder.path().join(KEY_FILE);
    std::fs::copy(key(&other), key(&good)).unwrap();
    let credentials = Credentials::open(good.path()).unwrap();
    assert_eq!(credentials.check(summer()), Err(CredentialsFault::OtherKey));
}

#[test]
fn a_file_that_is_not_there_or_no_certificate_is_named() {
    let ours = authority("ours");
    for (file, text) in [
        (AUTHORITY_FILE, Some("")),
        (CERTIFICATE_FILE, Some("nothing")),
        (KEY_FILE, None),
    ] {
        let folder = folder("saw", &ours, &ours);
        let path = folder.path().join(file);
        match text {
            Some(text) => std::fs::write(&path, text).unwrap(),
            None => std::fs::remove_file(&path).unwrap(),
        }
        let error = Credentials::open(folder.path()).unwrap_err();
        assert_eq!(error.file, path);
        assert!(error.to_string().contains("coaxle secure init"), "{error}");
    }
    // Blanks are not allowed in a key, and so not in the name of a node.
    let nameless = folder("no name at all", &ours, &ours);
    let error = Credentials::open(nameless.path()).unwrap_err();
    assert!(error.to_string().contains("no name at all"), "{error}");
}
