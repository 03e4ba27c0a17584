use std::path::Path;

use super::*;

/// Update after a change: `UPDATE_DOCS=1 cargo test -p coaxle reference`.
#[test]
fn the_reference_is_what_the_types_say() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/REFERENCE.md");
    let page = reference::page();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == page,
        "docs/REFERENCE.md is not what the types say: UPDATE_DOCS=1 writes it"
    );
}

fn folder(path: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    let files = std::fs::read_dir(&folder)
        .unwrap()
        .map(|file| file.unwrap().path());
    let mut files: Vec<_> = files
        .filter(|file| file.extension().is_some_and(|ending| ending == "toml"))
        .collect();
    assert!(!files.is_empty(), "{}", folder.display());
    files.sort();
    files
}

fn json(text: &str) -> Value {
    let table: toml::Table = text.parse().unwrap();
    serde_json::to_value(table).unwrap()
}

#[test]
fn every_file_that_is_shipped_fits_its_schema() {
    for (kind, folders) in [
        (FileKind::Scenario, &["catalog", "catalog/faults"][..]),
        (FileKind::Sender, &["../sender/configs"]),
        (FileKind::Receiver, &["../receiver/configs"]),
        (FileKind::Gateway, &["../common/gateway/configs"]),
        (FileKind::Opcua, &["../common/opcua/configs"]),
        (FileKind::Cam, &["cams"]),
        (FileKind::Saw, &["saws"]),
        (FileKind::Gear, &["gears"]),
    ] {
        let schema = jsonschema::validator_for(&kind.schema()).unwrap();
        for file in folders.iter().flat_map(|path| folder(path)) {
            let held = json(&std::fs::read_to_string(&file).unwrap());
            let errors: Vec<_> = schema
                .iter_errors(&held)
                .map(|e| format!("{}: {e}", e.instance_path()))
                .collect();
            assert!(errors.is_empty(), "{}: {errors:#?}", file.display());
        }
    }
}

#[test]
fn what_is_refused_when_a_file_is_read_fails_its_schema() {
    let sender = "name = 'a'\ncycle-time-us = 1000\n[[axis]]\nid = 1\nname = 'x'\n[axis.program]\n\
                  limits = { velocity = 1, acceleration = 1, jerk = 1 }\n";
    let schema = jsonschema::validator_for(&FileKind::Sender.schema()).unwrap();
    assert!(schema.is_valid(&json(sender)));
    for (from, to) in [
        ("cycle-time-us", "cycle-time-u"),
        ("1000", "'1 ms'"),
        ("1000", "1"),
        ("id = 1", "id = 0"),
        ("name = 'a'", ""),
        ("name = 'a'", "name = 'a b'"),
        ("jerk = 1", "jerk = 0"),
        ("[axis.program]", "[axis.program]\nrepeat = 'yes'"),
        (
            "[axis.program]",
            "[axis.program]\nsteps = [{ move-abs = { position = 1 } }]",
        ),
        ("[[axis]]", "[transport]\nmode = 'star'\n[[axis]]"),
    ] {
        let changed = sender.replacen(from, to, 1);
        assert_ne!(changed, sender);
        assert!(!schema.is_valid(&json(&changed)), "{changed}");
    }
}

#[test]
fn schemas_are_written_for_editors() {
    let out = tempfile::tempdir().unwrap();
    for kind in FileKind::value_variants() {
        write(*kind, out.path()).unwrap();
        let path = out
            .path()
            .join(format!("coaxle-{}.schema.json", kind.name()));
        let schema: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        assert_eq!(schema["type"], "object");
        assert_eq!(schema["additionalProperties"], false, "{kind:?}");
    }
}
