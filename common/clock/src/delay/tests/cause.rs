//! Attribution of a change of the drift by the ways of requests.

use super::*;
use drift::whose;

/// Result for requests of three seconds, whose way grows by this part of the change that messages show.
fn whose_if_requests_grow_by(part: f64) -> Option<Whose> {
    let line = line(micros(1_000));
    let suspected = SuspectedDrift {
        since: at(0),
        change: 100e-6,
        line,
    };
    let exchanges: std::vec::Vec<Exchange> = (0..100)
        .map(|n| {
            let seconds = 0.03 * f64::from(n as u32);
            let way = Span::from_secs_f64(1e-3 + part * 100e-6 * seconds);
            let (response, arrived) = response(n as u32, at(30_000 * n), way, micros(300));
            let stamps = ExchangeStamps {
                requested: response.requested,
                received: response.received,
                responded: response.responded,
                arrived,
            };
            Exchange::measured(stamps, &line)
        })
        .collect();
    whose(&suspected, exchanges.iter())
}

#[test]
fn requests_that_do_not_take_longer_show_that_it_is_the_senders_clock() {
    assert_eq!(whose_if_requests_grow_by(0.0), Some(Whose::Sender));
    // The line that messages are on is a little off in its drift.
    for part in [0.3, -0.3] {
        assert_eq!(whose_if_requests_grow_by(part), Some(Whose::Sender));
    }
    for part in [0.4, -0.4, 1.0, 2.0] {
        assert_eq!(whose_if_requests_grow_by(part), Some(Whose::Path));
    }
}
