//! Routers between nodes.
//!
//! A node is behind one router. Its frames go to that router, and from router to router, once over
//! each hop that leads to a living subscriber, like with Zenoh's routers. They know the shortest
//! paths around dead routers; a frozen one is not detected, and messages wait there.

use std::collections::VecDeque;
use std::rc::Rc;

use coaxle_clock::{Instant, Span};
use coaxle_node::Channel;
use coaxle_node::config::{LinkConfig, Wrong};

use crate::hop::{End, Hop, Load, Throttle};
use crate::setup::RouterSetup;
use crate::traffic::LinkCounts;
use crate::true_time::True;

/// The routers, and the hops between them and to their nodes.
#[derive(Default)]
pub(crate) struct Network {
    routers: Vec<Router>,
    hops: Vec<Hop>,
    /// Home of each node behind a router, by node number.
    homes: Vec<Option<Home>>,
    flows: Vec<Flow>,
    /// The hops of the frame that is forwarded.
    next_hops: Vec<usize>,
    pub(crate) counts: LinkCounts,
}

struct Router {
    setup: RouterSetup,
    state: RouterState,
    forwarding: Throttle,
    /// The connected routers, each with the hop to it.
    neighbours: Vec<(usize, usize)>,
    /// The hop that leads to each router, by its number; none to itself and to unreachable ones.
    ways: Vec<Option<usize>>,
    received: Load,
    dropped: u64,
}

enum RouterState {
    Running,
    /// Frozen, with the waiting frames.
    Frozen(Vec<Transit>),
    Dead,
}

/// A node's place.
#[derive(Clone, Copy)]
struct Home {
    router: usize,
    up: usize,
    down: usize,
}

/// Frames of one node under one key, with the subscribers.
struct Flow {
    from: usize,
    channel: Channel,
    far: usize,
    /// The links, each with the node it leads to.
    links: Vec<(usize, usize)>,
}

/// A frame on a hop.
pub(crate) struct Transit {
    hop: usize,
    flow: usize,
    frame: Rc<[u8]>,
}

/// Traffic of a router.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RouterTraffic {
    /// Name of the router.
    pub name: String,
    /// Messages received from nodes and other routers.
    pub received: Load,
    /// Messages sent to its nodes.
    pub to_nodes: Load,
    /// Messages sent to each connected router.
    pub to_routers: Vec<(String, Load)>,
    /// Messages dropped for lack of room, or because the router was dead.
    pub dropped: u64,
}

impl Network {
    pub(crate) fn add_router(&mut self, setup: RouterSetup) -> usize {
        // Zero time per byte: forwarding costs the same for every size, the line behind it does not.
        let forwarding = Throttle::new(setup.forwarding, 0.0, setup.longest_queue);
        self.routers.push(Router {
            setup,
            state: RouterState::Running,
            forwarding,
            neighbours: Vec::new(),
            ways: Vec::new(),
            received: Load::default(),
            dropped: 0,
        });
        self.find_ways();
        self.routers.len() - 1
    }

    /// Connects two routers, with the link's behaviour in both directions, and a seed for each.
    pub(crate) fn connect_routers(
        &mut self,
        routers: [usize; 2],
        config: &LinkConfig,
        seeds: [u64; 2],
    ) -> Result<(), Wrong> {
        let [a, b] = routers;
        for ((from, to), seed) in [(a, b), (b, a)].into_iter().zip(seeds) {
            // Each direction has the line of the router that sends, as with full duplex.
            let line = self.line_of(from);
            let hop = self.add_hop(End::Router(to), config, seed, line)?;
            self.routers[from].neighbours.push((to, hop));
        }
        self.find_ways();
        Ok(())
    }

    /// Puts a node behind a router.
    pub(crate) fn place(
        &mut self,
        node: usize,
        router: usize,
        config: &LinkConfig,
        seeds: [u64; 2],
    ) -> Result<(), Wrong> {
        let line = self.line_of(router);
        let up = self.add_hop(End::Router(router), config, seeds[0], line)?;
        let down = self.add_hop(End::Node(node), config, seeds[1], line)?;
        if self.homes.len() <= node {
            self.homes.resize(node + 1, None);
        }
        self.homes[node] = Some(Home { router, up, down });
        Ok(())
    }

    fn line_of(&self, router: usize) -> Throttle {
        let RouterSetup {
            ns_per_byte,
            longest_queue,
            ..
        } = self.routers[router].setup;
        Throttle::new(Span::ZERO, ns_per_byte, longest_queue)
    }

    fn add_hop(
        &mut self,
        to: End,
        config: &LinkConfig,
        seed: u64,
        line: Throttle,
    ) -> Result<usize, Wrong> {
        self.hops.push(Hop::new(to, config, seed, line)?);
        Ok(self.hops.len() - 1)
    }

    /// The flow that a link belongs to, if both of its nodes are behind routers. Beacons take
    /// another path.
    pub(crate) fn flow_of(
        &mut self,
        (from, channel, far): (usize, Channel, usize),
        link: usize,
        to: usize,
    ) -> Option<usize> {
        self.home(from)?;
        self.home(to)?;
        // Beacons are datagrams from node to node, stamped by the kernel; no router sees them.
        if channel.is_timing() {
            return None;
        }
        let is_it = |flow: &Flow| flow.from == from && flow.channel == channel && flow.far == far;
        let flow = self.flows.iter().position(is_it).unwrap_or_else(|| {
            self.flows.push(Flow {
                from,
                channel,
                far,
                links: Vec::new(),
            });
            self.flows.len() - 1
        });
        self.flows[flow].links.push((link, to));
        Some(flow)
    }

    fn home(&self, node: usize) -> Option<Home> {
        self.homes.get(node).copied().flatten()
    }

    /// The links of a flow that lead to a node.
    pub(crate) fn links_to(&self, flow: usize, node: usize) -> impl Iterator<Item = usize> {
        let links = self.flows[flow].links.iter();
        links.filter_map(move |(link, to)| (*to == node).then_some(*link))
    }

    /// True if this link represents its whole flow: a frame leaves its node only once.
    pub(crate) fn is_first(&self, flow: usize, link: usize) -> bool {
        // Any fixed link would do; the first exists as soon as the flow does.
        self.flows[flow].links.first().map(|(first, _)| *first) == Some(link)
    }

    /// Publishes a frame of a node.
    pub(crate) fn publish(
        &mut self,
        now: Instant<True>,
        flow: usize,
        frame: &[u8],
        on_its_way: &mut impl FnMut(Instant<True>, Transit),
    ) {
        let Some(home) = self.home(self.flows[flow].from) else {
            return;
        };
        self.counts.send();
        self.send(now, home.up, flow, &Rc::from(frame), on_its_way);
    }

    /// Takes a frame at the end of its hop. Returns the node that it has reached, with the flow and
    /// the frame, or forwards it towards living nodes.
    pub(crate) fn arrive(
        &mut self,
        now: Instant<True>,
        transit: Transit,
        lives: impl Fn(usize) -> bool,
        on_its_way: &mut impl FnMut(Instant<True>, Transit),
    ) -> Option<(usize, usize, Rc<[u8]>)> {
        match self.hops[transit.hop].to {
            End::Node(node) => Some((node, transit.flow, transit.frame)),
            End::Router(router) => {
                self.reach(now, router, transit, lives, on_its_way);
                None
            }
        }
    }

    fn reach(
        &mut self,
        now: Instant<True>,
        router: usize,
        transit: Transit,
        lives: impl Fn(usize) -> bool,
        on_its_way: &mut impl FnMut(Instant<True>, Transit),
    ) {
        let at = &mut self.routers[router];
        match &mut at.state {
            RouterState::Running => {
                at.received.add(Load {
                    messages: 1,
                    bytes: transit.frame.len() as u64,
                });
                self.forward(now, router, &transit, lives, on_its_way);
            }
            // A frozen process keeps its sockets, which go on filling; a dead one has none.
            RouterState::Frozen(waiting) if waiting.len() < MOST_WAITING => waiting.push(transit),
            RouterState::Frozen(_) | RouterState::Dead => {
                at.dropped += 1;
                self.counts.became(0);
            }
        }
    }

    /// Forwards a frame once over each hop that leads to a living subscriber, one after the other.
    fn forward(
        &mut self,
        now: Instant<True>,
        router: usize,
        transit: &Transit,
        lives: impl Fn(usize) -> bool,
        on_its_way: &mut impl FnMut(Instant<True>, Transit),
    ) {
        // Taken out and put back: sending borrows the whole network, and a new list per frame would allocate.
        let mut next_hops = std::mem::take(&mut self.next_hops);
        next_hops.clear();
        for (_, node) in &self.flows[transit.flow].links {
            let way = || self.way_on(transit.flow, transit.hop, router, *node);
            // Subscriptions of a dead node are withdrawn, and a router forwards nothing without a subscriber.
            let hop = lives(*node).then(way).flatten();
            // Several subscribers behind one hop share a single frame.
            next_hops.extend(hop.filter(|hop| !next_hops.contains(hop)));
        }
        self.counts.became(next_hops.len() as u64);
        for hop in &next_hops {
            let at = &mut self.routers[router];
            match at.forwarding.pass(now, transit.frame.len()) {
                Some(left) => self.send(left, *hop, transit.flow, &transit.frame, on_its_way),
                None => {
                    at.dropped += 1;
                    self.counts.became(0);
                }
            }
        }
        self.next_hops = next_hops;
    }

    /// The next hop of a frame from `router` to a node, arrived over the hop `came`; none if this
    /// is not on the path from its source: paths differ by source, and forwarding by every router
    /// would duplicate frames.
    fn way_on(&self, flow: usize, came: usize, router: usize, node: usize) -> Option<usize> {
        let source = self.home(self.flows[flow].from)?;
        let (mut at, mut by) = (source.router, source.up);
        // A path visits each router at most once; the bound ends the search if paths changed while a frame was under
        // way.
        for _ in 0..self.routers.len() {
            let next = self.hop_to(at, node)?;
            if at == router {
                // The router is on the path, but a frame that came another way is a copy.
                return (by == came).then_some(next);
            }
            let End::Router(after) = self.hops[next].to else {
                return None;
            };
            (at, by) = (after, next);
        }
        None
    }

    fn hop_to(&self, router: usize, node: usize) -> Option<usize> {
        let home = self.home(node)?;
        match home.router == router {
            true => Some(home.down),
            false => self.routers[router].ways[home.router],
        }
    }

    fn send(
        &mut self,
        at: Instant<True>,
        hop: usize,
        flow: usize,
        frame: &Rc<[u8]>,
        on_its_way: &mut impl FnMut(Instant<True>, Transit),
    ) {
        let mut messages = 0;
        for arrival in self.hops[hop].send(at, frame.len()) {
            messages += 1;
            let frame = Rc::clone(frame);
            on_its_way(arrival, Transit { hop, flow, frame });
        }
        self.counts.became(messages);
    }

    /// Ends a router at once; frames that wait there are lost.
    pub(crate) fn kill(&mut self, router: usize) {
        let at = &mut self.routers[router];
        if let RouterState::Frozen(waiting) = &at.state {
            at.dropped += waiting.len() as u64;
            // Every message ends in exactly one count, or the sums of the traffic do not agree.
            waiting.iter().for_each(|_| self.counts.became(0));
        }
        at.state = RouterState::Dead;
        self.find_ways();
    }

    /// Restarts a dead router.
    pub(crate) fn start(&mut self, router: usize) {
        let at = &mut self.routers[router];
        // Starting a frozen router would silently lose the frames that wait there.
        if matches!(at.state, RouterState::Dead) {
            at.state = RouterState::Running;
            self.find_ways();
        }
    }

    /// Freezes a router.
    pub(crate) fn freeze(&mut self, router: usize) {
        let at = &mut self.routers[router];
        if matches!(at.state, RouterState::Running) {
            at.state = RouterState::Frozen(Vec::new());
        }
    }

    /// Resumes a frozen router, with the frames that wait there.
    pub(crate) fn resume(
        &mut self,
        now: Instant<True>,
        router: usize,
        lives: impl Fn(usize) -> bool,
        on_its_way: &mut impl FnMut(Instant<True>, Transit),
    ) {
        let at = &mut self.routers[router];
        let RouterState::Frozen(waiting) = &mut at.state else {
            return;
        };
        let waiting = std::mem::take(waiting);
        at.state = RouterState::Running;
        // The state is changed before: in a frozen state each frame would wait again.
        for transit in waiting {
            self.reach(now, router, transit, &lives, on_its_way);
        }
    }

    /// Frames that wait for frozen routers.
    pub(crate) fn waiting(&self) -> u64 {
        let waiting = self.routers.iter().map(|router| match &router.state {
            RouterState::Frozen(waiting) => waiting.len() as u64,
            RouterState::Running | RouterState::Dead => 0,
        });
        waiting.sum()
    }

    /// Traffic of each router since the start.
    pub(crate) fn traffic(&self) -> Vec<RouterTraffic> {
        let traffic = self.routers.iter().enumerate().map(|(number, router)| {
            let mut to_nodes = Load::default();
            let mut dropped = router.dropped;
            for home in self.homes.iter().flatten() {
                if home.router == number {
                    to_nodes.add(self.hops[home.down].sent);
                    dropped += self.hops[home.down].dropped + self.hops[home.up].dropped;
                }
            }
            let to_routers = router.neighbours.iter().map(|(to, hop)| {
                dropped += self.hops[*hop].dropped;
                (self.routers[*to].setup.name.clone(), self.hops[*hop].sent)
            });
            RouterTraffic {
                name: router.setup.name.clone(),
                received: router.received,
                to_nodes,
                to_routers: to_routers.collect(),
                dropped,
            }
        });
        traffic.collect()
    }

    /// Computes the paths with the fewest hops around dead routers; among several, over the router
    /// connected first.
    fn find_ways(&mut self) {
        for from in 0..self.routers.len() {
            // Breadth first: the first way that reaches a router has the fewest hops.
            let mut ways = vec![None; self.routers.len()];
            let mut queue = VecDeque::from([from]);
            while let Some(at) = queue.pop_front() {
                for (to, hop) in &self.routers[at].neighbours {
                    // Without the first condition the start would get a way to itself over a neighbour.
                    let is_new = *to != from && ways[*to].is_none();
                    if is_new && !matches!(self.routers[*to].state, RouterState::Dead) {
                        // Only the first hop of a way is stored; each router on it has its own table.
                        ways[*to] = if at == from { Some(*hop) } else { ways[at] };
                        queue.push_back(*to);
                    }
                }
            }
            self.routers[from].ways = ways;
        }
    }
}

/// Greatest number of frames that wait for a frozen router: no socket holds more, and further ones
/// are lost.
const MOST_WAITING: usize = 50_000;
