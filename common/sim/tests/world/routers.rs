//! Frames that go over routers.

use coaxle_clock::Span;
use coaxle_node::Channel;
use coaxle_node::config::{LinkConfig, parse};
use coaxle_sim::{Load, RouterSetup, RouterTraffic, Traffic, World};
use proptest::prelude::*;

use crate::toy::{BELT, Memory, Toy, link, run, toy};

/// A world of a belt and some saws that receive from it, each behind a router: the belt's comes first.
struct Plant {
    world: World<Toy>,
    memory: Memory,
    now_micros: i64,
}

fn latency(micros: u32) -> LinkConfig {
    parse("link", &format!("latency-us = {micros}")).expect("a test's own input")
}

fn router(name: usize) -> RouterSetup {
    RouterSetup {
        name: name.to_string(),
        forwarding: Span::ZERO,
        ns_per_byte: 0.0,
        longest_queue: Span::from_secs(1),
    }
}

impl Plant {
    fn new(routers: &[RouterSetup], connected: &[[usize; 2]], behind: &[usize]) -> Self {
        let mut world = World::new();
        for router in routers {
            world.add_router(router.clone());
        }
        for &pair in connected {
            let connect = world.connect_routers(pair, &latency(100), [1, 2]);
            connect.expect("no files");
        }
        for (node, router) in behind.iter().enumerate() {
            let setup = match node {
                BELT => toy("belt", "", &[Channel::Axes]),
                saw => toy(&format!("saw-{saw}"), "", &[]),
            };
            assert_eq!(world.add_node(setup).expect("no files"), node);
            let place = world.place_behind(node, *router, &latency(10), [3, 4]);
            place.expect("no files");
        }
        for saw in 1..behind.len() {
            world.add_link(link(BELT, saw, &[""])).expect("no files");
        }
        Self {
            world,
            memory: Memory::default(),
            now_micros: 0,
        }
    }

    fn of(routers: usize, connected: &[[usize; 2]], behind: &[usize]) -> Self {
        let routers: Vec<_> = (0..routers).map(router).collect();
        Self::new(&routers, connected, behind)
    }

    /// Runs this number of cycles, the last one until all its frames have arrived.
    fn cycles(&mut self, cycles: i64) {
        self.now_micros += 1_000 * cycles;
        run(&mut self.world, self.now_micros, &mut self.memory);
        let Traffic {
            sent,
            added,
            lost,
            delivered,
            dropped,
            waiting,
            under_way,
        } = self.world.traffic();
        let rest = lost + delivered + dropped + waiting + under_way;
        assert_eq!(sent + added, rest, "every message is accounted for");
    }

    /// The counts that a saw received.
    fn counts(&self, saw: usize) -> Vec<u64> {
        let saw = self.world.node(saw).expect("it lives");
        saw.counts().into_iter().map(|(_, count)| count).collect()
    }

    /// Transport time of each frame to a saw, µs.
    fn delays(&self, saw: usize) -> Vec<i64> {
        let received = self.world.node(saw).expect("it lives").counts();
        let delay = |(at, count): &(coaxle_clock::Instant<coaxle_clock::Local>, u64)| {
            at.as_nanos() / 1_000 - 1_000 * *count as i64
        };
        received.iter().map(delay).collect()
    }

    fn traffic(&self, router: usize) -> RouterTraffic {
        self.world.router_traffic().remove(router)
    }

    fn messages_to(&self, router: usize, next: usize) -> u64 {
        let traffic = self.traffic(router);
        let mut to = traffic.to_routers.into_iter();
        let (_, load) = to
            .find(|(name, _)| *name == next.to_string())
            .expect("connected");
        load.messages
    }
}

/// Halls 0 and 2 with one router each, and one in the middle.
const LINE: [[usize; 2]; 2] = [[0, 1], [1, 2]];

#[test]
fn a_frame_takes_each_hop_once_however_many_hear_it() {
    let mut plant = Plant::of(3, &LINE, &[0, 2, 2, 2, 0]);
    plant.cycles(10);
    for saw in [1, 2, 3] {
        // Up, two hops between routers, and down.
        assert_eq!(plant.delays(saw), [10 + 100 + 100 + 10; 10]);
    }
    assert_eq!(plant.delays(4), [20; 10], "next door");
    assert_eq!(plant.messages_to(0, 1), 10);
    assert_eq!(plant.messages_to(1, 2), 10);
    assert_eq!(plant.messages_to(1, 0), 0);
    let last = plant.traffic(2);
    assert_eq!(last.received.messages, 10);
    assert_eq!(last.to_nodes.messages, 30);
    let Load { messages, bytes } = last.received;
    assert_eq!(last.to_nodes.bytes, 3 * bytes);
    // Header, an axis and check sum; the exact length is the wire's affair.
    assert!((60..200).contains(&(bytes / messages)), "{bytes}");
}

#[test]
fn what_nobody_subscribes_to_is_not_forwarded() {
    let mut plant = Plant::of(3, &LINE, &[0, 2]);
    plant.cycles(5);
    plant.world.kill(1);
    plant.cycles(5);
    assert_eq!(plant.traffic(0).received.messages, 10);
    assert_eq!(plant.messages_to(0, 1), 5);
    plant.world.start(1);
    plant.cycles(5);
    assert_eq!(plant.counts(1), [10, 11, 12, 13, 14]);
}

#[test]
fn nodes_behind_a_dead_router_lose_each_other_until_it_is_back() {
    let mut plant = Plant::of(3, &LINE, &[0, 2, 0]);
    plant.cycles(5);
    plant.world.kill_router(1);
    plant.cycles(5);
    plant.world.start_router(1);
    plant.cycles(5);
    assert_eq!(plant.counts(1), [0, 1, 2, 3, 4, 10, 11, 12, 13, 14]);
    assert_eq!(plant.counts(2), (0..15).collect::<Vec<_>>(), "its own hall");
    // No frame was sent in vain: the router before it knows that no subscriber is behind it.
    assert_eq!(plant.messages_to(0, 1), 10);
    plant.world.kill_router(0);
    plant.cycles(5);
    assert_eq!(plant.counts(2).len(), 15, "without its own router");
    assert_eq!(plant.traffic(0).dropped, 5);
}

#[test]
fn frames_wait_for_a_frozen_router() {
    let mut plant = Plant::of(3, &LINE, &[0, 2]);
    plant.cycles(5);
    plant.world.stop_router(1);
    plant.cycles(5);
    assert_eq!(plant.counts(1).len(), 5);
    plant.world.resume_router(1);
    plant.cycles(1);
    assert_eq!(plant.counts(1), (0..11).collect::<Vec<_>>());
    assert_eq!(
        plant.delays(1)[5..],
        [5_110, 4_110, 3_110, 2_110, 1_110, 220]
    );
    plant.world.stop_router(1);
    plant.cycles(5);
    plant.world.kill_router(1);
    plant.world.start_router(1);
    plant.cycles(1);
    assert_eq!(plant.counts(1).last(), Some(&16));
    assert_eq!(plant.counts(1).len(), 12, "what waited died with it");
}

#[test]
fn another_way_is_taken_past_a_dead_router() {
    // Two paths of equal length; the one connected first is taken.
    let mut plant = Plant::of(4, &[[0, 1], [0, 3], [1, 2], [3, 2]], &[0, 2]);
    plant.cycles(5);
    assert_eq!((plant.messages_to(0, 1), plant.messages_to(0, 3)), (5, 0));
    plant.world.kill_router(1);
    plant.cycles(5);
    plant.world.start_router(1);
    plant.cycles(5);
    assert_eq!(plant.counts(1), (0..15).collect::<Vec<_>>());
    assert_eq!((plant.messages_to(0, 1), plant.messages_to(0, 3)), (10, 5));
}

#[test]
fn a_slow_router_queues_and_what_would_wait_too_long_is_dropped() {
    let slow = RouterSetup {
        forwarding: Span::from_micros(300),
        longest_queue: Span::from_micros(700),
        ..router(0)
    };
    let mut plant = Plant::new(&[slow], &[], &[0, 0, 0, 0, 0]);
    plant.cycles(1);
    let first: Vec<_> = (1..5).map(|saw| plant.delays(saw)).collect();
    // 10 µs up, 300 to forward and 10 down; the fourth would wait 900 µs, above 700.
    assert_eq!(first, [vec![320], vec![620], vec![920], vec![]]);
    assert_eq!(plant.traffic(0).dropped, 1);
    let narrow = RouterSetup {
        ns_per_byte: 1_000.0,
        ..router(0)
    };
    let mut plant = Plant::new(&[narrow], &[], &[0, 0]);
    plant.cycles(3);
    let bytes = plant.traffic(0).received.bytes / 3;
    // 10 µs and a microsecond per byte on each of the two hops.
    assert_eq!(plant.delays(1), [20 + 2 * bytes as i64; 3]);
}

proptest! {
    /// With any connections and deaths, each reachable saw gets every frame once, and no other saw any.
    #[test]
    fn every_saw_with_a_way_gets_every_frame_once(
        routers in 1..7usize,
        connected in prop::collection::vec((0..7usize, 0..7usize), 0..14),
        behind in prop::collection::vec(0..7usize, 2..8),
        dead in prop::collection::vec(0..7usize, 0..3),
    ) {
        let mut pairs: Vec<[usize; 2]> = Vec::new();
        for (a, b) in connected {
            let (a, b) = (a % routers, b % routers);
            if a != b && !pairs.contains(&[a, b]) && !pairs.contains(&[b, a]) {
                pairs.push([a, b]);
            }
        }
        let behind: Vec<_> = behind.into_iter().map(|router| router % routers).collect();
        let dead: Vec<_> = dead.into_iter().map(|router| router % routers).collect();
        let mut plant = Plant::of(routers, &pairs, &behind);
        let mut expected = vec![Vec::new(); behind.len()];
        for phase in 0..3 {
            let alive = |router: usize| phase != 1 || !dead.contains(&router);
            for router in &dead {
                match phase {
                    1 => plant.world.kill_router(*router),
                    2 => plant.world.start_router(*router),
                    _ => {}
                }
            }
            plant.cycles(3);
            for (saw, router) in behind.iter().enumerate().skip(1) {
                if reaches(&pairs, &alive, behind[BELT], *router) {
                    expected[saw].extend(3 * phase..3 * phase + 3);
                }
            }
        }
        for (saw, expected) in expected.iter().enumerate().skip(1) {
            prop_assert_eq!(&plant.counts(saw), expected);
        }
    }
}

/// Reachability, by spreading from `from` until no new router is found.
fn reaches(pairs: &[[usize; 2]], alive: &dyn Fn(usize) -> bool, from: usize, to: usize) -> bool {
    let mut found: Vec<usize> = Some(from).filter(|from| alive(*from)).into_iter().collect();
    loop {
        let spread = pairs.iter().flat_map(|&[a, b]| [(a, b), (b, a)]);
        let new = spread
            .filter(|(a, b)| found.contains(a) && !found.contains(b))
            .map(|(_, b)| b)
            .find(|router| alive(*router));
        match new {
            Some(new) => found.push(new),
            None => return found.contains(&to),
        }
    }
}
