//! `modelDescription.xml`: what a unit states of itself.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::model::Model;
use crate::resources::UnitKind;
use crate::units_of_measure::base_of;
use crate::variable::{Causality, UnitValue, Variable};

/// Writes the description of a unit.
pub(crate) fn description(model: &dyn Model, kind: UnitKind, token: &str) -> String {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let identifier = kind.identifier();
    let title = escaped(&model.title());
    let version = env!("CARGO_PKG_VERSION");
    let step = model.cycle_time().as_secs_f64();
    let _ = write!(
        xml,
        r#"<fmiModelDescription fmiVersion="3.0" modelName="{identifier}" instantiationToken="{token}" description="{title}"
  version="{version}" generationTool="Coaxle {version}" variableNamingConvention="flat">
  <CoSimulation modelIdentifier="{identifier}" canHandleVariableCommunicationStepSize="false" fixedInternalStepSize="{step}"
    canGetAndSetFMUState="true" canSerializeFMUState="true"/>
"#
    );
    write_units(&mut xml, model);
    xml.push_str("  <LogCategories>\n");
    for (category, meaning) in LOG_CATEGORIES {
        let _ = writeln!(
            xml,
            r#"    <Category name="{category}" description="{meaning}"/>"#
        );
    }
    xml.push_str("  </LogCategories>\n");
    let _ = writeln!(
        xml,
        r#"  <DefaultExperiment startTime="0" stepSize="{step}"/>"#
    );
    xml.push_str("  <ModelVariables>\n");
    for (reference, variable) in model.variables().iter().enumerate() {
        write_variable(&mut xml, reference, variable);
    }
    xml.push_str("  </ModelVariables>\n  <ModelStructure>\n");
    for element in ["Output", "InitialUnknown"] {
        let outputs = model.variables().iter().enumerate();
        for (reference, _) in outputs.filter(|(_, it)| it.causality == Causality::Output) {
            let _ = writeln!(xml, r#"    <{element} valueReference="{reference}"/>"#);
        }
    }
    xml.push_str("  </ModelStructure>\n</fmiModelDescription>\n");
    xml
}

/// Categories of messages to the log, with their meanings.
const LOG_CATEGORIES: [(&str, &str); 2] = [
    (
        "logStatusError",
        "A call that was refused, with its reason.",
    ),
    (
        "logStatusWarning",
        "A command of an axis that was refused, with its reason.",
    ),
];

fn write_units(xml: &mut String, model: &dyn Model) {
    let units = model.variables().iter().map(|it| it.unit.as_str());
    let units: BTreeSet<&str> = units.filter(|unit| !unit.is_empty()).collect();
    xml.push_str("  <UnitDefinitions>\n");
    for unit in units {
        let name = escaped(unit);
        let Some(base) = base_of(unit) else {
            let _ = writeln!(xml, r#"    <Unit name="{name}"/>"#);
            continue;
        };
        let _ = write!(xml, r#"    <Unit name="{name}"><BaseUnit"#);
        for (exponent, of) in [(base.m, "m"), (base.s, "s"), (base.rad, "rad")] {
            if exponent != 0 {
                let _ = write!(xml, r#" {of}="{exponent}""#);
            }
        }
        let _ = writeln!(xml, r#" factor="{}"/></Unit>"#, base.factor);
    }
    xml.push_str("  </UnitDefinitions>\n");
}

fn write_variable(xml: &mut String, reference: usize, variable: &Variable) {
    let kind = variable.start.kind().name();
    let name = escaped(&variable.name);
    let description = escaped(&variable.description);
    let (causality, variability) = role_of(variable);
    let _ = write!(
        xml,
        r#"    <{kind} name="{name}" valueReference="{reference}" description="{description}" causality="{causality}" variability="{variability}""#
    );
    if !variable.unit.is_empty() {
        let _ = write!(xml, r#" unit="{}""#, escaped(&variable.unit));
    }
    let has_start = matches!(variable.causality, Causality::Parameter | Causality::Input);
    let _ = match (&variable.start, has_start) {
        (_, false) => writeln!(xml, "/>"),
        (UnitValue::Float64(start), _) => writeln!(xml, r#" start="{start:?}"/>"#),
        (UnitValue::Int64(start), _) => writeln!(xml, r#" start="{start}"/>"#),
        (UnitValue::UInt64(start), _) => writeln!(xml, r#" start="{start}"/>"#),
        (UnitValue::Boolean(start), _) => writeln!(xml, r#" start="{start}"/>"#),
        (UnitValue::String(start), _) => {
            writeln!(xml, r#"><Start value="{}"/></{kind}>"#, escaped(start))
        }
    };
}

/// Causality and variability in the words of FMI.
const fn role_of(variable: &Variable) -> (&'static str, &'static str) {
    let is_number = matches!(variable.start, UnitValue::Float64(_));
    match variable.causality {
        Causality::Independent => ("independent", "continuous"),
        Causality::Parameter => ("parameter", "fixed"),
        Causality::Input if is_number => ("input", "continuous"),
        Causality::Input => ("input", "discrete"),
        // Values stay from cycle to cycle.
        Causality::Output => ("output", "discrete"),
        Causality::Local => ("local", "discrete"),
    }
}

/// A text as part of an attribute.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // XML 1.0 has no other control characters, and a name has none of these.
            letter if letter.is_control() => escaped.push(' '),
            letter => escaped.push(letter),
        }
    }
    escaped
}
