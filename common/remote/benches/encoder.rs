//! Cost of a cycle of an encoder master.

use std::hint::black_box;

use coaxle_clock::{Seconds, Span};
use coaxle_remote::{EncoderMaster, EncoderParameters, EncoderSample};
use criterion::{Criterion, criterion_group, criterion_main};

/// Counts of an axis that swings about a speed, in increments per cycle.
fn counts(per_cycle: f64) -> Vec<u64> {
    (0..65_536_u32)
        .map(|k| {
            let t = f64::from(k);
            let position = per_cycle * (t + 0.4 * (t / 40.0).sin());
            position as u64
        })
        .collect()
}

fn master(increment: f64) -> EncoderMaster {
    let parameters = EncoderParameters {
        increment,
        ..EncoderParameters::default()
    };
    let checked = parameters
        .checked(Span::from_millis(1))
        .expect("they are right");
    EncoderMaster::new(&checked)
}

fn cycles(c: &mut Criterion) {
    for (name, per_cycle) in [("standing", 0.0), ("an edge in seven", 0.14), ("fast", 7.3)] {
        let counts = counts(per_cycle);
        c.bench_function(&format!("encoder master, {name}"), |b| {
            let mut master = master(0.01);
            let mut counts = counts.iter().cycle();
            b.iter(|| {
                counts.next().map(|&count| {
                    let sample = Some(EncoderSample::next(black_box(count)));
                    black_box(master.update(sample, Seconds(2e-3), 1))
                })
            });
        });
    }
}

criterion_group!(encoder, cycles);
criterion_main!(encoder);
