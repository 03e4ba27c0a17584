//! The parts, each prepared once and then called the given number of times.

mod couplings;
mod far;
mod plans;
mod scan;

/// A part of a cycle's work.
pub(crate) struct Part {
    pub(crate) name: &'static str,
    /// Prepares the part, and calls it this number of times.
    pub(crate) run: fn(u32),
    /// Number of calls over which its cost is averaged.
    pub(crate) calls: u32,
    /// Budget of a call, instructions; none for code of others.
    pub(crate) budget: Option<f64>,
}

const fn part(name: &'static str, run: fn(u32), calls: u32, budget: f64) -> Part {
    Part {
        name,
        run,
        calls,
        budget: Some(budget),
    }
}

const fn peer(name: &'static str, run: fn(u32), calls: u32) -> Part {
    Part {
        name,
        run,
        calls,
        budget: None,
    }
}

/// The parts, in the order of the data flow.
pub(crate) const PARTS: &[Part] = &[
    part("frame of one axis accepted", far::frame, 4_000, 1_419.0),
    part("FB_TimeSync, a cycle", far::time_sync, 4_000, 241.0),
    part(
        "observer, a message",
        far::observer_messages,
        4_000,
        1_048.0,
    ),
    part("observer, a cycle", far::observer_cycles, 4_000, 682.0),
    part(
        "FB_AxisSync by the observer's clock, a cycle",
        far::axis_sync,
        4_000,
        652.0,
    ),
    part("far axis extrapolated, a cycle", far::axis_now, 4_000, 1.0),
    part("far axis shown later, a cycle", far::axis_later, 4_000, 1.0),
    part("encoder master, a cycle", far::encoder, 4_000, 665.0),
    part("guard, passing", couplings::guard, 4_000, 419.0),
    part("flying gear, a cycle", couplings::flying_gear, 4_000, 82.0),
    part("cam plate, along a path", couplings::cam, 4_000, 424.0),
    part(
        "four cam plates, at random",
        couplings::four_cams,
        4_000,
        1_600.0,
    ),
    part(
        "flying saw, P5+P1+P5 planned at a limit",
        plans::two_quintics,
        500,
        4_403.0,
    ),
    part(
        "flying saw, ramp planned from an acceleration",
        plans::ramp,
        500,
        3_485.0,
    ),
    part(
        "flying saw, time-based plan",
        plans::time_based,
        1_000,
        833.0,
    ),
    peer("the same by rsruckig", plans::rsruckig, 1_000),
    part(
        "slave, coupled by a gear, a cycle",
        couplings::slave,
        4_000,
        1_149.0,
    ),
    part(
        "slave, a move and back, a cycle",
        couplings::slave_life,
        8_000,
        948.0,
    ),
    part("whole scan, one far axis", scan::one_axis, 1_000, 8_428.0),
    part(
        "whole scan, 100 far axes, each with a slave",
        scan::hundred_axes,
        200,
        343_094.0,
    ),
];
