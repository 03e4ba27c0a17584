//! Commands to the slaves of running processes, through the network.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::thread::JoinHandle;

use anyhow::Context;
use coaxle_host::client::Commander;
use coaxle_lab::event::{Event, EventCommand, EventKind};
use coaxle_lab::verdict::Verdict;
use coaxle_node::CommandAnswer;
use coaxle_node::config::TransportConfig;
use coaxle_node::keys::NodeName;

/// The orders of a run. None of them delays the runner: each waits for its response on its own thread.
pub(super) struct OrderSender {
    commander: Option<Arc<Commander>>,
    sent: Vec<PendingOrder>,
}

struct PendingOrder {
    event: Event,
    commanded: EventCommand,
    answer: JoinHandle<anyhow::Result<CommandAnswer>>,
}

impl OrderSender {
    /// Joins the network if there is anything to send.
    pub(super) fn prepare(
        events: &[Event],
        endpoint: impl Fn(&NodeName) -> Option<String>,
    ) -> anyhow::Result<Self> {
        let is_order = |event: &&Event| matches!(event.what, EventKind::Command(_));
        let nodes: BTreeSet<_> = events.iter().filter(is_order).map(|e| &e.node).collect();
        // A run without commands needs no session beside those of its nodes.
        let commander = if nodes.is_empty() {
            None
        } else {
            let transport = TransportConfig {
                connect: nodes.into_iter().filter_map(endpoint).collect(),
                ..TransportConfig::default()
            };
            Some(Arc::new(Commander::open(&transport)?))
        };
        Ok(Self {
            commander,
            sent: Vec::new(),
        })
    }

    pub(super) fn send(&mut self, event: &Event) -> anyhow::Result<()> {
        let (Some(commander), EventKind::Command(commanded)) = (&self.commander, &event.what)
        else {
            return Ok(());
        };
        // An order to a frozen node waits until its timeout, and the events of others must not wait with it.
        let (commander, node) = (Arc::clone(commander), event.node.clone());
        let order = commanded.order.clone();
        let answer = std::thread::Builder::new()
            .name("order".to_owned())
            .spawn(move || commander.send(&node, &order))
            .context("cannot start a thread for an order")?;
        self.sent.push(PendingOrder {
            event: event.clone(),
            commanded: commanded.clone(),
            answer,
        });
        Ok(())
    }

    /// Waits for the outstanding responses, and leaves the network.
    pub(super) fn finish(self) -> Vec<Verdict> {
        let verdicts = self.sent.into_iter().map(PendingOrder::judge).collect();
        // Every thread has ended by now, so this is the last owner.
        if let Some(commander) = self.commander.and_then(Arc::into_inner) {
            commander.close();
        }
        verdicts
    }
}

impl PendingOrder {
    fn judge(self) -> Verdict {
        let answer = match self.answer.join() {
            Ok(Ok(answer)) => Some(answer),
            Ok(Err(error)) => {
                tracing::warn!("{error:#}");
                None
            }
            // A panic of the thread is judged as no response.
            Err(_) => None,
        };
        self.commanded.judge(&self.event, answer.as_ref())
    }
}
