//! The figures of a run, in the order of the page.

use coaxle_lab::curves::{Curves, Series};
use coaxle_lab::summary::{ReceiverSummary, Summary};
use coaxle_receiver::FilterState;

use super::around_beat;
use super::shown::{ColouredCurves, coloured};
use super::slaves;
use crate::figure::{Across, Curve, Data, Figure, Look, Panel, Room, Scale};
use crate::plotting::NEUTRAL;

/// Returns all figures of a run, those without any curve among them.
pub(super) fn all(summary: &Summary, curves: &[Curves]) -> Vec<Figure> {
    let shown = coloured(curves);
    // A single slave is the drive of the velocity panel.
    let several = curves.iter().any(|curves| curves.slaves.len() > 1);
    let positions = curves.iter().flat_map(|curves| &curves.slaves);
    let positions = positions.map(|slave| &slave.position);
    let positions = positions.filter(|_| several);
    let series = curves.iter().flat_map(|curves| {
        [
            &curves.set_velocity,
            &curves.drive_velocity,
            &curves.correction_us,
            &curves.time_error_us,
            &curves.drift_ppm,
        ]
    });
    let run = RunFigures {
        summary,
        receivers: &shown,
        // Only series that are drawn take room.
        room: Room::shared_by(series.chain(positions)),
    };
    let cuts = slaves::cuts(summary, &shown);
    // Left out if they are empty.
    let of_cuts = (!cuts.is_empty()).then_some(cuts);
    let of_slaves = several.then(|| slaves::positions(&shown, run.room));
    let of_the_far_axis = [
        run.velocity(),
        around_beat::figure(&shown),
        run.correction(),
        run.time_error(),
        run.drift(),
        run.state(),
    ];
    of_cuts
        .into_iter()
        .chain(of_slaves)
        .chain(of_the_far_axis)
        .collect()
}

struct RunFigures<'a> {
    summary: &'a Summary,
    receivers: &'a [ColouredCurves<'a>],
    room: Room,
}

impl RunFigures<'_> {
    fn velocity(&self) -> Figure {
        let panels = self.receivers.iter().map(|receiver| {
            let data = |series| Data::of(series, self.room, 0.0);
            let name = format!("{}: set velocity", receiver.name());
            let set = data(&receiver.curves.set_velocity);
            let drive = data(&receiver.curves.drive_velocity);
            let drive = Curve::new("actual velocity of the drive", NEUTRAL, drive);
            let curves = [Curve::new(&name, &receiver.colour, set), drive];
            Panel {
                title: receiver.title(),
                unit: receiver.curves.drive_unit().in_place_of_u("u/s"),
                height: 170,
                marks: self.first_sync(receiver).into_iter().collect(),
                curves: drawn(curves),
                ..Panel::default()
            }
        });
        Figure {
            id: "velocity".to_owned(),
            title: "Velocity, without correction and with it".to_owned(),
            caption: "Set velocity (coloured) and actual velocity of the drive (grey), every \
                      receiver on the same scale, those without correction first. Spikes are \
                      beats: messages missed or received twice because two clocks drift. A \
                      dotted line marks the first synchronisation."
                .to_owned(),
            across: Across::run(),
            panels: panels.collect(),
            is_on_one_scale: true,
        }
    }

    fn figures(&self, receiver: &ColouredCurves<'_>) -> Option<&ReceiverSummary> {
        self.summary.receivers.get(&receiver.curves.name)
    }

    /// Returns the time at which the receiver first synchronised.
    fn first_sync(&self, receiver: &ColouredCurves<'_>) -> Option<f64> {
        let figures = self.figures(receiver)?;
        figures.time_to_sync_s?;
        figures.evaluated_from_s
    }

    fn correction(&self) -> Figure {
        Figure {
            id: "correction".to_owned(),
            title: "Correction time".to_owned(),
            caption: "By how much the received axis is extrapolated. A steady ramp, set back by \
                      one cycle at every beat, is the drift being compensated."
                .to_owned(),
            ..self.over_time("µs", |curves| &curves.correction_us, |_| 0.0)
        }
    }

    fn time_error(&self) -> Figure {
        // The mean error is minus the lag.
        let lag = |receiver: &ColouredCurves<'_>| {
            let lag = self.figures(receiver).and_then(|figures| figures.lag_us);
            // A receiver that was never evaluated has no lag, but its curve.
            lag.unwrap_or_else(|| -middle(&receiver.curves.time_error_us))
        };
        Figure {
            id: "time-error".to_owned(),
            title: "Error of the corrected time".to_owned(),
            caption: "The far time each set value stands for, minus the true one, without the \
                      mean (the lag). Times the velocity it is the position error."
                .to_owned(),
            ..self.over_time("µs", |curves| &curves.time_error_us, lag)
        }
    }

    /// End of the run, s: an interrupted one has no curves beyond it.
    fn end_s(&self) -> f64 {
        let Summary {
            duration_s,
            interrupted_at_s,
            ..
        } = self.summary;
        interrupted_at_s.unwrap_or(*duration_s)
    }

    fn drift(&self) -> Figure {
        let mut figure = self.over_time("ppm", |curves| &curves.drift_ppm, |_| 0.0);
        let true_drifts = self.receivers.iter().filter_map(|receiver| {
            let ppm = self.figures(receiver)?.drift_ppm_true?;
            let name = format!("{}: true", receiver.name());
            Some(Curve {
                group: receiver.name().to_owned(),
                colour: receiver.colour.clone(),
                ..Curve::level(&name, ppm, 0.0, self.end_s())
            })
        });
        // True values alone would be a figure of nothing that was estimated.
        if !figure.is_empty() {
            figure.panels[0].curves.extend(true_drifts);
        }
        Figure {
            id: "drift".to_owned(),
            title: "Estimated drift".to_owned(),
            caption: "The sender's clock against the receiver's own, positive when the sender's \
                      is the faster one. Dashed: the true value at the end of the run."
                .to_owned(),
            ..figure
        }
    }

    fn state(&self) -> Figure {
        let count = self.receivers.len() as f64;
        let curves = self
            .receivers
            .iter()
            .enumerate()
            .filter_map(|(n, receiver)| {
                let states = &receiver.curves.states;
                let last = states.last()?;
                // Side by side, so that none hides another.
                // All receivers within half a level, so that they stay apart from those of the next one.
                let shift = 0.5 * ((n as f64 + 0.5) / count - 0.5);
                // Only changes are kept: the last state lasts to the end.
                let end = (self.end_s().max(last.0), last.1);
                let points = states.iter().chain([&end]);
                let points = points.map(|(t, state)| (*t, level(*state) - shift));
                Some(Curve {
                    look: Look::Steps,
                    ..Curve::new(
                        receiver.name(),
                        &receiver.colour,
                        Data::Points(points.collect()),
                    )
                })
            });
        let panel = Panel {
            height: 260,
            scale: Scale::Words(STATES.map(str::to_owned).into()),
            curves: curves.collect(),
            ..Panel::default()
        };
        Figure {
            id: "state".to_owned(),
            title: "State".to_owned(),
            caption: "The mode that makes the set values.".to_owned(),
            across: Across::run(),
            panels: vec![panel],
            is_on_one_scale: false,
        }
    }

    /// Returns one curve per receiver over the whole run. Values while it locks in may lie beyond the range.
    fn over_time(
        &self,
        unit: &str,
        series: impl Fn(&Curves) -> &Series,
        offset: impl Fn(&ColouredCurves<'_>) -> f64,
    ) -> Figure {
        let curves = self.receivers.iter().map(|receiver| {
            let data = Data::of(series(receiver.curves), self.room, offset(receiver));
            Curve {
                settled_from: self.first_sync(receiver).unwrap_or(f64::NEG_INFINITY),
                ..Curve::new(receiver.name(), &receiver.colour, data)
            }
        });
        let panel = Panel {
            unit: unit.to_owned(),
            height: 320,
            curves: drawn(curves),
            ..Panel::default()
        };
        Figure {
            across: Across::run(),
            panels: vec![panel],
            ..Figure::default()
        }
    }
}

/// Returns the curves that are not empty.
fn drawn(curves: impl IntoIterator<Item = Curve>) -> Vec<Curve> {
    let curves = curves.into_iter();
    curves.filter(|curve| !curve.data.is_empty()).collect()
}

/// States by their levels.
const STATES: [&str; 6] = ["no data", "bypass", "pt1", "time", "sync", "observer"];

fn level(state: Option<FilterState>) -> f64 {
    match state {
        None => 0.0,
        Some(FilterState::Bypass) => 1.0,
        Some(FilterState::Pt1) => 2.0,
        Some(FilterState::Time) => 3.0,
        Some(FilterState::Sync) => 4.0,
        Some(FilterState::Observer) => 5.0,
    }
}

fn middle(series: &Series) -> f64 {
    let count = series.stretches.len().max(1) as f64;
    let sum: f64 = series.stretches.iter().map(|s| s.low + s.high).sum();
    // Each stretch has as many cycles as any other but the last, so the mean of their middles is near enough for an offset.
    sum / (2.0 * count)
}
