//! Attempts at a network under the secure profile, with real certificates over real Zenoh on loopback: forbidden messages
//! do not reach their target, and permitted ones do, in the same sessions. `docs/SECURE.md`
//! lists the attempts.
//!
//! That a message does not arrive is judged by a later one on the same link that did arrive, so no test
//! here waits for a time to pass.

mod flood;
mod network;
mod processes;
mod revocation;

use coaxle::secure::{MAX_FRAME_BYTES, MAX_MESSAGE_BYTES};
use coaxle_host::network::credentials::Authority;
use coaxle_test_process::until;
use network::{Session, TestNetwork, expired, year};

/// The line with its regular declarations.
fn line(network: &TestNetwork) -> Session {
    let mut line = network.member("line");
    line.announce("coaxle/line/alive");
    line.record("coaxle/line/time-requests");
    line.watch("coaxle/line/seen-by/*");
    line.serve("coaxle/line/command");
    line.serve("coaxle/line/command/*");
    line
}

fn saw(network: &TestNetwork) -> Session {
    as_saw(network.member("saw"))
}

fn as_saw(mut saw: Session) -> Session {
    for far in ["line", "press"] {
        saw.record(&format!("coaxle/{far}/axes"));
        saw.record(&format!("coaxle/{far}/time-responses"));
        saw.watch(&format!("coaxle/{far}/alive"));
    }
    saw.announce("coaxle/saw/alive");
    saw.record("coaxle/saw/time-requests");
    saw.serve("coaxle/saw/command");
    saw.serve("coaxle/saw/command/*");
    saw
}

/// Checks that the regular messages still pass.
fn follows(saw: &Session, line: &mut Session) {
    // Sent again and again: a message before the link exists is lost.
    until("saw hears line", || {
        line.publish("coaxle/line/axes", "frame");
        line.publish("coaxle/line/time-responses", "response");
        saw.saw("coaxle/line/axes frame") && saw.saw("coaxle/line/time-responses response")
    });
    until("saw sees that line is alive", || {
        saw.saw("coaxle/line/alive is there")
    });
}

#[test]
fn members_hear_ask_and_command_each_other() {
    let network = TestNetwork::new();
    let (mut line, mut saw) = (line(&network), saw(&network));
    follows(&saw, &mut line);
    until("line is asked", || {
        saw.publish("coaxle/line/time-requests", "when?");
        line.saw("coaxle/line/time-requests when?")
    });
    let mut anna = network.member("anna");
    anna.watch("coaxle/saw/alive");
    anna.record("coaxle/saw/status");
    until("anna commands saw", || {
        anna.request("coaxle/saw/command/anna", "halt").is_some()
    });
    assert!(saw.saw("coaxle/saw/command/anna halt"));
    until("anna sees saw", || {
        saw.publish("coaxle/saw/status", "{}");
        anna.saw("coaxle/saw/alive is there") && anna.saw("coaxle/saw/status {}")
    });
    let bert = network.member("bert");
    until("bert commands line", || {
        bert.request("coaxle/line/command/bert", "halt").is_some()
    });
    assert!(line.saw("coaxle/line/command/bert halt"));
}

#[test]
fn who_has_no_certificate_of_ours_that_holds_gets_no_link() {
    let network = TestNetwork::new();
    let (mut line, saw) = (line(&network), saw(&network));
    follows(&saw, &mut line);
    // Same names, another key.
    let theirs = Authority::new(year()).expect("an authority");
    let mut strangers = [
        ("without a certificate", network.nameless("saw")),
        (
            "of another authority",
            network.rogue_with("line", "saw", &theirs, year()),
        ),
        (
            "expired",
            network.rogue_with("line", "saw", &network.authority, expired()),
        ),
        ("without TLS", network.plain("saw")),
    ];
    // Each retries four times a second: long enough for several attempts of all, measured by saw's messages from line.
    for round in 0..300 {
        let text = format!("round {round}");
        for (who, stranger) in &mut strangers {
            stranger.publish("coaxle/line/axes", who);
        }
        until("saw hears line", || {
            line.publish("coaxle/line/axes", &text);
            saw.saw(&format!("coaxle/line/axes {text}"))
        });
        std::thread::park_timeout(std::time::Duration::from_millis(10));
    }
    for (who, stranger) in &strangers {
        assert!(
            !saw.saw(&format!("coaxle/line/axes {who}")),
            "{who}: {:?}",
            saw.seen()
        );
        assert_eq!(
            stranger.request("coaxle/saw/command/anna", who),
            None,
            "{who}"
        );
        assert!(!saw.saw(&format!("coaxle/saw/command/anna {who}")), "{who}");
    }
}

#[test]
fn a_name_that_nobody_knows_has_a_link_and_no_rights() {
    let network = TestNetwork::new();
    let (mut line, saw) = (line(&network), saw(&network));
    let mut mallory = network.rogue("mallory", "line");
    mallory.record("coaxle/**");
    mallory.watch("coaxle/line/alive");
    follows(&saw, &mut line);
    for _ in 0..3 {
        mallory.publish("coaxle/line/time-requests", "mallory");
        mallory.publish("coaxle/mallory/axes", "mallory");
        assert_eq!(mallory.request("coaxle/line/command/anna", "mallory"), None);
        assert_eq!(
            mallory.request("coaxle/line/command/mallory", "mallory"),
            None
        );
        assert_eq!(mallory.request("coaxle/line/command", "mallory"), None);
    }
    assert!(
        !line.seen().iter().any(|seen| seen.contains("mallory")),
        "{:?}",
        line.seen()
    );
    // Its own messages are all that it receives.
    assert!(
        mallory.seen().iter().all(|seen| seen.ends_with("mallory")),
        "{:?}",
        mallory.seen()
    );
}

#[test]
fn a_member_is_itself_and_nobody_else() {
    let network = TestNetwork::new();
    let saw = saw(&network);
    let mut press = network.rogue("press", "saw");
    press.announce("coaxle/line/alive");
    press.announce("coaxle/press/alive");
    until("saw sees that press is alive", || {
        saw.saw("coaxle/press/alive is there")
    });
    // The low-pass filter of the rights stops longer frames; 2000 bytes pass.
    let long = "x".repeat(MAX_FRAME_BYTES + 1);
    until("saw hears press", || {
        press.publish("coaxle/line/axes", "forged");
        press.publish("coaxle/line/time-responses", "forged");
        press.publish("coaxle/line/status", "forged");
        press.publish("coaxle/press/axes", &long);
        press.publish("coaxle/press/axes", &"y".repeat(2_000));
        press.publish("coaxle/press/time-responses", "its own");
        saw.saw("coaxle/press/axes 2000") && saw.saw("coaxle/press/time-responses its own")
    });
    assert!(
        !saw.seen().iter().any(|seen| seen.contains("forged")),
        "{:?}",
        saw.seen()
    );
    assert!(!saw.saw("coaxle/line/alive is there"), "as press says");
    assert!(!saw.saw(&format!("coaxle/press/axes {}", long.len())));
    for key in [
        "coaxle/saw/command",
        "coaxle/saw/command/press",
        "coaxle/saw/command/anna",
        "coaxle/*/command/*",
    ] {
        assert_eq!(press.request(key, "forged"), None, "{key}");
    }
    assert!(
        !saw.seen().iter().any(|seen| seen.contains("/command")),
        "{:?}",
        saw.seen()
    );

    // A message longer than permitted costs its sender the link, at most.
    press.publish("coaxle/press/axes", &"z".repeat(MAX_MESSAGE_BYTES + 1));
    let mut line = line(&network);
    follows(&saw, &mut line);
    assert!(!saw.saw(&format!("coaxle/press/axes {}", MAX_MESSAGE_BYTES + 1)));
}

#[test]
fn who_hears_a_node_says_so_for_itself_alone() {
    let network = TestNetwork::new();
    let line = line(&network);
    let mut saw = network.rogue("saw", "line");
    saw.announce("coaxle/line/seen-by/press");
    saw.announce("coaxle/line/seen-by/saw");
    until("line is told", || {
        line.saw("coaxle/line/seen-by/saw is there")
    });
    assert!(!line.saw("coaxle/line/seen-by/press is there"));
}

#[test]
fn an_operator_commands_where_it_may_and_as_itself() {
    let network = TestNetwork::new();
    let (line, saw) = (line(&network), saw(&network));
    let bert = network.rogue("bert", "line");
    until("bert commands line", || {
        bert.request("coaxle/line/command/bert", "its own")
            .is_some()
    });
    for key in [
        "coaxle/line/command",
        "coaxle/line/command/anna",
        "coaxle/line/command/*",
    ] {
        assert_eq!(bert.request(key, "forged"), None, "{key}");
    }
    let bert = network.rogue("bert", "saw");
    for _ in 0..3 {
        assert_eq!(bert.request("coaxle/saw/command/bert", "forged"), None);
    }
    for victim in [&line, &saw] {
        assert!(
            !victim.seen().iter().any(|seen| seen.contains("forged")),
            "{:?}",
            victim.seen()
        );
    }
}

#[test]
fn the_audit_of_a_node_is_for_operators_of_it_and_nobody_else() {
    let network = TestNetwork::new();
    let (mut line, saw) = (line(&network), saw(&network));
    line.serve("coaxle/line/audit");
    let mut anna = network.member("anna");
    anna.record("coaxle/line/audit");
    until("anna reads the audit of line", || {
        line.publish("coaxle/line/audit", "record");
        anna.saw("coaxle/line/audit record")
            && anna.request("coaxle/line/audit", "newest").is_some()
    });
    // A follower, another sender, and an operator of other nodes only; links of each to its victim are there.
    let mut press = network.rogue("press", "saw");
    until("saw hears press", || {
        press.publish("coaxle/press/axes", "its own");
        saw.saw("coaxle/press/axes its own")
    });
    follows(&saw, &mut line);
    let mut follower = network.rogue("saw", "line");
    follower.record("coaxle/line/audit");
    follower.record("coaxle/line/axes");
    until("the follower hears line", || {
        line.publish("coaxle/line/axes", "frame");
        line.publish("coaxle/line/audit", "record");
        follower.saw("coaxle/line/axes frame")
    });
    assert_eq!(follower.request("coaxle/line/audit", "stolen"), None);
    assert!(
        !follower.seen().iter().any(|seen| seen.contains("audit")),
        "{:?}",
        follower.seen()
    );
    // Nor does a node believe records of another one, or an operator those of somebody else.
    press.publish("coaxle/line/audit", "forged");
    assert_eq!(press.request("coaxle/saw/audit", "stolen"), None);
    for seen in [line.seen(), saw.seen(), anna.seen()] {
        let is_bad = |seen: &String| seen.contains("stolen") || seen.contains("forged");
        assert!(!seen.iter().any(is_bad), "{seen:?}");
    }
}

#[test]
fn without_rights_at_the_victim_the_same_attempts_succeed() {
    // The counter-test: attempts that fail for another reason than the rights would prove nothing.
    let network = TestNetwork::new();
    let saw = as_saw(network.member_without_rights("saw"));
    let mut press = network.rogue("press", "saw");
    press.announce("coaxle/line/alive");
    let long = "x".repeat(MAX_FRAME_BYTES + 1);
    until("saw believes press", || {
        press.publish("coaxle/line/axes", "forged");
        press.publish("coaxle/line/time-responses", "forged");
        press.publish("coaxle/press/axes", &long);
        saw.saw("coaxle/line/axes forged")
            && saw.saw("coaxle/line/time-responses forged")
            && saw.saw("coaxle/line/alive is there")
            && saw.saw(&format!("coaxle/press/axes {}", long.len()))
    });
    let bert = network.rogue("bert", "saw");
    for key in [
        "coaxle/saw/command",
        "coaxle/saw/command/anna",
        "coaxle/saw/command/bert",
    ] {
        until(key, || bert.request(key, "forged").is_some());
    }
}

#[test]
fn nobody_takes_the_orders_of_another_node() {
    let network = TestNetwork::new();
    let saw = saw(&network);
    // Press is at its own address, with its own certificate, and claims to be the saw, too.
    let mut press = network.rogue_at("press");
    press.serve("coaxle/saw/command/*");
    press.serve("coaxle/press/command/*");
    let anna = network.member("anna");
    until("anna commands press", || {
        anna.request("coaxle/press/command/anna", "halt").is_some()
    });
    until("anna commands saw", || {
        anna.request("coaxle/saw/command/anna", "halt").is_some()
    });
    assert!(saw.saw("coaxle/saw/command/anna halt"));
    assert!(press.saw("coaxle/press/command/anna halt"));
    assert!(
        !press.saw("coaxle/saw/command/anna halt"),
        "{:?}",
        press.seen()
    );
}
