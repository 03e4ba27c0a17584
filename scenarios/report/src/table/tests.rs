use std::collections::BTreeMap;

use coaxle_lab::summary::{CutsSummary, SlaveSummary, World};

use super::*;

fn summary(receivers: Vec<(&str, ReceiverSummary)>) -> Summary {
    let receivers: BTreeMap<_, _> = receivers
        .into_iter()
        .map(|(name, figures)| (name.to_owned(), figures))
        .collect();
    Summary {
        scenario: "beat".to_owned(),
        title: "Beats".to_owned(),
        world: World::Virtual,
        seed: 1,
        duration_s: 40.0,
        interrupted_at_s: None,
        receivers,
        routers: BTreeMap::new(),
        expectations: Vec::new(),
    }
}

fn receiver(mode: &'static str, ripple: Option<f64>) -> ReceiverSummary {
    let mut summary = ReceiverSummary {
        mode,
        velocity_ripple_max: ripple.map(|ratio| 500.0 * ratio),
        velocity_ripple_ratio: ripple,
        ..ReceiverSummary::default()
    };
    summary.last.far.beats = 19;
    summary
}

#[test]
fn what_one_does_not_know_is_a_dash_and_what_none_knows_is_left_out() {
    let lagging = ReceiverSummary {
        lag_us: Some(1e3),
        ..ReceiverSummary::default()
    };
    let text = results(&summary(vec![
        ("r", ReceiverSummary::default()),
        ("s", lagging),
    ]));
    let lag = text.lines().find(|line| line.contains("lag")).unwrap();
    assert!(lag.contains('–') && lag.contains('1'), "{lag}");
    assert!(!text.contains("drift true"), "{text}");
    assert!(!text.contains("NaN") && !text.contains("None"), "{text}");
}

#[test]
fn receivers_without_correction_come_first() {
    let text = results(&summary(vec![
        ("a-cured", receiver("sync", Some(0.004))),
        ("z-bare", receiver("bypass", Some(1.0))),
    ]));
    let header = text.lines().find(|line| line.contains("receiver")).unwrap();
    assert!(header.find("z-bare") < header.find("a-cured"), "{text}");
}

#[test]
fn a_narrow_terminal_cuts_nothing() {
    let names: Vec<String> = (0..9).map(|n| format!("receiver-number-{n}")).collect();
    let all = summary(
        names
            .iter()
            .map(|name| (name.as_str(), receiver("sync", Some(0.001))))
            .collect(),
    );
    let text = results_within(&all, 80);
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
    assert!(names.iter().all(|name| text.contains(name)), "{text}");
}

#[test]
fn no_receivers_no_table() {
    assert_eq!(results(&summary(Vec::new())), "");
    assert_eq!(verdicts(&summary(Vec::new())), "");
    assert_eq!(conclusion(&summary(Vec::new())), None);
}

#[test]
fn a_failed_expectation_is_named_with_its_numbers() {
    let mut run = summary(Vec::new());
    run.expectations = vec![
        Verdict {
            receiver: "cured".to_owned(),
            slave: None,
            field: "lag_us".to_owned(),
            expected: "at most 0.001".to_owned(),
            received: Value::from(0.001_000_1),
            met: false,
        },
        Verdict {
            receiver: "cured".to_owned(),
            slave: None,
            field: "beats".to_owned(),
            expected: "at least 3".to_owned(),
            received: Value::from(19),
            met: true,
        },
    ];
    let text = verdicts(&run);
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines[0], "ok     cured.beats is 19, expected at least 3");
    assert_eq!(
        lines[1],
        "FAILED cured.lag_us is 0.0010001, expected at most 0.001"
    );
}

#[test]
fn the_conclusion_compares_the_beat_with_its_cure() {
    let text = conclusion(&summary(vec![
        ("bare", receiver("bypass", Some(1.0))),
        ("cured", receiver("sync", Some(0.004))),
    ]));
    assert_eq!(
        text.as_deref(),
        Some(
            "without correction: the velocity jumps by up to 100 %, with 19 beats\n\
             with TS5066:        by up to 0.400 %, about 250 times smaller"
        )
    );
}

#[test]
fn the_conclusion_knows_every_mode() {
    let text = conclusion(&summary(vec![
        ("a", receiver("bypass", Some(1.0))),
        ("b", receiver("observer", Some(0.0005))),
        ("c", receiver("pt1", Some(0.5))),
        ("d", receiver("sync", Some(0.004))),
        ("e", receiver("time", Some(0.01))),
    ]));
    assert_eq!(
        text.as_deref(),
        Some(
            "without correction: the velocity jumps by up to 100 %, with 19 beats\n\
             with a PT1 filter:  by up to 50.0 %, about 2.0 times smaller\n\
             with time mode:     by up to 1.00 %, about 100 times smaller\n\
             with TS5066:        by up to 0.400 %, about 250 times smaller\n\
             with the observer:  by up to 0.0500 %, about 2000 times smaller"
        )
    );
}

#[test]
fn the_conclusion_tells_what_is_settled_from_the_lock_in() {
    let cured = ReceiverSummary {
        velocity_ripple_settled_ratio: Some(0.0001),
        ..receiver("observer", Some(0.02))
    };
    let bare = receiver("bypass", Some(1.0));
    let text = conclusion(&summary(vec![("bare", bare), ("cured", cured)])).unwrap();
    let line = "with the observer:  by up to 0.0100 %, about 10000 times smaller; \
                2.00 % while locking in";
    assert!(text.ends_with(line), "{text}");
}

#[test]
fn a_receiver_that_never_synchronised_is_no_success() {
    let text = conclusion(&summary(vec![
        ("bare", receiver("bypass", Some(1.0))),
        ("cured", receiver("sync", Some(0.004))),
        ("lost", receiver("sync", None)),
    ]))
    .unwrap();
    assert!(text.ends_with("not synchronised within the run"), "{text}");
}

#[test]
fn nothing_to_compare_no_conclusion() {
    let only = summary(vec![("cured", receiver("sync", Some(0.004)))]);
    assert_eq!(conclusion(&only), None);
}

#[test]
fn numbers_are_rounded_to_what_is_significant() {
    assert_eq!(significant(499.96, 3), "500");
    assert_eq!(significant(99.96, 3), "100");
    assert_eq!(significant(12_345.6, 3), "12346");
    assert_eq!(significant(0.000_423_4, 3), "0.000423");
    assert_eq!(significant(-1.5, 3), "-1.50");
    assert_eq!(significant(1e-12, 3), "1.00e-12");
    assert_eq!(significant(0.0, 3), "0");
    assert_eq!(roughly(1515.2), "1500");
    assert_eq!(roughly(2.345), "2.3");
}

fn millimetres() -> Unit {
    Unit::new("mm").expect("a unit")
}

fn slaves(cuts: &[(&str, u64)]) -> BTreeMap<String, SlaveSummary> {
    let slave = |(name, cuts): &(&str, u64)| {
        let figures = CutsSummary {
            cuts: *cuts,
            cut_unit: millimetres(),
            cut_length_error_max: Some(0.00425),
            ..CutsSummary::default()
        };
        let slave = SlaveSummary {
            cuts: figures,
            ..SlaveSummary::default()
        };
        ((*name).to_owned(), slave)
    };
    cuts.iter().map(slave).collect()
}

#[test]
fn slaves_that_cut_have_rows_of_their_own() {
    let with = |cuts: &[(&str, u64)]| ReceiverSummary {
        slaves: slaves(cuts),
        ..ReceiverSummary::default()
    };
    let (saw, other) = (with(&[("saw", 60), ("table", 0)]), with(&[("table", 0)]));
    let text = results(&summary(vec![("a", saw), ("b", other.clone())]));
    let line = |label: &str| text.lines().find(|line| line.trim().starts_with(label));
    let words = |label| line(label).map(|line| line.split_whitespace().collect::<Vec<_>>());
    assert_eq!(words("cuts"), Some(vec!["cuts", "60", "–"]));
    assert!(line("length error max, µm").is_some_and(|line| line.contains("4.25")));
    let none = results(&summary(vec![("b", other)]));
    assert!(!none.contains("cut"), "{none}");
    let two = results(&summary(vec![("a", with(&[("left", 1), ("right", 2)]))]));
    assert!(
        two.contains("left: cuts") && two.contains("right: cuts"),
        "{two}"
    );
}

#[test]
fn a_conclusion_about_cuts_compares_the_lengths_of_pieces() {
    let with = |mode, length_error| {
        let cuts = CutsSummary {
            cuts: 29,
            cut_unit: millimetres(),
            cut_length_error_max: length_error,
            ..CutsSummary::default()
        };
        let slave = SlaveSummary {
            cuts,
            ..SlaveSummary::default()
        };
        ReceiverSummary {
            slaves: BTreeMap::from([("saw".to_owned(), slave)]),
            ..receiver(mode, None)
        }
    };
    let text = conclusion(&summary(vec![
        ("bypass", with("bypass", Some(0.4))),
        ("observer", with("observer", Some(0.25e-3))),
        ("sync", with("sync", None)),
    ]));
    assert_eq!(
        text.unwrap(),
        "without correction: pieces are off by up to 400 µm\n\
         with TS5066:        nothing was cut twice within the run\n\
         with the observer:  by up to 0.250 µm, about 1600 times less"
    );
}
