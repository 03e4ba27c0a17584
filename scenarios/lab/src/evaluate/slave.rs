//! Figures of one slave.

use coaxle_axis::AxisStatus;
use coaxle_clock::Span;
use coaxle_node::config::Unit;
use coaxle_receiver::SlaveConfig;
use coaxle_receiver::signals::SlaveSignals;
use coaxle_sim::Shares;
use coaxle_slave::CouplingPhase;

use super::coupling::CouplingJudge;
use super::cuts::{CutsJudge, SlaveCycle, TrueMotion};
use crate::record::ReceiverCycle;
use crate::summary::SlaveSummary;

/// Judges one slave by its signals.
#[derive(Debug)]
pub(super) struct SlaveJudge {
    name: String,
    /// The slave that is its master, by number; none if that is the far axis.
    master: Option<usize>,
    previous: Option<(i64, SlaveSignals)>,
    in_sync_cycles: u64,
    cycles: u64,
    coupling: CouplingJudge,
    cuts: CutsJudge,
    last_error: Option<u32>,
    last_refusal: Option<u32>,
    summary: SlaveSummary,
}

impl SlaveJudge {
    /// The judge of a slave, with the index of its master among the slaves of its far axis, if that
    /// is a slave, and the units of both.
    pub(super) fn new(
        config: &SlaveConfig,
        master: Option<usize>,
        [own, masters]: [Unit; 2],
    ) -> Self {
        Self {
            name: config.name.to_string(),
            master,
            previous: None,
            in_sync_cycles: 0,
            cycles: 0,
            coupling: CouplingJudge::default(),
            cuts: CutsJudge::new(config, masters),
            last_error: None,
            last_refusal: None,
            summary: SlaveSummary {
                unit: own,
                ..SlaveSummary::default()
            },
        }
    }

    /// Takes the next cycle of its receiver, and the slave's part of it.
    pub(super) fn push(
        &mut self,
        record: &ReceiverCycle,
        slave: &SlaveSignals,
        truth: &impl TrueMotion,
    ) {
        let at_ns = record.at_ns;
        let before = self.previous.replace((at_ns, *slave));
        self.cycles += 1;
        self.in_sync_cycles += u64::from(slave.phase.is_some_and(CouplingPhase::is_in_sync));
        self.note_events(before.map(|(_, before)| before).as_ref(), slave);
        if let Some((before_ns, before)) = before {
            let passed = Span::from_nanos(at_ns - before_ns).as_secs_f64();
            self.measure(&before, slave, passed);
        }
        let master = self.master_in(record);
        self.coupling.push(at_ns, master, slave);
        let moment = SlaveCycle::new(slave, at_ns, master);
        // The truth of a local master is its own set position, as no network lies between.
        self.cuts.push(moment, self.master.is_none(), truth);
        let summary = &mut self.summary;
        let following_error = slave.following_error.abs();
        summary.following_error_max = summary.following_error_max.max(following_error);
    }

    /// Position of the master for this slave.
    fn master_in(&self, record: &ReceiverCycle) -> Option<f64> {
        match self.master {
            None => record.axis.corrected_position,
            Some(n) => record.slaves.get(n)?.position,
        }
    }

    fn note_events(&mut self, before: Option<&SlaveSignals>, slave: &SlaveSignals) {
        let failed = slave.state == AxisStatus::ErrorStop;
        // An error stop lasts for many cycles, and counts once.
        if failed && before.is_none_or(|before| before.state != AxisStatus::ErrorStop) {
            self.summary.errors += 1;
            self.last_error = Some(slave.error);
        }
        // Refusals of later commands replace earlier ones, and stay after the next accepted one.
        if slave.refusal != 0 {
            self.last_refusal = Some(slave.refusal);
        }
    }

    /// Jumps are counted only under set values: power, homing and reset set the position.
    fn measure(&mut self, before: &SlaveSignals, slave: &SlaveSignals, passed: f64) {
        let is_set_anew = |slave: &SlaveSignals| {
            matches!(
                slave.state,
                AxisStatus::Disabled | AxisStatus::Standstill | AxisStatus::Homing
            )
        };
        // The way back to what the drive was given is no motion.
        let is_set_back = before.set_back != slave.set_back;
        if is_set_anew(before) || is_set_anew(slave) || is_set_back || passed <= 0.0 {
            return;
        }
        let (Some(from), Some(to)) = (before.position, slave.position) else {
            return;
        };
        let (Some(start), Some(end)) = (before.velocity, slave.velocity) else {
            return;
        };
        let summary = &mut self.summary;
        // The trapezoidal rule is exact for a constant acceleration, and off by j·T³/12 with a jerk.
        let jump = (to - from - 0.5 * (start + end) * passed).abs();
        summary.position_jump_max = summary.position_jump_max.max(jump);
        summary.velocity_max = summary.velocity_max.max(end.abs());
        let acceleration = ((end - start) / passed).abs();
        summary.acceleration_max = summary.acceleration_max.max(acceleration);
    }

    /// Ends the run; `shares` are the greatest shares of its limits that its set positions reached.
    pub(super) fn finish(mut self, shares: Option<Shares>) -> (String, SlaveSummary) {
        let code = |code| format!("{code:#06x}");
        self.summary.last_error = self.last_error.map(code);
        self.summary.last_refusal = self.last_refusal.map(code);
        self.summary.velocity_share_max = shares.map(|shares| shares.velocity);
        self.summary.acceleration_share_max = shares.map(|shares| shares.acceleration);
        self.summary.jerk_share_max = shares.map(|shares| shares.jerk);
        if self.cycles > 0 {
            self.summary.in_sync_share = self.in_sync_cycles as f64 / self.cycles as f64;
        }
        if let Some((_, last)) = self.previous {
            self.summary.last = last;
        }
        self.summary.coupling = self.coupling.finish();
        self.summary.cuts = self.cuts.finish();
        (self.name, self.summary)
    }
}
