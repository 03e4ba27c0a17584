//! The status of a node: JSON, four times a second, and the log lines when its health changes.

mod announcements;
mod facts;
mod health;
mod health_log;
mod unseen;
mod waiting;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use coaxle_clock::Instant;
use coaxle_node::Channel;
use coaxle_node::audit::{AuditDoor, AuditEntry, AuditOutcome};
use coaxle_node::keys::NodeName;
use coaxle_os::machine::Machine;

use serde_json::{Map, Value};

use crate::machine::real_time;
use crate::network::transport::InvisibilityReason;
use crate::node::about::Abouts;
use crate::node::audit::FreshRecord;
use crate::node::circles::CircleSearch;
use crate::node::counters::{Counters, read};
use crate::node::reception::Contact;
use crate::node::session::Session;

use announcements::Announcements;
use facts::{merged, word_for};
pub use health::Health;
use health::{Evidence, judge};
use health_log::{HealthLog, Note, is_in_order};
use unseen::{Inquiry, Search};
use waiting::{last_came, other_axes, others};

/// Identity of the node in its status.
pub(crate) struct Identity {
    pub(crate) name: NodeName,
    pub(crate) role: &'static str,
    pub(crate) epoch: u64,
    /// The followed nodes and the keys of their frames.
    pub(crate) sources: Vec<(NodeName, String)>,
    /// The keys under which this node publishes axes.
    pub(crate) publishes: Vec<String>,
    /// True if access control decides which data pass between the nodes.
    pub(crate) in_secure_network: bool,
    /// Injected faults and simulated inputs, if it was started for an experiment.
    pub(crate) lab: Option<String>,
}

/// Publishes the status and watches the health.
pub(crate) struct Reporter {
    identity: Identity,
    session: Arc<Session>,
    counters: Arc<Counters>,
    granted: Arc<real_time::Outcome>,
    started: Instant<Machine>,
    log: HealthLog,
    /// Search state per source, in the order of the session's contacts.
    searches: Vec<Search>,
    inquiry: Inquiry,
    announcements: Announcements,
    circles: CircleSearch,
    abouts: Abouts,
    /// Search for the reason why no node receives the axes of this one although there is a subscriber.
    unheard: Search,
}

impl Reporter {
    pub(crate) fn new(
        identity: Identity,
        session: Arc<Session>,
        counters: Arc<Counters>,
        granted: Arc<real_time::Outcome>,
        (circles, abouts): (CircleSearch, Abouts),
        started: Instant<Machine>,
    ) -> Self {
        Self {
            searches: session
                .contacts()
                .iter()
                .map(|_| Search::default())
                .collect(),
            identity,
            session,
            counters,
            granted,
            started,
            log: HealthLog::new(started),
            inquiry: Inquiry::default(),
            announcements: Announcements::default(),
            circles,
            abouts,
            unheard: Search::default(),
        }
    }

    /// Publishes the status at `now`, with the recorder's additions, and returns it: JSON.
    pub(crate) fn report(
        &mut self,
        now: Instant<Machine>,
        mut details: Map<String, Value>,
    ) -> String {
        self.look_for_circles(now, &mut details);
        let contradicts = self.compare_descriptions(now, &mut details);
        self.look_for_missing(now);
        self.announce_received_nodes(now);
        self.look_for_hearers(now);
        let (evidence, source) = self.evidence(now);
        // A namesake outranks all others: whose frames arrive is then unknown.
        let health = match (self.session.namesakes(), judge(evidence)) {
            // Refused only while waiting: a node whose frames arrive is not refused, whatever a dial says.
            // Its frames are refused, which looks like their absence.
            (0, _) if contradicts => Health::AxisContradicts,
            (0, Health::Waiting) if self.is_refused(source) => Health::Refused,
            // A subscriber is there, and access control drops the frames at either end.
            (0, Health::Ok) if self.unheard.reason().is_some() => Health::Refused,
            // The least of all: established links are not affected by it.
            (0, Health::Ok) if word_for(Health::Ok, &details) == "ok" && self.is_flooded() => {
                Health::ConnectionFlood
            }
            (0, health) => health,
            _ => Health::NameTaken,
        };
        self.log_health(now, health, (evidence, source), &details);
        self.publish(now, health, details)
    }

    /// Publishes the records of the audit since the last call, and returns them.
    pub(crate) fn take_audit(&self) -> VecDeque<FreshRecord> {
        self.session.take_audit()
    }

    /// Publishes the last status.
    pub(crate) fn report_end(&mut self, now: Instant<Machine>, details: Map<String, Value>) {
        self.publish(now, Health::Stopped, details);
    }

    /// Evidence for the health. A node that follows others needs the frames of all of them; any
    /// other needs a follower. Returns the worst evidence, and the index of its source.
    fn evidence(&self, now: Instant<Machine>) -> (Evidence, usize) {
        let contacts = self.session.contacts().iter();
        let evidence = contacts.map(|contact| evidence_of(contact, now));
        let how_well = |evidence| match judge(evidence) {
            Health::Ok => 2,
            Health::NoData => 1,
            // Evidence shows no other.
            _ => 0,
        };
        let worst = evidence
            .zip(0..)
            // The first of equals, so that the text names the same source each time.
            .min_by_key(|(evidence, _)| how_well(*evidence));
        let any = || self.session.has_follower();
        worst.unwrap_or_else(|| (Evidence::Followers { any: any() }, 0))
    }

    /// Inquires why sources are not visible, one at a time, and logs each confirmed reason.
    fn look_for_missing(&mut self, now: Instant<Machine>) {
        let node = &self.identity.name;
        // `find` is asked first: it takes the finding even if it confirms nothing.
        if let Some((n, found)) = self.inquiry.take()
            && self.searches[n].find(found)
            && let Some(unseen) = self.searches[n].reason()
        {
            let (source, reason) = (&self.identity.sources[n].0, unseen.reason());
            match unseen {
                InvisibilityReason::Refused(_) => {
                    tracing::error!(%node, "node {source} is not to be seen: {reason}");
                    let entry = refused_right(Some(node), "follow").on(source.as_str());
                    self.session.note(entry.because(reason));
                }
                InvisibilityReason::Unreachable(_) => {
                    tracing::warn!(%node, "node {source} is not to be seen: {reason}")
                }
            }
        }
        for (n, contact) in self.session.contacts().iter().enumerate() {
            let is_seen = judge(evidence_of(contact, now)) != Health::Waiting;
            // A single dial at a time: a list of dead addresses would start a thread for each.
            if self.searches[n].is_due(now, is_seen) && !self.inquiry.is_open() {
                let (source, transport) = (&self.identity.sources[n].0, self.session.transport());
                self.searches[n].ask(now);
                self.inquiry.open(n, source, transport);
            }
        }
    }

    /// Announces for each source whether all followed frames of it arrive.
    fn announce_received_nodes(&mut self, now: Instant<Machine>) {
        let mut heard = BTreeMap::new();
        let sources = self.identity.sources.iter().zip(self.session.contacts());
        for ((source, _), contact) in sources {
            // Several channels of one node count together: it is heard only if all of them arrive.
            *heard.entry(source).or_insert(true) &= judge(evidence_of(contact, now)) == Health::Ok;
        }
        let transport = &**self.session.transport();
        for (source, is_heard) in heard {
            self.announcements
                .announce(source, is_heard, &self.identity.name, transport);
        }
    }

    fn look_for_circles(&mut self, now: Instant<Machine>, details: &mut Map<String, Value>) {
        let (sources, contacts) = (&self.identity.sources, self.session.contacts());
        self.circles.look(now, details, |node| {
            let mut of_node = sources
                .iter()
                .zip(contacts)
                .filter(|((of, _), _)| of == node);
            of_node.any(|(_, contact)| judge(evidence_of(contact, now)) == Health::Ok)
        });
    }

    /// Publishes the own description, and compares the config with those of the followed nodes. Returns true if one
    /// contradicts.
    fn compare_descriptions(
        &mut self,
        now: Instant<Machine>,
        details: &mut Map<String, Value>,
    ) -> bool {
        self.abouts.own.publish(now);
        self.abouts.others.look(details)
    }

    /// Outside a secure network all data pass, and a listener need not announce itself.
    fn look_for_hearers(&mut self, now: Instant<Machine>) {
        if !self.identity.in_secure_network {
            return;
        }
        // Without a subscriber the health is waiting already.
        let is_well = !self.session.has_follower() || !self.session.seen_by().is_empty();
        if !self.unheard.is_due(now, is_well) {
            return;
        }
        self.unheard.ask(now);
        let reason = format!(
            "somebody subscribes to {}, and nobody says that anything arrives: the zenoh.json5 of one of \
             the two gives no rights to the other",
            self.identity.publishes.join(", ")
        );
        if self
            .unheard
            .find(Some(InvisibilityReason::Refused(reason.clone())))
        {
            tracing::error!(node = %self.identity.name, "{reason}");
            // The subscriber is not known by name.
            self.session
                .note(refused_right(None, "follow").because(&reason));
        }
    }

    fn is_refused(&self, source: usize) -> bool {
        let search = self.searches.get(source);
        matches!(
            // `Unreachable` may end by itself, a refusal does not.
            search.and_then(Search::reason),
            Some(InvisibilityReason::Refused(_))
        )
    }

    fn is_flooded(&self) -> bool {
        let refused = self.session.transport().refused_connections();
        refused.is_some_and(|refused| refused.flood_from.is_some())
    }

    fn publish(
        &self,
        now: Instant<Machine>,
        health: Health,
        details: Map<String, Value>,
    ) -> String {
        let status = Value::Object(merged(self.facts(now), health, details)).to_string();
        self.session.publish_status(status.clone());
        status
    }

    fn log_health(
        &mut self,
        now: Instant<Machine>,
        health: Health,
        evidence: (Evidence, usize),
        details: &Map<String, Value>,
    ) {
        let word = word_for(health, details);
        let Some(note) = self.log.next(now, health, &word) else {
            return;
        };
        let node = &self.identity.name;
        let wanted = self.wanted(evidence, now);
        match note {
            // First of all: the health may be good, and the name taken nevertheless.
            _ if health == Health::NameTaken => tracing::error!(
                %node,
                "another node has the name {:?}, too: its followers keep to the one that was there first; \
                 give one of them another name, or end it",
                node.as_str()
            ),
            // The listener itself logs the flood, with its origin.
            Note::Changed if is_in_order(health) => tracing::info!(%node, "health is {word}"),
            // The line of the contradiction has both values.
            Note::Changed if health == Health::AxisContradicts => {
                tracing::warn!(%node, "health is {word}");
            }
            Note::Changed => tracing::warn!(%node, "health is {word}: needs {wanted}"),
            Note::StillWaiting => tracing::warn!(%node, "still {word}: needs {wanted}"),
        }
    }

    /// Text on the data that an unhealthy node lacks.
    fn wanted(&self, (evidence, source): (Evidence, usize), now: Instant<Machine>) -> String {
        let running = now - self.started;
        let endpoints = self.session.whereabouts();
        match (self.identity.sources.get(source), evidence) {
            (Some((node, key)), Evidence::Source { alive: true, age }) => {
                let refused = read(&self.counters.refused);
                let other_axes = other_axes(&self.session.contacts()[source].other_axes());
                // Neither a good frame nor a refused one, and yet it is alive.
                let hint = match age.is_none() && refused == 0 {
                    // Few receivers publish them.
                    true if *key == node.channel_key(Channel::FarAxes) => {
                        "; is `publish-far-axes = true` in its config?"
                    }
                    // Access control drops them unseen.
                    true if self.identity.in_secure_network => {
                        "; if its cycle runs, the zenoh.json5 of one of the two gives no rights to the other"
                    }
                    _ => "",
                };
                format!(
                    "good frames on {key}, {}; node {node} is alive, {refused} of its frames were refused{other_axes}{hint}",
                    last_came(age, running)
                )
            }
            (Some((node, key)), evidence) => {
                let last_came = match evidence {
                    Evidence::Source { age, .. } => last_came(age, running),
                    Evidence::Followers { .. } => String::new(),
                };
                let reason = self.searches[source]
                    .reason()
                    .map(InvisibilityReason::reason);
                let reason = reason.map_or_else(String::new, |reason| format!("; {reason}"));
                let others = others(node, &self.session.neighbours());
                format!(
                    "node {node}, whose frames come on {key}, {last_came}; {endpoints}{others}{reason}"
                )
            }
            (None, Evidence::Followers { any: true }) => format!(
                "somebody who hears {}; {endpoints}",
                self.identity.publishes.join(", ")
            ),
            (None, _) => format!(
                "somebody who subscribes to {}; {endpoints}",
                self.identity.publishes.join(", ")
            ),
        }
    }
}

fn evidence_of(contact: &Contact, now: Instant<Machine>) -> Evidence {
    Evidence::Source {
        alive: contact.is_alive(),
        age: contact.frame_age(now),
    }
}

fn refused_right(of: Option<&NodeName>, action: &str) -> AuditEntry {
    let of = of.map(NodeName::as_str);
    AuditEntry::new(AuditDoor::Right, of, action, AuditOutcome::Refused)
}
