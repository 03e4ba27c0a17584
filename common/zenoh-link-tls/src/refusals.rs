//! Refused connections: counted for the status of the node, and logged now and then.

use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use tokio::time::Instant;

use crate::events::{LinkEventKind, report};
use crate::flood::FloodWatch;
use crate::source_prefix::SourcePrefix;

/// Least time between two lines, so that many refused members are not as many lines.
const BETWEEN_LINES: Duration = Duration::from_secs(10);

/// Least time between two lines about a flood: it may last for days, and the log is for everything else, too.
const BETWEEN_FLOOD_LINES: Duration = Duration::from_secs(60);

/// Refused connections of all listeners of this process.
static REFUSED: AtomicU64 = AtomicU64::new(0);

/// The newest flood: its busiest origin, and its end if no connection is added.
static FLOOD: Mutex<Option<(SourcePrefix, Instant)>> = Mutex::new(None);

/// Connections to the listeners of this process that were refused.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RefusedConnections {
    /// Their number since the start: failed handshakes, and connections that made room for later ones.
    pub count: u64,
    /// During a flood of connections the address that opens most of them: an IPv4 address, or an IPv6 network.
    pub flood_from: Option<String>,
}

/// Returns the refused connections of this process so far.
#[must_use]
pub fn refused_connections() -> RefusedConnections {
    let flood = *FLOOD.lock().unwrap_or_else(PoisonError::into_inner);
    let flood = flood.filter(|(_, until)| *until > Instant::now());
    RefusedConnections {
        // A figure for people: no other memory is read by its value.
        count: REFUSED.load(Ordering::Relaxed),
        flood_from: flood.map(|(origin, _)| origin.to_string()),
    }
}

/// Connections of a listener that were refused since its last line.
#[derive(Debug, Default)]
pub(crate) struct Refusals {
    count: u64,
    last: Option<(SocketAddr, String)>,
    last_logged: Option<Instant>,
    flood: FloodWatch,
    flood_logged: Option<Instant>,
}

impl Refusals {
    pub(crate) fn add(&mut self, now: Instant, from: SocketAddr, reason: String) {
        report(&from.to_string(), LinkEventKind::Refused, &reason);
        self.count += 1;
        self.last = Some((from, reason));
        self.flood.add(now, SourcePrefix::of(from));
        REFUSED.fetch_add(1, Ordering::Relaxed);
        if let Some(until) = self.flood.until(now)
            && let Some((origin, _)) = self.flood.busiest()
        {
            let mut flood = FLOOD.lock().unwrap_or_else(PoisonError::into_inner);
            *flood = Some((origin, until));
        }
    }

    /// Returns a line, if there are new refusals and the last one was long enough ago.
    pub(crate) fn line(&mut self, now: Instant) -> Option<String> {
        if self.due(now)? > now {
            return None;
        }
        let is_flood = self.flood.until(now).is_some();
        let busiest = self.flood.busiest();
        // Taken, so that nothing is due until the next refusal.
        let (from, reason) = self.last.take()?;
        let count = std::mem::take(&mut self.count);
        self.flood.clear(now);
        self.last_logged = Some(now);
        Some(match (busiest, count) {
            (Some((origin, most)), _) if is_flood => {
                self.flood_logged = Some(now);
                format!(
                    "connection flood: {count} connections refused, {most} of them from {origin}, the last one \
                     from {from}: {reason}; members still get in, and established links are not affected"
                )
            }
            (_, 1) => format!("a connection from {from} was refused: {reason}"),
            _ => format!("{count} connections were refused, the last one from {from}: {reason}"),
        })
    }

    /// Returns the time of the next line; none without a refusal.
    pub(crate) fn due(&self, now: Instant) -> Option<Instant> {
        self.last.as_ref()?;
        let after = |last: Option<Instant>, pause| last.map_or(now, |last| last + pause);
        Some(match self.flood.until(now) {
            // The first line about a flood waits for no other line.
            Some(_) => after(self.flood_logged, BETWEEN_FLOOD_LINES),
            None => after(self.last_logged, BETWEEN_LINES),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from(n: u8) -> SocketAddr {
        SocketAddr::from(([10, 0, 0, n], 40_000))
    }

    #[test]
    fn refusals_are_lines_with_their_count_now_and_then() {
        let start = Instant::now();
        let mut refusals = Refusals::default();
        assert_eq!(refusals.line(start), None);
        assert_eq!(refusals.due(start), None);
        refusals.add(start, from(7), "no certificate".to_owned());
        assert_eq!(
            refusals.line(start).as_deref(),
            Some("a connection from 10.0.0.7:40000 was refused: no certificate")
        );
        for n in 0..40 {
            refusals.add(start, from(n), "tls handshake eof".to_owned());
        }
        assert_eq!(refusals.line(start + Duration::from_secs(9)), None);
        let next = start + BETWEEN_LINES;
        assert_eq!(refusals.due(start), Some(next));
        let line = refusals.line(next).expect("a line");
        assert!(line.starts_with("40 connections were refused"), "{line}");
        assert_eq!(refusals.due(next), None, "all is said");
    }

    #[test]
    fn a_flood_is_one_line_a_minute_with_the_busiest_address() {
        let start = Instant::now();
        let mut refusals = Refusals::default();
        refusals.add(start, from(8), "tls handshake eof".to_owned());
        assert!(refusals.line(start).is_some());
        for _ in 0..7_300 {
            refusals.add(start, from(7), "tls handshake eof".to_owned());
        }
        let line = refusals.line(start).expect("a line at once");
        let expected = "connection flood: 7300 connections refused, 7300 of them from 10.0.0.7,";
        assert!(line.starts_with(expected), "{line}");
        assert_eq!(
            refused_connections().flood_from.as_deref(),
            Some("10.0.0.7")
        );
        assert!(refused_connections().count > 7_300);
        // Nine a second for two minutes.
        let lines = (0..1_080).filter_map(|n| {
            let now = start + Duration::from_secs(1) * n / 9;
            refusals.add(now, from(7), "tls handshake eof".to_owned());
            refusals.line(now)
        });
        let lines: Vec<_> = lines.collect();
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(lines[0].contains("541 of them from 10.0.0.7"), "{lines:?}");
        // The rest is said when it is over.
        let over = start + Duration::from_secs(135);
        let line = refusals.line(over).expect("a line");
        assert!(line.contains("connections were refused"), "{line}");
    }
}
