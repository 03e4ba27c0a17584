//! A picture as SVG.

use std::fmt::Write as _;

use super::picture::{Anchor, Colour, MM, Picture, Point, Shape};
use crate::html::escaped;

/// Unit of the size of a picture.
#[derive(Clone, Copy, Debug)]
pub(super) enum SvgUnit {
    /// Millimetres, at its true size.
    Millimetres,
    /// Pixels, given their number per point.
    Pixels(f64),
}

pub(super) fn drawn(picture: &Picture, measure: SvgUnit) -> String {
    let Picture { width, height, .. } = picture;
    // The size is in the unit of the reader, all places in points: the view box scales one to the other.
    let [wide, high] = [width, height].map(|length| match measure {
        SvgUnit::Millimetres => format!("{:.2}mm", length / MM),
        SvgUnit::Pixels(each) => format!("{:.0}", length * each),
    });
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{wide}\" height=\"{high}\" \
         viewBox=\"0 0 {width:.2} {height:.2}\" font-family=\"Helvetica, Arial, sans-serif\">\n\
         <title>{}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
        escaped(&picture.title)
    );
    for shape in &picture.shapes {
        text += &element(shape);
    }
    text + "</svg>\n"
}

fn element(shape: &Shape) -> String {
    match shape {
        Shape::Line {
            points,
            colour,
            width,
            dashes,
        } => {
            let dashes: Vec<_> = dashes.iter().map(f64::to_string).collect();
            let dashes = match dashes.as_slice() {
                [] => String::new(),
                all => format!(" stroke-dasharray=\"{}\"", all.join(" ")),
            };
            format!(
                "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"{dashes} stroke-linejoin=\"round\" \
                 points=\"{}\"/>\n",
                hex(*colour),
                places(points)
            )
        }
        Shape::Area {
            points,
            colour,
            opacity,
        } => format!(
            "<polygon fill=\"{}\" fill-opacity=\"{opacity}\" points=\"{}\"/>\n",
            hex(*colour),
            places(points)
        ),
        Shape::Dot {
            at: (x, y),
            radius,
            colour,
        } => format!(
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" fill=\"{}\"/>\n",
            hex(*colour)
        ),
        Shape::Text {
            at: (x, y),
            text,
            size,
            anchor,
            colour,
            is_upward,
        } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let turned = match is_upward {
                true => format!(" transform=\"rotate(-90 {x:.2} {y:.2})\""),
                false => String::new(),
            };
            format!(
                "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{}\"{turned}>{}</text>\n",
                hex(*colour),
                escaped(text)
            )
        }
    }
}

fn places(points: &[Point]) -> String {
    // Two numbers with two decimals, a comma and a space take 12 to 14 characters.
    let mut text = String::with_capacity(12 * points.len());
    for (x, y) in points {
        let _ = write!(text, "{x:.2},{y:.2} ");
    }
    text
}

fn hex((red, green, blue): Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
