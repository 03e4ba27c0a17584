use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::json;

use super::*;

#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Machine {
    name: String,
    #[serde(default)]
    axes: Vec<Axis>,
    limits: Option<BTreeMap<String, f64>>,
    #[serde(default)]
    corner: Option<(i8, i8)>,
}

#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Axis {
    None,
    At(Place),
    Pair(u8, u8),
    Moving { speed: f64 },
}

#[derive(Debug, PartialEq, Deserialize)]
struct Place(u32);

/// A document as TOML has it: whole numbers have a sign.
fn document(json: &serde_json::Value) -> Document {
    use serde_json::Value;
    match json {
        Value::Null => Document::Null,
        Value::Bool(value) => Document::Boolean(*value),
        Value::Number(number) => match number.as_i64() {
            Some(number) => Document::Integer(number),
            None => Document::Float(number.as_f64().unwrap()),
        },
        Value::String(text) => Document::Text(text.clone()),
        Value::Array(list) => Document::List(list.iter().map(document).collect()),
        Value::Object(table) => {
            let fields = table.iter();
            let fields = fields.map(|(key, value)| (Document::Text(key.clone()), document(value)));
            Document::Table(fields.collect())
        }
    }
}

#[test]
fn a_type_is_read_from_a_document() {
    let json = json!({
        "name": "saw",
        "axes": ["none", { "none": {} }, { "at": 3 }, { "pair": [1, 2] }, { "moving": { "speed": 2 } }],
        "limits": { "x": -1.5, "y": 7 },
        "corner": [-1, 1],
    });
    let expected = Machine {
        name: "saw".to_owned(),
        axes: vec![
            Axis::None,
            Axis::None,
            Axis::At(Place(3)),
            Axis::Pair(1, 2),
            Axis::Moving { speed: 2.0 },
        ],
        limits: Some(BTreeMap::from([
            ("x".to_owned(), -1.5),
            ("y".to_owned(), 7.0),
        ])),
        corner: Some((-1, 1)),
    };
    assert_eq!(Machine::deserialize(&document(&json)).unwrap(), expected);
    // In JSON, other than in TOML, a variant that holds nothing holds null.
    let json = json
        .to_string()
        .replace(r#"{"none":{}}"#, r#"{"none":null}"#);
    assert_eq!(from_json::<Machine>(json.as_bytes()).unwrap(), expected);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(from_json_value::<Machine>(&json).unwrap(), expected);
}

/// Documents that are wrong, the field, and the reason.
fn wrong() -> Vec<(serde_json::Value, &'static str, &'static str)> {
    vec![
        (json!({}), ".", "missing field `name`"),
        (
            json!({ "name": 1 }),
            "name",
            "invalid type: integer `1`, expected a string",
        ),
        (
            json!({ "name": "a", "b": 1 }),
            "b",
            "unknown field `b`, expected one of",
        ),
        (
            json!({ "name": "a", "limits": { "x.y": "z" } }),
            "limits.x.y",
            "invalid type: string \"z\"",
        ),
        (
            json!({ "name": "a", "corner": [1, 300] }),
            "corner[1]",
            "invalid value: integer `300`",
        ),
        (
            json!({ "name": "a", "corner": [1, 2, 3] }),
            "corner",
            "invalid length 3",
        ),
        (
            json!({ "name": "a", "axes": 7 }),
            "axes",
            "invalid type: integer `7`",
        ),
        (
            json!({ "name": "a", "axes": ["none", "some"] }),
            "axes[1]",
            "unknown variant `some`",
        ),
        (
            json!({ "name": "a", "axes": [7] }),
            "axes[0]",
            "string only",
        ),
        (
            json!({ "name": "a", "axes": [{}] }),
            "axes[0]",
            "wanted exactly 1 element, found 0",
        ),
        (
            json!({ "name": "a", "axes": [{ "none": {}, "at": 1 }] }),
            "axes[0]",
            "more than 1 element",
        ),
        (
            json!({ "name": "a", "axes": [{ "none": 1 }] }),
            "axes[0].none",
            "expected table, found integer",
        ),
        (
            json!({ "name": "a", "axes": [{ "none": [1] }] }),
            "axes[0].none",
            "expected empty array",
        ),
        (
            json!({ "name": "a", "axes": [{ "at": -1 }] }),
            "axes[0].at",
            "invalid value: integer `-1`",
        ),
        (
            json!({ "name": "a", "axes": ["at"] }),
            "axes[0].at",
            "expected newtype variant",
        ),
        (
            json!({ "name": "a", "axes": [{ "pair": [1] }] }),
            "axes[0].pair",
            "expected tuple with length 2",
        ),
        (
            json!({ "name": "a", "axes": [{ "pair": [1, true] }] }),
            "axes[0].pair[1]",
            "boolean `true`",
        ),
        (
            json!({ "name": "a", "axes": [{ "moving": {} }] }),
            "axes[0].moving",
            "missing field `speed`",
        ),
        (
            json!({ "name": "a", "axes": [{ "moving": { "speed": [] } }] }),
            "axes[0].moving.speed",
            "invalid type: sequence, expected f64",
        ),
    ]
}

#[test]
fn an_error_has_the_field_and_the_reason() {
    for (json, field, reason) in wrong() {
        let misread = Machine::deserialize(&document(&json)).unwrap_err();
        assert_eq!(misread.field(), field, "{json}: {misread}");
        assert!(misread.reason().contains(reason), "{json}: {misread}");
    }
}

#[test]
fn json_that_is_wrong_has_the_same_field_and_the_words_of_its_library() {
    for (json, field, _) in wrong() {
        let text = json.to_string();
        let misread = from_json::<Machine>(text.as_bytes()).unwrap_err();
        let library = serde_json::from_str::<Machine>(&text).unwrap_err();
        assert_eq!(misread.field(), field, "{json}: {misread}");
        assert_eq!(misread.reason(), library.to_string());
        let misread = from_json_value::<Machine>(&json).unwrap_err();
        let library = serde_json::from_value::<Machine>(json).unwrap_err();
        assert_eq!(misread.field(), field, "{misread}");
        assert_eq!(misread.reason(), library.to_string());
    }
}

fn misread<T: DeserializeOwned + std::fmt::Debug>(text: &str) -> String {
    from_json::<T>(text.as_bytes()).unwrap_err().to_string()
}

#[test]
fn text_that_is_no_json_is_wrong_where_it_breaks_off() {
    for (text, expected) in [
        ("", "EOF while parsing a value at line 1 column 0"),
        (
            r#"{ "name": x }"#,
            "name: expected value at line 1 column 11",
        ),
        (
            r#"{ "name": "a", "axes": ["none", "no"#,
            "axes[1]: EOF while parsing a string at line 1 column 35",
        ),
        (
            r#"{ "name": "a" } {}"#,
            "trailing characters at line 1 column 17",
        ),
        // Of the table as a whole.
        (
            r#"{ "name": "a", "name": "b" }"#,
            "duplicate field `name` at line 1 column 21",
        ),
    ] {
        assert_eq!(misread::<Machine>(text), expected, "{text}");
    }
}
