//! `coaxle gear plot`: the course of a flying gear as a page for a browser.

use coaxle_files::gear::GearFile;
use coaxle_gear::FlyingGear;
use coaxle_report::figure::Figure;
use coaxle_report::inspect::{Charts, LevelLine, Sampled};
use coaxle_report::page::{HINT, document, escaped, figure_element};

use super::course::course;
use super::plan::outline;

/// The page.
pub(super) fn page(file: &GearFile, gear: &FlyingGear) -> String {
    let title = if file.title.is_empty() {
        "Flying gear"
    } else {
        &file.title
    };
    let body = format!(
        "<header>\n<h1>{}</h1>\n<p class=\"facts\">{}</p>\n</header>\n{}{HINT}",
        escaped(title),
        escaped(&outline(file, gear)),
        figure_element(&figure(file, gear)),
    );
    document(title, &body)
}

/// The gear as it is drawn.
pub(super) fn figure(file: &GearFile, gear: &FlyingGear) -> Figure {
    let caption = "The master passes the gear at the velocity of the file, and comes back where the slave is released on the \
                   way back. Limits are dashed; a limit far away is out of sight until you zoom out with the wheel over the \
                   numbers at the left. All four charts zoom together.";
    Figure {
        id: "gear".to_owned(),
        title: "The slave over the master".to_owned(),
        caption: caption.to_owned(),
        ..charts(file, gear).figure()
    }
}

fn charts(file: &GearFile, gear: &FlyingGear) -> Charts {
    let stretches = gear.ranges(file.master.velocity, file.cycle.0);
    let mut sampled = Sampled::default();
    for (master, slave) in course(file, gear, &stretches) {
        sampled.push(master, slave);
    }
    let unit =
        |quantity: usize| format!("{}{}", file.slave_unit, ["", "/s", "/s²", "/s³"][quantity]);
    // Limits bound both directions of the slave.
    let both = |name, limit: f64| {
        [limit, -limit]
            .map(|value| LevelLine {
                name,
                value,
                // The gear checks them all before it engages.
                binds: true,
            })
            .into()
    };
    let limits = &file.limits;
    Charts {
        along: ("master".to_owned(), file.master_unit.clone()),
        units: std::array::from_fn(unit),
        course: sampled,
        marks: Sampled::default(),
        labels: Vec::new(),
        lines: [
            Vec::new(),
            both("limit of velocity", limits.velocity()),
            // A master that turns round makes of an acceleration a deceleration.
            both(
                "limit of acceleration and deceleration",
                limits.acceleration().min(limits.deceleration()),
            ),
            both("limit of jerk", limits.jerk()),
        ],
    }
}
