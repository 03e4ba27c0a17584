//! A node in the address space: its objects, their newest values, its events.

use coaxle_clock::{Instant, Span};
use coaxle_host::client::SeenNode;
use coaxle_node::keys::NodeName;
use coaxle_os::Machine;
use coaxle_recording::{ReadTable, Value};
use opcua::types::{DataValue, DateTime, NodeId, StatusCode};

use super::space::{data_value, date_time};
use crate::occurrence::{Occurrence, StatusWatch, status_part, status_text};
use crate::part::{PartObject, StatusText, VariableSource};
use crate::rows::CycleValues;

/// Age of the newest row from which values are marked as old.
// Forty pieces: a network that loses some of them is still followed.
const OLDEST: Span = Span::from_secs(2);

/// State of a shown node.
pub(super) struct ShownNode {
    pub(super) name: NodeName,
    table: Option<ReadTable>,
    parts: Vec<PartObject>,
    /// Newest values of the variables of rows.
    values: Vec<(NodeId, DataValue)>,
    watch: StatusWatch,
    status_at: Option<Instant<Machine>>,
    row_at: Option<Instant<Machine>>,
    is_old: bool,
}

impl ShownNode {
    pub(super) fn new(name: NodeName) -> Self {
        Self {
            name,
            table: None,
            parts: vec![PartObject::node()],
            values: Vec::new(),
            watch: StatusWatch::default(),
            status_at: None,
            row_at: None,
            is_old: false,
        }
    }

    pub(super) fn parts(&self) -> &[PartObject] {
        &self.parts
    }

    /// True if the objects are those of a table.
    pub(super) fn has_table(&self, table: &ReadTable) -> bool {
        self.table.as_ref() == Some(table)
    }

    /// Takes the table of a run with other signals. The objects are those of it from then on.
    pub(super) fn take_table(&mut self, table: ReadTable) {
        self.parts = PartObject::of_table(&table);
        self.table = Some(table);
        self.values.clear();
        // Texts of the status belong to new objects.
        self.status_at = None;
    }

    /// Takes the values of a cycle. Returns those of variables.
    pub(super) fn take_values(
        &mut self,
        now: Instant<Machine>,
        cycle: &CycleValues,
        id: impl Fn(&str) -> NodeId,
    ) -> Vec<(NodeId, DataValue)> {
        self.row_at = Some(now);
        self.is_old = false;
        let source = date_time(cycle.unix_ns);
        let mut changed = Vec::new();
        for (path, of) in self.variables() {
            if let VariableSource::Column(column) = of {
                let value = cycle.values.get(column).and_then(Option::as_ref);
                changed.push((id(&path), data_value(value, source)));
            }
        }
        self.values.clone_from(&changed);
        changed
    }

    /// Takes a status, if it is a new one. Returns its values and events.
    pub(super) fn take_status(
        &mut self,
        seen: &SeenNode,
        unix_ns: i64,
        id: impl Fn(&str) -> NodeId,
    ) -> (Vec<(NodeId, DataValue)>, Vec<Occurrence>) {
        let status = seen.status.as_ref();
        let at = status.map(|(at, _)| *at);
        let fresh = status
            .filter(|_| at != self.status_at)
            .map(|(_, fields)| fields);
        let events = self.watch.take(self.name.as_str(), seen.is_alive, fresh);
        if at == self.status_at && events.is_empty() {
            return (Vec::new(), events);
        }
        self.status_at = at;
        // Dated by its arrival: a status does not say when it was made.
        let arrived = at.map_or(unix_ns, |at| at.as_nanos().saturating_add(unix_ns));
        let source = date_time(arrived);
        let fields = status.map(|(_, fields)| fields);
        let mut changed = Vec::new();
        for part in &self.parts {
            let of_part = fields.and_then(|fields| status_part(fields, part.kind, &part.name));
            let path = part.path(self.name.as_str());
            for variable in &part.variables {
                let VariableSource::Status(text) = variable.source else {
                    continue;
                };
                let value = match text {
                    StatusText::Alive => Value::Flag(seen.is_alive),
                    // Without a fault its text is empty.
                    text => Value::Text(status_text(text, of_part).unwrap_or_default()),
                };
                let path = format!("{path}/{}", variable.name);
                changed.push((id(&path), data_value(Some(&value), source)));
            }
        }
        (changed, events)
    }

    /// Values to mark as old, once, when rows have stayed away.
    pub(super) fn grow_old(&mut self, now: Instant<Machine>) -> Vec<(NodeId, DataValue)> {
        let is_old = self.row_at.is_some_and(|at| now - at > OLDEST);
        if !is_old || std::mem::replace(&mut self.is_old, true) {
            return Vec::new();
        }
        for (_, value) in &mut self.values {
            value.status = Some(StatusCode::UncertainNoCommunicationLastUsableValue);
            value.server_timestamp = Some(DateTime::now());
        }
        self.values.clone()
    }

    /// Paths of the variables, and their sources.
    fn variables(&self) -> impl Iterator<Item = (String, VariableSource)> {
        self.parts.iter().flat_map(|part| {
            let path = part.path(self.name.as_str());
            let variables = part.variables.iter();
            variables.map(move |variable| (format!("{path}/{}", variable.name), variable.source))
        })
    }
}
