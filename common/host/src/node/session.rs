//! A node's declarations on its transport: its channels, its status, its presence, and the
//! subscriptions for frames and requests.

use std::collections::{BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};

use coaxle_clock::Instant;
use coaxle_node::CommandAnswer;
use coaxle_node::audit::{AuditEntry, AuditQuery};
use coaxle_node::command::InvalidOrder;
use coaxle_node::frame::KeySeal;
use coaxle_node::keys::{ANY_ALIVE_KEY, NodeName};
use coaxle_node::wiring::{Publication, Subscription};
use coaxle_os::machine::Machine;
use serde_json::json;

use crate::network::transport::{
    Declared, PresenceHandler, Publisher, Request, Transport, Urgency,
};
use crate::node::audit::{Audit, FreshRecord};
use crate::node::commands::{RequestSender, ambiguous, answer};
use crate::node::counters::Counters;
use crate::node::faults::Faults;
use crate::node::mailbox::Inbox;
use crate::node::panics::PanicWatch;
use crate::node::publisher::PublishedChannel;
use crate::node::reception::{Contact, Reception};

/// A node on its transport, with all its declarations.
pub(crate) struct Session {
    transport: Arc<dyn Transport>,
    /// Publishers of axes; the subscribers follow the node.
    axes: Vec<Arc<dyn Publisher>>,
    status: Box<dyn Publisher>,
    declared: Vec<Declared>,
    /// State of each followed node.
    contacts: Vec<Arc<Contact>>,
    /// Other runs under the name of this node.
    namesakes: Keys,
    /// Announcements of the nodes that receive the axes of this node.
    seen_by: Keys,
    /// Other nodes, where access control permits listing them.
    neighbours: Keys,
    /// The audit, and the publisher of its records.
    audit: Option<(Audit, Box<dyn Publisher>)>,
    panics: PanicWatch,
}

/// Keys that are announced.
type Keys = Arc<Mutex<BTreeSet<String>>>;

impl Session {
    /// Announces the node and this run of it, and watches for other runs under its name.
    ///
    /// # Errors
    /// The transport refuses.
    pub(crate) fn open(
        transport: Arc<dyn Transport>,
        name: &NodeName,
        epoch: u64,
        panics: PanicWatch,
    ) -> anyhow::Result<Self> {
        let status = transport.publisher(&name.status_key(), Urgency::Ordinary)?;
        let alive = transport.announce(&name.alive_key())?;
        let run = transport.announce(&name.run_key(epoch))?;
        let namesakes = Arc::default();
        // The own run is announced before it is watched, so that its own token would be seen.
        let on_change = keeping(Arc::clone(&namesakes), Some(name.run_key(epoch)));
        // By run and not by name: both nodes of one name have the same `alive` key.
        let watched = transport.watch(&name.runs_key(), on_change)?;
        Ok(Self {
            transport,
            axes: Vec::new(),
            status,
            declared: vec![alive, run, watched],
            contacts: Vec::new(),
            namesakes,
            seen_by: Arc::default(),
            neighbours: Arc::default(),
            audit: None,
            panics,
        })
    }

    /// Number of visible other nodes with this name: no network forwards between two peers.
    pub(crate) fn namesakes(&self) -> usize {
        let namesakes = self.namesakes.lock();
        namesakes.unwrap_or_else(PoisonError::into_inner).len()
    }

    /// Watches for nodes that receive the axes of this node, `name`, if it publishes any.
    pub(crate) fn watch_receivers(&mut self, name: &NodeName) -> anyhow::Result<()> {
        // A node that publishes no axes has no key that others would announce themselves under.
        if self.axes.is_empty() {
            return Ok(());
        }
        let on_change = keeping(Arc::clone(&self.seen_by), None);
        let watched = self.transport.watch(&name.seen_by_keys(), on_change)?;
        self.declared.push(watched);
        Ok(())
    }

    /// Watches for other nodes.
    pub(crate) fn watch_neighbours(&mut self, name: &NodeName) -> anyhow::Result<()> {
        let on_change = keeping(Arc::clone(&self.neighbours), Some(name.alive_key()));
        let watched = self.transport.watch(ANY_ALIVE_KEY, on_change)?;
        self.declared.push(watched);
        Ok(())
    }

    /// Names of the other visible nodes, in order; empty where access control forbids it.
    pub(crate) fn neighbours(&self) -> Vec<String> {
        let names = names(&self.neighbours, NodeName::of_key);
        names.iter().map(NodeName::to_string).collect()
    }

    /// Names of the nodes that announce to receive the axes of this node, in order.
    pub(crate) fn seen_by(&self) -> Vec<String> {
        names(&self.seen_by, |key| {
            // The last part of the key is the name of the receiver.
            key.rsplit('/').next().map(str::to_owned)
        })
    }

    /// Declares the channels that the node publishes.
    pub(crate) fn publish(
        &mut self,
        publications: &[Publication],
        seed: u64,
    ) -> anyhow::Result<Vec<PublishedChannel>> {
        let mut channels = Vec::new();
        // Beacons do not pass through the transport.
        for publication in publications.iter().filter(|p| !p.channel.is_timing()) {
            let channel = publication.channel;
            let key = publication.node.channel_key(channel);
            let publisher = Arc::from(self.transport.publisher(&key, Urgency::RealTime)?);
            // Shared with the publish thread: here it only says whether there is a subscriber.
            if channel.carries_axes() {
                self.axes.push(Arc::clone(&publisher));
            }
            channels.push(PublishedChannel {
                channel,
                far: publication.far,
                // The key is part of the check sum: a frame under a foreign key is refused.
                seal: KeySeal::new(&key),
                publisher,
                faults: Faults::new(&publication.faults, seed, &key, channel, publication.far)?,
            });
        }
        Ok(channels)
    }

    /// Subscribes to a channel: its messages go to `inbox`. A source of axes is added to
    /// [`Self::contacts`].
    pub(crate) fn subscribe(
        &mut self,
        subscription: &Subscription,
        seed: u64,
        inbox: Inbox,
        counters: Arc<Counters>,
    ) -> anyhow::Result<()> {
        let channel = subscription.channel;
        let contact = Contact::new();
        let key = subscription.node.channel_key(channel);
        let mut reception =
            Reception::new(subscription, seed, inbox, Arc::clone(&contact), counters)?;
        let panics = self.panics.clone();
        let on_bytes = move |arrival, bytes: &[u8]| {
            // The thread is the transport's own: a panic there would end nothing by itself.
            let _watched = panics.over("receive");
            reception.take(arrival, bytes);
        };
        let frames = self.transport.subscribe(&key, Box::new(on_bytes))?;
        // Frames before presence: a node that is seen alive is heard as well.
        self.declared.push(frames);
        // Requests and responses come from nodes whose axes have a contact already.
        if channel.carries_axes() {
            self.watch(&subscription.node, Arc::clone(&contact))?;
            self.contacts.push(contact);
        }
        Ok(())
    }

    /// Takes orders, of operators and of unnamed clients, and hands them to `requests`.
    pub(crate) fn take_orders(
        &mut self,
        name: &NodeName,
        requests: RequestSender,
    ) -> anyhow::Result<()> {
        let orders = Arc::new(Orders {
            key: name.command_key(),
            requests,
        });
        // With certificates the operator's name is a part of the key, on which access control acts.
        for key in [name.command_key(), name.operator_command_keys()] {
            let orders = Arc::clone(&orders);
            let on_request = move |arrival, request| orders.take(arrival, request);
            let served = self.transport.serve(&key, Box::new(on_request))?;
            self.declared.push(served);
        }
        Ok(())
    }

    /// Publishes the records of the audit from now on, and answers queries of the newest ones.
    pub(crate) fn serve_audit(&mut self, name: &NodeName, audit: Audit) -> anyhow::Result<()> {
        let key = name.audit_key();
        let publisher = self.transport.publisher(&key, Urgency::Ordinary)?;
        let asked = audit.clone();
        let on_request =
            move |_, request: Box<dyn Request>| match AuditQuery::from_json(&request.payload()) {
                Ok(query) => request.reply(asked.excerpt(&query).to_json(), true),
                Err(error) => {
                    request.reply(json!({ "error": error.to_string() }).to_string(), false)
                }
            };
        let served = self.transport.serve(&key, Box::new(on_request))?;
        self.declared.push(served);
        self.audit = Some((audit, publisher));
        Ok(())
    }

    /// Notes an entry in the audit, if it is served.
    pub(crate) fn note(&self, entry: AuditEntry) {
        if let Some((audit, _)) = &self.audit {
            audit.note(entry);
        }
    }

    /// Publishes the records of the audit since the last call, and returns them.
    pub(crate) fn take_audit(&self) -> VecDeque<FreshRecord> {
        let Some((audit, publisher)) = &self.audit else {
            return VecDeque::new();
        };
        let fresh = audit.take();
        for (_, record) in &fresh {
            if let Err(error) = publisher.publish(record.to_json().into_bytes()) {
                tracing::debug!(%error, "the transport refused a record of the audit");
            }
        }
        fresh
    }

    fn watch(&mut self, source: &NodeName, contact: Arc<Contact>) -> anyhow::Result<()> {
        let on_change = move |_: &str, alive| contact.set_alive(alive);
        let watched = self
            .transport
            .watch(&source.alive_key(), Box::new(on_change))?;
        self.declared.push(watched);
        Ok(())
    }

    /// True if the axes of this node have a subscriber.
    pub(crate) fn has_follower(&self) -> bool {
        self.axes.iter().any(|publisher| publisher.has_subscriber())
    }

    /// State of each followed node, in the order of the subscriptions.
    pub(crate) fn contacts(&self) -> &[Arc<Contact>] {
        &self.contacts
    }

    /// Publishes the status; a failure is only logged.
    pub(crate) fn publish_status(&self, json: String) {
        if let Err(error) = self.status.publish(json.into_bytes()) {
            tracing::debug!(%error, "the transport refused the status");
        }
    }

    /// The transport, for callers that may wait for it.
    pub(crate) const fn transport(&self) -> &Arc<dyn Transport> {
        &self.transport
    }

    /// Endpoints of the transport, for messages.
    pub(crate) fn whereabouts(&self) -> &str {
        self.transport.whereabouts()
    }

    /// Leaves the network.
    pub(crate) fn close(&self) {
        self.transport.close();
    }
}

/// The path of orders; the sender's name is in the key.
struct Orders {
    key: String,
    requests: RequestSender,
}

impl Orders {
    fn take(&self, arrival: Instant<Machine>, request: Box<dyn Request>) {
        match self.given_by(request.key()) {
            Some(by) => self.requests.send(arrival, request, by),
            // A request under `coaxle/*/command` is meant for many nodes, and an order for a single one.
            None => {
                let received = request.key().to_owned();
                let many = InvalidOrder::AmbiguousKey { received };
                let refusal = CommandAnswer::malformed(&many);
                answer(&*request, &refusal);
                (self.requests.audit()).note(ambiguous(request.key(), &refusal));
            }
        }
    }

    /// Operator named in the key of an order, if any; none if this is not the key of an order.
    fn given_by(&self, key: &str) -> Option<Option<NodeName>> {
        let operator = key.strip_prefix(&self.key)?;
        if operator.is_empty() {
            return Some(None);
        }
        // `command-x` is no key of orders.
        let operator = operator.strip_prefix('/')?;
        NodeName::new(operator).ok().map(Some)
    }
}

/// Names in announced keys.
fn names<T>(keys: &Keys, name: impl Fn(&str) -> Option<T>) -> Vec<T> {
    let keys = keys.lock().unwrap_or_else(PoisonError::into_inner);
    keys.iter().filter_map(|key| name(key)).collect()
}

/// Keeps the set of announced keys other than the own one. A key may be reported more than once.
fn keeping(keys: Keys, own: Option<String>) -> PresenceHandler {
    Box::new(move |key, is_there| {
        let mut keys = keys.lock().unwrap_or_else(PoisonError::into_inner);
        if own.as_deref() != Some(key) && is_there {
            keys.insert(key.to_owned());
        } else {
            // The own key was never inserted, so that its removal changes nothing.
            keys.remove(key);
        }
    })
}
