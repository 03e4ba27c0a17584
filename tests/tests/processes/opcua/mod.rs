//! `coaxle opcua`: a third-party client in Python browses, reads, subscribes, commands a slave, and is refused. Without Python with
//! asyncua there is nothing to test with.

mod world;

use coaxle_test_process::until;
use serde_json::{Value, json};
use world::{PythonClient, ServedPlant};

const POSITION: &str = "saw/slaves/carriage/position";

#[test]
fn somebody_elses_client_sees_the_nodes_and_moves_a_saw() {
    let Some(world) = ServedPlant::plain() else {
        return;
    };
    let server = world.server();
    until("the server is there", || {
        server.logged("OPC UA at opc.tcp://127.0.0.1")
    });
    let mut client = world.client("client", None);
    let connected = client.response("the client connects", &["connected", "refused"]);
    assert!(
        connected["connected"][0]
            .as_str()
            .is_some_and(|policy| policy.ends_with("#None")),
        "{connected}"
    );
    objects_are_there(&mut client);
    values_have_units_and_times(&mut client);
    client.ask(&json!({ "do": "events" }));
    client.ask(&json!({ "do": "subscribe", "path": POSITION }));
    a_saw_is_commanded(&mut client);
    what_is_wrong_is_named(&mut client, &server.log());
    a_second_server_ends_at_once(&world);
    what_goes_is_an_event(&world, &mut client);
    client.end();
    server.signal("INT");
    assert_eq!(server.wait().code(), Some(0), "{}", server.log());
}

fn objects_are_there(client: &mut PythonClient) {
    for (path, child) in [
        ("/", "saw"),
        ("/", "conveyor"),
        ("saw/slaves", "saw/slaves/carriage"),
        ("saw/far", "saw/far/conveyor"),
        ("conveyor/axes", "conveyor/axes/belt"),
        ("saw/slaves/carriage", POSITION),
        ("saw/slaves/carriage", "saw/slaves/carriage:gear-in-pos"),
        ("saw/far/conveyor", "saw/far/conveyor:filter-mode"),
    ] {
        until(child, || {
            let children = client.ask(&json!({ "do": "browse", "path": path }));
            children
                .as_array()
                .is_some_and(|all| all.iter().any(|one| one == child))
        });
    }
}

fn values_have_units_and_times(client: &mut PythonClient) {
    client.until(POSITION, |read| {
        read["value"] == 0.0 && read["status"] == "Good"
    });
    let read = client.read(POSITION);
    // "MMT" of UNECE Recommendation 20.
    let unit = json!([
        5_066_068,
        "mm",
        "http://www.opcfoundation.org/UA/units/un/cefact"
    ]);
    assert_eq!(read["unit"], unit, "{read}");
    let first = read["source"].as_f64().expect("a time of the source");
    let age = read["age"].as_f64().expect("an age");
    // Both by the time of day of this PC; a busy machine is late, never early.
    assert!((-0.1..60.0).contains(&age), "{read}");
    client.until(POSITION, |read| read["source"].as_f64() > Some(first));
    client.until("saw/health", |read| read["value"] == "ok");
    client.until("saw/far/conveyor/synced", |read| read["value"] == true);
    let velocity = client.read("conveyor/axes/belt/velocity");
    assert_eq!(
        (&velocity["value"], &velocity["unit"][1]),
        (&json!(500.0), &json!("mm/s")),
        "{velocity}"
    );
}

fn a_saw_is_commanded(client: &mut PythonClient) {
    let power = "saw/slaves/carriage:power";
    let dry = client.call(power, &json!([true, true]));
    assert_eq!(
        (&dry["accepted"], &dry["job"]),
        (&json!(true), &json!(0)),
        "{dry}"
    );
    let state = "saw/slaves/carriage/state";
    assert_eq!(
        client.read(state)["value"],
        "disabled",
        "a dry run moves nothing"
    );
    let on = client.call(power, &json!([false, true]));
    assert_eq!(on["accepted"], true, "{on}");
    client.until(state, |read| read["value"] == "standstill");

    let saw = "saw/slaves/carriage:gear-in-pos";
    let ahead = |dry_run: bool| {
        json!({
            "dry-run": dry_run, "ratio.numerator": 1.0,
            "master-sync-position": "{ \"ahead\": 2000 }", "slave-sync-position": "{ \"ahead\": 200 }",
        })
    };
    let planned = client.call_named(saw, &ahead(true));
    assert_eq!(planned["accepted"], true, "{planned}");
    let response: Value =
        serde_json::from_str(planned["response"].as_str().unwrap_or_default()).expect("JSON");
    assert!(
        response["saw"]["peak-velocity"].as_f64().is_some(),
        "{response}"
    );
    let cut = client.call_named(saw, &ahead(false));
    assert!(
        cut["accepted"] == true && cut["job"].as_u64() > Some(0),
        "{cut}"
    );
    client.until("saw/slaves/carriage/phase", |read| {
        read["value"] == "in-sync"
    });
    client.until("saw/slaves/carriage/velocity", |read| {
        read["value"]
            .as_f64()
            .is_some_and(|v| (v - 500.0).abs() < 5.0)
    });
    let halted = client.call_named("saw/slaves/carriage:halt", &json!({ "dry-run": false }));
    assert_eq!(halted["accepted"], true, "{halted}");
    client.until(state, |read| read["value"] == "standstill");
    let moved = client.printed();
    let positions = moved.iter().filter(|line| line["changed"] == POSITION);
    let positions: Vec<_> = positions
        .filter_map(|line| line["value"].as_f64())
        .collect();
    assert!(
        positions.len() > 10 && positions[positions.len() - 1] > 200.0,
        "{positions:?}"
    );
}

fn what_is_wrong_is_named(client: &mut PythonClient, log: &str) {
    let before = client.read(POSITION)["value"].clone();
    let moving = "saw/slaves/carriage:move-absolute";
    let refused = client.call_named(
        moving,
        &json!({ "dry-run": false, "position": 0.0, "velocity": 900.0 }),
    );
    assert_eq!(
        (&refused["accepted"], &refused["outcome"]),
        (&json!(false), &json!("refused")),
        "{refused}"
    );
    let text = refused["text"].as_str().unwrap_or_default();
    assert!(
        text.contains("velocity: received 900, expected at most 800"),
        "{text}"
    );
    let nan = json!({ "dry-run": false, "position": { "double": "nan" } });
    let nan = client.call_named(moving, &nan);
    assert!(
        nan["status"] == "BadInvalidArgument"
            && nan["arguments"]
                .as_array()
                .is_some_and(|all| all.iter().any(|one| one == "BadOutOfRange")),
        "{nan}"
    );
    let words = client.call_named(moving, &json!({ "dry-run": false, "position": "far" }));
    assert!(
        words["arguments"]
            .as_array()
            .is_some_and(|all| all.iter().any(|one| one == "BadTypeMismatch")),
        "{words}"
    );
    let none = client.call(moving, &json!([]));
    assert!(
        none["status"]
            .as_str()
            .is_some_and(|status| status.starts_with("Bad")),
        "{none}"
    );
    let mode = client.call("saw/far/conveyor:filter-mode", &json!([true, "wild"]));
    assert!(
        mode["outcome"] == "not-taken"
            && mode["text"]
                .as_str()
                .is_some_and(|text| text.contains("wild")),
        "{mode}"
    );
    let json = client.call(
        "saw/slaves/carriage:execute",
        &json!([false, "{ \"dance\": {} }"]),
    );
    assert!(
        json["text"]
            .as_str()
            .is_some_and(|text| text.contains("dance")),
        "{json}"
    );
    for unknown in ["saw/slaves/blade:halt", "mill/slaves/blade:halt"] {
        let gone = client.call(unknown, &json!([false]));
        assert!(
            gone["status"]
                .as_str()
                .is_some_and(|status| status.starts_with("Bad")),
            "{gone}"
        );
    }
    assert_eq!(
        client.read(POSITION)["value"],
        before,
        "nothing of this moves it"
    );
    assert!(
        log.contains("order of \"anonymous\": MC_Power to \"saw/carriage\": accepted"),
        "{log}"
    );
}

fn a_second_server_ends_at_once(world: &ServedPlant) {
    let second = world.run("opcua opcua.toml");
    let text = String::from_utf8_lossy(&second.stderr);
    assert_eq!(second.status.code(), Some(1), "{text}");
    assert!(
        text.contains("endpoint.listen: cannot listen on 127.0.0.1:"),
        "{text}"
    );
}

fn what_goes_is_an_event(world: &ServedPlant, client: &mut PythonClient) {
    world.conveyor.signal("INT");
    let event = |client: &PythonClient, text: &str| {
        let printed = client.printed();
        printed.iter().any(|line| {
            line["event"]
                .as_str()
                .is_some_and(|event| event.contains(text))
        })
    };
    until("the loss of the conveyor is an event", || {
        event(client, "conveyor is gone") && event(client, "health of saw: ok")
    });
    world.saw.signal("INT");
    until("the end of the saw is an event", || {
        event(client, "saw is gone")
    });
    client.until(POSITION, |read| {
        read["status"] == "UncertainNoCommunicationLastUsableValue"
    });
    let gone = client.call("saw/slaves/carriage:power", &json!([false, true]));
    let text = gone["text"].as_str().unwrap_or_default();
    assert!(
        gone["outcome"] == "no-response"
            && text.contains("node saw takes no orders: it is not there"),
        "{gone}"
    );
}

#[test]
fn in_a_secure_network_clients_have_names_and_rights() {
    let Some(world) = ServedPlant::secure() else {
        return;
    };
    let port = world.port;
    let text = format!(
        "name = 'opcua'\nendpoint = {{ listen = '127.0.0.1:{port}', certificates = 'pki' }}\n\
         rights = {{ commanders = ['anna'] }}\n[transport]\nsecure = 'net/opcua'\n"
    );
    std::fs::write(world.folder.path().join("opcua.toml"), text).expect("a config");
    let missing = world.run("opcua opcua.toml --check");
    let text = String::from_utf8_lossy(&missing.stderr).into_owned();
    assert!(
        missing.status.code() == Some(78) && text.contains("endpoint.certificates"),
        "{text}"
    );
    for line in [
        "opcua opcua.toml --certificates anna,bert,carl",
        "opcua opcua.toml --check",
    ] {
        let good = world.run(line);
        assert!(good.status.success(), "{line}: {good:?}");
    }
    // A certificate that is not among the trusted ones.
    let trusted = world.folder.path().join("pki/trusted");
    for file in std::fs::read_dir(&trusted).expect("a folder").flatten() {
        if file.file_name().to_string_lossy().contains("carl") {
            std::fs::remove_file(file.path()).expect("its file");
        }
    }
    let server = world.server();
    until("the server is there", || server.logged("OPC UA at"));

    let mut anna = world.client("anna", Some("anna"));
    let connected = anna.response("anna connects", &["connected", "refused"]);
    assert!(
        connected["connected"][0]
            .as_str()
            .is_some_and(|policy| policy.ends_with("#Basic256Sha256")),
        "{connected}"
    );
    anna.until(POSITION, |read| read["value"] == 0.0);
    let power = "saw/slaves/carriage:power";
    let on = anna.call(power, &json!([false, true]));
    assert_eq!(on["accepted"], true, "{on}");
    anna.until("saw/slaves/carriage/state", |read| {
        read["value"] == "standstill"
    });
    until("the node has the operator", || {
        world
            .saw
            .logged("order of \"opcua\": MC_Power to \"carriage\": accepted")
    });
    assert!(
        server.logged("order of \"anna\": MC_Power to \"saw/carriage\": accepted"),
        "{}",
        server.log()
    );

    let mut bert = world.client("bert", Some("bert"));
    bert.response("bert connects", &["connected"]);
    bert.until(POSITION, |read| read["value"] == 0.0);
    let refused = bert.call(power, &json!([true, true]));
    assert_eq!(refused["status"], "BadUserAccessDenied", "{refused}");
    let record =
        "order of \"bert\": power to \"saw/carriage\": refused, rights.commanders names anna only";
    assert!(server.logged(record), "{}", server.log());

    for (log, certificates, expected) in [
        ("carl", Some("carl"), "BadCertificateUntrusted"),
        // Its own library says that the server has nothing without security.
        ("nobody", None, "No matching endpoints"),
    ] {
        let mut stranger = world.client(log, certificates);
        stranger.may_end();
        let refused = stranger.response("a stranger is refused", &["connected", "refused"]);
        let reason = refused["refused"].as_str().unwrap_or_default();
        assert!(reason.contains(expected), "{log}: {refused}");
    }
    anna.end();
    bert.end();
    server.signal("INT");
    assert_eq!(server.wait().code(), Some(0), "{}", server.log());
}

#[test]
fn a_wrong_config_of_a_server_is_named() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    for (text, expected) in [
        ("name = 'a'\nport = 1", "port"),
        ("name = 'a'\n[endpoint]\nlisten = 4840", "endpoint.listen"),
        (
            "name = 'a'\n[transport]\nconnect = ['tcp/127.0.0.1:1']",
            "endpoint.certificates: received none",
        ),
    ] {
        let file = folder.path().join("opcua.toml");
        std::fs::write(&file, text).expect("a config");
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"))
            .arg("opcua")
            .arg(&file)
            .arg("--check")
            .output()
            .expect("it runs");
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(78), "{error}");
        assert!(error.contains(expected), "{expected}: {error}");
    }
}
