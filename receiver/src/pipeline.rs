//! The data flow: far axes and virtual axes in, set values of the slaves out. One scan, top to bottom.

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::cycle::Tick;
use coaxle_clock::{Seconds, Span};
use coaxle_node::Channel;
use coaxle_node::circles::{CircleChange, CircleState};
use coaxle_node::config::Wrong;

use crate::arrivals::ArrivalLog;
use crate::config::ReceiverConfig;
use crate::far::{Candidate, FarNode, FarOutputs, HeldNow, OwnNode};
use crate::far_axes::PublishedFarAxes;
use crate::health::Health;
use crate::hold_back::{HoldBack, Spare};
use crate::promised::PromisedMotion;
use crate::reports::Reported;
use crate::slaves::{Master, Slaves};
use crate::snapshot::ReceiverSnapshot;
use crate::virtual_axes::VirtualAxes;

/// Processing between the mailboxes and the drives.
#[derive(Debug)]
pub(crate) struct Pipeline {
    cycle_s: f64,
    pub(crate) far: Box<[FarNode]>,
    /// Far node of each node received from, and its place there: the far node itself or a standby.
    received_from: Box<[(usize, usize)]>,
    /// First axis of each far node among all axes, and one past its last.
    ranges: Box<[(usize, usize)]>,
    /// Every far axis as a master.
    masters: Box<[Option<Master>]>,
    pub(crate) virtual_axes: VirtualAxes,
    pub(crate) slaves: Slaves,
    hold_back: HoldBack,
    /// True for each far axis that leads a slave or is published: only these have a say about the hold-back.
    counts: Box<[bool]>,
    /// What the virtual axes leave of the time by which they are shown later.
    virtual_spare: Spare,
    far_axes: PublishedFarAxes,
    /// True for each published far axis that is in a circle across nodes.
    far_axes_in_circles: Box<[bool]>,
    /// Measurements of the newest cycle.
    pub(crate) arrivals: ArrivalLog,
}

impl Pipeline {
    /// Creates the pipeline; `run` is the epoch of this run.
    pub(crate) fn new(
        config: &ReceiverConfig,
        virtual_axes: VirtualAxes,
        slaves: Slaves,
        run: u64,
    ) -> Result<Self, Wrong> {
        let cycle_time = config.cycle_time_us.0;
        let own = OwnNode {
            cycle_time,
            run,
            takes_common_time: config.time.is_some(),
        };
        let nodes = config.received_nodes().into_iter();
        let received_from: Box<[_]> = nodes.map(|node| (node.far, node.place)).collect();
        let far = (config.far.iter().enumerate())
            .map(|(n, far)| {
                let numbers = config.numbers_of(n);
                let field = || match config.far.len() {
                    1 => "sync".to_owned(),
                    _ => format!("far[{n}].sync"),
                };
                FarNode::new(far, own, &numbers)
                    .map(|node| node.with_dead_time(config.longest_dead_time()))
                    .map_err(|error| Wrong::with_reason(field(), error))
            })
            .collect::<Result<_, _>>()?;
        let range = |n| {
            let first = config.first_axis_of(n);
            (first, first + config.far[n].axes.count())
        };
        Ok(Self {
            cycle_s: cycle_time.as_secs_f64(),
            far,
            ranges: (0..config.far.len()).map(range).collect(),
            masters: config.far_axes().map(|_| None).collect(),
            virtual_axes,
            slaves,
            hold_back: HoldBack::new(
                cycle_time.span(),
                config.may_hold_back(),
                !config.published_far_axes().is_empty(),
            ),
            counts: config.far_axes_that_lead().into(),
            virtual_spare: config.virtual_spare(),
            far_axes: PublishedFarAxes::new(config),
            far_axes_in_circles: config.published_far_axes().iter().map(|_| false).collect(),
            arrivals: ArrivalLog::new(received_from.len()),
            received_from,
        })
    }

    /// The node with this number among those received from.
    pub(crate) fn received_from(&mut self, number: usize) -> &mut Candidate {
        // The host numbers all nodes in a row, the pipeline by far node and standby.
        let (far, place) = self.received_from[number];
        self.far[far].node(place)
    }

    /// Runs one scan.
    pub(crate) fn scan(&mut self, tick: &Tick, shown: &mut ReceiverSnapshot) {
        self.arrivals.begin();
        // Skipped cycles count: set values go by the ideal time and not by the number of scans.
        let elapsed = Seconds(self.cycle_s * f64::from(tick.elapsed));
        // Before the masters, which it places.
        self.lead_hold_back(elapsed);
        // Masters before slaves, which read both kinds of axes as they are in this cycle.
        for n in 0..self.far.len() {
            self.far_node(n, tick, shown);
        }
        let virtual_axes = &mut shown.signals.virtual_axes;
        let hold_back = self.hold_back.by();
        let virtual_axes = (self.virtual_axes).cycle(tick.ideal_start, hold_back, virtual_axes);
        let (far, ranges) = (&self.far, &self.ranges);
        let promised = |axis| promised(far, ranges, axis);
        (self.slaves).update(&self.masters, virtual_axes, promised, hold_back, elapsed);
        self.slaves.show(shown);
        // Last, because it depends on all of the others.
        shown.health = self.health(shown);
        shown.signals.node.health = shown.health.name();
    }

    /// The hold-back of the newest cycle.
    pub(crate) const fn hold_back(&self) -> Span {
        self.hold_back.by()
    }

    /// Leads the hold-back to what all axes leave, as they were in the cycle before.
    fn lead_hold_back(&mut self, elapsed: Seconds) {
        if !self.hold_back.is_possible() {
            return;
        }
        let of = |far: &FarNode, (first, end): (usize, usize)| far.spare(&self.counts[first..end]);
        let far = self.far.iter().zip(&self.ranges);
        let spare = far
            .map(|(far, range)| of(far, *range))
            .fold(self.virtual_spare, Spare::and);
        let slaves = &self.slaves;
        (self.hold_back).advance(elapsed.to_span(), spare, || slaves.rest());
    }

    /// Processes a far node: the node and run followed, its clock, its axes.
    fn far_node(&mut self, n: usize, tick: &Tick, shown: &mut ReceiverSnapshot) {
        let (first, end) = self.ranges[n];
        let signals = &mut shown.signals;
        let outputs = FarOutputs {
            masters: &mut self.masters[first..end],
            axes: &mut signals.axes[first..end],
            nodes: &mut signals.far,
            health: &mut shown.far_health,
            data_cycle_times: &mut shown.data_cycle_times,
        };
        let held = HeldNow {
            by: self.hold_back.by(),
            is_decided: self.hold_back.is_decided(),
        };
        self.far[n].scan(tick, held, &mut self.arrivals, outputs);
    }

    /// Takes the circle across nodes that an axis is in.
    pub(crate) fn set_circle(&mut self, CircleChange { channel, id, state }: CircleChange) {
        match channel {
            Channel::Slaves => self.slaves.set_circle(id, state),
            // The axes' ids are their places, from 1.
            Channel::FarAxes => {
                // An id of 0 wraps to a place that does not exist.
                let place = (id as usize).wrapping_sub(1);
                if let Some(is_in_circle) = self.far_axes_in_circles.get_mut(place) {
                    *is_in_circle = state != CircleState::None;
                }
            }
            // Other channels have no axes that follow any.
            _ => {}
        }
    }

    /// Worst health. A slave's fault comes first, because it stays; then a circle across nodes,
    /// then the worst of the far nodes, then a slave that is behind, which is often a consequence
    /// of a far node's fault.
    fn health(&self, shown: &ReceiverSnapshot) -> Health {
        let worst = || {
            // The standbys behind them are part of the health of their far node.
            shown.far_health[..self.far.len()]
                .iter()
                .copied()
                // Without far nodes there is none, and all is well as far as they go.
                .max_by_key(Health::severity)
        };
        let is_in_circle = self.far_axes_in_circles.contains(&true);
        let circle = || is_in_circle.then_some(Health::Circle);
        match self
            .slaves
            .fault()
            .or_else(circle)
            .or_else(worst)
            .unwrap_or(Health::Ok)
        {
            Health::Ok => self.slaves.behind().unwrap_or(Health::Ok),
            worse => worse,
        }
    }

    /// Far axes and their slaves, for reports.
    pub(crate) fn reported(&self) -> Reported<'_> {
        Reported {
            far: &self.far,
            masters: &self.masters,
            slaves: &self.slaves,
        }
    }

    /// A far axis in this cycle, published or not.
    pub(crate) fn corrected_axis(&self, number: usize) -> Option<NcToPlcAxis> {
        self.far_axes.axis(number, &self.masters)
    }

    /// Published far axes, in this cycle.
    pub(crate) fn corrected_axes(&mut self) -> &[NcToPlcAxis] {
        self.far_axes.axes(&self.masters)
    }
}

/// Promised motion of a far axis, by its number among all axes; none without a promise.
fn promised<'a>(
    far: &'a [FarNode],
    ranges: &[(usize, usize)],
    axis: usize,
) -> Option<PromisedMotion<'a>> {
    let after = ranges.partition_point(|(first, _)| *first <= axis);
    let node = after.checked_sub(1)?;
    far[node].promised(axis - ranges[node].0)
}
