//! Motions of the masters of a swarm schedule.

use std::fmt::Write as _;

use super::super::draw::Draw as _;
use super::SwarmSchedule;
use super::features::Feature;

/// Longest time of a program until its last motion is steady, s: [`MOST_STEPS`] steps of [`STEP`], and five ramps from one direction to
/// the other.
// 2·v/a + a/j is at most 2 · 500/500 + 0.2 = 2.2 s: 4 · 1 s + 5 · 2.2 s.
pub(super) const PROGRAM: f64 = 15.0;
const MOST_STEPS: u64 = 4;
const STEP: f64 = 1.0;

/// Highest velocity at the end, of the highest velocity of all masters: less than half of the least limit, which is 0.6 of it.
// A slave at the least limit makes up its distance with 0.35 of the highest velocity.
const SLOW: f64 = 0.25;
/// The same where slaves of two masters are followed: each of up to four links between five receivers may double the velocity.
const SLOW_OF_SUMS: f64 = SLOW / 16.0;

impl SwarmSchedule {
    /// Writes a program that ends: at rest, or in a slow and steady motion.
    pub(super) fn motion(&mut self) {
        let (speed, [acceleration, jerk]) = (self.speed, self.dynamics);
        let random = &mut self.base.random;
        let mut text = String::new();
        if self.features.has(Feature::Modulo) || self.features.has(Feature::WithinTurn) {
            text += "modulo = 360\n";
        }
        let _ = write!(
            text,
            "program.start-position = {:.2}\nprogram.start-velocity = {:.2}\n\
             program.limits = {{ velocity = {speed:.2}, acceleration = {acceleration:.1}, jerk = {jerk:.1} }}\n\
             program.steps = [\n  {{ enable = true }},\n",
            random.between(-500.0, 500.0),
            random.between(-speed, speed),
        );
        for _ in 0..random.whole(0, MOST_STEPS) {
            let step = match random.below(4) {
                0 => {
                    // At most the way of a step at the highest velocity.
                    let way = STEP * random.between(-speed, speed);
                    format!("{{ move-relative = {{ distance = {way:.2} }} }}")
                }
                1 => format!(
                    "{{ dwell = {{ for-s = {:.3} }} }}",
                    random.between(0.01, STEP)
                ),
                _ => format!(
                    "{{ velocity = {{ value = {:.2}, for-s = {:.3} }} }}",
                    random.between(-speed, speed),
                    random.decades(0.05, STEP)
                ),
            };
            let _ = writeln!(text, "  {step},");
        }
        let slow = match self.features.has(Feature::Chain) && self.features.has(Feature::TwoMasters)
        {
            true => SLOW_OF_SUMS,
            false => SLOW,
        };
        let last = match random.chance(0.3) {
            true => "{ halt = {} }".to_owned(),
            false => format!(
                "{{ velocity = {{ value = {:.3} }} }}",
                random.one_of(&[-1.0, 1.0]) * random.decades(0.01, slow / SLOW) * SLOW * speed
            ),
        };
        let _ = write!(text, "  {last},\n]\n");
        self.base.text += &text;
    }
}
