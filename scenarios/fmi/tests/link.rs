//! The unit *link* against the run of its scenario: equal to the last bit.
#![allow(missing_docs)]

use std::path::Path;
use std::rc::Rc;

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::Span;
use coaxle_curve::profile::Kinematics;
use coaxle_fmi::{Model, Resources, UnitInstance, UnitValue};
use coaxle_lab::catalog::Source;
use coaxle_lab::record::ReceiverCycle;
use coaxle_lab::row::{Row, RowSink};
use coaxle_source::SourceAxis;

const TEXT: &str = include_str!("../examples/link.toml");
const STEPS: u32 = 6000;
const CYCLE_S: f64 = 0.001;

fn model(text: &str) -> Rc<dyn Model> {
    Resources::of_link("link.toml", text)
        .model(Path::new(""))
        .expect("a link")
}

fn started(model: &Rc<dyn Model>, parameters: &[(&str, UnitValue)]) -> UnitInstance {
    let mut link = UnitInstance::new(Rc::clone(model));
    for (name, value) in parameters {
        set(&mut link, name, value.clone());
    }
    link.enter_initialization(0.0).expect("it is new");
    link.exit_initialization().expect("it starts");
    link
}

fn set(link: &mut UnitInstance, name: &str, value: UnitValue) {
    let reference = link.reference(name).expect(name);
    link.set(reference, value).expect(name);
}

fn get(link: &UnitInstance, name: &str) -> UnitValue {
    link.get(link.reference(name).expect(name))
        .expect(name)
        .clone()
}

fn set_master(link: &mut UnitInstance, master: &Kinematics) {
    set(link, "master.position", UnitValue::Float64(master.position));
    set(link, "master.velocity", UnitValue::Float64(master.velocity));
    set(
        link,
        "master.acceleration",
        UnitValue::Float64(master.acceleration),
    );
}

fn step(link: &mut UnitInstance, step: u32) {
    link.step(f64::from(step) * CYCLE_S, CYCLE_S)
        .expect("a step");
}

/// The motion of the scenario's conveyor at the beginnings of the steps.
fn motion_of_the_run() -> Vec<Kinematics> {
    let scenario = source(TEXT).read(&[]).expect("a scenario");
    let mut axis = SourceAxis::open(&scenario.senders[0].axes[0]).expect("a program");
    let mut shown = NcToPlcAxis::default();
    let mut at = |step| axis.at(Span::from_millis(step), &mut shown).seen;
    (0..i64::from(STEPS)).map(&mut at).collect()
}

fn source(text: &str) -> Source {
    Source {
        name: "link".to_owned(),
        file: "link.toml".to_owned(),
        text: text.to_owned(),
    }
}

/// The cycles of the receiver in the run of the scenario.
fn cycles_of_the_run(text: &str) -> Vec<ReceiverCycle> {
    #[derive(Default)]
    struct Cycles(Vec<ReceiverCycle>);
    impl RowSink for Cycles {
        fn row(&mut self, _view: usize, row: &Row) {
            self.0.push((*row.record).clone());
        }
    }
    let scenario = source(text).read(&[]).expect("a scenario");
    let mut cycles = Cycles::default();
    coaxle_lab::virtual_time::run(&scenario, &mut cycles, &mut ()).expect("a run");
    cycles.0
}

/// Compares all signals of a unit with those of the same cycle of the run. Returns true if there is one.
fn compare(link: &UnitInstance, run: &[ReceiverCycle]) -> bool {
    let UnitValue::UInt64(cycle) = get(link, "cycle") else {
        panic!("cycles are counts");
    };
    let at = get(link, "at_ns");
    let Some(expected) = run.iter().find(|row| UnitValue::Int64(row.at_ns) == at) else {
        return false;
    };
    assert_eq!(expected.node.cycle, cycle);
    for (prefix, signals) in [
        ("axis", serde_json::to_value(expected.axis)),
        ("far", serde_json::to_value(expected.far)),
        ("shadow", serde_json::to_value(expected.slaves[0])),
    ] {
        for (name, expected) in signals.expect("signals").as_object().expect("a table") {
            let received = get(link, &format!("{prefix}.{name}"));
            let is_equal = match &received {
                UnitValue::Float64(number) => match expected.as_f64() {
                    Some(expected) => expected.to_bits() == number.to_bits(),
                    None => number.is_nan(),
                },
                UnitValue::UInt64(count) => expected.as_u64().unwrap_or(0) == *count,
                UnitValue::Int64(number) => expected.as_i64().unwrap_or(0) == *number,
                UnitValue::Boolean(flag) => expected.as_bool().unwrap_or(false) == *flag,
                UnitValue::String(word) => expected.as_str().unwrap_or("") == word,
            };
            assert!(
                is_equal,
                "cycle {cycle}: {prefix}.{name} is {received:?}, expected {expected}"
            );
        }
    }
    true
}

#[test]
fn moved_by_inputs_it_is_the_run_to_the_last_bit() {
    let (run, motion) = (cycles_of_the_run(TEXT), motion_of_the_run());
    let mut link = started(&model(TEXT), &[]);
    let mut compared = 0;
    for (n, master) in (0..).zip(&motion) {
        set_master(&mut link, master);
        step(&mut link, n);
        compared += u32::from(compare(&link, &run));
    }
    // 200 ppm of 6000 cycles: a step or two has two cycles of the receiver.
    assert!(compared >= STEPS - 5, "{compared}");
    let UnitValue::Float64(position) = get(&link, "axis.corrected_position") else {
        panic!("positions are numbers");
    };
    assert!(position > 1000.0, "{position}");
    assert!(
        matches!(get(&link, "axis.corrected_acceleration"), UnitValue::Float64(it) if it.is_finite())
    );
}

#[test]
fn moved_by_its_scenario_it_is_the_run_also_with_a_drifting_sender() {
    let drifting = TEXT.replace("clock = { jitter", "clock = { drift-ppm = -70, jitter");
    assert_ne!(drifting, TEXT);
    let run = cycles_of_the_run(&drifting);
    let parameters = [
        ("master.from_scenario", UnitValue::Boolean(true)),
        (
            "set",
            UnitValue::String("sender.line.clock.drift-ppm=-70\n".to_owned()),
        ),
    ];
    let mut link = started(&model(TEXT), &parameters);
    let compared = (0..STEPS).filter(|n| {
        step(&mut link, *n);
        compare(&link, &run)
    });
    assert!(compared.count() as u32 >= STEPS - 5);
}

#[test]
fn a_drifting_sender_is_moved_by_inputs_as_by_its_scenario() {
    let set = (
        "set",
        UnitValue::String("sender.line.clock.drift-ppm=-70".to_owned()),
    );
    let model = model(TEXT);
    let mut by_inputs = started(&model, std::slice::from_ref(&set));
    let mut by_scenario = started(
        &model,
        &[set, ("master.from_scenario", UnitValue::Boolean(true))],
    );
    let mut greatest = 0.0_f64;
    for (n, master) in (0..).zip(&motion_of_the_run()) {
        set_master(&mut by_inputs, master);
        step(&mut by_inputs, n);
        step(&mut by_scenario, n);
        let [a, b] = [&by_inputs, &by_scenario].map(|link| get(link, "axis.received_position"));
        if let (UnitValue::Float64(a), UnitValue::Float64(b)) = (a, b)
            && a.is_finite()
        {
            greatest = greatest.max((a - b).abs());
        }
    }
    // By its drift the motion of the scenario is 70 ppm slow: 0.42 ms of 6 s, at 500 mm/s.
    assert!((0.1..0.3).contains(&greatest), "{greatest}");
}

#[test]
fn a_state_is_returned_to_and_survives_as_bytes() {
    let (model, motion) = (model(TEXT), motion_of_the_run());
    let mut link = started(&model, &[("seed", UnitValue::UInt64(7))]);
    let go = |link: &mut UnitInstance, from: u32, to: u32| {
        for n in from..to {
            set_master(link, &motion[n as usize]);
            step(link, n);
        }
        (1..)
            .map_while(|reference| link.get(reference).ok())
            .map(|it| format!("{it:?}"))
            .collect::<Vec<_>>()
    };
    let _ = go(&mut link, 0, 2500);
    let state = link.state().expect("a state");
    let first = go(&mut link, 2500, 3000);
    link.restore(&state).expect("its own");
    assert_eq!(go(&mut link, 2500, 3000), first);
    let bytes = state.to_bytes().expect("bytes");
    let read = coaxle_fmi::InstanceState::from_bytes(&bytes).expect("the bytes");
    let mut other = UnitInstance::new(Rc::clone(&model));
    other.restore(&read).expect("of the same unit");
    assert_eq!(go(&mut other, 2500, 3000), first);
    let cut =
        coaxle_fmi::InstanceState::from_bytes(&bytes[..bytes.len() / 2]).expect_err("half of it");
    assert!(
        cut.to_string()
            .contains("expected those of fmi3SerializeFMUState"),
        "{cut}"
    );
}

#[test]
fn what_is_no_link_is_refused_with_a_sentence() {
    for (from, to, expected) in [
        (
            "[[receiver]]\nname = \"saw\"",
            "[[receiver]]\nname = \"b\"\ncycle-time-us = 1000\nmaster = { node = \"line\", axis = 1 }\n[[receiver]]\nname = \"saw\"",
            "receiver: received 2 receivers, expected one receiver",
        ),
        (
            "loss = 0.01",
            "loss = 1.5",
            "network.loss: received 1.5, expected",
        ),
        (
            "name = \"shadow\"",
            "name = \"axis\"",
            "slave: received two variables \"axis.",
        ),
        ("duration-s = 10", "duration-s = ", "link.toml:"),
    ] {
        let text = TEXT.replacen(from, to, 1);
        assert_ne!(text, TEXT);
        let refused = Resources::of_link("link.toml", &text).model(Path::new(""));
        let refused = format!("{:#}", refused.expect_err(expected));
        assert!(refused.contains(expected), "{refused}");
    }
}

#[test]
fn parameters_that_do_not_fit_are_refused_with_a_sentence() {
    for (set, expected) in [
        ("network.loss=2", "network.loss: received 2"),
        (
            "nonsense",
            "received --set \"nonsense\", expected path.to.field=value",
        ),
        (
            "sender.line.cycle-time-us=500",
            "set: received another cycle time",
        ),
        (
            "receiver.saw.slave.0.name=other",
            "set: received other nodes or slaves",
        ),
    ] {
        let mut link = UnitInstance::new(model(TEXT));
        let reference = link.reference("set").expect("a parameter");
        link.set(reference, UnitValue::String(set.to_owned()))
            .expect("a text");
        link.enter_initialization(0.0).expect("it is new");
        let refused = format!("{:#}", link.exit_initialization().expect_err(set));
        assert!(refused.contains(expected), "{refused}");
    }
}
