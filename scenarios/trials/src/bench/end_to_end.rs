//! Latency of a sample between two processes: as a datagram, over Zenoh alone, and between our nodes.

use std::collections::BTreeMap;

use coaxle_clock::Span;
use serde::Serialize;

use super::pair::{Measured, Pair, WARM_UP};
use super::plan::{PeerPlan, PeerReport};
use super::quantiles::{MedianRatio, TimeQuantiles};
use super::settings::{BenchSettings, connecting, free_address, listening};
use super::turns::BenchProgress;

/// Latencies one way over loopback, from the wake-up of the loop that sends.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct EndToEnd {
    /// Length of a message, equal for all.
    pub(super) bytes: usize,
    pub(super) axes: u32,
    /// From the wake-up to the arrival.
    pub(super) udp: Option<TimeQuantiles>,
    pub(super) zenoh: Option<TimeQuantiles>,
    pub(super) nodes: Option<TimeQuantiles>,
    /// From handing over to the network to the arrival alone.
    pub(super) zenoh_network: Option<TimeQuantiles>,
    pub(super) stages: Stages,
    pub(super) ratios: LatencyRatios,
    /// Requests for real time that the system did not grant.
    pub(super) denied: Vec<String>,
}

/// Stages of the latency between our nodes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Stages {
    /// From the ideal start of the sender's cycle to its wake-up.
    pub(super) wake_up: Option<TimeQuantiles>,
    /// To the frame in the outbox.
    pub(super) scan: Option<TimeQuantiles>,
    /// To the publisher that has it.
    pub(super) hand_over: Option<TimeQuantiles>,
    /// To the stamp on arrival.
    pub(super) network: Option<TimeQuantiles>,
    /// To the beginning of the scan that takes it in.
    pub(super) wait: Option<TimeQuantiles>,
    /// From the wake-up of the sender to the beginning of that scan.
    pub(super) to_scan: Option<TimeQuantiles>,
}

/// Over Zenoh alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct LatencyRatios {
    /// Our nodes, from wake-up to arrival.
    pub(super) nodes: Option<MedianRatio>,
    /// Our nodes, from handing over to the network to the arrival.
    pub(super) network: Option<MedianRatio>,
    /// Datagrams, from wake-up to arrival.
    pub(super) udp: Option<MedianRatio>,
}

/// Datagrams, Zenoh alone, our nodes.
const CONTENDERS: i64 = 3;

/// Planned time of the measurement.
pub(super) fn planned(settings: &BenchSettings) -> Span {
    settings.planned(CONTENDERS, WARM_UP)
}

/// # Errors
/// A process fails, or Ctrl-C came.
pub(super) fn measure(
    settings: &BenchSettings,
    axes: u32,
    turns: &mut BenchProgress<'_>,
) -> anyhow::Result<EndToEnd> {
    // All contenders carry messages of this length: latency and load grow with it.
    let bytes = settings.nodes(axes).frame_bytes()?;
    let turn = settings.turn(CONTENDERS);
    let mut ways = LatencyRounds::default();
    for round in 0..settings.rounds {
        // Each contender is first as often as last.
        for place in 0..CONTENDERS {
            // The order rotates by one each round: none is always measured in the wake of the same other one.
            match (place + i64::from(round)) % CONTENDERS {
                0 => ways.udp.add(&udp(settings, bytes)?.measure(turn, turns)?),
                1 => ways
                    .zenoh
                    .add(&zenoh(settings, bytes)?.measure(turn, turns)?),
                _ => ways
                    .nodes
                    .add(&nodes(settings, axes, true)?.measure(turn, turns)?),
            }
        }
    }
    // Quantiles come after the last round only, because a median of medians is no median.
    Ok(ways.summed_up(bytes, axes))
}

/// Datagrams.
pub(super) fn udp(settings: &BenchSettings, bytes: usize) -> anyhow::Result<Pair> {
    let at = free_address()?;
    let pace = settings.pace(bytes);
    let sender = PeerPlan::UdpSender { to: at, pace };
    Ok(Pair::new(sender, PeerPlan::UdpReceiver { at, looks: None }))
}

/// Zenoh alone.
pub(super) fn zenoh(settings: &BenchSettings, bytes: usize) -> anyhow::Result<Pair> {
    let endpoint = format!("tcp/{}", free_address()?);
    let sender = PeerPlan::ZenohSender {
        transport: listening(&endpoint),
        pace: settings.pace(bytes),
    };
    let receiver = PeerPlan::ZenohReceiver {
        transport: connecting(&endpoint),
        real_time: settings.real_time,
        looks: None,
    };
    Ok(Pair::new(sender, receiver))
}

/// Our nodes; with stamps of every step, or just as they are.
pub(super) fn nodes(settings: &BenchSettings, axes: u32, stamps: bool) -> anyhow::Result<Pair> {
    let endpoint = format!("tcp/{}", free_address()?);
    let nodes = settings.nodes(axes);
    let sender = PeerPlan::Sender {
        config: nodes.sender(Some(&endpoint))?,
        stamps,
    };
    let config = nodes.receiver(&endpoint)?;
    Ok(Pair::new(sender, PeerPlan::Receiver { config }))
}

/// Measurements of all rounds, ns.
#[derive(Default)]
struct LatencyRounds {
    udp: BareLatencies,
    zenoh: BareLatencies,
    nodes: NodeLatencies,
}

/// Latencies of a bare loop, in each round.
#[derive(Default)]
struct BareLatencies {
    one_way: Vec<Vec<i64>>,
    network: Vec<Vec<i64>>,
    denied: Vec<String>,
}

impl BareLatencies {
    fn add(&mut self, measured: &Measured) {
        let messages = &measured.receiver.messages;
        self.one_way
            .push(messages.iter().map(|m| m.arrived - m.woke).collect());
        self.network
            .push(messages.iter().map(|m| m.arrived - m.left).collect());
        self.denied = measured.denied().cloned().collect();
    }
}

/// Latencies of our nodes.
#[derive(Default)]
struct NodeLatencies {
    one_way: Vec<Vec<i64>>,
    network: Vec<Vec<i64>>,
    wake_up: Vec<i64>,
    scan: Vec<i64>,
    hand_over: Vec<i64>,
    wait: Vec<i64>,
    to_scan: Vec<i64>,
}

impl NodeLatencies {
    fn add(&mut self, measured: &Measured) {
        let (mut one_way, mut network) = (Vec::new(), Vec::new());
        for stamps in frame_stamps(&measured.sender, &measured.receiver) {
            one_way.push(stamps.arrived - stamps.woke);
            network.push(stamps.arrived - stamps.left);
            self.wake_up.push(stamps.woke - stamps.ideal);
            self.scan.push(stamps.handed_over - stamps.woke);
            self.hand_over.push(stamps.left - stamps.handed_over);
            self.wait.push(stamps.used - stamps.arrived);
            self.to_scan.push(stamps.used - stamps.woke);
        }
        self.one_way.push(one_way);
        self.network.push(network);
    }

    fn stages(&self) -> Stages {
        let of = |nanos: &[i64]| TimeQuantiles::of(nanos.iter().copied());
        Stages {
            wake_up: of(&self.wake_up),
            scan: of(&self.scan),
            hand_over: of(&self.hand_over),
            network: of(&self.network.concat()),
            wait: of(&self.wait),
            to_scan: of(&self.to_scan),
        }
    }
}

/// The stamps of a frame, from the cycle that made it to the scan that used it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FrameStamps {
    ideal: i64,
    woke: i64,
    handed_over: i64,
    left: i64,
    arrived: i64,
    used: i64,
}

/// Stamps of every received frame whose cycle is known.
fn frame_stamps<'a>(
    sender: &'a PeerReport,
    receiver: &'a PeerReport,
) -> impl Iterator<Item = FrameStamps> + 'a {
    let cycles: BTreeMap<u64, _> = sender.cycles.iter().map(|c| (c.count, c)).collect();
    receiver.frames.iter().filter_map(move |frame| {
        // A cycle that the recorder did not get has no stamps to join.
        let cycle = cycles.get(&frame.count)?;
        Some(FrameStamps {
            ideal: cycle.ideal,
            woke: cycle.woke,
            handed_over: cycle.handed_over,
            // A send stamp counts from the ideal start of its cycle (docs/WIRE.md).
            left: cycle.ideal + frame.left_after,
            arrived: frame.arrived,
            used: frame.used,
        })
    })
}

impl LatencyRounds {
    fn summed_up(&self, bytes: usize, axes: u32) -> EndToEnd {
        let Self { udp, zenoh, nodes } = self;
        let all = |rounds: &[Vec<i64>]| TimeQuantiles::of(rounds.concat());
        EndToEnd {
            bytes,
            axes,
            udp: all(&udp.one_way),
            zenoh: all(&zenoh.one_way),
            nodes: all(&nodes.one_way),
            zenoh_network: all(&zenoh.network),
            stages: nodes.stages(),
            ratios: LatencyRatios {
                nodes: MedianRatio::of(&nodes.one_way, &zenoh.one_way),
                network: MedianRatio::of(&nodes.network, &zenoh.network),
                udp: MedianRatio::of(&udp.one_way, &zenoh.one_way),
            },
            denied: zenoh.denied.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::plan::{CycleStamps, FrameArrival};

    #[test]
    fn a_frame_finds_its_cycle_by_its_count() {
        let cycle = |count| CycleStamps {
            count,
            ideal: 1_000 * count as i64,
            woke: 1_000 * count as i64 + 50,
            handed_over: 1_000 * count as i64 + 52,
        };
        let frame = |count| FrameArrival {
            count,
            left_after: 80,
            arrived: 1_000 * count as i64 + 180,
            used: 1_000 * count as i64 + 500,
        };
        let measured = Measured {
            sender: PeerReport {
                cycles: (1..=3).map(cycle).collect(),
                ..PeerReport::default()
            },
            receiver: PeerReport {
                frames: [2, 3, 4].map(frame).into(),
                ..PeerReport::default()
            },
            load: None,
        };
        let mut ours = NodeLatencies::default();
        ours.add(&measured);
        assert_eq!(
            (&ours.one_way, &ours.network),
            (&vec![vec![130; 2]], &vec![vec![100; 2]])
        );
        assert_eq!((&ours.wake_up, &ours.scan), (&vec![50; 2], &vec![2; 2]));
        assert_eq!((&ours.hand_over, &ours.wait), (&vec![28; 2], &vec![320; 2]));
        // Differences of the stamps above, from 50 to 500; frame 4 has no cycle.
        assert_eq!(ours.to_scan, [450; 2]);
    }
}
