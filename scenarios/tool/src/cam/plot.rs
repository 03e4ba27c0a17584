//! `coaxle cam plot`: the course of a plate as a page for a browser.

use coaxle_files::cam::{CamFile, Shape};
use coaxle_plate::{MotionPoint, Plate, PointType};
use coaxle_report::figure::Figure;
use coaxle_report::inspect::{Charts, Sampled, name};
use coaxle_report::page::{HINT, document, escaped, figure_element};

use super::text::{description, unit};

/// The page.
pub(super) fn page(cam: &CamFile, plate: &Plate) -> String {
    let title = if cam.title.is_empty() {
        "Cam plate"
    } else {
        &cam.title
    };
    let body = format!(
        "<header>\n<h1>{}</h1>\n<p class=\"facts\">{}</p>\n</header>\n{}{HINT}",
        escaped(title),
        escaped(&description(cam, plate)),
        figure_element(&figure(cam, plate)),
    );
    document(title, &body)
}

/// The plate as it is drawn.
pub(super) fn figure(cam: &CamFile, plate: &Plate) -> Figure {
    Figure {
        id: "cam".to_owned(),
        title: "Position and its derivatives over the master".to_owned(),
        caption: "Rest on a point to see its law. All four charts zoom together.".to_owned(),
        ..charts(cam, plate).figure()
    }
}

fn charts(cam: &CamFile, plate: &Plate) -> Charts {
    let marks = CourseMark::some(cam, plate);
    Charts {
        along: ("master".to_owned(), cam.master_unit.clone()),
        units: std::array::from_fn(|quantity| unit(cam, quantity)),
        course: course(cam, plate),
        marks: points(plate, &marks),
        labels: marks.into_iter().map(|mark| mark.label).collect(),
        lines: Default::default(),
    }
}

/// Greatest number of places marked: a screen cannot show more of the many rows of a table apart.
const MOST_MARKS: usize = 400;
/// Places computed in all, as far as the rows leave a choice.
const SAMPLES: usize = 3_000;

/// A place where the course may change abruptly.
struct CourseMark {
    master: f64,
    label: String,
}

impl CourseMark {
    /// Returns all of them, or as many as there is room for.
    fn some(cam: &CamFile, plate: &Plate) -> Vec<Self> {
        let all = Self::all(cam);
        // At least 1 for a plate with any row.
        let every = all.len().div_ceil(MOST_MARKS);
        let (_, end) = plate.master_range();
        all.into_iter()
            .enumerate()
            // The end is kept in any case, as the drawing ends there.
            .filter(|(n, mark)| n % every == 0 || mark.master == end)
            .map(|(_, mark)| mark)
            .collect()
    }

    fn all(cam: &CamFile) -> Vec<Self> {
        match &cam.shape {
            Shape::Points(points) => points_in_use(points).map(Self::of_point).collect(),
            Shape::Table(table) => {
                let rows = table.rows.iter().enumerate();
                rows.map(|(row, (master, _))| Self {
                    master: *master,
                    label: format!("row {row}"),
                })
                .collect()
            }
        }
    }

    fn of_point(point: &MotionPoint) -> Self {
        Self {
            master: point.master,
            label: format!(
                "point {}, {}, {}",
                point.index,
                name(&point.point_type),
                name(&point.function)
            ),
        }
    }
}

/// The points the course leads through.
fn points_in_use(points: &[MotionPoint]) -> impl Iterator<Item = &MotionPoint> {
    let next = |&row: &usize| {
        // A step of 0 would never end.
        let further = usize::try_from(points[row].relative_next).ok()?;
        Some(row + further).filter(|next| further > 0 && *next < points.len())
    };
    std::iter::successors(Some(0), next)
        .map(|row| &points[row])
        .filter(|point| point.point_type != PointType::Ignore)
}

/// The whole course. At each row it has the values of both sides, so that jumps are upright and no row of a long table is
/// passed over.
fn course(cam: &CamFile, plate: &Plate) -> Sampled {
    let mut course = Sampled::default();
    let rows = CourseMark::all(cam);
    let stretches = rows.len().saturating_sub(1).max(1);
    // Two at least: each row of a long table has its own place.
    let count = (SAMPLES / stretches).clamp(2, 500);
    for pair in rows.windows(2) {
        let (start, end) = (pair[0].master, pair[1].master);
        for n in 0..count {
            let master = start + (end - start) * (n as f64 / count as f64);
            course.push(master, plate.at(master));
        }
        // The value just before: at the row itself a plate is in the next segment already.
        course.push(end, plate.at(end.next_down()));
    }
    course
}

/// The marks, each with the values after it; the last one with those before.
fn points(plate: &Plate, marks: &[CourseMark]) -> Sampled {
    let (_, end) = plate.master_range();
    let mut points = Sampled::default();
    for mark in marks {
        // A cyclic plate at its end is at its start again.
        let motion = plate.at(mark.master.min(end.next_down()));
        points.push(mark.master, motion);
    }
    points
}
