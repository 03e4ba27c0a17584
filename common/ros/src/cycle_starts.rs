//! Starts of the cycles of a node, by the clock of this machine.

use coaxle_clock::far_clock::{DelaySource, FarClock};
use coaxle_clock::observer::ObserverParameters;
use coaxle_clock::{Instant, Local, Span};
use coaxle_wire::FrameHeader;

/// Finds the instants at which the cycles of a node began from the arrivals of its frames, without their
/// jitter.
///
/// They lag by about the delay of a frame on a quiet network: there are no time requests for it.
#[derive(Clone, Debug, Default)]
pub struct CycleStarts {
    clock: Option<(Span, FarClock)>,
    now: Option<Instant<Local>>,
}

impl CycleStarts {
    /// Takes the arrival of a frame.
    pub fn frame(&mut self, header: &FrameHeader, at: Instant<Local>) {
        let cycle_time = header.cycle_time.span();
        // A node restarted with another cycle time counts in other units: its clock begins again.
        if self.clock.as_ref().is_none_or(|(of, _)| *of != cycle_time) {
            let parameters = ObserverParameters::default();
            // `DelaySource::Off`: no time requests are sent, so that the path delay stays in the stamps.
            let clock = FarClock::new(header.cycle_time, parameters, DelaySource::Off, 0);
            self.clock = clock.ok().map(|clock| (cycle_time, clock));
        }
        if let Some((_, clock)) = &mut self.clock {
            clock.message(header.epoch, header.count, at, header.send_stamp);
        }
    }

    /// Runs the cycle at `now`, with all frames up to then.
    pub fn cycle(&mut self, now: Instant<Local>) {
        self.now = Some(now);
        if let Some((_, clock)) = &mut self.clock {
            let _ = clock.cycle(now, |_, _| {});
        }
    }

    /// Returns the start of the cycle with this count. Until the clock is known, a second or two: the
    /// arrival of its frame.
    #[must_use]
    pub fn cycle_start(&self, count: u64, received_at: Instant<Local>) -> Instant<Local> {
        let clock = self.clock.as_ref().zip(self.now);
        let known = clock.and_then(|((_, clock), now)| {
            // The drift of the node's clock over so short a time is negligible.
            let since = clock.correction(count)?;
            Some(now - since.to_span())
        });
        known.unwrap_or(received_at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::{CycleIndex, CycleTime};

    /// Returns noise from 0 to 1, reproducible.
    fn noise(count: u64) -> f64 {
        let mixed = (count + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed >> 11) as f64 / (1_u64 << 53) as f64
    }

    #[test]
    fn the_jitter_of_arrivals_is_not_in_the_stamps() {
        let mut cycle_starts = CycleStarts::default();
        let (mut least, mut most) = (Span::MAX, Span::ZERO);
        for count in 0..8_000_u64 {
            // 200 ppm slow, and a delay of 0.1 to 0.6 ms.
            let cycle_start = Instant::from_nanos(count as i64 * 1_000_200);
            let received_at = cycle_start + Span::from_micros_f64(100.0 + 500.0 * noise(count));
            let header = FrameHeader {
                sender: 1,
                epoch: 7,
                index: CycleIndex(count as u16),
                count,
                cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
                present_after: None,
                send_stamp: Some(Span::ZERO),
            };
            cycle_starts.frame(&header, received_at);
            if count % 10 == 0 {
                cycle_starts.cycle(cycle_start + Span::from_micros(700));
                let late = cycle_starts.cycle_start(count, received_at) - cycle_start;
                // Four seconds, twice as long as the clock needs to be known.
                if count > 4_000 {
                    (least, most) = (least.min(late), most.max(late));
                }
            }
        }
        // All of them lag equally, by a time between the least and the greatest delay of a frame.
        assert!(
            least > Span::from_micros(50) && most < Span::from_micros(600),
            "{least:?} {most:?}"
        );
        assert!(most - least < Span::from_micros(30), "{least:?} {most:?}");
    }

    #[test]
    fn a_frame_alone_is_dated_by_its_arrival() {
        let received_at = Instant::from_nanos(5);
        assert_eq!(
            CycleStarts::default().cycle_start(3, received_at),
            received_at
        );
    }
}
