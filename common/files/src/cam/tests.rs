use coaxle_curve::law::MotionLaw;
use coaxle_plate::{PointType, TableType};

use super::*;

/// A rise and a fall, with additions by the test before the points and in the second one.
fn rise_and_fall(before: &str, into_second: &str) -> String {
    // The last point has no law, since no section begins there.
    format!(
        "{before}\n\
         point = [\n\
         {{ master = 0, slave = 0, law = 'polynom5' }},\n\
         {{ master = 180, slave = 50, law = 'polynom5'{into_second} }},\n\
         {{ master = 360, slave = 0 }},\n]"
    )
}

fn parse(text: &str) -> Result<CamFile, CamFileError> {
    CamFile::parse(Path::new("cams/t.toml"), text)
}

fn plate(text: &str) -> Plate {
    parse(text).and_then(|cam| cam.plate()).expect("a plate")
}

fn refusal(text: &str) -> String {
    let refused = parse(text).and_then(|cam| cam.plate());
    refused.expect_err("no plate").to_string()
}

#[test]
fn points_make_a_motion_function() {
    let text = "title = 'x'\ntable-id = 7\nmaster-unit = '°'\ncourse = 'cyclic'";
    let cam = parse(&rise_and_fall(text, "")).unwrap();
    assert_eq!((cam.title.as_str(), cam.course), ("x", Course::Cyclic));
    assert_eq!(cam.table_id.map(TableId::get), Some(7));
    assert_eq!(
        (cam.master_unit.as_str(), cam.slave_unit.as_str()),
        ("°", "u")
    );
    let plate = cam.plate().unwrap();
    assert_eq!(plate.table_type(), TableType::MotionFunction);
    // Two periods after the point at 180.
    assert_eq!(plate.at(180.0 + 720.0).position, 50.0);
}

#[test]
fn what_a_point_leaves_out_is_filled_in() {
    let text = "[[point]]\nmaster = 0\nslave = 0\nlaw = 'polynom5-mm'\n\
                [[point]]\nmaster = 1\nslave = 1\nlaw = 'polynom5-mm'\nvelocity = 2\n\
                [[point]]\nmaster = 2\nslave = 1\nlaw = 'polynom5-mm'\nacceleration = -3\n\
                [[point]]\nmaster = 3\nslave = 1\nvelocity = 1\nacceleration = 1";
    let Shape::Points(points) = parse(text).unwrap().shape else {
        panic!("a motion function was written");
    };
    let types = points.iter().map(|point| point.point_type);
    // By the values given: nothing, a velocity, an acceleration, and both.
    assert!(types.eq([
        PointType::Rest,
        PointType::Velocity,
        PointType::Turn,
        PointType::Motion
    ]));
    assert!(points.iter().map(|point| point.index).eq(1..=4));
    assert!(points.iter().all(|point| point.relative_next == 1));
    assert_eq!(points[2].function, MotionLaw::Polynom5Mm);
}

#[test]
fn ignored_points_are_passed_over() {
    let text = "[[point]]\nmaster = 0\nslave = 0\nlaw = 'polynom1'\nrelative-next = 2\n\
                [[point]]\ntype = 'ignore'\nmaster = 99\nslave = 99\n\
                [[point]]\nmaster = 2\nslave = 2";
    // The straight line from 0 to 2 passes the ignored point, which lies far off it.
    assert_eq!(plate(text).at(1.0).position, 1.0);
}

#[test]
fn rows_make_a_table() {
    let rows = "rows = [[0, 0], [1, 1], [2, 0], [3, -1], [4, 0]]";
    for (settings, expected) in [
        ("", TableType::NonEquidistant),
        ("equidistant = true", TableType::Equidistant),
        ("interpolation = 'spline'", TableType::NonEquidistant),
        (
            "interpolation = 'sliding-spline'",
            TableType::NonEquidistant,
        ),
    ] {
        for course in ["linear", "cyclic"] {
            let plate = plate(&format!("course = '{course}'\n[table]\n{settings}\n{rows}"));
            assert_eq!(plate.table_type(), expected);
            // A row of the table, so that every interpolation passes it, but for rounding.
            assert!((plate.at(3.0).position + 1.0).abs() < 1e-15);
        }
    }
}

#[test]
fn points_may_be_in_a_csv_file_and_errors_name_its_lines() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let (cam, csv) = (folder.path().join("t.toml"), folder.path().join("p.csv"));
    let written = |text: &str, points: &str| {
        std::fs::write(&cam, text).expect("the folder can be written");
        std::fs::write(&csv, points).expect("the folder can be written");
        CamFile::load(&cam).and_then(|cam| cam.plate())
    };
    let named = "course = 'cyclic'\n[points]\ncsv = 'p.csv'\n";
    let load = |points: &str| written(named, points);

    // Columns in another order, a comment, and an empty law in the last line.
    let plate = load("law,master,slave\npolynom5,0,0\n# half\npolynom5,180,50\n,360,0\n");
    let same = parse(&rise_and_fall("course = 'cyclic'", "")).and_then(|cam| cam.plate());
    let (plate, same) = (plate.expect("a plate"), same.expect("a plate"));
    assert_eq!(plate.source(), same.source());

    let name = csv.display();
    for (points, expected) in [
        (
            "law,master,slave\npolynom5,0,0\n\npolynom5,-1,1\n,2,0\n",
            // Empty lines count: the second point is in line 4.
            "line 4: 0x4a06: ",
        ),
        (
            "law,master,slave\npolynom5,0,0\n,1,0\n,2,0\n",
            "line 3, law: received none",
        ),
        (
            "law,master,slave\npolynom5,0,fast\n",
            "line 2, slave: received \"fast\"",
        ),
        (
            "law,master,slave\npolynom5,0,1e300\n",
            "line 2, slave: received 1e300",
        ),
        ("law,master,slave\n", "0x4a23: received 0 points"),
        ("master,slave\n0,0\n1,1\n", "line 1: received no column law"),
        ("", "line 1: received no column law"),
    ] {
        let message = load(points).expect_err("refused").to_string();
        let expected = format!("{name}: {expected}");
        assert!(message.contains(&expected), "{message}\n{expected}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    let twice = format!("{named}[[point]]\nmaster = 0\nslave = 0\n");
    let message = written(&twice, "").expect_err("refused").to_string();
    assert!(
        message.contains("points: received points here and in a CSV file"),
        "{message}"
    );
    let both = format!("{named}[table]\nrows = []\n");
    let message = written(&both, "").expect_err("refused").to_string();
    assert!(
        message.contains("table: 0x4b35: received points and a table"),
        "{message}"
    );
}

#[test]
fn a_csv_file_lies_beside_the_cam_file_and_errors_name_its_lines() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let (cam, csv) = (folder.path().join("t.toml"), folder.path().join("t.csv"));
    std::fs::write(&cam, "[table]\ncsv = 't.csv'").expect("the folder can be written");
    let load = |rows: &str| {
        std::fs::write(&csv, rows).expect("the folder can be written");
        CamFile::load(&cam).and_then(|cam| cam.plate())
    };

    let good = load("master;slave\n0;0\n1;0,5\n").expect("a plate");
    let descending = load("master;slave\n0;0\n\n2;0,5\n1;1\n").expect_err("refused");
    let short = load("0;0\n").expect_err("refused");
    let letters = load("0;0\n1;x\n").expect_err("refused");
    std::fs::remove_file(&csv).expect("it was there");
    let missing = CamFile::load(&cam).expect_err("refused");

    // Half of the way between 0 and 0.5.
    assert_eq!(good.at(0.5).position, 0.25);
    let name = csv.display();
    assert_eq!(descending.code(), Some(0x4A06));
    let message = descending.to_string();
    assert!(
        // Head, a row, an empty line and a row before it.
        message.starts_with(&format!("{name}: line 5: 0x4a06: ")),
        "{message}"
    );
    assert!(short.to_string().starts_with(&format!("{name}: 0x4a02: ")));
    assert_eq!(letters.code(), None);
    assert!(
        letters
            .to_string()
            .starts_with(&format!("{name}: line 2, slave: "))
    );
    assert!(
        missing
            .to_string()
            .starts_with(&format!("{name}: cannot be read: "))
    );
}

#[test]
fn errors_name_the_point_or_row_and_the_field() {
    let missing = "[[point]]\nslave = 0";
    let no_law = "[[point]]\nmaster = 0\nslave = 0\n[[point]]\nmaster = 1\nslave = 0";
    let both = "point = [{ master = 0, slave = 0 }]\n[table]\nrows = [[0, 0]]";
    for (text, expected) in [
        ("", "point: 0x4b35: received neither points nor a table"),
        (both, "table: 0x4b35: received points and a table"),
        ("[table]", "table: received neither of rows and csv"),
        (
            "[table]\nrows = []\ncsv = 'x'",
            "table: received both of rows and csv",
        ),
        (missing, "point 1, master: missing"),
        (no_law, "point 1, law: received none, expected one"),
        (
            &rise_and_fall("", ", velo = 1"),
            // `velo` is a slip for `velocity`.
            "point 2, velo: unknown field `velo`",
        ),
        (
            &rise_and_fall("", ", type = 'stop'"),
            "point 2, type: received \"stop\", expected",
        ),
        (
            &rise_and_fall("", ", velocity = 'x'"),
            "point 2, velocity: received the text \"x\", expected a number",
        ),
        (
            &rise_and_fall("", ", index = 5"),
            "0x4a1f: row 1: received point index 5, expected 2",
        ),
        (
            &rise_and_fall("", ", velocity = nan"),
            "0x4a1c: point 2, velocity: received NaN",
        ),
        (
            &rise_and_fall("", ", velocity = 1"),
            "0x42da: point 2, velocity: received 1, expected 0 at the end of law \"polynom5\"",
        ),
        (
            &rise_and_fall("", ", type = 'turn', velocity = 1"),
            "0x42da: point 2, velocity: received 1, expected 0",
        ),
        (
            &rise_and_fall("", "").replace("180", "-180"),
            "0x4a06: point 2, master: received -180, expected above 0",
        ),
        (
            &rise_and_fall("table-id = 256", ""),
            "table-id: 0x4b32: received 256, expected 1 to 255",
        ),
        (
            &rise_and_fall("course = 'round'", ""),
            "course: received \"round\", expected `linear` or `cyclic`",
        ),
        (
            "[table]\nrows = [[0, 0], [1, 'x']]",
            "table.rows[1][1]: received the text \"x\"",
        ),
        (
            "[table]\nrows = [[0, 0], [0, 1]]",
            "table.rows[1]: 0x4a06: row 1, master: received 0, expected above 0",
        ),
        (
            "[table]\nrows = [[0, 0], [1, 1], [3, 0]]\nequidistant = true",
            // Half of the distance from 0 to 3.
            "table.rows[1]: 0x4a04: row 1, master: received 1, expected 1.5",
        ),
        ("[table]\nrows = [[0, 0]]", "table: 0x4a02: received 1 rows"),
        (
            "[table]\nrows = []",
            "table: 0x4b36: received 0 rows, expected at least 2",
        ),
        (
            "[table]\nrows = [[0, 0], [1, 1]]\ninterpolation = 'four-point'",
            "table: 0x4a08: four-point interpolation is no longer supported",
        ),
    ] {
        let message = refusal(text);
        let place = message.split_once(&format!(": {expected}"));
        assert!(
            place.is_some_and(|(file, _)| file.starts_with("cams/t.toml")),
            "{message}"
        );
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

#[test]
fn broken_toml_is_told_in_one_line_with_its_number() {
    let message = refusal("title = 'x'\n\ncourse = = 'linear'");
    assert!(
        // Column 10: the second equals sign.
        message.starts_with("cams/t.toml:3:10: is not valid TOML: "),
        "{message}"
    );
    assert_eq!(message.lines().count(), 1, "{message}");
    // Texts that the parser of TOML quotes over several lines.
    for text in ["[[point", "\u{1}", "'", "a = \"\n\n"] {
        assert_eq!(refusal(text).lines().count(), 1);
    }
}

#[test]
fn a_file_that_is_no_text_is_refused() {
    let no_file = CamFile::load(Path::new("no/such.toml")).unwrap_err();
    assert!(
        no_file
            .to_string()
            .starts_with("no/such.toml: cannot be read: ")
    );
    // A folder can be opened, but not read.
    let folder = CamFile::load(Path::new("/")).unwrap_err();
    assert!(folder.to_string().starts_with("/: cannot be read: "));
}
