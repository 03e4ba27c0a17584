//! Orders to slaves, on a thread of their own: a node may take its time to respond.

use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};

use anyhow::Context;
use coaxle_host::client::Commander;
use coaxle_node::CommandOrder;
use coaxle_node::command::CommandVerdict;
use coaxle_ros::trajectory_queue::DueOrder;

/// Most orders that wait.
const MOST_WAITING: usize = 1024;

/// Sends orders, one after the other.
pub(super) struct OrderThread {
    queue: SyncSender<DueOrder>,
    refused: Receiver<u64>,
}

impl OrderThread {
    /// # Errors
    /// The system refuses a thread.
    pub(super) fn start(commander: Commander) -> anyhow::Result<Self> {
        let (queue, due) = sync_channel(MOST_WAITING);
        let (refusals, refused) = channel();
        let thread = std::thread::Builder::new().name("orders".to_owned());
        thread
            .spawn(move || send_all(&commander, &due, &refusals))
            .context("cannot start the thread of the orders")?;
        Ok(Self { queue, refused })
    }

    /// Queues an order; false if the queue is full.
    pub(super) fn enqueue(&self, due: DueOrder) -> bool {
        // Never waits: the thread of the bridge publishes joint states.
        self.queue.try_send(due).is_ok()
    }

    /// The trajectories with an order that was not accepted.
    pub(super) fn refused(&self) -> impl Iterator<Item = u64> {
        self.refused.try_iter()
    }
}

/// Sends orders until the queue is closed.
fn send_all(commander: &Commander, due: &Receiver<DueOrder>, refusals: &Sender<u64>) {
    // Trajectories are numbered from 1.
    let mut dropped = 0;
    for due in due {
        let trajectory = due.trajectory;
        // Orders that were queued before the refusal was noticed by the other thread.
        if trajectory == dropped {
            continue;
        }
        match send(commander, &due) {
            Ok(()) => tracing::info!(
                "trajectory {trajectory}: {} has {}",
                due.joint,
                due.order.command.name()
            ),
            Err(why) => {
                tracing::warn!(
                    "trajectory {trajectory}: {}: {why}, so the rest is dropped",
                    due.joint
                );
                dropped = trajectory;
                // Fails only if the bridge is gone, and then nothing is left to drop.
                let _ = refusals.send(trajectory);
            }
        }
    }
}

fn send(commander: &Commander, due: &DueOrder) -> Result<(), String> {
    let answer = commander.send(&due.node, &CommandOrder::Slave(due.order));
    match answer.map_err(|error| format!("{error:#}"))?.verdict {
        CommandVerdict::Accepted { .. } => Ok(()),
        CommandVerdict::Refused { text, .. } => Err(format!("refused {text}")),
        CommandVerdict::NotTaken { text, .. } => Err(format!("not taken: {text}")),
    }
}
