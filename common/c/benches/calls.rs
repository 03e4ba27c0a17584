//! Cost of a call from C beside the same call in Rust: both at once, so that the difference is of one machine and one hour.
#![allow(missing_docs, unsafe_code)]

use core::ptr::null_mut;
use std::hint::black_box;

use coaxle_c::*;
use coaxle_clock::cycle_lock::FarPhase;
use coaxle_clock::far_clock::{DelaySource, FarClock};
use coaxle_clock::observer::ObserverParameters;
use coaxle_clock::{CycleLock, CycleTime, Instant, Seconds, Span};
use coaxle_remote::{EncoderMaster, EncoderParameters, EncoderSample};
use criterion::{Criterion, criterion_group, criterion_main};

const CYCLE_NS: i64 = 1_000_000;

fn cycle_time() -> CycleTime {
    CycleTime::new(Span::from_nanos(CYCLE_NS)).expect("within its range")
}

/// A struct of zeros that says its size.
fn sized<T>() -> T {
    // SAFETY: all structs of the interface are plain numbers, the first a `u32`.
    unsafe {
        let mut zero: T = core::mem::zeroed();
        (&raw mut zero).cast::<u32>().write(size_of::<T>() as u32);
        zero
    }
}

/// A message, and the cycle that it is for, of a far clock that is 50 ppm fast.
fn far_clock(c: &mut Criterion) {
    let arrival = |count: i64| count * CYCLE_NS - count * CYCLE_NS / 20_000 + 100_000;
    let mut group = c.benchmark_group("a message and a cycle of a far clock");
    group.bench_function("Rust", |b| {
        let parameters = ObserverParameters::default();
        let mut clock =
            FarClock::new(cycle_time(), parameters, DelaySource::Off, 1).expect("good parameters");
        let mut count = 0;
        b.iter(|| {
            count += 1;
            let at = Instant::from_nanos(arrival(count));
            clock.message(1, count as u64, at, None);
            let now = Instant::from_nanos(count * CYCLE_NS + 400_000);
            let _ = black_box(clock.cycle(now, |_, _| {}));
            // What the call from C passes out.
            black_box(clock.far_time_at(now))
        });
    });
    group.bench_function("C", |b| {
        let parameters = coaxle_far_clock_parameters {
            cycle_time_ns: CYCLE_NS,
            run: 1,
            ..sized()
        };
        let mut clock = null_mut();
        // SAFETY: the rules of the header.
        let code = unsafe { coaxle_far_clock_new(&raw const parameters, &raw mut clock) };
        assert_eq!(code, COAXLE_OK);
        let (mut message, mut time) = (sized::<coaxle_message>(), sized::<coaxle_far_time>());
        message.epoch = 1;
        let mut count = 0;
        b.iter(|| {
            count += 1;
            (message.count, message.arrived_ns) = (count as u64, arrival(count));
            let now = count * CYCLE_NS + 400_000;
            // SAFETY: the rules of the header.
            unsafe {
                let _ = coaxle_far_clock_message(clock, black_box(&raw const message));
                coaxle_far_clock_cycle(clock, now, black_box(&raw mut time))
            }
        });
        // SAFETY: made above.
        unsafe { coaxle_far_clock_free(clock) };
    });
}

/// A cycle of an encoder's master, whose axis moves by 7.3 counts in it.
fn encoder(c: &mut Criterion) {
    let count = |cycle: u64| 73 * cycle / 10;
    let mut group = c.benchmark_group("a cycle of an encoder's master");
    group.bench_function("Rust", |b| {
        let parameters = EncoderParameters {
            increment: 0.01,
            ..EncoderParameters::default()
        };
        let checked = parameters.checked(cycle_time().span());
        let mut master = EncoderMaster::new(&checked.expect("good parameters"));
        let mut cycle = 0;
        b.iter(|| {
            cycle += 1;
            let sample = EncoderSample::next(black_box(count(cycle)));
            black_box(master.update(Some(sample), Seconds::ZERO, 1))
        });
    });
    group.bench_function("C", |b| {
        let (mut parameters, mut encoder) = (sized(), null_mut());
        // SAFETY: the rules of the header.
        let code = unsafe {
            let _ = coaxle_encoder_parameters_init(&raw mut parameters, 0.01, CYCLE_NS);
            coaxle_encoder_new(&raw const parameters, &raw mut encoder)
        };
        assert_eq!(code, COAXLE_OK);
        let mut state: coaxle_encoder_state = sized();
        let mut cycle = 0;
        b.iter(|| {
            cycle += 1;
            let sample = coaxle_encoder_sample {
                count: count(cycle),
                cycles: 1,
                reserved: 0,
            };
            let (sample, state) = (black_box(&raw const sample), black_box(&raw mut state));
            // SAFETY: the rules of the header.
            unsafe { coaxle_encoder_update(encoder, sample, 0.0, 1, state) }
        });
        // SAFETY: made above.
        unsafe { coaxle_encoder_free(encoder) };
    });
}

/// A cycle of a lock, which is the cheapest call with a struct.
fn cycle_lock(c: &mut Criterion) {
    let mut group = c.benchmark_group("a cycle of a lock");
    group.bench_function("Rust", |b| {
        let mut lock = CycleLock::new(cycle_time(), Span::ZERO);
        let phase = FarPhase {
            age: Seconds(1e-4),
            delay: Seconds(0.0),
            drift_ppm: 50.0,
            cycle_time: cycle_time(),
        };
        b.iter(|| black_box(lock.advance(Some(black_box(&phase)), 1)));
    });
    group.bench_function("C", |b| {
        let (mut lock, mut moved) = (null_mut(), 0);
        // SAFETY: the rules of the header.
        let code = unsafe { coaxle_cycle_lock_new(CYCLE_NS, 0, &raw mut lock) };
        assert_eq!(code, COAXLE_OK);
        let phase = coaxle_far_phase {
            age_s: 1e-4,
            drift_ppm: 50.0,
            cycle_time_ns: CYCLE_NS,
            ..sized()
        };
        b.iter(|| {
            // SAFETY: the rules of the header.
            unsafe {
                coaxle_cycle_lock_advance(lock, black_box(&raw const phase), 1, &raw mut moved)
            }
        });
        // SAFETY: made above.
        unsafe { coaxle_cycle_lock_free(lock) };
    });
}

criterion_group!(calls, far_clock, encoder, cycle_lock);
criterion_main!(calls);
