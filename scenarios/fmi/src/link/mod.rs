//! The unit *link*: a sender, a network with its faults, and a receiver, in virtual time.

mod given_motion;
mod layout;

pub(crate) use layout::MASTER;

use std::path::Path;
use std::sync::{Arc, Mutex};

use coaxle_clock::{CycleTime, Instant, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_lab::catalog::Source;
use coaxle_lab::record::ReceiverCycle;
use coaxle_lab::scenario::Scenario;
use coaxle_lab::topology::{ReceiverAxis, Topology, View};
use coaxle_lab::virtual_time::{GivenMotion, SteppedScenario};
use coaxle_node::config::Wrong;
use coaxle_receiver::SignalRow;

use crate::model::{CoSimulation, Model};
use crate::variable::{UnitValue, Variables};
use given_motion::{GivenInputs, InputSource};
use layout::LinkLayout;

/// A link by its scenario.
#[derive(Debug)]
pub struct LinkUnitModel {
    source: Source,
    scenario: Scenario,
    layout: LinkLayout,
}

impl LinkUnitModel {
    /// The link of a scenario with one sender of one axis, and one receiver that follows it. `file` is its name in errors, and files
    /// that it names are searched for in its folder.
    ///
    /// # Errors
    /// Names the file, the field, the value received and the one expected.
    pub fn new(file: &Path, text: &str) -> anyhow::Result<Self> {
        let source = Source {
            name: file
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            file: file.display().to_string(),
            text: text.to_owned(),
        };
        let scenario = source.read(&[])?;
        let view = view_of(&scenario).map_err(|wrong| wrong.in_file(&source.file))?;
        let layout = LinkLayout::new(&scenario, view);
        Ok(Self {
            layout: layout.map_err(|wrong| wrong.in_file(&source.file))?,
            scenario,
            source,
        })
    }

    /// The scenario with the parameters of an instance.
    fn with_parameters(&self, values: &[UnitValue]) -> anyhow::Result<Scenario> {
        let sets = match &values[self.layout.set] {
            UnitValue::String(sets) => sets.as_str(),
            _ => "",
        };
        let lines = sets.lines().map(str::trim).filter(|line| !line.is_empty());
        let lines: Vec<_> = lines.map(str::to_owned).collect();
        let mut scenario = self.source.read(&lines)?;
        self.check_likeness(&scenario)?;
        if let UnitValue::UInt64(seed) = values[self.layout.seed] {
            scenario.seed = seed;
        }
        Ok(scenario)
    }

    /// Checks that a scenario has the variables and the step that the description of the unit states.
    fn check_likeness(&self, scenario: &Scenario) -> Result<(), Wrong> {
        let view = view_of(scenario)?;
        let layout = LinkLayout::new(scenario, view)?;
        // Start values may differ: these are what parameters replace.
        let stated = |layout: &LinkLayout| {
            let variables = layout.variables.iter();
            let stated = variables.map(|it| (it.name.clone(), it.unit.clone()));
            stated.collect::<Vec<_>>()
        };
        if stated(&layout) != stated(&self.layout) {
            let (received, expected) = ("other nodes or slaves", "those of the unit's scenario");
            return Err(Wrong::of("set", received, expected));
        }
        if cycle_of(scenario) != cycle_of(&self.scenario) {
            let received = "another cycle time of the sender, which is the step of the unit";
            return Err(Wrong::of("set", received, "the scenario's"));
        }
        Ok(())
    }
}

impl Model for LinkUnitModel {
    fn title(&self) -> String {
        self.scenario.title.clone()
    }

    fn variables(&self) -> &Variables {
        &self.layout.variables
    }

    fn cycle_time(&self) -> CycleTime {
        cycle_of(&self.scenario)
    }

    fn start(&self, values: &[UnitValue]) -> anyhow::Result<Box<dyn CoSimulation>> {
        let scenario = self.with_parameters(values)?;
        let given = Arc::new(Mutex::new(GivenInputs::default()));
        let motion: GivenMotion = {
            let given = Arc::clone(&given);
            std::rc::Rc::new(move |start| Box::new(InputSource::new(start, Arc::clone(&given))))
        };
        let is_own = values[self.layout.from_scenario] == UnitValue::Boolean(true);
        let mut record = ReceiverCycle::default();
        let signals = SignalRow::new(&scenario.receivers[0]);
        record.fill(0, 0, &signals, &self.layout.view);
        GivenInputs::add(&given, Instant::EPOCH, self.layout.master(values));
        Ok(Box::new(LinkUnit {
            layout: self.layout.clone(),
            cycle: self.cycle_time().span(),
            passed: 0,
            stepped: SteppedScenario::new(scenario, (!is_own).then_some(&motion))?,
            given,
            record,
            acceleration: None,
        }))
    }
}

/// A link under way.
struct LinkUnit {
    layout: LinkLayout,
    cycle: Span,
    /// Cycles since the start.
    passed: i64,
    stepped: SteppedScenario,
    given: Arc<Mutex<GivenInputs>>,
    /// The newest cycle of the receiver.
    record: ReceiverCycle,
    /// Acceleration of the far axis in that cycle, as its slaves follow it.
    acceleration: Option<f64>,
}

impl CoSimulation for LinkUnit {
    fn step(&mut self, values: &[UnitValue], cycles: u32) -> anyhow::Result<Option<String>> {
        let begin = self.stepped.sender_time(0);
        GivenInputs::add(&self.given, begin, self.layout.master(values));
        self.passed += i64::from(cycles);
        let end = self.cycle * self.passed;
        let (record, acceleration) = (&mut self.record, &mut self.acceleration);
        let view = &self.layout.view;
        self.stepped.advance(end, &mut |seen| {
            record.fill(seen.at_ns, seen.woke_ns, seen.signals(), view);
            *acceleration = match view.of {
                ReceiverAxis::Far { axis, .. } => seen.receiver.far_axis(axis),
                ReceiverAxis::Virtual(_) => None,
            }
            .map(|axis| axis.set_acceleration);
        })?;
        Ok(None)
    }

    fn show(&self, values: &mut [UnitValue]) {
        self.layout.show(&self.record, self.acceleration, values);
    }
}

fn cycle_of(scenario: &Scenario) -> CycleTime {
    scenario.senders[0].cycle_time_us.0
}

/// The far axis of the receiver that follows the sender.
fn view_of(scenario: &Scenario) -> Result<View, Wrong> {
    let [sender] = &scenario.senders[..] else {
        let received = format!("{} senders", scenario.senders.len());
        return Err(Wrong::of("sender", received, "one sender"));
    };
    if sender.axes.len() != 1 {
        let received = format!("{} axes", sender.axes.len());
        return Err(Wrong::of("sender[0].axis", received, "one axis"));
    }
    if scenario.receivers.len() != 1 {
        let received = format!("{} receivers", scenario.receivers.len());
        return Err(Wrong::of("receiver", received, "one receiver"));
    }
    let topology = Topology::of(scenario)?;
    let mut views = topology.views().iter();
    let is_far = |view: &&View| matches!(view.of, ReceiverAxis::Far { .. }) && view.root.node == 0;
    views.find(is_far).cloned().ok_or_else(|| {
        let expected = "one with the sender's axis as a far axis";
        Wrong::of("receiver[0]", "a receiver without a far axis", expected)
    })
}

/// Motion of a master by its inputs.
pub(crate) fn kinematics_of(values: &[UnitValue], places: [usize; 3]) -> Kinematics {
    let [position, velocity, acceleration] = places.map(|place| match values[place] {
        UnitValue::Float64(number) => number,
        _ => 0.0,
    });
    Kinematics {
        position,
        velocity,
        acceleration,
    }
}
