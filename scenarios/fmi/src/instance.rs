//! An instance of a unit, by the rules of FMI 3.0: what is allowed when, and what a state is.

use std::rc::Rc;

use coaxle_node::config::Wrong;

use crate::communication::cycles_of;
use crate::journal::StepJournal;
use crate::mode::InstanceMode;
use crate::model::{CoSimulation, Model};
use crate::state::InstanceState;
use crate::variable::{Causality, UnitValue, ValueKind};

/// An instance of a unit.
pub struct UnitInstance {
    model: Rc<dyn Model>,
    token: String,
    mode: InstanceMode,
    values: Vec<UnitValue>,
    start_s: f64,
    /// Cycles since the start.
    passed: u64,
    unit: Option<Box<dyn CoSimulation>>,
    /// Values with which the unit was started.
    started_with: Vec<UnitValue>,
    journal: StepJournal,
}

impl UnitInstance {
    /// Makes an instance.
    #[must_use]
    pub fn new(model: Rc<dyn Model>) -> Self {
        Self {
            token: String::new(),
            mode: InstanceMode::Instantiated,
            values: model.variables().starts(),
            start_s: 0.0,
            passed: 0,
            unit: None,
            started_with: Vec::new(),
            journal: StepJournal::new(model.variables()),
            model,
        }
    }

    /// Sets the token of its unit, so that states of other units are recognised.
    #[must_use]
    pub fn with_token(self, token: String) -> Self {
        Self { token, ..self }
    }

    /// The value reference of a variable.
    #[must_use]
    pub fn reference(&self, name: &str) -> Option<u32> {
        self.model.variables().reference(name)
    }

    /// The value of a variable.
    ///
    /// # Errors
    /// [`Wrong`]: no such variable.
    pub fn get(&self, reference: u32) -> Result<&UnitValue, Wrong> {
        let value = usize::try_from(reference).ok();
        let value = value.and_then(|place| self.values.get(place));
        value.ok_or_else(|| self.unknown(reference))
    }

    /// Sets a parameter or an input.
    ///
    /// # Errors
    /// [`Wrong`]: no such variable, one that cannot be set, a value of another type, or one that is not finite.
    pub fn set(&mut self, reference: u32, value: UnitValue) -> Result<(), Wrong> {
        let variable = self.model.variables().get(reference);
        let variable = variable.ok_or_else(|| self.unknown(reference))?;
        check_kind(&variable.name, variable.start.kind(), value.kind())?;
        let is_early = matches!(
            self.mode,
            InstanceMode::Instantiated | InstanceMode::Initialization
        );
        let expected = match (variable.causality, self.mode) {
            (Causality::Parameter, _) if is_early => None,
            (
                Causality::Input,
                InstanceMode::Instantiated | InstanceMode::Initialization | InstanceMode::Step,
            ) => None,
            (Causality::Parameter, _) => Some("a parameter to be set before the first step"),
            (Causality::Input, _) => Some("an input to be set before its end"),
            _ => Some("a parameter or an input, other variables cannot be set"),
        };
        if let Some(expected) = expected {
            let received = format!("a value {}", self.mode.name());
            return Err(Wrong::of(&variable.name, received, expected));
        }
        if let UnitValue::Float64(number) = value
            && !number.is_finite()
        {
            return Err(Wrong::of(&variable.name, number, "a finite number"));
        }
        self.values[reference as usize] = value;
        Ok(())
    }

    /// Checks the type by which a variable is read or written.
    ///
    /// # Errors
    /// [`Wrong`]: no such variable, or another type.
    pub fn check_type(&self, reference: u32, received: ValueKind) -> Result<(), Wrong> {
        let variable = self.model.variables().get(reference);
        let variable = variable.ok_or_else(|| self.unknown(reference))?;
        check_kind(&variable.name, variable.start.kind(), received)
    }

    /// Enters initialization mode: the simulation begins at `start_s`.
    ///
    /// # Errors
    /// [`Wrong`]: another mode, or a time that is not finite.
    pub fn enter_initialization(&mut self, start_s: f64) -> Result<(), Wrong> {
        self.check_mode("fmi3EnterInitializationMode", &[InstanceMode::Instantiated])?;
        if !start_s.is_finite() {
            return Err(Wrong::of("startTime", start_s, "a finite number"));
        }
        self.start_s = start_s;
        self.values[0] = UnitValue::Float64(start_s);
        self.mode = InstanceMode::Initialization;
        Ok(())
    }

    /// Leaves initialization mode: the unit starts with its parameters.
    ///
    /// # Errors
    /// Another mode, or parameters that cannot be used; it can be reset then.
    pub fn exit_initialization(&mut self) -> anyhow::Result<()> {
        self.check_mode(
            "fmi3ExitInitializationMode",
            &[InstanceMode::Initialization],
        )?;
        self.started_with = self.values.clone();
        self.start()?;
        self.mode = InstanceMode::Step;
        Ok(())
    }

    /// Runs a communication step; the time that it ends at is variable 0. Returns what the log is to say, as of a refused command.
    ///
    /// # Errors
    /// Another mode, another point than the one reached, a step that is no whole number of cycles: nothing has happened then. A node
    /// that breaks its contract: the instance has to be reset.
    pub fn step(&mut self, point_s: f64, size_s: f64) -> anyhow::Result<Option<String>> {
        self.check_mode("fmi3DoStep", &[InstanceMode::Step])?;
        let cycle = self.model.cycle_time();
        let cycles = cycles_of(cycle, self.start_s, self.passed, point_s, size_s)?;
        self.journal.add(&self.values, cycles);
        let note = self.run(cycles)?;
        self.show();
        Ok(note)
    }

    /// Ends the simulation.
    ///
    /// # Errors
    /// [`Wrong`]: another mode.
    pub fn terminate(&mut self) -> Result<(), Wrong> {
        self.check_mode("fmi3Terminate", &[InstanceMode::Step, InstanceMode::Failed])?;
        self.mode = InstanceMode::Terminated;
        Ok(())
    }

    /// Returns to the state after its making.
    pub fn reset(&mut self) {
        let token = std::mem::take(&mut self.token);
        *self = Self::new(Rc::clone(&self.model)).with_token(token);
    }

    /// State of the instance.
    ///
    /// # Errors
    /// [`Wrong`]: too many steps for one, or a failed step.
    pub fn state(&self) -> Result<InstanceState, Wrong> {
        let Some(steps) = self.journal.numbers() else {
            let received = "an instance with more steps than its journal holds";
            return Err(Wrong::of(
                "FMUState",
                received,
                "a state within 64 million numbers",
            ));
        };
        Ok(InstanceState {
            token: self.token.clone(),
            mode: self.mode,
            start_s: self.start_s,
            values: self.values.clone(),
            started_with: self.started_with.clone(),
            steps: steps.to_vec(),
        })
    }

    /// Returns to a state: from its own steps if it begins with them, otherwise from the start again.
    ///
    /// # Errors
    /// The state of another unit: nothing has happened then.
    pub fn restore(&mut self, state: &InstanceState) -> anyhow::Result<()> {
        self.check_state(state)?;
        let is_ahead = self.unit.is_some()
            && self.mode != InstanceMode::Failed
            && self.started_with == state.started_with
            && self.journal.is_begin_of(&state.steps);
        let from = if is_ahead {
            self.journal.steps()
        } else {
            self.reset();
            0
        };
        self.start_s = state.start_s;
        if !state.started_with.is_empty() {
            self.started_with.clone_from(&state.started_with);
            if !is_ahead {
                self.values.clone_from(&state.started_with);
                self.start()?;
            }
            for (cycles, inputs) in self.journal.steps_of(&state.steps, from) {
                self.journal.write(inputs, &mut self.values);
                self.journal.add(&self.values, cycles);
                self.run(cycles)?;
            }
        }
        self.mode = state.mode;
        self.values.clone_from(&state.values);
        Ok(())
    }

    fn start(&mut self) -> anyhow::Result<()> {
        let unit = self.unit.insert(self.model.start(&self.values)?);
        unit.show(&mut self.values);
        self.passed = 0;
        self.journal.clear();
        Ok(())
    }

    fn run(&mut self, cycles: u32) -> anyhow::Result<Option<String>> {
        let unit = self.unit.as_mut();
        let ran = unit.map_or(Ok(None), |unit| unit.step(&self.values, cycles));
        match &ran {
            Ok(_) => self.passed += u64::from(cycles),
            Err(_) => self.mode = InstanceMode::Failed,
        }
        ran
    }

    fn show(&mut self) {
        if let Some(unit) = &self.unit {
            unit.show(&mut self.values);
        }
        let passed = self.passed as f64 * self.model.cycle_time().as_secs_f64();
        self.values[0] = UnitValue::Float64(self.start_s + passed);
    }

    fn check_state(&self, state: &InstanceState) -> Result<(), Wrong> {
        let are_own = |values: &[UnitValue]| {
            let kinds = self.model.variables().iter().map(|it| it.start.kind());
            values.len() == self.values.len() && kinds.eq(values.iter().map(UnitValue::kind))
        };
        let is_own = state.token == self.token
            && state.start_s.is_finite()
            && are_own(&state.values)
            && (are_own(&state.started_with) || state.started_with.is_empty())
            && self.journal.could_hold(&state.steps);
        if is_own {
            return Ok(());
        }
        Err(Wrong::of(
            "FMUState",
            "the state of another unit",
            "one of this unit",
        ))
    }

    fn check_mode(&self, function: &str, expected: &[InstanceMode]) -> Result<(), Wrong> {
        if expected.contains(&self.mode) {
            return Ok(());
        }
        let received = format!("a call {}", self.mode.name());
        Err(Wrong::of(
            function,
            received,
            format!("one {}", expected[0].name()),
        ))
    }

    fn unknown(&self, reference: u32) -> Wrong {
        let expected = format!("0 to {}", self.values.len() - 1);
        Wrong::of("valueReference", reference, expected)
    }
}

fn check_kind(name: &str, expected: ValueKind, received: ValueKind) -> Result<(), Wrong> {
    if expected == received {
        return Ok(());
    }
    Err(Wrong::of(name, received.name(), expected.name()))
}
