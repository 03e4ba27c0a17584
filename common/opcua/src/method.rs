//! Commands as methods: the arguments of each, from the schema of commands, and the order that a call makes.

use coaxle_node::CommandOrder;
use coaxle_node::command::{Addressee, AnyCommand, CommandFamily, ListedCommand};
use coaxle_node::config::schema::{self, resolved, schema_of};
use coaxle_node::document::from_json;
use serde_json::{Map, Value};

/// Method of a slave or of a far node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CommandMethod {
    /// Key of the command, which is the name of the method.
    pub key: &'static str,
    /// Meaning in words.
    pub meaning: String,
    /// Arguments behind `dry-run`, which is the first of each method.
    pub arguments: Vec<MethodArgument>,
}

/// Argument of a method.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MethodArgument {
    /// Name: the path of the field in the command, `dynamics.jerk`.
    pub name: String,
    /// Kind of its values.
    pub kind: ArgumentKind,
    /// True if null stands for the default.
    pub is_optional: bool,
    /// Meaning in words.
    pub meaning: String,
    /// Path of the field in the command; empty for the command's only value.
    path: Vec<String>,
}

/// Kind of an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArgumentKind {
    /// Finite number.
    Number,
    /// Integer.
    Integer,
    /// True or false.
    Flag,
    /// Text.
    Text,
    /// Text with JSON: a list, or a value of several forms.
    Json,
}

/// Value of an argument as a client sent it.
#[derive(Clone, Debug, PartialEq)]
pub enum ArgumentValue {
    /// No value: the default.
    Null,
    /// Floating point number.
    Number(f64),
    /// Integer.
    Integer(i64),
    /// True or false.
    Flag(bool),
    /// Text.
    Text(String),
    /// Value of another type, which is named.
    Other(String),
}

/// Argument that makes no order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InvalidCall {
    /// Value of a wrong type, or none where one is required; with the place of the argument, from 0 at `dry-run`.
    Type(usize, String),
    /// Number that is not finite.
    Range(usize, String),
    /// Command that is none with these arguments, in words.
    Command(String),
}

/// Nesting up to which the fields of a command are arguments of their own.
// Deeper ones are of rare commands, and travel as JSON.
const DEEPEST: usize = 2;

impl CommandMethod {
    /// Methods of a slave.
    #[must_use]
    pub fn of_slaves() -> Vec<Self> {
        Self::all(|family| !family.is_about_far_node())
    }

    /// Methods of a far node.
    #[must_use]
    pub fn of_far_nodes() -> Vec<Self> {
        Self::all(CommandFamily::is_about_far_node)
    }

    fn all(is_listed: fn(CommandFamily) -> bool) -> Vec<Self> {
        let root = schema_of::<AnyCommand>().to_value();
        let listed = ListedCommand::all().filter(|command| is_listed(command.family));
        listed.map(|command| Self::new(&root, command)).collect()
    }

    fn new(root: &Value, command: ListedCommand) -> Self {
        let mut arguments = Vec::new();
        let mut meaning = String::new();
        if let Some((variant, fields)) = variant(root, root, command.key) {
            meaning = described(variant);
            let mut path = Vec::new();
            flatten(root, fields, true, &mut path, &mut arguments);
        }
        // A command without fields of its own: power, the filter mode.
        for argument in arguments.iter_mut().filter(|one| one.path.is_empty()) {
            argument.name = command.key.to_owned();
        }
        if meaning.is_empty() {
            meaning = command.name.to_owned();
        }
        Self {
            key: command.key,
            meaning,
            arguments,
        }
    }

    /// Makes the order of a call. The first value is `dry-run`.
    ///
    /// # Errors
    /// [`InvalidCall`] with the argument, the value received and the one expected.
    pub fn order(
        &self,
        addressee: Addressee,
        values: &[ArgumentValue],
    ) -> Result<CommandOrder, InvalidCall> {
        let is_dry_run = match values.first() {
            Some(ArgumentValue::Flag(is_dry_run)) => *is_dry_run,
            value => return Err(mistyped(0, "dry-run", value, "true or false")),
        };
        // A command with one value only has no object around it.
        let mut fields = Value::Object(Map::new());
        for (place, argument) in self.arguments.iter().enumerate() {
            let value = values.get(place + 1).unwrap_or(&ArgumentValue::Null);
            if let Some(json) = argument.json(place + 1, value)? {
                put(&mut fields, &argument.path, json);
            }
        }
        order_of(
            addressee,
            &serde_json::json!({ self.key: fields }),
            is_dry_run,
        )
    }
}

/// Makes the order of a command as JSON.
///
/// # Errors
/// [`InvalidCall::Command`] with the field, the value received and the one expected.
pub fn order_of_json(
    addressee: Addressee,
    json: &str,
    is_dry_run: bool,
) -> Result<CommandOrder, InvalidCall> {
    let command: Value = serde_json::from_str(json)
        .map_err(|error| InvalidCall::Command(format!("command: {error}")))?;
    order_of(addressee, &command, is_dry_run)
}

fn order_of(
    addressee: Addressee,
    command: &Value,
    is_dry_run: bool,
) -> Result<CommandOrder, InvalidCall> {
    let read: Result<AnyCommand, _> = from_json(command.to_string().as_bytes());
    let command = read.map_err(|error| InvalidCall::Command(error.to_string()))?;
    CommandOrder::new(addressee, command, is_dry_run)
        .map_err(|error| InvalidCall::Command(error.to_string()))
}

impl MethodArgument {
    /// The value in JSON; none for the default.
    fn json(&self, place: usize, value: &ArgumentValue) -> Result<Option<Value>, InvalidCall> {
        let mistyped = |expected: &str| Err(mistyped(place, &self.name, Some(value), expected));
        Ok(Some(match (self.kind, value) {
            (_, ArgumentValue::Null) if self.is_optional => return Ok(None),
            (ArgumentKind::Number, ArgumentValue::Number(number)) if !number.is_finite() => {
                let name = &self.name;
                let reason = format!("{name}: received {number}, expected a finite number");
                return Err(InvalidCall::Range(place, reason));
            }
            (ArgumentKind::Number, ArgumentValue::Number(number)) => (*number).into(),
            (ArgumentKind::Number | ArgumentKind::Integer, ArgumentValue::Integer(number)) => {
                (*number).into()
            }
            (ArgumentKind::Flag, ArgumentValue::Flag(flag)) => (*flag).into(),
            (ArgumentKind::Text, ArgumentValue::Text(text)) => text.as_str().into(),
            (ArgumentKind::Json, ArgumentValue::Text(text)) => {
                // A word alone is a text, as in a command line.
                serde_json::from_str(text).unwrap_or_else(|_| text.as_str().into())
            }
            (ArgumentKind::Json, ArgumentValue::Number(number)) if number.is_finite() => {
                (*number).into()
            }
            (ArgumentKind::Number, _) => return mistyped("a number"),
            (ArgumentKind::Integer, _) => return mistyped("an integer"),
            (ArgumentKind::Flag, _) => return mistyped("true or false"),
            (ArgumentKind::Text, _) => return mistyped("a text"),
            (ArgumentKind::Json, _) => return mistyped("a text with JSON"),
        }))
    }
}

fn mistyped(
    place: usize,
    name: &str,
    received: Option<&ArgumentValue>,
    expected: &str,
) -> InvalidCall {
    let received = match received {
        None | Some(ArgumentValue::Null) => "nothing".to_owned(),
        Some(ArgumentValue::Number(number)) => number.to_string(),
        Some(ArgumentValue::Integer(number)) => number.to_string(),
        Some(ArgumentValue::Flag(flag)) => flag.to_string(),
        Some(ArgumentValue::Text(text)) => format!("{text:?}"),
        Some(ArgumentValue::Other(kind)) => kind.clone(),
    };
    InvalidCall::Type(
        place,
        format!("{name}: received {received}, expected {expected}"),
    )
}

/// Writes a value at its path, with the objects on the way.
fn put(fields: &mut Value, path: &[String], json: Value) {
    let Some((first, rest)) = path.split_first() else {
        *fields = json;
        return;
    };
    if let Value::Object(fields) = fields {
        let field = fields.entry(first.clone());
        put(
            field.or_insert_with(|| Value::Object(Map::new())),
            rest,
            json,
        );
    }
}

/// The variant with a key among those of an enum of commands, and its fields.
fn variant<'s>(root: &'s Value, part: &'s Value, key: &str) -> Option<(&'s Value, &'s Value)> {
    let part = resolved(root, part);
    if let Some(fields) = part.get("properties").and_then(|fields| fields.get(key)) {
        return Some((part, fields));
    }
    alternatives(part).find_map(|one| variant(root, one, key))
}

fn alternatives(part: &Value) -> impl Iterator<Item = &Value> {
    schema::alternatives(part).into_iter().flatten()
}

fn flatten(
    root: &Value,
    schema: &Value,
    is_required: bool,
    path: &mut Vec<String>,
    out: &mut Vec<MethodArgument>,
) {
    let meaning = described(schema);
    let target = not_null(root, schema);
    let can_be_null = is_nullable(root, schema);
    let fields = target.get("properties").and_then(Value::as_object);
    if let Some(fields) =
        fields.filter(|_| path.len() < DEEPEST && alternatives(target).next().is_none())
    {
        let required: Vec<_> = (target.get("required").and_then(Value::as_array).into_iter())
            .flatten()
            .filter_map(Value::as_str)
            .collect();
        for (name, field) in fields {
            path.push(name.clone());
            let is_required = is_required && required.contains(&name.as_str());
            flatten(root, field, is_required, path, out);
            path.pop();
        }
        return;
    }
    let Some(kind) = kind_of(target) else {
        return;
    };
    out.push(MethodArgument {
        name: path.join("."),
        kind,
        is_optional: !is_required || can_be_null,
        meaning: match meaning.as_str() {
            "" => described(target),
            _ => meaning,
        },
        path: path.clone(),
    });
}

/// Kind of the values of a schema; none of an object without fields.
fn kind_of(schema: &Value) -> Option<ArgumentKind> {
    let types: Vec<_> = match schema.get("type") {
        Some(Value::String(one)) => vec![one.as_str()],
        Some(Value::Array(several)) => several.iter().filter_map(Value::as_str).collect(),
        _ => Vec::new(),
    };
    let types: Vec<_> = types.into_iter().filter(|name| *name != "null").collect();
    let is_choice = alternatives(schema).next().is_some();
    let is_word = |one: &Value| {
        one.get("type").is_some_and(|kind| kind == "string")
            || one.get("const").is_some_and(Value::is_string)
    };
    if is_choice && alternatives(schema).all(is_word) {
        return Some(ArgumentKind::Text);
    }
    Some(match types[..] {
        ["number"] if !is_choice => ArgumentKind::Number,
        ["integer"] if !is_choice => ArgumentKind::Integer,
        ["boolean"] if !is_choice => ArgumentKind::Flag,
        ["string"] if !is_choice => ArgumentKind::Text,
        ["object"] if !is_choice && has_no_field(schema) => return None,
        _ if !is_choice && types.is_empty() && schema.get("enum").is_some() => ArgumentKind::Text,
        _ => ArgumentKind::Json,
    })
}

fn has_no_field(schema: &Value) -> bool {
    let fields = schema.get("properties").and_then(Value::as_object);
    fields.is_none_or(Map::is_empty)
}

/// The schema of the values besides null.
fn not_null<'s>(root: &'s Value, schema: &'s Value) -> &'s Value {
    let schema = resolved(root, schema);
    let mut others = alternatives(schema).filter(|one| !is_null(one));
    match (others.next(), others.next()) {
        (Some(only), None) => not_null(root, only),
        _ => schema,
    }
}

fn is_nullable(root: &Value, schema: &Value) -> bool {
    let schema = resolved(root, schema);
    let types = schema.get("type").and_then(Value::as_array);
    types.is_some_and(|types| types.iter().any(|one| one == "null"))
        || alternatives(schema).any(is_null)
}

fn is_null(schema: &Value) -> bool {
    schema.get("type").is_some_and(|one| one == "null")
}

fn described(schema: &Value) -> String {
    let text = schema.get("description").and_then(Value::as_str);
    // Line breaks of the source are none of the sentence.
    text.unwrap_or_default()
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::command::SlaveName;

    fn method(key: &str) -> CommandMethod {
        let mut all = CommandMethod::of_slaves();
        all.extend(CommandMethod::of_far_nodes());
        all.into_iter().find(|method| method.key == key).unwrap()
    }

    fn carriage() -> Addressee {
        Addressee::Slave(SlaveName::new("carriage").unwrap())
    }

    fn order(key: &str, values: &[ArgumentValue]) -> Result<String, InvalidCall> {
        method(key)
            .order(carriage(), values)
            .map(|order| order.to_json())
    }

    #[test]
    fn every_command_has_a_method_whose_arguments_are_its_fields() {
        let all = CommandMethod::of_slaves().len() + CommandMethod::of_far_nodes().len();
        assert_eq!(all, ListedCommand::all().count());
        let names = |key: &str| -> Vec<_> {
            let arguments = method(key).arguments.into_iter();
            arguments
                .map(|one| (one.name, one.kind, one.is_optional))
                .collect()
        };
        assert_eq!(
            names("power"),
            [("power".to_owned(), ArgumentKind::Flag, false)]
        );
        assert_eq!(names("reset"), []);
        let moved: Vec<_> = (names("move-absolute").into_iter())
            .filter(|(_, kind, is_optional)| *kind == ArgumentKind::Number && *is_optional)
            .map(|(name, ..)| name)
            .collect();
        for name in [
            "velocity",
            "dynamics.acceleration",
            "dynamics.deceleration",
            "dynamics.jerk",
        ] {
            assert!(moved.iter().any(|known| known == name), "{name}: {moved:?}");
        }
        assert!(names("move-absolute").contains(&(
            "position".to_owned(),
            ArgumentKind::Number,
            false
        )));
        assert_eq!(names("filter-mode")[0].1, ArgumentKind::Text);
        for method in CommandMethod::of_slaves() {
            assert!(!method.meaning.is_empty(), "{}", method.key);
        }
    }

    #[test]
    fn a_call_makes_the_order_of_the_command_line() {
        use ArgumentValue::{Flag, Null, Number};
        let dry = order("power", &[Flag(true), Flag(true)]).unwrap();
        assert!(
            dry.contains(r#"{"power":true}"#) && dry.contains(r#""dry-run":true"#),
            "{dry}"
        );
        let moving = method("move-absolute");
        let values = moving.arguments.iter().map(|one| match one.name.as_str() {
            "position" => Number(100.0),
            "dynamics.jerk" => Number(5e3),
            _ => Null,
        });
        let values: Vec<_> = [Flag(false)].into_iter().chain(values).collect();
        let order = moving.order(carriage(), &values).unwrap();
        let expected = r#"{ "move-absolute": { "position": 100, "dynamics": { "jerk": 5e3 } } }"#;
        assert_eq!(order, order_of_json(carriage(), expected, false).unwrap());
    }

    #[test]
    fn what_makes_no_order_is_named() {
        use ArgumentValue::{Flag, Integer, Null, Number, Text};
        let range = InvalidCall::Range(
            1,
            "position: received NaN, expected a finite number".to_owned(),
        );
        assert_eq!(order("home", &[Flag(false), Number(f64::NAN)]), Err(range));
        for (key, values, place, expected) in [
            (
                "home",
                &[Flag(false), Null][..],
                1,
                "position: received nothing, expected a number",
            ),
            (
                "home",
                &[Flag(false), Text("x".to_owned())],
                1,
                "position: received \"x\", expected a number",
            ),
            (
                "reset",
                &[Integer(1)],
                0,
                "dry-run: received 1, expected true or false",
            ),
            (
                "power",
                &[Flag(true), Integer(1)],
                1,
                "power: received 1, expected true or false",
            ),
        ] {
            assert_eq!(
                order(key, values),
                Err(InvalidCall::Type(place, expected.to_owned()))
            );
        }
        let unknown = order_of_json(carriage(), r#"{ "dance": {} }"#, false).unwrap_err();
        assert!(matches!(unknown, InvalidCall::Command(text) if text.contains("dance")));
        let far = order_of_json(carriage(), r#"{ "disable": {} }"#, false).unwrap_err();
        assert!(matches!(far, InvalidCall::Command(text) if text.contains("for a slave")));
    }
}
