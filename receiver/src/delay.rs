//! The constant part of the link's delay: off, told, or measured by questions and answers.

use coaxle_clock::delay::{Answer, DelayExchange, DelayOutput, DelayState, Refusal};
use coaxle_clock::observer::PhaseObserver;
use coaxle_clock::{Instant, Local, Seconds, Span};

use crate::config::DelayConfig;

/// Answers that can wait for their cycle.
pub(crate) const CAPACITY: usize = 16;

/// What an observer is told about the delay.
#[derive(Debug)]
pub(crate) struct Delay {
    config: DelayConfig,
    exchange: DelayExchange,
    waiting: [Option<(Instant<Local>, Answer)>; CAPACITY],
    /// Answers that found no room to wait.
    overflow: u64,
    /// How sure the line is that it is measured against.
    sigma: Seconds,
}

impl Delay {
    /// `run` is this run of the node.
    pub(crate) const fn new(config: DelayConfig, run: u64) -> Self {
        Self {
            config,
            exchange: DelayExchange::new(run),
            waiting: [None; CAPACITY],
            overflow: 0,
            sigma: Seconds::ZERO,
        }
    }

    /// Stores an answer that arrived at `at`.
    pub(crate) fn hear(&mut self, at: Instant<Local>, answer: &Answer) {
        match self.waiting.iter_mut().find(|place| place.is_none()) {
            Some(place) => *place = Some((at, *answer)),
            None => self.overflow = self.overflow.saturating_add(1),
        }
    }

    /// Tells the observer, which has heard all messages of the cycle that ideally begins at `now`.
    ///
    /// Every answer to a question of this run is shown to `heard`, with its arrival.
    pub(crate) fn steer(
        &mut self,
        observer: &mut PhaseObserver,
        now: Instant<Local>,
        heard: impl FnMut(Instant<Local>, &Answer),
    ) {
        let delay = match self.config {
            DelayConfig::Off => Span::ZERO,
            DelayConfig::FixedUs(micros) => micros.span(),
            DelayConfig::Measured => {
                self.measure(observer, now, heard);
                self.exchange.delay().unwrap_or(Span::ZERO)
            }
        };
        observer.set_delay(delay);
    }

    fn measure(
        &mut self,
        observer: &mut PhaseObserver,
        now: Instant<Local>,
        mut heard: impl FnMut(Instant<Local>, &Answer),
    ) {
        let Some(line) = observer.line() else {
            return;
        };
        self.sigma = line.sigma;
        if let Some(jump) = self.exchange.follow(&line) {
            observer.blame_path(jump);
        }
        for place in &mut self.waiting {
            if let Some((arrived, answer)) = place.take_if(|(at, _)| *at <= now) {
                // It counts what it refuses.
                match self.exchange.take(&answer, arrived, &line) {
                    Err(Refusal::OtherRun | Refusal::OtherEpoch | Refusal::NotAsked) => {}
                    // Another estimator may think otherwise of one that is implausible.
                    Ok(()) | Err(_) => heard(arrived, &answer),
                }
            }
        }
    }

    /// The number of the question that is due, if one is.
    pub(crate) fn ask(&mut self, now: Instant<Local>) -> Option<u32> {
        match self.config {
            DelayConfig::Measured => self.exchange.ask(now),
            DelayConfig::Off | DelayConfig::FixedUs(_) => None,
        }
    }

    pub(crate) fn output(&self, now: Instant<Local>) -> DelayOutput {
        match self.config {
            DelayConfig::Off => DelayOutput::default(),
            DelayConfig::FixedUs(micros) => DelayOutput {
                state: DelayState::Fixed,
                delay: Some(micros.span().into()),
                ..DelayOutput::default()
            },
            DelayConfig::Measured => {
                let output = self.exchange.output(now, self.sigma);
                DelayOutput {
                    refused: output.refused.saturating_add(self.overflow),
                    ..output
                }
            }
        }
    }
}
