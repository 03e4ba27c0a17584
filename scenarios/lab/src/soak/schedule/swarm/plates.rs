//! Cam plates of a swarm schedule, and the commands about them.

use coaxle_node::faults::Random;

use super::super::draw::Draw as _;

/// The plates of each receiver: to and fro, with rests, onwards with each cycle, and one that ends.
pub(super) const PLATES: &str = "cams = [\n\
    { table-id = 10, course = 'cyclic', point = [{ master = 0, slave = 0, law = 'polynom5' }, \
    { master = 180, slave = 60, law = 'polynom5' }, { master = 360, slave = 0 }] },\n\
    { table-id = 11, course = 'cyclic', point = [{ master = 0, slave = 0, law = 'bestehorn' }, \
    { master = 120, slave = 40, law = 'polynom5' }, { master = 180, slave = 40, law = 'polynom5' }, { master = 360, slave = 0 }] },\n\
    { table-id = 12, course = 'cyclic', point = [{ master = 0, slave = 0, law = 'polynom5' }, { master = 240, slave = 90, law = 'polynom5' }, \
    { master = 360, slave = 120 }] },\n\
    { table-id = 13, course = 'linear', point = [{ master = 0, slave = 0, law = 'polynom5' }, { master = 720, slave = 150 }] },\n]\n";

/// Numbers of the plates.
const TABLES: [u64; 4] = [10, 11, 12, 13];

/// Every mode of activation.
const MODES: [&str; 10] = [
    "instantaneous",
    "at-master-cam-pos",
    "at-master-axis-pos",
    "next-cycle",
    "next-cycle-once",
    "as-soon-as-possible",
    "off",
    "delete-queued-data",
    "at-master-axis-pos-positive-direction",
    "at-master-axis-pos-negative-direction",
];

/// A command about plates; `turns` if the master has a modulo period.
pub(super) fn command(random: &mut Random, turns: bool) -> String {
    let [table, other] = [(); 2].map(|()| *random.one_of(&TABLES));
    let activation = activation(random, turns);
    let jump = jump(random);
    let scaling = scaling(random);
    match random.below(10) {
        0..=2 => {
            let start = *random.one_of(&[
                "relative",
                "relative",
                "absolute",
                "master-absolute-slave-relative",
                "master-relative-slave-absolute",
            ]);
            format!(
                "cam-in = {{ table = {table}, start-mode = '{start}', activation = {activation}, jump = {jump} }}"
            )
        }
        3 => {
            let operation = *random.one_of(&["default", "additive", "exchange", "remove"]);
            format!(
                "cam-in-v2 = {{ table = {table}, reference = {other}, operation = '{operation}', activation = {activation}, \
                 scaling = {scaling}, jump = {jump} }}"
            )
        }
        4 => format!(
            "cam-add = {{ table = {table}, activation = {activation}, scaling = {{ master = {{ relative = true }}, slave = {{ \
             relative = true, scaling = 0.5 }} }}, jump = {jump} }}"
        ),
        5 => format!(
            "cam-exchange = {{ table = {table}, reference = {other}, activation = {activation}, scaling = {scaling}, jump = {jump} }}"
        ),
        6 => {
            format!("cam-remove = {{ table = {table}, activation = {activation}, jump = {jump} }}")
        }
        7 => format!(
            "cam-scaling = {{ activation = {activation}, scaling = {scaling}, jump = {jump} }}"
        ),
        8 => format!(
            "cam-scaling-v2 = {{ table = {table}, activation = {activation}, scaling = {scaling}, jump = {jump} }}"
        ),
        _ => "cam-out = {}".to_owned(),
    }
}

/// A command that changes the points of a plate, or the mode in which such changes come into force.
pub(super) fn online_change(random: &mut Random, turns: bool) -> String {
    let table = *random.one_of(&[10_u64, 11, 12]);
    let slave = random.between(20.0, 80.0);
    match random.below(4) {
        0 => {
            let (activation, jump) = (activation(random, turns), jump(random));
            format!(
                "set-cam-online-change-mode = {{ table = {table}, mode = {{ activation = {activation}, jump = {jump} }} }}"
            )
        }
        1 => format!(
            "cam-table-select = {{ table = 10, replace = true, plate = {{ course = 'cyclic', point = [{{ master = 0, slave = 0, \
             law = 'polynom5' }}, {{ master = 150, slave = {slave:.2}, law = 'polynom5' }}, {{ master = 360, slave = 0 }}] }} }}"
        ),
        _ => {
            let (master, law) = (random.between(100.0, 170.0), "polynom5");
            format!(
                "write-motion-function = {{ table = {table}, points = [{{ index = 2, type = 'rest', law = '{law}', \
                 master = {master:.2}, slave = {slave:.2} }}] }}"
            )
        }
    }
}

fn activation(random: &mut Random, turns: bool) -> String {
    let mode = *random.one_of(&MODES);
    let position = match mode.starts_with("at-master-axis-pos") && turns && random.chance(0.5) {
        true => format!("in-turn = {:.2}", random.between(0.0, 359.9)),
        // On the plate, or on its axis.
        false => match mode {
            "at-master-cam-pos" => format!("position = {:.2}", random.between(0.0, 360.0)),
            _ => format!("position = {:.2}", random.between(-1_500.0, 1_500.0)),
        },
    };
    // Every second one comes into force at once, so that the others have something to change.
    match random.chance(0.5) {
        true => "{ mode = 'instantaneous' }".to_owned(),
        false => format!("{{ mode = '{mode}', {position} }}"),
    }
}

fn jump(random: &mut Random) -> String {
    match random.below(4) {
        0 => "'allow'".to_owned(),
        1 => {
            let length = random.decades(10.0, 1_000.0);
            format!("{{ ramp-in = {{ master-length = {length:.1} }} }}")
        }
        _ => "'refuse'".to_owned(),
    }
}

fn scaling(random: &mut Random) -> String {
    let [master, slave] = [(); 2].map(|()| {
        let mode = *random.one_of(&["user-defined", "auto-offset", "off"]);
        let (offset, scaling) = (random.between(-50.0, 50.0), random.between(0.5, 1.2));
        let relative = random.chance(0.5);
        format!(
            "{{ mode = '{mode}', offset = {offset:.2}, scaling = {scaling:.3}, relative = {relative} }}"
        )
    });
    format!("{{ master = {master}, slave = {slave} }}")
}
