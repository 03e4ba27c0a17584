//! Nodes of the address space for the objects, variables and methods of a node.

use std::sync::Arc;

use coaxle_node::command::{Addressee, FarName, SlaveName};
use coaxle_node::keys::NodeName;
use coaxle_node::signal::Kind;
use coaxle_recording::Value;
use opcua::nodes::{EventNotifier, MethodBuilder, ObjectBuilder, VariableBuilder};
use opcua::server::address_space::AddressSpace;
use opcua::types::{
    Argument, DataTypeId, DataValue, DateTime, EUInformation, ExtensionObject, LocalizedText,
    NodeId, ObjectId, ObjectTypeId, QualifiedName, StatusCode, UAString, VariableTypeId, Variant,
};

use super::calls::CallTarget;
use crate::method::{ArgumentKind, CommandMethod};
use crate::part::{PartKind, PartObject, PartVariable};
use crate::unit::{UNIT_NAMESPACE, unit_id};

/// Id of the folder of all nodes, which no node can have as its name.
const ROOT: &str = "/";

/// Method that takes a command as JSON.
const EXECUTE: &str = "execute";

/// Writes objects of nodes into the address space.
pub(super) struct SpaceWriter {
    namespace: u16,
    of_slaves: Vec<Arc<CommandMethod>>,
    of_far_nodes: Vec<Arc<CommandMethod>>,
}

/// Additions to the address space.
#[derive(Default)]
pub(super) struct AddedNodes {
    pub(super) ids: Vec<NodeId>,
    pub(super) targets: Vec<(NodeId, CallTarget)>,
}

impl SpaceWriter {
    pub(super) fn new(namespace: u16) -> Self {
        let shared = |methods: Vec<CommandMethod>| methods.into_iter().map(Arc::new).collect();
        Self {
            namespace,
            of_slaves: shared(CommandMethod::of_slaves()),
            of_far_nodes: shared(CommandMethod::of_far_nodes()),
        }
    }

    /// Id of an object, a variable or a method by its path.
    pub(super) fn id(&self, path: &str) -> NodeId {
        NodeId::new(self.namespace, path)
    }

    /// Adds the folder of all nodes.
    pub(super) fn add_root(&self, space: &mut AddressSpace) {
        let id = self.id(ROOT);
        ObjectBuilder::new(&id, self.name("Coaxle"), "Coaxle")
            .description(LocalizedText::from("The nodes of the network"))
            .has_type_definition(ObjectTypeId::FolderType)
            .organized_by(ObjectId::ObjectsFolder)
            .insert(space);
    }

    /// Adds an object with its variables and methods.
    pub(super) fn add(
        &self,
        space: &mut AddressSpace,
        node: &NodeName,
        part: &PartObject,
        added: &mut AddedNodes,
    ) {
        let path = part.path(node.as_str());
        let (id, name) = (
            self.id(&path),
            if part.name.is_empty() {
                node.as_str()
            } else {
                &part.name
            },
        );
        let parent = match part.kind {
            PartKind::Node => self.id(ROOT),
            kind => self.folder(space, node, kind, added),
        };
        ObjectBuilder::new(&id, self.name(name), name)
            .has_type_definition(ObjectTypeId::BaseObjectType)
            .event_notifier(EventNotifier::SUBSCRIBE_TO_EVENTS)
            .organized_by(parent)
            .insert(space);
        added.ids.push(id);
        for variable in &part.variables {
            self.add_variable(space, &path, variable, added);
        }
        self.add_methods(space, node, part, added);
    }

    fn folder(
        &self,
        space: &mut AddressSpace,
        node: &NodeName,
        kind: PartKind,
        added: &mut AddedNodes,
    ) -> NodeId {
        let id = self.id(&format!("{node}/{}", kind.folder()));
        if !space.node_exists(&id) {
            ObjectBuilder::new(&id, self.name(kind.folder()), kind.folder())
                .has_type_definition(ObjectTypeId::FolderType)
                .organized_by(self.id(node.as_str()))
                .insert(space);
            added.ids.push(id.clone());
        }
        id
    }

    fn add_variable(
        &self,
        space: &mut AddressSpace,
        object: &str,
        variable: &PartVariable,
        added: &mut AddedNodes,
    ) {
        let path = format!("{object}/{}", variable.name);
        let id = self.id(&path);
        let kind = match variable.unit.as_str() {
            "" => VariableTypeId::BaseDataVariableType,
            _ => VariableTypeId::AnalogUnitType,
        };
        VariableBuilder::new(&id, self.name(&variable.name), variable.name.as_str())
            .data_type(data_type(variable.kind))
            .value_rank(-1)
            .has_type_definition(kind)
            .component_of(self.id(object))
            .insert(space);
        if let Some(node) = space.find_mut(&id)
            && let opcua::nodes::NodeType::Variable(node) = node
        {
            node.set_data_value(no_value(StatusCode::BadWaitingForInitialData));
        }
        added.ids.push(id);
        if !variable.unit.is_empty() {
            added.ids.push(self.add_unit(space, &path, &variable.unit));
        }
    }

    fn add_unit(&self, space: &mut AddressSpace, variable: &str, unit: &str) -> NodeId {
        let information = EUInformation {
            namespace_uri: UAString::from(UNIT_NAMESPACE),
            unit_id: unit_id(unit),
            display_name: LocalizedText::from(unit),
            description: LocalizedText::from(unit),
        };
        let id = self.id(&format!("{variable}/EngineeringUnits"));
        let name = QualifiedName::new(0, "EngineeringUnits");
        VariableBuilder::new(&id, name, "EngineeringUnits")
            .data_type(DataTypeId::EUInformation)
            .value_rank(-1)
            .value(Variant::from(ExtensionObject::from_message(information)))
            .has_type_definition(VariableTypeId::PropertyType)
            .property_of(self.id(variable))
            .insert(space);
        id
    }

    fn add_methods(
        &self,
        space: &mut AddressSpace,
        node: &NodeName,
        part: &PartObject,
        added: &mut AddedNodes,
    ) {
        let name = &part.name;
        let (addressee, methods) = match part.kind {
            PartKind::Slave => (
                SlaveName::new(name).ok().map(Addressee::Slave),
                &self.of_slaves,
            ),
            PartKind::FarNode => (
                FarName::new(name).ok().map(Addressee::Far),
                &self.of_far_nodes,
            ),
            _ => return,
        };
        // A name that no order can have is one of a later version.
        let Some(addressee) = addressee else {
            return;
        };
        let path = part.path(node.as_str());
        for method in methods.iter().map(Some).chain([None]) {
            let target = CallTarget {
                node: node.clone(),
                addressee,
                method: method.map(Arc::clone),
            };
            let id = self.add_method(space, &path, &target, added);
            added.targets.push((id, target));
        }
    }

    fn add_method(
        &self,
        space: &mut AddressSpace,
        object: &str,
        target: &CallTarget,
        added: &mut AddedNodes,
    ) -> NodeId {
        let (key, meaning) = target.method.as_ref().map_or(
            (
                EXECUTE,
                "Executes a command as JSON, as docs/WIRE.md has it.",
            ),
            |method| (method.key, method.meaning.as_str()),
        );
        // A colon: a signal may have the name of a command.
        let path = format!("{object}:{key}");
        let id = self.id(&path);
        let properties = ["input", "output"].map(|of| self.id(&format!("{path}/{of}")));
        MethodBuilder::new(&id, self.name(key), key)
            .description(LocalizedText::from(meaning))
            .executable(true)
            .user_executable(true)
            .component_of(self.id(object))
            .input_args(space, &properties[0], &inputs(target))
            .output_args(space, &properties[1], &outputs())
            .insert(space);
        added.ids.extend(properties);
        added.ids.push(id.clone());
        id
    }

    fn name(&self, name: &str) -> QualifiedName {
        QualifiedName::new(self.namespace, name)
    }
}

/// Value of a variable with the time of its source.
pub(super) fn data_value(value: Option<&Value>, source: DateTime) -> DataValue {
    let Some(value) = value else {
        return DataValue {
            source_timestamp: Some(source),
            ..no_value(StatusCode::BadNoData)
        };
    };
    let value = match value {
        Value::Number(number) => Variant::Double(*number),
        Value::Count(count) => Variant::UInt64(*count),
        Value::Integer(integer) => Variant::Int64(*integer),
        Value::Flag(flag) => Variant::Boolean(*flag),
        Value::Text(text) => Variant::String(UAString::from(text.as_str())),
    };
    DataValue {
        value: Some(value),
        status: Some(StatusCode::Good),
        source_timestamp: Some(source),
        server_timestamp: Some(DateTime::now()),
        ..DataValue::default()
    }
}

fn no_value(status: StatusCode) -> DataValue {
    DataValue {
        // Without any value the library would drop the status.
        value: Some(Variant::Empty),
        status: Some(status),
        server_timestamp: Some(DateTime::now()),
        ..DataValue::default()
    }
}

/// Time in ns since 1970 as OPC UA has it.
pub(super) fn date_time(unix_ns: i64) -> DateTime {
    // 100 ns since 1601, of which 11 644 473 600 s are before 1970.
    DateTime::from(unix_ns / 100 + 116_444_736_000_000_000)
}

const fn data_type(kind: Kind) -> DataTypeId {
    match kind {
        Kind::Number => DataTypeId::Double,
        Kind::Count => DataTypeId::UInt64,
        Kind::Integer => DataTypeId::Int64,
        Kind::Flag => DataTypeId::Boolean,
        Kind::Text => DataTypeId::String,
    }
}

fn inputs(target: &CallTarget) -> Vec<Argument> {
    let dry_run = argument(
        "dry-run",
        DataTypeId::Boolean,
        "True: only report the result, execute nothing.",
    );
    let rest = match &target.method {
        None => vec![argument(
            "command",
            DataTypeId::String,
            "The command, such as { \"halt\": {} }.",
        )],
        Some(method) => (method.arguments.iter())
            .map(|one| {
                let kind = match one.kind {
                    ArgumentKind::Number => DataTypeId::Double,
                    ArgumentKind::Integer => DataTypeId::Int64,
                    ArgumentKind::Flag => DataTypeId::Boolean,
                    ArgumentKind::Text | ArgumentKind::Json => DataTypeId::String,
                };
                let meaning = match one.is_optional {
                    true => format!("{} Null: the default.", one.meaning),
                    false => one.meaning.clone(),
                };
                argument(&one.name, kind, &meaning)
            })
            .collect(),
    };
    [dry_run].into_iter().chain(rest).collect()
}

fn outputs() -> Vec<Argument> {
    vec![
        argument(
            "accepted",
            DataTypeId::Boolean,
            "True if the command was accepted; after a dry run, if it would be.",
        ),
        argument(
            "outcome",
            DataTypeId::String,
            "accepted, refused, not-taken or no-response.",
        ),
        argument(
            "text",
            DataTypeId::String,
            "Reason in words: the field, the value received and the one expected.",
        ),
        argument("code", DataTypeId::String, "Error code of a refusal."),
        argument(
            "job",
            DataTypeId::UInt32,
            "Number of the slave's job; 0 without one.",
        ),
        argument(
            "response",
            DataTypeId::String,
            "Response of the node as JSON.",
        ),
    ]
}

fn argument(name: &str, kind: DataTypeId, meaning: &str) -> Argument {
    Argument {
        name: UAString::from(name),
        data_type: kind.into(),
        value_rank: -1,
        array_dimensions: None,
        description: LocalizedText::from(meaning),
    }
}
