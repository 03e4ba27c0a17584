//! `ptp4l` of linuxptp, by its socket on this machine.

use std::io;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::ptp::{PtpService, PtpState, answer, request};

/// Sockets of `ptp4l`: the one for reading alone, which others than root may use, and that for all.
const PATHS: [&str; 2] = ["/var/run/ptp4lro", "/var/run/ptp4l"];

/// Connection to `ptp4l`.
#[derive(Debug)]
pub struct Ptp4l {
    socket: UnixDatagram,
    sequence: u16,
    /// File of the own address, if it has one.
    file: Option<PathBuf>,
}

impl PtpService for Ptp4l {
    fn open() -> io::Result<Self> {
        let (socket, file) = bound()?;
        let mut service = Self {
            socket,
            sequence: 0,
            file,
        };
        service.connect()?;
        Ok(service)
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

impl Ptp4l {
    fn connect(&mut self) -> io::Result<()> {
        self.socket.set_nonblocking(true)?;
        let mut refused = io::Error::from(io::ErrorKind::NotFound);
        for path in PATHS {
            match self.socket.connect(path) {
                Ok(()) => return Ok(()),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => refused = error,
            }
        }
        Err(refused)
    }
}

impl Drop for Ptp4l {
    fn drop(&mut self) {
        if let Some(file) = &self.file {
            // Left behind it would do no harm.
            let _ = std::fs::remove_file(file);
        }
    }
}

/// Returns a socket with an address that the service can answer to: in turn one without a file, and one with.
// A service with a /tmp of its own sees no file there, and one in another network namespace no address without a file.
fn bound() -> io::Result<(UnixDatagram, Option<PathBuf>)> {
    static OPENED: AtomicU32 = AtomicU32::new(0);
    let number = OPENED.fetch_add(1, Ordering::Relaxed);
    let name = format!("coaxle-ptp-{}-{number}", std::process::id());
    if number.is_multiple_of(2) {
        let address = SocketAddr::from_abstract_name(name)?;
        return Ok((UnixDatagram::bind_addr(&address)?, None));
    }
    let file = std::env::temp_dir().join(name);
    Ok((UnixDatagram::bind(&file)?, Some(file)))
}
