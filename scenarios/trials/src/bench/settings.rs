//! Settings of a measurement.

use std::net::{Ipv4Addr, SocketAddr};

use anyhow::Context;
use coaxle_clock::Span;
use coaxle_node::config::{RealTimeConfig, TransportConfig};
use coaxle_os::ClaimedPort;
use serde::Serialize;

use super::configs::NodesConfig;
use super::plan::LoopPace;

/// Settings that all parts share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BenchSettings {
    /// Cycle of every loop.
    pub(super) cycle: Span,
    /// Time that each part measures.
    pub(super) time: Span,
    /// Number of rounds.
    pub(super) rounds: u32,
    pub(super) real_time: RealTimeConfig,
}

/// Settings as shown beside the figures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct PrintedSettings {
    cycle_us: f64,
    seconds: f64,
    rounds: u32,
    priority: Option<u8>,
}

impl BenchSettings {
    /// Time that one of this many contenders is measured in each round.
    pub(super) fn turn(&self, contenders: i64) -> Span {
        // The time is that of a part: more contenders or rounds make turns shorter, not the part longer.
        Span::from_nanos(self.time.as_nanos() / (contenders * i64::from(self.rounds)))
    }

    /// Time that this many contenders take in all rounds, each with its warm-up.
    pub(super) fn planned(&self, contenders: i64, warm_up: Span) -> Span {
        (self.turn(contenders) + warm_up) * contenders * i64::from(self.rounds)
    }

    pub(super) fn nodes(&self, axes: u32) -> NodesConfig {
        NodesConfig {
            cycle: self.cycle,
            axes,
            real_time: self.real_time,
        }
    }

    pub(super) fn pace(&self, bytes: usize) -> LoopPace {
        LoopPace {
            cycle_ns: self.cycle.as_nanos(),
            bytes,
            real_time: self.real_time,
        }
    }

    pub(super) fn shown(&self) -> PrintedSettings {
        PrintedSettings {
            cycle_us: self.cycle.as_nanos() as f64 / 1e3,
            seconds: self.time.as_secs_f64(),
            rounds: self.rounds,
            priority: self.real_time.priority,
        }
    }
}

/// An address of this machine that is free for connections as well as for datagrams.
///
/// # Errors
/// The system has none.
pub(super) fn free_address() -> anyhow::Result<SocketAddr> {
    let port = ClaimedPort::find().context("cannot find a free port")?;
    Ok((Ipv4Addr::LOCALHOST, port.keep()).into())
}

/// A session that listens there.
pub(super) fn listening(endpoint: &str) -> TransportConfig {
    TransportConfig {
        listen: vec![endpoint.to_owned()],
        ..TransportConfig::default()
    }
}

/// A session that connects to there.
pub(super) fn connecting(endpoint: &str) -> TransportConfig {
    TransportConfig {
        connect: vec![endpoint.to_owned()],
        ..TransportConfig::default()
    }
}
