use coaxle_curve::law::MotionLaw;
use coaxle_plate::{Course, MotionPoint, PointType, WrittenPoint};
use proptest::prelude::*;

use super::*;

/// Up and down, with all fields set.
fn points() -> PointTable {
    let turn = MotionPoint {
        function: MotionLaw::SplineLinear,
        point_type: PointType::Motion,
        velocity: -0.125,
        acceleration: 1e-7,
        jerk: 3.0,
        ..MotionPoint::rest(2, 180.0, 50.5)
    };
    let points = [
        MotionPoint::rest(1, 0.0, 0.0),
        turn,
        MotionPoint::rest(3, 360.0, 0.0),
    ];
    PointTable::from(&PlateSource {
        course: Course::Cyclic,
        rows: SourceRows::Points(points.into()),
    })
}

fn csv(text: &str) -> Result<PointTable, String> {
    PointTable::from_csv("t.csv", text).map_err(|error| error.to_string())
}

fn plc(text: &str) -> Result<PointTable, String> {
    PointTable::from_structured_text("t.st", text, None).map_err(|error| error.to_string())
}

#[test]
fn what_is_written_is_read_again() {
    // 0.1 + 0.2 has 17 digits, and 1e300 an exponent.
    let positions = PointTable::Positions(vec![(0.0, 0.1 + 0.2), (1e-300, -1e15), (1e300, 5.0)]);
    for table in [points(), positions] {
        assert_eq!(csv(&table.to_csv()), Ok(table.clone()));
        // Exactly: the shortest text of a float is read as the same float.
        assert_eq!(plc(&table.to_structured_text("Cam")), Ok(table));
    }
}

/// IEC 61131-3, real literals: digits, a point, digits, and an exponent if any.
#[test]
fn every_literal_has_a_decimal_point() {
    let table = PointTable::Positions(vec![(1e16, 1e-7), (-1e16, -5e-324), (1.5e300, 0.25)]);
    let text = table.to_structured_text("A");
    for literal in ["1.0e16, 1.0e-7", "-1.0e16, -5.0e-324", "1.5e300, 0.25"] {
        assert!(text.contains(&format!("  {literal}")), "{text}");
    }
    assert_eq!(plc(&text), Ok(table));
}

#[test]
fn comments_nest() {
    // Edition 3 of IEC 61131-3: the first end is that of the inner comment. Signs of the other kind mean nothing.
    for text in [
        "(* (* inner *) A[0,0] := 9; *) A[0,0] := 1; A[0,1] := 2;",
        "(* a (* b (* c *) *) *) A[0,0] := 1; /* (* */ A[0,1] := 2; (* /* *)",
        "/* /* inner */ A[0,0] := 9; */ A[0,0] := 1; A[0,1] := 2; (* never (* closed *) A[0,0] := 9;",
        "(*) A[0,0] := 9; (**) *) A[0,0] := 1; A[0,1] := 2;",
    ] {
        assert_eq!(
            plc(text),
            Ok(PointTable::Positions(vec![(1.0, 2.0)])),
            "{text}"
        );
    }
    let message = plc("(* a\n(* b\n*)\n*)\nA[0,2] := 1;").unwrap_err();
    assert!(message.contains("line 5: "), "{message}");
}

proptest! {
    #[test]
    fn every_number_comes_back(rows in prop::collection::vec((-1e9..1e9, -1e9..1e9), 1..40)) {
        let table = PointTable::Positions(rows);
        prop_assert_eq!(csv(&table.to_csv()).unwrap(), table.clone());
        prop_assert_eq!(plc(&table.to_structured_text("Cam")).unwrap(), table);
    }
}

#[test]
fn tables_of_all_countries_are_understood() {
    let expected = |velocity| {
        let point = |master, slave, law, velocity| WrittenPoint {
            law,
            velocity,
            master,
            slave,
            ..field::default_point()
        };
        let first = point(0.0, 0.5, Some(MotionLaw::Polynom5Mm), 0.0);
        PointTable::Points(vec![first, point(90.0, -1.25, None, velocity)])
    };
    for text in [
        "master,slave,law,velocity\n0,0.5,polynom5-mm,\n90,-1.25,,2\n",
        // A mark of the byte order, a comment, names of the PLC, decimal commas.
        "\u{feff}# exported\n\nFunctionType;SlavePos;MasterPos;SlaveVelo\r\nMOTIONFUNCTYPE_POLYNOM5_MM;0,5;0;0\r\n;-1,25;90;2,0\r\n",
        // 15 is the code of the law. Separated by tabs, with a comma in a number.
        "law\tmaster\tslave\tvelocity\n15\t0\t0.5\t\n\t90\t-1,25\t2\n",
    ] {
        assert_eq!(csv(text), Ok(expected(2.0)), "{text}");
    }
    assert_eq!(
        csv("m;s\n0;1\n"),
        Ok(PointTable::Positions(vec![(0.0, 1.0)]))
    );
}

#[test]
fn what_is_no_point_is_named_by_its_line() {
    for (text, expected) in [
        (
            "law;slave\n",
            "t.csv: line 1: received no column master, expected one",
        ),
        (
            "law;master;slave;speed\n",
            "t.csv: line 1: received column \"speed\", expected some of index, law",
        ),
        (
            "law;master;slave;law\n",
            "t.csv: line 1: received column law twice",
        ),
        (
            "law;master;slave\npolynom6;0;0\n",
            "t.csv: line 2, law: received \"polynom6\", expected a law by its name",
        ),
        (
            "law;master;slave\n6;0;0\n",
            "t.csv: line 2, law: received 6, expected a law",
        ),
        (
            "law;master;slave\n5;;0\n",
            "t.csv: line 2, master: received \"\", expected a number",
        ),
        (
            "law;master;slave\n5;0\n",
            "t.csv: line 2: received 2 columns, expected 3",
        ),
        (
            "law;master;slave;index\n5;0;0;1.5\n",
            "t.csv: line 2, index: received 1.5, expected a whole number",
        ),
        (
            "m;s\n0;fast\n",
            "t.csv: line 2, slave: received \"fast\", expected a number",
        ),
    ] {
        let message = csv(text).unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn programs_are_read_as_they_are_written() {
    let expected = PointTable::Positions(vec![(0.0, 0.0), (90.0, -1500.0), (180.0, 0.0)]);
    for text in [
        "VAR\n Cam : ARRAY[0..2, 0..1] OF LREAL := [0, 0.0, 90, -1.5e3, 180.0, 0];\nEND_VAR",
        // A constant as a bound, lists of rows, a repeated number, a type, an underscore, and a base.
        "cam:array[1..N,1..2] of lreal:=[[2(0.0)],[LREAL#90.0,-1_500.0],[16#B4,0]]; // and more\nx : INT := 5;",
        // Assignments only: the loop has variables as indices and says nothing.
        "(* rows *) Cam[0,0] := 0; Cam[0,1] := 0; Cam[1,0] := 90; Cam[1,1] := -1500; Cam[2,0] := 180; CAM[2, 1] := 0;\n\
         FOR i := 0 TO 2 DO Other[i, 0] := i; END_FOR {pragma [0..1]} s := 'a [ b';",
        "Cam : ARRAY[0..2,0..1] OF LREAL;\nCam[0,0]:=0.0;Cam[0,1]:=0.0;Cam[1,0]:=90.0;Cam[1,1]:=-1500.0;Cam[2,0]:=180.0;Cam[2,1]:=0.0;",
    ] {
        assert_eq!(plc(text), Ok(expected.clone()), "{text}");
    }
    let PointTable::Points(points) = plc(
        "Cam : ARRAY[1..2] OF MC_MotionFunctionPoint := [(FunctionType := MC_MotionFunctionType.MOTIONFUNCTYPE_SPLINE_LINEAR, \
         MasterPos := 1, SlavePos := 2), (PointType := MOTIONPOINTTYPE_IGNORE, MasterPos := 2, SlavePos := -3)];\n\
         Cam[2].PointType := 2; Cam[3].MasterPos := 9; Cam[3].SlavePos := 8;",
    )
    .unwrap() else {
        panic!("points were written");
    };
    assert_eq!(points.len(), 3);
    assert_eq!(points[0].law, Some(MotionLaw::SplineLinear));
    // The assignment behind the declaration replaces IGNORE.
    assert_eq!(points[1].point_type, Some(PointType::Velocity));
    assert_eq!((points[2].master, points[2].slave), (9.0, 8.0));
}

#[test]
fn of_several_arrays_one_is_named() {
    let text = "A : ARRAY[0..1,0..1] OF LREAL := [0,0,1,1]; B : ARRAY[0..1,0..1] OF LREAL := [0,0,1,2]; E : ARRAY[0..9,0..1] OF LREAL;";
    let message = plc(text).unwrap_err();
    assert_eq!(
        message,
        "t.st: array: received no name, expected one of: A, B"
    );
    let read = |name| PointTable::from_structured_text("t.st", text, Some(name));
    assert_eq!(
        read("b").unwrap(),
        PointTable::Positions(vec![(0.0, 0.0), (1.0, 2.0)])
    );
    let message = read("E").unwrap_err().to_string();
    assert!(
        message.ends_with("received \"E\", expected one of: A, B"),
        "{message}"
    );
    let message = plc("x := 1;").unwrap_err();
    assert!(message.contains("the file has no array"), "{message}");
}

#[test]
fn what_is_no_array_is_named_by_its_line() {
    let points = "A : ARRAY[1..2] OF MC_MotionFunctionPoint := [\n";
    let rows = "A : ARRAY[0..1,0..1] OF LREAL := [\n";
    for (text, expected) in [
        (
            format!("{points}(Speed := 1)]"),
            "line 2: received field \"Speed\", expected some of PointIndex",
        ),
        (
            format!("{points}(MasterPos := fast)]"),
            "line 2: MasterPos: received \"fast\", expected a number",
        ),
        (
            format!("{points}(MasterPos := 1.2.3)]"),
            "expected a number",
        ),
        (
            format!("{points}(FunctionType := MOTIONFUNCTYPE_6)]"),
            "line 2: FunctionType: received \"MOTIONFUNCTYPE_6\"",
        ),
        (
            format!("{points}(MasterPos := 1)]"),
            "array of line 1: element 1: received no SlavePos",
        ),
        (
            format!("{points}(MasterPos 1)]"),
            "line 2: received 1, expected ':='",
        ),
        (format!("{points}3]"), "received 3, expected '('"),
        (
            format!("{rows}0, 1"),
            "received the end of the file, expected ',' or ']'",
        ),
        (
            format!("{rows}0, 1, 2]"),
            "array of line 1: element 1: received no slave position",
        ),
        (
            // Refused before the first element is made.
            format!("{rows}1000000000000(0.0)]"),
            "line 2: received 1000000000000 elements, expected at most",
        ),
        (
            format!("{rows}[[0, 1]]]"),
            "received no value, expected a number or a name",
        ),
        (
            "A[0,0] := 1; A[0,1] := 1; A[2,0] := 3;".to_owned(),
            "element 1: received no value",
        ),
        (
            "A[0,2] := 1;".to_owned(),
            "line 1: received column 2, expected 0 or 1",
        ),
    ] {
        let message = plc(&text).unwrap_err();
        assert!(
            message.starts_with("t.st: ") && message.contains(expected),
            "{text}: {message}"
        );
    }
}
