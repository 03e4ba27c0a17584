//! A page that opens without a network: its frame, and its figures, which a script of its own draws.

mod encoding;
mod maps;
mod numbers;

use crate::figure::{Figure, Maps};
pub use crate::html::{escaped, script_json};
use crate::plotting::AXES_JS;

/// Styles of a page and of its figures.
const STYLES: [&str; 2] = [include_str!("page.css"), include_str!("figures.css")];

/// Scripts that draw the figures: axes that all pages have, the levels of a curve, a panel, maps, a picture to keep, and all
/// figures of the page.
const SCRIPTS: [&str; 6] = [
    AXES_JS,
    include_str!("levels.js"),
    include_str!("draw.js"),
    include_str!("maps.js"),
    include_str!("keep.js"),
    include_str!("figures.js"),
];

/// Instructions for the figures, for a page that has any.
pub const HINT: &str = "<p class=\"hint\">Wheel: zoom (over the numbers at the left: values). Drag: move; with Shift: zoom to \
     what is marked. Double click: all. Click: cursor A, with Shift: cursor B, Esc: none. Click a name to hide its \
     curve.</p>\n";

/// Returns a page of this title and body, in the browser's own colours. Equal figures give equal bytes.
#[must_use]
pub fn document(title: &str, body: &str) -> String {
    let title = escaped(title);
    let style = STYLES.concat();
    let scripts = SCRIPTS.map(|script| format!("<script>\n{script}</script>\n"));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n\
         <style>\n{style}</style>\n</head>\n<body>\n<main>\n{body}</main>\n{}</body>\n</html>\n",
        scripts.concat()
    )
}

/// Returns a figure with its words.
#[must_use]
pub fn figure_element(figure: &Figure) -> String {
    let Figure {
        id, title, caption, ..
    } = figure;
    element(id, title, caption, "plot", &encoding::figure(figure))
}

/// Returns maps with their words.
#[must_use]
pub fn maps_element(maps: &Maps) -> String {
    let Maps {
        id, title, caption, ..
    } = maps;
    element(id, title, caption, "maps", &maps::encoded(maps))
}

fn element(id: &str, title: &str, caption: &str, class: &str, json: &serde_json::Value) -> String {
    let [id, title, caption] = [id, title, caption].map(escaped);
    let json = script_json(json);
    format!(
        "<figure>\n<h3>{title}</h3>\n<figcaption>{caption}</figcaption>\n\
         <div class=\"{class}\" id=\"{id}\"></div>\n\
         <script type=\"application/json\" id=\"{id}-figure\">{json}</script>\n</figure>\n"
    )
}

#[cfg(test)]
pub(crate) use numbers::untold;

#[cfg(test)]
mod tests;
