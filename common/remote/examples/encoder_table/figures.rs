//! Quality of the emitted positions of a run.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use coaxle_axis::TravelDirection;

use crate::peers::Follower;
use crate::world::{CYCLE, Case, HORIZON, START};

/// Figures of one run, or the worst of many. Lengths in µm, everything by differences of positions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Figures {
    /// Largest error once the profile has settled.
    pub largest: f64,
    /// Mean square of this error.
    pub square: f64,
    /// Mean of this error, as an amount.
    pub mean: f64,
    /// Largest error of the whole run.
    pub ever: f64,
    /// Largest error from 0.3 s after a stop on.
    pub standing: f64,
    /// Mean square of the velocity's error, from when it has settled, (mm/s)².
    pub velocity_square: f64,
    /// mm/s².
    pub acceleration: f64,
    /// mm/s³.
    pub jerk: f64,
    /// Number of announced directions in which the axis did not move.
    pub false_directions: u32,
    /// Cycles with a position behind the previous one, against the direction, outside a walk back.
    pub undershoots: u32,
    /// Root mean square of error over announced standard deviation.
    pub sigmas: f64,
}

/// Accumulates the figures of a run.
struct Judge {
    figures: Figures,
    settled: Sums,
    scaled: Sums,
    positions: [f64; 4],
    direction: Option<TravelDirection>,
    /// The least and the largest true position since a direction was announced.
    range: (f64, f64),
}

#[derive(Default)]
struct Sums {
    cycles: f64,
    error: f64,
    square: f64,
    velocity_square: f64,
}

/// Follows a run.
pub fn followed(case: &Case, follower: &mut dyn Follower) -> Figures {
    let run = case.run();
    let (settled, stopped) = (run.settled, run.stopped);
    let mut judge = Judge::default();
    let (mut missed, mut moved) = (0_u32, 0_u32);
    for scene in run {
        missed = if scene.count.is_some() { 0 } else { missed + 1 };
        let position = follower.update(scene.count, HORIZON + f64::from(missed) * CYCLE);
        judge.emit(position);
        // Judging begins 0.1 s before the motion: a direction announced at rest is a false one.
        if scene.time < START - 0.1 {
            judge.range = (scene.sampled.position, scene.sampled.position);
            continue;
        }
        moved += 1;
        let error = 1e3 * (position - scene.wanted.position);
        judge.limits(moved);
        judge.figures.ever = judge.figures.ever.max(error.abs());
        if scene.time >= settled {
            judge.steady(error, scene.wanted.velocity);
        }
        if stopped.is_some_and(|stopped| scene.time > stopped + 0.3) {
            judge.figures.standing = judge.figures.standing.max(error.abs());
        }
        if let Some(output) = follower.output() {
            if scene.time >= settled {
                let scaled = error / (1e3 * output.position_sigma);
                judge.scaled.cycles += 1.0;
                judge.scaled.square += scaled * scaled;
            }
            judge.direction(output.direction, output.trimming, scene.sampled.position);
        }
    }
    judge.done()
}

impl Default for Judge {
    fn default() -> Self {
        Self {
            figures: Figures::default(),
            settled: Sums::default(),
            scaled: Sums::default(),
            // NaN never exceeds a maximum, so that the first cycles without a difference count for nothing.
            positions: [f64::NAN; 4],
            direction: None,
            range: (0.0, 0.0),
        }
    }
}

impl Judge {
    fn emit(&mut self, position: f64) {
        self.positions.rotate_right(1);
        self.positions[0] = position;
    }

    fn velocity(&self) -> f64 {
        (self.positions[0] - self.positions[1]) / CYCLE
    }

    fn limits(&mut self, cycles: u32) {
        // A third difference needs four positions of the motion itself.
        if cycles < 4 {
            return;
        }
        let [p0, p1, p2, p3] = self.positions;
        // Differences of the positions, which a drive is given, and not the reported acceleration, which might
        // flatter.
        let acceleration = (p0 - 2.0 * p1 + p2) / (CYCLE * CYCLE);
        let jerk = (p0 - 3.0 * p1 + 3.0 * p2 - p3) / (CYCLE * CYCLE * CYCLE);
        let figures = &mut self.figures;
        figures.acceleration = figures.acceleration.max(acceleration.abs());
        figures.jerk = figures.jerk.max(jerk.abs());
    }

    fn steady(&mut self, error: f64, velocity: f64) {
        let by = self.velocity() - velocity;
        self.figures.largest = self.figures.largest.max(error.abs());
        self.settled.cycles += 1.0;
        self.settled.error += error;
        self.settled.square += error * error;
        self.settled.velocity_square += by * by;
    }

    /// A direction that was announced must be one in which the axis moved since the last one.
    fn direction(&mut self, direction: Option<TravelDirection>, trimming: bool, position: f64) {
        let (low, high) = (self.range.0.min(position), self.range.1.max(position));
        self.range = (low, high);
        if direction != self.direction {
            let went = match direction {
                // Movement by any amount since the last direction suffices: the gate may report it late.
                Some(TravelDirection::Forward) => position > low,
                Some(TravelDirection::Backward) => position < high,
                None => false,
            };
            if !went {
                self.figures.false_directions += 1;
            }
            self.direction = direction;
            self.range = (position, position);
        }
        let sign = direction.map_or(0.0, TravelDirection::sign);
        // Rounding residues of a position of metres stay far below 1e-6 mm/s.
        if self.velocity() * sign < -1e-6 && !trimming {
            self.figures.undershoots += 1;
        }
    }

    fn done(self) -> Figures {
        // A run may end before it settles, whose means are then 0 instead of NaN.
        let cycles = self.settled.cycles.max(1.0);
        Figures {
            square: self.settled.square / cycles,
            mean: (self.settled.error / cycles).abs(),
            velocity_square: self.settled.velocity_square / cycles,
            sigmas: (self.scaled.square / self.scaled.cycles.max(1.0)).sqrt(),
            ..self.figures
        }
    }
}

impl Figures {
    /// The worst of both; for mean squares and sigmas the largest too.
    #[must_use]
    pub fn or(self, other: &Self) -> Self {
        Self {
            largest: self.largest.max(other.largest),
            square: self.square.max(other.square),
            mean: self.mean.max(other.mean),
            ever: self.ever.max(other.ever),
            standing: self.standing.max(other.standing),
            velocity_square: self.velocity_square.max(other.velocity_square),
            acceleration: self.acceleration.max(other.acceleration),
            jerk: self.jerk.max(other.jerk),
            false_directions: self.false_directions + other.false_directions,
            undershoots: self.undershoots + other.undershoots,
            sigmas: self.sigmas.max(other.sigmas),
        }
    }
}

/// Follows all cases, each with a follower of its own, on all cores; returns the figures in the
/// order of the cases.
pub fn all(cases: &[Case], make: &(dyn Fn(&Case) -> Box<dyn Follower> + Sync)) -> Vec<Figures> {
    let next = AtomicUsize::new(0);
    let done = Mutex::new(vec![Figures::default(); cases.len()]);
    let work = || {
        while let Some((number, case)) = {
            // A counter for all threads: a case that takes long delays no other.
            let number = next.fetch_add(1, Ordering::Relaxed);
            cases.get(number).map(|case| (number, case))
        } {
            let figures = followed(case, &mut *make(case));
            // Each result has the place of its case, whichever thread is faster.
            done.lock().unwrap()[number] = figures;
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            let _ = scope.spawn(work);
        }
    });
    done.into_inner().unwrap()
}
