//! A stretch of the slave's way: a polynomial in the master's position, or in time.

use coaxle_curve::law::polynom::quintic;
use coaxle_curve::law::polynomial::Polynomial;
use coaxle_curve::law::roots::roots_between_turns;
use coaxle_curve::law::{Extreme, Extremes, MinMax, Motion, MotionLaw, Roots};

/// The slave's way from its position at `begin`, as a polynomial of `x`, which runs from 0 to 1
/// while the master (or the time) runs from `begin` over the signed `length`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    pub(super) begin: f64,
    pub(super) length: f64,
    position: f64,
    /// Counted from `position`: far from zero a position has few digits left for differences.
    way: Polynomial<6>,
}

impl Piece {
    /// P1: a constant slope.
    pub(super) fn line(begin: f64, length: f64, position: f64, slope: f64) -> Self {
        Self::new(
            begin,
            length,
            position,
            [0.0, slope * length, 0.0, 0.0, 0.0, 0.0],
        )
    }

    /// P5 where it degenerates to a ramp: the slope goes from one value to another along
    /// 3x² − 2x³, without curvature at either end.
    pub(super) fn ramp(begin: f64, length: f64, position: f64, from: f64, to: f64) -> Self {
        let rise = (to - from) * length;
        Self::new(
            begin,
            length,
            position,
            [0.0, from * length, 0.0, rise, -rise / 2.0, 0.0],
        )
    }

    /// The same with a start curvature: the slope is the cubic that meets slope and curvature at
    /// both ends.
    pub(super) fn curved_ramp(
        begin: f64,
        length: f64,
        position: f64,
        (from, curvature): (f64, f64),
        to: f64,
    ) -> Self {
        let bend = curvature * length * length;
        let rise = (to - from) * length;
        let way = [
            0.0,
            from * length,
            bend / 2.0,
            rise - 2.0 / 3.0 * bend,
            bend / 4.0 - rise / 2.0,
            0.0,
        ];
        Self::new(begin, length, position, way)
    }

    /// P5: from slope and curvature over `distance` to the slope `to` without curvature.
    pub(super) fn quintic(
        begin: f64,
        length: f64,
        (position, from, curvature): (f64, f64, f64),
        (distance, to): (f64, f64),
    ) -> Self {
        // Derivatives over the share of the length.
        let start = Motion {
            velocity: from * length,
            acceleration: curvature * length * length,
            ..Motion::default()
        };
        let end = Motion {
            position: distance,
            velocity: to * length,
            ..Motion::default()
        };
        Self::new(begin, length, position, quintic(&start, &end).0)
    }

    /// Constant jerk, over time.
    pub(super) fn phase(
        begin: f64,
        length: f64,
        position: f64,
        (velocity, acceleration, jerk): (f64, f64, f64),
    ) -> Self {
        let way = [
            0.0,
            velocity * length,
            acceleration / 2.0 * length * length,
            jerk / 6.0 * length * length * length,
            0.0,
            0.0,
        ];
        Self::new(begin, length, position, way)
    }

    /// The same course over another stretch of the master (or the time).
    pub(super) const fn spread(self, begin: f64, length: f64) -> Self {
        Self {
            begin,
            length,
            ..self
        }
    }

    fn new(begin: f64, length: f64, position: f64, way: [f64; 6]) -> Self {
        Self {
            begin,
            length,
            position,
            way: Polynomial(way),
        }
    }

    /// Where the slave is at its begin.
    pub(super) const fn position(&self) -> f64 {
        self.position
    }

    /// Where it ends.
    pub(super) fn end(&self) -> f64 {
        self.begin + self.length
    }

    /// Whether the master has passed its end.
    pub(super) fn is_left_by(&self, master: f64) -> bool {
        (master - self.end()) * self.length > 0.0
    }

    /// The slave's way from begin to end.
    pub(super) fn distance(&self) -> f64 {
        self.way.0.iter().sum()
    }

    /// Whether every number in it is one.
    pub(super) fn is_finite(&self) -> bool {
        let numbers = [self.begin, self.length, self.position];
        numbers.iter().chain(&self.way.0).all(|n| n.is_finite())
    }

    /// The slave and its derivatives with respect to the master (or time). Beyond its ends the
    /// polynomial goes on.
    pub(super) fn at(&self, master: f64) -> Motion {
        let x = (master - self.begin) / self.length;
        let [way, first, second, third] = self.way.derivatives(x);
        let inverse = 1.0 / self.length;
        Motion {
            position: self.position + way,
            velocity: first * inverse,
            acceleration: second * inverse * inverse,
            jerk: third * inverse * inverse * inverse,
        }
    }

    /// What it demands of the slave while the master runs at `master_velocity`.
    pub(super) fn demands(&self, master_velocity: f64) -> Demands {
        let rate = master_velocity / self.length;
        let velocity = self.way.derivative();
        if self.is_line() {
            return self.demands_of_line(velocity.0[0] * rate);
        }
        let acceleration = velocity.derivative();
        let jerk = acceleration.derivative();

        // The turns of each quantity are the roots of the next one.
        let jerk_turns = jerk.derivative().roots_in(0.0, 1.0);
        let acceleration_turns = roots_between_turns(&jerk, &jerk_turns, 0.0, 1.0);
        let velocity_turns = roots_between_turns(&acceleration, &acceleration_turns, 0.0, 1.0);
        // By the slope, not the velocity: a master at rest hides no reversal.
        let slope = self.range(&velocity, &velocity_turns, 1.0);
        let reverses = slope.minimum.value < 0.0 && slope.maximum.value > 0.0;
        let position_turns = if reverses {
            roots_between_turns(&velocity, &velocity_turns, 0.0, 1.0)
        } else {
            Roots::none()
        };

        let square = rate * rate;
        let mut effort = Effort::none(self.begin);
        effort.add(&position_turns, &acceleration_turns, |x| Sample {
            master: self.master_at(x),
            velocity: velocity.derivatives(x)[0] * rate,
            acceleration: acceleration.derivatives(x)[0] * square,
        });
        Demands {
            course: Extremes {
                position: mapped(self.range(&self.way, &position_turns, 1.0), |way| {
                    self.position + way
                }),
                velocity: mapped(slope, |slope| slope * rate),
                acceleration: self.range(&acceleration, &acceleration_turns, square),
                jerk: self.range(&jerk, &jerk_turns, square * rate),
            },
            speeding_up: effort.speeding_up,
            slowing_down: effort.slowing_down,
        }
    }

    /// The slave's whole way, forwards and backwards.
    pub(super) fn path(&self) -> f64 {
        let velocity = self.way.derivative();
        let turns = velocity.roots_in(0.0, 1.0);
        let mut from = 0.0;
        let mut path = 0.0;
        for &to in turns.iter().chain(core::iter::once(&1.0)) {
            path += (self.way.derivatives(to)[0] - self.way.derivatives(from)[0]).abs();
            from = to;
        }
        path
    }

    /// The integral over time of the squared acceleration.
    pub(super) fn squared_acceleration(&self, master_velocity: f64) -> f64 {
        let acceleration = self.way.derivative().derivative();
        let terms = &acceleration.0[..4];
        let mut integral = 0.0;
        for (i, a) in terms.iter().enumerate() {
            for (j, b) in terms.iter().enumerate() {
                integral += a * b / (i + j + 1) as f64;
            }
        }
        integral * cube(master_velocity / self.length)
    }

    /// The least and the highest product of velocity and acceleration.
    pub(super) fn dynamic_moment(&self, master_velocity: f64) -> MinMax {
        let velocity = self.way.derivative();
        let acceleration = velocity.derivative();
        let mut product = Polynomial([0.0; 8]);
        for (i, v) in velocity.0[..5].iter().enumerate() {
            for (j, a) in acceleration.0[..4].iter().enumerate() {
                product.0[i + j] += v * a;
            }
        }
        let turns = product.derivative().roots_in(0.0, 1.0);
        self.range(&product, &turns, cube(master_velocity / self.length))
    }

    /// Its law, as a segment of a cam.
    pub(super) fn law(&self) -> MotionLaw {
        if self.is_line() {
            MotionLaw::Polynom1
        } else {
            MotionLaw::Polynom5Mm
        }
    }

    pub(super) fn is_line(&self) -> bool {
        self.way.0[2..].iter().all(|&c| c == 0.0)
    }

    fn demands_of_line(&self, velocity: f64) -> Demands {
        let still = MinMax::at(self.begin, 0.0);
        let position = MinMax::at(self.begin, self.position)
            .joined(MinMax::at(self.end(), self.position + self.way.0[1]));
        Demands {
            course: Extremes {
                position,
                velocity: MinMax::at(self.begin, velocity),
                acceleration: still,
                jerk: still,
            },
            speeding_up: still.maximum,
            slowing_down: still.maximum,
        }
    }

    fn master_at(&self, x: f64) -> f64 {
        self.begin + x * self.length
    }

    /// The range of a quantity with its turns, scaled.
    fn range<const N: usize>(&self, quantity: &Polynomial<N>, turns: &[f64], scale: f64) -> MinMax {
        let at = |x: f64| MinMax::at(self.master_at(x), quantity.derivatives(x)[0] * scale);
        turns
            .iter()
            .chain(core::iter::once(&1.0))
            .fold(at(0.0), |range, &x| range.joined(at(x)))
    }
}

/// The largest values along a way, over the master's position and per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Demands {
    /// Of position, velocity, acceleration and jerk.
    pub(super) course: Extremes,
    /// The largest acceleration where the slave gets faster, as a magnitude.
    pub(super) speeding_up: Extreme,
    /// The largest acceleration where it gets slower, as a magnitude.
    pub(super) slowing_down: Extreme,
}

impl Demands {
    /// The same with other places: where time is what the way depends on, the master's positions.
    pub(super) fn with_places(self, place: impl Fn(f64) -> f64) -> Self {
        let at = |extreme: Extreme| Extreme {
            master: place(extreme.master),
            ..extreme
        };
        let both = |range: MinMax| MinMax {
            minimum: at(range.minimum),
            maximum: at(range.maximum),
        };
        let course = self.course;
        Self {
            course: Extremes {
                position: both(course.position),
                velocity: both(course.velocity),
                acceleration: both(course.acceleration),
                jerk: both(course.jerk),
            },
            speeding_up: at(self.speeding_up),
            slowing_down: at(self.slowing_down),
        }
    }

    pub(super) fn joined(self, next: Self) -> Self {
        Self {
            course: self.course.joined(next.course),
            speeding_up: larger(self.speeding_up, next.speeding_up),
            slowing_down: larger(self.slowing_down, next.slowing_down),
        }
    }
}

/// What accelerations the slave is put to, apart for either side of standstill.
struct Effort {
    speeding_up: Extreme,
    slowing_down: Extreme,
}

/// The slave at one place of its way.
struct Sample {
    master: f64,
    velocity: f64,
    acceleration: f64,
}

impl Effort {
    fn none(master: f64) -> Self {
        let nothing = Extreme { master, value: 0.0 };
        Self {
            speeding_up: nothing,
            slowing_down: nothing,
        }
    }

    /// Between two standstills the velocity keeps its sign; there, the acceleration is extreme at
    /// its turns and at the two ends.
    fn add(&mut self, standstills: &[f64], turns: &[f64], at: impl Fn(f64) -> Sample) {
        let mut from = 0.0;
        for &to in standstills.iter().chain(core::iter::once(&1.0)) {
            let direction = at(from + (to - from) / 2.0).velocity.signum();
            self.add_at(&at(from), direction);
            for &turn in turns.iter().filter(|&&turn| turn > from && turn < to) {
                self.add_at(&at(turn), direction);
            }
            self.add_at(&at(to), direction);
            from = to;
        }
    }

    fn add_at(&mut self, sample: &Sample, direction: f64) {
        let along = sample.acceleration * direction;
        let extreme = Extreme {
            master: sample.master,
            value: along.abs(),
        };
        if along > 0.0 {
            self.speeding_up = larger(self.speeding_up, extreme);
        } else {
            self.slowing_down = larger(self.slowing_down, extreme);
        }
    }
}

fn larger(first: Extreme, second: Extreme) -> Extreme {
    if second.value > first.value {
        second
    } else {
        first
    }
}

fn cube(x: f64) -> f64 {
    x * x * x
}

/// The range of a quantity that rises with this one.
fn mapped(range: MinMax, f: impl Fn(f64) -> f64) -> MinMax {
    let map = |extreme: Extreme| Extreme {
        value: f(extreme.value),
        ..extreme
    };
    MinMax {
        minimum: map(range.minimum),
        maximum: map(range.maximum),
    }
}
