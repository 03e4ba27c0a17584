//! The nodes and links as a graph in the language of Graphviz.

use std::fmt::Write as _;

use crate::analysis::{LinkSummary, PlantAnalysis};
use crate::presentation::ShownAs;

/// Writes a graph: `dot -Tsvg`.
#[must_use]
pub fn dot(plant: &PlantAnalysis) -> String {
    let mut text = String::from(
        "digraph plant {\n  rankdir = LR\n  node [shape = box, style = \"rounded,filled\", fillcolor = white, \
         fontname = Helvetica]\n  edge [fontname = Helvetica, fontsize = 10]\n",
    );
    for (n, node) in plant.nodes.iter().enumerate() {
        let title = format!("{} ({})", node.node, node.role.name());
        let _ = writeln!(
            text,
            "  subgraph cluster_{n} {{\n    label = {}",
            quoted(&title)
        );
        for (k, axis) in node.axes.iter().enumerate() {
            let unit = axis
                .unit
                .as_ref()
                .map_or(String::new(), |unit| format!(" [{unit}]"));
            let label = format!("{}{unit}\n{}", axis.axis, axis.kind);
            let _ = writeln!(text, "    a{n}_{k} [label = {}]", quoted(&label));
        }
        text += "  }\n";
        for (k, axis) in node.axes.iter().enumerate() {
            for master in &axis.masters {
                let place = node.axes.iter().position(|other| other.axis == *master);
                if let Some(place) = place {
                    let _ = writeln!(text, "  a{n}_{place} -> a{n}_{k}");
                }
            }
        }
    }
    for link in &plant.links {
        let ((n, k), (m, l)) = (link.from, link.to);
        let _ = writeln!(
            text,
            "  a{n}_{k} -> a{m}_{l} [label = {}, style = {}]",
            quoted(&label(link)),
            style(link.stage.shown)
        );
    }
    text + "}\n"
}

/// Delay and lag of a link.
#[must_use]
pub fn label(link: &LinkSummary) -> String {
    let delay = match link.stage.delay_ms {
        Some(delay) => format!("{} ms", short(delay)),
        None => "unknown".to_owned(),
    };
    match link.stage.lag_ms {
        Some(lag) if lag > 0.0 => format!("{delay}, lag {} ms", short(lag)),
        _ => delay,
    }
}

/// Milliseconds with as many digits as anybody reads.
#[must_use]
pub fn short(millis: f64) -> String {
    let decimals = match millis.abs() {
        size if size >= 100.0 => 0,
        size if size >= 10.0 => 1,
        size if size >= 0.1 => 2,
        _ => 3,
    };
    let text = format!("{millis:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn style(shown: ShownAs) -> &'static str {
    match shown {
        ShownAs::Interpolated | ShownAs::Local => "solid",
        ShownAs::Now | ShownAs::AsReceived | ShownAs::Unknown => "dashed",
        ShownAs::Extrapolated => "bold, color = \"#c2362b\"",
    }
}

fn quoted(text: &str) -> String {
    let text = text.replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{}\"", text.replace('\n', "\\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn milliseconds_are_short() {
        for (millis, expected) in [
            (0.0, "0"),
            (0.0123, "0.012"),
            (0.5, "0.5"),
            (23.04, "23"),
            (23.45, "23.4"),
            (200.0, "200"),
        ] {
            assert_eq!(short(millis), expected, "{millis}");
        }
    }

    #[test]
    fn names_of_axes_cannot_break_the_graph() {
        assert_eq!(quoted("a \"b\"\\\nc"), "\"a \\\"b\\\"\\\\\\nc\"");
    }
}
