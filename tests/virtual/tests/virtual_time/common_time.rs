//! A time that nodes have in common, followed and contradicted.

use coaxle_clock::timing::TimingState;
use coaxle_lab::catalog;
use coaxle_lab::row::{Row, RowSink};
use coaxle_lab::virtual_time;

/// Time, s, from which far time is judged: messages alone are followed in the first seconds.
const SETTLED: f64 = 10.0;

/// Errors of the far time of one receiver, and when its clocks disagreed first.
#[derive(Clone, Debug, Default)]
struct FarTimeErrors {
    count: u64,
    squares: f64,
    largest: f64,
    largest_step: f64,
    last: Option<f64>,
    named_at: Option<f64>,
}

impl FarTimeErrors {
    fn take(&mut self, at: f64, row: &Row) {
        let far = &row.record.far;
        let disagrees = far.health.name() == "clocks-disagree";
        let is_contradicted = far.common_time_state == Some(TimingState::Contradicted);
        assert_eq!(disagrees, is_contradicted && far.synced, "at {at} s");
        if disagrees {
            self.named_at.get_or_insert(at);
        }
        let Some(error) = row.time_error_us.filter(|_| at > SETTLED) else {
            return;
        };
        self.count += 1;
        self.squares += error * error;
        self.largest = self.largest.max(error.abs());
        if let Some(last) = self.last.replace(error) {
            self.largest_step = self.largest_step.max((error - last).abs());
        }
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }
}

struct OfReceivers([FarTimeErrors; 5]);

impl RowSink for OfReceivers {
    fn row(&mut self, view: usize, row: &Row) {
        let at = row.record.node.cycle as f64 * 1e-3;
        self.0[view].take(at, row);
    }
}

#[test]
fn a_common_time_is_followed_and_named_where_ways_contradict_it() {
    let source = catalog::find("common-time").expect("a scenario of the catalogue");
    let scenario = source.read(&[]).expect("a scenario");
    let mut rows = OfReceivers(Default::default());
    virtual_time::run(&scenario, &mut rows, &mut ()).expect("it runs");
    let names: Vec<_> = scenario
        .receivers
        .iter()
        .map(|it| it.name.as_str())
        .collect();
    assert_eq!(names, ["agreed", "leaps", "runs-free", "strange", "ways"]);
    for (name, errors) in names.iter().zip(&rows.0) {
        assert!(errors.count > 49_000, "{name}: {}", errors.count);
    }
    let [agreed, leaps, runs_free, strange, ways] = &rows.0;
    assert!(agreed.rms() < 0.02, "{} us", agreed.rms());
    assert!(agreed.largest < 0.05, "{} us", agreed.largest);
    // It leaps at 50 s.
    let named = leaps.named_at.expect("it is named");
    assert!((50.0..60.0).contains(&named), "named at {named} s");
    assert!(leaps.largest < 0.2, "{} us", leaps.largest);
    // 0.5 ppm from 20 s on, until neither way leaves it room: half of the round trip, and what both state.
    let named = runs_free.named_at.expect("it is named");
    assert!((20.0..50.0).contains(&named), "named at {named} s");
    assert!(runs_free.largest < 8.0, "{} us", runs_free.largest);
    for (name, errors) in [("strange", strange), ("ways", ways)] {
        assert_eq!(errors.named_at, None, "{name}");
        assert!(
            errors.rms() > 2.0 * agreed.rms(),
            "{name}: {} us",
            errors.rms()
        );
    }
    for (name, errors) in names.iter().zip(&rows.0) {
        assert!(
            errors.largest_step < 0.1,
            "{name}: {} us",
            errors.largest_step
        );
    }
}
