//! `coaxle saw plan`, where the synchronisation is refused.

use std::path::Path;

use coaxle_files::saw::SawFile;
use coaxle_report::inspect::{QUANTITIES, name, shown};
use coaxle_saw::{Check, SawCommand, SawRefusal, SyncMask, SyncStrategy, Violation};
use serde_json::{Value, json};

use super::text::{command_name, sync_mode, unit};
use crate::sync_flags::{any_of, flag_name};

/// The refusal for people: check and place, and values that would have passed.
pub(super) fn in_words(file: &Path, saw: &SawFile, refusal: &SawRefusal) -> String {
    let mut lines = vec![format!("{}: refused: {refusal}", file.display())];
    lines.extend(refusal.violation().map(|violation| details(saw, violation)));
    let remedy = Remedy::of(saw);
    lines.extend(remedy.distance_in_words(saw));
    lines.extend(remedy.speed_in_words(saw));
    lines.extend(remedy.flags_in_words());
    lines.extend(remedy.strategy_in_words());
    if refusal.violation().is_some() && remedy.is_missing(saw) {
        lines.push(
            "no other distance, lower speed of the master, flag or strategy was found to pass"
                .to_owned(),
        );
    }
    lines.join("\n")
}

fn details(saw: &SawFile, violation: &Violation) -> String {
    let check = violation.check;
    format!(
        "checked by {}, detailed code {:#06x}: {} {} beyond the limit",
        flag_name(check.flag()),
        check.code(),
        shown(violation.excess()),
        unit(saw, quantity(check)),
    )
}

/// The refusal with all digits.
pub(super) fn json_of(saw: &SawFile, refusal: &SawRefusal) -> Value {
    let remedy = Remedy::of(saw);
    let mut json = json!({
        "code": refusal.code(),
        "message": refusal.to_string(),
        "given": {
            "master_distance": remedy.given_distance,
            "master_speed": saw.moment.master.velocity.abs(),
        },
        "remedy": {
            "master_distance": remedy.master_distance,
            "master_speed": remedy.master_speed,
            "flags": remedy.flags,
            "strategy": remedy.strategy,
        },
    });
    if let Some(violation) = refusal.violation() {
        let quantity = quantity(violation.check);
        json["violation"] = json!({
            "checked_by": flag_name(violation.check.flag()),
            "detailed_code": violation.check.code(),
            "quantity": QUANTITIES[quantity],
            "unit": unit(saw, quantity),
            "measured": violation.measured,
            "limit": violation.limit,
            "excess": violation.excess(),
            "master_position": violation.master_position,
        });
    }
    json!({
        "title": saw.title,
        "command": command_name(&saw.command),
        "master_unit": saw.master_unit,
        "slave_unit": saw.slave_unit,
        "refusal": json,
    })
}

/// Values that would have passed, beside the given ones.
struct Remedy {
    /// Distance from the master to its synchronisation position; below 0 if it is behind.
    given_distance: Option<f64>,
    master_distance: Option<f64>,
    master_speed: Option<f64>,
    flags: SyncMask,
    strategy: Option<SyncStrategy>,
}

impl Remedy {
    fn of(saw: &SawFile) -> Self {
        let master = &saw.moment.master;
        let remedy = saw.remedy();
        // In the direction of the master, so that "before" has one meaning for both.
        let ahead = |sync: f64| (sync - master.position) * master.velocity.signum();
        Self {
            given_distance: match &saw.command {
                SawCommand::GearInPos(command) => Some(ahead(command.master_sync_position)),
                SawCommand::GearInVelo(_) => None,
            },
            master_distance: remedy.master_distance,
            master_speed: remedy.master_speed,
            flags: remedy.flags,
            strategy: remedy.strategy,
        }
    }

    /// True if a remedy was looked for in vain.
    fn is_missing(&self, saw: &SawFile) -> bool {
        saw.command.looks_for_a_remedy()
            && self.master_distance.is_none()
            && self.master_speed.is_none()
            && self.flags.is_empty()
            && self.strategy.is_none()
    }

    fn distance_in_words(&self, saw: &SawFile) -> Option<String> {
        let (passing, given) = (self.master_distance?, self.given_distance?);
        // Rounded away from the limit: six digits of the exact bound could lie on its wrong side.
        let (bound, passing) = if passing > given {
            ("least", rounded(passing, f64::ceil))
        } else {
            ("most", rounded(passing, f64::floor))
        };
        let (given, unit) = (shown(given), &saw.master_unit);
        Some(format!(
            "would pass with the master at {bound} {passing} {unit} before its synchronisation \
             position, not {given} {unit}"
        ))
    }

    fn flags_in_words(&self) -> Option<String> {
        let flags = self.flags;
        (!flags.is_empty())
            .then(|| format!("would pass with {} in sync-mode.mask too", any_of(flags)))
    }

    fn strategy_in_words(&self) -> Option<String> {
        let strategy = name(&self.strategy?);
        Some(format!("would pass with strategy = \"{strategy}\""))
    }

    fn speed_in_words(&self, saw: &SawFile) -> Option<String> {
        let passing = rounded(self.master_speed?, f64::floor);
        let (given, unit) = (shown(saw.moment.master.velocity.abs()), &saw.master_unit);
        Some(format!(
            "would pass with the master at most {passing} {unit}/s fast, not {given} {unit}/s"
        ))
    }
}

/// Remedies, each in words and as changes of fields of the file, by their paths.
pub(super) fn remedies(saw: &SawFile) -> Vec<(String, Vec<(String, Value)>)> {
    let remedy = Remedy::of(saw);
    let command = command_name(&saw.command);
    let forwards = saw.moment.master.velocity.signum();
    let number = |text: String| text.parse().unwrap_or(f64::NAN);
    let mut remedies = Vec::new();
    if let (Some(words), Some(passing), Some(given)) = (
        remedy.distance_in_words(saw),
        remedy.master_distance,
        remedy.given_distance,
    ) {
        let to_passing_side = if passing > given {
            f64::ceil
        } else {
            f64::floor
        };
        // Parsed from the text: the file gets the number that the words name.
        let distance: f64 = number(rounded(passing, to_passing_side));
        let position = saw.moment.master.position + distance * forwards;
        let field = format!("{command}.master-sync-position");
        remedies.push((words, vec![(field, position.into())]));
    }
    if let (Some(words), Some(passing)) = (remedy.speed_in_words(saw), remedy.master_speed) {
        let speed: f64 = number(rounded(passing, f64::floor));
        remedies.push((
            words,
            vec![("master.velocity".to_owned(), (speed * forwards).into())],
        ));
    }
    // Each alone is enough.
    for flag in remedy.flags.iter() {
        let words = format!("would pass with {} in sync-mode.mask too", any_of(flag));
        let mask = flags_with(sync_mode(&saw.command).mask | flag);
        remedies.push((words, vec![(format!("{command}.sync-mode.mask"), mask)]));
    }
    if let (Some(words), Some(strategy)) = (remedy.strategy_in_words(), remedy.strategy) {
        let field = format!("{command}.strategy");
        remedies.push((words, vec![(field, name(&strategy).into())]));
    }
    remedies
}

/// A mask as files have it.
pub(super) fn flags_with(mask: SyncMask) -> Value {
    mask.iter().map(flag_name).collect()
}

/// Six digits, rounded to the side that passes.
fn rounded(value: f64, to_passing_side: fn(f64) -> f64) -> String {
    // Decimals for six significant digits: 5 for 1.23456, 3 for 123.456, negative for more than a million.
    let digits = 5 - value.log10().floor() as i32;
    let scale = 10_f64.powi(digits);
    shown(to_passing_side(value * scale) / scale)
}

/// Index of the [`QUANTITIES`] that a check is about.
fn quantity(check: Check) -> usize {
    let is_it = |quantity: &&str| *quantity == check.quantity();
    // By name, as checks and charts order their quantities independently.
    QUANTITIES.iter().position(is_it).unwrap_or_default()
}
