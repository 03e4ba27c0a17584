//! Conditioning of a far axis that is only measured: a smooth master from its increments, in place
//! of the extrapolation.

use coaxle_axis::TravelDirection;
use coaxle_clock::time_sync::WrongParameter;
use coaxle_clock::{CycleTime, Seconds};
use coaxle_curve::profile::Kinematics;
use coaxle_remote::{
    CheckedEncoder, EncoderMaster, EncoderOutput, EncoderParameters, EncoderSample, Smoothing,
};

use crate::signals::FarAxisSignals;

/// The conditioning of one far axis.
#[derive(Debug)]
pub(super) struct Encoder {
    own: CycleTime,
    parameters: EncoderParameters,
    /// Cycle in which the far node reads its counter; none before its first frame.
    sampled_every: Option<CycleTime>,
    checked: CheckedEncoder,
    master: EncoderMaster,
    /// Received sample that is not processed yet, with its count.
    fresh: Option<(Kinematics, u64)>,
    /// The count of the newest processed sample.
    count: Option<u64>,
    /// Own cycles since that sample.
    cycles: u32,
    output: EncoderOutput,
}

impl Encoder {
    /// Creates it for `own`, the receiver's cycle time; the far node's is known with its first frame.
    pub(super) fn new(
        own: CycleTime,
        parameters: EncoderParameters,
    ) -> Result<Self, WrongParameter> {
        let checked = parameters.checked(own.span())?;
        Ok(Self {
            own,
            parameters,
            sampled_every: None,
            checked,
            master: EncoderMaster::new(&checked),
            fresh: None,
            count: None,
            cycles: 0,
            output: EncoderOutput::default(),
        })
    }

    /// Restarts for a far node that reads its counter in cycles of this length: the next sample is
    /// the first.
    pub(super) fn restart(&mut self, sampled_every: CycleTime) {
        // Only another sampling time changes the smoothing.
        if self.sampled_every.replace(sampled_every) != Some(sampled_every) {
            self.checked = self.for_samples(sampled_every);
            self.master = EncoderMaster::new(&self.checked);
        }
        self.forget();
    }

    /// A smoothing time that is too short for such infrequent samples is replaced by the automatic one.
    fn for_samples(&self, every: CycleTime) -> CheckedEncoder {
        let sampled = EncoderParameters {
            sampling_time: Seconds(every.as_secs_f64()),
            ..self.parameters
        };
        let automatic = EncoderParameters {
            smoothing: Smoothing::Auto,
            ..sampled
        };
        let task = self.own.span();
        sampled
            .checked(task)
            .or_else(|_| automatic.checked(task))
            // Without a valid smoothing for these samples the one of the config stays in force.
            .unwrap_or(self.checked)
    }

    /// Restarts at a position unrelated to the previous one: the next sample is the first.
    pub(super) fn forget(&mut self) {
        self.master.restart();
        self.count = None;
        self.output = EncoderOutput {
            // Counts of events outlive a restart: a reader that takes differences would see them fall.
            refused_jumps: self.output.refused_jumps,
            counter_resets: self.output.counter_resets,
            ..EncoderOutput::default()
        };
    }

    /// Takes the axis's values of the newest frame, with this count.
    pub(super) const fn take(&mut self, set: &Kinematics, count: u64) {
        self.fresh = Some((*set, count));
    }

    /// Runs one cycle. `age` is that of the newest sample in the mode in force; none if the axis is
    /// to be as received: then a sample is new in the cycle of its arrival.
    pub(super) fn update(&mut self, age: Option<Seconds>, elapsed: u32) {
        self.cycles = self.cycles.saturating_add(elapsed);
        let sample = self.sample();
        let since = f64::from(self.cycles) * self.own.as_secs_f64();
        // The master needs an age in any mode. Without a clock it is that of a sample which is new on arrival.
        let horizon = age.unwrap_or(Seconds(since));
        self.output = self.master.update(sample, horizon, elapsed);
    }

    fn sample(&mut self) -> Option<EncoderSample> {
        let (set, count) = self.fresh.take()?;
        let sample = EncoderSample::next_position(set.position, self.parameters.increment)?;
        let behind = self
            .count
            .replace(count)
            // The first sample counts as one cycle. A count that fell back gives 0 and no underflow.
            .map_or(1, |last| count - last.min(count));
        self.cycles = 0;
        Some(sample.after(u32::try_from(behind).unwrap_or(u32::MAX)))
    }

    /// The set values; none until they have settled.
    pub(super) fn set(&self) -> Option<Kinematics> {
        self.output.acquired.then_some(self.output.set)
    }

    /// Current or last direction of the axis by its increments.
    pub(super) const fn travel(&self) -> Option<TravelDirection> {
        self.output.direction
    }

    pub(super) fn show(&self, signals: &mut FarAxisSignals) {
        let output = &self.output;
        signals.encoder_bandwidth = Some(self.checked.bandwidth());
        signals.position_sigma = Some(output.position_sigma);
        signals.velocity_sigma = Some(output.velocity_sigma);
        signals.travel = output.direction;
        signals.acquired = Some(output.acquired);
        signals.trimming = Some(output.trimming);
        signals.refused_jumps = Some(output.refused_jumps);
        signals.counter_resets = Some(output.counter_resets);
    }
}
