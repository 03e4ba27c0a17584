//! A far axis at the end: it follows, and at rest it is where its master is.

use coaxle_curve::profile::Limits;
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals};
use coaxle_receiver::{ContinuityState, FilterState, ReceiverConfig};

use super::rough::RoughMaster;
use super::tolerance;
use super::way::{self, HALF, Way};
use crate::row::Row;
use crate::topology::{ReceiverAxis, View};

/// Largest slope and curvature of the curve by which an axis is brought back, 15/8 and 10/√3 (`continuity::rejoin`), …
const STEEPEST: f64 = 1.875;
const MOST_CURVED: f64 = 5.774;
/// … its velocity relative to its master, of the greatest velocity of that, …
const FASTER: f64 = 0.5;
/// … and its least acceleration, of that velocity: 1.5·v within 0.5 s.
const PULL: f64 = 3.0;
/// Part of its master's greatest velocity below which that at the planning may not be.
const OUTGROWN: f64 = 0.5;
/// Longest way back to a master that has not moved, s.
const TO_A_RESTING_MASTER: f64 = 30.0;
/// Shortest way back, s: the blending time at most, as orders change it.
const SHORTEST: f64 = 0.6;
/// Time after which an axis without a clock is at a master at rest, s: far longer than a filter of some cycles takes.
const SETTLED: f64 = 5.0;

/// Watches a far axis.
#[derive(Debug)]
pub(super) struct AxisLiveness {
    pub(super) name: String,
    limits: Option<Limits>,
    /// Runs and restarts that begin another way back.
    events: [u64; 7],
    /// Greatest velocity of its master in this run of the receiver, u/s.
    fastest: f64,
    back: Option<Way>,
    /// Greatest velocity of its master when its way back was planned, u/s.
    planned: f64,
    /// Time at which it was last without sync, or not following, s.
    uneven: Option<f64>,
    /// Time since which its master is at rest, s.
    rest_since: Option<f64>,
    /// The part of its master's motion that is beyond its limits; none without limits.
    rough: Option<RoughMaster>,
    last: Option<(f64, FarAxisSignals)>,
}

impl AxisLiveness {
    /// Absent for the receiver's own axes.
    pub(super) fn new(config: &ReceiverConfig, view: &View) -> Option<Self> {
        let ReceiverAxis::Far { axis, .. } = view.of else {
            return None;
        };
        let limits = config.far_axes().nth(axis)?.2.limits;
        Some(Self {
            name: config.far_axis_names().into_iter().nth(axis)?,
            limits: limits.map(|limits| *limits.get()),
            events: [0; 7],
            fastest: 0.0,
            back: None,
            planned: 0.0,
            uneven: None,
            rest_since: None,
            rough: limits.map(|limits| RoughMaster::new(*limits.get())),
            last: None,
        })
    }

    pub(super) fn push(&mut self, row: &Row) {
        let (t_s, record) = (row.t_s, &row.record);
        let axis = &record.axis;
        let events = events_of(record.node.run, record.place, &record.far);
        if events[0] != self.events[0] {
            (self.fastest, self.planned) = (0.0, 0.0);
        }
        let is_another = std::mem::replace(&mut self.events, events) != events;
        self.last = Some((t_s, *axis));
        if !axis.synced || axis.continuity != ContinuityState::Following || is_another {
            self.uneven = Some(t_s);
        }
        let (Some(received), Some(velocity)) = (axis.received_position, axis.received_velocity)
        else {
            self.rest_since = None;
            return;
        };
        if let Some(rough) = &mut self.rough {
            rough.push(t_s, record.far.count, axis, is_another);
        }
        self.fastest = self.fastest.max(velocity.abs());
        let is_resting = velocity == 0.0 && !is_another;
        self.rest_since = is_resting.then(|| self.rest_since.unwrap_or(t_s));
        if axis.continuity != ContinuityState::Rejoining {
            self.back = None;
            return;
        }
        let distance = (axis.corrected_position.unwrap_or(received) - received).abs();
        // Until its master is slow enough for its own limits it may fall behind.
        let is_too_fast =
            (self.limits).is_some_and(|limits| velocity.abs() > HALF * limits.velocity());
        // A plan is made again once its master is more than twice as fast: swarm schedule 3088 began it with a master that had hardly moved.
        let is_outgrown = self.planned < OUTGROWN * self.fastest;
        match &mut self.back {
            Some(back) if !(is_another || is_too_fast || is_outgrown) => back.note(distance),
            back => {
                *back = Some(Way::new(t_s, distance));
                self.planned = self.fastest;
            }
        }
    }

    /// Longest time of its way back, s.
    fn longest(&self, back: &Way) -> f64 {
        // The position received is as old as the message: half a second of travel covers every delay.
        let way = back.distance + 0.5 * self.fastest;
        let by_plan = match self.planned > 0.0 {
            true => {
                let for_velocity = STEEPEST * way / (FASTER * self.planned);
                let for_acceleration = (MOST_CURVED * way / (PULL * self.planned)).sqrt();
                for_velocity.max(for_acceleration)
            }
            false => TO_A_RESTING_MASTER,
        };
        let by_limits = self.limits.map_or(0.0, |limits| way::within(&limits, way));
        SHORTEST + by_plan + by_limits
    }

    /// True if its set values move as evenly as its master: it follows by a clock, and not by what comes, for some seconds.
    pub(super) fn is_even(&self) -> bool {
        let is_settled = |t_s: f64| self.uneven.is_none_or(|at| t_s - at > SETTLED);
        !self.shows_beats() && self.last.as_ref().is_some_and(|(t_s, _)| is_settled(*t_s))
    }

    /// True if its set values are shown as they come, with their beats.
    pub(super) fn shows_beats(&self) -> bool {
        let state = self.last.as_ref().and_then(|(_, axis)| axis.state);
        matches!(state, Some(FilterState::Bypass | FilterState::Pt1) | None)
    }

    /// Fault at the end, if any.
    pub(super) fn broken(&self) -> Option<String> {
        let Some((t_s, axis)) = &self.last else {
            return Some("had no cycle".to_owned());
        };
        // A master in error says so, and is not followed.
        if axis.received_error != 0 {
            return None;
        }
        match (axis.continuity, &self.back) {
            (ContinuityState::Braking, _) => Some("has no master at the end".to_owned()),
            (ContinuityState::Rejoining, Some(_))
                if self.rough.is_some_and(|rough| rough.is_beside(*t_s, axis)) =>
            {
                None
            }
            (ContinuityState::Rejoining, Some(back)) => {
                let (had, longest) = (t_s - back.since, self.longest(back));
                (had > longest).then(|| {
                    format!(
                        "is not back at the end: {:.3} u away at {:.3} s, it takes {longest:.3} s at most, and had {had:.3} s",
                        back.distance, back.since
                    )
                })
            }
            _ => self.beside_resting_master(*t_s, axis),
        }
    }

    fn beside_resting_master(&self, t_s: f64, axis: &FarAxisSignals) -> Option<String> {
        let rest = self.rest_since.filter(|since| t_s - since > SETTLED)?;
        let (corrected, received) = (axis.corrected_position?, axis.received_position?);
        let distance = (corrected - received).abs();
        (distance > tolerance(received)).then(|| {
            format!(
                "is not where its master is: {distance:.6} u away at the end, and the master rests since {rest:.3} s"
            )
        })
    }
}

/// Events that begin another way back: another run of the receiver or of the node, another node, a restart of the clock.
fn events_of(run: u64, place: usize, far: &FarNodeSignals) -> [u64; 7] {
    [
        run,
        place as u64,
        far.epoch.unwrap_or_default(),
        far.restarts,
        far.take_overs,
        far.relocks.into(),
        far.re_initialisations.into(),
    ]
}
