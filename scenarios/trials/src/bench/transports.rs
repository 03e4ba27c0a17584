//! Age of the newest message over each transport, while packets are lost.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;

use anyhow::Context;
use coaxle_clock::Span;
use coaxle_host::network::credentials::{Authority, Validity};
use coaxle_node::config::TransportConfig;
use coaxle_node::keys::NodeName;
use coaxle_os::machine;
use serde::Serialize;

use super::namespace::{HERE, NetworkNamespace, THERE};
use super::pair::{Measured, Pair};
use super::plan::PeerPlan;
use super::quantiles::TimeQuantiles;
use super::settings::{BenchSettings, connecting, free_address, listening};
use super::turns::BenchProgress;

/// Results of all transports, at each loss.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Transports {
    pub(super) axes: u32,
    /// Length of a message.
    pub(super) bytes: usize,
    /// Reason why no packet is lost, if so.
    pub(super) without_loss: Option<String>,
    pub(super) rows: Vec<TransportResult>,
}

/// A transport at a loss.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct TransportResult {
    pub(super) transport: &'static str,
    /// Lost share of packets in each direction, 1: all.
    pub(super) loss: f64,
    /// Time since the wake-up of the loop that sent the newest message, sampled once a cycle.
    pub(super) age: Option<TimeQuantiles>,
    /// Messages received, of those that were sent from the first to the last of them, 1: all.
    pub(super) came: Option<f64>,
    /// Reason why it cannot be measured, if so.
    pub(super) failed: Option<String>,
}

/// A transport to compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BenchTransport {
    Datagrams,
    Tcp,
    Udp,
    Tls,
    Quic,
    UnixSocket,
}

const TRANSPORTS: [BenchTransport; 6] = [
    BenchTransport::Datagrams,
    BenchTransport::Tcp,
    BenchTransport::Udp,
    BenchTransport::Tls,
    BenchTransport::Quic,
    BenchTransport::UnixSocket,
];

impl BenchTransport {
    const fn name(self) -> &'static str {
        match self {
            Self::Datagrams => "datagrams, without Zenoh",
            Self::Tcp => "Zenoh, TCP",
            Self::Udp => "Zenoh, UDP",
            Self::Tls => "Zenoh, TLS",
            Self::Quic => "Zenoh, QUIC stream",
            Self::UnixSocket => "Zenoh, Unix socket",
        }
    }

    /// False for a transport within the machine, which loses nothing.
    fn can_lose(self) -> bool {
        self != Self::UnixSocket
    }
}

/// Connections may have to be made again while packets are lost.
// TCP waits 1 s, then 2 s, before it repeats a lost first packet (RFC 6298).
const WARM_UP: Span = Span::from_secs(3);

/// Planned time of the measurement.
pub(super) fn planned(settings: &BenchSettings, losses: &[f64]) -> Span {
    let cases = cases(losses).count() as i64;
    settings.time + WARM_UP * (cases * i64::from(settings.rounds))
}

/// Every transport at every loss that it can have.
fn cases(losses: &[f64]) -> impl Iterator<Item = (BenchTransport, f64)> {
    losses.iter().flat_map(|loss| {
        let ways = TRANSPORTS.iter();
        // A Unix socket passes no device whose packets could be dropped.
        let ways = ways.filter(|way| *loss <= 0.0 || way.can_lose());
        ways.map(|way| (*way, *loss))
    })
}

/// # Errors
/// Ctrl-C came, or nothing can be started at all. A transport that cannot be measured has a row with the reason.
pub(super) fn measure(
    settings: &BenchSettings,
    axes: u32,
    losses: &[f64],
    turns: &mut BenchProgress<'_>,
) -> anyhow::Result<Transports> {
    let bytes = settings.nodes(axes).frame_bytes()?;
    let (namespace, without_loss) = match NetworkNamespace::new() {
        Ok(namespace) => (Some(namespace), None),
        Err(missing) => (None, Some(format!("{missing:#}"))),
    };
    let all = losses;
    let losses = match namespace {
        Some(_) => losses,
        // Without a namespace there is a comparison without loss, and the reason is printed.
        None => &[0.0],
    };
    turns.forgo(planned(settings, all) - planned(settings, losses));
    let scratch = Scratch::new()?;
    let cases: Vec<_> = cases(losses).collect();
    let mut found = vec![TransportRounds::default(); cases.len()];
    let turn = settings.turn(cases.len() as i64);
    for _ in 0..settings.rounds {
        for ((way, loss), case) in cases.iter().zip(&mut found) {
            if let Some(namespace) = &namespace {
                // Set for each case: the cases of one round differ in their loss.
                namespace.lose(*loss)?;
            }
            let place = EndpointPair::of(*way, namespace.as_ref());
            // A new pair of processes each time: a connection that has slowed down after losses would carry over.
            let pair = pair(*way, settings, bytes, &place, &scratch)?;
            let end = turns.done() + WARM_UP + turn;
            match pair.measure(turn, turns) {
                Ok(measured) => case.add(&measured),
                Err(error) if error.is::<super::turns::MeasurementInterrupted>() => {
                    return Err(error);
                }
                Err(error) => {
                    case.failed = Some(format!("{error:#}"));
                    // Its turn is over, whenever it failed: the bar goes on with the next one.
                    turns.passed(end - turns.done())?;
                }
            }
        }
    }
    let rows = cases.iter().zip(&found);
    Ok(Transports {
        axes,
        bytes,
        without_loss,
        rows: rows
            .map(|((way, loss), case)| case.row(*way, *loss))
            .collect(),
    })
}

/// Results of the rounds of a transport at a loss.
#[derive(Clone, Debug, Default)]
struct TransportRounds {
    ages: Vec<i64>,
    came: u64,
    sent: u64,
    failed: Option<String>,
}

impl TransportRounds {
    fn add(&mut self, measured: &Measured) {
        let received = &measured.receiver;
        self.ages.extend(received.looks.iter().map(|look| look.age));
        let mut counts: Vec<u64> = received.messages.iter().map(|m| m.count).collect();
        counts.sort_unstable();
        // UDP may deliver a datagram twice.
        counts.dedup();
        if let (Some(first), Some(last)) = (counts.first(), counts.last()) {
            self.came += counts.len() as u64;
            // Between the first and the last that arrived: before, the ends had not met, and afterwards the receiver was gone.
            self.sent += last - first + 1;
        }
    }

    fn row(&self, way: BenchTransport, loss: f64) -> TransportResult {
        TransportResult {
            transport: way.name(),
            loss,
            age: TimeQuantiles::of(self.ages.iter().copied()),
            came: (self.sent > 0).then(|| self.came as f64 / self.sent as f64),
            failed: self.failed.clone(),
        }
    }
}

/// Addresses of both ends.
struct EndpointPair {
    address: SocketAddr,
    /// Destination of datagrams: the receiving end.
    far: SocketAddr,
    before_receiver: Vec<String>,
}

impl EndpointPair {
    fn of(way: BenchTransport, namespace: Option<&NetworkNamespace>) -> Self {
        // Free on this machine, where the sending end listens. The namespace is new: all its ports are free.
        let port = free_address().map_or(7447, |address| address.port());
        let ends = |near: Ipv4Addr, far: Ipv4Addr, before_receiver| Self {
            address: (near, port).into(),
            far: (far, port).into(),
            before_receiver,
        };
        match namespace.filter(|_| way.can_lose()) {
            Some(namespace) => ends(HERE, THERE, namespace.prefix()),
            None => ends(Ipv4Addr::LOCALHOST, Ipv4Addr::LOCALHOST, Vec::new()),
        }
    }
}

fn pair(
    way: BenchTransport,
    settings: &BenchSettings,
    bytes: usize,
    place: &EndpointPair,
    scratch: &Scratch,
) -> anyhow::Result<Pair> {
    let pace = settings.pace(bytes);
    let looks = Some(pace);
    let over = |[sender, receiver]: [TransportConfig; 2]| {
        let sender = PeerPlan::ZenohSender {
            transport: sender,
            pace,
        };
        let receiver = PeerPlan::ZenohReceiver {
            transport: receiver,
            real_time: settings.real_time,
            looks,
        };
        Pair::new(sender, receiver)
    };
    let address = place.address;
    let both = |endpoint: &str| [listening(endpoint), connecting(endpoint)];
    let mut pair = match way {
        BenchTransport::Datagrams => {
            let sender = PeerPlan::UdpSender {
                to: place.far,
                pace,
            };
            let at = place.far;
            Pair::new(sender, PeerPlan::UdpReceiver { at, looks })
        }
        BenchTransport::Tcp => over(both(&format!("tcp/{address}"))),
        BenchTransport::Udp => over(both(&format!("udp/{address}"))),
        BenchTransport::Tls => over(scratch.with_certificates(both(&format!("tls/{address}")))?),
        BenchTransport::Quic => over(scratch.with_certificates(both(&format!("quic/{address}")))?),
        BenchTransport::UnixSocket => over(both(&scratch.socket(address.port()))),
    };
    pair.before_receiver.clone_from(&place.before_receiver);
    pair.warm_up = WARM_UP;
    Ok(pair)
}

/// A folder for certificates and sockets, until it is dropped.
struct Scratch {
    folder: std::path::PathBuf,
}

const AUTHORITY: &str = "ca.pem";
const CERTIFICATE: &str = "cert.pem";
const KEY: &str = "key.pem";

impl Scratch {
    fn new() -> anyhow::Result<Self> {
        use coaxle_os::{Os, Readers, System};
        use std::io::Write;
        // A short path: that of a Unix socket has at most 107 bytes.
        let folder = std::env::temp_dir().join(format!("coaxle-bench-{}", std::process::id()));
        let scratch = Self { folder };
        let folder = &scratch.folder;
        let cannot = || format!("cannot use the folder {}", folder.display());
        Os::make_private_folder(folder).with_context(cannot)?;
        let validity = Validity::days(machine::wall_clock(), 1);
        let authority = Authority::new(validity)?;
        // The listening end is at the near end of the cable, or at home without one; its certificate must name both.
        let hosts = [HERE, Ipv4Addr::LOCALHOST].map(|host| host.to_string());
        let issued = authority.issue(&NodeName::new("bench")?, &hosts, validity)?;
        for (name, text) in [
            (AUTHORITY, authority.certificate()),
            (CERTIFICATE, &issued.certificate),
            (KEY, &issued.key),
        ] {
            let file = Os::create_file(&folder.join(name), Readers::Owner);
            let written = file.and_then(|mut file| file.write_all(text.as_bytes()));
            written.with_context(cannot)?;
        }
        Ok(scratch)
    }

    fn socket(&self, number: u16) -> String {
        let path = self.folder.join(format!("{number}.sock"));
        format!("unixsock-stream/{}", path.display())
    }

    /// A session over TLS or QUIC between both ends, with certificates of both, as a secure network has them.
    fn with_certificates(
        &self,
        ends: [TransportConfig; 2],
    ) -> anyhow::Result<[TransportConfig; 2]> {
        let text = |path: &Path| path.display().to_string();
        let mut settings = toml::Table::new();
        settings.insert("transport/link/tls/enable_mtls".to_owned(), true.into());
        for (setting, file) in [
            ("root_ca_certificate", AUTHORITY),
            ("listen_certificate", CERTIFICATE),
            ("listen_private_key", KEY),
            ("connect_certificate", CERTIFICATE),
            ("connect_private_key", KEY),
        ] {
            let path = format!("transport/link/tls/{setting}");
            settings.insert(path, text(&self.folder.join(file)).into());
        }
        Ok(ends.map(|end| TransportConfig {
            settings: settings.clone(),
            ..end
        }))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::plan::{AgeSample, MessageArrival, PeerReport};

    #[test]
    fn what_never_leaves_the_machine_is_tried_without_loss_alone() {
        let all: Vec<_> = cases(&[0.0, 0.05]).collect();
        assert_eq!(all.len(), 2 * TRANSPORTS.len() - 1);
        assert!(!all.contains(&(BenchTransport::UnixSocket, 0.05)));
    }

    #[test]
    fn a_message_that_came_twice_came_once() {
        let message = |count| MessageArrival {
            count,
            woke: 0,
            left: 0,
            arrived: 0,
        };
        let measured = Measured {
            receiver: PeerReport {
                messages: [3, 4, 4, 6].map(message).into(),
                looks: vec![AgeSample { at: 9, age: 2_000 }],
                ..PeerReport::default()
            },
            ..Measured::default()
        };
        let mut case = TransportRounds::default();
        case.add(&measured);
        let row = case.row(BenchTransport::Tcp, 0.0);
        // 3, 4 and 6 of the four from 3 to 6.
        assert_eq!(row.came, Some(0.75));
        assert_eq!(row.age.unwrap().max_us, 2.0);
        assert_eq!(
            TransportRounds::default()
                .row(BenchTransport::Udp, 0.1)
                .came,
            None
        );
    }
}
