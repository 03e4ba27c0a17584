use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::time::Duration;

use serde_json::json;

use super::*;

/// A text that changes append words to.
struct Words;

impl Design for Words {
    const MOST_BYTES: u64 = 100;

    fn template(&self) -> String {
        "new".to_owned()
    }

    fn view(&mut self, text: &str, asked: &Value) -> Value {
        json!({ "length": text.len(), "asked": asked })
    }

    fn changed(&mut self, text: &str, change: &Value, _: &Value) -> Result<String, String> {
        let word = change.as_str().ok_or("expected a word")?;
        Ok(format!("{text} {word}"))
    }

    fn check(&self, text: &str) -> Result<(), String> {
        if text.contains("bad") {
            return Err("received bad".to_owned());
        }
        Ok(())
    }

    fn act(&mut self, _: &str, wanted: &Value) -> Result<String, String> {
        Ok(format!("did {wanted}"))
    }
}

fn page(file: &Path) -> PageServer {
    let args = EditArgs {
        file: file.to_owned(),
        page: Some("127.0.0.1:0".parse().unwrap()),
    };
    let parts = PageParts {
        html: "<!doctype html>the page",
        js: "'its script'",
    };
    open(&args, Words, parts).unwrap()
}

/// The response to a request, with its head.
fn asked(address: SocketAddr, request: &str, headers: &str, body: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(60)))
        .unwrap();
    let length = body.len();
    let request = format!(
        "{request} HTTP/1.1\r\nConnection: close\r\nContent-Length: {length}\r\n{headers}\r\n{body}"
    );
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

fn token(page: &PageServer) -> String {
    let url = page.url();
    let (_, token) = url.split_once("/?token=").unwrap();
    token.to_owned()
}

fn done(page: &PageServer, what: &str, said: &Value) -> Value {
    let headers = format!(
        "Host: {}\r\nx-coaxle-page: {}\r\n",
        page.address(),
        token(page)
    );
    let answer = asked(
        page.address(),
        &format!("POST /do/{what}"),
        &headers,
        &said.to_string(),
    );
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    assert!(head.contains("200 OK"), "{answer}");
    serde_json::from_str(body).unwrap()
}

fn change(word: &str, gesture: Option<u64>) -> Value {
    json!({ "change": word, "gesture": gesture })
}

#[test]
fn a_new_file_is_made_when_it_is_saved_and_changed_back_and_forth() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("new.toml");
    let page = page(&file);
    let none = json!({});
    let begun = done(&page, "view", &json!({ "asked": { "n": 1 } }));
    assert_eq!(begun["text"], "new");
    assert_eq!(
        (&begun["is_new"], &begun["is_saved"]),
        (&json!(true), &json!(false))
    );
    assert_eq!(begun["view"], json!({ "length": 3, "asked": { "n": 1 } }));
    assert!(!file.exists());
    // A drag is one step, however many changes it is.
    done(&page, "change", &change("a", None));
    for word in ["b", "c"] {
        done(&page, "change", &change(word, Some(1)));
    }
    let undone = done(&page, "undo", &none);
    assert_eq!(
        (&undone["text"], &undone["can_redo"]),
        (&json!("new a"), &json!(true))
    );
    assert_eq!(done(&page, "redo", &none)["text"], "new a b c");
    let saved = done(&page, "save", &none);
    assert_eq!(
        (&saved["is_saved"], &saved["is_new"]),
        (&json!(true), &json!(false))
    );
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "new a b c");
    let refused = done(&page, "change", &json!({ "change": 7 }));
    assert_eq!(refused["refused"], "expected a word");
    done(&page, "change", &change("bad", None));
    assert_eq!(
        done(&page, "save", &none)["refused"],
        "not saved: received bad"
    );
    let long = json!({ "change": { "text": "x".repeat(101) } });
    let refused = done(&page, "change", &long)["refused"].to_string();
    assert!(
        refused.contains("received 101 bytes, expected at most 100"),
        "{refused}"
    );
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "new a b c");
    assert_eq!(
        done(&page, "act", &json!({ "change": "it" }))["told"],
        "did \"it\""
    );
}

#[test]
fn what_somebody_else_has_written_meanwhile_stays() {
    let folder = tempfile::tempdir().unwrap();
    let [old, new] = ["old.toml", "new.toml"].map(|name| folder.path().join(name));
    std::fs::write(&old, "old").unwrap();
    let pages = [page(&old), page(&new)];
    assert_eq!(done(&pages[0], "view", &json!({}))["is_saved"], true);
    for (page, file) in pages.iter().zip([&old, &new]) {
        done(page, "change", &change("mine", None));
        std::fs::write(file, "theirs").unwrap();
        let refused = done(page, "save", &json!({}))["refused"].to_string();
        assert!(refused.contains("somebody else"), "{refused}");
        assert_eq!(std::fs::read_to_string(file).unwrap(), "theirs");
    }
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

#[test]
fn other_pages_neither_look_nor_change() {
    let folder = tempfile::tempdir().unwrap();
    let page = page(&folder.path().join("new.toml"));
    let host = format!("Host: {}\r\n", page.address());
    let ask =
        |request: &str, headers: &str, body: &str| asked(page.address(), request, headers, body);
    assert!(ask("GET /", "Host: evil.example\r\n", "").contains(" 403 "));
    assert!(ask("POST /do/undo", &host, "{}").contains(" 403 "));
    // Nor any other program on this PC.
    let unknown = format!("{host}x-coaxle-page: 1\r\n");
    assert!(ask("POST /do/undo", &unknown, "{}").contains("with ?token="));
    let own = format!("{host}x-coaxle-page: {}\r\n", token(&page));
    assert!(ask("POST /do/undo", &own, "{}").contains(" 200 "));
    assert!(ask("POST /do/undo", &own, "{").contains(" 400 "));
    assert!(ask("POST /do/undo", &own, "{\"chnge\":1}").contains("unknown field"));
    assert!(ask("POST /do/dance", &own, "{}").contains(" 404 "));
    for file in [
        "/",
        "/base.css",
        "/edit.css",
        "/axes.js",
        "/edit.js",
        "/page.js",
    ] {
        let answer = ask(&format!("GET {file}"), &host, "");
        assert!(
            answer.contains(" 200 ") && answer.contains("default-src 'self'"),
            "{file}"
        );
    }
}

#[test]
fn a_file_that_cannot_be_read_is_not_edited() {
    let folder = tempfile::tempdir().unwrap();
    let args = EditArgs {
        file: folder.path().to_owned(),
        page: Some("127.0.0.1:0".parse().unwrap()),
    };
    let parts = PageParts { html: "", js: "" };
    let refused = open(&args, Words, parts).err().unwrap().to_string();
    assert!(
        refused.contains("cannot be read: received a folder"),
        "{refused}"
    );
}

#[test]
fn values_change_in_their_places() {
    let text = "# a saw\nx = 1 # one\n[limits] # all\njerk = 2.5 # high\n";
    let mut document = toml_text::document(text).unwrap();
    toml_text::put_at(&mut document, "x", Some(toml_text::number(90.0))).unwrap();
    toml_text::put_at(&mut document, "limits.jerk", Some(toml_text::number(0.5))).unwrap();
    toml_text::put_at(&mut document, "other.deep", Some("y".into())).unwrap();
    toml_text::put_at(&mut document, "none.deep", None).unwrap();
    let expected =
        "# a saw\nx = 90 # one\n[limits] # all\njerk = 0.5 # high\n\n[other]\ndeep = \"y\"\n";
    assert_eq!(document.to_string(), expected);
    let refused = toml_text::put_at(&mut document, "x.y", Some(1.into())).unwrap_err();
    assert_eq!(refused, "x: received no table, expected one");
    assert!(
        toml_text::document("x = = 1")
            .unwrap_err()
            .contains("not valid TOML")
    );
}

#[test]
fn a_second_designer_takes_another_port() {
    let args = EditArgs {
        file: PathBuf::from("a"),
        page: None,
    };
    // Somebody has the usual one from here on, if not before.
    let _taken = TcpListener::bind((Ipv4Addr::LOCALHOST, PORT));
    assert_eq!(args.address().port(), 0);
}
