//! A judged receiver cycle, and its sinks.

use coaxle_clock::cycle::Tick;
use coaxle_clock::{Domain, Instant};
use coaxle_node::Arrival;
use coaxle_sim::True;

use crate::record::ReceiverCycle;

/// The clock both worlds are judged by: true time, or the machine's monotonic clock.
#[derive(Debug)]
pub enum Reference {}

impl Domain for Reference {
    const NAME: &'static str = "reference";
}

/// A judged receiver cycle.
#[derive(Debug, PartialEq)]
pub struct Row {
    /// Ideal start of the cycle, s after the start of the run.
    pub t_s: f64,
    /// Signals of the receiver; in a box, as it waits, is judged, shown and reused.
    pub record: Box<ReceiverCycle>,
    /// True position and velocity of its master, in units of the axis it receives.
    pub truth: Option<(f64, f64)>,
    /// Difference quotient of the set position given to the drive, slave units/s.
    pub set_velocity: Option<f64>,
    /// Corrected minus true far time, µs.
    pub time_error_us: Option<f64>,
    /// True if it counts for the figures: not before the receiver is first in sync.
    pub evaluated: bool,
}

impl Clone for Row {
    fn clone(&self) -> Self {
        Self {
            record: self.record.clone(),
            ..*self
        }
    }

    fn clone_from(&mut self, other: &Self) {
        // Into the present box and the list of slaves in it: a derived method would allocate both again.
        self.record.clone_from(&other.record);
        self.t_s = other.t_s;
        self.truth = other.truth;
        self.set_velocity = other.set_velocity;
        self.time_error_us = other.time_error_us;
        self.evaluated = other.evaluated;
    }
}

/// Takes every row, judged, in the order of its receiver's cycles.
pub trait RowSink {
    /// A row of one of the receivers' far or virtual axes, by its number among all of them.
    fn row(&mut self, view: usize, row: &Row);

    /// Takes an arrival that the n-th receiver took in during the cycle `tick`, which ideally started at `at`.
    /// In virtual time only: processes write arrivals themselves.
    fn arrived(&mut self, receiver: usize, at: Instant<True>, tick: &Tick, arrival: &Arrival) {
        let _ = (receiver, at, tick, arrival);
    }
}

impl RowSink for () {
    fn row(&mut self, _view: usize, _row: &Row) {}
}

impl<S: RowSink + ?Sized> RowSink for &mut S {
    fn row(&mut self, view: usize, row: &Row) {
        (**self).row(view, row);
    }

    fn arrived(&mut self, receiver: usize, at: Instant<True>, tick: &Tick, arrival: &Arrival) {
        (**self).arrived(receiver, at, tick, arrival);
    }
}

impl<S: RowSink> RowSink for Option<S> {
    fn row(&mut self, view: usize, row: &Row) {
        if let Some(sink) = self {
            sink.row(view, row);
        }
    }

    fn arrived(&mut self, receiver: usize, at: Instant<True>, tick: &Tick, arrival: &Arrival) {
        if let Some(sink) = self {
            sink.arrived(receiver, at, tick, arrival);
        }
    }
}

/// Passes each row to both sinks.
impl<A: RowSink, B: RowSink> RowSink for (A, B) {
    fn row(&mut self, view: usize, row: &Row) {
        self.0.row(view, row);
        self.1.row(view, row);
    }

    fn arrived(&mut self, receiver: usize, at: Instant<True>, tick: &Tick, arrival: &Arrival) {
        self.0.arrived(receiver, at, tick, arrival);
        self.1.arrived(receiver, at, tick, arrival);
    }
}
