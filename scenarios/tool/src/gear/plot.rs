//! `coaxle gear plot`: the course of a flying gear as a page for a browser.

use coaxle_gear::FlyingGear;
use coaxle_node::gear_file::GearFile;
use coaxle_report::inspect::{Charts, Line, QUANTITIES, Sampled};
use coaxle_report::page::{Drawing, document, escaped, figure_element};

use super::course::course;
use super::plan::outline;

/// The page.
///
/// # Errors
/// The plotting library is not the expected one.
pub(super) fn page(file: &GearFile, gear: &FlyingGear) -> anyhow::Result<String> {
    let title = if file.title.is_empty() {
        "Flying gear"
    } else {
        &file.title
    };
    let drawing = Drawing {
        id: "gear",
        title: "The slave over the master",
        caption: "The master passes the gear at the velocity of the file, and comes back where the slave is released on the \
                  way back. Limits are dashed; a limit far away is out of sight until you zoom out. Drag to zoom in, \
                  double-click to zoom out; all four charts zoom together.",
        height: 1000,
        figure: charts(file, gear).figure(),
    };
    let body = format!(
        "<header>\n<h1>{}</h1>\n<p class=\"facts\">{}</p>\n</header>\n{}",
        escaped(title),
        escaped(&outline(file, gear)),
        figure_element(&drawing),
    );
    document(title, &body)
}

fn charts(file: &GearFile, gear: &FlyingGear) -> Charts {
    let stretches = gear.ranges(file.master.velocity, file.cycle.0);
    let mut sampled = Sampled::default();
    for (master, slave) in course(file, gear, &stretches) {
        sampled.push(master, slave);
    }
    let heading = |quantity: usize| {
        let per_time = ["", "/s", "/s²", "/s³"][quantity];
        format!("{} ({}{per_time})", QUANTITIES[quantity], file.slave_unit)
    };
    let both = |name, limit: f64| {
        [limit, -limit]
            .map(|value| Line {
                name,
                value,
                binds: true,
            })
            .into()
    };
    let limits = &file.limits;
    Charts {
        along: format!("master ({})", file.master_unit),
        headings: std::array::from_fn(heading),
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
