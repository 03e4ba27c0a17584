//! Byte streams of an ADS connection: a TCP connection, or a recorded one.

use std::io::{ErrorKind, Read, Result, Write};
use std::net::{IpAddr, TcpStream, ToSocketAddrs};
use std::time::Duration;

use coaxle_clock::Span;

/// A connection as bytes.
pub(super) trait AdsWire: Send {
    /// Sends all bytes.
    ///
    /// # Errors
    /// The connection has ended.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;

    /// Takes bytes that come within `timeout`. Returns their number, 0 if none came.
    ///
    /// # Errors
    /// The connection has ended.
    fn receive(&mut self, bytes: &mut [u8], timeout: Span) -> Result<usize>;
}

/// A TCP connection.
pub(super) struct Tcp(TcpStream);

impl Tcp {
    /// Connects to the first address of the host that accepts within `timeout`.
    ///
    /// # Errors
    /// No address does.
    pub(super) fn reach(host: &str, port: u16, timeout: Span) -> Result<Self> {
        let timeout = duration(timeout);
        let mut failed = ErrorKind::AddrNotAvailable.into();
        for address in (host, port).to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, timeout) {
                Ok(socket) => {
                    // Small requests: Nagle's algorithm would hold each back until the last one is acknowledged.
                    socket.set_nodelay(true)?;
                    // A PLC that reads no more fills the buffer, and the thread would hang in `write`.
                    socket.set_write_timeout(Some(timeout))?;
                    return Ok(Self(socket));
                }
                Err(error) => failed = error,
            }
        }
        Err(failed)
    }

    /// The address of this PC that it leaves from.
    pub(super) fn own_ip(&self) -> Result<IpAddr> {
        Ok(self.0.local_addr()?.ip())
    }
}

impl AdsWire for Tcp {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.0.write_all(bytes)
    }

    fn receive(&mut self, bytes: &mut [u8], timeout: Span) -> Result<usize> {
        // A timeout of 0 is refused by the standard library: it would mean to wait without end.
        let least = Span::from_micros(1);
        self.0
            .set_read_timeout(Some(duration(timeout.max(least))))?;
        match self.0.read(bytes) {
            // The end of the stream, not an empty read.
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Ok(length) => Ok(length),
            Err(error) => match error.kind() {
                ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => Ok(0),
                _ => Err(error),
            },
        }
    }
}

// Spans here are positive.
fn duration(span: Span) -> Duration {
    Duration::from_nanos(span.as_nanos().unsigned_abs())
}
