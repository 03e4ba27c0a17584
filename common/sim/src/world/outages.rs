//! Ends, starts and pauses of nodes and routers.

use coaxle_clock::Span;
use coaxle_node::{Channel, Node};

use super::{SimulatedState, World, WorldEvent, add};
use crate::invariants::Watch;

/// Messages of a backlog that arrive at once, and the interval between such pieces: a second's
/// worth of a sender of 1 ms arrives within 10 ms.
const PIECE: usize = 100;
const BETWEEN_PIECES: Span = Span::from_millis(1);

impl<N: Node> World<N> {
    /// Ends a node at once, like a power cut.
    pub fn kill(&mut self, node: usize) {
        let simulated = &mut self.nodes[node];
        if let SimulatedState::Stopped(_, waiting) = &simulated.state {
            // The messages die with the process, and must appear in one of the counts.
            self.dropped += waiting.len() as u64;
        }
        simulated.state = SimulatedState::Dead;
        simulated.orders.clear();
    }

    /// Restarts a dead node, on the same clock.
    pub fn start(&mut self, node: usize) {
        let now = self.now;
        let simulated = &mut self.nodes[node];
        simulated.run += 1;
        // Cycle counts restart with the process; compared with the old ones they would be a breach.
        simulated.watch = Watch::default();
        let start = simulated.clock.local_at(now) + simulated.start_phase;
        let mut built = (simulated.build)(start, simulated.run);
        // Links outlive the processes at their ends: a restarted node finds its subscribers at once.
        for channel in Channel::ALL {
            let mut links = self.links_of[node].iter();
            let is_subscribed = links.any(|link| self.links[*link].channel == channel);
            built.set_subscribed(channel, is_subscribed);
        }
        simulated.state = SimulatedState::Running(built);
        self.schedule(node);
    }

    /// Freezes a node, like a debugger. Messages wait for it.
    pub fn stop(&mut self, node: usize) {
        let state = &mut self.nodes[node].state;
        // Dead is only a placeholder while the node is moved from one state into the other.
        *state = match std::mem::replace(state, SimulatedState::Dead) {
            SimulatedState::Running(node) => SimulatedState::Stopped(node, Vec::new()),
            other => other,
        };
    }

    /// Resumes a frozen node. Messages that waited for it arrive now.
    pub fn resume(&mut self, node: usize) {
        let state = &mut self.nodes[node].state;
        match std::mem::replace(state, SimulatedState::Dead) {
            SimulatedState::Stopped(frozen, waiting) => {
                *state = SimulatedState::Running(frozen);
                for (link, message) in waiting {
                    self.deliver(link, message);
                }
                self.schedule(node);
            }
            other => *state = other,
        }
    }

    /// Resumes a frozen node. Messages that waited for it arrive in pieces, like from a drained
    /// mailbox, and messages sent meanwhile arrive behind them.
    pub fn resume_in_pieces(&mut self, node: usize) {
        let state = &mut self.nodes[node].state;
        match std::mem::replace(state, SimulatedState::Dead) {
            SimulatedState::Stopped(frozen, waiting) => {
                *state = SimulatedState::Running(frozen);
                let mut at = self.now;
                for (n, (link, message)) in waiting.into_iter().enumerate() {
                    if n > 0 && n % PIECE == 0 {
                        at += BETWEEN_PIECES;
                    }
                    self.queue.add(at, WorldEvent::Drain { link, message });
                }
                // Messages sent meanwhile must not overtake the backlog: a link never reorders.
                self.nodes[node].drained_at = at;
                self.schedule(node);
            }
            other => *state = other,
        }
    }

    /// Ends a router at once. Nodes behind it are cut off, and others find paths around it if there
    /// are any.
    pub fn kill_router(&mut self, router: usize) {
        self.network.kill(router);
    }

    /// Restarts a dead router.
    pub fn start_router(&mut self, router: usize) {
        self.network.start(router);
    }

    /// Freezes a router. Messages wait there, and no path around it is searched.
    pub fn stop_router(&mut self, router: usize) {
        self.network.freeze(router);
    }

    /// Resumes a frozen router, with the waiting messages.
    pub fn resume_router(&mut self, router: usize) {
        let (nodes, queue, dropped) = (&self.nodes, &mut self.queue, &mut self.dropped);
        let lives = |node: usize| !matches!(nodes[node].state, SimulatedState::Dead);
        let mut on_its_way = |at, transit| add(queue, dropped, at, WorldEvent::Hop(transit));
        self.network
            .resume(self.now, router, lives, &mut on_its_way);
    }
}
