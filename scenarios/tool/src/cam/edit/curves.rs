//! Curves of a plate.

use coaxle_curve::law::Motion;
use coaxle_plate::Plate;
use serde_json::{Value, json};

use super::view_settings::ViewSettings;

/// Places drawn of a turn, as far as its joints leave a choice.
// About the pixels of a wide chart.
const SAMPLES: usize = 1_200;
/// Most places in all.
// Ten turns at full detail; more turns have fewer places each.
const MOST: usize = 12_000;
/// Most joints at which both sides are drawn.
// At 400 joints each segment still has three places and its end.
const MOST_JOINTS: usize = 400;

/// Position, velocity, acceleration and jerk, in the page's view settings.
pub(super) fn curve(plate: &Plate, name: &str, settings: &ViewSettings) -> Value {
    let mut along = Vec::new();
    let mut values: [Vec<f64>; 4] = Default::default();
    let (start, end) = plate.master_range();
    let turns = settings.turns_of(plate);
    for turn in 0..turns {
        // Multiplied, not added up: rounding does not grow with the turns.
        let offset = f64::from(turn) * (end - start);
        let lift = f64::from(turn) * plate.lift();
        for (master, motion) in places(plate, SAMPLES.min(MOST / turns as usize)) {
            along.push(settings.along(start, master + offset));
            let Motion {
                position,
                velocity,
                acceleration,
                jerk,
            } = motion;
            let row = [position + lift, velocity, acceleration, jerk];
            for (quantity, value) in row.into_iter().enumerate() {
                values[quantity].push(value * settings.factor(quantity));
            }
        }
    }
    json!({ "name": name, "along": along, "values": values })
}

/// A turn; at each joint the values of both sides, so that jumps are upright.
fn places(plate: &Plate, samples: usize) -> Vec<(f64, Motion)> {
    let (start, end) = plate.master_range();
    let mut marks: Vec<f64> = plate.joints().map(|joint| joint.master).collect();
    // `step_by(0)` would panic, but a plate has a joint at its start at least.
    let every = marks.len().div_ceil(MOST_JOINTS);
    marks = marks
        .into_iter()
        .step_by(every)
        .filter(|mark| *mark < end)
        .collect();
    marks.push(end);
    let stretches = marks.len().saturating_sub(1).max(1);
    // At least two places, so that a short segment between joints keeps its slope.
    let count = (samples / stretches).clamp(2, 400);
    let mut places = Vec::new();
    for pair in marks.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        // Without the end of the segment, which follows with the values before the joint.
        for n in 0..count {
            let master = from + (to - from) * (n as f64 / count as f64);
            places.push((master, plate.at(master)));
        }
        // The last place before the next segment, or before the next turn.
        let last = plate.at(to.next_down().max(start));
        places.push((to, last));
    }
    places
}
