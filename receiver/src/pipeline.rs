//! The way of the data: far axes and virtual ones in, set values of the slaves out. One scan, top to bottom.

use coaxle_axis::{Job, NcToPlcAxis};
use coaxle_clock::cycle::Tick;
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::time_sync::WrongParameter;
use coaxle_clock::{Instant, Local, Seconds};
use coaxle_node::circles::{CircleChange, CircleState};
use coaxle_node::command::{CamOrder, FarOrder, OrderCargo, SlaveOrder};
use coaxle_node::{Arrival, BeaconResponse, Channel, CommandOutcome, Frame, Rejection};
use coaxle_slave::{Command, Refusal};

use crate::arrivals::ArrivalLog;
use crate::config::ReceiverConfig;
use crate::far::{Candidate, FarNode, FarOutputs};
use crate::far_axes::PublishedFarAxes;
use crate::slaves::{Master, SlaveNumber, Slaves};
use crate::snapshot::{Health, ReceiverSnapshot};
use crate::virtual_axes::VirtualAxes;

/// Everything between the mailboxes and the drives.
#[derive(Debug)]
pub(crate) struct Pipeline {
    cycle_s: f64,
    far: Box<[FarNode]>,
    /// Which of them each node that is heard is for, and its place there.
    heard: Box<[(usize, usize)]>,
    /// Each far node's first axis among all of them, and one past its last.
    ranges: Box<[(usize, usize)]>,
    /// Every far axis as a master.
    masters: Box<[Option<Master>]>,
    virtual_axes: VirtualAxes,
    slaves: Slaves,
    far_axes: PublishedFarAxes,
    /// Whether each far axis that it publishes is in a circle over nodes.
    far_axes_in_circles: Box<[bool]>,
    arrivals: ArrivalLog,
}

impl Pipeline {
    /// `run` is this run of the node.
    pub(crate) fn new(
        config: &ReceiverConfig,
        virtual_axes: VirtualAxes,
        slaves: Slaves,
        run: u64,
    ) -> Result<Self, (usize, WrongParameter)> {
        let cycle_time = config.cycle_time_us.0;
        let heard = config.heard_nodes().into_iter();
        let heard: Box<[_]> = heard.map(|node| (node.far, node.place)).collect();
        let far = (config.far.iter().enumerate())
            .map(|(n, far)| {
                let numbers = config.numbers_of(n);
                FarNode::new(far, cycle_time, run, &numbers).map_err(|wrong| (n, wrong))
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
            far_axes: PublishedFarAxes::new(config),
            far_axes_in_circles: config.published_far_axes().iter().map(|_| false).collect(),
            arrivals: ArrivalLog::new(heard.len()),
            heard,
        })
    }

    /// Stores a frame of the node with this number that arrived at `at`. The next cycle begins at `due`, or later.
    pub(crate) fn store(
        &mut self,
        number: usize,
        at: Instant<Local>,
        frame: &Frame<'_>,
        due: Instant<Local>,
    ) {
        self.heard(number).store(at, frame, due);
    }

    /// Stores a response of the node with this number that arrived at `at`.
    pub(crate) fn store_response(
        &mut self,
        number: usize,
        at: Instant<Local>,
        response: &TimeResponse,
    ) {
        self.heard(number).store_response(at, response);
    }

    /// Stores the answer to a beacon of the node with this number that arrived at `at`.
    pub(crate) fn store_beacon(
        &mut self,
        number: usize,
        at: Instant<Local>,
        response: &BeaconResponse,
    ) {
        self.heard(number).store_beacon(at, response);
    }

    /// Counts a beacon that was refused of the node with this number.
    pub(crate) fn reject_beacon(&mut self, number: usize) {
        self.heard(number).reject_beacon();
    }

    /// Counts what was refused of the node with this number.
    pub(crate) fn reject(&mut self, number: usize, reason: Rejection) {
        self.heard(number).reject(reason);
    }

    fn heard(&mut self, number: usize) -> &mut Candidate {
        let (far, place) = self.heard[number];
        self.far[far].node(place)
    }

    /// What the newest cycle took in and nobody fetched yet.
    pub(crate) fn arrival(&mut self) -> Option<Arrival> {
        self.arrivals.next()
    }

    /// The number of the time request to the node with this number that is due, if one is.
    pub(crate) fn ask(&mut self, number: usize, tick: &Tick) -> Option<u32> {
        self.heard(number).ask(tick)
    }

    /// The number of the beacon to the node with this number that is due, if one is.
    pub(crate) fn due_beacon(&mut self, number: usize, tick: &Tick) -> Option<u32> {
        self.heard(number).due_beacon(tick)
    }

    /// One scan.
    pub(crate) fn scan(&mut self, tick: &Tick, shown: &mut ReceiverSnapshot) {
        self.arrivals.begin();
        for n in 0..self.far.len() {
            self.far_node(n, tick, shown);
        }
        let virtual_axes = &mut shown.signals.virtual_axes;
        let virtual_axes = self.virtual_axes.cycle(tick.ideal_start, virtual_axes);
        let elapsed = Seconds(self.cycle_s * f64::from(tick.elapsed));
        self.slaves.update(&self.masters, virtual_axes, elapsed);
        self.slaves.show(shown);
        shown.health = self.health(shown);
        shown.signals.node.health = shown.health.name();
    }

    /// A far node: whom it follows, which run, its clock, its axes.
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
        self.far[n].scan(tick, &mut self.arrivals, outputs);
    }

    /// A command to a slave that does not come from its program.
    pub(crate) fn command(
        &mut self,
        slave: SlaveNumber,
        command: &Command,
    ) -> Result<Job, Refusal> {
        self.slaves.command(slave, command)
    }

    /// An order of somebody in the network to a slave.
    pub(crate) fn execute(&mut self, slave: SlaveNumber, order: &SlaveOrder) -> CommandOutcome {
        self.slaves.execute(slave, order)
    }

    /// An order about the cam plates of a slave, with what it brings and takes back.
    pub(crate) fn execute_cam(
        &mut self,
        slave: SlaveNumber,
        order: &CamOrder,
        cargo: &mut OrderCargo,
    ) -> CommandOutcome {
        self.slaves.execute_cam(slave, order, cargo)
    }

    /// An order of somebody in the network about a far node.
    pub(crate) fn execute_far(&mut self, far: usize, order: &FarOrder) -> CommandOutcome {
        self.far[far].execute(order)
    }

    /// Takes the circle over nodes that an axis is in.
    pub(crate) fn set_circle(&mut self, CircleChange { channel, id, state }: CircleChange) {
        match channel {
            Channel::Slaves => self.slaves.set_circle(id, state),
            // Their ids are their places, from 1.
            Channel::FarAxes => {
                let place = (id as usize).wrapping_sub(1);
                if let Some(is_in_circle) = self.far_axes_in_circles.get_mut(place) {
                    *is_in_circle = state != CircleState::None;
                }
            }
            _ => {}
        }
    }

    /// A slave's fault comes before all else, for it does not go away; then a circle over nodes, then the worst of the far nodes, then a slave that is
    /// behind: often for what is wrong there.
    fn health(&self, shown: &ReceiverSnapshot) -> Health {
        let worst = || {
            shown.far_health[..self.far.len()]
                .iter()
                .copied()
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

    /// The virtual axes in the newest cycle, in the order of the config.
    pub(crate) fn virtual_axes(&self) -> &[NcToPlcAxis] {
        self.virtual_axes.axes()
    }

    /// What is published of the slaves, by axis id.
    pub(crate) fn slave_axes(&mut self) -> &[NcToPlcAxis] {
        self.slaves.axes()
    }

    /// What is published of the far axes, in the cycle that is shown.
    pub(crate) fn corrected_axes(&mut self, shown: &ReceiverSnapshot) -> &[NcToPlcAxis] {
        self.far_axes.axes(&self.masters, &shown.signals.axes)
    }
}
