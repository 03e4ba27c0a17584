//! Every block of TF5050 used from another process: orders over Zenoh to a receiver that runs.
//!
//! The clock on the wall decides nothing: each wait polls until its condition is met.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::shared::{free_endpoint, text, written};
use coaxle_host::client::Commander;
use coaxle_node::CommandOrder;
use coaxle_node::config::TransportConfig;
use coaxle_node::keys::NodeName;
use coaxle_test_process::{Process, output, until};
use serde_json::{Value, json};

const RECEIVER: &str = "name = 'cutter'\ncycle-time-us = 2000\n\
    [[virtual-axis]]\nid = 1\nname = 'shaft'\nunit = '°'\n\
    [virtual-axis.program]\nlimits = { velocity = 720, acceleration = 7200, jerk = 72000 }\n\
    steps = [{ enable = true }, { velocity = { value = 720 } }]\n\
    [[slave]]\nname = 'knife'\ncouple = 'off'\nlimits = { velocity = 2000, acceleration = 40000, jerk = 2e6 }\n";

/// Limits of the differences of the set positions: velocity, acceleration, jerk.
const LIMITS: [f64; 3] = [2_000.0, 40_000.0, 2e6];

fn coaxle(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle"));
    command.args(arguments).stdin(Stdio::null());
    command
}

/// A receiver in a process of its own, and a client that commands it.
struct Live {
    node: Process,
    commander: Option<Commander>,
    at: String,
}

impl Drop for Live {
    fn drop(&mut self) {
        if let Some(commander) = self.commander.take() {
            commander.close();
        }
    }
}

impl Live {
    fn start(folder: &Path) -> Self {
        let at = free_endpoint();
        let config = written(folder, "receiver.toml", RECEIVER.as_bytes());
        let mut command = coaxle(&["receiver"]);
        command
            .arg(config)
            .args(["--listen", &at, "--for", "600s", "--quiet", "--trace"])
            .arg(folder.join("trace.csv"));
        let node = Process::start("cutter", &mut command, &folder.join("cutter.log"));
        let transport = TransportConfig {
            connect: vec![at.clone()],
            ..TransportConfig::default()
        };
        let commander = Commander::open(&transport).expect("a session");
        Self {
            node,
            commander: Some(commander),
            at,
        }
    }

    fn send(&self, command: &Value) -> Value {
        let order = json!({ "version": 1, "slave": "knife", "command": command });
        let order = CommandOrder::from_json(order.to_string().as_bytes()).expect("an order");
        let node = NodeName::new("cutter").expect("a name");
        let commander = self.commander.as_ref().expect("it is open");
        let answer = commander.send(&node, &order).expect("an answer");
        serde_json::from_str(&answer.to_json()).expect("JSON")
    }

    fn accepted(&self, command: Value) -> Value {
        let answer = self.send(&command);
        assert_eq!(answer["outcome"], "accepted", "{command}: {answer}");
        answer
    }

    fn refused(&self, command: Value, code: &str) {
        let answer = self.send(&command);
        assert_eq!(answer["outcome"], "refused", "{command}: {answer}");
        assert_eq!(answer["code"], code, "{command}: {answer}");
    }

    fn info(&self, table: u32) -> Value {
        self.accepted(json!({ "cam-info": { "table": table } }))["cam"]["info"].take()
    }

    /// Repeats the command until its response meets the condition.
    fn wait(&self, what: &str, command: &Value, is_so: impl Fn(&Value) -> bool) -> Value {
        let mut answer = Value::Null;
        until(what, || {
            answer = self.send(command);
            is_so(&answer)
        });
        answer
    }

    fn wait_coupled(&self, table: u32) -> Value {
        let ask = json!({ "cam-info": { "table": table } });
        self.wait("coupled", &ask, |answer| {
            answer["outcome"] == "accepted" && answer["axis"]["coupling"] == "in-sync"
        })
    }

    fn wait_done(&self, table: u32, field: &str, value: &Value) {
        let ask = json!({ "cam-info": { "table": table } });
        self.wait(field, &ask, |answer| answer["cam"]["info"][field] == *value);
    }

    fn wait_standstill(&self) {
        // A dry run of a reading command returns the slave's state.
        let ask = json!({ "read-motion-function": { "table": 3 } });
        self.wait("standstill", &ask, |answer| {
            answer["axis"]["status"] == "standstill"
        });
    }

    /// Runs `coaxle command` with arguments that a user types.
    fn typed(&self, arguments: &[&str]) -> (String, Option<i32>) {
        let mut command = coaxle(&["command", "cutter", "knife"]);
        command.args(arguments).args(["--connect", &self.at]);
        let output = output(&mut command);
        let said = text(&output.stdout) + &text(&output.stderr);
        (said, output.status.code())
    }

    /// Ends the node as Ctrl-C does, so that its trace is whole.
    fn end(mut self) {
        if let Some(commander) = self.commander.take() {
            commander.close();
        }
        self.node.signal("INT");
        assert!(self.node.wait().success(), "{}", self.node.log());
    }
}

fn at(mode: &str) -> Value {
    json!({ "mode": mode })
}

fn plate(points: &[(f64, f64)]) -> Value {
    let point = |&(master, slave): &(f64, f64)| json!({ "law": "polynom5", "master": master, "slave": slave });
    json!({ "course": "cyclic", "point": points.iter().map(point).collect::<Vec<_>>() })
}

/// A plate up to `top` and down again in one turn of the shaft.
fn up_and_down(top: f64) -> Value {
    plate(&[(0.0, 0.0), (180.0, top), (360.0, 0.0)])
}

#[test]
fn every_block_of_tf5050_is_used_from_another_process() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let live = Live::start(folder.path());
    load(&live, folder.path());
    single(&live);
    read(&live);
    several(&live);
    unload(&live);
    live.end();
    check_trace(&folder.path().join("trace.csv"));
}

/// `MC_CamTableSelect`, typed and sent.
fn load(live: &Live, folder: &Path) {
    live.refused(json!({ "cam-info": {} }), "0x4256");
    let file = "title = 'Up and down'\ncourse = 'cyclic'\ntable-id = 3\n\
        point = [{ law = 'polynom5', master = 0, slave = 0 }, { law = 'polynom5', master = 180, slave = 50 },\n\
        { master = 360, slave = 0 }]\n";
    let file = written(folder, "plate.toml", file.as_bytes());
    let file = file.to_str().expect("a plain path");
    let (said, code) = live.typed(&["cam-table-select", file]);
    assert_eq!(code, Some(0), "{said}");
    let (said, code) = live.typed(&["cam-table-select", file]);
    assert_eq!(code, Some(4), "{said}");
    assert!(said.contains("0x4063"), "{said}");
    let (said, code) = live.typed(&["read-motion-function-point", "--table=3", "--point=2"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("180  50  polynom5  rest"), "{said}");
    let small = plate(&[(0.0, 0.0), (90.0, 5.0), (360.0, 0.0)]);
    live.accepted(json!({ "cam-table-select": { "table": 4, "plate": small } }));
    let table = json!({ "course": "cyclic", "table": { "interpolation": "spline", "rows": [[0, 0], [100, 3], [200, 4], [300, 1], [360, 0]] } });
    live.accepted(json!({ "cam-table-select": { "table": 5, "plate": table } }));
    let wrong = plate(&[(0.0, 0.0), (400.0, 5.0), (360.0, 0.0)]);
    live.refused(
        json!({ "cam-table-select": { "table": 6, "plate": wrong } }),
        "0x4a06",
    );
}

/// `MC_CamIn`, `MC_CamScaling`, the online change, `MC_CamInfo`, `MC_CamOut`.
fn single(live: &Live) {
    live.accepted(json!({ "power": true }));
    live.accepted(json!({ "cam-in": { "table": 3, "activation": at("next-cycle") } }));
    live.wait_coupled(3);
    let there = live.accepted(json!({ "cam-info": { "table": 3, "master-position": 180.0 } }));
    assert_eq!(there["cam"]["info"]["slave-axis-position"], 50.0);
    live.refused(json!({ "cam-table-delete": { "table": 3 } }), "0x4259");

    // Changed while it runs: as a whole, and by a point.
    let mode = json!({ "activation": at("next-cycle") });
    live.accepted(json!({ "set-cam-online-change-mode": { "table": 3, "mode": mode } }));
    live.accepted(
        json!({ "cam-table-select": { "table": 3, "replace": true, "plate": up_and_down(40.0) } }),
    );
    live.wait_done(3, "cam-data-queued", &json!(false));
    let top = |live: &Live| {
        let read =
            live.accepted(json!({ "read-motion-function-point": { "table": 3, "point": 2 } }));
        read["cam"]["points"]["points"][0]["slave"].clone()
    };
    assert_eq!(top(live), 40.0);
    let point =
        json!({ "index": 2, "law": "polynom5", "type": "rest", "master": 180.0, "slave": 30.0 });
    live.accepted(json!({ "write-motion-function": { "table": 3, "points": [point] } }));
    live.wait_done(3, "cam-data-queued", &json!(false));
    assert_eq!(top(live), 30.0);

    let scaling = json!({ "slave": { "scaling": 1.5 } });
    live.accepted(json!({ "cam-scaling": { "activation": at("next-cycle"), "scaling": scaling } }));
    live.wait_done(3, "slave-scaling", &json!(1.5));
    live.refused(json!({ "cam-add": { "table": 4 } }), "0x425c");

    live.accepted(json!({ "cam-out": {} }));
    live.refused(json!({ "cam-info": {} }), "0x4256");
    live.accepted(json!({ "halt": {} }));
    live.wait_standstill();
}

/// The reading blocks: their responses match the plate.
fn read(live: &Live) {
    let all = live.accepted(json!({ "read-motion-function": { "table": 3 } }));
    assert_eq!(all["cam"]["points"]["number-of-rows"], 3);
    let ask = json!({ "table": 3, "from": 0, "to": 360, "increment": 90, "values": ["position", "velocity"] });
    let values = live.accepted(json!({ "read-motion-function-values": ask }));
    let values = &values["cam"]["values"];
    assert_eq!(values["columns"], json!(["master", "position", "velocity"]));
    assert_eq!(values["rows"][2], json!([180.0, 30.0, 0.0]));
    let ask = json!({ "table": 5, "master-position": 200 });
    let dynamics = live.accepted(json!({ "read-cam-table-slave-dynamics": ask }));
    assert_eq!(dynamics["cam"]["slave-dynamics"]["position"], 4.0);
    let found = live.accepted(json!({ "read-cam-table-characteristics": { "table": 3 } }));
    assert_eq!(found["cam"]["characteristics"]["values"][21]["value"], 30.0);
    let ask = json!({ "table": 3, "slave-position": 30, "slave-scaling": 2, "master-start-position": 180 });
    let masters = live.accepted(json!({ "read-cam-table-master-position": ask }));
    let masters = &masters["cam"]["master-position"];
    for (side, expected) in [("low", 90.0), ("high", 270.0)] {
        let found = masters[side]["master-axis-position"]
            .as_f64()
            .expect("a number");
        assert!((found - expected).abs() < 1e-6, "{masters}");
    }
    live.refused(json!({ "read-motion-function": { "table": 9 } }), "0x4216");
    live.refused(json!({ "read-motion-function": { "table": 5 } }), "0x4262");
}

/// Several plates at once: `MC_CamIn_V2`, `MC_CamAdd`, `MC_CamExchange`, `MC_CamScaling_V2`, `MC_CamRemove`.
fn several(live: &Live) {
    live.accepted(json!({ "move-absolute": { "position": 0 } }));
    live.wait_standstill();
    let next = at("next-cycle");
    live.accepted(json!({ "cam-in-v2": { "table": 3, "activation": next } }));
    live.wait_coupled(3);
    let jump = json!({ "ramp-in": { "master-length": 90 } });
    live.accepted(json!({ "cam-add": { "table": 4, "activation": next, "jump": jump } }));
    live.wait_coupled(4);
    live.refused(json!({ "cam-info": {} }), "0x4261");
    let scaling = json!({ "slave": { "scaling": 2.0 } });
    let scale = json!({ "table": 4, "activation": next, "scaling": scaling, "jump": jump });
    live.accepted(json!({ "cam-scaling-v2": scale }));
    live.wait_done(4, "slave-scaling", &json!(2.0));
    let exchange = json!({ "table": 5, "reference": 4, "activation": next, "jump": jump });
    live.accepted(json!({ "cam-exchange": exchange }));
    live.wait_coupled(5);
    live.accepted(json!({ "cam-remove": { "table": 5, "activation": next, "jump": jump } }));
    let ask = json!({ "cam-info": { "table": 5 } });
    live.wait("removed", &ask, |answer| answer["code"] == "0x4261");
    assert_eq!(live.info(0)["table"], 3);
    live.accepted(json!({ "cam-out": {} }));
    live.accepted(json!({ "halt": {} }));
    live.wait_standstill();
}

fn unload(live: &Live) {
    for table in [4, 5] {
        live.accepted(json!({ "cam-table-delete": { "table": table } }));
    }
    let (said, code) = live.typed(&["cam-table-delete", "--table=3"]);
    assert_eq!(code, Some(0), "{said}");
    live.refused(json!({ "read-motion-function": { "table": 3 } }), "0x4216");
}

/// Checks the drive's set positions: over any four successive cycles their differences keep the limits.
fn check_trace(file: &Path) {
    let trace = std::fs::read_to_string(file).expect("a trace");
    let mut lines = trace.lines();
    let header: Vec<_> = lines.next().expect("a header").split(',').collect();
    let place = |name: &str| {
        header
            .iter()
            .position(|column| *column == name)
            .expect(name)
    };
    let (cycle, position, anew) = (
        place("cycle"),
        place("knife.position"),
        place("knife.set_anew"),
    );
    let rows: Vec<(i64, f64, i64)> = lines
        .filter_map(|line| {
            let cells: Vec<_> = line.split(',').collect();
            Some((
                cells.get(cycle)?.parse().ok()?,
                cells.get(position)?.parse().ok()?,
                cells.get(anew)?.parse().ok()?,
            ))
        })
        .collect();
    assert!(rows.len() > 1_000, "{} rows", rows.len());
    let dt = 2e-3;
    let mut most = [0.0_f64; 3];
    for rows in rows.windows(4) {
        let follow_each_other = rows.windows(2).all(|two| two[1].0 == two[0].0 + 1);
        if !follow_each_other || rows[0].2 != rows[3].2 {
            continue;
        }
        let [a, b, c, d] = [rows[0].1, rows[1].1, rows[2].1, rows[3].1];
        let differences = [
            (d - c) / dt,
            (d - 2.0 * c + b) / (dt * dt),
            (d - 3.0 * c + 3.0 * b - a) / (dt * dt * dt),
        ];
        for (most, difference) in most.iter_mut().zip(differences) {
            *most = most.max(difference.abs());
        }
    }
    assert!(most[0] > 50.0, "it moved: {most:?}");
    for (most, limit) in most.into_iter().zip(LIMITS) {
        assert!(most <= limit * 1.001, "{most}, at most {limit}");
    }
}
