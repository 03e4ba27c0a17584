//! Settings of a measurement.

use std::net::{SocketAddr, TcpListener, UdpSocket};

use anyhow::Context;
use coaxle_clock::Span;
use coaxle_node::config::{RealTimeConfig, TransportConfig};
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

/// Number of ports that are tried.
// The system chooses them at random. A thousand are all taken by datagrams only if nearly all of them are.
const PORTS_TRIED: usize = 1_000;

/// An address of this machine that is free for connections as well as for datagrams: their ports are counted separately.
///
/// # Errors
/// The system has none.
pub(super) fn free_address() -> anyhow::Result<SocketAddr> {
    free_for_both(|| {
        // Port 0: the system chooses one. The socket is closed again, as the measured process binds the port itself.
        TcpListener::bind(("127.0.0.1", 0)).and_then(|listener| listener.local_addr())
    })
}

/// The first address chosen that is free for datagrams, too.
fn free_for_both(
    mut choose: impl FnMut() -> std::io::Result<SocketAddr>,
) -> anyhow::Result<SocketAddr> {
    let mut taken = None;
    for _ in 0..PORTS_TRIED {
        let address = choose().context("cannot find a free port")?;
        match UdpSocket::bind(address) {
            Ok(_) => return Ok(address),
            Err(error) => taken = Some(error),
        }
    }
    let taken = taken.map_or_else(|| anyhow::anyhow!("none was tried"), Into::into);
    Err(taken.context("cannot find a free port"))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_free_for_connections_and_for_datagrams() {
        let taken = UdpSocket::bind(("127.0.0.1", 0)).unwrap();
        let taken = taken.local_addr().unwrap();
        let mut chosen = [taken, free_address().unwrap()].into_iter();
        let free = free_for_both(|| Ok(chosen.next().unwrap())).unwrap();
        assert_ne!(free, taken);
        let refused = free_for_both(|| Ok(taken)).unwrap_err();
        assert!(format!("{refused:#}").starts_with("cannot find a free port: "));
    }
}
