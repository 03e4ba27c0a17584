//! UDP with `SO_TIMESTAMPING`: arrivals and departures of datagrams, stamped by the kernel.

use std::io::{self, IoSliceMut};
use std::net::{SocketAddr, UdpSocket};
use std::os::fd::AsRawFd;
use std::time::Duration;

use coaxle_node::Stamps;
use nix::cmsg_space;
use nix::libc;
use nix::sys::socket::{
    ControlMessageOwned, MsgFlags, SockaddrStorage, TimestampingFlag, Timestamps, recvmsg,
    setsockopt, sockopt,
};
use nix::sys::time::TimeSpec;
use rustix::time::{ClockId, clock_gettime};

use super::threads::NANOS_PER_SEC;
use crate::stamped_socket::{ClockOffset, ReceivedDatagram, StampedSocket};

/// Greatest wait for a datagram.
const RECEIVE_TIMEOUT: Duration = Duration::from_millis(100);

/// UDP socket with stamps of `CLOCK_REALTIME`, converted to the machine's clock.
#[derive(Debug)]
pub struct KernelStamped {
    socket: UdpSocket,
    stamps: Stamps,
    offset: ClockOffset,
    /// Buffer of the kernel's control messages beside a datagram.
    control_messages: Vec<u8>,
}

impl KernelStamped {
    fn over(socket: UdpSocket, stamps: Stamps) -> Self {
        Self {
            socket,
            stamps,
            offset: ClockOffset::default(),
            control_messages: cmsg_space!(Timestamps, libc::sock_extended_err, libc::sockaddr_in6),
        }
    }

    /// Converts a stamp of `CLOCK_REALTIME` to the machine's clock.
    fn converted(&mut self, stamp: i64) -> Option<i64> {
        // Measured for each stamp: the realtime clock is slewed all the time, and may be set.
        let was_set = self.offset.measure(monotonic, realtime);
        self.offset
            .converted(stamp, monotonic())
            // Unknown whether this stamp is from before or after the clock was set.
            .filter(|_| !was_set)
    }
}

impl StampedSocket for KernelStamped {
    fn bind(address: SocketAddr) -> io::Result<Self> {
        let socket = UdpSocket::bind(address)?;
        socket.set_read_timeout(Some(RECEIVE_TIMEOUT))?;
        // SOFTWARE reports stamps, RX and TX take them. OPT_ID numbers departures, OPT_TSONLY returns them without
        // the datagram.
        let wanted = TimestampingFlag::SOF_TIMESTAMPING_SOFTWARE
            | TimestampingFlag::SOF_TIMESTAMPING_RX_SOFTWARE
            | TimestampingFlag::SOF_TIMESTAMPING_TX_SOFTWARE
            | TimestampingFlag::SOF_TIMESTAMPING_OPT_ID
            | TimestampingFlag::SOF_TIMESTAMPING_OPT_TSONLY;
        let stamps = match setsockopt(&socket, sockopt::Timestamping, &wanted) {
            Ok(()) => Stamps::Kernel,
            Err(errno) => {
                tracing::warn!("the kernel gives no stamps: {errno}; the program takes its own");
                // Stamps of the program are later by its wake-up, and are marked as such.
                Stamps::Application
            }
        };
        Ok(Self::over(socket, stamps))
    }

    fn try_clone(&self) -> io::Result<Self> {
        Ok(Self::over(self.socket.try_clone()?, self.stamps))
    }

    fn address(&self) -> io::Result<SocketAddr> {
        self.socket.local_addr()
    }

    fn stamps(&self) -> Stamps {
        self.stamps
    }

    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<Option<ReceivedDatagram>> {
        if self.stamps == Stamps::Application {
            return match self.socket.recv_from(buffer) {
                Ok((length, from)) => Ok(Some(ReceivedDatagram {
                    length,
                    from,
                    at_ns: Some(monotonic()),
                })),
                Err(error) => none_if_timed_out(error),
            };
        }
        let mut parts = [IoSliceMut::new(buffer)];
        let received = recvmsg::<SockaddrStorage>(
            self.socket.as_raw_fd(),
            &mut parts,
            Some(&mut self.control_messages),
            MsgFlags::empty(),
        );
        let (length, from, stamp) = match received {
            Ok(message) => {
                let stamp = message.cmsgs().ok().and_then(|mut control_messages| {
                    control_messages.find_map(|one| match one {
                        // `system` is the software stamp; the others are of network cards.
                        ControlMessageOwned::ScmTimestampsns(stamps) => Some(nanos(stamps.system)),
                        _ => None,
                    })
                });
                (message.bytes, message.address.and_then(address_of), stamp)
            }
            Err(errno) => return none_if_timed_out(errno.into()),
        };
        let Some(from) = from else {
            return Ok(None);
        };
        let at_ns = stamp.and_then(|stamp| self.converted(stamp));
        Ok(Some(ReceivedDatagram {
            length,
            from,
            at_ns,
        }))
    }

    fn send(&mut self, bytes: &[u8], to: SocketAddr) -> io::Result<()> {
        self.socket.send_to(bytes, to).map(drop)
    }

    fn departure(&mut self) -> Option<(u32, i64)> {
        if self.stamps == Stamps::Application {
            return None;
        }
        loop {
            let message = recvmsg::<SockaddrStorage>(
                self.socket.as_raw_fd(),
                &mut [],
                Some(&mut self.control_messages),
                // Departures come back on the error queue of the socket; a stamp that is not there yet must not be
                // waited for.
                MsgFlags::MSG_ERRQUEUE | MsgFlags::MSG_DONTWAIT,
            );
            let (mut stamp, mut number) = (None, None);
            for one in message.ok()?.cmsgs().ok()? {
                match one {
                    ControlMessageOwned::ScmTimestampsns(stamps) => {
                        stamp = Some(nanos(stamps.system));
                    }
                    ControlMessageOwned::Ipv4RecvErr(error, _)
                    | ControlMessageOwned::Ipv6RecvErr(error, _) => {
                        // The queue carries errors of the network too, such as an unreachable port; their number
                        // means something else.
                        let is_stamp = error.ee_origin == libc::SO_EE_ORIGIN_TIMESTAMPING;
                        number = is_stamp.then_some(error.ee_data);
                    }
                    _ => {}
                }
            }
            if let (Some(stamp), Some(number)) = (stamp, number)
                && let Some(left) = self.converted(stamp)
            {
                return Some((number, left));
            }
        }
    }
}

fn none_if_timed_out(error: io::Error) -> io::Result<Option<ReceivedDatagram>> {
    use io::ErrorKind::{ConnectionRefused, Interrupted, TimedOut, WouldBlock};
    match error.kind() {
        // Nobody listens at that address yet, which the next call reports.
        WouldBlock | TimedOut | Interrupted | ConnectionRefused => Ok(None),
        _ => Err(error),
    }
}

fn address_of(address: SockaddrStorage) -> Option<SocketAddr> {
    if let Some(v4) = address.as_sockaddr_in() {
        return Some(std::net::SocketAddrV4::from(*v4).into());
    }
    let v6 = address.as_sockaddr_in6()?;
    Some(std::net::SocketAddrV6::from(*v6).into())
}

fn nanos(time: TimeSpec) -> i64 {
    time.tv_sec() * NANOS_PER_SEC + time.tv_nsec()
}

fn monotonic() -> i64 {
    let time = clock_gettime(ClockId::Monotonic);
    time.tv_sec * NANOS_PER_SEC + time.tv_nsec
}

fn realtime() -> i64 {
    let time = clock_gettime(ClockId::Realtime);
    time.tv_sec * NANOS_PER_SEC + time.tv_nsec
}
