//! Record of the steps of an instance.

use crate::communication::is_number_of_cycles;
use crate::variable::{Causality, UnitValue, Variables};

/// Most numbers of a journal: 512 MB.
// 16 million steps of a link: four and a half hours at the usual cycle.
const MOST_NUMBERS: usize = 64 << 20;

/// The steps of an instance since its start: the number of cycles and the inputs of each.
///
/// A unit is deterministic, so its state is its parameters and its journal. It cannot be copied itself: it holds drives and sources
/// of axes of any kind.
#[derive(Clone, Debug)]
pub(crate) struct StepJournal {
    /// Places of the inputs among the values.
    inputs: Vec<usize>,
    numbers: Vec<f64>,
    /// True if steps are missing because there were too many.
    is_full: bool,
}

impl StepJournal {
    /// An empty journal.
    pub(crate) fn new(variables: &Variables) -> Self {
        let inputs = variables.iter().enumerate();
        let inputs = inputs.filter(|(_, it)| it.causality == Causality::Input);
        Self {
            inputs: inputs.map(|(place, _)| place).collect(),
            numbers: Vec::new(),
            is_full: false,
        }
    }

    /// Adds a step.
    pub(crate) fn add(&mut self, values: &[UnitValue], cycles: u32) {
        if self.is_full || self.numbers.len() + self.stride() > MOST_NUMBERS {
            self.is_full = true;
            return;
        }
        self.numbers.push(cycles.into());
        let inputs = self.inputs.iter().map(|place| number_of(&values[*place]));
        self.numbers.extend(inputs);
    }

    pub(crate) fn clear(&mut self) {
        self.numbers.clear();
        self.is_full = false;
    }

    /// Numbers of the journal; none if steps are missing.
    pub(crate) fn numbers(&self) -> Option<&[f64]> {
        (!self.is_full).then_some(&self.numbers)
    }

    /// True if these numbers begin as the journal does.
    pub(crate) fn is_begin_of(&self, numbers: &[f64]) -> bool {
        let own = self.numbers.iter();
        !self.is_full
            && self.numbers.len() <= numbers.len()
            // By bits: −0 is another input than 0.
            && own.zip(numbers).all(|(a, b)| a.to_bits() == b.to_bits())
    }

    /// Number of steps.
    pub(crate) fn steps(&self) -> usize {
        self.numbers.len() / self.stride()
    }

    /// True if these numbers are whole steps with inputs of a unit.
    pub(crate) fn could_hold(&self, numbers: &[f64]) -> bool {
        let mut steps = numbers.chunks_exact(self.stride());
        let are_finite = numbers.iter().all(|number| number.is_finite());
        are_finite
            && numbers.len().is_multiple_of(self.stride())
            && steps.all(|step| is_number_of_cycles(step[0]))
    }

    /// The cycles and inputs of steps, from the step `from` on.
    pub(crate) fn steps_of<'a>(
        &self,
        numbers: &'a [f64],
        from: usize,
    ) -> impl Iterator<Item = (u32, &'a [f64])> + use<'a> {
        let steps = numbers.chunks_exact(self.stride()).skip(from);
        steps.map(|step| (step[0] as u32, &step[1..]))
    }

    /// Writes inputs to their places.
    pub(crate) fn write(&self, inputs: &[f64], values: &mut [UnitValue]) {
        for (place, number) in self.inputs.iter().zip(inputs) {
            match &mut values[*place] {
                UnitValue::Boolean(value) => *value = *number != 0.0,
                value => *value = UnitValue::Float64(*number),
            }
        }
    }

    fn stride(&self) -> usize {
        1 + self.inputs.len()
    }
}

/// Inputs are numbers and flags.
const fn number_of(value: &UnitValue) -> f64 {
    match value {
        UnitValue::Float64(number) => *number,
        UnitValue::Boolean(true) => 1.0,
        _ => 0.0,
    }
}
