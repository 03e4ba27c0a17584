//! The threads of a running node, from their start to their end.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::JoinHandle;

use anyhow::Context;
use coaxle_node::Node;
use coaxle_os::machine;

use super::connect::Connected;
use super::rings::{CycleEnds, OutgoingEnds};
use super::{RunContext, Setup};
use crate::machine::real_time;
use crate::node::cycle::{Cycle, NodeClock};
use crate::node::session::Session;
use crate::node::status::{Identity, Reporter};
use crate::node::threads::{
    RunningBeacons, RunningCycle, Wishes, joined, start_beacons, start_cycle, start_publisher,
    start_telemetry,
};
use crate::node::timing::TimingChannel;

/// The threads of a node, and its session.
pub(super) struct RunningNode {
    session: Arc<Session>,
    cycle: RunningCycle,
    server: JoinHandle<()>,
    publisher: JoinHandle<()>,
    telemetry: JoinHandle<anyhow::Result<()>>,
    beacons: Option<RunningBeacons>,
    /// Real-time settings that were not granted, for the status.
    denied: Arc<real_time::Outcome>,
}

/// Starts the threads, those that take from the cycle thread before it.
pub(super) fn start<N: Node + Send + 'static>(
    setup: Setup<N>,
    run: &RunContext,
    (node, clock): (N, NodeClock),
    cycle: CycleEnds<N::Snapshot>,
    outgoing: OutgoingEnds<N::Snapshot>,
    connected: Connected,
) -> anyhow::Result<RunningNode> {
    let identity = identity(&setup, run.epoch);
    let session = connected.session;
    let (sender, receiver) = connected.timing.map(TimingChannel::ends).unzip();
    let beacons = receiver
        .map(|receiver| start_beacons(receiver, run.carriers, &run.panics))
        .transpose()?;
    let publisher = start_publisher(
        outgoing.frames,
        setup.send_stamps,
        connected.channels,
        sender,
        &run.counters,
        run.carriers,
        &run.panics,
    )?;
    let denied = Arc::new(real_time::Outcome::new());
    let reporter = Reporter::new(
        identity,
        Arc::clone(&session),
        Arc::clone(&run.counters),
        Arc::clone(&denied),
        (connected.circle_search, connected.abouts),
        machine::now(),
    );
    let telemetry = start_telemetry(outgoing.telemetry, setup.recorder, reporter, &run.panics)?;
    let CycleEnds {
        mailboxes,
        orders,
        mut outbox,
        records,
        arrivals,
        inputs,
    } = cycle;
    // The cycle wakes a thread by its handle, so that the thread has to be there first.
    outbox.attach(publisher.thread().clone());
    let circles = connected.circles;
    let counters = Arc::clone(&run.counters);
    // Built on the cycle thread, which starts the clock at its first cycle.
    let with_clock = move |clock| Cycle {
        node,
        clock,
        mailboxes,
        orders,
        outbox,
        records,
        arrivals,
        inputs,
        circles,
        counters,
    };
    let wishes = Wishes {
        real_time: setup.real_time,
        clock,
        run_for: setup.run_for,
    };
    Ok(RunningNode {
        cycle: start_cycle(with_clock, wishes, &run.panics)?,
        session,
        server: outgoing.server,
        publisher,
        telemetry,
        beacons,
        denied,
    })
}

impl RunningNode {
    /// Waits for the first cycle, and logs the start with the settings that were not granted.
    pub(super) async fn report_start(&mut self, run: &RunContext) {
        // A cycle thread that panicked before its first cycle sends nothing: its end is reported elsewhere.
        let Ok(denied) = (&mut self.cycle.running).await else {
            return;
        };
        for denied in self.denied.get_or_init(|| denied) {
            tracing::warn!(node = %run.name, "real-time wish {denied}");
        }
        let endpoints = self.session.whereabouts();
        tracing::info!(node = %run.name, role = run.role, "running, {endpoints}");
    }

    /// Waits for the end of the cycle thread.
    pub(super) async fn ended(&mut self) {
        // The thread never sends: the channel closes when it ends.
        let _ = (&mut self.cycle.ended).await;
    }

    /// Stops the threads in the order of the data flow, so that each finds all remaining data.
    ///
    /// # Errors
    /// A thread panicked or does not end, or the recorder could not keep what it recorded.
    pub(super) async fn stop(self) -> anyhow::Result<()> {
        self.cycle.stop.store(true, Ordering::Relaxed);
        let cycled = joined("cycle", self.cycle.thread).await;
        let commanded = joined("command", self.server).await;
        let published = joined("publish", self.publisher).await;
        let observed = joined("telemetry", self.telemetry).await;
        let timed = match self.beacons {
            // Last: the thread only waits for its socket, and its messages have no reader any more.
            Some(beacons) => {
                beacons.stop.store(true, Ordering::Relaxed);
                joined("timing", beacons.thread).await
            }
            None => Ok(()),
        };
        // After all threads: the last frames and the last status leave by this session.
        self.session.close();
        // An error of a thread itself is more specific than that one of them panicked.
        cycled?;
        commanded?;
        published?;
        timed?;
        observed?.context("the recorder could not keep what it recorded")
    }
}

fn identity<N: Node>(setup: &Setup<N>, epoch: u64) -> Identity {
    let heard = setup.wiring.subscriptions.iter();
    let followed = heard.filter(|s| s.channel.carries_axes());
    let axes = setup
        .wiring
        .publications
        .iter()
        // Requests and responses are left out: a node that only asks for the time is followed by nobody.
        .filter(|p| p.channel.carries_axes());
    Identity {
        name: setup.name.clone(),
        role: setup.role,
        epoch,
        sources: followed
            .map(|s| (s.node.clone(), s.node.channel_key(s.channel)))
            .collect(),
        publishes: axes.map(|p| p.node.channel_key(p.channel)).collect(),
        in_secure_network: setup.transport.secure.is_some(),
        lab: setup.lab.as_ref().map(ToString::to_string),
    }
}
