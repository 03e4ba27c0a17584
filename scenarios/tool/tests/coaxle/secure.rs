//! `coaxle secure` as a user starts it.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use crate::shared::{text, written};

const LINE: &str = "name = 'line'\ncycle-time-us = 1000\n[[axis]]\nid = 1\nname = 'belt'\n\
    program = { limits = { velocity = 10, acceleration = 10, jerk = 10 } }\n\
    [transport]\nlisten = ['tcp/127.0.0.1:7447']\n";
const SAW: &str = "name = 'saw'\ncycle-time-us = 1000\nmaster = { node = 'line' }\n\
    [transport]\nconnect = ['tcp/10.0.0.1:7447']\n";

/// Output of the tool in a folder with the configs of both nodes, and its exit code.
fn said(folder: &Path, arguments: &str) -> (String, Option<i32>) {
    written(folder, "line.toml", LINE.as_bytes());
    written(folder, "saw.toml", SAW.as_bytes());
    let output = Command::new(env!("CARGO_BIN_EXE_coaxle"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .output()
        .expect("the tool starts");
    (
        text(&output.stdout) + &text(&output.stderr),
        output.status.code(),
    )
}

fn read(folder: &Path, file: &str) -> String {
    std::fs::read_to_string(folder.join(file)).expect(file)
}

#[test]
fn a_network_is_made_once_and_renewed_with_its_authority() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let folder = folder.path();
    let (first, code) = said(
        folder,
        "secure init line.toml saw.toml --out net --operator anna",
    );
    assert_eq!(code, Some(0), "{first}");
    for part in [
        "net/authority: keep it away",
        "secure = \"saw\"",
        "listen = [\"tls/0.0.0.0:7447\"]",
        "connect = [\"tls/10.0.0.1:7447\"]",
        "coaxle command --secure anna",
    ] {
        assert!(first.contains(part), "{part}: {first}");
    }
    for file in [
        "authority/ca.key",
        "line/key.pem",
        "saw/key.pem",
        "anna/key.pem",
    ] {
        let file = folder.join("net").join(file);
        let mode = file.metadata().expect("a key").permissions().mode();
        assert_eq!(mode & 0o777, 0o600, "{}", file.display());
    }
    let authority = read(folder, "net/authority/ca.pem");
    assert_eq!(read(folder, "net/saw/ca.pem"), authority);
    assert!(read(folder, "net/anna/zenoh.json5").contains("tls/10.0.0.1:7447"));

    let (again, code) = said(folder, "secure init line.toml saw.toml --out net");
    assert_eq!(code, Some(2), "{again}");
    assert!(again.contains("is there already"), "{again}");

    let old = ["line", "saw"].map(|node| read(folder, &format!("net/{node}/cert.pem")));
    let (renewed, code) = said(
        folder,
        "secure renew line.toml saw.toml --out net --operator bert --only saw,bert",
    );
    assert_eq!(code, Some(0), "{renewed}");
    assert_eq!(read(folder, "net/line/cert.pem"), old[0]);
    assert_ne!(read(folder, "net/saw/cert.pem"), old[1]);
    assert_eq!(read(folder, "net/bert/ca.pem"), authority);
    let rights = read(folder, "net/saw/zenoh.json5");
    assert!(
        rights.contains("command/bert") && !rights.contains("command/anna"),
        "{rights}"
    );
}

#[test]
fn a_pair_has_its_timing_key_and_a_revocation_goes_to_every_folder() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let folder = folder.path();
    let members = "line.toml saw.toml --out net --operator anna";
    let (text, code) = said(folder, &format!("secure init {members}"));
    assert_eq!(code, Some(0), "{text}");
    let key = |file: &str| {
        let text = read(folder, file);
        let last = text.lines().last().expect("a key").to_owned();
        last.split_once(' ')
            .map(|(node, key)| (node.to_owned(), key.to_owned()))
    };
    let (line, saw) = (key("net/line/timing.keys"), key("net/saw/timing.keys"));
    let ((follower, of_line), (followed, of_saw)) = line.zip(saw).expect("two keys");
    assert_eq!((follower.as_str(), followed.as_str()), ("saw", "line"));
    assert_eq!(of_line, of_saw);
    let secret = read(folder, "net/authority/timing.secret");
    assert!(!of_line.contains(secret.trim()), "the secret stays there");
    for file in ["authority/timing.secret", "line/timing.keys"] {
        let file = folder.join("net").join(file);
        let mode = file.metadata().expect("a key").permissions().mode();
        assert_eq!(mode & 0o777, 0o600, "{}", file.display());
    }
    assert!(!folder.join("net/anna/timing.keys").exists());
    assert!(!folder.join("net/saw/revoked.list").exists());

    // A network of an earlier version: its secret was in every folder, so it is drawn again.
    for node in ["authority", "saw"] {
        let file = folder.join(format!("net/{node}/timing.key"));
        std::fs::write(file, &secret).expect("a file");
    }
    std::fs::remove_file(folder.join("net/authority/timing.secret")).expect("it is there");
    let (text, code) = said(folder, &format!("secure renew {members} --revoke saw,bert"));
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("earlier certificates of bert, saw are revoked"),
        "{text}"
    );
    assert!(!folder.join("net/saw/timing.key").exists());
    assert_ne!(read(folder, "net/authority/timing.secret"), secret);
    let list = read(folder, "net/authority/revoked.list");
    for member in ["line", "saw", "anna"] {
        assert_eq!(read(folder, &format!("net/{member}/revoked.list")), list);
    }
    // The list stays, and a later one has a higher number.
    let (text, code) = said(folder, &format!("secure renew {members} --only line"));
    assert!(code == Some(0) && text.contains("number 1"), "{text}");
    let (text, code) = said(folder, &format!("secure renew {members} --revoke line"));
    assert!(code == Some(0) && text.contains("number 2"), "{text}");
    assert!(read(folder, "net/saw/revoked.list").contains(" bert\n"));
    std::fs::write(
        folder.join("net/authority/revoked.list"),
        list.replace("bert", "anna"),
    )
    .expect("a file");
    let (text, code) = said(folder, &format!("secure renew {members}"));
    assert_eq!(code, Some(78), "{text}");
    assert!(text.contains("it is not signed by the authority"), "{text}");
}

#[test]
fn what_makes_no_network_is_said_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let folder = folder.path();
    for (arguments, code, expected) in [
        ("secure init saw.toml --out net", 2, "expected its config"),
        (
            "secure init line.toml --out net --operator line",
            2,
            "twice",
        ),
        (
            "secure init line.toml --out net --at line",
            2,
            "expected NODE=HOST",
        ),
        (
            "secure init line.toml --out net --operator a/b",
            2,
            "is no node name",
        ),
        (
            "secure init line.toml --out net --valid-days 0",
            2,
            "1..=3650",
        ),
        (
            "secure init nowhere.toml --out net",
            78,
            "nowhere.toml: cannot be read",
        ),
        (
            "secure renew line.toml --out net",
            78,
            "expected what `coaxle secure init` wrote",
        ),
    ] {
        let (said, found) = said(folder, arguments);
        assert_eq!(found, Some(code), "{said}");
        assert!(said.contains(expected), "{arguments}: {said}");
        assert!(!folder.join("net").exists(), "{arguments}");
    }
}
