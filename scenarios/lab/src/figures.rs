//! The figures of a summary as columns: name, unit, kind of value, and direction of worse values.
//!
//! Signals bring these from their declaration. Other figures of the evaluation are declared here, a line each.

use coaxle_node::config::Unit;
use coaxle_node::fields_of;
use coaxle_node::signal::{Kind, Signal, Signals};
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals, NodeSignals, SlaveSignals};
use coaxle_recording::Value;
use serde_json::{Map, Value as Json};

use crate::summary::{ReceiverSummary, SlaveSummary};
use crate::units;

/// A figure of a receiver, or of a slave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SummaryFigure {
    /// Name, for a slave's figure with `slave.` in front.
    pub(crate) name: String,
    /// Name in the summary.
    field: &'static str,
    /// True for a slave's figure.
    pub(crate) is_of_slave: bool,
    /// Unit, in which `u` stands for another one; empty if it has none.
    unit: &'static str,
    /// Meaning of `u` in the unit.
    u: UnitMeaning,
    /// Kind of its values.
    pub(crate) kind: Kind,
    /// True if larger values are better. Otherwise values farther from zero are worse.
    pub(crate) more_is_better: bool,
}

/// Meaning of `u`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum UnitMeaning {
    /// The unit of the receiver's master axis.
    Receiver,
    /// The unit of the slave.
    Slave,
    /// The unit of the slave's master.
    Master,
}

/// The units of a row: of a receiver, and of one of its slaves.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Units {
    receiver: Unit,
    slave: Unit,
    master: Unit,
}

impl Units {
    pub(crate) fn of(receiver: &ReceiverSummary, slave: Option<&SlaveSummary>) -> Self {
        Self {
            receiver: receiver.unit.clone(),
            slave: slave.map_or_else(Unit::default, |slave| slave.unit.clone()),
            master: slave.map_or_else(Unit::default, |slave| slave.cuts.cut_unit.clone()),
        }
    }

    /// Units that these rows have in common: `u` where they differ. Rows without a slave do not affect slaves' units.
    pub(crate) fn common<'a>(rows: impl Iterator<Item = (&'a Self, bool)> + Clone) -> Self {
        let of_slaves = rows.clone().filter(|(_, has_slave)| *has_slave);
        Self {
            receiver: units::common(rows.map(|(units, _)| &units.receiver)),
            slave: units::common(of_slaves.clone().map(|(units, _)| &units.slave)),
            master: units::common(of_slaves.map(|(units, _)| &units.master)),
        }
    }
}

impl SummaryFigure {
    /// Every figure: those of receivers, then those of slaves.
    pub(crate) fn all() -> Vec<Self> {
        let signals = |signals: &'static [Signal]| signals.iter().filter(|s| s.is_summarized);
        let of_receiver = [
            NodeSignals::SIGNALS,
            FarNodeSignals::SIGNALS,
            FarAxisSignals::SIGNALS,
        ];
        let declared = RECEIVER.iter().map(|it| Self::declared(it, false));
        let receiver = (of_receiver.into_iter().flat_map(signals)).map(|it| Self::of(it, false));
        let slaves = SLAVE.iter().map(|it| Self::declared(it, true));
        let slave = signals(SlaveSignals::SIGNALS).map(|it| Self::of(it, true));
        declared
            .chain(receiver)
            .chain(slaves)
            .chain(slave)
            .collect()
    }

    fn declared(declared: &Declared, is_of_slave: bool) -> Self {
        let Declared(field, unit, u, kind) = *declared;
        Self {
            name: full_name(field, is_of_slave),
            field,
            is_of_slave,
            unit,
            u,
            kind,
            more_is_better: MORE_IS_BETTER.contains(&field),
        }
    }

    fn of(signal: &Signal, is_of_slave: bool) -> Self {
        let u = if is_of_slave {
            UnitMeaning::Slave
        } else {
            UnitMeaning::Receiver
        };
        let declared = Declared(signal.name, signal.unit, u, signal.kind);
        Self::declared(&declared, is_of_slave)
    }

    /// Unit among such rows.
    pub(crate) fn unit(&self, units: &Units) -> String {
        let of = match self.u {
            UnitMeaning::Receiver => &units.receiver,
            UnitMeaning::Slave => &units.slave,
            UnitMeaning::Master => &units.master,
        };
        of.in_place_of_u(self.unit)
    }

    /// Column heading with the unit: `lag_us`, `velocity_ripple_max [mm/s]`.
    pub(crate) fn heading(&self, units: &Units) -> String {
        let unit = self.unit(units);
        let ascii = unit.replace('µ', "u");
        // Names are ASCII, and write µs as us.
        let is_in_name = self.name.split('_').any(|part| part == ascii);
        if unit.is_empty() || is_in_name {
            self.name.clone()
        } else {
            format!("{} [{unit}]", self.name)
        }
    }

    /// Value among the fields of a receiver's summary or a slave's; none where it is missing.
    pub(crate) fn value(
        &self,
        receiver: &SummaryFields,
        slave: Option<&SummaryFields>,
    ) -> Option<Value> {
        let fields = if self.is_of_slave { slave? } else { receiver };
        let value = fields.0.get(self.field)?;
        match self.kind {
            Kind::Number => value.as_f64().map(Value::Number),
            // A value of another kind counts as missing instead of ending the sweep.
            Kind::Count => value.as_u64().map(Value::Count),
            Kind::Integer => value.as_i64().map(Value::Integer),
            Kind::Flag => value.as_bool().map(Value::Flag),
            Kind::Text => value.as_str().map(|text| Value::Text(text.to_owned())),
        }
    }
}

/// A value as a number; none of a text. A flag is 0 or 1.
pub(crate) fn number(value: &Value) -> Option<f64> {
    match *value {
        Value::Number(number) => Some(number),
        Value::Count(count) => Some(count as f64),
        Value::Integer(integer) => Some(integer as f64),
        Value::Flag(flag) => Some(if flag { 1.0 } else { 0.0 }),
        Value::Text(_) => None,
    }
}

/// The fields of a summary.
pub(crate) struct SummaryFields(Map<String, Json>);

impl SummaryFields {
    pub(crate) fn of_receiver(summary: &ReceiverSummary) -> Self {
        Self(fields_of(summary))
    }

    pub(crate) fn of_slave(summary: &SlaveSummary) -> Self {
        Self(fields_of(summary))
    }
}

fn full_name(field: &str, is_of_slave: bool) -> String {
    match is_of_slave {
        true => format!("slave.{field}"),
        false => field.to_owned(),
    }
}

/// Name, unit, meaning of `u`, kind.
struct Declared(&'static str, &'static str, UnitMeaning, Kind);

const fn number_of(name: &'static str, unit: &'static str, u: UnitMeaning) -> Declared {
    Declared(name, unit, u, Kind::Number)
}

const fn count(name: &'static str) -> Declared {
    Declared(name, "", UnitMeaning::Receiver, Kind::Count)
}

const fn flag(name: &'static str) -> Declared {
    Declared(name, "", UnitMeaning::Receiver, Kind::Flag)
}

const fn text(name: &'static str) -> Declared {
    Declared(name, "", UnitMeaning::Receiver, Kind::Text)
}

const RECEIVER: &[Declared] = &[
    text("mode"),
    text("master"),
    count("cycles"),
    count("skipped_by_sender"),
    count("errors"),
    text("last_error"),
    count("warnings"),
    number_of("time_to_sync_s", "s", UnitMeaning::Receiver),
    count("beats_at_sync"),
    count("synced_times"),
    flag("synced_at_end"),
    number_of("drift_ppm_true", "ppm", UnitMeaning::Receiver),
    number_of("delay_error_us", "µs", UnitMeaning::Receiver),
    number_of("delay_covered_share", "", UnitMeaning::Receiver),
    number_of("evaluated_from_s", "s", UnitMeaning::Receiver),
    count("evaluated_cycles"),
    number_of("velocity_ripple_rms", "u/s", UnitMeaning::Receiver),
    number_of("velocity_ripple_max", "u/s", UnitMeaning::Receiver),
    number_of("velocity_ripple_ratio", "", UnitMeaning::Receiver),
    number_of("velocity_ripple_settled_rms", "u/s", UnitMeaning::Receiver),
    number_of("velocity_ripple_settled_max", "u/s", UnitMeaning::Receiver),
    number_of("velocity_ripple_settled_ratio", "", UnitMeaning::Receiver),
    number_of("velocity_ripple_lock_in_max", "u/s", UnitMeaning::Receiver),
    number_of("corrected_time_error_rms_us", "µs", UnitMeaning::Receiver),
    number_of("corrected_time_error_max_us", "µs", UnitMeaning::Receiver),
    number_of(
        "corrected_time_error_settled_rms_us",
        "µs",
        UnitMeaning::Receiver,
    ),
    number_of(
        "corrected_time_error_settled_max_us",
        "µs",
        UnitMeaning::Receiver,
    ),
    number_of(
        "corrected_time_error_lock_in_max_us",
        "µs",
        UnitMeaning::Receiver,
    ),
    number_of("lag_us", "µs", UnitMeaning::Receiver),
    number_of("far_position_error_max", "u", UnitMeaning::Receiver),
    number_of("far_position_error_rms", "u", UnitMeaning::Receiver),
    number_of("far_motion_error_max", "u", UnitMeaning::Receiver),
    number_of("lag_error_max", "u", UnitMeaning::Receiver),
    number_of("lag_error_max_us", "µs", UnitMeaning::Receiver),
    number_of("lag_error_rms_us", "µs", UnitMeaning::Receiver),
    number_of("drive_position_error_max", "u", UnitMeaning::Slave),
    number_of("shown_position_error_max", "u", UnitMeaning::Slave),
    number_of("following_error_max", "u", UnitMeaning::Slave),
    flag("drive_tripped"),
    number_of("wake_up_max_us", "µs", UnitMeaning::Receiver),
    number_of("frame_age_p1_us", "µs", UnitMeaning::Receiver),
    number_of("frame_age_p50_us", "µs", UnitMeaning::Receiver),
    number_of("frame_age_p99_us", "µs", UnitMeaning::Receiver),
    number_of("frame_age_spread_us", "µs", UnitMeaning::Receiver),
];

const SLAVE: &[Declared] = &[
    count("errors"),
    text("last_error"),
    text("last_refusal"),
    number_of("in_sync_share", "", UnitMeaning::Slave),
    number_of("position_jump_max", "u", UnitMeaning::Slave),
    number_of("velocity_max", "u/s", UnitMeaning::Slave),
    number_of("acceleration_max", "u/s²", UnitMeaning::Slave),
    number_of("velocity_share_max", "", UnitMeaning::Slave),
    number_of("acceleration_share_max", "", UnitMeaning::Slave),
    number_of("jerk_share_max", "", UnitMeaning::Slave),
    number_of("following_error_max", "u", UnitMeaning::Slave),
    count("synchronisations"),
    number_of("sync_duration_s", "s", UnitMeaning::Slave),
    number_of("sync_master_way", "u", UnitMeaning::Master),
    number_of("sync_slave_way", "u", UnitMeaning::Slave),
    number_of("sync_master_position", "u", UnitMeaning::Master),
    number_of("sync_slave_position", "u", UnitMeaning::Slave),
    number_of("sync_position_min", "u", UnitMeaning::Slave),
    number_of("sync_position_max", "u", UnitMeaning::Slave),
    number_of("release_master_way", "u", UnitMeaning::Master),
    number_of("release_slave_way", "u", UnitMeaning::Slave),
    number_of("release_master_position", "u", UnitMeaning::Master),
    number_of("release_slave_position", "u", UnitMeaning::Slave),
    count("cuts"),
    number_of("cut_position_error_max", "u", UnitMeaning::Master),
    number_of("cut_position_error_rms", "u", UnitMeaning::Master),
    number_of("cut_length_error_max", "u", UnitMeaning::Master),
    number_of("cut_length_error_rms", "u", UnitMeaning::Master),
];

/// Figures whose least value is the worst.
const MORE_IS_BETTER: [&str; 8] = [
    "cuts",
    "cycles",
    "delay_covered_share",
    "evaluated_cycles",
    "in_sync_share",
    "received",
    "synced_at_end",
    "synchronisations",
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Names of the figures of a summary, without units, lists and slaves.
    fn names_of(fields: &SummaryFields) -> BTreeSet<&str> {
        const NO_FIGURES: [&str; 3] = ["unit", "cut_unit", "slaves"];
        let names = fields.0.keys().map(String::as_str);
        names.filter(|name| !NO_FIGURES.contains(name)).collect()
    }

    #[test]
    fn every_field_of_a_summary_is_a_figure() {
        let figures = SummaryFigure::all();
        let declared = |is_of_slave| -> BTreeSet<&str> {
            let figures = figures.iter().filter(|f| f.is_of_slave == is_of_slave);
            figures.map(|figure| figure.field).collect()
        };
        let receiver = SummaryFields::of_receiver(&ReceiverSummary::default());
        assert_eq!(declared(false), names_of(&receiver));
        let slave = SummaryFields::of_slave(&SlaveSummary::default());
        assert_eq!(declared(true), names_of(&slave));
        let names: BTreeSet<_> = figures.iter().map(|figure| &figure.name).collect();
        assert_eq!(names.len(), figures.len());
    }

    #[test]
    fn what_a_summary_has_is_of_the_kind_that_is_declared() {
        let receiver = SummaryFields::of_receiver(&ReceiverSummary::default());
        let slave = SummaryFields::of_slave(&SlaveSummary::default());
        for figure in SummaryFigure::all() {
            let fields = if figure.is_of_slave {
                &slave
            } else {
                &receiver
            };
            if !fields.0[figure.field].is_null() {
                let value = figure.value(&receiver, Some(&slave));
                assert!(value.is_some(), "{} is no {}", figure.name, figure.kind);
            }
        }
    }

    #[test]
    fn a_column_bears_its_unit_once() {
        let units = |slave: &str| Units {
            receiver: Unit::new("mm").unwrap(),
            slave: Unit::new(slave).unwrap(),
            master: Unit::new("mm").unwrap(),
        };
        let (degrees, turns) = (units("°"), units("rev"));
        let same = [(&degrees, true), (&turns, false)];
        assert_eq!(Units::common(same.into_iter()), degrees);
        let common = Units::common([(&degrees, true), (&turns, true)].into_iter());
        let heading = |name: &str| {
            let all = SummaryFigure::all();
            let figure = all.iter().find(|figure| figure.name == name).unwrap();
            figure.heading(&common)
        };
        for (name, expected) in [
            ("lag_us", "lag_us"),
            ("time_to_sync_s", "time_to_sync_s"),
            ("drift_ppm_true", "drift_ppm_true"),
            ("random_walk_ppm", "random_walk_ppm [ppm/√s]"),
            ("velocity_ripple_max", "velocity_ripple_max [mm/s]"),
            ("slave.velocity_max", "slave.velocity_max [u/s]"),
            (
                "slave.cut_length_error_max",
                "slave.cut_length_error_max [mm]",
            ),
            ("cycles", "cycles"),
        ] {
            assert_eq!(heading(name), expected);
        }
    }
}
