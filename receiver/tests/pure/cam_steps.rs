//! Steps of a program on the cam plates: loaded, replaced while the slave runs on them, deleted;
//! repeatedly, without an allocation in the cycle and within the limits of the slave, with any
//! interruption.

use crate::nodes::{Far, receiver};
use assert_no_alloc::assert_no_alloc;
use coaxle_axis::AxisStatus;
use coaxle_node::command::CommandVerdict;
use coaxle_node::{CommandAnswer, CommandOrder, Node};
use coaxle_receiver::signals::SlaveSignals;
use coaxle_receiver::{Outcome, ProgramState, Receiver, WaitsFor};

const LIMITS: [f64; 3] = [1_000.0, 20_000.0, 1e6];

fn plate(top: f64) -> String {
    format!(
        "{{ course = 'cyclic', point = [{{ law = 'polynom5', master = 0, slave = 0 }}, \
         {{ law = 'polynom5', master = 180, slave = {top} }}, {{ master = 360, slave = 0 }}] }}"
    )
}

/// A slave of its own shaft, which moves by 360° in a second, or of the far axis.
fn slave(master: &str, steps: &str) -> String {
    format!(
        "[[far]]
        node = 'line'
        axes = [{{ id = 1, name = 'far' }}]
        [[virtual-axis]]
        id = 1
        name = 'shaft'
        unit = '°'
        [virtual-axis.program]
        start-velocity = 360
        limits = {{ velocity = 360, acceleration = 3600, jerk = 36000 }}
        steps = []
        [[slave]]
        name = 'pusher'
        master = '{master}'
        limits = {{ velocity = 1000, acceleration = 20000, jerk = 1e6 }}
        {steps}"
    )
}

/// Product a, product b, a again, and so on, each while the slave runs on the plate; interruptions
/// lead to the start.
fn products() -> String {
    let (a, b) = (plate(60.0), plate(40.0));
    format!(
        "[[slave.step]]
        label = 'begin'
        when = {{ master-ready = true, error-stop = false, standstill = true }}
        do = {{ power = true }}
        [[slave.step]]
        when = {{ state = 'standstill', cam-table = 0 }}
        do = {{ move-absolute = {{ position = 0 }} }}
        [[slave.step]]
        when = {{ done = true, standstill = true }}
        do = {{ cam-table-select = {{ table = 3, plate = {a} }} }}
        otherwise = {{ failed = 'failed' }}
        [[slave.step]]
        do = {{ set-cam-online-change-mode = {{ table = 3, mode = {{ activation = {{ mode = 'next-cycle' }} }} }} }}
        otherwise = {{ failed = 'failed' }}
        [[slave.step]]
        do = {{ cam-in = {{ table = 3, activation = {{ mode = 'next-cycle' }} }} }}
        otherwise = {{ failed = 'failed', refused = 'stopped' }}
        [[slave.step]]
        label = 'b'
        when = {{ cam-table = 3, cam-data-queued = false, after-s = 1.2 }}
        do = {{ cam-table-select = {{ table = 3, replace = true, plate = {b} }} }}
        otherwise = {{ aborted = 'stopped', failed = 'failed' }}
        [[slave.step]]
        label = 'a'
        when = {{ cam-table = 3, cam-data-queued = false, after-s = 1.2 }}
        do = {{ cam-table-select = {{ table = 3, replace = true, plate = {a} }} }}
        otherwise = {{ aborted = 'stopped', failed = 'failed' }}
        go-to = 'b'
        [[slave.step]]
        label = 'failed'
        when = {{ standstill = true }}
        do = {{ reset = {{}} }}
        [[slave.step]]
        label = 'stopped'
        when = {{ standstill = true, cam-table = 0 }}
        do = {{ cam-table-delete = {{ table = 3 }} }}
        otherwise = {{ refused = 'begin' }}
        go-to = 'begin'
        "
    )
}

struct Bench {
    receiver: Receiver,
    far: Far,
    positions: Vec<f64>,
}

impl Bench {
    fn new(text: &str) -> Self {
        Self {
            receiver: receiver(text),
            far: Far::new(0, 1_000_100, &[360.0]),
            positions: Vec::with_capacity(1_000_000),
        }
    }

    /// Runs a cycle without allocation; the set positions keep the limits of the slave in their
    /// differences.
    fn cycle(&mut self) {
        let now = self.receiver.next_cycle();
        self.far.send_until(now, &mut self.receiver);
        assert_no_alloc(|| {
            self.receiver.cycle(now);
            while self.receiver.transmit().is_some() {}
        });
        self.positions
            .push(self.slave().position.unwrap_or_default());
        self.check_differences();
    }

    fn check_differences(&self) {
        let [.., a, b, c, d] = self.positions[..] else {
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
                "{differences:?}: {:?}",
                self.slave()
            );
        }
    }

    fn slave(&self) -> &SlaveSignals {
        &self.receiver.snapshot().signals.slaves[0]
    }

    fn until(&mut self, what: &str, is_so: impl Fn(&SlaveSignals) -> bool) {
        // 30 s are thirty turns of the shaft.
        for _ in 0..30_000 {
            self.cycle();
            if is_so(self.slave()) {
                return;
            }
        }
        panic!("{what} never came: {:?}", self.slave());
    }

    /// The slave's greatest positions in this number of plate cycles.
    fn tops(&mut self, turns: usize) -> Vec<f64> {
        let mut tops = Vec::new();
        while tops.len() < turns {
            self.until("the middle of a turn", |slave| {
                slave
                    .cam_master_position
                    // At 0.36° per cycle, each turn has a cycle in it.
                    .is_some_and(|at| (178.0..183.0).contains(&at))
            });
            // Within 3° of its top, a plate of 60 u is less than 0.01 u lower.
            tops.push(self.slave().cam_slave_position.unwrap_or_default().round());
            self.until("the next turn", |slave| {
                slave.cam_master_position.is_none_or(|at| at < 170.0)
            });
        }
        tops
    }

    /// Executes an order like the host.
    fn order(&mut self, command: &str) -> CommandAnswer {
        let text = format!(r#"{{"version":1,"slave":"pusher","command":{command}}}"#);
        let order = CommandOrder::from_json(text.as_bytes()).expect("an order");
        let mut cargo = order.cargo();
        let outcome = assert_no_alloc(|| self.receiver.execute_with(&order, &mut cargo));
        CommandAnswer::with_cargo(&order, &outcome, &cargo)
    }

    fn accepted(&mut self, command: &str) {
        let answer = self.order(command);
        assert!(answer.is_accepted(), "{command}: {answer:?}");
    }

    fn points(&mut self) -> String {
        let read = self.order(r#"{"read-motion-function":{"table":3}}"#);
        read.to_json()
    }
}

fn is_on(slave: &SlaveSignals) -> bool {
    slave.cam_table == Some(3)
}

#[test]
fn products_change_again_and_again_while_the_slave_runs_on_the_plate() {
    let mut bench = Bench::new(&slave("shaft", &products()));
    let tops = bench.tops(14);
    // Changes wait for the next cycle of the plate.
    assert_eq!(tops[0], 60.0);
    let changes = tops.windows(2).filter(|pair| pair[0] != pair[1]).count();
    // A change waits for 1.2 s and for the next turn: six times in 14 turns.
    assert!(changes >= 5, "{tops:?}");
    assert!(
        tops.iter().all(|top| [40.0, 60.0].contains(top)),
        "{tops:?}"
    );
    assert_eq!((bench.slave().error, bench.slave().refusal), (0, 0));
}

#[test]
fn an_order_that_stops_it_is_branched_for_and_the_plate_is_taken_out_and_loaded_anew() {
    let mut bench = Bench::new(&slave("shaft", &products()));
    for turns in [2, 3, 4] {
        bench.tops(turns);
        bench.accepted(r#"{"halt":{}}"#);
        bench.until("it stands", |slave| slave.state == AxisStatus::Standstill);
        // Product a is that of the program's first steps.
        assert_eq!(bench.tops(1), [60.0], "it began anew");
        assert_eq!(bench.slave().error, 0);
    }
}

#[test]
fn a_master_that_is_lost_or_begins_anew_leads_to_an_error_stop_and_to_the_start_again() {
    let mut bench = Bench::new(&slave("far", &products()));
    for run in 2..5 {
        bench.until("it is on the plate", is_on);
        bench.tops(2);
        bench.far.silent = true;
        bench.until("an error stop", |slave| {
            slave.state == AxisStatus::ErrorStop
        });
        for _ in 0..300 {
            bench.cycle();
        }
        bench.far.silent = false;
        if run > 2 {
            // Another run, at another position.
            bench.far.epoch = run;
            bench.far.offsets[0] += 77.0;
        }
    }
    bench.until("it is on the plate", is_on);
    assert_eq!(bench.tops(1), [60.0]);
}

#[test]
fn orders_may_take_its_plates_and_it_loses_none() {
    let mut bench = Bench::new(&slave("shaft", &products()));
    bench.tops(1);
    let first = bench.points();
    // Points written by an order are discarded when the plate is loaded again.
    bench.accepted(
        r#"{"write-motion-function":{"table":3,"points":[{"index":2,"type":"rest","law":"polynom5","master":180,"slave":50}]}}"#,
    );
    bench.tops(2);
    let own = |top: f64| {
        format!(
            r#"{{"cam-table-select":{{"table":3,"replace":true,"plate":{{"course":"cyclic","point":[
            {{"law":"polynom5","master":0,"slave":0}},{{"law":"polynom5","master":180,"slave":{top}}},
            {{"master":360,"slave":0}}]}}}}}}"#
        )
    };
    for top in [30.0, 20.0, 10.0] {
        bench.accepted(r#"{"halt":{}}"#);
        // The program deletes the current plate; an order in between loads a plate of its own.
        bench.until("it has left the plate", |slave| slave.cam_table.is_none());
        bench.accepted(&own(top));
        bench.accepted(r#"{"cam-table-delete":{"table":3}}"#);
        bench.accepted(&own(top).replace("\"replace\":true,", ""));
        assert_eq!(bench.tops(1), [60.0]);
        assert_eq!(bench.points(), first);
    }
}

#[test]
fn a_refusal_is_expected_branched_for_or_ends_the_program() {
    let a = plate(60.0);
    let start = format!(
        "[[slave.step]]
        do = {{ power = true }}
        [[slave.step]]
        do = {{ cam-table-select = {{ table = 3, plate = {a} }} }}
        [[slave.step]]
        do = {{ cam-table-select = {{ table = 3, plate = {a} }} }}
        expect-refusal = 0x4063
        [[slave.step]]
        do = {{ cam-in = {{ table = 3, activation = {{ mode = 'next-cycle' }} }} }}
        [[slave.step]]
        when = {{ cam-table = 3 }}
        do = {{ cam-table-delete = {{ table = 3 }} }}\n"
    );
    let branched = "otherwise = { refused = 'out' }
        [[slave.step]]
        do = { home = { position = 0 } }
        [[slave.step]]
        label = 'out'
        do = { cam-out = {} }
        [[slave.step]]
        do = { halt = {} }
        [[slave.step]]
        when = { standstill = true, cam-table = 0 }
        do = { cam-table-delete = { table = 3 } }
        [[slave.step]]
        when = { cam-table = 3, time-s = 5 }\n";
    let mut bench = Bench::new(&slave("shaft", &format!("{start}{branched}")));
    bench.until("it waits for what cannot come", |slave| {
        slave.program == Some(ProgramState::WaitingForOrder)
    });
    assert_eq!(bench.slave().program_waits_for, Some(WaitsFor::CamTable));
    assert_eq!(bench.slave().program_outcome, Some(Outcome::Done));
    let CommandVerdict::Refused { code, .. } = bench.order(r#"{"cam-in":{"table":3}}"#).verdict
    else {
        panic!("the plate is out");
    };
    assert_eq!(code, "0x4216");

    let mut bench = Bench::new(&slave("shaft", &start));
    bench.until("it ends", |slave| {
        slave.program == Some(ProgramState::Refused)
    });
    assert_eq!(bench.slave().refusal, 0x4259);
    // The slave continues its motion.
    bench.tops(2);
}

#[test]
fn a_wrong_step_is_told_with_its_field() {
    for (step, expected) in [
        (
            "do = { cam-table-select = { table = 3, plate = { point = [] } } }",
            "slave[0].step[0].do.cam-table-select.plate: here: ",
        ),
        (
            "do = { cam-table-select = { plate = { point = [{ law = 'polynom5', master = 0, slave = 0 }, \
             { master = 1, slave = 1 }] } } }",
            "slave[0].step[0].do.cam-table-select.table: 0x4b32: received none, and no table-id in the plate",
        ),
        (
            "do = { cam-table-select = { table = 300, plate = { point = [{ law = 'polynom5', master = 0, slave = 0 }, \
             { master = 1, slave = 1 }] } } }",
            "slave[0].step[0].do.cam-table-select: ",
        ),
        (
            "do = { cam-table-select = { table = 3, plate = 'nowhere.toml' } }",
            "nowhere.toml",
        ),
    ] {
        let text = slave("shaft", &format!("[[slave.step]]\n{step}\n"));
        let text = format!("name = 'line'\ncycle-time-us = 1000\n{text}");
        let config: coaxle_receiver::ReceiverConfig =
            coaxle_node::config::parse("r.toml", &text).expect("a config");
        let built = Receiver::new(&config, coaxle_clock::Instant::EPOCH, 1);
        let error = built.expect_err("no receiver").to_string();
        assert!(error.contains(expected), "{error}");
    }
    let wrong = [
        (
            "do = { cam-tabel-delete = { table = 3 } }",
            "did you mean \"cam-table-delete\"?",
        ),
        (
            "do = { gear-inn = { ratio = 1 } }",
            "did you mean \"gear-in\"?",
        ),
        (
            "do = { cam-table-delete = { tabel = 3 } }",
            "did you mean \"table\"?",
        ),
        (
            "do = { move-absolute = { position = 'far' } }",
            "move-absolute.position",
        ),
        ("do = 'halt'", "expected a command"),
        ("do = { halt = {}, reset = {} }", "expected a command"),
    ];
    for (step, expected) in wrong {
        let text = slave("shaft", &format!("[[slave.step]]\n{step}\n"));
        let text = format!("name = 'line'\ncycle-time-us = 1000\n{text}");
        let parsed = coaxle_node::config::parse::<coaxle_receiver::ReceiverConfig>("r.toml", &text);
        let error = parsed.expect_err("no config").to_string();
        assert!(error.contains(expected), "{step}: {error}");
    }
}
