//! `trace.mcap`: every receiver cycle, a table for each far or virtual axis.

use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use coaxle_node::signal::Instance;
use coaxle_os::machine;
use coaxle_receiver::ReceiverConfig;
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals, NodeSignals, SlaveSignals};
use coaxle_recording::{EncodedRow, Facts, RowEncoder, RowError, Table, Writer};

use crate::record::ReceiverCycle;
use crate::row::{Row, RowSink};
use crate::scenario::Scenario;
use crate::summary::World;
use crate::topology::{ReceiverAxis, View};
use truth::TruthSignals;

mod truth {
    coaxle_node::signals! {
        /// True motion of the axis, unknown to the receiver, with the derived errors.
        pub struct TruthSignals of Truth {
            /// Since the start of the run.
            t_s: f64 ["s"],
            /// True position.
            position: Option<f64> ["u"],
            /// True velocity.
            velocity: Option<f64> ["u/s"],
            /// Difference quotient of the set position that the first slave's drive gets.
            set_velocity: Option<f64> ["slave u/s"],
            /// Corrected minus true far time.
            time_error_us: Option<f64> ["µs"],
        }
    }
}

/// Writes the trace. The first error ends it and is reported at the end.
pub(crate) struct TraceRecording {
    path: PathBuf,
    encoders: Vec<RowEncoder>,
    writer: Writer<File>,
    error: Option<anyhow::Error>,
}

impl TraceRecording {
    /// Creates the file, with the scenario in it.
    ///
    /// # Errors
    /// Names the file that cannot be written.
    pub(crate) fn create(
        path: &Path,
        name: &str,
        scenario: &Scenario,
        world: World,
        views: &[View],
    ) -> anyhow::Result<Self> {
        let cannot = || format!("cannot write {}", path.display());
        let tables: Vec<Table> = views
            .iter()
            .map(|view| table(&scenario.receivers[view.receiver], view))
            .collect();
        let offset_ns = match world {
            // Equal runs give equal bytes, on any day.
            World::Virtual => 0,
            World::Processes => machine::wall_clock_offset_ns(),
        };
        let facts = facts(name, scenario, world);
        let file = File::create(path).with_context(cannot)?;
        let mut writer = Writer::create(file, &tables, &facts, offset_ns).with_context(cannot)?;
        let text = toml::to_string_pretty(scenario).context("cannot write the scenario as TOML")?;
        let attached = writer.attach("scenario.toml", "application/toml", text.as_bytes());
        attached.with_context(cannot)?;
        Ok(Self {
            path: path.to_owned(),
            encoders: tables.iter().map(RowEncoder::of).collect(),
            writer,
            error: None,
        })
    }

    pub(crate) fn finish(self) -> anyhow::Result<()> {
        let finished = match self.error {
            Some(error) => Err(error),
            None => self.writer.finish().map(|_| ()).map_err(Into::into),
        };
        finished.with_context(|| format!("cannot write {}", self.path.display()))
    }

    fn write(&mut self, view: usize, row: &Row) -> anyhow::Result<()> {
        let record = &row.record;
        let truth = TruthSignals {
            t_s: row.t_s,
            position: row.truth.map(|(position, _)| position),
            velocity: row.truth.map(|(_, velocity)| velocity),
            set_velocity: row.set_velocity,
            time_error_us: row.time_error_us,
        };
        let encoder = self.encoders.get_mut(view);
        let encoder = encoder.ok_or_else(|| anyhow!("a row of no axis that is known"))?;
        let encoded = encode(encoder, truth, record)?;
        Ok(self.writer.row(view, &encoded)?)
    }
}

/// Encodes a row in the order of the instances of [`table`].
fn encode(
    encoder: &mut RowEncoder,
    truth: TruthSignals,
    record: &ReceiverCycle,
) -> Result<EncodedRow, RowError> {
    let ReceiverCycle {
        node,
        far,
        axis,
        slaves,
        ..
    } = record;
    encoder.encode(
        record.at_ns,
        record.woke_ns,
        &(truth, node, far, axis, slaves),
    )
}

impl RowSink for TraceRecording {
    fn row(&mut self, view: usize, row: &Row) {
        if self.error.is_none() {
            self.error = self.write(view, row).err();
        }
    }
}

fn facts(name: &str, scenario: &Scenario, world: World) -> Facts {
    let facts = [
        ("scenario", name.to_owned()),
        ("seed", scenario.seed.to_string()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("world", world.name().to_owned()),
    ];
    facts.map(|(name, fact)| (name.to_owned(), fact)).into()
}

/// An axis of a receiver, with the node it is read from and the slaves that follow it in the end.
fn table(receiver: &ReceiverConfig, view: &View) -> Table {
    let unit = match view.of {
        ReceiverAxis::Far { axis, .. } => receiver.far_axis_unit(axis),
        ReceiverAxis::Virtual(axis) => receiver.virtual_axes[axis].unit.clone(),
    };
    let mut instances = vec![
        Instance::of::<TruthSignals>("truth").in_unit(unit.clone()),
        Instance::of::<NodeSignals>(""),
        Instance::of::<FarNodeSignals>("far"),
        Instance::of::<FarAxisSignals>("axis").in_unit(unit),
    ];
    instances.extend(view.slaves.iter().map(|n| {
        let name = receiver.slaves[*n].name.as_str();
        Instance::of::<SlaveSignals>(name).in_unit(receiver.slave_unit(*n))
    }));
    Table {
        name: view.name.clone(),
        role: "receiver".to_owned(),
        instances,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_receiver::SignalRow;
    use coaxle_recording::{Item, Reader, Value};

    #[test]
    fn a_row_comes_back_with_what_the_axis_truly_did() {
        let text = "name = 'r'\ncycle-time-us = 1000\nmaster = { node = 'm' }\n\
                    [[slave]]\nname = 'a'";
        let config: ReceiverConfig = coaxle_node::config::parse("test", text).unwrap();
        let view = View::of_first_axis(1);
        let mut record = Box::<ReceiverCycle>::default();
        record.fill(3_000_000, 3_000_500, &SignalRow::new(&config), &view);
        let table = table(&config, &view);
        let mut encoder = RowEncoder::of(&table);
        let truth = TruthSignals {
            position: Some(2.5),
            ..TruthSignals::default()
        };
        let encoded = encode(&mut encoder, truth, &record).unwrap();
        let mut writer = Writer::create(Vec::new(), &[table], &Facts::new(), 0).unwrap();
        writer.row(0, &encoded).unwrap();
        let file = writer.finish().unwrap();
        let mut reader = Reader::new(file.as_slice());
        let row = reader.by_ref().find_map(|item| match item.unwrap() {
            Item::Row(row) => Some(row),
            _ => None,
        });
        let row = row.unwrap();
        let value = |name: &str| {
            let columns = &reader.tables()[0].columns;
            let place = columns.iter().position(|column| column.name() == name);
            row.values[place.expect(name)].clone()
        };
        assert_eq!(row.at_ns, 3_000_000);
        assert_eq!(value("truth.position"), Some(Value::Number(2.5)));
        assert_eq!(value("truth.velocity"), None);
        assert_eq!(
            value("health"),
            Some(Value::Text("waiting-for-master".to_owned()))
        );
        assert_eq!(value("far.restarts"), Some(Value::Count(0)));
        assert_eq!(value("a.state"), Some(Value::Text("disabled".to_owned())));
    }
}
