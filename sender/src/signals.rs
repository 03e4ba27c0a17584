//! The signals of a sender: each is declared here, and computed in the node.

use coaxle_node::signals;

signals! {
    /// The sender itself.
    pub struct SenderSignals of Node {
        /// Cycle number, skipped ones counted: the count in its frames.
        cycle: u64 [""],
        /// The cycle index in its frames.
        index: u16 [""],
        /// Run of the node: the epoch in its frames.
        run: u64 [""],
        /// Presentation delay of its frames: the time after their generation at which its axes are shown; none if
        /// followers move the newest values to now.
        present_after_us: Option<f64> ["µs"],
        /// Greatest presentation delay that a follower reports as needed: its axes then find the frames that they need.
        wanted_present_after_us: Option<f64> ["µs"],
        /// Cycles skipped.
        overruns: u64 [""],
        /// Plans published, of all axes.
        plans_published: u64 [""],
        /// Followers of its axes whose slaves are all in sync: those of each axis that waits for them or stops with them.
        followers_in_sync: u32 [""],
        /// Followers that have failed: with a slave in error, silent, or begun again.
        followers_failed: u32 [""],
        /// Axes that stand still, or ramp down, because a follower has failed.
        axes_held: u32 [""],
        /// Reports of followers rejected before they reached the node.
        reports_refused: u64 [""],
        /// Time requests responded to.
        requests_answered: u64 [""],
        /// Time requests dropped because too many arrived in one cycle.
        requests_dropped: u64 [""],
        /// Time requests rejected before they reached the node.
        requests_refused: u64 [""],
        /// Beacons of the timing channel responded to.
        beacons_answered: u64 [""],
        /// Beacons dropped because too many arrived in one cycle.
        beacons_dropped: u64 [""],
        /// Beacons rejected before they reached the node.
        beacons_refused: u64 [""],
    }
}

// Truth, since runs judge receivers by these signals and not by readings.
signals! {
    /// An axis of its own, by its true motion: with an encoder, the measured one.
    pub struct AxisSignals of Axis {
        /// Position.
        position: f64 ["u"],
        /// Velocity.
        velocity: f64 ["u/s"],
        /// Acceleration.
        acceleration: f64 ["u/s²"],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::signal::table;

    const DOCUMENT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/SIGNALS.md");
    const HEADING: &str = "# Signals of a sender\n";

    /// Rewrites it after a change: `UPDATE_DOCS=1 cargo test -p coaxle-sender signals`.
    #[test]
    fn the_document_has_every_signal() {
        let path = std::path::Path::new(DOCUMENT);
        let written = std::fs::read_to_string(path).expect("the document");
        let (others, own) = written.split_once(HEADING).expect("the sender's part");
        let (head, _) = own.split_once("## ").expect("the tables");
        let tables = [
            table::<SenderSignals>("The sender"),
            table::<AxisSignals>("An axis"),
        ];
        let expected = format!("{others}{HEADING}{head}{}", tables.join("\n"));
        if std::env::var_os("UPDATE_DOCS").is_some() {
            std::fs::write(path, &expected).expect("the document can be written");
        } else {
            assert_eq!(written, expected);
        }
    }
}
