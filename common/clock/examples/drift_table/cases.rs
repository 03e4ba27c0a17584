//! Links, and the changes on them from [`BEGINS`] on.

use super::world::{Course, Link};

/// Beginning of the change, s, and time watched.
// Long enough for the observer to be synchronised and the delay measured, and the usual differences of slopes known.
pub(crate) const BEGINS: f64 = 15.0;
pub(crate) const WATCHED: f64 = 30.0;

const fn link(sender_us: f64, network_us: f64) -> Link {
    Link {
        sender: sender_us * 1e-6,
        network: network_us * 1e-6,
        correlated: None,
        stamps: false,
        exchanges: true,
    }
}

// Quick and wide jitter, and the three things that decide how soon a change is attributed: stamps, exchanges,
// correlation.
pub(crate) const LINKS: [(&str, Link); 6] = [
    ("1/5", link(1.0, 5.0)),
    ("5/20", link(5.0, 20.0)),
    (
        "5/20 stamped",
        Link {
            stamps: true,
            ..link(5.0, 20.0)
        },
    ),
    (
        "5/20, no exchanges",
        Link {
            exchanges: false,
            ..link(5.0, 20.0)
        },
    ),
    ("20/100", link(20.0, 100.0)),
    (
        "5/20, AR(1) 15 µs/0.3 s",
        Link {
            correlated: Some((15e-6, 0.3)),
            ..link(5.0, 20.0)
        },
    ),
];

const fn drift(drift: fn(f64) -> f64) -> Course {
    Course {
        drift,
        delay: |_| 0.0,
    }
}

const fn delay(delay: fn(f64) -> f64) -> Course {
    Course {
        drift: |_| 0.0,
        delay,
    }
}

fn since(time: f64) -> f64 {
    time - BEGINS
}

fn step(time: f64, size: f64) -> f64 {
    if time < BEGINS { 0.0 } else { size }
}

/// Triangle wave from 0 at the beginning, first upwards.
fn triangle(time: f64, amplitude: f64, period: f64) -> f64 {
    let part = (since(time).max(0.0) / period).rem_euclid(1.0);
    let height = match part {
        ..0.25 => 4.0 * part,
        0.25..0.75 => 2.0 - 4.0 * part,
        _ => 4.0 * part - 4.0,
    };
    amplitude * height
}

/// Changes to be followed: of the sender's clock.
pub(crate) const DRIFTS: [(&str, Course); 9] = [
    ("drift +20 ppm", drift(|t| step(t, 20.0))),
    ("drift −20 ppm", drift(|t| step(t, -20.0))),
    ("drift +50 ppm", drift(|t| step(t, 50.0))),
    ("drift −50 ppm", drift(|t| step(t, -50.0))),
    ("drift +200 ppm", drift(|t| step(t, 200.0))),
    ("drift −200 ppm", drift(|t| step(t, -200.0))),
    ("drift +500 ppm", drift(|t| step(t, 500.0))),
    ("drift −500 ppm", drift(|t| step(t, -500.0))),
    (
        "drift +100 ppm/s for 3 s",
        drift(|t| 100.0 * since(t).clamp(0.0, 3.0)),
    ),
];

/// Changes not to be followed: of the path.
// Slopes of 25 to 500 ppm: what a drift would look like for as long as they last.
pub(crate) const DELAYS: [(&str, Course); 6] = [
    (
        "delay +200 µs in 0.5 s",
        delay(|t| 400e-6 * since(t).clamp(0.0, 0.5)),
    ),
    (
        "delay +1 ms in 2 s",
        delay(|t| 500e-6 * since(t).clamp(0.0, 2.0)),
    ),
    (
        "delay +1 ms in 20 s",
        delay(|t| 50e-6 * since(t).clamp(0.0, 20.0)),
    ),
    (
        "delay ±50 µs every 3 s",
        delay(|t| step(t, 50e-6) + triangle(t, 50e-6, 3.0)),
    ),
    (
        "delay ±50 µs, sine of 30 s",
        delay(|t| 50e-6 * f64::sin(since(t).max(0.0) * std::f64::consts::TAU / 30.0)),
    ),
    (
        "delay ±200 µs every 3 s",
        delay(|t| step(t, 200e-6) + triangle(t, 200e-6, 3.0)),
    ),
];
