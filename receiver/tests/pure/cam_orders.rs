//! Orders on the cam plates of a running receiver: no memory is allocated or freed in its cycle,
//! and its signals show them.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use assert_no_alloc::assert_no_alloc;
use coaxle_clock::{Instant, Span};
use coaxle_node::command::{CommandVerdict, OrderCargo};
use coaxle_node::config::parse;
use coaxle_node::{CommandAnswer, CommandOrder, Node};
use coaxle_receiver::signals::SlaveSignals;
use coaxle_receiver::{Receiver, ReceiverConfig};
use serde_json::Value;

const CONFIG: &str = "
    name = 'cutter'
    cycle-time-us = 1000
    [[virtual-axis]]
    id = 1
    name = 'shaft'
    unit = '°'
    [virtual-axis.program]
    limits = { velocity = 360, acceleration = 3600, jerk = 36000 }
    steps = [{ enable = true }, { velocity = { value = 360 } }]
    [[slave]]
    name = 'knife'
    couple = 'off'
    limits = { velocity = 1000, acceleration = 10000, jerk = 1e6 }
    [[slave]]
    name = 'press'
    couple = 'off'
    limits = { velocity = 1000, acceleration = 10000, jerk = 1e6 }
";

const LIMITS: [f64; 3] = [1_000.0, 10_000.0, 1e6];

const SLAVES: [&str; 2] = ["knife", "press"];

struct Bench {
    receiver: Receiver,
    /// The last set positions of each slave.
    positions: [Vec<f64>; 2],
}

fn bench() -> Bench {
    let config: ReceiverConfig = parse("test", CONFIG).unwrap();
    Bench {
        receiver: Receiver::new(&config, Instant::EPOCH, 1).unwrap(),
        positions: [0, 1].map(|_| Vec::with_capacity(100_000)),
    }
}

impl Bench {
    /// Runs this number of cycles. The set positions keep the limits of the slaves in their differences.
    fn cycles(&mut self, count: u32) {
        for _ in 0..count {
            let now = self.receiver.next_cycle() + Span::from_micros(5);
            assert_no_alloc(|| {
                self.receiver.cycle(now);
                while self.receiver.transmit().is_some() {}
            });
            for n in 0..SLAVES.len() {
                let position = self.slave(n).position.unwrap_or_default();
                self.positions[n].push(position);
                self.check_differences(n);
            }
        }
    }

    fn check_differences(&self, n: usize) {
        let [.., a, b, c, d] = self.positions[n][..] else {
            return;
        };
        let dt = 1e-3;
        let differences = [
            (d - c) / dt,
            (d - 2.0 * c + b) / (dt * dt),
            (d - 3.0 * c + 3.0 * b - a) / (dt * dt * dt),
        ];
        for (difference, limit) in differences.into_iter().zip(LIMITS) {
            // Rounding of four positions, divided by dt³ as the jerk is.
            let rounding = 1e-12 / (dt * dt * dt);
            assert!(
                difference.abs() <= limit * (1.0 + 1e-6) + rounding,
                "{differences:?}"
            );
        }
    }

    fn slave(&self, n: usize) -> &SlaveSignals {
        &self.receiver.snapshot().signals.slaves[n]
    }

    fn knife(&self) -> &SlaveSignals {
        self.slave(0)
    }

    /// Executes an order like the host: its memory is allocated before, and freed afterwards.
    fn order(&mut self, slave: &str, command: &str) -> CommandAnswer {
        let text = format!(r#"{{"version":1,"slave":"{slave}","command":{command}}}"#);
        let order = CommandOrder::from_json(text.as_bytes()).unwrap();
        let mut cargo = order.cargo();
        let outcome = assert_no_alloc(|| self.receiver.execute_with(&order, &mut cargo));
        CommandAnswer::with_cargo(&order, &outcome, &cargo)
    }

    fn accepted(&mut self, command: &str) -> Value {
        self.accepted_by("knife", command)
    }

    fn accepted_by(&mut self, slave: &str, command: &str) -> Value {
        let answer = self.order(slave, command);
        assert!(answer.is_accepted(), "{command}: {answer:?}");
        serde_json::from_str(&answer.to_json()).unwrap()
    }

    fn refused(&mut self, command: &str) -> String {
        self.refused_by("knife", command)
    }

    fn refused_by(&mut self, slave: &str, command: &str) -> String {
        match self.order(slave, command).verdict {
            CommandVerdict::Refused { code, .. } => code,
            other => panic!("{command}: {other:?}"),
        }
    }
}

fn select(top: f64, replace: bool) -> String {
    format!(
        r#"{{"cam-table-select":{{"table":3,"replace":{replace},"plate":{{"course":"cyclic","point":[
            {{"law":"polynom5","master":0,"slave":0}},{{"law":"polynom5","master":180,"slave":{top}}},
            {{"master":360,"slave":0}}]}}}}}}"#
    )
}

#[test]
fn a_plate_is_loaded_coupled_changed_read_and_deleted_without_an_allocation() {
    let mut bench = bench();
    bench.cycles(10);
    assert_eq!(bench.refused(r#"{"cam-info":{}}"#), "0x4256");
    assert_eq!(
        bench.refused(r#"{"cam-table-delete":{"table":3}}"#),
        "0x4216"
    );
    // Beyond the last point, at 360: masters must ascend.
    let no_plate = select(50.0, false).replace("\"master\":180", "\"master\":400");
    assert_eq!(bench.refused(&no_plate), "0x4a06");
    bench.accepted(&select(50.0, false));
    assert_eq!(bench.refused(&select(20.0, false)), "0x4063");
    bench.accepted(r#"{"power":true}"#);
    bench.cycles(1);
    bench.accepted(r#"{"cam-in":{"table":3,"activation":{"mode":"next-cycle"}}}"#);
    bench.cycles(1);
    assert!(bench.knife().cam_table_queued);
    assert_eq!(bench.knife().cam_table, None);
    // The next turn of the shaft begins within a second.
    bench.cycles(1_500);
    let knife = bench.knife();
    assert_eq!((knife.cam_table, knife.cam_table_queued), (Some(3), false));
    let (master, slave) = (
        knife.cam_master_position.unwrap(),
        knife.cam_slave_position.unwrap(),
    );
    assert!((0.0..360.0).contains(&master), "{master}");
    let info = bench.accepted(r#"{"cam-info":{"table":3}}"#);
    let info = &info["cam"]["info"];
    // No cycle ran in between, so they are equal to the last bit.
    assert_eq!(info["master-cam-position"], master);
    assert_eq!(info["slave-cam-position"], slave);
    assert_eq!(info["raw-master-period"], 360.0);

    assert_eq!(
        bench.refused(r#"{"cam-table-delete":{"table":3}}"#),
        "0x4259"
    );
    bench.accepted(
        r#"{"set-cam-online-change-mode":{"table":3,"mode":{"activation":{"mode":"next-cycle"}}}}"#,
    );
    bench.accepted(&select(20.0, true));
    bench.cycles(1);
    assert!(bench.knife().cam_data_queued);
    let top = |bench: &mut Bench| {
        let read = bench.accepted(r#"{"read-motion-function-point":{"table":3,"point":2}}"#);
        read["cam"]["points"]["points"][0]["slave"]
            .as_f64()
            .unwrap()
    };
    // A plate that waits is not read before it is active.
    assert_eq!(top(&mut bench), 50.0);
    bench.cycles(1_500);
    assert!(!bench.knife().cam_data_queued);
    assert_eq!(top(&mut bench), 20.0);
    bench.accepted(
        r#"{"cam-scaling":{"activation":{"mode":"next-cycle"},"scaling":{"slave":{"scaling":1.5}}}}"#,
    );
    bench.cycles(1);
    assert!(bench.knife().cam_scaling_pending);
    bench.cycles(1_500);

    bench.accepted(r#"{"cam-out":{}}"#);
    bench.cycles(50);
    bench.accepted(r#"{"halt":{}}"#);
    bench.cycles(500);
    assert_eq!(bench.knife().cam_table, None);
    bench.accepted(r#"{"cam-table-delete":{"table":3}}"#);
    assert_eq!(
        bench.refused(r#"{"read-motion-function":{"table":3}}"#),
        "0x4216"
    );
    assert_eq!(bench.knife().error, 0);
}

#[test]
fn an_order_that_is_only_tried_changes_nothing() {
    let mut bench = bench();
    bench.cycles(1);
    let dry = |bench: &mut Bench, command: &str| {
        let text = format!(r#"{{"version":1,"slave":"knife","dry-run":true,"command":{command}}}"#);
        let order = CommandOrder::from_json(text.as_bytes()).unwrap();
        let mut cargo = order.cargo();
        let outcome = bench.receiver.execute_with(&order, &mut cargo);
        // A plate that was taken over would be missing in the cargo.
        let is_whole = !matches!(cargo, OrderCargo::Table(None));
        (
            CommandAnswer::with_cargo(&order, &outcome, &cargo),
            is_whole,
        )
    };
    let (answer, kept) = dry(&mut bench, &select(50.0, false));
    assert!(answer.is_accepted() && kept, "{answer:?}");
    // Nothing was loaded: there is no plate to delete.
    assert_eq!(
        bench.refused(r#"{"cam-table-delete":{"table":3}}"#),
        "0x4216"
    );
    bench.accepted(&select(50.0, false));
    let (answer, _) = dry(&mut bench, r#"{"cam-table-delete":{"table":3}}"#);
    assert!(answer.is_accepted());
    // Still loaded after a deletion that was only tried.
    bench.accepted(r#"{"read-cam-table-characteristics":{"table":3}}"#);
}

/// Two slaves on one plate, the press 90° of the shaft behind the knife.
#[test]
fn a_plate_is_one_for_all_slaves_whoever_is_ordered_to_load_it() {
    let mut bench = bench();
    bench.cycles(10);
    bench.accepted(&select(50.0, false));
    let press = "press";
    assert_eq!(bench.refused_by(press, &select(20.0, false)), "0x4063");
    for (slave, offset) in [("knife", 0), (press, -90)] {
        bench.accepted_by(slave, r#"{"power":true}"#);
        bench.accepted_by(
            slave,
            &format!(
                r#"{{"cam-in":{{"table":3,"master-offset":{offset},"activation":{{"mode":"next-cycle"}}}}}}"#
            ),
        );
    }
    bench.cycles(1_500);
    let on_plate = |bench: &Bench| [0, 1].map(|n| bench.slave(n).cam_master_position.unwrap());
    let [knife, behind] = on_plate(&bench);
    assert!(
        ((knife - behind).rem_euclid(360.0) - 90.0).abs() < 1e-6,
        "{knife} {behind}"
    );

    // An order to one slave replaces it for both, and each takes it at its own next plate cycle.
    let mode =
        r#"{"set-cam-online-change-mode":{"table":3,"mode":{"activation":{"mode":"next-cycle"}}}}"#;
    // Knife past its top, press 90° behind still before its own.
    while !(190.0..260.0).contains(&on_plate(&bench)[0]) {
        bench.cycles(1);
    }
    bench.accepted_by(press, mode);
    bench.accepted_by(press, &select(20.0, true));
    let mut tops = [Vec::new(), Vec::new()];
    let mut before = on_plate(&bench);
    while !tops.iter().all(|tops| tops.len() >= 2) {
        bench.cycles(1);
        let now = on_plate(&bench);
        for (n, tops) in tops.iter_mut().enumerate() {
            if before[n] < 180.0 && now[n] >= 180.0 {
                tops.push(bench.slave(n).cam_slave_position.unwrap().round());
            }
        }
        before = now;
    }
    // The press finished its turn on the old plate.
    assert_eq!(tops, [vec![20.0, 20.0], vec![50.0, 20.0]]);
    assert!(!bench.knife().cam_data_queued);

    bench.accepted(r#"{"cam-out":{}}"#);
    let delete = r#"{"cam-table-delete":{"table":3}}"#;
    assert_eq!(bench.refused(delete), "0x4259", "the press is on it");
    bench.accepted_by(press, r#"{"cam-out":{}}"#);
    bench.accepted(delete);
    assert_eq!(
        bench.refused_by(press, r#"{"cam-in":{"table":3}}"#),
        "0x4216"
    );
    for slave in SLAVES {
        bench.accepted_by(slave, r#"{"halt":{}}"#);
    }
    bench.cycles(500);
    assert_eq!([0, 1].map(|n| bench.slave(n).error), [0, 0]);
}
