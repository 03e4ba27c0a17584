use core::f64::consts::{PI, TAU};

use proptest::prelude::*;

use super::*;
use crate::config::{ClockConfig, LinkConfig, parse};
use crate::faults::statistics::{assert_distributed, assert_moments, exponential, normal, uniform};

fn terms(text: &str) -> Terms {
    let link: LinkConfig = parse("t", &format!("delay-terms-us = [{text}]")).unwrap();
    Terms::of_link(&link, 5).unwrap()
}

/// The terms of a file with these contents.
fn of_file(text: &str, between: &str) -> Result<Terms, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("t.csv"), text).unwrap();
    let list = format!("[{{ file = {{ path = 't.csv', between = '{between}' }} }}]");
    let mut link: LinkConfig = parse("t", &format!("delay-terms-us = {list}")).unwrap();
    link.relative_to(folder.path());
    let opened = Terms::of_link(&link, 5);
    let place = format!("{}/", folder.path().display());
    opened.map_err(|wrong| wrong.to_string().replace(&place, ""))
}

fn assert_near(received: f64, expected: f64, what: &str) {
    let off = (received - expected).abs();
    assert!(
        // Relative to the size: the floats of both forms differ in their last digits.
        off < 1e-9 * (1.0 + expected.abs()),
        "{what}: {received}, expected {expected}"
    );
}

#[test]
fn each_kind_has_its_closed_form() {
    type Form = fn(f64) -> f64;
    let forms: [(&str, Form); 8] = [
        ("{ constant = 7 }", |_| 7.0),
        ("{ sine = { amplitude = 3, period-s = 5 } }", |t| {
            3.0 * (TAU * t / 5.0).sin()
        }),
        (
            "{ sine = { amplitude = 3, period-s = 5, phase = 0.25 } }",
            |t| 3.0 * (TAU * t / 5.0).cos(),
        ),
        ("{ triangle = { amplitude = 4, period-s = 8 } }", |t| {
            // The arc sine turns a sine into straight lines.
            4.0 * 2.0 / PI * (TAU * t / 8.0).sin().asin()
        }),
        (
            "{ pulse = { height = 6, period-s = 2, duty = 0.25 } }",
            |t| {
                if t.rem_euclid(2.0) < 0.5 { 6.0 } else { 0.0 }
            },
        ),
        (
            "{ pulse = { height = 6, period-s = 2, duty = 0.25, phase = 0.5 } }",
            |t| {
                if (t + 1.0).rem_euclid(2.0) < 0.5 {
                    6.0
                } else {
                    0.0
                }
            },
        ),
        ("{ step = { at-s = 3, by = -5 } }", |t| {
            if t < 3.0 { 0.0 } else { -5.0 }
        }),
        ("{ step = { at-s = 3, by = -5, over-s = 4 } }", |t| {
            -5.0 * ((t - 3.0) / 4.0).clamp(0.0, 1.0)
        }),
    ];
    for (text, form) in forms {
        let mut terms = terms(text);
        for k in 0..400 {
            // No edge is hit.
            let at = 0.07 * f64::from(k) + 0.003;
            assert_near(terms.at(at), form(at), text);
        }
    }
}

#[test]
fn terms_add_up() {
    let mut sum = terms("{ constant = 7 }, { step = { at-s = 2, by = 3 } }, { constant = -1 }");
    assert_eq!((sum.at(1.0), sum.at(2.0)), (6.0, 9.0));
    assert_eq!(terms("").at(1.0), 0.0);
    assert!(terms("{ constant = 7 }").is_constant());
    assert!(!terms("{ normal = 7 }").is_constant());
    assert!(!sum.is_constant());
}

#[test]
fn noise_is_distributed_as_its_kind_says() {
    let drawn = |text: &str| {
        let mut terms = terms(text);
        // Both ways of drawing, in turns.
        let drawn = (0..20_000).map(|k| match k % 2 {
            0 => terms.at(f64::from(k)),
            _ => terms.mean(f64::from(k), f64::from(k) + 0.5),
        });
        drawn.collect::<Vec<_>>()
    };
    let uniforms = drawn("{ uniform = { from = -2, to = 6 } }");
    assert_moments(&uniforms, 2.0, 8.0 / 12f64.sqrt());
    assert_distributed(&uniforms, |x| uniform(x, -2.0, 6.0));
    let exponentials = drawn("{ exponential = 30 }");
    assert_moments(&exponentials, 30.0, 30.0);
    assert_distributed(&exponentials, |x| exponential(x, 30.0));
    let early: Vec<_> = drawn("{ exponential = -30 }").iter().map(|x| -x).collect();
    assert_distributed(&early, |x| exponential(x, 30.0));
    let normals = drawn("{ normal = 20 }, { constant = 100 }");
    assert_moments(&normals, 100.0, 20.0);
    assert_distributed(&normals, |x| normal(x - 100.0, 20.0));
}

#[test]
fn a_file_is_followed_on_straight_lines_or_by_steps() {
    let rows = "s;value\n1;10\n3;20\n4;-5\n";
    let mut linear = of_file(rows, "linear").unwrap();
    let mut held = of_file(rows, "held").unwrap();
    for (at, on_lines, by_steps) in [
        (0.0, 10.0, 10.0),
        (1.0, 10.0, 10.0),
        (2.0, 15.0, 10.0),
        (3.0, 20.0, 20.0),
        (3.5, 7.5, 20.0),
        (4.0, -5.0, -5.0),
        (1e6, -5.0, -5.0),
    ] {
        assert_eq!((linear.at(at), held.at(at)), (on_lines, by_steps), "{at}");
    }
    // 10 for a second, 15 in the mean for two, 7.5 for one, and -5 for two.
    assert_near(
        linear.mean(0.0, 6.0),
        (10.0 + 30.0 + 7.5 - 10.0) / 6.0,
        "linear",
    );
    assert_near(
        held.mean(0.0, 6.0),
        (10.0 + 20.0 + 20.0 - 10.0) / 6.0,
        "held",
    );
    assert_eq!(of_file("5;3", "linear").unwrap().at(0.0), 3.0);
}

#[test]
fn a_file_that_is_no_term_is_refused_by_its_line() {
    for (text, expected) in [
        (
            "",
            "t.csv: received no rows, expected at least 1: seconds and value",
        ),
        (
            "0;1\n1;1;2\n",
            "t.csv: line 2: received 3 columns, expected 2: s and value",
        ),
        (
            "0;1\n1;x\n",
            "t.csv: line 2, value: received \"x\", expected a number",
        ),
        (
            "0;1\n-1;1\n",
            "t.csv: line 2, s: received -1, expected a number from 0 to 1000000000",
        ),
        (
            "2;1\n2;1\n",
            "t.csv: line 2, s: received 2, expected more than 2, the row before",
        ),
        (
            "2;1e9\n",
            "t.csv: line 1, value: received 1000000000, expected a number from -100000000 to 100000000",
        ),
        (
            "2;nan\n",
            "t.csv: line 1, value: received NaN, expected a number from -100000000 to 100000000",
        ),
    ] {
        let expected = format!("delay-terms-us[0].file.path: {expected}");
        assert_eq!(of_file(text, "held").map(|_| ()), Err(expected));
    }
    let missing = "drift-terms-ppm = [{ constant = 1 }, { file = { path = 'no/such.csv' } }]";
    let clock: ClockConfig = parse("t", missing).unwrap();
    let wrong = check_clock(&clock).unwrap_err().within("clock");
    assert_eq!(wrong.field(), "clock.drift-terms-ppm[1].file.path");
    let text = wrong.to_string();
    let expected = "clock.drift-terms-ppm[1].file.path: no/such.csv: cannot be read: ";
    assert!(text.starts_with(expected), "{text}");
}

/// Functions of time of every kind.
fn functions() -> impl Strategy<Value = String> {
    let amount = || -1e3..1e3f64;
    let (period, share) = (|| 0.05..100.0f64, || 0.0..=1.0f64);
    prop_oneof![
        (amount(), period(), share()).prop_map(|(amplitude, period, phase)| format!(
            "{{ sine = {{ amplitude = {amplitude:?}, period-s = {period:?}, phase = {phase:?} }} }}"
        )),
        (amount(), period(), share()).prop_map(|(amplitude, period, phase)| format!(
            "{{ triangle = {{ amplitude = {amplitude:?}, period-s = {period:?}, phase = {phase:?} }} }}"
        )),
        (amount(), period(), share(), share()).prop_map(|(height, period, duty, phase)| format!(
            "{{ pulse = {{ height = {height:?}, period-s = {period:?}, duty = {duty:?}, phase = {phase:?} }} }}"
        )),
        (0.0..30.0f64, amount(), 0.0..20.0f64).prop_map(|(at, by, over)| format!(
            "{{ step = {{ at-s = {at:?}, by = {by:?}, over-s = {over:?} }} }}"
        )),
    ]
}

proptest! {
    #[test]
    fn a_mean_is_that_of_many_values(
        text in functions(),
        from in 0.0..50.0f64,
        length in 0.01..5.0f64,
    ) {
        const PARTS: u32 = 4_000;
        let mut terms = terms(&text);
        let part = length / f64::from(PARTS);
        let values = (0..PARTS).map(|k| terms.at(from + (f64::from(k) + 0.5) * part));
        let expected = values.sum::<f64>() / f64::from(PARTS);
        let mean = terms.mean(from, from + length);
        // An edge lies within one of the parts; there are at most two in a period.
        let edges = 2.0 * (length / 0.05 + 1.0);
        let most = 1e3 * edges / f64::from(PARTS) + 1e-3;
        prop_assert!((mean - expected).abs() <= most, "{mean}, {expected}");
    }
}
