//! Follows a far clock from files of arrivals, as receivers write them: prints a line per second with the far time,
//! its uncertainty and its rate.
//!
//! ```sh
//! coaxle receiver receiver/configs/saw.toml --connect tcp/192.168.1.10:7447 --arrivals saw-arrivals.csv
//! cargo run --example follow -- saw-arrivals.csv saw-exchanges.csv
//! ```
//!
//! Without the second file the delay is unknown, and the far time lags by it.

#![allow(clippy::print_stdout, reason = "a program that prints")]

use std::collections::VecDeque;
use std::error::Error;

use coaxle_clock::delay::TimeResponse;
use coaxle_clock::far_clock::{DelaySource, FarClock};
use coaxle_clock::observer::ObserverParameters;
use coaxle_clock::{CycleTime, Instant, Local, Span};

fn main() -> Result<(), Box<dyn Error>> {
    let mut files = std::env::args().skip(1);
    let arrivals = files
        .next()
        .ok_or("usage: follow ARRIVALS.csv [EXCHANGES.csv]")?;
    let arrivals = std::fs::read_to_string(arrivals)?;
    let exchanges = files.next().map(std::fs::read_to_string).transpose()?;
    follow(&arrivals, exchanges.as_deref(), &mut |line| {
        println!("{line}")
    })
}

/// A message: the cycle that took it in, its run, its count, its arrival, its send stamp.
struct Message {
    cycle_start: i64,
    epoch: u64,
    count: u64,
    at: i64,
    send_stamp: Option<i64>,
}

/// A response, likewise.
struct Response {
    cycle_start: i64,
    at: i64,
    response: TimeResponse,
}

fn follow(
    arrivals: &str,
    exchanges: Option<&str>,
    print: &mut dyn FnMut(String),
) -> Result<(), Box<dyn Error>> {
    let table = Table::of(arrivals)?;
    let cycle_time = table.first("cycle_time_ns")?;
    let mut messages = VecDeque::new();
    for row in table.rows() {
        messages.push_back(Message {
            cycle_start: row.number("cycle_start_ns")?,
            epoch: row.number("epoch")?,
            count: row.number("count")?,
            at: row.number("arrival_ns")?,
            send_stamp: row.number("send_stamp_ns").ok(),
        });
    }
    let mut responses = VecDeque::new();
    for row in exchanges
        .map(Table::of)
        .transpose()?
        .iter()
        .flat_map(Table::rows)
    {
        responses.push_back(Response {
            cycle_start: row.number("cycle_start_ns")?,
            at: row.number("t4_ns")?,
            response: TimeResponse {
                run: RUN,
                number: row.number("number")?,
                requested: Instant::from_nanos(row.number("t1_ns")?),
                epoch: row.number("epoch")?,
                received: Span::from_nanos(row.number("t2_ns")?),
                responded: Span::from_nanos(row.number("t3_ns")?),
            },
        });
    }
    let delay = match responses.is_empty() {
        true => DelaySource::Off,
        false => DelaySource::Measured,
    };
    let cycle_time = CycleTime::new(Span::from_nanos(cycle_time))?;
    let mut clock = FarClock::new(cycle_time, ObserverParameters::default(), delay, RUN)?;
    let mut next_line = i64::MIN;
    // One cycle after the other, each with all that it took in.
    while let Some(start) = messages.front().map(|message| message.cycle_start) {
        while let Some(m) = next_if(&mut messages, |message| message.cycle_start == start) {
            let stamp = m.send_stamp.map(Span::from_nanos);
            clock.message(m.epoch, m.count, Instant::from_nanos(m.at), stamp);
        }
        // Responses of cycles without a message go into the next one that has some.
        while let Some(r) = next_if(&mut responses, |response| response.cycle_start <= start) {
            clock.response(Instant::from_nanos(r.at), &r.response);
        }
        let now = Instant::<Local>::from_nanos(start);
        let output = *clock.cycle(now, |_, _| {});
        // The requests went out when the recording was made; here only their numbers count.
        let _ = clock.request(now);
        if start >= next_line {
            // A line a second.
            next_line = start.saturating_add(1_000_000_000);
            print(match clock.far_time_at(now) {
                Some(far) if output.is_sure => format!(
                    "{:10.3} s: far clock {:14.6} s ± {:.2} µs, drift {:+.3} ppm",
                    start as f64 * 1e-9,
                    far.time.since(Instant::EPOCH).0,
                    far.uncertainty.as_micros(),
                    output.observer.drift_ppm
                ),
                _ => format!("{:10.3} s: not sure yet", start as f64 * 1e-9),
            });
        }
    }
    Ok(())
}

const RUN: u64 = 1;

fn next_if<T>(queue: &mut VecDeque<T>, is_due: impl Fn(&T) -> bool) -> Option<T> {
    queue
        .front()
        .is_some_and(is_due)
        .then(|| queue.pop_front())?
}

/// A CSV file with a head line, and no commas in its values.
struct Table<'a> {
    columns: Vec<&'a str>,
    lines: Vec<&'a str>,
}

struct Row<'a> {
    columns: &'a [&'a str],
    values: Vec<&'a str>,
}

impl<'a> Table<'a> {
    fn of(text: &'a str) -> Result<Self, Box<dyn Error>> {
        let mut lines = text.lines();
        let head = lines
            .next()
            .ok_or("the file is empty, expected a head line")?;
        Ok(Self {
            columns: head.split(',').collect(),
            lines: lines.collect(),
        })
    }

    fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.lines.iter().map(|line| Row {
            columns: &self.columns,
            values: line.split(',').collect(),
        })
    }

    fn first<T: std::str::FromStr>(&self, column: &str) -> Result<T, String> {
        let row = self.rows().next().ok_or("the file has no line")?;
        row.number(column)
    }
}

impl Row<'_> {
    fn number<T: std::str::FromStr>(&self, column: &str) -> Result<T, String> {
        let place = self.columns.iter().position(|name| *name == column);
        let value = place
            .and_then(|place| self.values.get(place))
            .unwrap_or(&"");
        value
            .parse()
            .map_err(|_| format!("{column}: received {value:?}, expected a number"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write as _;

    #[test]
    fn a_file_of_arrivals_is_followed() {
        let mut arrivals =
            "cycle_start_ns,epoch,count,cycle_time_ns,arrival_ns,send_stamp_ns\n".to_owned();
        for count in 0..5_000_i64 {
            // 100 ppm slow, 200 to 220 µs under way.
            let jitter = count * 7_919 % 20_011;
            let at = count * 1_000_100 + 200_000 + jitter;
            let start = (at / 1_000_000 + 1) * 1_000_000;
            let _ = writeln!(arrivals, "{start},3,{count},1000000,{at},");
        }
        let mut lines = Vec::new();
        follow(&arrivals, None, &mut |line| lines.push(line)).unwrap();
        assert_eq!(lines.len(), 5);
        assert!(lines[0].ends_with("not sure yet"), "{}", lines[0]);
        assert!(lines[4].contains("drift -100.0"), "{}", lines[4]);
    }

    #[test]
    fn what_is_no_number_is_named() {
        let error = follow("cycle_time_ns\nx", None, &mut |_| {}).unwrap_err();
        assert_eq!(
            error.to_string(),
            "cycle_time_ns: received \"x\", expected a number"
        );
    }
}
