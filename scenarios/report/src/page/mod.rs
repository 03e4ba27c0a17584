//! A page with plots that opens without a network, drawn by a plotting library that it carries with it: of cams, saws and sweeps.

mod drawing;
mod html;

use anyhow::Context;
use plotly::Plot;

pub use drawing::{Drawing, axis_name, band, figure_element, layout, vertical};
pub use html::{escaped, script_json};

/// How a page looks.
pub const CSS: &str = include_str!("page.css");

/// A page that opens without a network, drawing its figures in the browser's own colours.
///
/// # Errors
/// The plotting library is not what it was.
pub fn document(title: &str, body: &str) -> anyhow::Result<String> {
    let js = include_str!("page.js");
    let scripts = format!("<script>\n{js}</script>\n");
    Ok(framed(title, body, &plotting_script()?, &scripts))
}

/// A page: what stands in its head besides the usual, its body, and its scripts.
pub fn framed(title: &str, body: &str, head: &str, scripts: &str) -> String {
    let title = escaped(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n\
         <style>\n{CSS}</style>\n{head}\n</head>\n<body>\n<main>\n{body}</main>\n{scripts}</body>\n</html>\n"
    )
}

/// The plotting library as a script element. The crate hands out a formula renderer behind it,
/// which no figure here needs.
fn plotting_script() -> anyhow::Result<String> {
    let mut scripts = Plot::offline_js_sources();
    let end = scripts
        .find(SCRIPT_END)
        .context("the plotting library is not a script element")?;
    scripts.truncate(end + SCRIPT_END.len());
    Ok(scripts)
}

const SCRIPT_END: &str = "</script>";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plotting_library_is_one_script() {
        let script = plotting_script().unwrap();
        assert_eq!(script.matches(SCRIPT_END).count(), 1);
        assert!(script.starts_with("<script") && script.ends_with(SCRIPT_END));
        assert!(script.contains("plotly.js v"));
    }
}
