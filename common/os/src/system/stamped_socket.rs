//! A UDP socket with stamps of arrivals and departures, as near to the wire as the system can take them.

use std::io;
use std::net::SocketAddr;

use coaxle_node::Stamps;

use crate::ClockPair;

/// A received datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReceivedDatagram {
    /// Length; a datagram longer than the buffer is cut.
    pub length: usize,
    /// Address of the sender.
    pub from: SocketAddr,
    /// Time of arrival, ns of [`System::clock_ns`](super::System::clock_ns); none if its stamp is not
    /// plausible.
    pub at_ns: Option<i64>,
}

/// A UDP socket with stamps. Both ends of a clone share the socket.
pub trait StampedSocket: Sized + Send {
    /// Opens it.
    ///
    /// # Errors
    /// An address that cannot be used.
    fn bind(address: SocketAddr) -> io::Result<Self>;

    /// Makes another end of it.
    ///
    /// # Errors
    /// A refusal of the system.
    fn try_clone(&self) -> io::Result<Self>;

    /// Returns the bound address.
    ///
    /// # Errors
    /// A refusal of the system.
    fn address(&self) -> io::Result<SocketAddr>;

    /// Returns the place where its stamps are taken.
    fn stamps(&self) -> Stamps;

    /// Waits for the next datagram, for a tenth of a second at most; none if none arrived.
    ///
    /// # Errors
    /// A refusal of the system.
    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<Option<ReceivedDatagram>>;

    /// Sends a datagram.
    ///
    /// # Errors
    /// A datagram that was not sent.
    fn send(&mut self, bytes: &[u8], to: SocketAddr) -> io::Result<()>;

    /// Returns the departure stamp of a datagram: the number of datagrams sent before it by this socket,
    /// and its time, ns of the clock above. None if there is no further one yet.
    fn departure(&mut self) -> Option<(u32, i64)>;
}

/// Offset between two clocks, the second at time 0 of the first, as far as stamps can be converted from
/// one to the other.
///
/// The second may be set at any time: a stamp from before that cannot be converted.
#[derive(Clone, Copy, Debug, Default)]
pub struct ClockOffset {
    newest: Option<i64>,
}

/// Greatest age of a stamp, ns: older ones are of no use, and none is in the future.
const LONGEST_AGE_NS: i64 = 200_000_000;
/// Time between the readings of both clocks, ns.
const READING_NS: i64 = 1_000;
/// Change of the offset beyond which the clock was set, ns.
const JUMP_NS: i64 = 20_000;

impl ClockOffset {
    /// Reads both: `clock`, `other`, `clock`, several times. True if the other one was set since the last
    /// time.
    pub fn measure(&mut self, clock: impl Fn() -> i64, other: impl Fn() -> i64) -> bool {
        let pair = ClockPair::read(clock, other);
        let offset = pair.other - pair.clock;
        let before = self.newest.replace(offset);
        // A clock slewed by 500 ppm changes by this much in 40 ms. Mistaken for a jump it costs one stamp.
        before.is_some_and(|before| (offset - before).abs() > JUMP_NS)
    }

    /// Converts a stamp of the other clock to the first, which shows `now`; none if it is not plausible.
    #[must_use]
    pub fn converted(&self, stamp: i64, now: i64) -> Option<i64> {
        let at = stamp.checked_sub(self.newest?)?;
        let age = now.checked_sub(at)?;
        // A stamp a reading in the future is an error of the offset; later ones are of a clock that was set.
        (-READING_NS..=LONGEST_AGE_NS).contains(&age).then_some(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// Simulates a clock: every reading takes this number of ns, and some are interrupted.
    fn clock(now: &Cell<i64>, takes: &[i64]) -> impl Fn() -> i64 {
        let reading = Cell::new(0);
        move || {
            let n = reading.replace(reading.get() + 1);
            now.set(now.get() + takes[n % takes.len()]);
            now.get()
        }
    }

    #[test]
    fn the_narrowest_reading_counts() {
        let now = Cell::new(1_000_000);
        let takes = [20, 40_000, 20, 30, 9_000, 25];
        let read = clock(&now, &takes);
        let mut offset = ClockOffset::default();
        assert!(!offset.measure(&read, || now.get() + 5_000_000_000));
        let converted = offset.converted(now.get() + 5_000_000_000 - 700, now.get());
        let off = converted.unwrap() - (now.get() - 700);
        assert!(off.abs() <= 20, "{off}");
    }

    #[test]
    fn a_clock_that_was_set_is_noticed_and_stamps_of_before_are_not_believed() {
        let now = Cell::new(1_000_000);
        let read = || now.replace(now.get() + 20);
        let set = Cell::new(7_000_000);
        let other = || now.get() + set.get();
        let mut offset = ClockOffset::default();
        assert!(!offset.measure(read, other));
        let stamp = other();
        assert!(!offset.measure(read, other));
        set.set(9_000_000);
        assert!(offset.measure(read, other));
        assert_eq!(
            offset.converted(stamp + 3_000_000, now.get()),
            None,
            "in the future"
        );
        assert!(!offset.measure(read, other));
        assert_eq!(
            offset.converted(other() - 300_000_000, now.get()),
            None,
            "too old"
        );
        assert_eq!(ClockOffset::default().converted(0, 0), None);
        assert_eq!(offset.converted(i64::MIN, 0), None);
    }
}
