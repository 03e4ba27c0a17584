//! Many far nodes, many far axes: each node with a clock of its own, each axis with its own errors.

use crate::nodes::{Far, MILLISECOND, of, receiver, run};
use coaxle_clock::time_sync::SyncError;
use coaxle_node::Node;
use coaxle_receiver::{FilterState, Health, HealthName, Receiver};

const THREE: &str = "
[[far]]
node = 'a'
axes = ['1-2']
delay = 'off'
sync.time-sync.age-of-data-limit = 7
[[far]]
node = 'b'
axes = [{ id = 5, name = 'belt' }]
delay = 'off'
[[far]]
node = 'c'
axes = ['1-3']
mode = 'sync'
sync.time-sync.automatic-re-init = true
[[slave]]
name = 'x'
master = 'a.2'
[[slave]]
name = 'y'
master = 'belt'
gear.ratio = 2
[[slave]]
name = 'z'
master = 'c.3'
";

fn three() -> (Receiver, [Far; 3]) {
    let far = [
        Far::new(0, 1_000_400, &[100.0, 200.0]),
        Far::new(1, 999_700, &[300.0]),
        Far::new(2, 1_001_000, &[10.0, 20.0, 30.0]),
    ];
    (receiver(THREE), far)
}

#[test]
fn each_far_node_has_a_clock_of_its_own() {
    let (mut receiver, mut far) = three();
    let mut last = None;
    run(&mut receiver, &mut far, 6_000 * MILLISECOND, |row, now| {
        if now > 5_000 * MILLISECOND {
            // The axes of a node refer to one instant: by the arrivals of its messages.
            let count = (now - 200_000) as f64 / 1_000_400.0;
            for (axis, velocity) in [(0, 100.0), (1, 200.0)] {
                let position = row.axes[axis].corrected_position.expect("known");
                let error = (position - Far::position(velocity, count)).abs();
                assert!(error < velocity * 20e-6, "{axis}: {error}");
            }
            assert_eq!(row.axes[0].far_time_ns, row.axes[1].far_time_ns);
            let belt = row.axes[2].corrected_position.expect("known");
            assert_eq!(row.slaves[1].position, Some(2.0 * belt));
            assert_eq!(row.slaves[2].position, row.axes[5].corrected_position);
        }
        last = Some(row.clone());
    });
    let last = last.expect("a cycle");
    let drifts = last.far.iter().map(|far| far.drift_ppm.expect("known"));
    // Cycles of 1 000 400 ns are those of a clock 400 ppm slow.
    for (drift, expected) in drifts.zip([-400.0, 300.0, -1000.0]) {
        assert!(
            (drift - expected).abs() < 5.0,
            "{drift}, expected {expected}"
        );
    }
    assert_eq!(receiver.snapshot().health, Health::Ok);
    assert_eq!(last.axes[0].state, Some(FilterState::Observer));
    assert_eq!(last.axes[3].state, Some(FilterState::Sync));
}

#[test]
fn a_far_node_that_falls_silent_or_starts_anew_is_no_matter_of_the_others() {
    let (mut receiver, mut far) = three();
    run(&mut receiver, &mut far, 5_000 * MILLISECOND, |_, _| {});
    far[1].silent = true;
    run(&mut receiver, &mut far, 6_000 * MILLISECOND, |row, _| {
        assert!(row.axes[0].synced && row.axes[3].synced);
    });
    let names = |receiver: &Receiver| {
        let far = receiver.snapshot().signals.far.iter();
        far.map(|far| far.health).collect::<Vec<_>>()
    };
    let (ok, error) = (HealthName::Ok, HealthName::Error);
    assert_eq!(names(&receiver), [ok, error, ok]);
    let worst = Health::Error(SyncError::MaxDataAgeExceeded);
    assert_eq!(receiver.snapshot().health, worst);
    // Another run of it.
    far[1].silent = false;
    far[1].epoch = 2;
    run(&mut receiver, &mut far, 10_000 * MILLISECOND, |_, _| {});
    assert_eq!(names(&receiver), [ok, ok, ok]);
    let restarts: Vec<_> = receiver
        .snapshot()
        .signals
        .far
        .iter()
        .map(|f| f.restarts)
        .collect();
    assert_eq!(restarts, [0, 1, 0]);
}

#[test]
fn an_axis_that_is_missing_goes_on_until_the_age_limit_and_the_others_do_not_notice() {
    let (mut receiver, mut far) = three();
    run(&mut receiver, &mut far, 5_000 * MILLISECOND, |_, _| {});
    far[0].axes[1] = None;
    let mut went_on = 0;
    run(&mut receiver, &mut far, 5_200 * MILLISECOND, |row, now| {
        let [first, missing] = [&row.axes[0], &row.axes[1]];
        assert!(first.synced && first.error == 0);
        if missing.error == 0 {
            went_on += 1;
            // By its newest data, moved on by the clock.
            let count = (now - 200_000) as f64 / 1_000_400.0;
            let expected = Far::position(200.0, count);
            let error = (missing.corrected_position.expect("known") - expected).abs();
            assert!(error < 200.0 * 20e-6, "{error}");
        }
    });
    assert!(
        (5..=9).contains(&went_on),
        "the age limit is 7 cycles: {went_on}"
    );
    let row = &receiver.snapshot().signals;
    assert_eq!(row.axes[1].error, SyncError::MaxDataAgeExceeded.code());
    // Missing for 200 cycles.
    assert!(row.axes[1].missing > 190 && row.axes[1].age_cycles > 190);
    assert_eq!((row.axes[0].missing, row.axes[0].age_cycles), (0, 0));
    // The axis is received again, and returned with at most the acceleration of braking.
    far[0].axes[1] = Some(200.0);
    run(&mut receiver, &mut far, 5_600 * MILLISECOND, |_, _| {});
    assert!(receiver.snapshot().signals.axes[1].synced);
    assert_eq!(receiver.snapshot().health, Health::Ok);
}

#[test]
fn a_position_error_is_its_axis_own_and_the_axis_alone_starts_anew() {
    let text = THREE.replace(
        "sync.time-sync.automatic-re-init = true",
        "sync = { time-sync.automatic-re-init = true, extrapolate.max-position-diff = 0.5 }",
    );
    let (mut receiver, mut far) = (receiver(&text), three().1);
    run(&mut receiver, &mut far, 5_000 * MILLISECOND, |_, _| {});
    let beats = receiver.snapshot().signals.far[2].beats;
    // So fast that half a cycle is too far.
    far[2].axes[1] = Some(2_000.0);
    let mut errors = [0; 3];
    run(&mut receiver, &mut far, 6_000 * MILLISECOND, |row, _| {
        for (errors, axis) in errors.iter_mut().zip(&row.axes[3..]) {
            *errors += u32::from(axis.error == SyncError::MaxPositionDiffExceeded.code());
        }
        assert!(row.far[2].synced, "the clock goes on");
    });
    assert!(errors[1] > 100, "{errors:?}");
    assert_eq!((errors[0], errors[2]), (0, 0));
    far[2].axes[1] = Some(20.0);
    run(&mut receiver, &mut far, 7_000 * MILLISECOND, |_, _| {});
    let row = &receiver.snapshot().signals;
    assert!(row.axes[4].synced && row.far[2].beats > beats);
}

#[test]
fn three_hundred_axes_and_a_hundred_slaves_are_one_receiver() {
    let mut text = String::new();
    for node in ["a", "b", "c"] {
        text += &format!("[[far]]\nnode = '{node}'\naxes = ['1-100']\ndelay = 'off'\n");
    }
    for n in 0..100 {
        let (node, axis) = (["a", "b", "c"][n % 3], n + 1);
        text += &format!("[[slave]]\nname = 's{axis}'\nmaster = '{node}.{axis}'\n");
    }
    let mut receiver = receiver(&text);
    let velocities: Vec<f64> = (1..=100).map(f64::from).collect();
    // 100 ppm slow, 100 ppm fast, exact.
    let mut far = [1_000_100, 999_900, 1_000_000].map(|cycle| Far::new(0, cycle, &velocities));
    for (n, far) in far.iter_mut().enumerate() {
        far.subscription = of(n);
    }
    run(&mut receiver, &mut far, 6_000 * MILLISECOND, |_, _| {});
    let row = &receiver.snapshot().signals;
    assert_eq!((row.axes.len(), row.slaves.len()), (300, 100));
    assert!(row.axes.iter().all(|axis| axis.synced));
    assert_eq!(row.slaves[99].position, row.axes[99].corrected_position);
    // Axis 2 of node b, after the hundred of node a.
    assert_eq!(row.slaves[1].position, row.axes[101].corrected_position);
}
