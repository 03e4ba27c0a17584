//! What nodes say of their axes: the own description for others, and a comparison of the config with those of the
//! followed nodes.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use coaxle_clock::{Instant, Span};
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::Subscription;
use coaxle_os::machine::Machine;
use coaxle_topology::{AboutContradiction, AboutWatch, AxisOrigin, PlantNode, about_to_json};
use serde_json::{Map, Value, json};

use crate::network::transport::{Declared, Publisher, Request, Transport, Urgency};
use crate::node::reception::Contact;
use crate::node::session::Session;

/// Longest description kept, bytes; [`AboutWatch`] refuses it then.
const LONGEST: usize = (1 << 20) + 1;
/// Interval of the repetitions while somebody subscribes: a follower may come late, and a message may be lost.
const AGAIN: Span = Span::from_secs(2);

/// The own description, published and served.
pub(crate) struct OwnAbout {
    json: String,
    publisher: Box<dyn Publisher>,
    last: Option<Instant<Machine>>,
    _served: Declared,
}

impl OwnAbout {
    /// Publishes a description from now on, and answers queries for it.
    ///
    /// # Errors
    /// The transport refuses.
    fn serve(name: &NodeName, json: String, transport: &dyn Transport) -> anyhow::Result<Self> {
        let key = name.about_key();
        let publisher = transport.publisher(&key, Urgency::Ordinary)?;
        let answer = json.clone();
        let on_request = move |_, request: Box<dyn Request>| request.reply(answer.clone(), true);
        let served = transport.serve(&key, Box::new(on_request))?;
        Ok(Self {
            json,
            publisher,
            last: None,
            _served: served,
        })
    }

    /// Publishes it to new subscribers, and again now and then.
    pub(crate) fn publish(&mut self, now: Instant<Machine>) {
        if !self.publisher.has_subscriber() {
            // The next one is new, and gets it at once.
            self.last = None;
            return;
        }
        if self.last.is_some_and(|last| now - last < AGAIN) {
            return;
        }
        self.last = Some(now);
        if let Err(error) = self.publisher.publish(self.json.clone().into_bytes()) {
            tracing::debug!(%error, "the transport refused the description of the axes");
        }
    }
}

/// Both directions of a node.
pub(crate) struct Abouts {
    pub(crate) own: OwnAbout,
    pub(crate) others: AboutReader,
}

impl Abouts {
    /// Opens both for a run of a node with these subscriptions.
    ///
    /// # Errors
    /// The transport refuses.
    pub(crate) fn open(
        own: PlantNode,
        epoch: u64,
        subscriptions: &[Subscription],
        session: &Session,
    ) -> anyhow::Result<Self> {
        let followed = subscriptions.iter();
        // In the order of the subscriptions, as the session has them.
        let followed = followed.filter(|subscription| subscription.channel.carries_axes());
        let contacts = followed.zip(session.contacts());
        let contacts = contacts.map(|(heard, contact)| (heard.node.clone(), Arc::clone(contact)));
        let (json, transport) = (about_to_json(&own, epoch), &**session.transport());
        Ok(Self {
            own: OwnAbout::serve(&own.name, json, transport)?,
            others: AboutReader::open(own, contacts.collect(), transport)?,
        })
    }
}

/// State of the followed nodes, for the threads of the transport and the one that reports.
struct FollowedAbouts {
    node: NodeName,
    watch: AboutWatch,
    /// The last description of each node: most are repetitions.
    read: BTreeMap<NodeName, Vec<u8>>,
    contacts: Vec<(NodeName, Arc<Contact>)>,
}

/// Reads the descriptions of the followed nodes.
pub(crate) struct AboutReader {
    /// Axes of the config: some state no unit.
    own: PlantNode,
    followed: Arc<Mutex<FollowedAbouts>>,
    logged: Vec<AboutContradiction>,
    _declared: Vec<Declared>,
}

impl AboutReader {
    /// Subscribes to the descriptions of the nodes that `own` follows, whose frames wait for them.
    ///
    /// # Errors
    /// The transport refuses.
    fn open(
        own: PlantNode,
        contacts: Vec<(NodeName, Arc<Contact>)>,
        transport: &dyn Transport,
    ) -> anyhow::Result<Self> {
        let watch = AboutWatch::new(&own);
        let others: Vec<_> = watch.nodes().cloned().collect();
        for (node, contact) in &contacts {
            // Where nothing is stated nothing can contradict, and nothing waits.
            if watch.states_something_of(node) {
                contact.described().expect();
            }
        }
        let followed = Arc::new(Mutex::new(FollowedAbouts {
            node: own.name.clone(),
            watch,
            read: BTreeMap::new(),
            contacts,
        }));
        let mut declared = Vec::new();
        for other in others {
            let (followed, name) = (Arc::clone(&followed), other.clone());
            // At once and not with the next status: frames wait for it.
            let on_about = move |_, bytes: &[u8]| lock(&followed).take(&name, bytes);
            declared.push(transport.subscribe(&other.about_key(), Box::new(on_about))?);
        }
        Ok(Self {
            own,
            followed,
            logged: Vec::new(),
            _declared: declared,
        })
    }

    /// Adds the findings to the status. Returns true if a run contradicts the config.
    pub(crate) fn look(&mut self, status: &mut Map<String, Value>) -> bool {
        let followed = Arc::clone(&self.followed);
        let followed = lock(&followed);
        let nodes = followed.watch.nodes();
        // The newest run counts: the one before it is over.
        let found: Vec<_> = nodes
            .flat_map(|node| followed.watch.newest_contradictions(node))
            .collect();
        self.show(&followed.watch, &found, status);
        drop(followed);
        self.log(found);
        !self.logged.is_empty()
    }

    fn show(
        &self,
        watch: &AboutWatch,
        found: &[AboutContradiction],
        status: &mut Map<String, Value>,
    ) {
        let nodes = watch.nodes().map(|source| {
            let own = found
                .iter()
                .filter(|contradiction| contradiction.node == *source);
            let texts: Vec<_> = own.map(ToString::to_string).collect();
            let about = json!({
                "described": watch.describes(source),
                "ignored": watch.ignored(source),
                "contradictions": texts,
            });
            (source.to_string(), about)
        });
        let nodes: Map<_, _> = nodes.collect();
        // A node that follows nobody has no entry about others.
        if nodes.is_empty() {
            return;
        }
        status.insert("about".to_owned(), Value::Object(nodes));
        self.show_units(watch, status);
    }

    /// Units that the config leaves open, as the followed nodes say.
    fn show_units(&self, watch: &AboutWatch, status: &mut Map<String, Value>) {
        let Some(Value::Object(axes)) = status.get_mut("axes") else {
            return;
        };
        for axis in self.own.axes.iter().filter(|axis| axis.unit.is_none()) {
            let AxisOrigin::Far(far) = &axis.origin else {
                continue;
            };
            let unit = far.sources.iter().find_map(|source| watch.unit(source));
            if let (Some(unit), Some(shown)) = (unit, axes.get_mut(&axis.name)) {
                shown["unit"] = json!(unit);
            }
        }
    }

    fn log(&mut self, found: Vec<AboutContradiction>) {
        let node = &self.own.name;
        // Only what is new: the same ones are found four times a second.
        for contradiction in found.iter().filter(|one| !self.logged.contains(one)) {
            tracing::error!(
                %node,
                "the config contradicts the axis: {contradiction}; frames of node {} are refused until one of both is changed",
                contradiction.node
            );
        }
        for contradiction in self.logged.iter().filter(|one| !found.contains(one)) {
            tracing::info!(%node, "no contradiction any more: {contradiction}");
        }
        self.logged = found;
    }
}

impl FollowedAbouts {
    /// Takes a description, and decides about the frames of its run.
    fn take(&mut self, source: &NodeName, bytes: &[u8]) {
        // Cut and not dropped: one that is too long is counted.
        let bytes = &bytes[..bytes.len().min(LONGEST)];
        if self.read.get(source).is_some_and(|read| read == bytes) {
            return;
        }
        if let Err(error) = self.watch.take(source, bytes) {
            tracing::warn!(node = %self.node, "what node {source} says of its axes is ignored: {error}");
        }
        self.read.insert(source.clone(), bytes.to_vec());
        let runs = self.watch.runs(source);
        for (node, contact) in &self.contacts {
            if node == source {
                contact.described().note(&runs);
            }
        }
    }
}

fn lock(followed: &Mutex<FollowedAbouts>) -> MutexGuard<'_, FollowedAbouts> {
    // Each call leaves the state whole: a panic elsewhere does not spoil it.
    followed.lock().unwrap_or_else(PoisonError::into_inner)
}
