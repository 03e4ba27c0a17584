//! The signals of a receiver: each is declared here, and computed where its value is at hand.

use coaxle_axis::drive::{DriveKind, DriveState};
use coaxle_axis::motion_plan::PlanFault;
use coaxle_axis::set_value_guard::GuardState;
use coaxle_axis::{AxisStatus, TravelDirection};
use coaxle_clock::common_time::CommonTimeLack;
use coaxle_clock::cycle_lock::CycleLockState;
use coaxle_clock::delay::DelayState;
use coaxle_clock::observer::{ObserverLine, ObserverState};
use coaxle_clock::timing::TimingState;
use coaxle_node::{Stamps, signals};
use coaxle_remote::{ContinuityState, FilterMode, FilterState};
use coaxle_slave::CouplingPhase;
use coaxle_source::Activity;

use crate::health::HealthName;
use crate::program::{Outcome, ProgramState, WaitsFor};

signals! {
    /// The receiver itself.
    pub struct NodeSignals of Node {
        /// Cycle number, skipped ones counted.
        cycle: u64 [""],
        /// Run of the node: the epoch in its frames.
        run: u64 [""],
        /// Cycles skipped.
        overruns: u64 [""] last "cycles skipped",
        /// The node's own judgement of its health.
        health: HealthName [""],
        /// Time by which the drives of its slaves are given the set values later than these are calculated: frames of
        /// slaves and far axes state it.
        hold_back_us: f64 ["µs"],
        /// State of the lock of its cycle to that of a far node; none without one.
        cycle_lock: Option<CycleLockState> [""] last,
        /// Time by which its cycle began later than the lock wants it.
        cycle_phase_us: Option<f64> ["µs"],
        /// Change of the period of its cycle by the lock, of the nominal one.
        cycle_period_ppm: Option<f64> ["ppm"],
        /// Time requests responded to.
        requests_answered: u64 [""],
        /// Time requests dropped because too many arrived in one cycle.
        requests_dropped: u64 [""],
        /// Time requests rejected before they reached the node.
        requests_refused: u64 [""],
        /// Beacons of its own timing channel responded to.
        beacons_answered: u64 [""],
        /// Beacons dropped because too many arrived in one cycle.
        beacons_dropped: u64 [""],
        /// Beacons rejected before they reached the node.
        beacons_refused: u64 [""],
    }
}

signals! {
    /// A followed node or a standby: its clock, and the counts of its messages.
    pub struct FarNodeSignals of FarNode {
        /// The receiver's judgement of its health.
        health: HealthName [""],
        /// True if the axes are read from it: for a standby, only after it has taken over.
        followed: bool [""],
        /// True if it could take over with its next frame: it is not followed, its frames arrive,
        /// and its clock is known.
        stands_by: bool [""],
        /// Take-overs among the node and its standbys.
        take_overs: u64 [""] last,
        /// True if it is enabled (`bEnable`).
        enabled: bool [""],
        /// Calculation of the set values while it is enabled (`eFilterMode`).
        mode: FilterMode [""],
        /// Re-initialisations by an order.
        re_initialisations: u32 [""],
        /// Changes of its parameters or its delay by an order.
        parameter_changes: u32 [""],
        /// Nominal cycle time in its frames; none before the first message.
        cycle_time_us: Option<f64> ["µs"],
        /// Run of the node that is followed.
        epoch: Option<u64> [""],
        /// Cycle count in the input image.
        count: Option<u64> [""],
        /// The cycle index in the input image (`iCycleIndex`).
        index: Option<u16> [""],
        /// Own cycles since the input image was updated.
        age_cycles: u32 [""],
        /// True if its clock is known (`bSynced`).
        synced: bool [""],
        /// The error of the clock (`iErrorId`), 0: none.
        error: u16 [""],
        /// The warning of the clock (`iWarningId`), 0: none.
        warning: u16 [""],
        /// Beats.
        beats: u32 [""] last "beats",
        /// Estimated drift of its clock against the own one (`fDrift`).
        drift_ppm: Option<f64> ["ppm"] last "drift estimated",
        /// The correction time applied to its axes; none where the mode uses none.
        correction_us: Option<f64> ["µs"],
        /// The correction time that `FB_TimeSync` has found (`fCorrectionTime`).
        time_sync_correction_us: Option<f64> ["µs"],
        /// The correction time of time mode.
        time_mode_correction_us: Option<f64> ["µs"],
        /// True if `FB_TimeSync` is in time mode (`bTimeMode`).
        time_mode: bool [""],
        /// The index read now minus the one read in the previous cycle (`iCycleIndexDiff`).
        cycle_index_diff: i32 [""],
        /// Cycles without new data (`iTotalEqualDataCounter`).
        total_equal_data: u64 [""],
        /// Cycles without new data in a row (`iConsecutiveEqualDataCounter`).
        consecutive_equal_data: u32 [""],
        /// State of the phase observer; none where it does not run.
        observer_state: Option<ObserverState> [""] last,
        /// Line of the arrivals that it follows.
        observer_line: Option<ObserverLine> [""] last,
        /// Standard deviation of the offset, estimated by the observer.
        offset_sigma_us: Option<f64> ["µs"] last,
        /// Fraction of its recent predictions that were within three standard deviations: 0.99 if
        /// its standard deviations are right.
        within_three_sigma: Option<f64> [""] last,
        /// Standard deviation of the drift, estimated by the observer.
        drift_sigma_ppm: Option<f64> ["ppm"] last,
        /// Estimated minus shown far time: the remainder to be slewed.
        slew_remaining_us: Option<f64> ["µs"],
        /// Configured offset of the correction time in force (`fDelayTimeOffset`): its axes are ahead by it,
        /// beside any error; none where the mode uses no correction time.
        time_offset_us: Option<f64> ["µs"],
        /// Normal part of the jitter of the arrivals, standard deviation.
        normal_jitter_us: Option<f64> ["µs"],
        /// Exponential part of the jitter of the arrivals, mean.
        exponential_jitter_us: Option<f64> ["µs"],
        /// The random walk of the drift with the best predictions.
        random_walk_ppm: Option<f64> ["ppm/√s"] last,
        /// Messages per measurement.
        block_length: Option<u16> [""] last,
        /// Detected jumps of the delay.
        shifts: u32 [""] last,
        /// Time of the last one, in the own clock.
        last_shift_s: Option<f64> ["s"],
        /// Steps of the drift after which the line was searched again.
        drift_steps: u32 [""] last,
        /// Lock restarts.
        relocks: u32 [""] last,
        /// Time of the last restart, in the own clock.
        last_relock_s: Option<f64> ["s"],
        /// State of the delay and its source; none where no phase observer runs.
        delay_state: Option<DelayState> [""] last,
        /// Assumed lead of the sender's time over the observer's line.
        delay_us: Option<f64> ["µs"] last "delay",
        /// Greatest error of the delay: half of the round trip, for any asymmetry of the paths; or
        /// the configured bound, if that is less.
        delay_uncertainty_us: Option<f64> ["µs"] last "… wrong by at most",
        /// True if the configured asymmetry exceeds the round trip.
        asymmetry_denied: bool [""] last,
        /// The part of the error that jitter causes, standard deviation.
        delay_jitter_us: Option<f64> ["µs"],
        /// Standard deviation of the delay at the configured asymmetry, or at equal path delays: by
        /// jitter and by the line.
        delay_sigma_us: Option<f64> ["µs"] last "… standard deviation",
        /// Age of the newest time exchange.
        delay_age_s: Option<f64> ["s"],
        /// Time exchanges used.
        exchanges: u64 [""] last,
        /// Time responses rejected.
        responses_refused: u64 [""] last,
        /// State of the timing channel; none without one, or where no phase observer runs.
        timing_state: Option<TimingState> [""] last "timing channel",
        /// Source of the stamps at both ends of the timing channel; none before the first response.
        timing_stamps: Option<Stamps> [""] last "… stamps",
        /// Standard deviation of the far clock by the timing channel.
        timing_sigma_us: Option<f64> ["µs"] last,
        /// Shortest recent round trip of its exchanges.
        timing_round_trip_us: Option<f64> ["µs"] last,
        /// Age of its newest exchange.
        timing_age_s: Option<f64> ["s"],
        /// Exchanges of the timing channel used.
        timing_exchanges: u64 [""] last,
        /// Exchanges of the timing channel rejected as impossible.
        timing_refused: u64 [""] last,
        /// Restarts of the timing channel because the clocks had moved.
        timing_restarts: u32 [""] last,
        /// State of the time that both nodes have in common; none without one in the config.
        common_time_state: Option<TimingState> [""] last "common time",
        /// Reason why there is none.
        common_time_lack: Option<CommonTimeLack> [""] last "… lacks",
        /// Distance of the far clock by the common time from where messages and beacons have it.
        common_time_apart_us: Option<f64> ["µs"] last "… apart",
        /// Greatest error of the common time, of both nodes together, as they state it.
        common_time_bound_us: Option<f64> ["µs"] last,
        /// Standard deviation of the far clock by the common time.
        common_time_sigma_us: Option<f64> ["µs"] last,
        /// Age of its newest reading.
        common_time_age_s: Option<f64> ["s"],
        /// Readings used.
        common_time_readings: u64 [""] last,
        /// Restarts of it because the clocks had moved.
        common_time_restarts: u32 [""] last,
        /// Beacons sent.
        beacons_sent: u64 [""],
        /// Good responses to beacons.
        beacons_received: u64 [""] last,
        /// Rejected responses to beacons.
        beacons_rejected: u64 [""] last,
        /// The rate of its cycles relative to the stated cycle time, by its frames of a second;
        /// positive: fast.
        pace_ppm: Option<f64> ["ppm"] last,
        /// Age of its newest frame when the cycle really began: since its generation by the far clock, whose delay is known or zero.
        frame_age_us: Option<f64> ["µs"],
        /// Presentation delay of its newest frame; none if its values are moved to now.
        present_after_us: Option<f64> ["µs"] last "shown later by",
        /// Presentation delay with which 99.9 % of the own cycles of the last minute would have found the frames that
        /// they need: the age of the newest frame, and a cycle of each side.
        needed_present_after_us: Option<f64> ["µs"] last,
        /// Lag of its axes, of that delay, in its clock; none if their values are moved to now.
        presentation_lag_us: Option<f64> ["µs"] last,
        /// Lag minus the delay needed; negative: frames come too late, and the rest is predicted.
        presentation_margin_us: Option<f64> ["µs"] last,
        /// Plans of its axes received.
        plans_received: u64 [""] last,
        /// Plans refused.
        plans_refused: u64 [""] last,
        /// The last fault of a plan; none without any.
        plan_fault: Option<PlanFault> [""] last,
        /// Accepted messages: in order, duplicates, late, waiting, dropped because of an overflow,
        /// or foreign.
        received: u64 [""] last,
        /// Messages that were the newest of their run when their cycle took them in.
        in_order: u64 [""],
        /// Expected messages, by the sender's count: from the first of each run to the newest. They
        /// are in order, late or lost.
        expected: u64 [""],
        /// Missing messages, by the sender's count: lost on the way, or of cycles that the sender skipped. No frame
        /// tells which; the sender counts the latter as `overruns`.
        lost: u64 [""] last "messages lost",
        /// Duplicate messages.
        duplicates: u64 [""] last,
        /// Overtaken messages.
        late: u64 [""] last,
        /// Messages too old to use.
        stale: u64 [""] last,
        /// Late messages from before the first of their run, or 64 and more behind the newest: not
        /// among the expected ones, as they may be duplicates.
        outdated: u64 [""],
        /// Messages that arrived after the ideal start of the cycle and are not due yet.
        waiting: u32 [""],
        /// Messages dropped because of a full inbox.
        overflow: u64 [""],
        /// New runs of the node.
        restarts: u64 [""] last,
        /// Frames of other runs that were not followed: strays, or those of a duplicate sender.
        foreign_frames: u64 [""] last "frames of others",
        /// Run of a duplicate sender, while its frames arrive.
        rival_epoch: Option<u64> [""],
        /// Rejected frames.
        rejected: u64 [""] last,
        /// Rejected frames of another format version.
        rejected_wrong_version: u64 [""],
        /// Rejected frames that are truncated.
        rejected_truncated: u64 [""],
        /// Rejected frames with a wrong check sum.
        rejected_wrong_checksum: u64 [""],
        /// Rejected frames with malformed bytes.
        rejected_malformed: u64 [""],
        /// Rejected frames with trailing bytes.
        rejected_trailing_bytes: u64 [""],
        /// Rejected frames with a cycle time out of range.
        rejected_cycle_time_out_of_range: u64 [""],
        /// Rejected frames with a presentation delay above 4 s.
        rejected_present_after_out_of_range: u64 [""],
        /// Rejected frames of another node under this one's key.
        rejected_foreign_sender: u64 [""],
        /// Rejected frames with none of the followed axes.
        rejected_axis_missing: u64 [""],
        /// Rejected frames with implausible values in all followed axes.
        rejected_implausible: u64 [""],
    }
}

signals! {
    /// A followed axis, as received and as corrected.
    pub struct FarAxisSignals of FarAxis {
        /// Mode that calculated the set values (`eFilterState`); none before the first message.
        state: Option<FilterState> [""],
        /// Continuity of the set values with those of the far axis.
        continuity: ContinuityState [""],
        /// True if the set values are synchronised (`bSynced`).
        synced: bool [""],
        /// The error of the axis, or of its node's clock (`iErrorId`), 0: none.
        error: u16 [""],
        /// Own cycles since the axis was last received.
        age_cycles: u32 [""],
        /// Frames without the axis, or with implausible values of it.
        missing: u64 [""],
        /// Received error code, 0: none.
        received_error: u32 [""],
        /// Received set position.
        received_position: Option<f64> ["u"],
        /// Received set velocity.
        received_velocity: Option<f64> ["u/s"],
        /// Received set acceleration.
        received_acceleration: Option<f64> ["u/s²"],
        /// Corrected set position.
        corrected_position: Option<f64> ["u"],
        /// Corrected set velocity.
        corrected_velocity: Option<f64> ["u/s"],
        /// Received minus corrected set position (`fPositionDiff`).
        position_diff: Option<f64> ["u"],
        /// Received minus corrected set velocity (`fVeloDiff`).
        velocity_diff: Option<f64> ["u/s"],
        /// The correction time applied to it; none where the mode uses none.
        correction_us: Option<f64> ["µs"],
        /// True if the set values lie between two received frames, because their node has them shown later; none if it
        /// has not.
        interpolated: Option<bool> [""],
        /// Own cycles in which a frame that was to be shown had not arrived, so that the set values were predicted.
        extrapolated_cycles: u64 [""] last,
        /// True if the set values are those of its node's plan, as a frame is missing; none without a plan.
        planned: Option<bool> [""],
        /// Own cycles in which the set values were those of the plan.
        planned_cycles: u64 [""] last,
        /// Time from the instant shown to the end of the promise; negative: the promise is over.
        promised_ahead_us: Option<f64> ["µs"],
        /// Plans that a sample or a later plan has contradicted: they are not used.
        plan_contradictions: u64 [""] last,
        /// Wraps of the received position, which is configured as continuous: `position =
        /// "within-turn"` and `modulo` are missing in the config.
        wraps: u32 [""] last,
        /// Step of the position at the newest wrap.
        wrap_length: Option<f64> ["u"],
        /// Standard deviation of the corrected set position as a prediction, while the axis moves
        /// as observed: the time error × velocity, and half of the greatest jerk observed × age³,
        /// or the greatest acceleration × age² where that is less.
        prediction_sigma: Option<f64> ["u"] last,
        /// The instant of the far node's ideal time that the set values refer to.
        far_time_ns: Option<i64> ["ns"],
        /// Bandwidth of the smoothing of an encoder axis; none for other axes.
        encoder_bandwidth: Option<f64> ["rad/s"],
        /// Standard deviation of the position derived from increments.
        position_sigma: Option<f64> ["u"] last,
        /// Standard deviation of the velocity derived from increments.
        velocity_sigma: Option<f64> ["u/s"] last,
        /// Direction of travel by its increments, current or last; none before it moved.
        travel: Option<TravelDirection> [""],
        /// True if its set values have settled since the first increments; before, it is not a master.
        acquired: Option<bool> [""],
        /// True if it came to rest ahead of its increments and moves back (trim).
        trimming: Option<bool> [""],
        /// Counts rejected because no motion explains them.
        refused_jumps: Option<u32> [""] last,
        /// Resets of its counter.
        counter_resets: Option<u32> [""],
    }
}

signals! {
    /// A virtual axis of the receiver's own, as its slaves follow it and its true motion.
    pub struct VirtualAxisSignals of VirtualAxis {
        /// Set position; with an encoder, the measured one.
        position: f64 ["u"],
        /// Set velocity.
        velocity: f64 ["u/s"],
        /// Set acceleration.
        acceleration: f64 ["u/s²"],
        /// End position of the current motion; the set position for a motion without end.
        target_position: f64 ["u"],
        /// Current activity.
        activity: Activity [""],
        /// True if it is enabled.
        operational: bool [""],
        /// NC error code; 0: none.
        error: u32 [""],
        /// True position; differs from the set position only with an encoder, or in error.
        true_position: f64 ["u"],
        /// True velocity.
        true_velocity: f64 ["u/s"],
        /// True acceleration.
        true_acceleration: f64 ["u/s²"],
    }
}

signals! {
    /// A slave. Positions are in its units.
    pub struct SlaveSignals of Slave {
        /// Set position of the drive; none before coupling, if coupled from the start.
        position: Option<f64> ["u"] last,
        /// Set position within its modulo period; none without one.
        modulo_position: Option<f64> ["u"],
        /// Position of its (first) master in the same cycle; none before the first data.
        master_position: Option<f64> ["master u"],
        /// Position of the master within its modulo period; none without one.
        master_modulo_position: Option<f64> ["master u"],
        /// Position of the slave at which its coupling has it synchronous at the latest; none for a
        /// coupling without such a position.
        slave_sync_position: Option<f64> ["u"],
        /// Position of the master at that point, as the coupling sees it.
        master_sync_position: Option<f64> ["master u"],
        /// Set velocity.
        velocity: Option<f64> ["u/s"],
        /// Set acceleration.
        acceleration: Option<f64> ["u/s²"],
        /// State of the guard, which keeps the limits.
        guard: GuardState [""],
        /// Distance of the set position from the requested one.
        distance: f64 ["u"],
        /// Set position presets outside a motion: switched on, homed, reset.
        set_anew: u32 [""],
        /// State in the PLCopen diagram.
        state: AxisStatus [""] last,
        /// Phase of its coupling; none without one.
        phase: Option<CouplingPhase> [""] last,
        /// The cam plate that couples it, the first of several; none without one, or before it is active.
        cam_table: Option<u32> [""],
        /// Position of the master on that plate, unscaled, within the base cycle if it is cyclic
        /// (`ActualMasterCamPos`).
        cam_master_position: Option<f64> ["plate x"],
        /// Position of the slave on that plate, unscaled, without the completed strokes
        /// (`ActualSlaveCamPos`).
        cam_slave_position: Option<f64> ["plate u"],
        /// True if the activation or the removal of a plate is pending (`CamTableQueued`).
        cam_table_queued: bool [""],
        /// True if written points are pending (`CamDataQueued`).
        cam_data_queued: bool [""],
        /// True if a scaling is pending (`CamScalingPending`).
        cam_scaling_pending: bool [""],
        /// NC error code of the error stop; 0: none.
        error: u32 [""],
        /// NC error code of the last refused command; 0: none.
        refusal: u32 [""],
        /// State of its program; none without one.
        program: Option<ProgramState> [""] last,
        /// The step that its program waits for, or ended with, from 1.
        program_step: Option<u16> [""] last,
        /// Condition that the step waits for, if any: the field that is hardest to meet.
        program_waits_for: Option<WaitsFor> [""] last,
        /// Result of its program's last command; none while that is under way.
        program_outcome: Option<Outcome> [""] last,
        /// Cuts done, by its tool or by steps of its program.
        cuts: u64 [""],
        /// Kind of drive.
        drive_kind: DriveKind [""],
        /// True if the process of its drive is attached and alive; none if the drive is not in
        /// another process.
        drive_attached: Option<bool> [""],
        /// Own cycles since the heartbeat of that process changed; none before the first change.
        drive_heartbeat_age: Option<u32> [""],
        /// Time by which the drive is given the set values later; 0: at once, or earlier.
        held_back_us: f64 ["µs"],
        /// Set position that the drive is given in this cycle; none before coupling, if coupled from the start.
        shown_position: Option<f64> ["u"],
        /// Times that an error or a stop set the axis back to what its drive was given.
        set_back: u32 [""],
        /// State of the drive.
        drive_state: DriveState [""],
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

    /// Rewrites it after a change: `UPDATE_DOCS=1 cargo test -p coaxle-receiver signals`.
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
