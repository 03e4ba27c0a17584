//! True motion of an axis: pieces of constant jerk, and a ripple on top.

use std::f64::consts::TAU;

use coaxle_curve::profile::Kinematics;

/// A motion that began at rest.
#[derive(Clone, Debug)]
pub struct Motion {
    pieces: Vec<Piece>,
    end: f64,
    ripple: Option<Ripple>,
}

#[derive(Clone, Copy, Debug)]
struct Piece {
    from: f64,
    state: Kinematics,
    jerk: f64,
}

/// A part of the speed that oscillates.
#[derive(Clone, Copy, Debug)]
struct Ripple {
    from: f64,
    speed: f64,
    frequency: f64,
}

/// Time over which the ripple grows, s.
pub const RIPPLE_GROWS: f64 = 0.5;

impl Motion {
    pub fn at_rest(position: f64) -> Self {
        Self {
            pieces: vec![Piece {
                from: 0.0,
                state: Kinematics::at_rest(position),
                jerk: 0.0,
            }],
            end: 0.0,
            ripple: None,
        }
    }

    /// Length, s.
    pub const fn end(&self) -> f64 {
        self.end
    }

    /// Keeps its state for a time.
    #[must_use]
    pub fn hold(self, seconds: f64) -> Self {
        self.piece(seconds, 0.0)
    }

    /// Changes to another velocity with limits of acceleration and jerk.
    #[must_use]
    pub fn to(self, velocity: f64, acceleration: f64, jerk: f64) -> Self {
        let way = velocity - self.at_end().velocity;
        // Without a phase of constant acceleration the change is v = j·t² in two halves of t = √(v/j).
        let by_jerk = (acceleration / jerk).min((way.abs() / jerk).sqrt());
        let held = way.abs() / (by_jerk * jerk) - by_jerk;
        let jerk = jerk.copysign(way);
        let mut done = self
            .piece(by_jerk, jerk)
            .piece(held.max(0.0), 0.0)
            .piece(by_jerk, -jerk);
        done.settle(velocity);
        done
    }

    /// From now on its speed oscillates with this amplitude and this frequency in Hz.
    #[must_use]
    pub const fn swing(mut self, speed: f64, frequency: f64) -> Self {
        self.ripple = Some(Ripple {
            from: self.end,
            speed,
            frequency,
        });
        self
    }

    pub fn at(&self, time: f64) -> Kinematics {
        let next = self.pieces.partition_point(|piece| piece.from <= time);
        // The jitter of a sample may lie before the first piece, which continues backwards then.
        let piece = &self.pieces[next.max(1) - 1];
        let plain = after(&piece.state, time - piece.from, piece.jerk);
        let Some(ripple) = &self.ripple else {
            return plain;
        };
        let (position, velocity) = ripple.at(time);
        Kinematics {
            position: plain.position + position,
            velocity: plain.velocity + velocity,
            ..plain
        }
    }

    fn at_end(&self) -> Kinematics {
        let last = &self.pieces[self.pieces.len() - 1];
        after(&last.state, self.end - last.from, last.jerk)
    }

    fn piece(mut self, seconds: f64, jerk: f64) -> Self {
        let state = self.at_end();
        self.pieces.push(Piece {
            from: self.end,
            state,
            jerk,
        });
        self.end += seconds;
        self
    }

    /// Clears the rounding residues of acceleration and velocity, which would add up.
    fn settle(&mut self, velocity: f64) {
        let state = Kinematics {
            velocity,
            acceleration: 0.0,
            ..self.at_end()
        };
        self.pieces.push(Piece {
            from: self.end,
            state,
            jerk: 0.0,
        });
    }
}

impl Ripple {
    fn at(&self, time: f64) -> (f64, f64) {
        let t = time - self.from;
        if t <= 0.0 {
            return (0.0, 0.0);
        }
        let s = (t / RIPPLE_GROWS).min(1.0);
        // Quintic from 0 to 1 with a velocity and an acceleration of 0 at both ends: 10s³ - 15s⁴ + 6s⁵.
        let grown = s * s * s * (10.0 - s * (15.0 - 6.0 * s));
        let growth = 30.0 * s * s * (1.0 - s) * (1.0 - s) / RIPPLE_GROWS;
        let w = TAU * self.frequency;
        let (sine, cosine) = (w * t).sin_cos();
        // An amplitude of the speed is one of the position over ω.
        let way = self.speed / w;
        (
            way * grown * sine,
            way * (growth * sine + grown * w * cosine),
        )
    }
}

fn after(state: &Kinematics, t: f64, jerk: f64) -> Kinematics {
    let Kinematics {
        position,
        velocity,
        acceleration,
    } = *state;
    Kinematics {
        position: position + t * (velocity + t * (acceleration / 2.0 + t * jerk / 6.0)),
        velocity: velocity + t * (acceleration + t * jerk / 2.0),
        acceleration: acceleration + t * jerk,
    }
}
