//! Corruption and forgery of messages on a link.

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::Span;
use coaxle_wire::frame::{FrameHeader, KeySeal, PRESENTED_VERSION, body_capacity, encode_body};

use super::random::{Random, seed_of};
use crate::config::{Forged, Forgery, LinkConfig};

/// Corrupts messages and adds forged ones.
#[derive(Clone, Debug)]
pub struct Tampering {
    config: LinkConfig,
    random: Random,
    seal: KeySeal,
    /// Flags of the single forgeries that are done.
    done: Vec<bool>,
    first: Vec<u8>,
    forger: Forger,
    forged: Vec<u8>,
}

impl Tampering {
    /// Creates the tampering of the link of this key, with random parts drawn from `seed`; none if
    /// there is none.
    #[must_use]
    pub fn new(config: &LinkConfig, seed: u64, key: &str) -> Option<Self> {
        // Without either there is nothing to copy, and messages pass as they are.
        let any = config.corruption.get() > 0.0 || !config.forgeries.is_empty();
        any.then(|| Self {
            config: config.clone(),
            random: Random::new(seed_of(seed, "content")),
            seal: KeySeal::new(key),
            done: vec![false; config.forgeries.len()],
            first: Vec::new(),
            forger: Forger::default(),
            forged: Vec::new(),
        })
    }

    /// Passes a message sent `since_start`, unaltered or altered, and the forged ones after it, to
    /// `arrive`.
    pub fn pass(&mut self, since_start: Span, message: &[u8], mut arrive: impl FnMut(&[u8])) {
        if self.first.is_empty() {
            self.first.extend_from_slice(message);
        }
        // Drawn for every message, so that the end of the faults does not shift the numbers of the damage; without
        // corruption nothing is drawn.
        let damaged = self.random.chance(self.config.corruption.get());
        let damaged = damaged && self.config.is_faulty(since_start);
        // Replaced, not damaged: the forged one comes below.
        match (self.is_replaced(since_start), damaged) {
            (true, _) => {}
            (false, true) => {
                self.damage(message);
                arrive(&self.forged);
            }
            (false, false) => arrive(message),
        }
        for place in 0..self.config.forgeries.len() {
            let forgery = self.config.forgeries[place];
            if !is_due(&forgery, self.done[place], since_start) {
                continue;
            }
            self.done[place] = true;
            for number in 0..forgery.times.get() {
                if self.forge(&forgery.what, message, number) {
                    arrive(&self.forged);
                }
            }
        }
    }

    fn is_replaced(&self, since_start: Span) -> bool {
        let mut all = self.config.forgeries.iter().zip(&self.done);
        all.any(|(forgery, done)| forgery.instead && is_due(forgery, *done, since_start))
    }

    /// Flips a bit, or cuts off the end.
    fn damage(&mut self, message: &[u8]) {
        self.forged.clear();
        self.forged.extend_from_slice(message);
        let (cut, place) = (self.random.chance(0.5), self.random.uniform());
        if cut {
            // Any length but the whole one.
            let length = (place * message.len() as f64) as usize;
            self.forged.truncate(length);
        } else {
            let bit = (place * 8.0 * message.len() as f64) as usize;
            if let Some(byte) = self.forged.get_mut(bit / 8) {
                // Any bit, so that header, axes and check sum are hit in their proportion.
                *byte ^= 1 << (bit % 8);
            }
        }
    }

    /// Creates a forged message; returns false if none applies.
    fn forge(&mut self, what: &Forged, message: &[u8], number: u32) -> bool {
        let Self { random, forged, .. } = self;
        match what {
            Forged::Noise => {
                forged.clear();
                // As long as a genuine message: length alone must not give it away.
                forged.extend(message.iter().map(|_| (random.uniform() * 256.0) as u8));
                true
            }
            Forged::FirstAgain => {
                forged.clone_from(&self.first);
                true
            }
            _ => (self.forger).forge(&self.seal, what, message, number, random, forged),
        }
    }
}

fn is_due(forgery: &Forgery, done: bool, since_start: Span) -> bool {
    let from = forgery.at_s.span();
    match forgery.for_s {
        // The end is excluded.
        Some(length) => (from..from + length.span()).contains(&since_start),
        None => !done && since_start >= from,
    }
}

/// Reads a frame of axes and writes a forged one.
#[derive(Clone, Debug, Default)]
struct Forger {
    axes: Vec<NcToPlcAxis>,
    body: Vec<u8>,
}

impl Forger {
    /// Writes a forged frame like `message` into `forged`; returns false if `message` is not a
    /// frame of axes.
    fn forge(
        &mut self,
        seal: &KeySeal,
        what: &Forged,
        message: &[u8],
        number: u32,
        random: &mut Random,
        forged: &mut Vec<u8>,
    ) -> bool {
        let axes = &mut self.axes;
        axes.clear();
        let Ok(mut header) = seal.open(message, |axis| axes.push(*axis)) else {
            return false;
        };
        change_header(&mut header, what, number);
        for axis in &mut *axes {
            change_axis(axis, what, random);
        }
        self.body.resize(body_capacity(axes.len()), 0);
        let Ok(length) = encode_body(&header, axes, &mut self.body) else {
            return false;
        };
        let body = &self.body[..length];
        match what {
            Forged::OtherKey => KeySeal::new("another/key").seal(body, header.send_stamp, forged),
            _ => seal.seal(body, header.send_stamp, forged),
        }
        // After sealing: receivers look at the version before the check sum.
        if let (Forged::OtherVersion, Some(version)) = (what, forged.first_mut()) {
            *version = PRESENTED_VERSION + 1;
        }
        true
    }
}

fn change_header(header: &mut FrameHeader, what: &Forged, number: u32) {
    match what {
        // Any other number. A fixed one, so that the forged run stays the same run.
        Forged::OtherRun => header.epoch ^= 0x5bd1_e995,
        Forged::OtherNode => header.sender ^= 0x5bd1_e995,
        Forged::CycleTimeUs(cycle) => header.cycle_time = cycle.0,
        Forged::CountAhead(by) => advance(header, by.get() as i64),
        Forged::PositionAhead(_) => advance(header, 1 + i64::from(number)),
        _ => {}
    }
}

const fn advance(header: &mut FrameHeader, by: i64) {
    // Wrapping: a forger may take any number.
    header.count = header.count.wrapping_add_signed(by);
    header.index = coaxle_clock::CycleIndex::of_count(header.count);
}

fn change_axis(axis: &mut NcToPlcAxis, what: &Forged, random: &mut Random) {
    match what {
        Forged::OtherAxes => axis.axis_id = axis.axis_id.wrapping_add(1_000),
        Forged::AxisError(code) => axis.error_code = *code,
        Forged::PositionAhead(by) => {
            axis.set_position += by.get();
            axis.actual_position += by.get();
        }
        Forged::NotFinite => {
            // 1e300 is finite, and beyond any limit.
            let any = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300];
            let value = any[(random.uniform() * 4.0) as usize];
            match (random.uniform() * 3.0) as usize {
                0 => axis.set_position = value,
                1 => axis.set_velocity = value,
                _ => axis.set_acceleration = value,
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests;
