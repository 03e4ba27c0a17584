//! Seeded random numbers against closed forms.

/// Fails unless the numbers have the distribution `cdf`: the test of Kolmogorov and Smirnov, with a
/// false alarm for one sample in a thousand. The seeds are fixed, so it fails always or never.
pub(super) fn assert_distributed(numbers: &[f64], cdf: impl Fn(f64) -> f64) {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len() as f64;
    let distance = sorted.iter().enumerate().fold(0.0, |most: f64, (k, x)| {
        let expected = cdf(*x);
        let below = (expected - k as f64 / count).abs();
        let above = ((k + 1) as f64 / count - expected).abs();
        most.max(below).max(above)
    });
    // 1.95 = √(−ln(0.001 / 2) / 2).
    let limit = 1.95 / count.sqrt();
    assert!(
        distance < limit,
        "{distance} from the closed form, {limit} allowed"
    );
}

/// Fails unless mean and standard deviation are those expected, within four standard errors.
pub(super) fn assert_moments(numbers: &[f64], mean: f64, deviation: f64) {
    let count = numbers.len() as f64;
    let measured = numbers.iter().sum::<f64>() / count;
    // The standard error of a mean is σ/√n.
    let error = 4.0 * deviation / count.sqrt();
    assert!(
        (measured - mean).abs() < error,
        "mean {measured}, expected {mean} ± {error}"
    );
    let squares = numbers.iter().map(|x| (x - measured).powi(2)).sum::<f64>();
    let spread = (squares / count).sqrt();
    // The largest kurtosis here is 9, that of the exponential distribution.
    let error = 4.0 * deviation * (8.0 / (4.0 * count)).sqrt();
    assert!(
        (spread - deviation).abs() < error,
        "deviation {spread}, expected {deviation} ± {error}"
    );
}

/// Fails unless this number of hits in `tries` fits a chance of `share`, within four standard errors.
pub(super) fn assert_share(hits: usize, tries: usize, share: f64) {
    let measured = hits as f64 / tries as f64;
    let error = 4.0 * (share * (1.0 - share) / tries as f64).sqrt();
    assert!(
        (measured - share).abs() <= error,
        "share {measured}, expected {share} ± {error}"
    );
}

/// The distribution function of the normal distribution with mean 0.
pub(super) fn normal(x: f64, deviation: f64) -> f64 {
    // `erfc` keeps its digits far below the mean, where 1 + erf would cancel.
    0.5 * libm::erfc(-x / (deviation * core::f64::consts::SQRT_2))
}

/// The distribution function of the exponential distribution.
pub(super) fn exponential(x: f64, mean: f64) -> f64 {
    if x < 0.0 {
        0.0
    } else {
        1.0 - libm::exp(-x / mean)
    }
}

/// The distribution function of the uniform distribution.
pub(super) fn uniform(x: f64, from: f64, to: f64) -> f64 {
    ((x - from) / (to - from)).clamp(0.0, 1.0)
}
