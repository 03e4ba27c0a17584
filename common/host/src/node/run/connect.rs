//! The connection of a node to others: what it publishes, what it subscribes to, its requests.

use std::sync::Arc;

use coaxle_node::Node;
use coaxle_node::circles::CircleChange;
use rtrb::Consumer;

use super::rings::IncomingEnds;
use super::{RunContext, Setup};
use crate::network::credentials::{OLD_TIMING_KEY_FILE, TIMING_KEYS_FILE, timing_keys};
use crate::network::transport::{Declared, Transport, Urgency};
use crate::node::about::Abouts;
use crate::node::circles::CircleSearch;
use crate::node::publisher::PublishedChannel;
use crate::node::session::Session;
use crate::node::timing::{SecuredBeacons, TimingChannel};

/// A node on its transport.
pub(super) struct Connected {
    pub(super) session: Arc<Session>,
    pub(super) channels: Vec<PublishedChannel>,
    pub(super) timing: Option<TimingChannel>,
    pub(super) circle_search: CircleSearch,
    pub(super) abouts: Abouts,
    pub(super) circles: Consumer<CircleChange>,
    /// Service that runs on the transport.
    pub(super) service: Option<Declared>,
}

/// Declares everything that the node publishes, receives and serves.
pub(super) fn connect<N: Node>(
    setup: &mut Setup<N>,
    run: &RunContext,
    transport: Arc<dyn Transport>,
    incoming: IncomingEnds,
) -> anyhow::Result<Connected> {
    let IncomingEnds {
        inboxes,
        requests,
        circle_names,
    } = incoming;
    let service = setup.transport_service.take();
    let service = service.map(|service| (service.start)(Arc::clone(&transport)));
    let service = service.transpose()?;
    // Bulk: rows for viewers never delay a frame.
    let rows = transport.publisher(&run.name.rows_key(), Urgency::Bulk)?;
    setup.recorder.begin(run.epoch, rows);
    let mut session = Session::open(transport, &run.name, run.epoch, run.panics.clone())?;
    let channels = session.publish(&setup.wiring.publications, setup.seed)?;
    let mut timing = timing_channel(setup)?;
    for (subscription, inbox) in setup.wiring.subscriptions.iter().zip(inboxes) {
        // Beacons come over a socket of their own. Without a timing channel nobody sends any.
        if !subscription.channel.is_timing() {
            let counters = Arc::clone(&run.counters);
            session.subscribe(subscription, setup.seed, inbox, counters)?;
        } else if let Some(timing) = &mut timing {
            timing.receive(subscription, setup.seed, inbox, &run.counters)?;
        }
    }
    session.take_orders(&run.name, requests)?;
    session.serve_audit(&run.name, run.audit.clone())?;
    session.watch_receivers(&run.name)?;
    // Access control gives no node the right to list all others.
    if setup.transport.secure.is_none() {
        session.watch_neighbours(&run.name)?;
    }
    let session = Arc::new(session);
    let (circle_search, circles) = CircleSearch::open(
        &run.name,
        &setup.wiring.subscriptions,
        circle_names,
        &**session.transport(),
    )?;
    let (plant, heard) = (setup.plant.clone(), &setup.wiring.subscriptions);
    let abouts = Abouts::open(plant, run.epoch, heard, &session)?;
    Ok(Connected {
        session,
        channels,
        timing,
        circle_search,
        abouts,
        circles,
        service,
    })
}

/// The timing channel of the node, if configured and permitted.
fn timing_channel<N: Node>(setup: &Setup<N>) -> anyhow::Result<Option<TimingChannel>> {
    // Without a configured endpoint there is no socket at all.
    if setup.timing.is_none() {
        return Ok(None);
    }
    let mut keys = None;
    // A plain network has no keys: its beacons carry a check sum, as its frames do.
    if let Some(folder) = &setup.transport.secure {
        let subscribed = setup.wiring.subscriptions.iter().map(|it| &it.node);
        let published = setup.wiring.publications.iter().map(|it| &it.node);
        let others = subscribed.chain(published).filter(|it| **it != setup.name);
        let Some(found) = timing_keys(folder, &setup.name, others)? else {
            // A channel without authentication would let any datagram move the clock of a secured node.
            tracing::warn!(
                node = %setup.name,
                "the timing channel stays off: {} has no {TIMING_KEYS_FILE} to authenticate beacons with; \
                 `coaxle secure renew` writes it",
                folder.display()
            );
            return Ok(None);
        };
        if found.from_shared_secret {
            tracing::warn!(
                node = %setup.name,
                "{} has the {OLD_TIMING_KEY_FILE} of all nodes, by which any of them can forge the beacons of \
                 every other: `coaxle secure renew` writes keys of each pair instead",
                folder.display()
            );
        }
        keys = Some(SecuredBeacons::new(found.keys, folder));
    }
    TimingChannel::open(
        &setup.name,
        &setup.timing,
        &setup.wiring.publications,
        setup.seed,
        keys,
    )
    .map(Some)
}
