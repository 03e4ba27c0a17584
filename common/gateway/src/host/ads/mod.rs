//! A Beckhoff PLC by ADS: one thread has the connection, since a router lets one host have only one.

mod client;
mod plc;
#[cfg(test)]
mod recorded;
mod wire;

use std::thread::JoinHandle;

use coaxle_clock::{Instant, Span};
use coaxle_os::machine;

use super::port::{NewestSlots, PlcEnd};
use super::thread;
use crate::Retry;
use crate::config::{AdsConfig, GatewayConfig, ReadMode};
use client::{AdsClient, AdsError};
use plc::{Notifications, Polling, Writing};

/// Period of requests for the PLC's state, beside all others: they detect a PLC in stop, and a connection that has ended.
// Two requests a second, beside two thousand for the index at cycles of 1 ms.
const STATE_PERIOD: Span = Span::from_millis(500);
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
        // Ends without an error only when the gateway ends.
        let Err(error) = converse(config, ads, &mut end, &mut retry) else {
            break;
        };
        end.link.disconnected();
        let (pause, is_first) = retry.failed();
        // Once for each reason.
        let reason = error.to_string();
        // A reason that changes helps to find the fault: a missing route, then a missing symbol.
        if is_first || reason != said {
            tracing::warn!(
                "the PLC at {plc} is away: {reason}. It is tried again until it is there"
            );
            said = reason;
        }
        end.stop.sleep(pause);
    }
    end.link.disconnected();
}

/// Talks with the PLC until the gateway ends.
fn converse(
    config: &GatewayConfig,
    ads: &AdsConfig,
    end: &mut PlcEnd,
    retry: &mut Retry,
) -> Result<(), AdsError> {
    let mut client = AdsClient::connect(ads)?;
    // Before the handles: a PLC that does not answer is another fault than a symbol that is missing.
    let state = client.state()?;
    let mut writings = Writing::prepare(&mut client, config)?;
    let reading = AxisReading::prepare(&mut client, config, ads)?;
    // Counted only once all symbols are found: each connection may begin a new run of the PLC.
    let connection = end.link.connected();
    retry.succeeded();
    end.link.set_stopped(state != RUN);
    let what = if state == RUN { "runs" } else { "does not run" };
    tracing::info!(
        "the PLC at {} is there and {what} (state {state})",
        String::from(ads.address.clone())
    );
    let ended = exchange(config, &mut client, reading, &mut writings, end, connection);
    // After an error a reply may still be on its way: the PLC releases the handles with the connection.
    if ended.is_ok() {
        client.release_handles();
    }
    ended
}

/// Mode of reading its axes.
enum AxisReading {
    Polling(Polling),
    Notifications(Notifications),
    Nothing,
}

impl AxisReading {
    fn prepare(
        client: &mut AdsClient,
        config: &GatewayConfig,
        ads: &AdsConfig,
    ) -> Result<Self, AdsError> {
        // Without axes nothing is read, and the connection is for writing and for the state.
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
    mut reading: AxisReading,
    writings: &mut [Writing],
    end: &mut PlcEnd,
    connection: u32,
) -> Result<(), AdsError> {
    let mut slots = NewestSlots::of(config);
    let mut requested_at = machine::now();
    let mut state_read_at = requested_at;
    let period = config.poll_period();
    while !end.stop.is_set() {
        match &mut reading {
            AxisReading::Polling(polling) => {
                requested_at = machine::now();
                polling.poll(client, end, connection)?;
            }
            AxisReading::Notifications(notifications) => {
                notifications.take(client, end, connection, period)?;
            }
            AxisReading::Nothing => {}
        }
        // Only the newest of each output: a PLC slower than the receiver has no use for the cycles between.
        end.outputs.newest_into(&mut slots);
        for slot in slots.take() {
            requested_at = machine::now();
            writings[slot.number].write(client, slot)?;
        }
        // After reading and writing, which are what matters.
        if machine::now() - state_read_at > STATE_PERIOD {
            // Counted as a request, so that the next poll keeps its distance from it.
            (requested_at, state_read_at) = (machine::now(), machine::now());
            log_state_change(client.state()?, end);
        }
        match &mut reading {
            AxisReading::Polling(polling) => {
                let part = polling.pauses.next_part();
                // From the request on: the time that the PLC took is part of the pause.
                pause(
                    requested_at,
                    Span::from_secs_f64(period.as_secs_f64() * part),
                );
            }
            // Waiting for the notification was the pause.
            AxisReading::Notifications(_) => {}
            // Nothing arrives that would set the pace.
            AxisReading::Nothing => pause(machine::now(), period),
        }
    }
    Ok(())
}

/// Logs that the runtime of the PLC stops, or runs again.
fn log_state_change(state: u16, end: &PlcEnd) {
    let is_stopped = state != RUN;
    if !end.link.set_stopped(is_stopped) {
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
