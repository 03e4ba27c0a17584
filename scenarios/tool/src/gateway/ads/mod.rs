//! A Beckhoff PLC by ADS: one thread has the connection, since a router lets one host have only one.

mod client;
mod plc;
#[cfg(test)]
mod recorded;
mod wire;

use std::thread::JoinHandle;

use coaxle_clock::{Instant, Span};
use coaxle_gateway::Retry;
use coaxle_gateway::config::{AdsConfig, GatewayConfig, ReadMode};
use coaxle_os::machine;

use super::port::{NewestSlots, PlcEnd};
use super::thread;
use client::{AdsClient, AdsError};
use plc::{Notifications, Polling, Writing};

/// Period of requests for the PLC's state, beside all others: they detect a PLC in stop, and a connection that has ended.
const GLANCE: Span = Span::from_millis(500);
/// State of a running PLC.
const RUN: u16 = 5;

/// Starts the thread.
pub(super) fn start(
    config: &GatewayConfig,
    ads: &AdsConfig,
    end: PlcEnd,
) -> anyhow::Result<Vec<JoinHandle<()>>> {
    let (config, ads) = (config.clone(), ads.clone());
    let link = thread("plc", move || work(&config, &ads, end))?;
    Ok(vec![link])
}

/// Connects, and connects again after each end of the connection.
fn work(config: &GatewayConfig, ads: &AdsConfig, mut end: PlcEnd) {
    let mut retry = Retry::default();
    let plc = String::from(ads.address.clone());
    let mut said = String::new();
    while !end.stop.is_set() {
        let Err(error) = converse(config, ads, &mut end, &mut retry) else {
            break;
        };
        end.link.down();
        let (pause, is_first) = retry.failed();
        // Once for each reason.
        let reason = error.to_string();
        if is_first || reason != said {
            tracing::warn!(
                "the PLC at {plc} is away: {reason}. It is tried again until it is there"
            );
            said = reason;
        }
        end.stop.sleep(pause);
    }
    end.link.down();
}

/// Talks with the PLC until the gateway ends.
fn converse(
    config: &GatewayConfig,
    ads: &AdsConfig,
    end: &mut PlcEnd,
    retry: &mut Retry,
) -> Result<(), AdsError> {
    let mut client = AdsClient::connect(ads)?;
    let state = client.state()?;
    let mut writings = Writing::prepare(&mut client, config)?;
    let reading = Reading::prepare(&mut client, config, ads)?;
    let connection = end.link.up();
    retry.succeeded();
    end.link.says_stopped(state != RUN);
    let what = if state == RUN { "runs" } else { "does not run" };
    tracing::info!(
        "the PLC at {} is there and {what} (state {state})",
        String::from(ads.address.clone())
    );
    let ended = exchange(config, &mut client, reading, &mut writings, end, connection);
    if ended.is_ok() {
        client.leave();
    }
    ended
}

/// Mode of reading its axes.
enum Reading {
    Polling(Polling),
    Notifications(Notifications),
    Nothing,
}

impl Reading {
    fn prepare(
        client: &mut AdsClient,
        config: &GatewayConfig,
        ads: &AdsConfig,
    ) -> Result<Self, AdsError> {
        let (Some(index), false) = (&ads.cycle_index, config.axes.is_empty()) else {
            return Ok(Self::Nothing);
        };
        Ok(match ads.read {
            ReadMode::Polling => Self::Polling(Polling::prepare(client, config, index)?),
            ReadMode::Notifications => {
                Self::Notifications(Notifications::prepare(client, config, index)?)
            }
        })
    }
}

fn exchange(
    config: &GatewayConfig,
    client: &mut AdsClient,
    mut reading: Reading,
    writings: &mut [Writing],
    end: &mut PlcEnd,
    connection: u32,
) -> Result<(), AdsError> {
    let mut slots = NewestSlots::of(config);
    let mut asked = machine::now();
    let mut looked = asked;
    let period = config.poll_period();
    while !end.stop.is_set() {
        match &mut reading {
            Reading::Polling(polling) => {
                asked = machine::now();
                polling.poll(client, end, connection)?;
            }
            Reading::Notifications(notifications) => {
                notifications.take(client, end, connection, period)?;
            }
            Reading::Nothing => {}
        }
        end.outputs.newest_into(&mut slots);
        for slot in slots.take() {
            asked = machine::now();
            writings[slot.number].write(client, slot)?;
        }
        if machine::now() - looked > GLANCE {
            (asked, looked) = (machine::now(), machine::now());
            look(client.state()?, end);
        }
        match &mut reading {
            Reading::Polling(polling) => {
                let part = polling.pauses.next_part();
                pause(asked, Span::from_secs_f64(period.as_secs_f64() * part));
            }
            // Waiting for the notification was the pause.
            Reading::Notifications(_) => {}
            Reading::Nothing => pause(machine::now(), period),
        }
    }
    Ok(())
}

/// Logs that the runtime of the PLC stops, or runs again.
fn look(state: u16, end: &PlcEnd) {
    let is_stopped = state != RUN;
    if !end.link.says_stopped(is_stopped) {
        return;
    }
    if is_stopped {
        tracing::warn!("the PLC does not run any more (state {state}): its index stands");
    } else {
        tracing::info!("the PLC runs again");
    }
}

/// Sleeps until this span after an instant.
fn pause(from: Instant<coaxle_os::Machine>, span: Span) {
    machine::sleep_until(from + span);
}
