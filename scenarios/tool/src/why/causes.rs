//! The causes of errors, by the status of a node.
//!
//! An error of time counts by the velocity of the axis, so that all of them are distances, and can be compared.

use serde::Serialize;

use crate::status::{COVERED, StatusFields};

/// Velocity at which an axis that stands is compared, u/s.
const USUAL_VELOCITY: f64 = 1_000.0;
/// Slowest motion that counts as one, u/s.
const MOVING: f64 = 1e-6;
/// Share of lost messages that is worth a word.
const MUCH_LOSS: f64 = 1e-3;
/// Part of the largest error from which on another one counts.
const WORTH_A_WORD: f64 = 1e-3;

/// A cause of errors.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) struct LimitingCause {
    /// Short name of the cause, for programs.
    pub(super) cause: &'static str,
    /// True for a fault, beside which errors do not count.
    pub(super) is_wrong: bool,
    /// What it is, and of which part of the node.
    pub(super) what: String,
    /// Error of time, µs.
    pub(super) time_us: Option<f64>,
    /// Distance.
    pub(super) way: Option<FoundWay>,
    /// Reason in a sentence.
    pub(super) why: String,
    /// What to change.
    pub(super) remedy: Option<String>,
}

/// Distance by which an axis or a drive is off.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) struct FoundWay {
    pub(super) by: f64,
    pub(super) unit: String,
    /// The velocity that an error of time was multiplied by, u/s.
    pub(super) at_velocity: Option<f64>,
}

/// Finds what is wrong, and then the errors, the largest first. `before` is an earlier status, from which counters have grown.
pub(super) fn findings(
    before: &StatusFields<'_>,
    now: &StatusFields<'_>,
    velocity: Option<f64>,
) -> Vec<LimitingCause> {
    let mut found = Vec::new();
    node(before, now, &mut found);
    for (name, far) in now.parts("far") {
        let motion = JudgedMotion::of_axes(now, name, velocity);
        let of = FarNodeStatus {
            name,
            far,
            before: before.part("far").and_then(|all| all.part(name)),
            source: now.part("sources").and_then(|all| all.part(name)),
            motion,
        };
        of.find(&mut found);
        for (axis, fields) in now.parts("axes") {
            if fields.text("node") == Some(name) {
                of.find_axis(axis, &fields, &mut found);
            }
        }
    }
    for (name, slave) in now.parts("slaves") {
        find_slave(name, &slave, &mut found);
    }
    // One of unknown size may be any.
    let size = |finding: &LimitingCause| finding.way.as_ref().map_or(f64::INFINITY, |way| way.by);
    let known = found.iter().map(&size).filter(|size| size.is_finite());
    let least = WORTH_A_WORD * known.fold(0.0, f64::max);
    found.retain(|finding| finding.is_wrong || size(finding) > least);
    // Stable: faults stay in the order from the node to its slaves.
    found.sort_by(|one, other| {
        let by_kind = other.is_wrong.cmp(&one.is_wrong);
        by_kind.then_with(|| match one.is_wrong {
            true => std::cmp::Ordering::Equal,
            false => size(other).total_cmp(&size(one)),
        })
    });
    found
}

/// Adds what is wrong with the node itself.
fn node(before: &StatusFields<'_>, now: &StatusFields<'_>, found: &mut Vec<LimitingCause>) {
    let skipped = now
        .count("overruns")
        .saturating_sub(before.count("overruns"));
    if skipped > 0 {
        found.push(LimitingCause::fault(
            "skipped-cycles",
            format!("{skipped} cycles were skipped in the last second"),
            "Its thread was not woken in time: axes are moved on at once, and slaves step as far as their limits let them.".to_owned(),
            "give it [real-time] priority, or a longer cycle-time-us; `coaxle doctor` says what this PC can do",
        ));
    }
}

/// The motion by which an error of time becomes a distance.
#[derive(Clone, Debug)]
struct JudgedMotion {
    velocity: f64,
    unit: String,
}

impl JudgedMotion {
    /// That of the fastest axis of a far node.
    fn of_axes(now: &StatusFields<'_>, node: &str, asked: Option<f64>) -> Self {
        let axes = now.parts("axes");
        let axes = axes.filter(|(_, axis)| axis.text("node") == Some(node));
        let mut fastest = Self {
            velocity: 0.0,
            unit: "u".to_owned(),
        };
        for (n, (_, axis)) in axes.enumerate() {
            let velocity = axis.number("corrected_velocity").unwrap_or_default().abs();
            if n == 0 || velocity > fastest.velocity {
                let unit = axis.text("unit").unwrap_or("u").to_owned();
                fastest = Self { velocity, unit };
            }
        }
        if fastest.velocity < MOVING {
            fastest.velocity = USUAL_VELOCITY;
        }
        fastest.velocity = asked.unwrap_or(fastest.velocity);
        fastest
    }

    fn way(&self, time_us: f64) -> FoundWay {
        FoundWay {
            by: self.velocity * time_us * 1e-6,
            unit: self.unit.clone(),
            at_velocity: Some(self.velocity),
        }
    }
}

/// A far node of the status.
struct FarNodeStatus<'a> {
    name: &'a str,
    far: StatusFields<'a>,
    before: Option<StatusFields<'a>>,
    source: Option<StatusFields<'a>>,
    motion: JudgedMotion,
}

impl FarNodeStatus<'_> {
    /// Adds what its messages and its clock are limited by.
    fn find(&self, found: &mut Vec<LimitingCause>) {
        if let Some(fault) = self.fault() {
            // Without a clock nothing else is known.
            found.push(fault);
            return;
        }
        found.extend(self.mode());
        if self.far.text("mode") == Some("observer") {
            found.extend(self.common_time());
            found.extend(self.delay());
            found.extend(self.noise());
            found.extend(self.catching_up());
        }
        found.extend(self.offset());
    }

    fn fault(&self) -> Option<LimitingCause> {
        let name = self.name;
        let health = self.far.text("health").unwrap_or("ok");
        let unseen = self.source.and_then(|source| source.text("unseen"));
        if let Some(reason) = unseen {
            return Some(LimitingCause::fault(
                "unseen",
                format!("nothing comes from {name}"),
                reason.to_owned(),
                "start it, or correct the connection; `coaxle nodes` lists who is there",
            ));
        }
        let remedy = match health {
            "ok" | "no-standby" | "on-standby" | "clocks-disagree" => return None,
            "waiting-for-master" => "wait for its first frame; `coaxle nodes` lists who is there",
            "starting-up" => "wait: a clock is known after one to five seconds",
            "disabled" => "`coaxle command` with enable",
            "master-silent" => "look at the node and the way to it: no new frame comes",
            "two-senders" => "stop one of them, or give it another name",
            "cycle-times-do-not-fit" | "pace-out-of-range" => {
                "make the cycle times alike, or multiples of each other"
            }
            _ => "the error says what to do; `coaxle status` has all of it",
        };
        let error = self.far.fault("error");
        let why = error.unwrap_or_else(|| format!("Its health is {health}."));
        let what = format!("the clock of {name} is not known");
        Some(LimitingCause::fault("not-in-sync", what, why, remedy))
    }

    /// A mode that does not know the time of the far node.
    fn mode(&self) -> Option<LimitingCause> {
        let mode = self.far.text("mode").filter(|mode| *mode != "observer")?;
        let why = match mode {
            "bypass" | "pt1" => {
                "Values are used as they come, as old as their way, and a cycle is repeated or missed now and then."
            }
            _ => {
                "The blocks of TS5066 know the drift, but not the delay of the way, and take a lost message for a beat."
            }
        };
        let what = format!("mode {mode} of {}", self.name);
        Some(LimitingCause {
            remedy: Some("mode = \"observer\"".to_owned()),
            ..LimitingCause::of_unknown_size("mode", what, why)
        })
    }

    /// A time in common that is not what it states.
    fn common_time(&self) -> Option<LimitingCause> {
        let is_contradicted = self.far.text("health") == Some("clocks-disagree");
        let why = "PTP thinks that both PCs have one time, and the ways of beacons or messages do not permit it: an asymmetry that was set wrongly, \
                   a clock in free run, another grandmaster.";
        let remedy = "`common_time_apart_us` of both nodes says by how much: compare `pmc 'GET TIME_STATUS_NP'` of the PCs and of the switches between; \
                      docs/CLOCKS.md";
        is_contradicted.then(|| LimitingCause {
            remedy: Some(remedy.to_owned()),
            ..LimitingCause::of_unknown_size(
                "clocks-disagree",
                format!("the time in common with {} is not followed", self.name),
                why,
            )
        })
    }

    fn delay(&self) -> Option<LimitingCause> {
        let name = self.name;
        let what = format!("delay of the way from {name}");
        if self.far.text("delay_state") == Some("off") {
            let why = "The delay is not taken into account: axes are as late as their way is long.";
            return Some(LimitingCause {
                remedy: Some("delay = \"measured\"".to_owned()),
                ..LimitingCause::of_unknown_size("delay", what, why)
            });
        }
        let uncertainty = self.far.number("delay_uncertainty_us")?;
        let why = "The two directions may differ: the error is at most half of the round trip, and none if they are alike.";
        let mut found = self.of_time("delay", what, uncertainty, why.to_owned());
        let timing = self.far.text("timing_state");
        found.remedy = Some(match timing {
            None => format!(
                "a timing channel to {name} has a shorter round trip (docs/OBSERVER.md); or state the asymmetry, if it is known"
            ),
            Some("in-use") => match self.far.text("timing_stamps") {
                Some("application") => "its stamps are those of the program: those of the kernel are closer to the wire".to_owned(),
                _ => "it is that of the timing channel already; beacons by another way, or a stated asymmetry, can lessen it".to_owned(),
            },
            Some(state) => format!("its timing channel is {state}: open the UDP port of {name}"),
        });
        Some(found)
    }

    fn noise(&self) -> Option<LimitingCause> {
        let is_timed = self.far.text("timing_state") == Some("in-use");
        let field = if is_timed {
            "timing_sigma_us"
        } else {
            "offset_sigma_us"
        };
        let sigma = self
            .far
            .number(field)
            .or_else(|| self.far.number("offset_sigma_us"))?;
        let number = |name| self.far.number(name).unwrap_or_default();
        let (normal, exponential) = (number("normal_jitter_us"), number("exponential_jitter_us"));
        let jitter = normal.hypot(exponential);
        let why = format!(
            "Messages scatter by {} about their time, of which the clock keeps that much.",
            super::micros(jitter)
        );
        let what = format!("scatter of the messages from {}", self.name);
        let mut found = self.of_time("jitter", what, COVERED * sigma, why);
        found.remedy = Some(
            "[real-time] priorities at both nodes, a quieter network, or a timing channel"
                .to_owned(),
        );
        Some(found)
    }

    fn catching_up(&self) -> Option<LimitingCause> {
        let left = self.far.number("slew_remaining_us")?.abs();
        let why =
            "A better estimate is approached by 0.1 % of the time at most, so that no axis steps.";
        let what = format!("correction of the clock of {} under way", self.name);
        let mut found = self.of_time("slew", what, left, why.to_owned());
        found.remedy = Some(format!(
            "wait {}; where it comes again and again, delays step: {} so far",
            super::micros(left * 1e3),
            self.far.count("shifts"),
        ));
        Some(found)
    }

    /// An offset that was asked for.
    fn offset(&self) -> Option<LimitingCause> {
        let offset = self.far.number("time_offset_us")?;
        let why = "It is asked for: delay-time-offset-s of the config, in force in all settings of the delay.";
        let what = format!("offset of the time of {}", self.name);
        let mut found = self.of_time("offset", what, offset.abs(), why.to_owned());
        found.remedy = Some(
            "delay-time-offset-s = 0, or dead-time-us of a slave for the dead time of its drive"
                .to_owned(),
        );
        Some(found)
    }

    /// Adds what an axis of the node is limited by.
    fn find_axis(&self, name: &str, axis: &StatusFields<'_>, found: &mut Vec<LimitingCause>) {
        let unit = axis.text("unit").unwrap_or("u");
        let way = |by: f64| FoundWay {
            by,
            unit: unit.to_owned(),
            at_velocity: None,
        };
        if let Some(continuity) = axis.text("continuity").filter(|it| *it != "following") {
            found.push(LimitingCause::fault(
                "continuity",
                format!("axis {name} is {continuity}"),
                "It was lost or has jumped, and is brought along a curve within its observed limits.".to_owned(),
                "wait; where it comes again and again, look for the cause in the log of the node",
            ));
        }
        if axis.is("interpolated") {
            return;
        }
        if let Some(sigma) = axis.number("prediction_sigma") {
            let clock = self.far.number("offset_sigma_us").unwrap_or_default() * 1e-6;
            let velocity = axis.number("corrected_velocity").unwrap_or_default();
            let own = (sigma * sigma - (clock * velocity).powi(2)).max(0.0).sqrt();
            let mut finding = LimitingCause {
                cause: "prediction",
                is_wrong: false,
                what: format!("prediction of axis {name}"),
                time_us: None,
                way: Some(way(COVERED * own)),
                why: self.why_predicted(),
                remedy: None,
            };
            finding.remedy = self.instead_of_a_prediction();
            found.push(finding);
        }
        if let Some(sigma) = axis.number("position_sigma") {
            found.push(LimitingCause {
                cause: "increments",
                is_wrong: false,
                what: format!("increments of axis {name}"),
                time_us: None,
                way: Some(way(COVERED * sigma)),
                why: "Its position is smoothed from increments of an encoder.".to_owned(),
                remedy: Some(
                    "an encoder with finer increments, or the set values of the axis".to_owned(),
                ),
            });
        }
    }

    fn why_predicted(&self) -> String {
        let mut why = "The newest frame is moved to now: what the master has done since it was sent is not known yet".to_owned();
        if let Some(share) = self.lost_share().filter(|share| *share > MUCH_LOSS) {
            why += &format!("; {:.1} % of the messages are lost", share * 100.0);
        }
        why + "."
    }

    fn instead_of_a_prediction(&self) -> Option<String> {
        let needed = self
            .far
            .number("needed_present_after_us")
            .map(|us| us * 1e-3);
        let margin = self
            .far
            .number("presentation_margin_us")
            .map(|us| us * 1e-3);
        let name = self.name;
        Some(match (margin, needed) {
            (Some(margin), _) if margin < 0.0 => format!(
                "its axes are shown later, but too early by {:.1} ms: raise present-after-ms at {name}, or lag-ms here",
                -margin
            ),
            (_, Some(needed)) => format!(
                "present-after-ms = {:.1} or more at {name}, or a lead-ms, where its axes are generated (docs/PRESENTATION.md); or a shorter way",
                needed
            ),
            (_, None) => {
                "a shorter way, or axes that are shown later (docs/PRESENTATION.md)".to_owned()
            }
        })
    }

    /// Share of the messages that were lost between the two statuses.
    fn lost_share(&self) -> Option<f64> {
        let before = self.before?;
        let grown = |name| self.far.count(name).saturating_sub(before.count(name)) as f64;
        let (lost, expected) = (grown("lost"), grown("expected"));
        (expected > 0.0).then(|| lost / expected)
    }

    fn of_time(
        &self,
        cause: &'static str,
        what: String,
        time_us: f64,
        why: String,
    ) -> LimitingCause {
        LimitingCause {
            cause,
            is_wrong: false,
            what,
            time_us: Some(time_us),
            way: Some(self.motion.way(time_us)),
            why,
            remedy: None,
        }
    }
}

/// Adds what a slave and its drive are limited by.
fn find_slave(name: &str, slave: &StatusFields<'_>, found: &mut Vec<LimitingCause>) {
    let unit = slave.text("unit").unwrap_or("u").to_owned();
    let way = |by: f64| FoundWay {
        by: by.abs(),
        unit: unit.clone(),
        at_velocity: None,
    };
    if let Some(error) = slave.fault("error") {
        let what = format!("slave {name} is in error");
        let remedy = "remove the cause, then `coaxle command` with reset";
        found.push(LimitingCause::fault("slave-error", what, error, remedy));
        return;
    }
    let distance = slave.number("distance").unwrap_or_default();
    if slave.text("guard").is_some_and(|guard| guard != "tracking") {
        found.push(LimitingCause {
            cause: "limits",
            is_wrong: false,
            what: format!("limits of slave {name}"),
            time_us: None,
            way: Some(way(distance)),
            why: "Its master asks for more than its limits let it do, so that it is behind the position of its coupling.".to_owned(),
            remedy: Some("raise limits of the slave, as far as its drive permits, or slow the master down: keep-limits of its sender".to_owned()),
        });
    }
    let lag = slave.number("following_error").unwrap_or_default();
    let velocity = slave.number("drive_velocity").unwrap_or_default();
    let behind = (velocity.abs() > MOVING)
        .then(|| lag / velocity)
        .filter(|time| *time > 0.0);
    found.push(LimitingCause {
        cause: "drive",
        is_wrong: false,
        what: format!("following error of the drive of {name}"),
        time_us: behind.map(|time| time * 1e6),
        way: Some(way(lag)),
        why: "The drive is behind its set values.".to_owned(),
        remedy: Some(match behind {
            Some(time) => format!(
                "at a constant velocity it is a dead time: dead-time-us = {:.0} of the slave gives them that much earlier; or stiffer controllers",
                time * 1e6
            ),
            None => "stiffer controllers in the drive".to_owned(),
        }),
    });
}

impl LimitingCause {
    fn of_unknown_size(cause: &'static str, what: String, why: &str) -> Self {
        Self {
            cause,
            is_wrong: false,
            what,
            time_us: None,
            way: None,
            why: why.to_owned(),
            remedy: None,
        }
    }

    fn fault(cause: &'static str, what: String, why: String, remedy: &str) -> Self {
        Self {
            cause,
            is_wrong: true,
            what,
            time_us: None,
            way: None,
            why,
            remedy: Some(remedy.to_owned()),
        }
    }
}
