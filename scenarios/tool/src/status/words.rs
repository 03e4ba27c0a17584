//! Numbers of a status in words.

/// Text of an unknown value.
pub(crate) const UNKNOWN: &str = "–";

/// `12.41 ± 0.08 ppm slow`: how a clock runs beside the own one.
pub(super) fn drift(ppm: f64, sigma: Option<f64>) -> String {
    // A far clock that runs fast has a positive drift.
    let way = if ppm < 0.0 { "slow" } else { "fast" };
    match sigma {
        Some(sigma) => {
            let digits = digits_for(sigma);
            format!("{:.digits$} ± {sigma:.digits$} ppm {way}", ppm.abs())
        }
        None => format!("{:.2} ppm {way}", ppm.abs()),
    }
}

/// Number of decimals for a value with this standard deviation.
fn digits_for(sigma: f64) -> usize {
    match sigma {
        // Two digits of a standard deviation from 0.1 to 100: more digits of the value would be noise.
        _ if sigma >= 10.0 => 0,
        _ if sigma >= 1.0 => 1,
        _ if sigma >= 0.1 => 2,
        _ => 3,
    }
}

/// Period after which a cycle is missed or read twice without correction, s; none if the clocks run at the same rate.
pub(super) fn beat_period(cycle_time_us: f64, drift_ppm: f64) -> Option<f64> {
    // µs / (µs/s): at 500 ppm and 1 ms the clocks are a cycle apart after 2 s.
    let period = cycle_time_us / drift_ppm.abs();
    // A drift of 0 divides to infinity, which is no period.
    period.is_finite().then_some(period)
}

/// A time in microseconds, with a fitting unit.
pub(crate) fn micros(us: f64) -> String {
    match us.abs() {
        // By the magnitude; NaN falls through to the last arm.
        0.0..1e3 => format!("{us:.1} µs"),
        1e3..1e6 => format!("{:.2} ms", us * 1e-3),
        _ => seconds(us * 1e-6),
    }
}

/// A time in seconds, with a fitting unit.
pub(super) fn seconds(s: f64) -> String {
    match s.abs() {
        0.0..1e-3 => format!("{:.1} µs", s * 1e6),
        1e-3..1.0 => format!("{:.1} ms", s * 1e3),
        // Two of a unit at least, with a decimal: never fewer than two digits.
        1.0..120.0 => format!("{s:.1} s"),
        120.0..7_200.0 => format!("{:.1} min", s / 60.0),
        7_200.0..172_800.0 => format!("{:.1} h", s / 3_600.0),
        _ => format!("{:.1} days", s / 86_400.0),
    }
}

/// The text of a value, or of an unknown one.
pub(super) fn or_unknown(value: Option<f64>, shown: impl Fn(f64) -> String) -> String {
    value.map_or_else(|| UNKNOWN.to_owned(), shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_is_fast_or_slow_in_digits_that_are_known() {
        assert_eq!(drift(12.4, Some(0.084)), "12.400 ± 0.084 ppm fast");
        assert_eq!(drift(-12.4, Some(0.3)), "12.40 ± 0.30 ppm slow");
        assert_eq!(drift(-0.25, None), "0.25 ppm slow");
        assert_eq!(drift(740.2, Some(33.0)), "740 ± 33 ppm fast");
    }

    #[test]
    fn beats_come_the_rarer_the_more_alike_clocks_are() {
        assert_eq!(beat_period(1_000.0, -500.0), Some(2.0));
        assert_eq!(beat_period(1_000.0, 0.0), None);
    }

    #[test]
    fn times_have_the_unit_that_suits_them() {
        assert_eq!(micros(-212.54), "-212.5 µs");
        assert_eq!(micros(21_454.9), "21.45 ms");
        assert_eq!(micros(2.5e6), "2.5 s");
        for (s, text) in [
            (0.000_41, "410.0 µs"),
            (0.25, "250.0 ms"),
            (119.0, "119.0 s"),
            (150.0, "2.5 min"),
            (9_000.0, "2.5 h"),
            (259_200.0, "3.0 days"),
        ] {
            assert_eq!(seconds(s), text);
        }
        assert_eq!(or_unknown(None, seconds), "–");
    }
}
