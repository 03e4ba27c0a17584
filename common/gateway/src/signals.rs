//! The signals of a gateway.

use coaxle_node::signals;

signals! {
    /// The gateway itself, and the PLC behind it.
    pub struct GatewaySignals of Node {
        /// Cycle of the gateway, skipped ones counted.
        cycle: u64 [""],
        /// Run of the gateway.
        run: u64 [""],
        /// Cycles skipped so far.
        overruns: u64 [""],
        /// The PLC is connected, as far as is known.
        plc_is_up: bool [""],
        /// The PLC reports that its runtime is not in run: its index stands. By ADS only.
        plc_is_stopped: bool [""],
        /// Connections to the PLC so far.
        plc_connections: u32 [""],
        /// Runs of the PLC so far: another one begins with another connection or an index out of sequence.
        plc_runs: u64 [""],
        /// The newest cycle index of the PLC.
        plc_index: u16 [""],
        /// The newest cycle index as a count: the count in the frames.
        plc_count: u64 [""],
        /// Cycles of the PLC that were seen so far.
        plc_cycles: u64 [""],
        /// Cycles of the PLC that were missed so far, between those that were seen.
        plc_missed: u64 [""],
        /// Samples so far with the cycle of the previous one, or an older one.
        plc_repeated: u64 [""],
        /// Samples so far whose index does not match the time.
        plc_foreign: u64 [""],
        /// Samples dropped so far because their parts were of different cycles.
        plc_torn: u64 [""],
        /// Invalid messages of the PLC so far.
        plc_refused: u64 [""],
        /// The clock of the PLC is known: its axes are published.
        plc_synced: bool [""],
        /// Drift of the PLC's clock against the gateway's.
        plc_drift_ppm: Option<f64> ["ppm"],
        /// Arrival of the newest sample after the ideal start of its cycle: the jitter of reading.
        plc_lateness_us: Option<f64> ["µs"],
        /// Frames for the PLC received so far.
        outputs: u64 [""],
        /// Frames for the PLC that were refused so far.
        outputs_refused: u64 [""],
        /// Time requests responded to so far.
        requests_answered: u64 [""],
        /// Time requests dropped so far: too many arrived in one cycle.
        requests_dropped: u64 [""],
        /// Time requests refused so far, before they reached the node.
        requests_refused: u64 [""],
    }
}

signals! {
    /// An axis of the PLC, as last read.
    pub struct PlcAxisSignals of Axis {
        /// Set position.
        position: f64 ["u"],
        /// Set velocity.
        velocity: f64 ["u/s"],
        /// Set acceleration.
        acceleration: f64 ["u/s²"],
        /// Error code of the axis, 0 without one.
        error_code: u32 [""],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::signal::table;

    const DOCUMENT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/PLC.md");
    // The tables behind this heading are written by the test, the rest of the page by hand.
    const HEADING: &str = "# Signals of a gateway\n";

    /// To update it after a change: `UPDATE_DOCS=1 cargo test -p coaxle-gateway signals`.
    #[test]
    fn the_document_has_every_signal() {
        let path = std::path::Path::new(DOCUMENT);
        let written = std::fs::read_to_string(path).expect("the document");
        let (others, _) = written.split_once(HEADING).expect("the tables");
        let tables = [
            table::<GatewaySignals>("The gateway"),
            table::<PlcAxisSignals>("An axis of the PLC"),
        ];
        let expected = format!("{others}{HEADING}\n{}", tables.join("\n"));
        if std::env::var_os("UPDATE_DOCS").is_some() {
            std::fs::write(path, &expected).expect("the document can be written");
        } else {
            assert_eq!(written, expected);
        }
    }
}
