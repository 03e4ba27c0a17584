//! Refused connections, counted and logged now and then.

use std::net::SocketAddr;
use std::time::Duration;

use tokio::time::Instant;

use crate::events::{LinkEventKind, report};

/// Least time between two lines: a flood of connects must not be a flood of lines.
const BETWEEN_LINES: Duration = Duration::from_secs(10);

/// Connections refused since the last line.
#[derive(Debug, Default)]
pub(crate) struct Refusals {
    count: u64,
    last: Option<(SocketAddr, String)>,
    last_logged: Option<Instant>,
}

impl Refusals {
    pub(crate) fn add(&mut self, from: SocketAddr, reason: String) {
        report(&from.to_string(), LinkEventKind::Refused, &reason);
        self.count += 1;
        self.last = Some((from, reason));
    }

    /// Returns a line, if there are new refusals and the last one was long enough ago.
    pub(crate) fn line(&mut self, now: Instant) -> Option<String> {
        if let Some(last_logged) = self.last_logged
            && now.duration_since(last_logged) < BETWEEN_LINES
        {
            return None;
        }
        // Taken, so that nothing is due until the next refusal.
        let (from, reason) = self.last.take()?;
        let count = std::mem::take(&mut self.count);
        self.last_logged = Some(now);
        Some(match count {
            1 => format!("a connection from {from} was refused: {reason}"),
            _ => format!("{count} connections were refused, the last one from {from}: {reason}"),
        })
    }

    /// Returns the time of the next line; none without a refusal.
    pub(crate) fn due(&self) -> Option<Instant> {
        self.last.as_ref()?;
        self.last_logged
            .map(|last_logged| last_logged + BETWEEN_LINES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_is_one_line_with_its_count() {
        let from = SocketAddr::from(([10, 0, 0, 7], 40_000));
        let start = Instant::now();
        let mut refusals = Refusals::default();
        assert_eq!(refusals.line(start), None);
        assert_eq!(refusals.due(), None);
        refusals.add(from, "no certificate".to_owned());
        assert_eq!(
            refusals.line(start).as_deref(),
            Some("a connection from 10.0.0.7:40000 was refused: no certificate")
        );
        for _ in 0..7300 {
            refusals.add(from, "tls handshake eof".to_owned());
        }
        assert_eq!(refusals.line(start + Duration::from_secs(9)), None);
        let line = refusals.line(start + BETWEEN_LINES).expect("a line");
        assert!(line.starts_with("7300 connections were refused"), "{line}");
        assert_eq!(refusals.due(), None, "all is said");
    }
}
