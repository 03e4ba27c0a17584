//! Log lines on a time that both nodes have in common.

use coaxle_clock::timing::TimingState;

use crate::signals::FarNodeSignals;

/// Log line on a common time that cannot be right.
pub(super) fn clocks_disagree(signals: &FarNodeSignals) -> String {
    let Some(apart) = signals.common_time_apart_us else {
        return "the common times of both nodes are more than a second apart: one of them lacks the offset of TAI from UTC; \
                its clock is followed without"
            .to_owned();
    };
    let bound = signals.common_time_bound_us.unwrap_or_default();
    let by_beacons = (signals.timing_round_trip_us)
        .filter(|_| signals.timing_state == Some(TimingState::InUse))
        .map(|round_trip| format!("beacons have it, to {:.3} us", 0.5 * round_trip));
    let ways = by_beacons.unwrap_or_else(|| {
        let uncertainty = signals.delay_uncertainty_us.unwrap_or_default();
        format!("messages have it, to {uncertainty:.3} us")
    });
    format!(
        "clocks disagree: by the common time, stated to {bound:.3} us, its clock is {apart:+.3} us from where {ways}; \
         the common time is not followed"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_names_both_with_their_figures() {
        let mut signals = FarNodeSignals {
            common_time_apart_us: Some(-19.98),
            common_time_bound_us: Some(0.2),
            timing_round_trip_us: Some(3.0),
            timing_state: Some(TimingState::InUse),
            delay_uncertainty_us: Some(150.0),
            ..FarNodeSignals::default()
        };
        let line = clocks_disagree(&signals);
        assert!(
            line.contains("stated to 0.200 us, its clock is -19.980 us from where beacons have it, to 1.500 us"),
            "{line}"
        );
        signals.timing_state = Some(TimingState::Held);
        let line = clocks_disagree(&signals);
        assert!(line.contains("messages have it, to 150.000 us"), "{line}");
        signals.common_time_apart_us = None;
        assert!(clocks_disagree(&signals).contains("offset of TAI from UTC"));
    }
}
