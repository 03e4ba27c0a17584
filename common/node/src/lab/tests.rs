use super::*;
use crate::config::schema::schema_of;
use crate::config::{ClockConfig, parse};
use serde::Deserialize;

/// A node with a clock and parts, each of which may have a fault.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Toy {
    name: String,
    #[serde(default)]
    #[schemars(extend("x-lab" = "lab.clock = {}"))]
    clock: ClockConfig,
    #[serde(default)]
    parts: Vec<Part>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Part {
    name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-lab" = "[[lab.parts]] with its name and fault = {}"))]
    fault: Option<f64>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct ToyLab {
    clock: ClockConfig,
    parts: Vec<PartLab>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct PartLab {
    name: String,
    fault: f64,
}

impl LabTable for ToyLab {
    fn read(document: &Document) -> Result<Self, Misread> {
        Self::deserialize(document)
    }

    fn check_files(&self, folder: &Path) -> Result<(), Wrong> {
        check_lab_clock(&self.clock, folder)
    }
}

impl WithLab for Toy {
    type Lab = ToyLab;

    fn read(document: &Document) -> Result<Self, Misread> {
        Self::deserialize(document)
    }

    fn set_lab(&mut self, lab: ToyLab) -> Result<(), Wrong> {
        self.clock = lab.clock;
        for (n, PartLab { name, fault }) in lab.parts.into_iter().enumerate() {
            let part = self.parts.iter_mut().find(|part| part.name == name);
            let part = part.ok_or_else(|| {
                Wrong::of(
                    format!("parts[{n}].name"),
                    format_args!("{name:?}"),
                    "a part",
                )
            })?;
            part.fault = Some(fault);
        }
        Ok(())
    }

    fn lab(&self) -> ToyLab {
        let parts = self.parts.iter().filter_map(|part| {
            let (name, fault) = (part.name.clone(), part.fault?);
            Some(PartLab { name, fault })
        });
        ToyLab {
            clock: self.clock.clone(),
            parts: parts.collect(),
        }
    }
}

const MACHINE: &str = "name = 'a'\n[[parts]]\nname = 'p'\n";
const LAB: &str = "[lab]\nclock.drift-ppm = 50\n[[lab.parts]]\nname = 'p'\nfault = 0.5\n";

fn read(text: &str) -> Result<NodeFile<Toy>, String> {
    NodeFile::parse("t.toml", text).map_err(|error| error.lines().join("\n"))
}

#[test]
fn a_machine_has_no_lab_and_an_experiment_says_what_is_in_it() {
    let machine = read(MACHINE).unwrap();
    assert_eq!(machine.lab, None);
    assert_eq!(machine.config.clock, ClockConfig::default());
    let experiment = read(&format!("{MACHINE}{LAB}")).unwrap();
    let fields = experiment.lab.unwrap();
    assert_eq!(
        fields.to_string(),
        "lab.clock.drift-ppm = 50, lab.parts \"p\".fault = 0.5"
    );
    assert!(fields.refusal().contains("--lab"), "{}", fields.refusal());
    assert_eq!(experiment.config.clock.drift_ppm.get(), 50.0);
    assert_eq!(experiment.config.parts[0].fault, Some(0.5));
    let refused = NodeFile::<Toy>::parse_machine("t.toml", &format!("{MACHINE}{LAB}")).unwrap_err();
    let refused = refused.to_string();
    assert!(
        refused.starts_with("t.toml:4:1: lab: received lab.clock.drift-ppm = 50, ")
            && refused.contains("--lab"),
        "{refused}"
    );
    assert!(NodeFile::<Toy>::parse_machine("t.toml", MACHINE).is_ok());
    let empty = read(&format!("{MACHINE}[lab]\n")).unwrap();
    let empty = empty.lab.map(|fields| fields.to_string());
    assert_eq!(empty.as_deref(), Some("nothing injected or simulated"));
}

#[test]
fn the_old_places_are_answered_with_what_to_write() {
    let refused =
        read("name = 'a'\nclock = { drift-ppm = 500.0 }\n[[parts]]\nname = 'p'\nfault = 0.5\n");
    assert_eq!(
        refused.unwrap_err(),
        "t.toml:2:9: clock: what is injected or simulated lives in [lab]: write lab.clock = { drift-ppm = 500.0 }, and start \
         the node with --lab\n\
         t.toml:5:9: parts \"p\".fault: what is injected or simulated lives in [lab]: write [[lab.parts]] with its name and \
         fault = 0.5, and start the node with --lab"
    );
    let many = format!(
        "name = 'a'\nclock.steps = [{}]",
        "{ at-s = 1 }, ".repeat(100)
    );
    let refused = read(&many).unwrap_err();
    assert!(refused.contains(" …, and start"), "{refused}");
}

#[test]
fn mistakes_in_the_table_are_named_with_their_place() {
    for (lab, expected) in [
        (
            "{ clok = {} }",
            "t.toml:1:9: lab.clok: unknown field `clok`; did you mean \"clock\"?",
        ),
        (
            "{ clock.drift-ppm = 1e6 }",
            "t.toml:1:27: lab.clock.drift-ppm: received 1000000, expected a number from -100000 to 100000",
        ),
        (
            "{ parts = [{ name = 'q', fault = 1 }] }",
            "t.toml:1:27: lab.parts[0].name: received \"q\", expected a part",
        ),
        ("3", "t.toml:1:7: lab: received 3, expected a table"),
    ] {
        assert_eq!(
            read(&format!("lab = {lab}\n{MACHINE}")).unwrap_err(),
            expected
        );
    }
}

#[test]
fn a_file_that_the_table_names_is_read_from_beside_the_config() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    let lab = "[lab]\nclock.drift-terms-ppm = [{ file = { path = 'd.csv' } }]\n";
    std::fs::write(&path, format!("{MACHINE}{lab}")).unwrap();
    let refused = NodeFile::<Toy>::load(&path).unwrap_err().to_string();
    assert!(
        refused.contains("lab.clock.drift-terms-ppm[0]"),
        "{refused}"
    );
    std::fs::write(folder.path().join("d.csv"), "0,0\n1,1\n").unwrap();
    NodeFile::<Toy>::load(&path).unwrap();
}

#[test]
fn a_config_survives_being_written_and_read() {
    for text in [MACHINE.to_owned(), format!("{MACHINE}{LAB}")] {
        let config = read(&text).unwrap().config;
        let written = NodeFile::text_of(&config).unwrap();
        // Another text may say the same: the values count.
        let again = read(&written).unwrap();
        assert_eq!(again.config, config);
        assert_eq!(again.lab.is_some(), text.contains("lab"), "{written}");
    }
}

#[test]
fn the_schemas_differ_by_where_the_fields_are() {
    let (in_place, file) = (
        schema_of::<Toy>().to_value(),
        NodeFile::<Toy>::schema().to_value(),
    );
    assert!(!in_place.to_string().contains("x-lab") && !file.to_string().contains("x-lab"));
    assert!(in_place["properties"]["clock"].is_object());
    assert!(file["properties"]["clock"].is_null());
    assert!(file["properties"]["lab"]["properties"]["clock"].is_object());
    assert!(in_place["$defs"]["Part"]["properties"]["fault"].is_object());
    assert!(file["$defs"]["Part"]["properties"]["fault"].is_null());
    // Definitions of both schemas are in one place.
    assert!(file["$defs"]["PartLab"].is_object());
    // A scenario's node has the fields where they belong.
    assert!(parse::<Toy>("t", "name = 'a'\nclock = { drift-ppm = 5 }").is_ok());
}
