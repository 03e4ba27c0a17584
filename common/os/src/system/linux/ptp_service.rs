//! `ptp4l` of linuxptp, by its socket on this machine.

use std::io;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::sync::atomic::{AtomicU32, Ordering};

use crate::ptp::{PtpService, PtpState, answer, request};

/// Its sockets: the one for reading alone, which others than root may use, and that for all.
const PATHS: [&str; 3] = ["/run/ptp4lro", "/var/run/ptp4lro", "/var/run/ptp4l"];

/// Connection to `ptp4l`.
#[derive(Debug)]
pub struct Ptp4l {
    socket: UnixDatagram,
    sequence: u16,
}

impl PtpService for Ptp4l {
    fn open() -> io::Result<Self> {
        // An address of its own to answer to, in the name space without files.
        static OPENED: AtomicU32 = AtomicU32::new(0);
        let number = OPENED.fetch_add(1, Ordering::Relaxed);
        let name = format!("coaxle-ptp-{}-{number}", std::process::id());
        let socket = UnixDatagram::bind_addr(&SocketAddr::from_abstract_name(name)?)?;
        socket.set_nonblocking(true)?;
        let mut refused = io::Error::from(io::ErrorKind::NotFound);
        for path in PATHS {
            match socket.connect(path) {
                Ok(()) => {
                    return Ok(Self {
                        socket,
                        sequence: 0,
                    });
                }
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => refused = error,
            }
        }
        Err(refused)
    }

    fn ask(&mut self) -> io::Result<()> {
        self.sequence = self.sequence.wrapping_add(1);
        self.socket.send(&request(self.sequence)).map(drop)
    }

    fn answer(&mut self) -> Option<PtpState> {
        let mut buffer = [0; 1500];
        let mut newest = None;
        while let Ok(length) = self.socket.recv(&mut buffer) {
            newest = answer(&buffer[..length]).or(newest);
        }
        newest
    }
}
