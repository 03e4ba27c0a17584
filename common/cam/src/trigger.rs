//! Moment at which a queued change is due.

use super::change_moment::{ChangeMoment, Direction, MasterStep};
use super::command::Activation;
use super::modes::ActivationMode;
use super::placement::PlacedPlate;
use coaxle_plate::Course;

/// Returns the moment of the activation, if it falls in this step. `first`: the first step after the
/// command, in which a master that stands on the position is enough. `plate`: the plate that positions
/// refer to.
pub(super) fn due(
    activation: &Activation,
    plate: Option<&PlacedPlate<'_>>,
    step: MasterStep,
    first: bool,
) -> Option<ChangeMoment> {
    let position = activation.position;
    let passed = |forwards, backwards| {
        passes(step, position, first, forwards, backwards).then(|| ChangeMoment::at(position))
    };
    match activation.mode {
        // The start of the step: the master of the last cycle, at which the slave's course is known.
        ActivationMode::Instantaneous => Some(ChangeMoment::at(step.from)),
        ActivationMode::AtMasterAxisPos => passed(true, true),
        ActivationMode::AtMasterAxisPosPositiveDirection => passed(true, false),
        ActivationMode::AtMasterAxisPosNegativeDirection => passed(false, true),
        ActivationMode::AtMasterCamPos => at_cam_position(plate?, position, step, first),
        ActivationMode::NextCycle | ActivationMode::NextCycleOnce => next_cycle(plate?, step),
        ActivationMode::AsSoonAsPossible
        | ActivationMode::Off
        | ActivationMode::DeleteQueuedData => None,
    }
}

/// True if the step passes a position in one of the requested directions.
fn passes(step: MasterStep, position: f64, first: bool, forwards: bool, backwards: bool) -> bool {
    let MasterStep { from, to } = step;
    let stands_there = first && from == position;
    // Half open, so that a position at which one step ends is not passed again by the next.
    let up = from < position && position <= to || stands_there && to > from;
    let down = from > position && position >= to || stands_there && to < from;
    forwards && up || backwards && down || forwards && backwards && stands_there
}

fn at_cam_position(
    placed: &PlacedPlate<'_>,
    position: f64,
    step: MasterStep,
    first: bool,
) -> Option<ChangeMoment> {
    if placed.plate.course() == Course::Linear {
        let on_axis = placed.placement.on_axis(position);
        return passes(step, on_axis, first, true, true).then(|| ChangeMoment::at(on_axis));
    }
    // No seam: a plate to come must not begin at its own start.
    passed_in_a_cycle(placed, position, step, first).map(|moment| ChangeMoment {
        edge: None,
        ..moment
    })
}

/// Returns the place at which the plate passes to another cycle; of a linear one, at which the master
/// leaves its range.
pub(super) fn next_cycle(placed: &PlacedPlate<'_>, step: MasterStep) -> Option<ChangeMoment> {
    let (start, end) = placed.plate.master_range();
    if placed.plate.course() == Course::Cyclic {
        return passed_in_a_cycle(placed, start, step, false);
    }
    let from = placed.placement.on_plate(step.from);
    let to = placed.placement.on_plate(step.to);
    let on_axis = |cam_master| placed.placement.on_axis(cam_master);
    // A master that is already outside has left.
    let (master, direction) = if from > end {
        (step.from, Direction::Forwards)
    } else if from < start {
        (step.from, Direction::Backwards)
    } else if from < to && to >= end {
        (on_axis(end), Direction::Forwards)
    } else if from > to && to <= start {
        (on_axis(start), Direction::Backwards)
    } else {
        return None;
    };
    Some(ChangeMoment {
        master,
        edge: Some(direction),
    })
}

/// Returns the first time in the step that a cyclic plate passes a position.
fn passed_in_a_cycle(
    placed: &PlacedPlate<'_>,
    position: f64,
    step: MasterStep,
    first: bool,
) -> Option<ChangeMoment> {
    let period = placed.plate.period();
    let turns = |master| placed.placement.turns_from(position, placed.plate, master);
    let (from, to) = (turns(step.from), turns(step.to));
    // In positions of the plate: a negative scaling turns forwards on the axis into backwards here.
    let (turn, direction) = if first && from == libm::floor(from) {
        (from, Direction::Forwards)
    } else if from < to {
        // Strictly beyond: a master on the position has passed it in the step before.
        (libm::floor(from) + 1.0, Direction::Forwards)
    } else {
        // A master at standstill comes here, too, and does not reach the turn below it.
        (libm::ceil(from) - 1.0, Direction::Backwards)
    };
    let reached = match direction {
        _ if turn == from => true,
        Direction::Forwards => turn <= to,
        Direction::Backwards => turn >= to,
    };
    reached.then(|| ChangeMoment {
        master: placed.placement.on_axis(position + turn * period),
        edge: Some(direction),
    })
}
