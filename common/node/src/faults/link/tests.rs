use proptest::prelude::*;

use super::*;
use crate::config::parse;
use crate::faults::statistics::{
    assert_distributed, assert_moments, assert_share, exponential, normal, uniform,
};

const COUNT: i64 = 20_000;

fn link(config: &str) -> LinkModel {
    LinkModel::new(&parse("test", config).unwrap(), 11).unwrap()
}

fn millis(k: i64) -> Span {
    Span::from_millis(k)
}

/// Deliveries of messages so far apart that none waits for another.
fn offered(config: &str) -> Vec<Deliveries> {
    let mut link = link(config);
    // A second apart, which no delay here exceeds.
    (0..COUNT).map(|k| link.offer(Span::from_secs(k))).collect()
}

/// The delays of first arrivals, µs.
fn delays(config: &str) -> Vec<f64> {
    let firsts = offered(config)
        .into_iter()
        .filter_map(|mut deliveries| deliveries.next());
    firsts.map(Span::as_micros_f64).collect()
}

#[test]
fn a_plain_link_only_delays() {
    let mut link = link("latency-us = 200");
    let delays: Vec<_> = link.offer(millis(5)).collect();
    assert_eq!(delays, [Span::from_micros(200)]);
}

#[test]
fn jitter_is_added_to_the_latency_as_distributed() {
    let normals = delays("latency-us = 500\njitter = { normal-us = 20 }");
    assert_moments(&normals, 500.0, 20.0);
    assert_distributed(&normals, |x| normal(x - 500.0, 20.0));
    let exponentials = delays("latency-us = 100\njitter = { exponential-us = 30 }");
    assert_moments(&exponentials, 130.0, 30.0);
    assert_distributed(&exponentials, |x| exponential(x - 100.0, 30.0));
    let uniforms = delays("latency-us = 50\njitter = { uniform-us = 40 }");
    // A width of 40 has the deviation 40/√12.
    assert_moments(&uniforms, 70.0, 40.0 / 12f64.sqrt());
    assert_distributed(&uniforms, |x| uniform(x, 50.0, 90.0));
}

#[test]
fn terms_add_to_the_delay_at_the_moment_of_sending() {
    let mut link = link(
        "latency-us = 100\ndelay-terms-us = [{ triangle = { amplitude = 40, period-s = 8 } }, \
         { pulse = { height = 500, period-s = 4, duty = 0.25, phase = 0.5 } }, { step = { at-s = 6, by = -1000 } }]",
    );
    // Triangle of 40 at period 8: 20 after a second. The pulse is high at 2 s. The step leads below zero.
    for (secs, expected) in [
        (0, 100),
        (1, 120),
        (2, 640),
        (3, 120),
        (5, 80),
        (6, 0),
        (10, 0),
    ] {
        let delays: Vec<_> = link.offer(Span::from_secs(secs)).collect();
        assert_eq!(delays, [Span::from_micros(expected)], "{secs}");
    }
    let noisy = delays("latency-us = 500\ndelay-terms-us = [{ normal = 20 }]");
    assert_moments(&noisy, 500.0, 20.0);
    assert_distributed(&noisy, |x| normal(x - 500.0, 20.0));
}

#[test]
fn terms_do_not_shift_the_numbers_of_other_faults() {
    let config = "jitter = { normal-us = 20 }\nlatency-us = 500";
    let plain = delays(config);
    // A constant of 50, and noise without a width, which is drawn all the same.
    let shifted = delays(&format!(
        "{config}\ndelay-terms-us = [{{ constant = 50 }}, {{ uniform = {{ from = 0, to = 0 }} }}]"
    ));
    assert!(
        plain
            .iter()
            .zip(&shifted)
            .all(|(plain, shifted)| (shifted - plain - 50.0).abs() < 0.002)
    );
}

#[test]
fn no_message_arrives_before_it_was_sent() {
    let early = delays("latency-us = 5\njitter = { normal-us = 20 }");
    assert!(early.iter().all(|delay| *delay >= 0.0));
    let at_once = early.iter().filter(|delay| **delay == 0.0).count();
    // A delay below half a nanosecond is zero.
    // P(x < −5) of the jitter.
    assert_share(at_once, early.len(), normal(-5.0, 20.0));
}

#[test]
fn spikes_come_in_their_share_between_their_bounds() {
    let delays = delays("latency-us = 100\nspikes = { share = 0.2, from-us = 1000, to-us = 5000 }");
    let spikes: Vec<f64> = delays
        .iter()
        .copied()
        .filter(|delay| *delay > 100.0)
        .collect();
    assert_share(spikes.len(), delays.len(), 0.2);
    assert_distributed(&spikes, |x| uniform(x, 1100.0, 5100.0));
}

#[test]
fn messages_are_lost_in_their_share_and_independently() {
    let offered = offered("loss = 0.1");
    let lost: Vec<bool> = offered
        .iter()
        .map(|deliveries| deliveries.count == 0)
        .collect();
    assert_share(lost.iter().filter(|lost| **lost).count(), lost.len(), 0.1);
    let both = lost.windows(2).filter(|pair| pair[0] && pair[1]).count();
    // Independent losses: 0.1 · 0.1.
    assert_share(both, lost.len() - 1, 0.01);
    assert!(delays("loss = 1").is_empty());
}

#[test]
fn a_repeated_message_arrives_again_but_not_before_itself() {
    let offered = offered("duplication = 0.3\njitter = { uniform-us = 100 }");
    let twice: Vec<_> = offered
        .iter()
        .filter(|deliveries| deliveries.count == 2)
        .collect();
    assert_share(twice.len(), offered.len(), 0.3);
    assert!(offered.iter().all(|deliveries| deliveries.count > 0));
    assert!(twice.iter().all(|deliveries| deliveries.delays.is_sorted()));
    // The later of two independent delays.
    let seconds: Vec<_> = twice
        .iter()
        .map(|twice| twice.delays[1].as_micros_f64())
        .collect();
    assert_distributed(&seconds, |x| uniform(x, 0.0, 100.0).powi(2));
}

#[test]
fn a_message_that_is_held_back_is_so_for_up_to_the_bound() {
    let delays = delays("latency-us = 10\nreorder = 0.4\nreorder-us = 5000");
    let held: Vec<f64> = delays
        .iter()
        .copied()
        .filter(|delay| *delay > 10.0)
        .collect();
    assert_share(held.len(), delays.len(), 0.4);
    assert_distributed(&held, |x| uniform(x, 10.0, 5010.0));
}

#[test]
fn a_message_that_is_held_back_holds_up_nobody() {
    let mut link = link("latency-us = 10\nreorder = 0.4\nreorder-us = 50000");
    let delays: Vec<_> = (0..1_000)
        .filter_map(|k| link.offer(millis(k)).next())
        .collect();
    let prompt = delays
        .iter()
        .filter(|delay| **delay == Span::from_micros(10))
        .count();
    assert_share(prompt, delays.len(), 0.6);
}

#[test]
fn losing_more_neither_spares_others_nor_changes_their_delays() {
    let jitter = "jitter = { exponential-us = 30 }";
    let (few, many) = (
        offered(&format!("loss = 0.1\n{jitter}")),
        offered(&format!("loss = 0.3\n{jitter}")),
    );
    for (few, many) in few.into_iter().zip(many) {
        assert!(many.count == 0 || few == many);
    }
}

#[test]
fn delay_steps_last_and_add_up_and_never_make_a_delay_negative() {
    let mut link = link(
        "latency-us = 100\ndelay-steps = [{ at-s = 1, by-us = 50 }, { at-s = 2, by-us = -120 }, \
         { at-s = 3, by-us = -120 }]",
    );
    let tick = Span::from_nanos(1);
    let mut delay = |at| link.offer(at).next().map(Span::as_micros_f64);
    let seen = [1, 2, 3, 9].map(|s| (delay(millis(1_000 * s) - tick), delay(millis(1_000 * s))));
    let expected = [(100.0, 150.0), (150.0, 30.0), (30.0, 0.0), (0.0, 0.0)];
    for ((before, at), (expected_before, expected_at)) in seen.into_iter().zip(expected) {
        // A message sent just before a step down arrives after one sent at it.
        let waits = if expected_at < expected_before {
            0.001
        } else {
            0.0
        };
        assert_eq!(before, Some(expected_before));
        let at = at.unwrap();
        assert!(
            at == expected_at || (at - (expected_before - waits)).abs() < 1e-9,
            "{at}"
        );
    }
}

#[test]
fn a_partition_lets_nothing_through_from_its_start_until_its_end() {
    let mut link = link("partitions = [{ at-s = 2, for-s = 1 }, { at-s = 5, for-s = 0.5 }]");
    let tick = Span::from_nanos(1);
    let mut passes = |at| link.offer(at).next().is_some();
    for (from, until) in [(2_000, 3_000), (5_000, 5_500)] {
        assert!(passes(millis(from) - tick));
        assert!(!passes(millis(from)));
        assert!(!passes(millis(until) - tick));
        assert!(passes(millis(until)));
    }
}

#[test]
fn a_seed_gives_the_same_fate_and_another_seed_another() {
    let config = parse(
        "test",
        "loss = 0.1\njitter = { normal-us = 5 }\nlatency-us = 50",
    )
    .unwrap();
    let fates = |seed| {
        let mut link = LinkModel::new(&config, seed).unwrap();
        (0..100).map(|k| link.offer(millis(k))).collect::<Vec<_>>()
    };
    assert_eq!(fates(1), fates(1));
    assert_ne!(fates(1), fates(2));
}

proptest! {
    /// A link is a queue: each arrival is its own delay's, or that of the one before if that is later.
    #[test]
    fn arrivals_are_in_the_order_of_sending(
        mean in 1.0..3_000.0f64,
        share in 0.0..1.0f64,
        gaps in prop::collection::vec(0..3_000i64, 2..100),
    ) {
        let config = format!(
            "jitter = {{ exponential-us = {mean} }}\n\
             spikes = {{ share = {share}, from-us = 0, to-us = 9000 }}"
        );
        let (mut busy, mut idle) = (link(&config), link(&config));
        let mut sent = Span::ZERO;
        let mut newest = Span::from_nanos(i64::MIN);
        for (k, gap) in gaps.into_iter().enumerate() {
            sent += Span::from_micros(gap);
            let own = idle.offer(Span::from_secs(k as i64)).next().unwrap();
            newest = newest.max(sent + own);
            let arrival = sent + busy.offer(sent).next().unwrap();
            prop_assert_eq!(arrival, newest);
        }
    }
}

#[test]
fn what_goes_wrong_at_random_ends_when_it_is_to_end() {
    let faults = "latency-us = 100\nloss = 0.3\nduplication = 0.3\nreorder = 0.3\nreorder-us = 5000\n\
                  spikes = { share = 0.3, from-us = 1000, to-us = 9000 }";
    let until = COUNT / 2;
    let endless = offered(faults);
    let ended = offered(&format!("{faults}\nfaults-until-s = {until}"));
    let until = until as usize;
    assert_eq!(ended[..until], endless[..until]);
    let plain = Deliveries::once(Span::from_micros(100));
    assert!(ended[until..].iter().all(|deliveries| *deliveries == plain));
    assert!(
        endless[until..]
            .iter()
            .any(|deliveries| *deliveries != plain)
    );
}

#[test]
fn bursts_begin_and_end_by_chance() {
    let offered = offered("burst-loss = { begins = 0.02, ends = 0.25 }");
    let lost: Vec<bool> = offered.into_iter().map(|it| it.count() == 0).collect();
    let bursts = lost.windows(2).filter(|two| !two[0] && two[1]).count();
    let all = lost.iter().filter(|lost| **lost).count();
    // Four in a burst, fifty between two.
    // 1 / 0.25, and 1 / 0.02.
    assert_share(all, lost.len(), 4.0 / 54.0);
    assert!(
        (0.9..1.1).contains(&(bursts as f64 / (COUNT as f64 / 54.0))),
        "{bursts}"
    );
}

#[test]
fn a_correlated_delay_is_distributed_as_said_and_stays_alike() {
    let mut link = link("latency-us = 500\ncorrelated = { sigma-us = 40, time-s = 0.1 }");
    let mut delays = Vec::new();
    for k in 0..200_000 {
        let delay = link.offer(millis(10 * k)).next().expect("not lost");
        delays.push(delay.as_micros_f64() - 500.0);
    }
    let mean_of = |products: &mut dyn Iterator<Item = f64>| products.sum::<f64>() / 2e5;
    let variance = mean_of(&mut delays.iter().map(|delay| delay * delay));
    // AR(1) with ρ = e⁻⁰·¹ leaves 20 000 independent values: a standard error of 0.5 %.
    assert!((variance.sqrt() / 40.0 - 1.0).abs() < 0.03, "{variance}");
    let pairs = delays.iter().zip(&delays[10..]);
    let covariance = mean_of(&mut pairs.map(|(now, later)| now * later));
    // Ten messages are the correlation time.
    let expected = (-1.0_f64).exp();
    assert!(
        (covariance / variance - expected).abs() < 0.03,
        "{covariance}"
    );
}

#[test]
fn arrivals_are_seen_on_a_grid_and_not_while_the_link_stalls() {
    let mut link =
        link("latency-us = 200\nresolution-us = 1000\nstalls = [{ at-s = 0.010, for-s = 0.005 }]");
    let mut arrival = |at_us: i64| {
        let sent = Span::from_micros(at_us);
        (sent + link.offer(sent).next().expect("not lost")).as_micros_f64()
    };
    // 1.2 ms is seen at 2 ms, 2 ms at once, and 10.1 ms after the stall.
    assert_eq!(arrival(1_000), 2_000.0);
    assert_eq!(arrival(1_800), 2_000.0);
    assert_eq!(arrival(9_900), 15_000.0);
    assert_eq!(arrival(12_000), 15_000.0);
    assert_eq!(arrival(14_900), 16_000.0);
}
