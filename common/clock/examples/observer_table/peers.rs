//! Simple alternatives to the observer, on equal arrivals, each with the tuning that suited it best.

use coaxle_clock::observer::{ObserverOutput, ObserverParameters, ObserverState, PhaseObserver};
use coaxle_clock::time_sync::{TimeSync, TimeSyncParameters};
use coaxle_clock::{CycleIndex, CycleTime, Instant, Local, Span};

use crate::world::{Exchange, Message};

/// Estimator of far time from arrivals.
pub(crate) trait Follower {
    fn observe(&mut self, message: &Message);
    /// Takes a request and its response, when the response has come. A follower of arrivals alone ignores it.
    fn exchange(&mut self, _exchange: &Exchange) {}
    /// The far time, s, at the local time `now` (ns).
    fn far(&mut self, now: i64) -> Option<f64>;
    fn output(&self) -> Option<ObserverOutput> {
        None
    }
}

pub(crate) struct Observer {
    observer: PhaseObserver,
    output: ObserverOutput,
}

impl Observer {
    pub(crate) fn new(cycle: f64) -> Self {
        let cycle = CycleTime::new(Span::from_secs_f64(cycle)).unwrap();
        Self {
            observer: PhaseObserver::new(cycle, ObserverParameters::default()).unwrap(),
            output: ObserverOutput::default(),
        }
    }
}

impl Follower for Observer {
    fn observe(&mut self, message: &Message) {
        let arrived: Instant<Local> = Instant::from_nanos(message.arrived);
        let stamp = message.stamp.map(Span::from_nanos);
        self.observer
            .observe(1, message.count as u64, arrived, stamp);
    }
    fn far(&mut self, now: i64) -> Option<f64> {
        self.output = self.observer.cycle(Instant::from_nanos(now));
        let far = self.output.far_time?;
        (self.output.state != ObserverState::Startup)
            .then(|| far.instant.as_nanos() as f64 * 1e-9 + far.fraction_ns * 1e-9)
    }
    fn output(&self) -> Option<ObserverOutput> {
        Some(self.output)
    }
}

/// TS5066: it sees only which index lies in the input image when a cycle begins. `slope` is the
/// numerator and the denominator of its ramps; 0.95 and 0.5 are the manual's.
pub(crate) struct Ts5066 {
    cycle: f64,
    block: TimeSync,
    newest: Option<i64>,
}

impl Ts5066 {
    pub(crate) fn new(cycle: f64, slope1_numerator: f64) -> Self {
        let parameters = TimeSyncParameters {
            slope1_numerator,
            // The spikes of the cases are no faults.
            max_cycle_index_difference: 500.0,
            age_of_data_limit: Some(500),
            automatic_re_init: true,
            ..TimeSyncParameters::default()
        };
        Self {
            cycle,
            block: TimeSync::start(Span::from_secs_f64(cycle), parameters).unwrap(),
            newest: None,
        }
    }
}

impl Follower for Ts5066 {
    fn observe(&mut self, message: &Message) {
        self.newest = self.newest.max(Some(message.count));
    }
    fn far(&mut self, _now: i64) -> Option<f64> {
        let newest = self.newest?;
        let output = self.block.update(CycleIndex::of_count(newest as u64), 1);
        let ahead = output.correction_time?;
        Some(newest as f64 * self.cycle + ahead.0)
    }
}

/// Returns the due time of a message by its count, and its lateness beyond the send stamp, s.
pub(crate) fn phase(message: &Message, cycle: f64) -> (f64, f64) {
    let due = message.count as f64 * cycle;
    let arrived = (message.arrived - message.stamp.unwrap_or(0)) as f64 * 1e-9;
    (due, arrived - due)
}

/// Far time from a line `offset + drift·(due − at)`.
pub(crate) fn far_by(now: i64, at: f64, offset: f64, drift: f64) -> f64 {
    at + (now as f64 * 1e-9 - at - offset) / (1.0 + drift)
}

/// A two-state Kalman filter on every message, as if the jitter were normal; outliers of more than three sigma are
/// clamped. Noise and random walk are given.
pub(crate) struct Kalman {
    cycle: f64,
    noise: f64,
    walk: f64,
    expected_drift: f64,
    clamp: f64,
    at: f64,
    x: Option<(f64, f64)>,
    p: (f64, f64, f64),
}

impl Kalman {
    pub(crate) fn new(cycle: f64, noise: f64, walk: f64) -> Self {
        Self {
            cycle,
            noise: noise * noise,
            walk: walk * walk,
            // The observer begins with the same.
            expected_drift: 1e-4,
            clamp: 3.0,
            at: 0.0,
            x: None,
            p: (0.0, 0.0, 0.0),
        }
    }

    /// Takes a message and returns the negative logarithm of its likelihood.
    fn take(&mut self, message: &Message) -> f64 {
        let (due, phase) = phase(message, self.cycle);
        let Some((mut offset, mut drift)) = self.x else {
            self.x = Some((phase, 0.0));
            self.p = (self.noise, 0.0, self.expected_drift.powi(2));
            self.at = due;
            return 0.0;
        };
        let dt = (due - self.at).max(0.0);
        self.at = self.at.max(due);
        let (mut a, mut b, mut c) = self.p;
        offset += drift * dt;
        a += dt * (2.0 * b + dt * (c + self.walk * dt / 3.0));
        b += dt * (c + 0.5 * self.walk * dt);
        c += self.walk * dt;
        let total = a + self.noise;
        let bound = self.clamp * total.sqrt();
        // Spikes of milliseconds would throw a plain filter off for minutes.
        let innovation = (phase - offset).clamp(-bound, bound);
        offset += a / total * innovation;
        drift += b / total * innovation;
        self.p = (a - a * a / total, b - a * b / total, c - b * b / total);
        self.x = Some((offset, drift));
        0.5 * (innovation * innovation / total + (total / self.noise).ln())
    }
}

impl Follower for Kalman {
    fn observe(&mut self, message: &Message) {
        let _ = self.take(message);
    }
    fn far(&mut self, now: i64) -> Option<f64> {
        self.x
            .map(|(offset, drift)| far_by(now, self.at, offset, drift))
    }
}

/// Best possible estimate: the exact posterior mean for normal jitter of equal information, when its width, the
/// random walk and the distribution of the drift are known.
pub(crate) struct Efficient {
    lines: Vec<(Kalman, f64)>,
}

impl Efficient {
    pub(crate) fn new(case: &crate::world::Case) -> Self {
        let noise = case.efficient.unwrap();
        // Together nearly log-uniform from 1 to 100 ppm.
        let lines = [1.5e-6, 4e-6, 10e-6, 25e-6, 65e-6].map(|expected_drift| {
            let line = Kalman {
                expected_drift,
                clamp: f64::INFINITY,
                ..Kalman::new(case.cycle, noise, case.walk)
            };
            (line, 0.0)
        });
        Self {
            lines: lines.into(),
        }
    }
}

impl Follower for Efficient {
    fn observe(&mut self, message: &Message) {
        for (line, loss) in &mut self.lines {
            *loss += line.take(message);
        }
    }
    fn far(&mut self, now: i64) -> Option<f64> {
        let least = self.lines.iter().map(|(_, loss)| *loss);
        let least = least.fold(f64::INFINITY, f64::min);
        let (mut sum, mut total) = (0.0, 0.0);
        for (line, loss) in &mut self.lines {
            let weight = (least - *loss).exp();
            let ahead = line.far(now)? - now as f64 * 1e-9;
            sum += weight * ahead;
            total += weight;
        }
        Some(now as f64 * 1e-9 + sum / total)
    }
}

/// A straight line fitted to a number of the last messages.
pub(crate) struct LeastSquares {
    cycle: f64,
    window: std::collections::VecDeque<(f64, f64)>,
    length: usize,
    sums: [f64; 4],
    base: Option<(f64, f64)>,
}

impl LeastSquares {
    pub(crate) fn new(cycle: f64, seconds: f64) -> Self {
        Self {
            cycle,
            window: std::collections::VecDeque::new(),
            length: (seconds / cycle) as usize,
            sums: [0.0; 4],
            base: None,
        }
    }
    fn add(&mut self, (t, y): (f64, f64), sign: f64) {
        for (sum, term) in self.sums.iter_mut().zip([t, y, t * t, t * y]) {
            *sum += sign * term;
        }
    }
}

impl Follower for LeastSquares {
    fn observe(&mut self, message: &Message) {
        let (due, phase) = phase(message, self.cycle);
        let base = *self.base.get_or_insert((due, phase));
        let point = (due - base.0, phase - base.1);
        self.window.push_back(point);
        self.add(point, 1.0);
        if self.window.len() > self.length {
            let oldest = self.window.pop_front().unwrap();
            self.add(oldest, -1.0);
        }
    }
    fn far(&mut self, now: i64) -> Option<f64> {
        let n = self.window.len() as f64;
        if n < 16.0 {
            return None;
        }
        let base = self.base?;
        let [t, y, tt, ty] = self.sums.map(|sum| sum / n);
        let drift = (ty - t * y) / (tt - t * t);
        Some(far_by(now, base.0 + t, base.1 + y, drift))
    }
}

/// The least phase of each block, followed by a proportional-integral servo.
pub(crate) struct MinimumServo {
    cycle: f64,
    length: usize,
    filled: usize,
    least: f64,
    line: Option<(f64, f64, f64)>,
    bandwidth: f64,
}

impl MinimumServo {
    pub(crate) fn new(cycle: f64, length: usize, bandwidth: f64) -> Self {
        Self {
            cycle,
            length,
            filled: 0,
            least: f64::INFINITY,
            line: None,
            bandwidth,
        }
    }
}

impl Follower for MinimumServo {
    fn observe(&mut self, message: &Message) {
        let (due, phase) = phase(message, self.cycle);
        let (at, offset, drift) = self.line.unwrap_or((due, 0.0, 0.0));
        self.least = self.least.min(phase - offset - drift * (due - at));
        self.filled += 1;
        if self.filled == self.length {
            let dt = self.length as f64 * self.cycle;
            let w = self.bandwidth * dt;
            self.line = Some(if self.line.is_none() {
                (due, self.least, 0.0)
            } else {
                (
                    due,
                    offset + drift * (due - at) + 1.4 * w * self.least,
                    drift + w * w / dt * self.least,
                )
            });
            self.filled = 0;
            self.least = f64::INFINITY;
        }
    }
    fn far(&mut self, now: i64) -> Option<f64> {
        self.line
            .map(|(at, offset, drift)| far_by(now, at, offset, drift))
    }
}

/// The lower convex hull of a window of phases: its edge below the middle of the window.
pub(crate) struct Hull {
    cycle: f64,
    seconds: f64,
    hull: std::collections::VecDeque<(f64, f64)>,
}

impl Hull {
    pub(crate) fn new(cycle: f64, seconds: f64) -> Self {
        Self {
            cycle,
            seconds,
            hull: std::collections::VecDeque::new(),
        }
    }
}

impl Follower for Hull {
    fn observe(&mut self, message: &Message) {
        let point = phase(message, self.cycle);
        if self.hull.back().is_some_and(|last| point.0 <= last.0) {
            return;
        }
        while self.hull.len() >= 2 {
            let (a, b) = (
                self.hull[self.hull.len() - 2],
                self.hull[self.hull.len() - 1],
            );
            let turn = (b.0 - a.0) * (point.1 - a.1) - (b.1 - a.1) * (point.0 - a.0);
            if turn > 0.0 {
                break;
            }
            let _ = self.hull.pop_back();
        }
        self.hull.push_back(point);
        while self.hull.len() > 2 && self.hull[1].0 < point.0 - self.seconds {
            let _ = self.hull.pop_front();
        }
    }
    fn far(&mut self, now: i64) -> Option<f64> {
        let (first, last) = (*self.hull.front()?, *self.hull.back()?);
        let middle = 0.5 * (first.0 + last.0);
        let right = self.hull.iter().position(|point| point.0 >= middle)?.max(1);
        let (a, b) = (*self.hull.get(right - 1)?, *self.hull.get(right)?);
        Some(far_by(now, a.0, a.1, (b.1 - a.1) / (b.0 - a.0)))
    }
}
