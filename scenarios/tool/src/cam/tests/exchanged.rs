//! Points and positions exported for a PLC or a spreadsheet, and imported again.

use std::path::Path;

use super::super::{export, format, import, load};
use super::{answer, output, shipped};

/// Exports each shipped plate and imports it again, in both formats: equal to the last bit.
#[test]
fn points_come_back_from_both_formats() {
    let scratch = tempfile::tempdir().unwrap();
    for (n, file) in shipped().into_iter().enumerate() {
        let (cam, plate) = load(&file).unwrap();
        for ending in ["csv", "st"] {
            let path = |name: &str| {
                scratch
                    .path()
                    .join(format!("{n}.{name}"))
                    .display()
                    .to_string()
            };
            let (table, again) = (path(ending), path(&format!("{ending}.toml")));
            let name = file.display().to_string();
            output(&["export", &name, "-o", &table]).unwrap();
            let course = coaxle_report::inspect::name(&cam.course);
            let mut words = vec!["import", &table, "-o", &again, "--course", &course];
            let interpolation = coaxle_report::inspect::name(&plate.interpolation());
            words.extend(["--interpolation", &interpolation]);
            if plate.table_type() == coaxle_plate::TableType::Equidistant {
                words.push("--equidistant");
            }
            output(&words).unwrap();
            let (read, _) = load(Path::new(&again)).unwrap();
            assert_eq!(read.source(), cam.source(), "{name} by {ending}");
        }
    }
}

#[test]
fn positions_of_any_plate_are_exported_at_equal_steps() {
    let csv = answer("export", "lift.toml", "--increment 100").unwrap();
    let masters: Vec<_> = csv
        .lines()
        .map(|line| line.split(',').next().unwrap())
        .collect();
    assert_eq!(masters, ["master", "0", "100", "200", "300", "360"]);
    assert!(csv.ends_with("360,90\n"), "{csv}");
    let array = answer(
        "export",
        "lift.toml",
        "--increment 180 --format plc --array Lift",
    )
    .unwrap();
    assert!(
        array.contains("Lift : ARRAY[0..2, 0..1] OF LREAL := [\n        0.0, 0.0,\n"),
        "{array}"
    );
    let points = answer("export", "rotary-knife.toml", "--format plc").unwrap();
    let first = "(PointIndex := 1, FunctionType := MOTIONFUNCTYPE_POLYNOM1, PointType := MOTIONPOINTTYPE_VELOCITY, \
        RelIndexNextPoint := 1, MasterPos := 0.0, SlavePos := 0.0, SlaveVelo := 1.25, SlaveAcc := 0.0, SlaveJerk := 0.0)";
    assert!(
        points.contains(first) && points.contains("ARRAY[1..4] OF MC_MotionFunctionPoint"),
        "{points}"
    );
    let refused = answer("export", "lift.toml", "--increment -1").unwrap_err();
    assert!(refused.contains("increment: received -1"), "{refused}");
    let refused = answer("export", "lift.toml", "--array 1a").unwrap_err();
    assert!(
        refused.contains("expected the name of a variable"),
        "{refused}"
    );
}

#[test]
fn an_import_takes_the_place_of_nothing_and_says_where_the_table_is_wrong() {
    let scratch = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = scratch.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let good = write("good.csv", "0,0\n90,5\n");
    let taken = write("taken.toml", "mine");
    let refused = output(&["import", &good, "-o", &taken]).unwrap_err();
    assert!(refused.contains("there already"), "{refused}");
    assert_eq!(std::fs::read_to_string(&taken).unwrap(), "mine");
    for (name, text, expected) in [
        (
            "back.csv",
            "0,0\n-1,5\n",
            "back.csv: table.rows[1]: 0x4a06: row 1",
        ),
        (
            "law.csv",
            "law,master,slave\n,0,0\n5,1,1\n",
            "law.csv: point 1, law: received none",
        ),
        (
            "one.st",
            "A[1].MasterPos := 0; A[1].SlavePos := 0;",
            "one.st: 0x4a23: received 1 points",
        ),
        (
            "none.st",
            "x := 1;",
            "none.st: array: received no name, expected one of MC_MotionFunctionPoint or of pairs of LREAL with values: the file has no array",
        ),
        (
            "big.csv",
            "0,1e16\n1,1\n",
            "big.csv: table.rows[0], slave: received 1e16",
        ),
    ] {
        let table = write(name, text);
        let refused = output(&["import", &table]).unwrap_err();
        assert!(refused.contains(expected), "{refused}");
    }
    let (_, text) = output(&["import", &good, "--title", "a \"b\"", "--table-id", "7"]).unwrap();
    assert!(
        text.starts_with("title = 'a \"b\"'\ntable-id = 7\ncourse = \"linear\"\n"),
        "{text}"
    );
}

/// 60 000 points are more than a cam file holds: they are left beside it, and make the same plate.
#[test]
fn more_points_than_a_cam_file_holds_are_left_in_a_csv_file_beside_it() {
    let scratch = tempfile::tempdir().unwrap();
    let path = |name: &str| scratch.path().join(name).display().to_string();
    let point = |row: u32| {
        let slave = f64::from(row % 1_000) * 0.123_456_789;
        format!(
            "polynom5,{}.000001,{slave},0.000001,0.000002,0.000003\n",
            row * 1_000
        )
    };
    let head = "law,master,slave,velocity,acceleration,jerk\n".to_owned();
    let points = head
        + &(0..60_000)
            .map(point)
            .collect::<String>()
            .replace("polynom5", "polynom7-mm");
    std::fs::write(path("points.csv"), &points).unwrap();
    let told_to_output = output(&["import", &path("points.csv")]).unwrap_err();
    assert!(told_to_output.contains("with --output"), "{told_to_output}");

    output(&["import", &path("points.csv"), "-o", &path("big.toml")]).unwrap();
    let text = std::fs::read_to_string(path("big.toml")).unwrap();
    assert!(text.ends_with("[points]\ncsv = \"big.csv\"\n"), "{text}");
    let (_, plate) = load(&scratch.path().join("big.toml")).unwrap();
    assert_eq!(plate.rows(), 60_000);
    // A table that lies there under that name already is named, and not written again.
    output(&["import", &path("points.csv"), "-o", &path("points.toml")]).unwrap();
    let (_, same) = load(&scratch.path().join("points.toml")).unwrap();
    assert_eq!(same.source(), plate.source());
    assert_eq!(std::fs::read_to_string(path("points.csv")).unwrap(), points);
    let taken = output(&["import", &path("points.csv"), "-o", &path("big.toml")]).unwrap_err();
    assert!(
        taken.contains("big.csv: received a file that is there already"),
        "{taken}"
    );
}

#[test]
fn help_names_every_ending_of_a_plc() {
    use clap::Args;
    for command in [
        import::ImportArgs::augment_args(clap::Command::new("import")),
        export::CamExportArgs::augment_args(clap::Command::new("export")),
    ] {
        let mut arguments = command.get_arguments();
        let format = arguments.find(|argument| argument.get_id() == "format");
        let help = format.unwrap().get_help().unwrap().to_string();
        for ending in format::OF_PLC {
            assert!(help.contains(&format!(".{ending}")), "{ending}: {help}");
            let path = Path::new("cam").with_extension(ending.to_lowercase());
            assert_eq!(format::FormatArg::of(&path), format::FormatArg::Plc);
        }
    }
}
