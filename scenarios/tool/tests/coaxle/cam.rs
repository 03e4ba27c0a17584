//! `coaxle cam` as a user starts it.

use std::io::{BufRead, BufReader};
use std::process::Stdio;

use crate::inspect::Tool;
use crate::shared::{text, written};

const CAM: Tool = Tool {
    command: "cam",
    files: "cams",
};

fn shipped(name: &str) -> String {
    CAM.shipped(name)
}

#[test]
fn commands_answer_on_standard_output() {
    let (knife, back) = (shipped("rotary-knife.toml"), shipped("reading-back.toml"));
    for (arguments, expected) in [
        (vec!["check", &knife, &back], "lift 360 °"),
        (vec!["values", &knife, "--csv"], "master,position"),
        (vec!["characteristics", &knife], "velocity (°/s)"),
        (
            vec!["inverse", &back, "--slave", "80", "--start", "-180"],
            "below -180: -225\nabove -180: -135",
        ),
    ] {
        let output = CAM.run(&arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(text(&output.stdout).contains(expected));
        assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
    }
}

#[test]
fn a_plot_is_written_where_it_is_wanted() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("plot.html");
    let page_name = page.to_str().unwrap();
    let output = CAM.run(&["plot", &shipped("sines.toml"), "-o", page_name]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(text(&output.stdout), format!("plot: {page_name}\n"));
    let text_of_page = std::fs::read_to_string(&page).unwrap();
    assert!(text_of_page.contains("id=\"cam-figure\"") && text_of_page.ends_with("</html>\n"));
    assert!(text_of_page.len() < 200_000, "{}", text_of_page.len());

    let nowhere = CAM.run(&["plot", &shipped("sines.toml"), "-o", "/no/such/plot.html"]);
    assert_eq!(nowhere.status.code(), Some(1));
    let said = text(&nowhere.stderr);
    assert!(
        said.starts_with("error: cannot write /no/such/plot.html"),
        "{said}"
    );
}

#[test]
fn a_broken_file_fails_every_command_with_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    let points = |third: &str| {
        format!(
            "[[point]]\nlaw = 'polynom5'\nmaster = 0\nslave = 0\n\
             [[point]]\nlaw = 'polynom5'\nmaster = 180\nslave = 50\n[[point]]\n{third}"
        )
    };
    written(folder.path(), "words.csv", b"master;slave\n0;0\n90;fast\n");
    for (name, bytes, expected) in [
        (
            "empty",
            String::new().into_bytes(),
            "neither points nor a table",
        ),
        (
            "one-point",
            b"[[point]]\nmaster = 0\nslave = 0".to_vec(),
            "0x4a23: received 1 points, expected at least 2",
        ),
        (
            "no-master",
            points("slave = 0").into_bytes(),
            "point 3, master: missing, expected a number",
        ),
        (
            "law",
            points("master = 360\nslave = 0\nlaw = 'polynom6'").into_bytes(),
            "point 3, law: received \"polynom6\", expected",
        ),
        (
            "descending",
            points("master = 90\nslave = 0").into_bytes(),
            "0x4a06: point 3, master: received 90, expected above 180",
        ),
        (
            "nan",
            points("master = 360\nslave = nan").into_bytes(),
            "0x4a1c: point 3, slave: received NaN",
        ),
        (
            "huge",
            points("master = 1e308\nslave = -1.7e308\nvelocity = 1e300").into_bytes(),
            "huge.toml:10:10: point 3, master: received 1e308",
        ),
        (
            "syntax",
            b"[[point]]\nmaster = = 1\n".to_vec(),
            "is not valid TOML: ",
        ),
        (
            "binary",
            vec![0, 159, 146, 150, 255, 0, 7],
            "cannot be read",
        ),
        (
            "csv",
            b"table.csv = 'words.csv'".to_vec(),
            "words.csv: line 3, slave: received \"fast\", expected a number",
        ),
        (
            "no-csv",
            b"table.csv = 'none.csv'".to_vec(),
            "none.csv: cannot be read",
        ),
        (
            "folder-as-csv",
            b"table.csv = '.'".to_vec(),
            "cannot be read",
        ),
    ] {
        let file = written(folder.path(), &format!("{name}.toml"), &bytes);
        let file = file.to_str().unwrap();
        CAM.refused(&["check", file], expected);
        CAM.refused(&["values", file], expected);
        CAM.refused(&["characteristics", file], expected);
        CAM.refused(&["inverse", file, "--slave", "0", "--start", "0"], expected);
        CAM.refused(&["plot", file, "-o", "/no/such/plot.html"], expected);
    }
    CAM.refused(
        &["check", folder.path().to_str().unwrap()],
        "cannot be read",
    );
    CAM.refused(
        &["check", "no/such/cam.toml"],
        "no/such/cam.toml: cannot be read",
    );
}

#[test]
fn a_reader_may_leave_at_any_time() {
    let knife = shipped("rotary-knife.toml");
    for format in [&["--csv"][..], &[]] {
        let mut arguments = vec!["values", knife.as_str(), "--increment", "0.001"];
        arguments.extend(format);
        let mut child = CAM
            .started(&arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the tool starts");
        let mut reader = BufReader::new(child.stdout.take().expect("it is piped"));
        reader.read_line(&mut String::new()).expect("a line");
        drop(reader);
        let output = child.wait_with_output().expect("it ends");
        assert!(output.status.success(), "{:?}", output.status);
        assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
    }
}

#[test]
fn a_wrong_command_says_what_is_wrong() {
    let knife = shipped("rotary-knife.toml");
    for (arguments, expected) in [
        (vec!["check"], "FILES"),
        (
            vec!["values", &knife, "--from", "nan"],
            "expected a finite number",
        ),
        (vec!["inverse", &knife], "--slave"),
        (vec!["plot", &knife], "--output"),
    ] {
        let output = CAM.run(&arguments);
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(expected));
    }
}
