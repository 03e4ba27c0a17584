//! A master that an encoder measures: [`EncoderMaster`].

use ::coaxle_axis::TravelDirection;
use coaxle_clock::Seconds;
use coaxle_remote::{EncoderMaster, EncoderOutput, EncoderParameters, EncoderSample, Smoothing};

use crate::failure::{Failure, wrong_parameter};
use crate::handle::{HandleHead, call, free, handle, make, plain};
use crate::memory::{check_if_any, finite, growing, read, readable, writable, write, write_if_any};
use crate::phase::cycle_time;

/// The master of an encoder: counts in, smooth set values with bounded acceleration and jerk out, at any instant.
///
/// Each cycle: `coaxle_encoder_update`, with the count if there is a new one.
#[repr(C)]
#[derive(Debug)]
pub struct coaxle_encoder {
    head: HandleHead,
    master: EncoderMaster,
}

handle!(coaxle_encoder, b"encoder1");

/// Parameters of the master of an encoder. `coaxle_encoder_parameters_init` sets all but the increment.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_encoder_parameters {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// Width of the counter, 8 to 64 bits.
    pub counter_bits: u32,
    /// Cycle time of the set values, ns: 100 000 to 100 000 000.
    pub cycle_time_ns: i64,
    /// Length of one count, u.
    pub increment: f64,
    /// Cycle time in which the counter is read, s; 0: that of the set values.
    pub sampling_time_s: f64,
    /// Time constant of the smoothing, s; 0: the best for the increment.
    pub smoothing_s: f64,
    /// Speed that the axis never exceeds, u/s. A count that needs 1.5 times as much is refused.
    pub max_speed: f64,
    /// Standard deviation of the shaft's vibration, u.
    pub vibration: f64,
    /// Standard deviation of the instants at which the counter is read, s.
    pub timing_sigma_s: f64,
    /// Largest acceleration of the set values, u/s².
    pub acceleration_limit: f64,
    /// Largest jerk of the set values, u/s³.
    pub jerk_limit: f64,
    /// Largest speed at which a master at rest too far ahead walks back, u/s.
    pub trim_speed: f64,
}

/// A reading of the counter. It does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_encoder_sample {
    /// The count. Bits beyond the width of the counter are ignored; a signed one is passed as its two's complement.
    pub count: u64,
    /// Sampling cycles since the sample before: 1, or more after lost ones. The sample of 0 cycles is the last one again.
    pub cycles: u32,
    /// 0.
    pub reserved: u32,
}

/// Set values of the master of an encoder, and what is known about them.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_encoder_state {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// Current or last direction: 1, -1, or 0 before the first motion.
    pub direction: i32,
    /// Other than 0 if no edge has come for a quarter of a second, or none that is a motion.
    pub is_standstill: u32,
    /// Other than 0 while the set values walk back to the position of the axis at rest.
    pub is_trimming: u32,
    /// Other than 0 once the set values have settled and keep their limits.
    pub is_acquired: u32,
    /// Refused counts that no motion explains.
    pub refused_jumps: u32,
    /// Presets of the counter.
    pub counter_resets: u32,
    /// 0.
    pub reserved: u32,
    /// Set position, u.
    pub position: f64,
    /// Set velocity, u/s.
    pub velocity: f64,
    /// Set acceleration, u/s².
    pub acceleration: f64,
    /// Standard deviation of the estimated position, u.
    pub position_sigma: f64,
    /// Standard deviation of the estimated velocity, u/s.
    pub velocity_sigma: f64,
}

growing! {
    coaxle_encoder_parameters, 88;
    coaxle_encoder_state, 72;
}

/// Sets the parameters of an encoder with this increment (u), at this cycle time (ns), to their defaults, but for `struct_size`, which
/// the caller has set. The defaults are for axes in millimetres.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_encoder_parameters_init(
    parameters: *mut coaxle_encoder_parameters,
    increment: f64,
    cycle_time_ns: i64,
) -> i32 {
    // SAFETY: as for this function.
    plain(|| unsafe {
        // Reads nothing but the size.
        let _ = writable(parameters, "parameters")?;
        let given = EncoderParameters {
            increment,
            ..EncoderParameters::default()
        };
        write(
            parameters,
            &coaxle_encoder_parameters::of(&given, cycle_time_ns),
        )
    })
}

/// Makes the master of an encoder, and passes it out in `out`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_encoder_new(
    parameters: *const coaxle_encoder_parameters,
    out: *mut *mut coaxle_encoder,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        make(out, || {
            let given = read(parameters)?;
            let cycle = cycle_time(given.cycle_time_ns)?;
            let checked = given.taken()?.checked(cycle.span());
            let checked = checked.map_err(wrong_parameter)?;
            Ok(coaxle_encoder {
                head: HandleHead::new::<coaxle_encoder>(),
                master: EncoderMaster::new(&checked),
            })
        })
    }
}

/// Frees the master of an encoder; `NULL` is left alone.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_encoder_free(encoder: *mut coaxle_encoder) {
    // SAFETY: as for this function.
    unsafe { free(encoder) }
}

/// Runs a cycle, `elapsed` cycles after the one before.
///
/// `sample` is the new reading, `NULL` without one. The set values belong to the instant `horizon_s` after the newest reading, which is
/// a cycle more with every cycle without one. `state` may be `NULL`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_encoder_update(
    encoder: *mut coaxle_encoder,
    sample: *const coaxle_encoder_sample,
    horizon_s: f64,
    elapsed: u32,
    state: *mut coaxle_encoder_state,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(encoder, |own| {
            check_if_any(state)?;
            let sample = match sample.is_null() {
                true => None,
                false => Some(readable(sample, "sample")?.taken()),
            };
            let horizon = Seconds(finite("horizon_s", horizon_s)?);
            let output = own.master.update(sample, horizon, elapsed);
            write_if_any(state, &coaxle_encoder_state::of(&output))
        })
    }
}

/// Forgets where the encoder was: the next reading is the first one.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_encoder_restart(encoder: *mut coaxle_encoder) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(encoder, |own| {
            own.master.restart();
            Ok(())
        })
    }
}

impl coaxle_encoder_parameters {
    fn of(given: &EncoderParameters, cycle_time_ns: i64) -> Self {
        let smoothing_s = match given.smoothing {
            Smoothing::Auto => 0.0,
            Smoothing::Time(Seconds(time)) => time,
        };
        Self {
            struct_size: 0,
            counter_bits: given.counter_bits.into(),
            cycle_time_ns,
            increment: given.increment,
            sampling_time_s: given.sampling_time.0,
            smoothing_s,
            max_speed: given.max_speed,
            vibration: given.vibration,
            timing_sigma_s: given.timing_sigma.0,
            acceleration_limit: given.acceleration_limit,
            jerk_limit: given.jerk_limit,
            trim_speed: given.trim_speed,
        }
    }

    fn taken(&self) -> Result<EncoderParameters, Failure> {
        let bits = self.counter_bits;
        Ok(EncoderParameters {
            increment: self.increment,
            sampling_time: Seconds(self.sampling_time_s),
            smoothing: match self.smoothing_s {
                0.0 => Smoothing::Auto,
                time => Smoothing::Time(Seconds(time)),
            },
            max_speed: self.max_speed,
            vibration: self.vibration,
            timing_sigma: Seconds(self.timing_sigma_s),
            acceleration_limit: self.acceleration_limit,
            jerk_limit: self.jerk_limit,
            trim_speed: self.trim_speed,
            counter_bits: u8::try_from(bits)
                .map_err(|_| Failure::range("counter_bits", bits, "8 to 64"))?,
        })
    }
}

impl coaxle_encoder_sample {
    const fn taken(&self) -> EncoderSample {
        EncoderSample::next(self.count).after(self.cycles)
    }
}

impl coaxle_encoder_state {
    fn of(output: &EncoderOutput) -> Self {
        Self {
            struct_size: 0,
            direction: match output.direction {
                None => 0,
                Some(TravelDirection::Forward) => 1,
                Some(TravelDirection::Backward) => -1,
            },
            is_standstill: output.standstill.into(),
            is_trimming: output.trimming.into(),
            is_acquired: output.acquired.into(),
            refused_jumps: output.refused_jumps,
            counter_resets: output.counter_resets,
            reserved: 0,
            position: output.set.position,
            velocity: output.set.velocity,
            acceleration: output.set.acceleration,
            position_sigma: output.position_sigma,
            velocity_sigma: output.velocity_sigma,
        }
    }
}
