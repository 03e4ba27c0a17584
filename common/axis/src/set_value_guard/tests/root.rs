//! Roots are found, with few evaluations.

use core::cell::Cell;

use super::super::closed_forms::stop_way;
use super::super::root::last_not_above;
use super::random::Random;

#[test]
fn roots_are_found_with_few_evaluations() {
    let random = &mut Random::seeded(1);
    let (mut most, mut sum) = (0, 0);
    let functions = 10_000;
    for _ in 0..functions {
        let bound = random.decades(1e-2, 1e3);
        let (w, b) = (
            random.between(-1.0, 1.0) * random.decades(1e-3, 1e4),
            random.between(-bound, bound),
        );
        // The distance of a stop after the middle of the range.
        let way = |next: f64| w + next + stop_way(w + next, next, bound, bound);
        let x = -way(b + random.between(-1.0, 1.0));
        let evaluations = Cell::new(0);
        let function = |next: f64| {
            evaluations.set(evaluations.get() + 1);
            x + way(next)
        };
        let (low, high) = (b - 1.0, b + 1.0);
        let root = last_not_above(low, high, function);
        let scale = x.abs().max(1.0);
        assert!(x + way(root) <= 1e-12 * scale);
        assert!(x + way((root + 1e-9).min(high)) >= -1e-9 * scale);
        most = most.max(evaluations.get());
        sum += evaluations.get();
    }
    // An update finds at most five roots.
    // `USUAL_STEPS` and the two ends.
    assert!(most <= 38, "{most}");
    assert!(sum / functions <= 12, "{sum}");
}

#[test]
fn ends_without_a_root_are_given() {
    assert_eq!(last_not_above(-1.0, 2.0, |x| x - 5.0), 2.0);
    assert_eq!(last_not_above(-1.0, 2.0, |x| x + 5.0), -1.0);
    assert_eq!(last_not_above(-1.0, 2.0, |_| f64::NAN), -1.0);
    let jump = |x: f64| if x < 0.5 { -1.0 } else { f64::INFINITY };
    assert!((last_not_above(-1.0, 2.0, jump) - 0.5).abs() < 1e-9);
}
