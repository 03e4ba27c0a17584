//! The corrected far axes, published for others: a display, a test, another receiver.

use coaxle_axis::{AxisState, Modulo, NcToPlcAxis, StateWord};

use crate::config::{MasterRef, ReceiverConfig};
use crate::slaves::Master;

/// Published axis structures of the far axes.
#[derive(Debug)]
pub(crate) struct PublishedFarAxes {
    /// Numbers of the published axes, by their published axis id, from 1.
    which: Box<[usize]>,
    /// Modulo periods of all far axes.
    turns: Box<[Option<Modulo>]>,
    axes: Vec<NcToPlcAxis>,
}

impl PublishedFarAxes {
    pub(crate) fn new(config: &ReceiverConfig) -> Self {
        let which = config.published_far_axes();
        let all = 0..config.first_axis_of(config.far.len());
        Self {
            turns: all
                .map(|axis| config.modulo_of(MasterRef::Far(axis)))
                .collect(),
            axes: Vec::with_capacity(which.len()),
            which: which.into(),
        }
    }

    /// Axis structures in this cycle of all axes with data.
    pub(crate) fn axes(&mut self, masters: &[Option<Master>]) -> &[NcToPlcAxis] {
        // Keeps its memory: nothing allocates in the cycle.
        self.axes.clear();
        // Ids go with the config, so that an axis without data leaves those of the others alone.
        for (id, axis) in (1..).zip(&self.which) {
            // Without data an axis is left out, rather than shown at a position that it never had.
            if let Some(master) = &masters[*axis] {
                self.axes.push(axis_struct(id, master, self.turns[*axis]));
            }
        }
        &self.axes
    }

    /// Axis structure of one far axis in this cycle, published or not; none without data, or beyond the last axis.
    pub(crate) fn axis(&self, number: usize, masters: &[Option<Master>]) -> Option<NcToPlcAxis> {
        let master = masters.get(number)?.as_ref()?;
        let id = u32::try_from(number + 1).ok()?;
        Some(axis_struct(id, master, self.turns[number]))
    }
}

/// Builds an axis structure. Actual values are not corrected anywhere, so the set values are used.
fn axis_struct(id: u32, master: &Master, modulo: Option<Modulo>) -> NcToPlcAxis {
    let set = master.set;
    let mut axis = NcToPlcAxis {
        state_word: state_word(master),
        error_code: master.error_code,
        axis_state: AxisState::of_motion(set.velocity, set.acceleration),
        axis_id: id,
        actual_position: set.position,
        actual_velocity: set.velocity,
        set_position: set.position,
        set_velocity: set.velocity,
        set_acceleration: set.acceleration,
        target_position: set.position,
        ..NcToPlcAxis::default()
    };
    axis.count_turns(modulo);
    axis
}

/// Builds the state word. An axis is operational only once its clock is known.
fn state_word(master: &Master) -> StateWord {
    let mut word = StateWord::HOMED | StateWord::of_velocity(master.set.velocity);
    word.set(StateWord::OPERATIONAL, master.is_ready);
    word.set(StateWord::ERROR, master.error_code != 0);
    word
}
