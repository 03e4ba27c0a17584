use super::*;
use crate::observer::tests::delays::{Correlated, Random};

/// s
const CYCLE: f64 = 1e-3;
const NORMAL: f64 = 5e-6;
const EXPONENTIAL: f64 = 20e-6;

fn jitter(random: &mut Random) -> f64 {
    NORMAL * random.normal() + EXPONENTIAL * random.exponential()
}

/// Number of residuals, of `messages`, after which delays count as correlated.
fn noticed(
    correlation: &mut Correlation,
    messages: u32,
    mut residual: impl FnMut(u32) -> f64,
) -> Option<u32> {
    (0..messages).find(|n| {
        correlation.take(residual(*n));
        correlation.is_correlated()
    })
}

#[test]
fn independent_delays_are_not_correlated() {
    for seed in 0..200 {
        let mut random = Random::of_seed(seed);
        let noticed = noticed(&mut Correlation::new(), 60_000, |_| jitter(&mut random));
        assert_eq!(noticed, None, "{seed}");
    }
}

/// On a link that keeps the order late messages hold up the following ones, which are not looked at.
#[test]
fn a_link_that_keeps_the_order_under_load_is_not_correlated() {
    for seed in 0..200 {
        let mut random = Random::of_seed(seed);
        let mut correlation = Correlation::new();
        let mut busy_until = 0.0;
        for n in 0..60_000 {
            let due = f64::from(n) * CYCLE;
            let arrived =
                due + NORMAL * random.normal() + 20.0 * EXPONENTIAL * random.exponential();
            if busy_until <= due {
                correlation.take(arrived - due);
            }
            busy_until = arrived.max(busy_until);
        }
        assert!(!correlation.is_correlated(), "{seed}");
    }
}

#[test]
fn delays_that_are_alike_are_noticed_within_seconds() {
    for (mut delay, within) in [
        (Correlated::half_normal(15e-6, 0.3), 10_000),
        (Correlated::half_normal(40e-6, 5.0), 60_000),
        (Correlated::telegraph(30e-6, 2.0), 60_000),
    ] {
        for seed in 0..10 {
            let mut random = Random::of_seed(seed);
            let after = noticed(&mut Correlation::new(), within, |_| {
                delay.after(CYCLE, &mut random) + jitter(&mut random)
            });
            assert!(after.is_some(), "{seed}: not within {within}");
        }
    }
}

/// Transformation of the jitter of a message by its number.
type Disturbance = fn(u32, f64) -> f64;

#[test]
fn a_step_or_wider_jitter_does_not_make_them_correlated() {
    // The line follows a step of the delay within tenths of a second, one of the drift in seconds.
    let step_of_delay = |n: u32, jitter: f64| match n {
        30_000..30_150 => jitter + 30e-6,
        _ => jitter,
    };
    let step_of_drift = |n: u32, jitter: f64| {
        let since = (f64::from(n) - 30_000.0) * CYCLE;
        let behind = if since > 0.0 { 2e-6 * since } else { 0.0 };
        jitter + behind * libm::exp(-since.max(0.0))
    };
    let wider = |n: u32, jitter: f64| match n {
        20_000..40_000 => 20.0 * jitter,
        _ => jitter,
    };
    let disturbances: [(&str, Disturbance); 3] = [
        ("delay", step_of_delay),
        ("drift", step_of_drift),
        ("width", wider),
    ];
    for (name, disturbed) in disturbances {
        for seed in 0..20 {
            let mut random = Random::of_seed(seed);
            let after = noticed(&mut Correlation::new(), 60_000, |n| {
                disturbed(n, jitter(&mut random))
            });
            assert_eq!(after, None, "{name}, {seed}");
        }
    }
}

#[test]
fn long_independence_is_believed_again() {
    let mut correlation = Correlation::new();
    correlation.assume();
    let mut random = Random::of_seed(1);
    let mut messages = 0;
    while correlation.is_correlated() && messages < 600_000 {
        correlation.take(jitter(&mut random));
        messages += 1;
    }
    assert!((60_000..600_000).contains(&messages), "{messages}");

    // Where they really were correlated, the means of that time have to be forgotten first.
    let mut delay = Correlated::half_normal(15e-6, 0.3);
    for _ in 0..30_000 {
        correlation.take(delay.after(CYCLE, &mut random) + jitter(&mut random));
    }
    assert!(correlation.is_correlated());
    let mut messages = 0;
    while correlation.is_correlated() && messages < 600_000 {
        correlation.take(jitter(&mut random));
        messages += 1;
    }
    assert!((60_000..600_000).contains(&messages), "{messages}");
}

/// Number of messages after which delays are taken to be independent again, of jitter beside two levels that are `height` apart,
/// s; none of ten minutes.
fn independent_after(height: f64) -> Option<u32> {
    let mut correlation = Correlation::new();
    correlation.assume();
    (0..600_000_u32).find(|n| {
        let jitter = if (n * 7) % 16 < 8 { 20e-6 } else { -20e-6 };
        let upper = if n / 2_048 % 2 == 0 { height } else { 0.0 };
        correlation.take(jitter + upper);
        !correlation.is_correlated()
    })
}

#[test]
fn delays_are_independent_after_a_minute_of_chance() {
    let after = independent_after(0.0).unwrap();
    assert!((55_000..65_000).contains(&after), "{after}");
    // Means that scatter by 1.7 times as much as chance says, in squares, and by 2.4 times.
    assert!(independent_after(2.06e-6).is_some());
    assert!(independent_after(2.43e-6).is_none());
}
