use super::*;
use crate::run::figure::{Across, Curve, Data, Look, Panel};

fn figure() -> Figure {
    let sine = |n: i32| (f64::from(n), 100.0 * (0.1 * f64::from(n)).sin());
    let curve = |name: &str, look| Curve {
        look,
        ..Curve::new(name, "#d9541e", Data::Points((0..100).map(sine).collect()))
    };
    let panel = |quantity| Panel {
        title: "<b> – none".to_owned(),
        quantity,
        unit: "µm".to_owned(),
        marks: vec![30.0],
        curves: vec![curve("a & b", Look::Solid), curve("steps", Look::Steps)],
        ..Panel::default()
    };
    Figure {
        id: "x",
        title: "A figure",
        caption: "",
        across: Across::Run,
        panels: vec![panel("length"), panel("width")],
        is_on_one_scale: true,
    }
}

#[test]
fn a_pdf_is_one_page_of_a_column_with_text_and_paths() {
    let [_, pdf] = files_of(&figure(), COLUMN_MM);
    let text = String::from_utf8_lossy(&pdf);
    assert!(text.starts_with("%PDF-1.") && text.trim_end().ends_with("%%EOF"));
    assert_eq!(text.matches("/Type /Page\n").count(), 1, "{text}");
    assert!(text.contains("/Count 1"));
    // 85 mm.
    assert!(text.contains("/MediaBox [0 0 240.9"), "{text}");
    assert!(text.contains("(a & b) Tj") && text.contains("(time (s)) Tj"));
    let strokes = text.lines().filter(|line| *line == "S").count();
    assert!(strokes > 10, "{strokes} strokes");
    // What a reader finds the objects by is right.
    let from = text.rfind("startxref").unwrap();
    let offset: usize = text[from..].lines().nth(1).unwrap().parse().unwrap();
    assert!(pdf[offset..].starts_with(b"xref"));
}

#[test]
fn an_svg_is_whole_and_as_wide_as_a_column() {
    let [svg, _] = files_of(&figure(), COLUMN_MM);
    let text = String::from_utf8(svg).unwrap();
    assert!(text.starts_with("<svg ") && text.ends_with("</svg>\n"));
    assert!(text.contains("width=\"85.00mm\""));
    assert!(text.contains("&lt;b&gt; – none") && text.contains("a &amp; b"));
    // Each element is closed, and no text is markup.
    for line in text.lines().skip(1) {
        let is_closed =
            line.ends_with("/>") || line.ends_with("</text>") || line.contains("</title>");
        assert!(is_closed || line == "</svg>", "{line}");
    }
    assert!(!text.contains("NaN") && !text.contains("inf"));
}

#[test]
fn figures_of_a_run_are_files() {
    let folder = tempfile::tempdir().unwrap();
    let (summary, curves) = crate::run::tests::a_run();
    let path = folder.path().join("figures");
    write(&path, &summary, &curves, COLUMN_MM).unwrap();
    let names = std::fs::read_dir(&path).unwrap();
    let mut names: Vec<_> = names
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(
        names,
        ["state.pdf", "state.svg", "velocity.pdf", "velocity.svg"]
    );
}
