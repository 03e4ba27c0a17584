//! Figure of one beat, every cycle of it, without correction and with it.

use super::shown::ColouredCurves;
use crate::figure::{Across, Curve, Data, Figure, Look, Panel};
use coaxle_lab::row::Row;
use coaxle_lab::units;

/// Returns the positions, velocity and acceleration around the beat of a receiver without correction, and of the best cured
/// one.
pub(super) fn figure(receivers: &[ColouredCurves<'_>]) -> Figure {
    let beats: Vec<_> = compared(receivers)
        .into_iter()
        .filter_map(ReceiverBeat::of)
        .collect();
    let unit = units::common(beats.iter().map(|beat| &beat.receiver.curves.unit));
    let panel = |quantity: &str, unit: String, curves: Vec<Curve>| Panel {
        quantity: quantity.to_owned(),
        unit,
        height: 200,
        marks: vec![0.0],
        curves,
        ..Panel::default()
    };
    let of_all = || beats.iter();
    let panels = [
        panel(
            "position – truth",
            unit.to_string(),
            of_all().flat_map(ReceiverBeat::offsets).collect(),
        ),
        panel(
            "velocity",
            unit.in_place_of_u("u/s"),
            of_all().map(ReceiverBeat::velocity).collect(),
        ),
        panel(
            "acceleration",
            unit.in_place_of_u("u/s²"),
            of_all().map(ReceiverBeat::acceleration).collect(),
        ),
    ];
    Figure {
        id: "beat".to_owned(),
        title: "Around one beat".to_owned(),
        caption: "A receiver without correction beside a cured one, a point each cycle. Above: received (dotted) and corrected \
                  position (solid) of the far axis, minus its true position at that instant; the beat moves the received \
                  position by the way of one cycle. Below: how the corrected position moves from cycle to cycle, as the slaves \
                  are given it, and how that changes. Time counts from the beat as each receiver sees it.".to_owned(),
        across: Across::beat(),
        panels: panels.into(),
        is_on_one_scale: false,
    }
}

/// Returns the first receiver without correction, and the best that cures it, of those that kept a beat.
fn compared<'a, 'b>(receivers: &'b [ColouredCurves<'a>]) -> Vec<&'b ColouredCurves<'a>> {
    let with_beat = || (receivers.iter()).filter(|shown| !shown.curves.around_beat.is_empty());
    let of_mode = |mode| with_beat().find(|shown| shown.curves.mode == mode);
    // By how much they cure: the comparison is with the best there is.
    let mut best = ["observer", "sync", "time", "pt1"].into_iter();
    let bare = of_mode("bypass");
    bare.into_iter().chain(best.find_map(of_mode)).collect()
}

/// A receiver's cycles around its beat.
struct ReceiverBeat<'a> {
    receiver: &'a ColouredCurves<'a>,
    rows: &'a [Row],
    /// Time of the beat, s.
    zero: f64,
}

impl<'a> ReceiverBeat<'a> {
    fn of(receiver: &'a ColouredCurves<'_>) -> Option<Self> {
        let rows = &receiver.curves.around_beat;
        let zero = time_of_beat(rows)?;
        Some(Self {
            receiver,
            rows,
            zero,
        })
    }

    /// Returns a curve through a value of each row; none is a gap.
    fn curve(&self, what: &str, look: Look, values: impl Iterator<Item = Option<f64>>) -> Curve {
        let ms = self.rows.iter().map(|row| 1e3 * (row.t_s - self.zero));
        let points = ms.zip(values.map(|value| value.unwrap_or(f64::NAN)));
        let name = format!("{}: {what}", self.receiver.name());
        Curve {
            group: self.receiver.name().to_owned(),
            look,
            ..Curve::new(&name, &self.receiver.colour, Data::Points(points.collect()))
        }
    }

    fn offsets(&self) -> Vec<Curve> {
        let off = |position: fn(&Row) -> Option<f64>| {
            let rows = self.rows.iter();
            rows.map(move |row| Some(position(row)? - row.truth?.0))
        };
        vec![
            self.curve(
                "corrected",
                Look::Solid,
                off(|row| row.record.axis.corrected_position),
            ),
            self.curve(
                "received",
                Look::Dotted,
                off(|row| row.record.axis.received_position),
            ),
        ]
    }

    fn velocity(&self) -> Curve {
        self.curve("velocity", Look::Dots, self.velocities().into_iter())
    }

    fn acceleration(&self) -> Curve {
        let velocities = self.velocities();
        let velocities: Vec<_> = self.times().zip(velocities).collect();
        self.curve("acceleration", Look::Dots, rates(&velocities).into_iter())
    }

    /// Returns the difference quotients of the corrected position.
    fn velocities(&self) -> Vec<Option<f64>> {
        let positions = self
            .rows
            .iter()
            .map(|row| row.record.axis.corrected_position);
        rates(&self.times().zip(positions).collect::<Vec<_>>())
    }

    fn times(&self) -> impl Iterator<Item = f64> {
        self.rows.iter().map(|row| row.t_s)
    }
}

/// Returns the difference quotients over the cycle that ends at each value; the first has none.
fn rates(values: &[(f64, Option<f64>)]) -> Vec<Option<f64>> {
    let rate = |pair: &[(f64, Option<f64>)]| {
        let [(t0, before), (t1, after)] = *pair else {
            return None;
        };
        Some(((after?) - (before?)) / (t1 - t0))
    };
    let first = values.first().map(|_| None);
    first
        .into_iter()
        .chain(values.windows(2).map(rate))
        .collect()
}

/// Returns the time of the beat, s. The receivers' own detection comes a plateau later, so the step is searched in the sender's
/// count before it: the split that leaves the least spread on either side.
fn time_of_beat(rows: &[Row]) -> Option<f64> {
    let detected = rows
        .windows(2)
        .position(|pair| pair[1].record.far.beats > pair[0].record.far.beats)
        // The pair's second row is the one that detected it, and counts still.
        .map_or(rows.len(), |n| n + 2);
    let counts: Vec<_> = rows[..detected]
        .iter()
        .filter_map(|row| Some((row.t_s, row.record.node.cycle, row.record.far.count?)))
        .collect();
    beat_in(&counts)
}

/// Returns the time of the beat from the times, own cycles and sender's counts up to the detection.
fn beat_in(counts: &[(f64, u64, u64)]) -> Option<f64> {
    let (_, first_cycle, first) = *counts.first()?;
    let (_, last_cycle, last) = *counts.last()?;
    let cycles = last_cycle.saturating_sub(first_cycle).max(1) as f64;
    let per_cycle = last.saturating_sub(first) as f64 / cycles;
    // The cycle times are whole multiples of each other.
    let per_cycle = if per_cycle >= 1.0 {
        per_cycle.round()
    } else {
        // Cycle times are 100 µs to 100 ms (docs/LIMITS.md), so no count is slower than that.
        1.0 / (1.0 / per_cycle.max(1e-3)).round()
    };
    let lead: Vec<f64> = counts
        .iter()
        .map(|(_, cycle, count)| {
            let cycles = cycle.saturating_sub(first_cycle) as f64;
            // Without the slope only the phase is left: level before the beat, and level one count beside it after.
            count.saturating_sub(first) as f64 - per_cycle * cycles
        })
        .collect();
    let (t, _, _) = counts.get(step_in(&lead)?)?;
    Some(*t)
}

/// Returns the index at which two levels fit best: that of the first value of the second one.
fn step_in(values: &[f64]) -> Option<usize> {
    let total: f64 = values.iter().sum();
    let count = values.len() as f64;
    let mut before = 0.0;
    let mut best: Option<(f64, usize)> = None;
    for (n, value) in values
        .iter()
        .enumerate()
        // Both parts need a value.
        .take(values.len().saturating_sub(1))
    {
        before += value;
        let left = (n + 1) as f64;
        let right = count - left;
        // The spread within both parts is least where the part between them is largest.
        // Sums of squares of all values are the same for each split, and need not be summed.
        let between = before * before / left + (total - before) * (total - before) / right;
        if best.is_none_or(|(most, _)| between > most) {
            best = Some((between, n + 1));
        }
    }
    best.map(|(_, n)| n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_found_among_stragglers() {
        let mut values = vec![0.0; 100];
        values.extend(vec![-1.0; 90]);
        // A late message, and the flutter of jitter right at the beat.
        values[150] = -2.0;
        values[97] = -1.0;
        assert_eq!(step_in(&values), Some(100));
    }

    #[test]
    fn the_beat_is_dated_where_the_count_steps() {
        // Own cycles, in which the sender's count gains one at the hundredth, or loses one.
        let counts = |per_cycle: f64, step: f64| -> Vec<(f64, u64, u64)> {
            (0..200_u64)
                .map(|cycle| {
                    let step = if cycle < 100 { 0.0 } else { step };
                    let count = (per_cycle * cycle as f64).floor() + 10.0 + step;
                    (cycle as f64 * 0.5, cycle, count as u64)
                })
                .collect()
        };
        for (per_cycle, step) in [
            (1.0, 1.0),
            (1.0, -1.0),
            (2.0, 1.0),
            (0.5, 1.0),
            (0.25, -1.0),
        ] {
            let found = beat_in(&counts(per_cycle, step));
            assert_eq!(found, Some(50.0), "{per_cycle} per cycle, {step}");
        }
    }

    #[test]
    fn a_rate_is_that_of_the_cycle_before() {
        let values = [
            (0.0, Some(1.0)),
            (0.5, Some(2.0)),
            (1.0, None),
            (1.5, Some(2.0)),
        ];
        assert_eq!(rates(&values), [None, Some(2.0), None, None]);
        assert!(rates(&[]).is_empty());
    }

    #[test]
    fn no_values_no_step() {
        assert_eq!(step_in(&[]), None);
        assert_eq!(step_in(&[1.0]), None);
        assert_eq!(time_of_beat(&[]), None);
    }
}
