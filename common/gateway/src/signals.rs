//! The signals of a gateway.

use coaxle_node::signals;

signals! {
    /// The gateway itself, and the PLC behind it.
    pub struct GatewaySignals of Node {
        /// Cycle of the gateway, skipped ones counted.
        cycle: u64 [""],
        /// This run of the gateway.
        run: u64 [""],
        /// Cycles skipped so far.
        overruns: u64 [""],
        /// The PLC is there, as far as is known.
        plc_is_up: bool [""],
        /// It says that its runtime is not in run: its index stands. By ADS alone.
        plc_is_stopped: bool [""],
        /// How often it came.
        plc_connections: u32 [""],
        /// Runs of the PLC so far: another one begins with another connection, or an index that does not go on.
        plc_runs: u64 [""],
        /// The newest cycle index of it.
        plc_index: u16 [""],
        /// That as a count: the count in the frames.
        plc_count: u64 [""],
        /// Cycles of the PLC that were seen so far.
        plc_cycles: u64 [""],
        /// Cycles of it that were missed so far, between those that were seen.
        plc_missed: u64 [""],
        /// Samples so far that showed the cycle of the one before, or an older one.
        plc_repeated: u64 [""],
        /// Samples so far whose index keeps no pace with the time.
        plc_foreign: u64 [""],
        /// Samples so far that were left out because parts of them were of different cycles.
        plc_torn: u64 [""],
        /// What came so far and was no sample.
        plc_refused: u64 [""],
        /// The clock of the PLC is known: its axes are published.
        plc_synced: bool [""],
        /// How much faster that clock runs than the one here.
        plc_drift_ppm: Option<f64> ["ppm"],
        /// When the newest sample came, after the ideal start of its cycle: the jitter of reading.
        plc_lateness_us: Option<f64> ["µs"],
        /// Frames for the PLC that came so far.
        outputs: u64 [""],
        /// Frames for the PLC that were refused so far.
        outputs_refused: u64 [""],
        /// Time requests answered so far.
        requests_answered: u64 [""],
        /// Time requests not answered so far: too many came in one cycle.
        requests_dropped: u64 [""],
        /// Time requests refused so far, before they reached the node.
        requests_refused: u64 [""],
    }
}

signals! {
    /// An axis of the PLC, as it was read last.
    pub struct PlcAxisSignals of Axis {
        /// Set position.
        position: f64 ["u"],
        /// Set velocity.
        velocity: f64 ["u/s"],
        /// Set acceleration.
        acceleration: f64 ["u/s²"],
        /// Its error code, 0 without one.
        error_code: u32 [""],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::signal::table;

    const DOCUMENT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/PLC.md");
    const HEADING: &str = "# Signals of a gateway\n";

    /// To write it anew after a change: `UPDATE_DOCS=1 cargo test -p coaxle-gateway signals`.
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
