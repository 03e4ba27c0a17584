//! A small secure network on loopback: certificates and profiles as `coaxle secure init` makes them, sessions that
//! record received messages, and attackers whose own profile permits everything.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use coaxle::secure::{Member, SecureNetwork, profile, write_role};
use coaxle_host::network::credentials::{Authority, Validity};
use coaxle_host::network::transport::{
    Declared, OverZenoh, Publisher, Request, Transport, Urgency,
};
use coaxle_node::config::TransportConfig;
use coaxle_node::keys::NodeName;
use coaxle_os::machine;
use coaxle_tests::ports::free_port;

/// The configs of two senders and a receiver that follows both, and two operators: anna may command all nodes, bert
/// the first sender alone.
pub(crate) struct TestNetwork {
    scratch: tempfile::TempDir,
    pub(crate) authority: Authority,
    pub(crate) network: SecureNetwork,
    ports: [u16; 3],
    folders: std::cell::Cell<u32>,
}

pub(crate) const NODES: [&str; 3] = ["line", "press", "saw"];

impl TestNetwork {
    pub(crate) fn new() -> Self {
        let scratch = tempfile::tempdir().expect("a scratch folder");
        let ports = [(); 3].map(|()| free_port());
        let [line, press, saw] = ports;
        let axis = "[[axis]]\nid = 1\nname = 'x'\nprogram = { limits = { velocity = 1, acceleration = 1, jerk = 1 } }";
        let texts = [
            format!(
                "name = 'line'\ncycle-time-us = 2000\n{axis}\n[transport]\nlisten = ['tls/127.0.0.1:{line}']"
            ),
            format!(
                "name = 'press'\ncycle-time-us = 2000\n{axis}\n[transport]\nlisten = ['tls/127.0.0.1:{press}']"
            ),
            format!(
                "name = 'saw'\ncycle-time-us = 2000\n[[far]]\nnode = 'line'\n[[far]]\nnode = 'press'\n\
                 [[slave]]\nname = 'carriage'\nmaster = 'line.1'\ncouple = 'off'\n\
                 limits = {{ velocity = 500, acceleration = 2000, jerk = 1e5 }}\n[transport]\n\
                 listen = ['tls/127.0.0.1:{saw}']\n\
                 connect = ['tls/127.0.0.1:{line}', 'tls/127.0.0.1:{press}']"
            ),
        ];
        let members = NODES.iter().zip(texts).map(|(node, text)| {
            let file = scratch.path().join(format!("{node}.toml"));
            std::fs::write(&file, text).expect("a config");
            Member::load(&file).expect("a node")
        });
        let operators = ["anna", "bert=line"].map(|text| text.parse().expect("an operator"));
        let network =
            SecureNetwork::new(members.collect(), operators.into(), &[]).expect("a network");
        Self {
            authority: Authority::new(year()).expect("an authority"),
            scratch,
            network,
            ports,
            folders: std::cell::Cell::new(0),
        }
    }

    /// Endpoint of a node, over TLS or another protocol.
    pub(crate) fn endpoint(&self, protocol: &str, node: &str) -> String {
        let n = NODES
            .iter()
            .position(|known| *known == node)
            .expect("a node");
        format!("{protocol}/127.0.0.1:{}", self.ports[n])
    }

    /// The folder of a member.
    pub(crate) fn folder(&self, name: &str) -> PathBuf {
        let rights = profile(&self.network, &node(name)).expect("a member");
        self.folder_with(name, &self.authority, year(), &rights)
    }

    /// A folder for a member with a certificate of this authority, which trusts ours.
    pub(crate) fn folder_with(
        &self,
        name: &str,
        authority: &Authority,
        validity: Validity,
        rights: &str,
    ) -> PathBuf {
        self.folders.set(self.folders.get() + 1);
        let folder = self
            .scratch
            .path()
            .join(format!("{name}-{}", self.folders.get()));
        let hosts = ["127.0.0.1".to_owned()];
        let issued = authority
            .issue(&node(name), &hosts, validity)
            .expect("a certificate");
        write_role(&folder, &self.authority, &issued, rights).expect("a folder");
        folder
    }

    /// A member that keeps to its profile, with its config.
    pub(crate) fn member(&self, name: &str) -> Session {
        let known = self
            .network
            .nodes()
            .iter()
            .find(|node| node.name.as_str() == name);
        let (listen, connect) = known.map_or_else(Default::default, |node| {
            (node.listen.clone(), node.connect.clone())
        });
        Session::open(&TransportConfig {
            secure: Some(self.folder(name)),
            listen,
            connect,
            ..TransportConfig::default()
        })
    }

    /// A member with certificates only, as if no rights were needed.
    pub(crate) fn member_without_rights(&self, name: &str) -> Session {
        let known = self
            .network
            .nodes()
            .iter()
            .find(|node| node.name.as_str() == name);
        let known = known.expect("a node");
        Session::open(&TransportConfig {
            secure: Some(self.folder_with(name, &self.authority, year(), LAWLESS)),
            listen: known.listen.clone(),
            connect: known.connect.clone(),
            ..TransportConfig::default()
        })
    }

    /// An attacker with a certificate of ours that sends any message to a node.
    pub(crate) fn rogue(&self, name: &str, to: &str) -> Session {
        self.rogue_with(name, to, &self.authority, year())
    }

    /// Opens a session of such an attacker, at the endpoint of the node of its name.
    pub(crate) fn rogue_at(&self, name: &str) -> Session {
        Session::open(&TransportConfig {
            secure: Some(self.folder_with(name, &self.authority, year(), LAWLESS)),
            listen: vec![self.endpoint("tls", name)],
            ..TransportConfig::default()
        })
    }

    pub(crate) fn rogue_with(
        &self,
        name: &str,
        to: &str,
        authority: &Authority,
        validity: Validity,
    ) -> Session {
        Session::open(&TransportConfig {
            secure: Some(self.folder_with(name, authority, validity, LAWLESS)),
            connect: vec![self.endpoint("tls", to)],
            ..TransportConfig::default()
        })
    }

    /// A client without a certificate, which trusts our authority.
    pub(crate) fn nameless(&self, to: &str) -> Session {
        let authority = self.folder("saw").join("ca.pem");
        let authority = toml::Value::from(authority.to_str().expect("a plain path"));
        let settings = [(
            "transport/link/tls/root_ca_certificate".to_owned(),
            authority,
        )];
        Session::open(&TransportConfig {
            connect: vec![self.endpoint("tls", to)],
            settings: settings.into_iter().collect(),
            ..TransportConfig::default()
        })
    }

    /// A client without TLS.
    pub(crate) fn plain(&self, to: &str) -> Session {
        Session::open(&TransportConfig {
            connect: vec![self.endpoint("tcp", to)],
            ..TransportConfig::default()
        })
    }
}

/// TLS with the certificates beside it, without access control.
const LAWLESS: &str = "{ mode: 'peer', listen: { endpoints: [] }, transport: { link: { tls: { enable_mtls: true } } } }";

/// A session with all messages that reached it.
pub(crate) struct Session {
    transport: OverZenoh,
    seen: Seen,
    declared: Vec<Declared>,
    publishers: Vec<(String, Box<dyn Publisher>)>,
}

type Seen = Arc<Mutex<BTreeSet<String>>>;

impl Session {
    fn open(transport: &TransportConfig) -> Self {
        Self {
            transport: OverZenoh::open_and_wait(transport).expect("a session"),
            seen: Seen::default(),
            declared: Vec::new(),
            publishers: Vec::new(),
        }
    }

    /// Records messages published under a key as `key text`; for a long payload, its length.
    pub(crate) fn record(&mut self, key: &str) {
        let (seen, of) = (Arc::clone(&self.seen), key.to_owned());
        let keep = move |_, bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes);
            // Megabytes in the message of a failed test help nobody.
            let text = if text.len() < 100 {
                text.into_owned()
            } else {
                text.len().to_string()
            };
            note(&seen, format!("{of} {text}"));
        };
        let declared = self.transport.subscribe(key, Box::new(keep));
        self.declared.push(declared.expect("a subscription"));
    }

    /// Records that a key was announced.
    pub(crate) fn watch(&mut self, key: &str) {
        let seen = Arc::clone(&self.seen);
        let keep = move |key: &str, is_there| {
            if is_there {
                note(&seen, format!("{key} is there"));
            }
        };
        let declared = self.transport.watch(key, Box::new(keep));
        self.declared.push(declared.expect("a watch"));
    }

    /// Records requests, and replies to each.
    pub(crate) fn serve(&mut self, key: &str) {
        let seen = Arc::clone(&self.seen);
        let keep = move |_, request: Box<dyn Request>| {
            let text = String::from_utf8_lossy(&request.payload()).into_owned();
            note(&seen, format!("{} {text}", request.key()));
            request.reply("\"taken\"".to_owned(), true);
        };
        let declared = self.transport.serve(key, Box::new(keep));
        self.declared.push(declared.expect("a server"));
    }

    pub(crate) fn announce(&mut self, key: &str) {
        let declared = self.transport.announce(key);
        self.declared.push(declared.expect("an announcement"));
    }

    /// Publishes under a key, with or without subscribers.
    pub(crate) fn publish(&mut self, key: &str, text: &str) {
        if !self.publishers.iter().any(|(known, _)| known == key) {
            let publisher = self.transport.publisher(key, Urgency::RealTime);
            self.publishers
                .push((key.to_owned(), publisher.expect("a publisher")));
        }
        let publisher = self.publishers.iter().find(|(known, _)| known == key);
        let (_, publisher) = publisher.expect("just made");
        publisher
            .publish(text.as_bytes().to_vec())
            .expect("a session");
    }

    /// Sends a request. Returns the reply if there is one within a second.
    pub(crate) fn request(&self, key: &str, text: &str) -> Option<String> {
        let client = self
            .transport
            .client(key, Duration::from_secs(1))
            .expect("a client");
        let reply = client.request(text.to_owned()).expect("a session");
        reply.map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
    }

    pub(crate) fn saw(&self, what: &str) -> bool {
        lock(&self.seen).contains(what)
    }

    /// Every received message, for messages of failures.
    pub(crate) fn seen(&self) -> Vec<String> {
        lock(&self.seen).iter().cloned().collect()
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // Declarations end before their session.
        self.declared.clear();
        self.publishers.clear();
        self.transport.close();
    }
}

fn lock(seen: &Seen) -> std::sync::MutexGuard<'_, BTreeSet<String>> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}

fn note(seen: &Seen, what: String) {
    lock(seen).insert(what);
}

pub(crate) fn node(name: &str) -> NodeName {
    NodeName::new(name).expect("a name")
}

pub(crate) fn year() -> Validity {
    Validity::days(machine::wall_clock(), 365)
}

/// A validity that ended an hour ago.
pub(crate) fn expired() -> Validity {
    let hour = Duration::from_secs(3_600);
    let until = machine::wall_clock() - hour;
    let from: SystemTime = until - 24 * hour;
    Validity { from, until }
}
