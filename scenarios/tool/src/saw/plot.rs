//! `coaxle saw plot`: the course of a synchronisation as a page for a browser.

use coaxle_files::saw::SawFile;
use coaxle_report::figure::Figure;
use coaxle_report::inspect::{Charts, LevelLine, Sampled};
use coaxle_report::page::{HINT, document, escaped, figure_element};
use coaxle_saw::{SawCommand, SawPlan, SyncLimits, SyncMask};

use super::course::{CoursePhase, SlaveCourse};
use super::plan::outline;
use super::text::{description, sync_mode, unit};

/// The page.
pub(super) fn page(saw: &SawFile, plan: &SawPlan) -> String {
    let title = if saw.title.is_empty() {
        "Flying saw"
    } else {
        &saw.title
    };
    let body = format!(
        "<header>\n<h1>{}</h1>\n<p class=\"facts\">{}: {}</p>\n</header>\n{}{HINT}",
        escaped(title),
        escaped(&description(saw)),
        escaped(&outline(saw, plan)),
        figure_element(&figure(saw, plan)),
    );
    document(title, &body)
}

/// The synchronisation as it is drawn.
pub(super) fn figure(saw: &SawFile, plan: &SawPlan) -> Figure {
    let course = SlaveCourse::of(plan);
    let title = if course.is_over_time() {
        "The slave over time"
    } else {
        "The slave over the master"
    };
    let caption = "Limits are dashed where the command keeps them and dotted where it does not \
                   check them; a limit far away is out of sight until you zoom out with the wheel \
                   over the numbers at the left. Rest on a point to see which phase begins there. \
                   All four charts zoom together.";
    Figure {
        id: "saw".to_owned(),
        title: title.to_owned(),
        caption: caption.to_owned(),
        ..charts(saw, &course).figure()
    }
}

/// The slave and its limits.
pub(super) fn charts(saw: &SawFile, course: &SlaveCourse<'_>) -> Charts {
    let begins = course.phases.iter().map(|phase| phase.begin);
    let mut marks = Sampled::default();
    for along in begins.chain([course.end()]) {
        marks.push(along, course.slave_at(along));
    }
    let laws = course.phases.iter().map(|phase| phase.law.clone());
    Charts {
        along: if course.is_over_time() {
            ("time since the coupling moment".to_owned(), "s".to_owned())
        } else {
            ("master".to_owned(), saw.master_unit.clone())
        },
        units: std::array::from_fn(|quantity| unit(saw, quantity)),
        course: sampled(saw, course),
        marks,
        labels: laws.chain(["synchronous".to_owned()]).collect(),
        lines: lines(saw),
    }
}

/// Places drawn of each phase.
// About one place for each pixel of a chart, even for the only phase.
const SAMPLES: usize = 1_000;
/// Length of the synchronous phase in the drawing, as a part of what comes before it.
// An eighth of the picture: enough to see the line go on.
const TAIL: f64 = 0.15;

/// The synchronisation and the beginning of the synchronous phase.
fn sampled(saw: &SawFile, course: &SlaveCourse<'_>) -> Sampled {
    let mut sampled = Sampled::default();
    for phase in &course.phases {
        sample(&mut sampled, course, phase);
    }
    let end = course.end();
    let length = match end - course.start() {
        // Nothing to synchronise: a second of it, or a unit where the master stands.
        0.0 if saw.moment.master.velocity == 0.0 => 1.0,
        0.0 => saw.moment.master.velocity,
        length => length * TAIL,
    };
    // Two places suffice: the synchronous phase is a straight line.
    for along in [end, end + length] {
        sampled.push(along, course.slave_at(along));
    }
    sampled
}

/// A phase with its own values at both ends, so that jumps are upright.
fn sample(sampled: &mut Sampled, course: &SlaveCourse<'_>, phase: &CoursePhase) {
    let CoursePhase { begin, end, .. } = *phase;
    // A float inside of the phase: at the joint itself the course belongs to one of both phases.
    sampled.push(begin, course.slave_at(inwards(begin, end)));
    for n in 1..SAMPLES {
        let along = begin + (end - begin) * (n as f64 / SAMPLES as f64);
        sampled.push(along, course.slave_at(along));
    }
    sampled.push(end, course.slave_at(inwards(end, begin)));
}

fn inwards(from: f64, to: f64) -> f64 {
    if to > from {
        from.next_up()
    } else {
        from.next_down()
    }
}

/// The limits in force.
pub(super) fn lines(saw: &SawFile) -> [Vec<LevelLine>; 4] {
    let axis = &saw.moment.axis;
    let given = limits(&saw.command);
    let mask = sync_mode(&saw.command).mask;
    // These shape the change of velocity, checked or not.
    let shaped = matches!(saw.command, SawCommand::GearInVelo(_));
    let line = |name, value, flag| LevelLine {
        name,
        value,
        binds: mask.contains(flag),
    };
    let both = |name, limit: f64, flag| {
        [limit, -limit].map(|value| LevelLine {
            // The end velocity is given by the master and the ratio, so no limit shapes it.
            binds: mask.contains(flag) || shaped && flag != SyncMask::MAX_VELO,
            ..line(name, value, flag)
        })
    };
    let positions = [
        (
            "lower limit of the axis",
            axis.min_position,
            SyncMask::MIN_POS,
        ),
        (
            "upper limit of the axis",
            axis.max_position,
            SyncMask::MAX_POS,
        ),
        (
            "lower limit of the command",
            given.min_position,
            SyncMask::OPTIONAL_MIN_POS,
        ),
        (
            "upper limit of the command",
            given.max_position,
            SyncMask::OPTIONAL_MAX_POS,
        ),
    ];
    // A limit of the command replaces that of the axis.
    let velocity = given.velocity.unwrap_or(axis.dynamics.velocity());
    let acceleration = given.acceleration.unwrap_or(axis.dynamics.acceleration());
    let deceleration = given.deceleration.unwrap_or(axis.dynamics.deceleration());
    let jerk = given.jerk.unwrap_or(axis.dynamics.jerk());
    // Two pairs of lines, because braking may be allowed more than accelerating.
    let faster = both("limit of acceleration", acceleration, SyncMask::MAX_ACC);
    let slower = both("limit of deceleration", deceleration, SyncMask::MAX_DEC);
    [
        positions
            .into_iter()
            .filter_map(|(name, limit, flag)| limit.map(|limit| line(name, limit, flag)))
            .collect(),
        both("limit of velocity", velocity, SyncMask::MAX_VELO).into(),
        faster.into_iter().chain(slower).collect(),
        both("limit of jerk", jerk, SyncMask::MAX_JERK).into(),
    ]
}

const fn limits(command: &SawCommand) -> &SyncLimits {
    match command {
        SawCommand::GearInPos(command) => &command.limits,
        SawCommand::GearInVelo(command) => &command.limits,
    }
}
