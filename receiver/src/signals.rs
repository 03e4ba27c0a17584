//! The signals of a receiver: each is declared here, and computed where its value is at hand.

use coaxle_axis::AxisStatus;
use coaxle_clock::delay::DelayState;
use coaxle_clock::observer::{ObserverLine, ObserverState};
use coaxle_clock::timing::TimingState;
use coaxle_node::{Stamps, signals};
use coaxle_slave::CouplingPhase;
use coaxle_source::Activity;

use crate::names::{
    ContinuityName, DriveKindName, DriveStateName, GuardStateName, HealthName, StateName,
    TravelName,
};
use crate::program::{Outcome, ProgramState, WaitsFor};

signals! {
    /// The receiver itself.
    pub struct NodeSignals of Node {
        /// Cycle number, skipped ones counted.
        cycle: u64 [""],
        /// This run of the node: the epoch in its frames.
        run: u64 [""],
        /// Cycles skipped so far.
        overruns: u64 [""] last "cycles skipped",
        /// The node's own opinion of itself.
        health: HealthName [""],
        /// Time requests answered so far.
        requests_answered: u64 [""],
        /// Time requests not answered so far: too many came in one cycle.
        requests_dropped: u64 [""],
        /// Time requests refused so far, before they reached the node.
        requests_refused: u64 [""],
    }
}

signals! {
    /// A node that is followed, or stands by for one: its clock, and what came of its messages.
    pub struct FarNodeSignals of FarNode {
        /// What the receiver thinks of it.
        health: HealthName [""],
        /// Whether the axes are read from it: not from a standby, unless that has taken over.
        followed: bool [""],
        /// Whether it could take over with its next frame: it is not followed, is heard, and its clock is known.
        stands_by: bool [""],
        /// Times so far that another node, of it and its standbys, took over.
        take_overs: u64 [""] last,
        /// Whether it is enabled (`bEnable`).
        enabled: bool [""],
        /// How set values are calculated while it is (`eFilterMode`).
        mode: StateName [""],
        /// Times it was started anew by an order.
        re_initialisations: u32 [""],
        /// Times its parameters or its delay were changed by an order.
        parameter_changes: u32 [""],
        /// Its nominal cycle time, as its frames say; none before the first message.
        cycle_time_us: Option<f64> ["µs"],
        /// Which run of it is followed.
        epoch: Option<u64> [""],
        /// Its cycle count in the input image.
        count: Option<u64> [""],
        /// The cycle index in the input image (`iCycleIndex`).
        index: Option<u16> [""],
        /// Own cycles since the input image was renewed.
        age_cycles: u32 [""],
        /// Whether its clock is known (`bSynced`).
        synced: bool [""],
        /// The error of the clock (`iErrorId`), 0: none.
        error: u16 [""],
        /// The warning of the clock (`iWarningId`), 0: none.
        warning: u16 [""],
        /// Beats so far.
        beats: u32 [""] last "beats",
        /// Estimated drift of its clock against the own one (`fDrift`).
        drift_ppm: Option<f64> ["ppm"] last "drift estimated",
        /// The correction time that its axes are moved by; none where the mode uses none.
        correction_us: Option<f64> ["µs"],
        /// The correction time that `FB_TimeSync` has found (`fCorrectionTime`).
        time_sync_correction_us: Option<f64> ["µs"],
        /// The same as time mode has it.
        time_mode_correction_us: Option<f64> ["µs"],
        /// Whether `FB_TimeSync` is in time mode (`bTimeMode`).
        time_mode: bool [""],
        /// The index read now minus the one read in the previous cycle (`iCycleIndexDiff`).
        cycle_index_diff: i32 [""],
        /// Cycles without new data so far (`iTotalEqualDataCounter`).
        total_equal_data: u64 [""],
        /// Cycles without new data in a row (`iConsecutiveEqualDataCounter`).
        consecutive_equal_data: u32 [""],
        /// How far the phase observer is; none where it does not run.
        observer_state: Option<ObserverState> [""] last,
        /// Which line of the arrivals it follows.
        observer_line: Option<ObserverLine> [""] last,
        /// Its own standard deviation of the offset.
        offset_sigma_us: Option<f64> ["µs"] last,
        /// The part of its own predictions that it was within three standard deviations of, lately: 0.99 where it is as sure as
        /// it says.
        within_three_sigma: Option<f64> [""] last,
        /// Its own standard deviation of the drift.
        drift_sigma_ppm: Option<f64> ["ppm"] last,
        /// Estimated minus shown far time: what is still to be slewed.
        slew_remaining_us: Option<f64> ["µs"],
        /// Normal part of the jitter of the arrivals, standard deviation.
        normal_jitter_us: Option<f64> ["µs"],
        /// Exponential part of the jitter of the arrivals, mean.
        exponential_jitter_us: Option<f64> ["µs"],
        /// The random walk of the drift that predicts best.
        random_walk_ppm: Option<f64> ["ppm/√s"] last,
        /// Messages per measurement.
        block_length: Option<u16> [""] last,
        /// Jumps of the delay that it noticed so far.
        shifts: u32 [""] last,
        /// When it noticed the last one, in the own clock.
        last_shift_s: Option<f64> ["s"],
        /// How often the drift changed so much at once that the line was found anew.
        drift_steps: u32 [""] last,
        /// Times it began to lock anew.
        relocks: u32 [""] last,
        /// When it last did, in the own clock.
        last_relock_s: Option<f64> ["s"],
        /// Where the delay comes from; none where no phase observer runs.
        delay_state: Option<DelayState> [""] last,
        /// How far the sender's time is taken to be ahead of the observer's line.
        delay_us: Option<f64> ["µs"] last "delay",
        /// That is wrong by at most this: half of the round trip, however unequal the ways are; or what was stated of them, if that
        /// is less.
        delay_uncertainty_us: Option<f64> ["µs"] last "… wrong by at most",
        /// What was stated of how unequal the ways are is more than both of them take together.
        asymmetry_denied: bool [""] last,
        /// The part of the error that jitter causes, standard deviation.
        delay_jitter_us: Option<f64> ["µs"],
        /// Standard deviation of the delay for ways as unequal as was stated, or equally long ones: by jitter and by the line.
        delay_sigma_us: Option<f64> ["µs"] last "… standard deviation",
        /// Since the newest time exchange.
        delay_age_s: Option<f64> ["s"],
        /// Time exchanges used so far.
        exchanges: u64 [""] last,
        /// Responses refused so far.
        responses_refused: u64 [""] last,
        /// How far the timing channel is; none where there is none, or no phase observer runs.
        timing_state: Option<TimingState> [""] last "timing channel",
        /// Where both ends of it take their stamps; none before the first answer.
        timing_stamps: Option<Stamps> [""] last "… stamps",
        /// Standard deviation of the far clock as it shows it.
        timing_sigma_us: Option<f64> ["µs"] last,
        /// How long its exchanges are under way, both ways, at their shortest lately.
        timing_round_trip_us: Option<f64> ["µs"] last,
        /// Since its newest exchange.
        timing_age_s: Option<f64> ["s"],
        /// Its exchanges used so far.
        timing_exchanges: u64 [""] last,
        /// Its exchanges so far that could not be true.
        timing_refused: u64 [""] last,
        /// How often it was begun anew, since the clocks were no longer where it had them.
        timing_restarts: u32 [""] last,
        /// Beacons sent so far.
        beacons_sent: u64 [""],
        /// Answers to them so far that were good.
        beacons_received: u64 [""] last,
        /// Answers refused so far.
        beacons_rejected: u64 [""] last,
        /// The pace of its cycles against the stated cycle time, by its frames of a second; positive: fast.
        pace_ppm: Option<f64> ["ppm"] last,
        /// Accepted messages so far: in order, duplicates, late, waiting, dropped because of an overflow, or foreign.
        received: u64 [""] last,
        /// Messages so far that were the newest of their run when their cycle took them in.
        in_order: u64 [""],
        /// Messages that there should be so far, by the sender's count: from the first of each run to the newest. They are
        /// in order, late or lost.
        expected: u64 [""],
        /// Missing messages so far, by the sender's count.
        lost: u64 [""] last "messages lost",
        /// Repeated messages so far.
        duplicates: u64 [""] last,
        /// Overtaken messages so far.
        late: u64 [""] last,
        /// Messages too old to use so far.
        stale: u64 [""] last,
        /// Late messages so far from before the first of their run, or 64 and more behind the newest: none of those
        /// expected, as they may be repeated.
        outdated: u64 [""],
        /// Messages that have come and are not due yet: they came after the cycle ideally began.
        waiting: u32 [""],
        /// Messages dropped so far because more waited than there is room for.
        overflow: u64 [""],
        /// New runs of the node so far.
        restarts: u64 [""] last,
        /// Frames of other runs so far that were not followed: strays, or those of a second node of the same name.
        foreign_frames: u64 [""] last "frames of others",
        /// The run of a second node of the same name, while one is heard.
        rival_epoch: Option<u64> [""],
        /// Refused frames so far.
        rejected: u64 [""] last,
        /// Refused so far: frames of another format version.
        rejected_wrong_version: u64 [""],
        /// Refused so far: frames that end before their fields do.
        rejected_truncated: u64 [""],
        /// Refused so far: frames whose check sum does not fit.
        rejected_wrong_checksum: u64 [""],
        /// Refused so far: frames whose bytes are no frame.
        rejected_malformed: u64 [""],
        /// Refused so far: frames with bytes left over.
        rejected_trailing_bytes: u64 [""],
        /// Refused so far: frames with a cycle time that no node has.
        rejected_cycle_time_out_of_range: u64 [""],
        /// Refused so far: frames of another node under this one's key.
        rejected_foreign_sender: u64 [""],
        /// Refused so far: frames with none of the axes that are followed.
        rejected_axis_missing: u64 [""],
        /// Refused so far: frames in which none of these axes can be believed.
        rejected_implausible: u64 [""],
    }
}

signals! {
    /// An axis of a node that is followed, as received and as corrected.
    pub struct FarAxisSignals of FarAxis {
        /// The mode that made the set values (`eFilterState`); none before the first message.
        state: Option<StateName> [""],
        /// Whether they are those of the axis, or still on the way there.
        continuity: ContinuityName [""],
        /// Whether they are synchronised (`bSynced`).
        synced: bool [""],
        /// The error of the axis, or of its node's clock (`iErrorId`), 0: none.
        error: u16 [""],
        /// Own cycles since the axis came last.
        age_cycles: u32 [""],
        /// Frames without it so far, or in which it could not be believed.
        missing: u64 [""],
        /// The error code that came with it, 0: none.
        received_error: u32 [""],
        /// Received set position.
        received_position: Option<f64> ["u"],
        /// Received set velocity.
        received_velocity: Option<f64> ["u/s"],
        /// Corrected set position.
        corrected_position: Option<f64> ["u"],
        /// Corrected set velocity.
        corrected_velocity: Option<f64> ["u/s"],
        /// Received minus corrected set position (`fPositionDiff`).
        position_diff: Option<f64> ["u"],
        /// Received minus corrected set velocity (`fVeloDiff`).
        velocity_diff: Option<f64> ["u/s"],
        /// The correction time that moved it; none where the mode uses none.
        correction_us: Option<f64> ["µs"],
        /// Times its received position wrapped so far, from one end of a turn to the other, though it is taken for one that
        /// goes on: `position = "within-turn"` and `modulo` are missing in the config.
        wraps: u32 [""] last,
        /// By how much it did at the newest wrap.
        wrap_length: Option<f64> ["u"],
        /// How far the corrected set position may be from the axis, while that moves as it was seen to: the time error ×
        /// velocity, and half of the greatest jerk so far × age³, or the greatest acceleration × age² where that is less.
        prediction_sigma: Option<f64> ["u"] last,
        /// The instant of the far node's ideal time that the set values stand for.
        far_time_ns: Option<i64> ["ns"],
        /// Bandwidth of the smoothing of an axis that is only measured; none of one that is not.
        encoder_bandwidth: Option<f64> ["rad/s"],
        /// Standard deviation of the position that its increments say.
        position_sigma: Option<f64> ["u"] last,
        /// The same of the velocity.
        velocity_sigma: Option<f64> ["u/s"] last,
        /// Where its increments say that it goes, or went last; none before it moved.
        travel: Option<TravelName> [""],
        /// Whether its set values have settled since the first increments: it is no master before.
        acquired: Option<bool> [""],
        /// Whether it came to rest ahead of its increments and walks back (trim).
        trimming: Option<bool> [""],
        /// Counts that no motion explains, refused so far.
        refused_jumps: Option<u32> [""] last,
        /// How often its counter was set anew so far.
        counter_resets: Option<u32> [""],
    }
}

signals! {
    /// A virtual axis of the receiver's own, as its slaves follow it and as it truly is.
    pub struct VirtualAxisSignals of VirtualAxis {
        /// Set position; behind an encoder what that shows.
        position: f64 ["u"],
        /// Set velocity.
        velocity: f64 ["u/s"],
        /// Set acceleration.
        acceleration: f64 ["u/s²"],
        /// Where the motion under way ends; the set position where it has no end.
        target_position: f64 ["u"],
        /// What it is doing.
        activity: Activity [""],
        /// Whether it is enabled.
        operational: bool [""],
        /// Its error, by the NC's code; 0: none.
        error: u32 [""],
        /// Where it truly is; apart from the set position only behind an encoder, or in error.
        true_position: f64 ["u"],
        /// Its true velocity.
        true_velocity: f64 ["u/s"],
        /// Its true acceleration.
        true_acceleration: f64 ["u/s²"],
    }
}

signals! {
    /// A slave. Positions are in its units.
    pub struct SlaveSignals of Slave {
        /// Set position, as the drive gets it; none until it is coupled, if it is to be from the start.
        position: Option<f64> ["u"] last,
        /// The same within its modulo turn; none if it does not turn.
        modulo_position: Option<f64> ["u"],
        /// Where its (first) master is in the same cycle; none before anything of it has come.
        master_position: Option<f64> ["master u"],
        /// The same within the master's modulo turn; none if that does not turn.
        master_modulo_position: Option<f64> ["master u"],
        /// Where the slave is when its coupling has it synchronous, at the latest; none of a coupling that leads to no
        /// such position.
        slave_sync_position: Option<f64> ["u"],
        /// Where the master is then, as the coupling sees it.
        master_sync_position: Option<f64> ["master u"],
        /// Set velocity.
        velocity: Option<f64> ["u/s"],
        /// Set acceleration.
        acceleration: Option<f64> ["u/s²"],
        /// Whether its set values are what its motion or its coupling asks for, or what its limits leave of that.
        guard: GuardStateName [""],
        /// How far its set position is from what is asked for.
        distance: f64 ["u"],
        /// Times its set position was set anew so far, in no step of a motion: switched on, homed, reset.
        set_anew: u32 [""],
        /// Its state in the PLCopen diagram.
        state: AxisStatus [""] last,
        /// How far its coupling is; none without one.
        phase: Option<CouplingPhase> [""],
        /// The cam plate that couples it, of several the first; none without one, or before it is active.
        cam_table: Option<u32> [""],
        /// Where the master is on that plate, unscaled, within the base cycle if it is cyclic (`ActualMasterCamPos`).
        cam_master_position: Option<f64> ["plate x"],
        /// Where the slave is on that plate, unscaled, without the strokes done (`ActualSlaveCamPos`).
        cam_slave_position: Option<f64> ["plate u"],
        /// Whether a plate waits to become active, or to go (`CamTableQueued`).
        cam_table_queued: bool [""],
        /// Whether written points wait to take effect (`CamDataQueued`).
        cam_data_queued: bool [""],
        /// Whether a scaling waits to take effect (`CamScalingPending`).
        cam_scaling_pending: bool [""],
        /// Why it is in error stop, by the NC's code; 0: it is not.
        error: u32 [""],
        /// Why a command was refused last, by the NC's code; 0: none was.
        refusal: u32 [""],
        /// Whether its program goes on; none without one.
        program: Option<ProgramState> [""] last,
        /// The step that its program waits for, or ended with, from 1.
        program_step: Option<u16> [""] last,
        /// What that step waits for, if it does: the field of it that is hardest to come by.
        program_waits_for: Option<WaitsFor> [""] last,
        /// What became of its program's last command; none while that is under way.
        program_outcome: Option<Outcome> [""] last,
        /// Cuts done so far, by its tool or by steps of its program.
        cuts: u64 [""],
        /// What kind of drive it has.
        drive_kind: DriveKindName [""],
        /// Whether the process of its drive is attached and lives; none if it is in no other process.
        drive_attached: Option<bool> [""],
        /// Own cycles since the heartbeat of that process changed; none before it did.
        drive_heartbeat_age: Option<u32> [""],
        /// The drive's state.
        drive_state: DriveStateName [""],
        /// Actual position.
        drive_position: f64 ["u"],
        /// Actual velocity.
        drive_velocity: f64 ["u/s"],
        /// Following error.
        following_error: f64 ["u"],
    }
}

/// The tables of `docs/SIGNALS.md`.
#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::signal::table;

    const DOCUMENT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/SIGNALS.md");

    /// To write it anew after a change: `UPDATE_DOCS=1 cargo test -p coaxle-receiver signals`.
    #[test]
    fn the_document_has_every_signal() {
        let path = std::path::Path::new(DOCUMENT);
        let written = std::fs::read_to_string(path).expect("the document");
        let (own, sender) = written.split_once("\n# ").expect("the sender's part");
        let (head, _) = own.split_once("## ").expect("the tables");
        let tables = [
            table::<NodeSignals>("The receiver"),
            table::<FarNodeSignals>("A far node"),
            table::<FarAxisSignals>("A far axis"),
            table::<VirtualAxisSignals>("A virtual axis"),
            table::<SlaveSignals>("A slave"),
        ];
        let expected = format!("{head}{}\n# {sender}", tables.join("\n"));
        if std::env::var_os("UPDATE_DOCS").is_some() {
            std::fs::write(path, &expected).expect("the document can be written");
        } else {
            assert_eq!(written, expected);
        }
    }
}
