//! Reports of followers on the wire: `docs/WIRE.md` describes every byte.
//!
//! A node reports for each axis that it follows how its slaves of that axis are. The node of the axis waits for them, stops
//! with them, and keeps within what they can do.

use coaxle_clock::Span;
use coaxle_curve::profile::Limits;
use serde::{Deserialize, Serialize};

use crate::channel::Channel;
use crate::frame::{KeySeal, read, read_send_stamp, sender_id, write};
use crate::keys::NodeName;
use crate::message::{FollowerState, Message, ReceivedReport};
use crate::present_after::PresentAfter;
use crate::rejection::Rejection;
use crate::run_cycle::{ListPrefix, RunCycle};

/// Greatest number of reports in one message.
pub const MAX_REPORTS: usize = 16;

/// A buffer of this many bytes holds the body of every message of reports.
pub const REPORTS_CAPACITY: usize = 1 + 5 + 10 + 10 + 1 + MAX_REPORTS * MAX_REPORT_LEN;

/// Node, run, axis id, three numbers of slaves, distance, four limits, a delay.
const MAX_REPORT_LEN: usize = 5 + 10 + 5 + 3 * 3 + 8 + 4 * 8 + 5;

/// Report about one axis of another node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowerReport {
    /// Followed node: the CRC-32 of its name.
    pub node: u32,
    /// Run of the followed node.
    pub run: u64,
    /// Id of the axis there.
    pub axis_id: u32,
    /// State of its slaves.
    pub state: FollowerState,
}

/// Writes a message of reports up to its send stamp into `out` and returns its length. Of more than [`MAX_REPORTS`] the
/// first are taken. Does not allocate.
pub fn encode_reports(
    header: &RunCycle,
    reports: &[FollowerReport],
    out: &mut [u8; REPORTS_CAPACITY],
) -> usize {
    const ROOM: &str = "the buffer holds the longest reports";
    let reports = &reports[..reports.len().min(MAX_REPORTS)];
    let mut used = write(&ListPrefix::of(header, reports.len()), out).expect(ROOM);
    for report in reports {
        used += write(&ReportBody::from(report), &mut out[used..]).expect(ROOM);
    }
    used
}

impl KeySeal {
    /// Checks a message of reports and passes them on one after the other. Does not allocate.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies. Nothing is handed out then.
    pub fn open_reports(
        &self,
        payload: &[u8],
        mut each: impl FnMut(&FollowerReport),
    ) -> Result<RunCycle, Rejection> {
        let (_, content) = self.verified_reports(payload)?;
        read_reports(content, &mut each)
    }

    /// Reads a message to its end, before anything of it is handed out.
    fn verified_reports<'a>(&self, payload: &'a [u8]) -> Result<(RunCycle, &'a [u8]), Rejection> {
        let content = self.verify(payload, |content| read_reports(content, |_| {}).map(drop))?;
        Ok((read_reports(content, |_| {})?, content))
    }
}

/// Takes the reports about the axes of this node out of the messages of one follower.
#[derive(Clone, Debug)]
pub struct ReportIntake {
    seal: KeySeal,
    follower: u32,
    node: u32,
}

impl ReportIntake {
    /// Takes what `follower` reports about `node`.
    #[must_use]
    pub fn new(follower: &NodeName, node: &NodeName) -> Self {
        Self {
            seal: KeySeal::new(&follower.channel_key(Channel::Followers)),
            follower: sender_id(follower),
            node: sender_id(node),
        }
    }

    /// Passes on the reports about this node. Does not allocate.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies. Nothing is handed out then.
    pub(crate) fn read(
        &self,
        payload: &[u8],
        mut each: impl FnMut(&Message<'_>),
    ) -> Result<(), Rejection> {
        let (header, content) = self.seal.verified_reports(payload)?;
        let RunCycle {
            sender,
            epoch,
            count,
        } = header;
        if sender != self.follower {
            return Err(Rejection::ForeignSender);
        }
        read_reports(content, |report| {
            if report.node == self.node {
                each(&Message::FollowerReport(ReceivedReport {
                    epoch,
                    count,
                    run: report.run,
                    axis_id: report.axis_id,
                    state: report.state,
                }));
            }
        })
        .map(drop)
    }
}

/// Reads a message to its end.
fn read_reports(
    content: &[u8],
    mut each: impl FnMut(&FollowerReport),
) -> Result<RunCycle, Rejection> {
    let (header, count, mut rest) = ListPrefix::read(content, MAX_REPORTS)?;
    for _ in 0..count {
        let body;
        (body, rest) = read::<ReportBody>(rest)?;
        each(&body.report()?);
    }
    read_send_stamp(rest)?;
    Ok(header)
}

#[derive(Serialize, Deserialize)]
struct ReportBody {
    node: u32,
    run: u64,
    axis_id: u32,
    state: StateBody,
}

/// State of followers, in a message and in a recorded scan.
#[derive(Serialize, Deserialize)]
pub(crate) struct StateBody {
    slaves: u16,
    in_sync: u16,
    in_error: u16,
    distance: f64,
    velocity: f64,
    acceleration: f64,
    deceleration: f64,
    jerk: f64,
    /// 0: unknown, or of no interest.
    wanted_delay_ns: u32,
}

impl From<&FollowerReport> for ReportBody {
    fn from(report: &FollowerReport) -> Self {
        Self {
            node: report.node,
            run: report.run,
            axis_id: report.axis_id,
            state: StateBody::from(&report.state),
        }
    }
}

impl ReportBody {
    fn report(&self) -> Result<FollowerReport, Rejection> {
        Ok(FollowerReport {
            node: self.node,
            run: self.run,
            axis_id: self.axis_id,
            state: self.state.checked()?,
        })
    }
}

impl From<&FollowerState> for StateBody {
    fn from(state: &FollowerState) -> Self {
        Self {
            slaves: state.slaves,
            in_sync: state.in_sync,
            in_error: state.in_error,
            distance: state.distance,
            velocity: state.limits.velocity(),
            acceleration: state.limits.acceleration(),
            deceleration: state.limits.deceleration(),
            jerk: state.limits.jerk(),
            wanted_delay_ns: state.wanted_delay.map_or(0, PresentAfter::nanos),
        }
    }
}

impl StateBody {
    /// # Errors
    /// [`Rejection::Implausible`]: more slaves in sync or in error than there are, a number that is none, or a delay beyond
    /// [`PresentAfter::LONGEST`].
    pub(crate) fn checked(&self) -> Result<FollowerState, Rejection> {
        let Self {
            slaves,
            in_sync,
            in_error,
            distance,
            velocity,
            acceleration,
            deceleration,
            jerk,
            wanted_delay_ns,
        } = *self;
        let wanted_delay = PresentAfter::new(Span::from_nanos(wanted_delay_ns.into()));
        let is_delay = wanted_delay.is_some() || wanted_delay_ns == 0;
        let limits = Limits::new(velocity, acceleration, deceleration, jerk);
        let adds_up = u32::from(in_sync) + u32::from(in_error) <= u32::from(slaves);
        let is_distance = distance.is_finite() && distance >= 0.0;
        match limits {
            Ok(limits) if adds_up && is_distance && is_delay => Ok(FollowerState {
                slaves,
                in_sync,
                in_error,
                distance,
                limits,
                wanted_delay,
            }),
            _ => Err(Rejection::Implausible),
        }
    }
}
