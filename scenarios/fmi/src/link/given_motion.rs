//! The axis of a sender, moved by the inputs of a unit.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use coaxle_clock::{Instant, Local, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_source::{Activity, AxisSource, SourceSample};

/// Inputs that are kept: a sender that wakes late has cycles whose ideal start is in an earlier step.
const KEPT: usize = 64;

/// Motions of the master, from the instants on at which they were given, by the clock of the sender.
#[derive(Debug, Default)]
pub(super) struct GivenInputs {
    given: VecDeque<(Instant<Local>, Kinematics)>,
}

impl GivenInputs {
    /// Adds a motion that holds from `at` on.
    pub(super) fn add(inputs: &Mutex<Self>, at: Instant<Local>, motion: Kinematics) {
        let mut inputs = inputs.lock().unwrap_or_else(PoisonError::into_inner);
        if inputs.given.len() == KEPT {
            inputs.given.pop_front();
        }
        inputs.given.push_back((at, motion));
    }

    /// The motion at an instant: from the newest input before it on, by its velocity and acceleration.
    fn at(&self, now: Instant<Local>) -> Option<Kinematics> {
        let before = self.given.iter().rev().find(|(at, _)| *at <= now);
        let (at, motion) = before.or_else(|| self.given.front())?;
        // After no time it is the same, to the bit.
        Some(motion.after((now - *at).as_secs_f64(), 0.0))
    }
}

/// The source of the sender's axis.
#[derive(Debug)]
pub(super) struct InputSource {
    /// Start of the sender.
    start: Instant<Local>,
    inputs: Arc<Mutex<GivenInputs>>,
}

impl InputSource {
    pub(super) const fn new(start: Instant<Local>, inputs: Arc<Mutex<GivenInputs>>) -> Self {
        Self { start, inputs }
    }
}

impl AxisSource for InputSource {
    fn sample(&mut self, since_start: Span) -> SourceSample {
        let inputs = self.inputs.lock().unwrap_or_else(PoisonError::into_inner);
        let motion = inputs.at(self.start + since_start);
        let motion = motion.unwrap_or(Kinematics::at_rest(0.0));
        SourceSample {
            motion,
            seen: motion,
            enabled: true,
            activity: Activity::Following,
            command_number: 0,
            target_position: motion.position,
        }
    }
}
