//! Certificates of the server and of its clients: RSA, as Basic256Sha256 requires; those of the network are of P-256.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use coaxle_node::keys::NodeName;
use coaxle_os::exit::wrong_argument;
use coaxle_os::{Os, Readers, System};
use opcua::crypto::{CertificateStore, PrivateKey, X509, X509Data};

use crate::config::{OpcuaConfig, application_uri};

/// Files of the server in its folder. The library of OPC UA has these names.
const OWN_CERTIFICATE: &str = "own/cert.der";
const OWN_KEY: &str = "private/private.pem";
const TRUSTED: &str = "trusted";
const REJECTED: &str = "rejected";
/// Most unknown certificates that are kept, so that a new client finds its own among them.
const MOST_REJECTED: usize = 100;
/// Folders for the PCs of clients, and their files.
const CLIENTS: &str = "clients";
const CLIENT_CERTIFICATE: &str = "cert.der";
const CLIENT_KEY: &str = "key.pem";
const SERVER_CERTIFICATE: &str = "server.der";

/// Length of a key, and validity of a certificate as in a secure network.
const KEY_BITS: u32 = 2048;
const VALID_DAYS: u32 = 365;

/// Makes the certificate of the server, unless it is there, and those of clients.
///
/// # Errors
/// A config without a folder, a client that is there already, or a file that cannot be written.
pub(super) fn make(config: &OpcuaConfig, clients: &[NodeName]) -> anyhow::Result<()> {
    let Some(folder) = &config.endpoint.certificates else {
        return wrong_argument(
            "--certificates: the config has no endpoint.certificates, expected a folder",
        );
    };
    for name in clients {
        let of_client = folder.join(CLIENTS).join(name.as_str());
        if of_client.exists() {
            return wrong_argument(format!(
                "--certificates: {} is there already, expected none: delete it, and its file in {TRUSTED}, to make another one",
                of_client.display()
            ));
        }
    }
    let mut lines = Vec::new();
    if !folder.join(OWN_CERTIFICATE).exists() {
        let host = config.endpoint.advertised_host();
        let (certificate, key) = issue(&config.name, &config.application_uri(), Some(&host))?;
        write(&folder.join(OWN_CERTIFICATE), &der(&certificate)?)?;
        write(&folder.join(OWN_KEY), pem(&key)?.as_bytes())?;
        lines.push(format!(
            "{}: the server",
            folder.join(OWN_CERTIFICATE).display()
        ));
    }
    for name in clients {
        lines.push(make_client(folder, name)?);
    }
    writeln!(std::io::stdout(), "{}", lines.join("\n")).context("cannot write the result")
}

fn make_client(folder: &Path, name: &NodeName) -> anyhow::Result<String> {
    let (certificate, key) = issue(name, &application_uri(name), None)?;
    let of_client = folder.join(CLIENTS).join(name.as_str());
    write(&of_client.join(CLIENT_CERTIFICATE), &der(&certificate)?)?;
    write(&of_client.join(CLIENT_KEY), pem(&key)?.as_bytes())?;
    let own = folder.join(OWN_CERTIFICATE);
    let own = fs::read(&own).with_context(|| format!("cannot read {}", own.display()))?;
    write(&of_client.join(SERVER_CERTIFICATE), &own)?;
    // The library looks for it by this name.
    let trusted = folder
        .join(TRUSTED)
        .join(CertificateStore::cert_file_name(&certificate));
    write(&trusted, &der(&certificate)?)?;
    Ok(format!(
        "{}: for the PC of {name}, whose application URI is {}",
        of_client.display(),
        application_uri(name)
    ))
}

/// Checks that the server's certificate and key are there.
///
/// # Errors
/// The field, and the file that cannot be read.
pub(super) fn check(folder: &Path) -> anyhow::Result<()> {
    let wrong = |file: PathBuf, reason: String| {
        anyhow!(
            "endpoint.certificates: {}: {reason}, expected what `coaxle opcua CONFIG --certificates CLIENTS` makes",
            file.display()
        )
    };
    let file = folder.join(OWN_CERTIFICATE);
    let read = CertificateStore::read_cert(&file);
    read.map_err(|_| wrong(file, "received no certificate".to_owned()))?;
    let file = folder.join(OWN_KEY);
    let read = CertificateStore::read_pkey(&file);
    read.map_err(|_| wrong(file, "received no private key".to_owned()))?;
    Ok(())
}

/// Keeps the newest of the certificates that the server did not know.
// The library writes each into a file, and everybody who reaches the port can bring any number.
pub(super) fn prune_rejected(folder: &Path) {
    let Ok(files) = fs::read_dir(folder.join(REJECTED)) else {
        return;
    };
    let dated = |file: fs::DirEntry| Some((file.metadata().ok()?.modified().ok()?, file.path()));
    let mut files: Vec<_> = files.flatten().filter_map(dated).collect();
    files.sort();
    let surplus = files.len().saturating_sub(MOST_REJECTED);
    for (_, file) in files.into_iter().take(surplus) {
        // One that stays is tried again.
        let _ = fs::remove_file(file);
    }
}

fn issue(name: &NodeName, uri: &str, host: Option<&str>) -> anyhow::Result<(X509, PrivateKey)> {
    let host = host.map(|host| vec![host.trim_matches(['[', ']']).to_owned()]);
    // The application URI comes first, by the rules of OPC UA.
    let names = X509Data::alt_host_names(uri, host, true, false, false);
    let data = X509Data {
        key_size: KEY_BITS,
        common_name: name.to_string(),
        organization: "Coaxle".to_owned(),
        organizational_unit: String::new(),
        country: String::new(),
        state: String::new(),
        alt_host_names: names,
        certificate_duration_days: VALID_DAYS,
    };
    X509::cert_and_pkey(&data)
        .map_err(|error| anyhow!("cannot make the certificate of {name}: {error}"))
}

fn der(certificate: &X509) -> anyhow::Result<Vec<u8>> {
    certificate
        .to_der()
        .map_err(|_| anyhow!("cannot encode a certificate"))
}

fn pem(key: &PrivateKey) -> anyhow::Result<String> {
    let cannot = || anyhow!("cannot encode a key");
    let document = key.to_der().map_err(|_| cannot())?;
    // The name of PKCS#8 without a password.
    let pem = document.to_pem("PRIVATE KEY", Default::default());
    pem.map(|pem| pem.to_string()).map_err(|_| cannot())
}

/// Writes a new file that only its owner reads, with the folders on the way.
fn write(file: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let cannot = || format!("cannot write {}", file.display());
    let folder = file.parent().unwrap_or(Path::new(""));
    Os::make_private_folder(folder).with_context(cannot)?;
    // Read by nobody else from its first byte on.
    let mut new = Os::create_file(file, Readers::Owner).with_context(cannot)?;
    new.write_all(bytes).with_context(cannot)
}
