//! A PLC with an AMS/TCP server, always at hand: commands 2 to 4, 6, 7, 9 and notifications.

use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard};

use coaxle_axis::{ImageLayout, NcToPlcAxis, StateWord};
use coaxle_gateway::ams::{
    ADD_NOTIFICATION, DELETE_NOTIFICATION, HANDLE_BY_NAME, NOTIFICATION, Packet, READ, READ_STATE,
    READ_WRITE, REPLY, REQUEST, VALUE_BY_HANDLE, WRITE, take_packet,
};

/// Cycle time of the PLC, s.
pub(crate) const CYCLE_S: f64 = 0.004;
/// The error of a symbol that is not there.
const NO_SYMBOL: u32 = 0x710;

/// A PLC whose axis advances by one each cycle.
pub(crate) struct Plc {
    address: SocketAddr,
    state: Arc<Mutex<State>>,
}

struct State {
    variables: Vec<(String, Vec<u8>)>,
    connections: Vec<Connection>,
    cycle: u64,
    is_stopped: bool,
    talks_nonsense: bool,
    is_away: bool,
}

struct Connection {
    stream: TcpStream,
    /// Addresses of its first packet.
    ends: Option<Ends>,
    notified: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Ends {
    plc: coaxle_gateway::ams::AmsAddress,
    client: coaxle_gateway::ams::AmsAddress,
}

impl Plc {
    pub(crate) fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("it is there");
        let address = listener.local_addr().expect("it is there");
        let lengths = [
            ("n", 2),
            ("a", 128),
            ("c", 128),
            ("e", 28),
            ("m", 2),
            ("s", 128),
            ("k", 2),
        ];
        let variables = lengths.map(|(name, length)| (format!("G.{name}"), vec![0; length]));
        let state = Arc::new(Mutex::new(State {
            variables: variables.into(),
            connections: Vec::new(),
            // Shortly before the index wraps, so that every test passes the wrap.
            cycle: 65_500,
            is_stopped: false,
            talks_nonsense: false,
            is_away: false,
        }));
        let of_server = Arc::clone(&state);
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let state = Arc::clone(&of_server);
                std::thread::spawn(move || serve(stream, &state));
            }
        });
        let plc = Self { address, state };
        // A first cycle, or the first read would find an image of zeros.
        plc.step();
        plc
    }

    /// Sets its runtime to stop.
    pub(crate) fn stop(&self) {
        self.lock().is_stopped = true;
    }

    /// Sets its runtime to run again.
    pub(crate) fn run(&self) {
        self.lock().is_stopped = false;
    }

    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Runs the next cycle: index, axes, notifications.
    pub(crate) fn step(&self) {
        let mut state = self.lock();
        state.cycle += 1;
        let (index, position) = (state.cycle as u16, state.cycle as f64);
        let image = |position| {
            let axis = NcToPlcAxis {
                state_word: StateWord::OPERATIONAL | StateWord::HOMED,
                set_position: position,
                set_velocity: 1.0 / CYCLE_S,
                ..NcToPlcAxis::default()
            };
            axis.to_image(ImageLayout::AxisRef).to_vec()
        };
        state.set("G.n", index.to_le_bytes().to_vec());
        state.set("G.a", image(position));
        state.notify();
    }

    pub(crate) fn value(&self, name: &str) -> Vec<u8> {
        let state = self.lock();
        let found = state.variables.iter().find(|(known, _)| known == name);
        found.expect("it is there").1.clone()
    }

    /// Position of its axis.
    pub(crate) fn position(&self) -> f64 {
        self.lock().cycle as f64
    }

    pub(crate) fn talk_nonsense(&self) {
        self.lock().talks_nonsense = true;
        self.drop_connections();
    }

    pub(crate) fn hang_up(&self) {
        self.lock().is_away = true;
        self.drop_connections();
    }

    /// Accepts connections again.
    pub(crate) fn come_back(&self) {
        self.lock().is_away = false;
    }

    fn drop_connections(&self) {
        for connection in self.lock().connections.drain(..) {
            let _ = connection.stream.shutdown(Shutdown::Both);
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("it is there")
    }
}

impl State {
    fn set(&mut self, name: &str, value: Vec<u8>) {
        if let Some((_, held)) = self.variables.iter_mut().find(|(known, _)| known == name) {
            *held = value;
        }
    }

    /// Sends all notifications of this cycle, with one stamp.
    fn notify(&mut self) {
        // FILETIME counts 100 ns: 4 ms are 40 000.
        let stamp = self.cycle * 40_000 + 1;
        for connection in &mut self.connections {
            let Some(ends) = connection.ends.filter(|_| !connection.notified.is_empty()) else {
                continue;
            };
            let mut samples = Vec::new();
            for handle in &connection.notified {
                let value = &self.variables[*handle as usize].1;
                // The handle of a notification is that of the variable and 1000.
                samples.extend_from_slice(&(handle + 1_000).to_le_bytes());
                samples.extend_from_slice(&(value.len() as u32).to_le_bytes());
                samples.extend_from_slice(value);
            }
            let mut data = Vec::new();
            // Length of all behind it: number of stamps, stamp, number of samples, samples.
            data.extend_from_slice(&(samples.len() as u32 + 16).to_le_bytes());
            data.extend_from_slice(&1_u32.to_le_bytes());
            data.extend_from_slice(&stamp.to_le_bytes());
            data.extend_from_slice(&(connection.notified.len() as u32).to_le_bytes());
            data.extend_from_slice(&samples);
            let mut bytes = Vec::new();
            Packet {
                target: ends.client,
                source: ends.plc,
                command: NOTIFICATION,
                flags: REQUEST,
                error: 0,
                invoke: 0,
                data: &data,
            }
            .write(&mut bytes);
            let _ = connection.stream.write_all(&bytes);
        }
    }

    /// The data of a reply.
    fn answer(&mut self, port: u16, command: u16, data: &[u8]) -> Vec<u8> {
        let number =
            |n: usize| u32::from_le_bytes(data[4 * n..4 * n + 4].try_into().expect("it is there"));
        let refused = NO_SYMBOL.to_le_bytes().to_vec();
        let good = |rest: &[u8]| [&[0; 4][..], rest].concat();
        match command {
            // 5 is run, 6 is stop (ADSSTATE).
            READ_STATE => good(&[if self.is_stopped { 6 } else { 5 }, 0, 0, 0]),
            READ_WRITE if number(0) == HANDLE_BY_NAME => {
                let name = String::from_utf8_lossy(&data[16..]).into_owned();
                let found = self.variables.iter().position(|(known, _)| *known == name);
                found.map_or(refused, |handle| {
                    good(&[4_u32.to_le_bytes(), (handle as u32).to_le_bytes()].concat())
                })
            }
            READ if number(0) == VALUE_BY_HANDLE => {
                let value = &self.variables[number(1) as usize].1;
                good(&[&(value.len() as u32).to_le_bytes()[..], value].concat())
            }
            WRITE if number(0) == VALUE_BY_HANDLE => {
                self.variables[number(1) as usize].1 = data[12..].to_vec();
                good(&[])
            }
            WRITE => good(&[]),
            ADD_NOTIFICATION => {
                let handle = number(1);
                if let Some(connection) = self.of(port) {
                    connection.notified.push(handle);
                }
                good(&(handle + 1_000).to_le_bytes())
            }
            DELETE_NOTIFICATION => {
                let handle = number(0) - 1_000;
                if let Some(connection) = self.of(port) {
                    connection.notified.retain(|notified| *notified != handle);
                }
                good(&[])
            }
            other => panic!("command {other}"),
        }
    }

    /// The connection to this TCP port.
    fn of(&mut self, port: u16) -> Option<&mut Connection> {
        let is_it = |connection: &&mut Connection| {
            let peer = connection.stream.peer_addr();
            peer.is_ok_and(|peer| peer.port() == port)
        };
        self.connections.iter_mut().find(is_it)
    }
}

fn serve(mut stream: TcpStream, state: &Mutex<State>) {
    let Ok(peer) = stream.peer_addr() else {
        return;
    };
    // Notifications and replies must not wait for each other's acknowledgements.
    stream.set_nodelay(true).expect("it is there");
    if state.lock().expect("it is there").is_away {
        return;
    }
    if state.lock().expect("it is there").talks_nonsense {
        // A header that announces 3 bytes, fewer than any packet has.
        let _ = stream.write_all(&[0, 0, 3, 0, 0, 0, 1, 2, 3]);
        return;
    }
    state
        .lock()
        .expect("it is there")
        .connections
        .push(Connection {
            stream: stream.try_clone().expect("it is there"),
            ends: None,
            notified: Vec::new(),
        });
    let (mut received, mut bytes) = (Vec::new(), [0; 4096]);
    while let Ok(length @ 1..) = stream.read(&mut bytes) {
        received.extend_from_slice(&bytes[..length]);
        while let Some((packet, end)) = take_packet(&received).expect("it is there") {
            let packet = packet.expect("it is there");
            let mut state = state.lock().expect("it is there");
            let data = state.answer(peer.port(), packet.command, packet.data);
            let mut reply = Vec::new();
            Packet {
                target: packet.source,
                source: packet.target,
                flags: REPLY,
                data: &data,
                ..packet
            }
            .write(&mut reply);
            let ends = Some(Ends {
                plc: packet.target,
                client: packet.source,
            });
            if let Some(connection) = state.of(peer.port()) {
                connection.ends = ends;
            }
            // Within the lock: a notification must not lie in the middle of it.
            let _ = stream.write_all(&reply);
            drop(state);
            received.drain(..end);
        }
    }
}
