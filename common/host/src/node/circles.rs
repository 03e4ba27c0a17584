//! Detection of circular coupling across nodes: reads the statuses of the followed receivers, and
//! passes the result for each axis to the cycle.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use coaxle_clock::{Instant, Span};
use coaxle_node::Channel;
use coaxle_node::circles::{AxisAddress, CircleChange, CircleFinding, CircleState, CircleWatch};
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::Subscription;
use coaxle_os::machine::Machine;
use rtrb::{Consumer, Producer, RingBuffer};
use serde_json::{Map, Value, json};

use crate::network::transport::{Declared, Transport};

/// Longest status accepted, bytes: that of a node with thousands of axes.
// 4 KiB of JSON for each of 4096 axes.
const LONGEST_STATUS: usize = 16 << 20;
/// Time without a status after which a node is forgotten: 20 statuses missing.
const SILENCE: Span = Span::from_secs(5);
/// Capacity of the ring of changes to the cycle. A change that does not fit is sent with the next status.
// A frame has 128 axes at most, so that eight full channels change at once.
const CHANGES: usize = 1024;

/// Subscribes to other nodes' statuses and searches them for circles.
pub(crate) struct CircleSearch {
    node: NodeName,
    watch: CircleWatch,
    statuses: Arc<Statuses>,
    /// State per node whose status is subscribed to.
    sources: BTreeMap<NodeName, Source>,
    to_cycle: Producer<CircleChange>,
    /// Changes already sent to the cycle, except for axes in no circle.
    given: Vec<CircleChange>,
    slaves: CircleNames,
    found: Vec<String>,
    _declared: Vec<Declared>,
}

/// Arrival state of the statuses of one node.
#[derive(Clone, Copy, Debug, Default)]
struct Source {
    /// Arrival time of the last status, unless the node was forgotten since.
    last: Option<Instant<Machine>>,
    /// Start of the time in which frames arrive without a status.
    missed_since: Option<Instant<Machine>>,
    /// True once the missing status was logged.
    is_logged: bool,
}

/// The newest status of each node that was not read yet.
type Statuses = Mutex<BTreeMap<NodeName, (Instant<Machine>, Vec<u8>)>>;

/// The circles of slaves, by slave name, for the text of refused orders.
#[derive(Clone, Default)]
pub(crate) struct CircleNames(Arc<Mutex<BTreeMap<String, String>>>);

impl CircleNames {
    /// The circle that a slave is in.
    pub(crate) fn of(&self, slave: &str) -> Option<String> {
        self.lock().get(slave).cloned()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, String>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl CircleSearch {
    /// Opens the search of a node with these subscriptions. The consumer returned is for the cycle.
    ///
    /// # Errors
    /// The transport refuses.
    pub(crate) fn open(
        node: &NodeName,
        subscriptions: &[Subscription],
        slaves: CircleNames,
        transport: &dyn Transport,
    ) -> anyhow::Result<(Self, Consumer<CircleChange>)> {
        let followers = subscriptions.iter().filter(|heard| {
            // Publishers of these channels follow other nodes; senders and gateways do not.
            matches!(heard.channel, Channel::Slaves | Channel::FarAxes)
        });
        let followers = followers.map(|heard| heard.node.clone());
        let watch = CircleWatch::new(node.clone(), followers);
        let statuses = Arc::new(Statuses::default());
        let mut declared = Vec::new();
        for other in watch.nodes() {
            let (statuses, name) = (Arc::clone(&statuses), other.clone());
            let on_status = move |at, bytes: &[u8]| {
                // Checked before it is kept: the map holds one status per node, of any sender under that key.
                if bytes.len() <= LONGEST_STATUS {
                    let mut statuses = statuses.lock().unwrap_or_else(PoisonError::into_inner);
                    // A newer status replaces one that was not read: only the present coupling counts.
                    statuses.insert(name.clone(), (at, bytes.to_vec()));
                }
            };
            declared.push(transport.subscribe(&other.status_key(), Box::new(on_status))?);
        }
        let sources = watch
            .nodes()
            .map(|other| (other.clone(), Source::default()));
        let (to_cycle, changes) = RingBuffer::new(CHANGES);
        let search = Self {
            node: node.clone(),
            sources: sources.collect(),
            watch,
            statuses,
            to_cycle,
            given: Vec::new(),
            slaves,
            found: Vec::new(),
            _declared: declared,
        };
        Ok((search, changes))
    }

    /// Reads the statuses that arrived, passes changes to the cycle, and adds the findings to the
    /// node's own status.
    pub(crate) fn look(
        &mut self,
        now: Instant<Machine>,
        status: &mut Map<String, Value>,
        is_followed: impl Fn(&NodeName) -> bool,
    ) {
        // A node that follows senders only can be in no circle: its status has no entry about them.
        if self.sources.is_empty() {
            return;
        }
        self.read(now);
        // After reading: a status that has just arrived is not missing.
        self.log_silent_nodes(now, is_followed);
        let finding = self.watch.look(status);
        self.give(&finding);
        self.show(&finding, status);
        self.log_finding(&finding);
    }

    fn read(&mut self, now: Instant<Machine>) {
        let statuses = self.statuses.lock();
        // Taken as a whole: parsing JSON under the lock would hold the transport's thread.
        let statuses = std::mem::take(&mut *statuses.unwrap_or_else(PoisonError::into_inner));
        for (node, (at, bytes)) in statuses {
            // A status that is no JSON is of another program: the node counts as silent.
            let Ok(Value::Object(status)) = serde_json::from_slice(&bytes) else {
                continue;
            };
            self.watch.take(&node, &status);
            let last = Some(at);
            self.sources.insert(
                node,
                // A status ends the search for a missing one, and a later silence is logged again.
                Source {
                    last,
                    ..Source::default()
                },
            );
        }
        for (node, source) in &mut self.sources {
            if source.last.is_some_and(|last| now - last > SILENCE) {
                self.watch.forget(node);
                source.last = None;
            }
        }
    }

    /// Logs each node whose frames arrive without its status.
    fn log_silent_nodes(&mut self, now: Instant<Machine>, is_followed: impl Fn(&NodeName) -> bool) {
        for (other, source) in &mut self.sources {
            if source.last.is_some() || !is_followed(other) {
                // Without frames the node itself is missing, which its health says already.
                source.missed_since = None;
                continue;
            }
            let since = *source.missed_since.get_or_insert(now);
            if now - since > SILENCE && !source.is_logged {
                // Once per silence: rights do not come back by themselves.
                source.is_logged = true;
                tracing::warn!(
                    node = %self.node,
                    "the status of node {other} does not arrive, although its frames do: a circle over it cannot be found. \
                     In a secure network `coaxle secure renew` gives the right to it"
                );
            }
        }
    }

    fn give(&mut self, finding: &CircleFinding) {
        for change in &finding.states {
            let is_axis =
                |given: &CircleChange| (given.channel, given.id) == (change.channel, change.id);
            let place = self.given.iter().position(is_axis);
            // The cycle begins with no circle for every axis, so that only others are remembered.
            let before = place.map_or(CircleState::None, |place| self.given[place].state);
            // Not remembered where the ring is full, so that the next status tries again.
            if change.state == before || self.to_cycle.push(*change).is_err() {
                continue;
            }
            match place {
                Some(place) => self.given[place] = *change,
                None => self.given.push(*change),
            }
        }
    }

    fn show(&self, finding: &CircleFinding, status: &mut Map<String, Value>) {
        let mut names = BTreeMap::new();
        let slaves = status.get_mut("slaves").and_then(Value::as_object_mut);
        for (name, slave) in slaves.into_iter().flatten() {
            let id = slave["id"].as_u64().and_then(|id| u32::try_from(id).ok());
            let circle = id.and_then(|id| {
                let node = self.node.clone();
                let channel = Channel::Slaves;
                finding.circle_of(&AxisAddress { node, channel, id })
            });
            let circle = circle.map(ToString::to_string);
            if let Value::Object(slave) = slave {
                slave.insert("circle".to_owned(), json!(circle));
            }
            names.extend(circle.map(|circle| (name.clone(), circle)));
        }
        // Replaced as a whole: a slave that left its circle must not keep the old text.
        *self.slaves.lock() = names;
        status.insert("circles".to_owned(), finding.to_json());
    }

    fn log_finding(&mut self, finding: &CircleFinding) {
        let node = &self.node;
        let found: Vec<_> = finding.circles.iter().map(ToString::to_string).collect();
        // Only what is new: the same circles are found four times a second.
        for circle in found.iter().filter(|circle| !self.found.contains(circle)) {
            tracing::error!(
                %node,
                "0x816f: a circle: {circle}; what would couple an axis of this node in it is refused, and one that is coupled \
                 stops when the circle is closed"
            );
        }
        for circle in self.found.iter().filter(|circle| !found.contains(circle)) {
            tracing::info!(%node, "no circle any more: {circle}");
        }
        self.found = found;
    }
}

#[cfg(test)]
mod tests;
