//! The way of the data: far axes and virtual ones in, set values of the slaves out. One scan, top to bottom.

use coaxle_axis::{Job, NcToPlcAxis};
use coaxle_clock::cycle::Tick;
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::time_sync::WrongParameter;
use coaxle_clock::{Instant, Local, Seconds};
use coaxle_node::command::{FarOrder, SlaveOrder};
use coaxle_node::{Arrival, CommandOutcome, Frame, Rejection};
use coaxle_slave::{Command, Refusal};

use crate::arrivals::ArrivalLog;
use crate::config::ReceiverConfig;
use crate::far::{FarNode, FarOutputs};
use crate::far_axes::PublishedFarAxes;
use crate::slaves::{Master, SlaveNumber, Slaves};
use crate::snapshot::{Health, ReceiverSnapshot};
use crate::virtual_axes::VirtualAxes;

/// Everything between the mailboxes and the drives.
#[derive(Debug)]
pub(crate) struct Pipeline {
    cycle_s: f64,
    far: Box<[FarNode]>,
    /// Each far node's first axis among all of them, and one past its last.
    ranges: Box<[(usize, usize)]>,
    /// Every far axis as a master.
    masters: Box<[Option<Master>]>,
    virtual_axes: VirtualAxes,
    slaves: Slaves,
    far_axes: PublishedFarAxes,
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
        let far = (config.far.iter().enumerate())
            .map(|(n, far)| FarNode::new(far, cycle_time, run).map_err(|wrong| (n, wrong)))
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
            arrivals: ArrivalLog::new(config.far.len()),
        })
    }

    /// Stores a frame of a far node that arrived at `at`. The next cycle begins at `due`, or later.
    pub(crate) fn store(
        &mut self,
        far: usize,
        at: Instant<Local>,
        frame: &Frame<'_>,
        due: Instant<Local>,
    ) {
        self.far[far].store(at, frame, due);
    }

    /// Stores a response of a far node that arrived at `at`.
    pub(crate) fn store_response(
        &mut self,
        far: usize,
        at: Instant<Local>,
        response: &TimeResponse,
    ) {
        self.far[far].store_response(at, response);
    }

    /// Counts what was refused of a far node.
    pub(crate) fn reject(&mut self, far: usize, reason: Rejection) {
        self.far[far].reject(reason);
    }

    /// What the newest cycle took in and nobody fetched yet.
    pub(crate) fn arrival(&mut self) -> Option<Arrival> {
        self.arrivals.next()
    }

    /// The number of the time request to a far node that is due, if one is.
    pub(crate) fn ask(&mut self, far: usize, tick: &Tick) -> Option<u32> {
        self.far[far].ask(tick)
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

    /// A far node: which run, its clock, its axes.
    fn far_node(&mut self, n: usize, tick: &Tick, shown: &mut ReceiverSnapshot) {
        let (first, end) = self.ranges[n];
        let signals = &mut shown.signals;
        let outputs = FarOutputs {
            masters: &mut self.masters[first..end],
            signals: &mut signals.far[n],
            axes: &mut signals.axes[first..end],
        };
        let health = self.far[n].scan(tick, &mut self.arrivals.of(n), outputs);
        shown.far_health[n] = health;
        shown.data_cycle_times[n] = self.far[n].data_cycle_time();
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

    /// An order of somebody in the network about a far node.
    pub(crate) fn execute_far(&mut self, far: usize, order: &FarOrder) -> CommandOutcome {
        self.far[far].execute(order)
    }

    /// A slave's fault comes before all else, for it does not go away; then the worst of the far nodes.
    fn health(&self, shown: &ReceiverSnapshot) -> Health {
        let worst = || {
            shown
                .far_health
                .iter()
                .copied()
                .max_by_key(Health::severity)
        };
        self.slaves.fault().or_else(worst).unwrap_or(Health::Ok)
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
