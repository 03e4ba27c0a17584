//! `coaxle cam advise`.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use coaxle_files::cam::CamFile;
use coaxle_plate::{Demand, LawAdvice, LawCriteria, LawLimits};
use coaxle_report::inspect::{cells, name, right, shown, table};
use serde_json::{Value, json};

use super::load_unchecked;
use super::text::parse_finite;

/// Arguments of `coaxle cam advise`.
#[derive(Debug, Args)]
pub struct AdviseArgs {
    /// Cam file, TOML; it need not make a plate yet
    file: PathBuf,
    /// The segment, by the number of the point that it begins at, from 1
    #[arg(long, value_name = "POINT")]
    segment: u32,
    /// Quantity to minimise
    #[arg(long, value_enum, default_value = "acceleration")]
    least: Least,
    /// Velocity of the master, in master units per second
    #[arg(long, value_name = "V", default_value = "1", value_parser = parse_finite, allow_negative_numbers = true)]
    master_velocity: f64,
    #[command(flatten)]
    limits: LimitArgs,
    /// As JSON with all digits
    #[arg(long)]
    json: bool,
}

/// Limits of the slave.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(super) struct LimitArgs {
    /// The slave's highest velocity, per second
    #[arg(long, value_name = "V", value_parser = parse_finite)]
    max_velocity: Option<f64>,
    /// The slave's highest acceleration, per second²
    #[arg(long, value_name = "A", value_parser = parse_finite)]
    max_acceleration: Option<f64>,
    /// The slave's highest jerk, per second³
    #[arg(long, value_name = "J", value_parser = parse_finite)]
    max_jerk: Option<f64>,
    /// The slave's highest product of velocity and acceleration, per second³: a measure of its torque
    #[arg(long, value_name = "VA", value_parser = parse_finite)]
    max_torque: Option<f64>,
}

impl LimitArgs {
    pub(super) const fn limits(self) -> LawLimits {
        LawLimits {
            velocity: self.max_velocity,
            acceleration: self.max_acceleration,
            jerk: self.max_jerk,
            torque: self.max_torque,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Least {
    /// The highest velocity
    Velocity,
    /// The highest acceleration
    Acceleration,
    /// The highest jerk
    Jerk,
    /// The highest product of velocity and acceleration
    Torque,
}

impl AdviseArgs {
    /// False if no law keeps the limits.
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<bool> {
        // Unchecked, as the very segment that is asked about may be what makes no plate.
        let cam = load_unchecked(&self.file)?;
        let question = LawCriteria {
            master_velocity: self.master_velocity,
            limits: self.limits.limits(),
            least: match self.least {
                Least::Velocity => Demand::Velocity,
                Least::Acceleration => Demand::Acceleration,
                Least::Jerk => Demand::Jerk,
                Least::Torque => Demand::Torque,
            },
        };
        let advice = cam.source().law_advice(self.segment, &question)?;
        if self.json {
            let laws: Vec<_> = advice
                .iter()
                .map(|advice| json_of(advice, &question.limits))
                .collect();
            let json = json!({
                "segment": self.segment,
                "master_velocity": self.master_velocity,
                "least": question.least,
                "laws": laws,
            });
            writeln!(out, "{json:#}")?;
        } else {
            writeln!(out, "{}", self.in_words(&cam, &question, &advice))?;
        }
        // Laws come best first, and those that keep the limits before all others.
        Ok(advice.first().is_some_and(|best| best.passes))
    }

    fn in_words(&self, cam: &CamFile, question: &LawCriteria, advice: &[LawAdvice]) -> String {
        let verdict = match advice.first() {
            Some(best) if best.passes => format!(
                "from point {}, with the least {}: {}",
                self.segment,
                name(&question.least),
                best.law.file_name()
            ),
            _ => format!(
                "from point {}: no law that its points allow joins them and keeps the limits",
                self.segment
            ),
        };
        let unit = &cam.slave_unit;
        let headings = [
            "law".to_owned(),
            format!("velocity ({unit}/s)"),
            format!("acceleration ({unit}/s²)"),
            format!("jerk ({unit}/s³)"),
            format!("torque ({unit}²/s³)"),
            "remarks".to_owned(),
        ];
        let mut rows = table(headings.each_ref().map(String::as_str));
        for advice in advice {
            let demands = Demand::ALL.map(|demand| advice.demand(demand));
            // In the order of `Demand::ALL`, which is that of the headings.
            let mut row = cells(advice.law.file_name(), &demands);
            row.push(right(&remarks(cam, advice, &question.limits).join(", ")));
            rows.add_row(row);
        }
        format!(
            "{verdict}\n\nat a master velocity of {} {}/s; torque is velocity times acceleration\n\n{}",
            shown(self.master_velocity),
            cam.master_unit,
            rows.trim_fmt()
        )
    }
}

/// Reasons against a law.
pub(super) fn remarks(cam: &CamFile, advice: &LawAdvice, limits: &LawLimits) -> Vec<String> {
    let unit = &cam.slave_unit;
    let mut remarks = Vec::new();
    // Steps within rounding are exactly 0 already, so no tolerance is needed here.
    if advice.velocity_step > 0.0 {
        remarks.push(format!(
            "velocity steps by {} {unit}/s",
            shown(advice.velocity_step)
        ));
    }
    if advice.acceleration_step > 0.0 {
        remarks.push(format!(
            "acceleration steps by {} {unit}/s²",
            shown(advice.acceleration_step)
        ));
    }
    let broken = advice.broken(limits);
    remarks.extend(broken.map(|demand| format!("too much {}", name(&demand))));
    remarks
}

/// A law with all digits; no number where its jerk has no bound.
pub(super) fn json_of(advice: &LawAdvice, limits: &LawLimits) -> Value {
    // JSON has no infinity: a jerk without a bound becomes null.
    let demand = |demand| Some(advice.demand(demand)).filter(|value| value.is_finite());
    json!({
        "law": advice.law,
        "passes": advice.passes,
        "velocity": demand(Demand::Velocity),
        "acceleration": demand(Demand::Acceleration),
        "jerk": demand(Demand::Jerk),
        "jerk_inside": advice.inner_jerk(),
        "torque": demand(Demand::Torque),
        "velocity_step": advice.velocity_step,
        "acceleration_step": advice.acceleration_step,
        "broken": advice.broken(limits).collect::<Vec<_>>(),
    })
}
