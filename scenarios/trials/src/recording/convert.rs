//! Conversion of a receiver's raw arrivals, in two clocks, to a recording on one time scale.

use coaxle_node::arrival::{ArrivalRow, ExchangeRow};

use super::format::{ArrivalRecording, RecordedExchange, RecordedMessage};
use super::raw::Raw;

/// Map from the receiver's clock to the sender's time: zero is the ideal start of the first
/// recorded cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TimeScale {
    /// The receiver's clock at zero, ns.
    zero_ns: i64,
    /// Relative excess of the receiver's clock rate over the sender's, s/s.
    drift: f64,
}

impl TimeScale {
    /// The two clocks are one, and the receiver's shows `zero_ns` at the ideal start of the first
    /// recorded cycle.
    pub(crate) const fn of_one_clock(zero_ns: i64) -> Self {
        Self {
            zero_ns,
            drift: 0.0,
        }
    }

    /// Scale of unknown clocks: fits the straight line through the earliest messages of each second,
    /// so that the least delay is zero.
    pub(crate) fn fitted(raw: &Raw) -> Self {
        let first = raw.sent_first();
        let points: Vec<FitPoint> = raw
            .messages
            .iter()
            .map(|row| FitPoint::of(first, row))
            .collect();
        let mut drift = 0.0;
        // Each pass finds the slope that is left after the ones before.
        for _ in 0..PASSES {
            drift += slope(&earliest(&points, drift));
        }
        let above = |point: &FitPoint| point.above(drift).phase;
        let least = points.iter().map(above).fold(f64::INFINITY, f64::min);
        Self {
            // Rounded down, so that the least delay is not negative.
            zero_ns: first.arrival_ns.saturating_add(least.floor() as i64),
            drift,
        }
    }

    /// Relative excess of the receiver's clock rate over the sender's, ppm.
    pub(crate) fn drift_ppm(&self) -> f64 {
        self.drift * 1e6
    }

    /// The sender's time, ns, when the receiver's clock shows `local_ns`.
    fn sender_time_ns(&self, local_ns: i64) -> i64 {
        let passed = local_ns.saturating_sub(self.zero_ns);
        // x/(1+d) = x − x·d/(1+d): only the small second term is rounded.
        let gained = passed as f64 * (self.drift / (1.0 + self.drift));
        passed.saturating_sub(gained.round() as i64)
    }
}

/// Puts everything on the time scale.
pub(crate) fn convert(raw: &Raw, scale: &TimeScale) -> ArrivalRecording {
    let first = raw.sent_first();
    let converted = raw.messages.iter().map(|row| message(first, row, scale));
    let messages: Vec<RecordedMessage> = converted.flatten().collect();
    let exchange = |row: &ExchangeRow| exchange(first, row, scale);
    ArrivalRecording {
        left_out: (raw.messages.len() - messages.len()) as u64,
        messages,
        exchanges: raw.exchanges.iter().map(exchange).collect(),
    }
}

/// Converts a message; none if a number is too large for the file.
fn message(first: &ArrivalRow, row: &ArrivalRow, scale: &TimeScale) -> Option<RecordedMessage> {
    // Wrapping and signed: a message that was overtaken may have a smaller count than the first.
    let count = row.count.wrapping_sub(first.count) as i64;
    let stamp = row.send_stamp_ns.unwrap_or(0);
    let due = count.checked_mul(first.cycle_time_ns)?;
    let sent = due.checked_add(stamp)?;
    let delay = scale.sender_time_ns(row.arrival_ns).checked_sub(sent)?;
    Some(RecordedMessage {
        count: count.try_into().ok()?,
        send_stamp_ns: stamp.try_into().ok()?,
        delay_ns: delay.try_into().ok()?,
    })
}

fn exchange(first: &ArrivalRow, row: &ExchangeRow, scale: &TimeScale) -> RecordedExchange {
    // The sender counts its own time since its cycle 0.
    let before = (first.count as i64).saturating_mul(first.cycle_time_ns);
    RecordedExchange {
        t1_ns: scale.sender_time_ns(row.t1_ns),
        t2_ns: row.t2_ns.saturating_sub(before),
        t3_ns: row.t3_ns.saturating_sub(before),
        t4_ns: scale.sender_time_ns(row.t4_ns),
    }
}

/// A message as the fit sees it, ns since the first one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FitPoint {
    /// The sender's time when it was sent.
    passed: f64,
    /// Arrival minus that: drift and delay.
    phase: f64,
}

impl FitPoint {
    fn of(first: &ArrivalRow, row: &ArrivalRow) -> Self {
        let count = row.count.wrapping_sub(first.count) as i64;
        let due = count.saturating_mul(first.cycle_time_ns);
        let sent = due.saturating_add(row.send_stamp_ns.unwrap_or(0));
        let arrived = row.arrival_ns.saturating_sub(first.arrival_ns);
        Self {
            passed: sent as f64,
            phase: arrived.saturating_sub(sent) as f64,
        }
    }

    /// The point without this drift.
    fn above(&self, drift: f64) -> Self {
        Self {
            phase: self.phase - drift * self.passed,
            ..*self
        }
    }
}

/// Window of the search for the earliest message; an eighth of shorter recordings.
// Long enough that some message of each is delayed by nothing but the path, short against the wander of clocks.
const WINDOW_NS: f64 = 1e9;
// A line needs several points: eight windows at least.
const SHORTEST: f64 = 8.0;
/// The earliest messages depend on the drift; it is known well enough after the first pass.
const PASSES: usize = 2;

/// The earliest point of each window, once a drift is taken away.
fn earliest(points: &[FitPoint], drift: f64) -> Vec<FitPoint> {
    let whole = points.iter().map(|point| point.passed).fold(0.0, f64::max);
    // At least a nanosecond: a recording of one instant would divide by 0.
    let window = WINDOW_NS.min(whole / SHORTEST).max(1.0);
    let mut found: Vec<(f64, FitPoint)> = Vec::new();
    for point in points.iter().map(|point| point.above(drift)) {
        let this = (point.passed / window).floor();
        match found.last_mut() {
            // Messages that were overtaken may belong to the window before: they are late anyway.
            Some((window, earliest)) if this <= *window => {
                if point.phase < earliest.phase {
                    *earliest = point;
                }
            }
            _ => found.push((this, point)),
        }
    }
    found.into_iter().map(|(_, point)| point).collect()
}

/// The slope of the line of least squares; zero through a single point.
fn slope(points: &[FitPoint]) -> f64 {
    let number = points.len() as f64;
    let mean = |of: fn(&FitPoint) -> f64| points.iter().map(of).sum::<f64>() / number;
    // About the means: sums of squares of hours in ns would cancel in f64.
    let (middle, level) = (mean(|point| point.passed), mean(|point| point.phase));
    let (mut covariance, mut variance) = (0.0, 0.0);
    for point in points {
        let away = point.passed - middle;
        covariance += away * (point.phase - level);
        variance += away * away;
    }
    // All points at one time have no slope.
    if variance > 0.0 {
        covariance / variance
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests;
