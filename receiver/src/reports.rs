//! Reports to the nodes that it follows: how its slaves of each of their axes are.

use coaxle_clock::cycle::Tick;
use coaxle_clock::{Instant, Local, Span};
use coaxle_curve::profile::Limits;
use coaxle_node::followers::{MAX_REPORTS, REPORTS_CAPACITY, encode_reports};
use coaxle_node::frame::sender_id;
use coaxle_node::{Channel, FollowerReport, FollowerState, Outgoing, PresentAfter, RunCycle};

use crate::config::{FarChannel, ReceiverConfig};
use crate::far::FarNode;
use crate::slaves::{Master, Slaves, SlavesOfAxis};

/// Time between two reports without a change: a node that has missed one waits no longer for the next.
const PERIOD: Span = Span::from_millis(50);

/// Publisher of the reports.
#[derive(Debug)]
pub(crate) struct ReportPublisher {
    header: RunCycle,
    /// Axes of senders that it follows, in the order in which they have a turn.
    axes: Box<[ReportedAxis]>,
    /// The next one.
    turn: usize,
    /// A place for each far axis, and for each slave.
    counts: Box<[SlavesOfAxis]>,
    limits: Box<[Limits]>,
    limits_of_slaves: Box<[Limits]>,
    message: Vec<FollowerReport>,
    body: Box<[u8; REPORTS_CAPACITY]>,
    /// Length of the pending body.
    waiting: Option<usize>,
    is_subscribed: bool,
}

/// A far axis.
#[derive(Debug)]
struct ReportedAxis {
    /// Number among all far axes.
    axis: usize,
    /// Number of its far node, and the ids of that node and of its standbys.
    far: usize,
    nodes: Box<[u32]>,
    id: u32,
    /// Time of the next report.
    due: Option<Instant<Local>>,
    /// Last report: the followed node, its run, and the slaves.
    reported: Option<(u32, u64, SlavesOfAxis)>,
}

/// Subject of the reports.
pub(crate) struct Reported<'a> {
    pub(crate) far: &'a [FarNode],
    pub(crate) masters: &'a [Option<Master>],
    pub(crate) slaves: &'a Slaves,
}

impl ReportPublisher {
    /// Creates the publisher; none for a node without a slave of a sender's axis.
    pub(crate) fn new(config: &ReceiverConfig, run: u64) -> Option<Self> {
        if !config.reports() {
            return None;
        }
        let axes: Box<[_]> = config
            .far_axes()
            .enumerate()
            .filter(|(_, (_, far, _))| far.channel == FarChannel::Axes)
            .map(|(number, (far, config, axis))| ReportedAxis {
                axis: number,
                far,
                nodes: config.nodes().map(sender_id).collect(),
                id: axis.id,
                due: None,
                reported: None,
            })
            .collect();
        let far = config.far_axes().count();
        Some(Self {
            header: RunCycle {
                sender: sender_id(&config.name),
                epoch: run,
                count: 0,
            },
            axes,
            turn: 0,
            counts: vec![SlavesOfAxis::default(); far].into(),
            limits: vec![Limits::NONE; far].into(),
            limits_of_slaves: vec![Limits::NONE; config.slaves.len()].into(),
            // Sized once, because the cycle must not allocate.
            message: Vec::with_capacity(MAX_REPORTS),
            body: Box::new([0; REPORTS_CAPACITY]),
            waiting: None,
            // Until the host knows better, as for frames.
            is_subscribed: true,
        })
    }

    pub(crate) const fn set_subscribed(&mut self, is_subscribed: bool) {
        self.is_subscribed = is_subscribed;
    }

    /// Encodes the reports that are due in a cycle: what has changed, and the rest in turn.
    pub(crate) fn encode(&mut self, tick: &Tick, reported: &Reported<'_>) {
        self.waiting = None;
        if !self.is_subscribed {
            return;
        }
        reported
            .slaves
            .count_followers(reported.masters, &mut self.counts);
        self.message.clear();
        let mut are_limits_known = false;
        // One message a cycle bounds its work: many axes take turns.
        for _ in 0..self.axes.len() {
            if self.message.len() == MAX_REPORTS {
                break;
            }
            let turn = self.turn;
            self.turn = (turn + 1) % self.axes.len();
            let axis = &mut self.axes[turn];
            let Some((place, run)) = reported.far[axis.far].followed_run() else {
                continue;
            };
            let now = (axis.nodes[place], run, self.counts[axis.axis]);
            if !axis.is_due(tick.ideal_start, &now) {
                continue;
            }
            // Only now, and once: they take longer than all the rest.
            if !std::mem::replace(&mut are_limits_known, true) {
                let (slaves, far) = (&mut self.limits_of_slaves, &mut self.limits);
                reported.slaves.limits_of_far_axes(slaves, far);
            }
            axis.due = Some(tick.ideal_start + PERIOD);
            axis.reported = Some(now);
            let wanted_delay = reported.far[axis.far].wanted_delay();
            self.message.push(FollowerReport {
                node: now.0,
                run,
                axis_id: axis.id,
                state: now.2.state(self.limits[axis.axis], wanted_delay),
            });
        }
        self.header.count = tick.count;
        self.waiting = (!self.message.is_empty())
            .then(|| encode_reports(&self.header, &self.message, &mut self.body));
    }

    /// Takes the pending message, once.
    pub(crate) fn transmit(&mut self, ideal_start: Instant<Local>) -> Option<Outgoing<'_>> {
        let length = self.waiting.take()?;
        Some(Outgoing {
            channel: Channel::Followers,
            far: 0,
            ideal_start,
            body: &self.body[..length],
        })
    }
}

impl ReportedAxis {
    /// True if its time has come, or another state.
    fn is_due(&self, now: Instant<Local>, state: &(u32, u64, SlavesOfAxis)) -> bool {
        let is_late = self.due.is_none_or(|due| now >= due);
        let is_same = |(node, run, counts): &(u32, u64, SlavesOfAxis)| {
            // A distance changes with every cycle.
            (*node, *run) == (state.0, state.1) && counts.is_alike(&state.2)
        };
        is_late || !self.reported.as_ref().is_some_and(is_same)
    }
}

impl SlavesOfAxis {
    fn state(&self, limits: Limits, wanted_delay: Option<Span>) -> FollowerState {
        FollowerState {
            slaves: self.slaves,
            in_sync: self.in_sync,
            in_error: self.in_error,
            distance: self.distance,
            limits,
            wanted_delay: wanted_delay.and_then(PresentAfter::new),
        }
    }
}
