//! Processor load of each side for a hundred axes in one frame.

use coaxle_clock::Span;
use serde::Serialize;

use super::end_to_end::{nodes, zenoh};
use super::pair::Measured;
use super::settings::BenchSettings;
use super::turns::BenchProgress;

/// Shares of a processor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct ProcessorLoad {
    pub(super) axes: u32,
    /// Length of a frame.
    pub(super) bytes: usize,
    /// Axes that the receiver followed at the end of each round, the fewest.
    pub(super) followed: usize,
    /// Our nodes; absent where the system does not report processor times.
    pub(super) nodes: Option<Sides>,
    /// A bare loop and Zenoh, with messages as long.
    pub(super) zenoh: Option<Sides>,
}

/// 1: a whole processor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Sides {
    pub(super) sender: f64,
    pub(super) receiver: f64,
}

/// Our nodes, Zenoh alone.
const CONTENDERS: i64 = 2;

/// Time until a receiver knows the clock that it follows, and all its axes with it: some six seconds, more on a busy
/// machine. Both contenders wait this long, so that neither is measured in a better moment.
const WARM_UP: Span = Span::from_secs(15);

/// Planned time of the measurement.
pub(super) fn planned(settings: &BenchSettings) -> Span {
    settings.planned(CONTENDERS, WARM_UP)
}

/// # Errors
/// A process fails, or Ctrl-C came.
pub(super) fn measure(
    settings: &BenchSettings,
    axes: u32,
    turns: &mut BenchProgress<'_>,
) -> anyhow::Result<ProcessorLoad> {
    let bytes = settings.nodes(axes).frame_bytes()?;
    let turn = settings.turn(CONTENDERS);
    let (mut of_nodes, mut of_zenoh) = (Vec::new(), Vec::new());
    for _ in 0..settings.rounds {
        // Without stamps of every step: they would count as load of our nodes.
        let mut pair = nodes(settings, axes, false)?;
        pair.warm_up = WARM_UP;
        of_nodes.push(pair.measure(turn, turns)?);
        let mut pair = zenoh(settings, bytes)?;
        pair.warm_up = WARM_UP;
        of_zenoh.push(pair.measure(turn, turns)?);
    }
    let followed = of_nodes.iter().map(|measured| measured.receiver.followed);
    Ok(ProcessorLoad {
        axes,
        bytes,
        // The fewest, as a round with lost axes is cheaper and must not look good.
        followed: followed.min().unwrap_or(0),
        nodes: mean(&of_nodes),
        zenoh: mean(&of_zenoh),
    })
}

/// Mean over all rounds, which are equally long.
fn mean(rounds: &[Measured]) -> Option<Sides> {
    // A round without processor times leaves the mean unknown: a mean over other rounds would not compare.
    let loads: Vec<[f64; 2]> = rounds
        .iter()
        .map(|round| round.load)
        .collect::<Option<_>>()?;
    let mean = |side: usize| loads.iter().map(|load| load[side]).sum::<f64>() / loads.len() as f64;
    // Without a round the mean is 0/0.
    (!loads.is_empty()).then(|| Sides {
        sender: mean(0),
        receiver: mean(1),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_load_is_the_mean_of_all_rounds_or_not_known() {
        let round = |load| Measured {
            load,
            ..Measured::default()
        };
        let sides = mean(&[round(Some([0.25, 0.5])), round(Some([0.75, 1.0]))]).unwrap();
        assert_eq!((sides.sender, sides.receiver), (0.5, 0.75));
        assert_eq!(mean(&[round(Some([0.1, 0.2])), round(None)]), None);
        assert_eq!(mean(&[]), None);
    }
}
