//! A picture as PDF, one page of its size. Text is in Helvetica, which every reader has, so that no font needs to be inside.

use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, Str, TextStr};

use super::picture::{Anchor, Colour, Picture, Point, Shape};

const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const FONT: Ref = Ref::new(4);
const BANDS: Ref = Ref::new(5);
const CONTENT: Ref = Ref::new(6);
const INFO: Ref = Ref::new(7);

const FONT_NAME: Name<'static> = Name(b"F");
const BANDS_NAME: Name<'static> = Name(b"B");

pub(super) fn drawn(picture: &Picture) -> Vec<u8> {
    let mut pdf = Pdf::new();
    pdf.catalog(CATALOG).pages(PAGES);
    pdf.document_info(INFO).title(TextStr(&picture.title));
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let mut page = pdf.page(PAGE);
    // The writer takes numbers of single precision: within 2e-5 points on a page of 240.
    let (width, height) = (picture.width as f32, picture.height as f32);
    page.parent(PAGES)
        .media_box(Rect::new(0.0, 0.0, width, height));
    page.contents(CONTENT);
    let mut resources = page.resources();
    resources.fonts().pair(FONT_NAME, FONT);
    resources.ext_g_states().pair(BANDS_NAME, BANDS);
    resources.finish();
    page.finish();
    let mut font = pdf.type1_font(FONT);
    font.base_font(Name(b"Helvetica"));
    font.encoding_predefined(Name(b"WinAnsiEncoding"));
    font.finish();
    pdf.ext_graphics(BANDS)
        .non_stroking_alpha(opacity_of(picture));
    pdf.stream(CONTENT, &content(picture));
    pdf.finish()
}

/// Returns the opacity of all translucent shapes: a figure has bands of one kind.
fn opacity_of(picture: &Picture) -> f32 {
    let mut shapes = picture.shapes.iter();
    let opacity = shapes.find_map(|shape| match shape {
        Shape::Area { opacity, .. } if *opacity < 1.0 => Some(*opacity),
        _ => None,
    });
    opacity.unwrap_or(1.0) as f32
}

fn content(picture: &Picture) -> Vec<u8> {
    let mut content = Content::new();
    content.set_line_join(pdf_writer::types::LineJoinStyle::RoundJoin);
    // A page has its origin at the bottom.
    let place = |(x, y): Point| (x as f32, (picture.height - y) as f32);
    for shape in &picture.shapes {
        draw(&mut content, shape, place);
    }
    content.finish().to_vec()
}

fn draw(content: &mut Content, shape: &Shape, place: impl Fn(Point) -> (f32, f32)) {
    match shape {
        Shape::Line {
            points,
            colour,
            width,
            dashes,
        } => {
            let [red, green, blue] = shares(*colour);
            content.set_stroke_rgb(red, green, blue);
            content.set_line_width(*width as f32);
            // Set for solid lines, too: the pattern of the line before stays otherwise.
            content.set_dash_pattern(dashes.iter().map(|length| *length as f32), 0.0);
            trace(content, points, place);
            content.stroke();
        }
        Shape::Area {
            points,
            colour,
            opacity,
        } => {
            let [red, green, blue] = shares(*colour);
            // Opacity stays set until the state is restored, and dots behind a band would be translucent.
            content.save_state();
            if *opacity < 1.0 {
                content.set_parameters(BANDS_NAME);
            }
            content.set_fill_rgb(red, green, blue);
            trace(content, points, place);
            content.close_path();
            content.fill_nonzero();
            content.restore_state();
        }
        Shape::Dot { at, radius, colour } => {
            let [red, green, blue] = shares(*colour);
            content.set_fill_rgb(red, green, blue);
            dot(content, place(*at), *radius as f32);
            content.fill_nonzero();
        }
        Shape::Text {
            at,
            text,
            size,
            anchor,
            colour,
            is_upward,
        } => {
            let [red, green, blue] = shares(*colour);
            content.set_fill_rgb(red, green, blue);
            // PDF has no anchors: a text is moved back by its own measured length.
            let text = in_win_ansi(text);
            // The exact widths of the font: the estimate of the layout would misplace text that ends at its place.
            let length = length_of(&text) * size;
            let back = length
                * match anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => 0.5,
                    Anchor::End => 1.0,
                };
            let (along, matrix) = match is_upward {
                // A turn by 90° counterclockwise. Back is downwards for a text that reads upwards.
                true => ((at.0, at.1 + back), [0.0, 1.0, -1.0, 0.0]),
                false => ((at.0 - back, at.1), [1.0, 0.0, 0.0, 1.0]),
            };
            let ((x, y), [a, b, c, d]) = (place(along), matrix);
            content.begin_text();
            content.set_font(FONT_NAME, *size as f32);
            content.set_text_matrix([a, b, c, d, x, y]);
            content.show(Str(&text));
            content.end_text();
        }
    }
}

fn trace(content: &mut Content, points: &[Point], place: impl Fn(Point) -> (f32, f32)) {
    // A hundredth of a point is finer than any printer.
    let rounded = |value: f32| (100.0 * value).round() / 100.0;
    for (n, point) in points.iter().enumerate() {
        let (x, y) = place(*point);
        let (x, y) = (rounded(x), rounded(y));
        match n {
            0 => content.move_to(x, y),
            _ => content.line_to(x, y),
        };
    }
}

/// Draws a circle of four curves.
fn dot(content: &mut Content, (x, y): (f32, f32), radius: f32) {
    /// Distance of the handles of a quarter from its ends, of the radius: 4/3 tan(π/8), at most 0.03 % off a circle.
    const HANDLE: f32 = 0.552_285;
    let (r, h) = (radius, HANDLE * radius);
    content.move_to(x + r, y);
    content.cubic_to(x + r, y + h, x + h, y + r, x, y + r);
    content.cubic_to(x - h, y + r, x - r, y + h, x - r, y);
    content.cubic_to(x - r, y - h, x - h, y - r, x, y - r);
    content.cubic_to(x + h, y - r, x + r, y - h, x + r, y);
    content.close_path();
}

fn shares((red, green, blue): Colour) -> [f32; 3] {
    [red, green, blue].map(|part| f32::from(part) / 255.0)
}

/// Returns the characters that the font has, by their codes of Windows; others become question marks.
fn in_win_ansi(text: &str) -> Vec<u8> {
    let code = |c: char| match c {
        // Windows-1252 differs from Latin-1 between 0x80 and 0x9f only.
        '–' => 0x96,
        '…' => 0x85,
        '€' => 0x80,
        // The Greek letter looks like the micro sign, which has this code.
        'μ' => 0xb5,
        ' '..='~' | '\u{a0}'..='ÿ' => u8::try_from(u32::from(c)).unwrap_or(b'?'),
        _ => b'?',
    };
    text.chars().map(code).collect()
}

/// Returns the length of a text in Helvetica, of its size.
fn length_of(text: &[u8]) -> f64 {
    /// Widths from the space to the tilde, thousandths of the size.
    // From Adobe's metrics of the 14 standard fonts.
    const WIDTHS: [u16; 95] = [
        278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556,
        556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722,
        722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667, 611, 722,
        667, 944, 667, 667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278, 556,
        556, 222, 222, 500, 222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500,
        500, 334, 260, 334, 584,
    ];
    let width = |code: &u8| {
        let known = WIDTHS.get(usize::from(*code).wrapping_sub(32));
        // Digits and most letters are this wide.
        f64::from(known.copied().unwrap_or(556)) / 1_000.0
    };
    text.iter().map(width).sum()
}
