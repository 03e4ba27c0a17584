//! Communication points and steps, in whole cycles.

use coaxle_clock::CycleTime;
use coaxle_node::config::Wrong;

/// Greatest deviation of a communication point or step from whole cycles, of a cycle: what sums of floating point numbers are off by.
// A million seconds have a rounding error of 1e-10 s, a millionth of the shortest cycle.
const TOLERANCE: f64 = 1e-3;
/// Most cycles of a step.
// A hundred seconds at the usual cycle: one that was meant in other units is refused rather than waited for.
const MOST_CYCLES: f64 = 100_000.0;

/// Checks a communication step that begins `passed` cycles after `start_s`, and returns its number of cycles.
///
/// # Errors
/// [`Wrong`]: another point than the one reached, or a step that is no whole number of cycles.
pub(crate) fn cycles_of(
    cycle: CycleTime,
    start_s: f64,
    passed: u64,
    point_s: f64,
    size_s: f64,
) -> Result<u32, Wrong> {
    let cycle = cycle.as_secs_f64();
    let reached = passed as f64 * cycle + start_s;
    // A NaN compares as false.
    let is_there = (point_s - reached).abs() <= TOLERANCE * cycle;
    if !is_there {
        let expected = format!("{reached} s, where the last step ended");
        let received = format!("{point_s} s");
        return Err(Wrong::of("currentCommunicationPoint", received, expected));
    }
    let cycles = size_s / cycle;
    let is_whole = (cycles - cycles.round()).abs() <= TOLERANCE;
    if !(is_whole && is_number_of_cycles(cycles.round())) {
        let expected = format!("a whole number of cycles of {cycle} s, 1 to {MOST_CYCLES}");
        let received = format!("{size_s} s");
        return Err(Wrong::of("communicationStepSize", received, expected));
    }
    Ok(cycles.round() as u32)
}

/// True for a number of cycles that a step can have.
pub(crate) fn is_number_of_cycles(number: f64) -> bool {
    (1.0..=MOST_CYCLES).contains(&number) && number.fract() == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::Span;

    fn cycles(point_s: f64, size_s: f64) -> Result<u32, String> {
        let cycle = CycleTime::new(Span::from_millis(1)).unwrap();
        cycles_of(cycle, 2.0, 7, point_s, size_s).map_err(|wrong| wrong.to_string())
    }

    #[test]
    fn a_step_is_a_whole_number_of_cycles() {
        assert_eq!(cycles(2.007, 0.001), Ok(1));
        // As a master adds it up.
        assert_eq!(cycles(2.0 + 0.001 * 7.0, 0.1 + 0.2), Ok(300));
        for (point_s, size_s, expected) in [
            (
                2.007,
                0.0,
                "communicationStepSize: received 0 s, expected a whole number of cycles of 0.001 s, 1 to 100000",
            ),
            (2.007, -0.001, "communicationStepSize: received -0.001 s"),
            (2.007, 0.0015, "communicationStepSize: received 0.0015 s"),
            (2.007, f64::NAN, "communicationStepSize: received NaN s"),
            (
                2.007,
                f64::INFINITY,
                "communicationStepSize: received inf s",
            ),
            (2.007, 1e300, "communicationStepSize: received 1"),
            (
                2.006,
                0.001,
                "currentCommunicationPoint: received 2.006 s, expected 2.007 s, where the last step ended",
            ),
            (f64::NAN, 0.001, "currentCommunicationPoint: received NaN s"),
        ] {
            let refused = cycles(point_s, size_s).unwrap_err();
            assert!(refused.starts_with(expected), "{refused}");
        }
    }
}
