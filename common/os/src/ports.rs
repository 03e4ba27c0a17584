//! Ports of this machine for programs that are started by another one.

use std::io;
use std::net::{Ipv4Addr, TcpListener, UdpSocket};
use std::ops::Range;
use std::sync::atomic::{AtomicU16, Ordering};

/// Ports among which one is chosen.
// The system gives a connection a port of its own at its other end: from 32768 on under Linux, from 49152 on by IANA. A port that a
// bind to 0 found is one of those. In some of the runs with several nodes at a time a connection took it before its node did.
const PORTS: Range<u16> = 10_000..32_768;

/// Address of the sockets that claim a port. Nobody listens there, and all of 127.0.0.0/8 is this machine under Linux.
const CLAIMS: Ipv4Addr = Ipv4Addr::new(127, 0, 0, 2);

/// A port that is free for connections as well as for datagrams on 127.0.0.1.
///
/// While this is held, no other search of this kind finds the port, in this program or in another one: the program that it is for has
/// all the time that it needs to listen there.
#[derive(Debug)]
pub struct ClaimedPort {
    number: u16,
    /// Absent where a system has no such address: the port is free, and not claimed.
    _claim: Option<UdpSocket>,
}

impl ClaimedPort {
    /// Finds a port and claims it.
    ///
    /// # Errors
    /// All ports are taken, or the system permits no sockets: what it says of the last port tried.
    pub fn find() -> io::Result<Self> {
        static NEXT: AtomicU16 = AtomicU16::new(0);
        let mut last = io::ErrorKind::AddrInUse.into();
        for _ in PORTS {
            let nth = NEXT.fetch_add(1, Ordering::Relaxed);
            match Self::claim(candidate(std::process::id(), nth)) {
                Ok(port) => return Ok(port),
                Err(error) if error.kind() == io::ErrorKind::AddrInUse => last = error,
                Err(error) => return Err(error),
            }
        }
        Err(last)
    }

    /// Number of the port.
    #[must_use]
    pub const fn number(&self) -> u16 {
        self.number
    }

    /// Keeps the claim until this program ends. Returns the number.
    #[must_use]
    pub fn keep(self) -> u16 {
        let number = self.number;
        std::mem::forget(self);
        number
    }

    /// Claims this port, if it is free.
    fn claim(number: u16) -> io::Result<Self> {
        let claim = match UdpSocket::bind((CLAIMS, number)) {
            Ok(claim) => Some(claim),
            Err(error) if error.kind() == io::ErrorKind::AddrNotAvailable => None,
            Err(error) => return Err(error),
        };
        // Closed again at once, as the port is for somebody else. A listener that was never connected to leaves nothing behind.
        TcpListener::bind((Ipv4Addr::LOCALHOST, number))?;
        UdpSocket::bind((Ipv4Addr::LOCALHOST, number))?;
        Ok(Self {
            number,
            _claim: claim,
        })
    }
}

/// The port that a program tries as its nth.
// Programs start at places of their own, so that they seldom ask for the same ones. Neighbouring processes are 97 apart.
fn candidate(program: u32, nth: u16) -> u16 {
    let count = u32::from(PORTS.end - PORTS.start);
    let place = (program % count * 97 + u32::from(nth)) % count;
    PORTS.start + place as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claimed_port_is_found_by_nobody_else_and_anybody_can_listen_there() {
        let first = ClaimedPort::find().unwrap();
        let taken = ClaimedPort::claim(first.number()).unwrap_err();
        assert_eq!(taken.kind(), io::ErrorKind::AddrInUse);
        let at = (Ipv4Addr::LOCALHOST, first.number());
        let _listener = TcpListener::bind(at).unwrap();
        let _socket = UdpSocket::bind(at).unwrap();
        assert_ne!(ClaimedPort::find().unwrap().number(), first.number());
    }

    #[test]
    fn a_port_is_free_again_with_its_claim_and_a_kept_one_is_not() {
        let number = ClaimedPort::find().unwrap().number();
        let kept = ClaimedPort::claim(number).unwrap().keep();
        assert_eq!(kept, number);
        assert!(ClaimedPort::claim(number).is_err());
    }

    #[test]
    fn a_port_that_is_taken_for_connections_or_for_datagrams_is_none() {
        let port = ClaimedPort::find().unwrap();
        let at = (Ipv4Addr::LOCALHOST, port.number());
        drop(port);
        let listener = TcpListener::bind(at).unwrap();
        assert!(ClaimedPort::claim(at.1).is_err());
        drop(listener);
        let _socket = UdpSocket::bind(at).unwrap();
        assert!(ClaimedPort::claim(at.1).is_err());
    }

    #[test]
    fn no_connection_is_given_a_port_that_is_chosen() {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        assert!(!PORTS.contains(&listener.local_addr().unwrap().port()));
        for program in [1, 4_000, u32::MAX] {
            assert!((0..=u16::MAX).all(|nth| PORTS.contains(&candidate(program, nth))));
        }
    }
}
