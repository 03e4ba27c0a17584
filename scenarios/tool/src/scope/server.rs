//! Requests of the page, and their responses.

use std::sync::Arc;
use std::time::Duration;

use coaxle_host::client::{Commander, SeenNode, Watcher};
use coaxle_host::network::transport::{Declared, Transport};
use coaxle_host::node::audit;
use coaxle_node::CommandOrder;
use coaxle_node::audit::{AuditDoor, AuditEntry, AuditOutcome};
use coaxle_node::keys::NodeName;
use coaxle_os::machine;
use coaxle_report::plotting::AXES_JS;
use coaxle_report::print;
use coaxle_topology::PlantAnalysis;
use hyper::StatusCode;
use hyper::body::Bytes;
use serde_json::json;
use tokio::sync::mpsc;

use super::stream::{Blocks, signals_of};
use crate::status;
use crate::topology::live;
use crate::web::{
    BASE_CSS, CSS, HTML, JAVASCRIPT, Response, Routes, SVG, Verb, WebRequest, as_json, file,
    not_found, streamed, whole, wrong,
};

/// The page and the routes of its requests.
pub(super) struct ScopePage {
    pub(super) watcher: Arc<Watcher>,
    /// Absent where commands are off: they are refused.
    pub(super) commander: Option<Arc<Commander>>,
}

impl Routes for ScopePage {
    async fn respond(&self, request: WebRequest) -> Response {
        match (request.verb, request.path().as_slice()) {
            (Verb::Get, [""]) => file(HTML, include_str!("page.html")),
            (Verb::Get, ["base.css"]) => file(CSS, BASE_CSS),
            (Verb::Get, ["page.css"]) => file(CSS, include_str!("page.css")),
            (Verb::Get, ["page.js"]) => file(JAVASCRIPT, include_str!("page.js")),
            (Verb::Get, ["axes.js"]) => file(JAVASCRIPT, AXES_JS),
            (Verb::Get, ["pyramid.js"]) => file(JAVASCRIPT, include_str!("pyramid.js")),
            (Verb::Get, ["plot.js"]) => file(JAVASCRIPT, include_str!("plot.js")),
            (Verb::Get, ["kinds.js"]) => file(JAVASCRIPT, include_str!("kinds.js")),
            (Verb::Get, ["save.js"]) => file(JAVASCRIPT, include_str!("save.js")),
            (Verb::Get, ["nodes"]) => nodes(self),
            (Verb::Get, ["signals", node]) => signals(self, node).await,
            (Verb::Get, ["rows", node]) => rows(self, node, request.field("signals").as_deref()),
            (Verb::Post, ["orders", node]) => order(self, node, &request.body).await,
            (Verb::Get, ["metrics"]) => metrics(self),
            (Verb::Get, ["plant.svg"]) => plant(self).await,
            _ => not_found(),
        }
    }
}

/// The nodes with their statuses.
fn nodes(shared: &ScopePage) -> Response {
    let now = machine::now();
    let one = |node: &SeenNode| {
        let age = node
            .status
            .as_ref()
            .map(|(at, _)| (now - *at).as_secs_f64());
        let status = node.status.as_ref().map(|(_, status)| status);
        json!({ "name": node.name, "is_alive": node.is_alive, "age_s": age, "status": status })
    };
    let seen = shared.watcher.seen();
    let nodes: Vec<_> = seen.iter().map(one).collect();
    as_json(&json!({ "nodes": nodes, "commands": shared.commander.is_some() }))
}

fn metrics(shared: &ScopePage) -> Response {
    let text = status::metrics(&shared.watcher.seen());
    // The version of the text format, by which Prometheus chooses its parser.
    whole("text/plain; version=0.0.4", text + "\n")
}

/// The nodes that run as a picture: who follows whom, and shows it when.
async fn plant(shared: &ScopePage) -> Response {
    let watcher = Arc::clone(&shared.watcher);
    // Each node is asked to describe its axes.
    let drawn = tokio::task::spawn_blocking(move || {
        let nodes = live::described(&watcher, &watcher.seen());
        print::svg_of_plant(&PlantAnalysis::of(&nodes))
    });
    match drawn.await {
        Ok(svg) => whole(SVG, svg),
        Err(_) => wrong(
            StatusCode::INTERNAL_SERVER_ERROR,
            "the picture was not finished",
        ),
    }
}

/// Timeout of the first piece: the node learns of the subscription, and makes one.
// Pieces come every 50 ms; the rest is for a subscription to reach the node over routers.
const FIRST_PIECE: Duration = Duration::from_secs(3);
/// Most pieces that wait for a browser: those of three seconds.
// 64 pieces of 50 ms are 3.2 s.
const MOST_PIECES: usize = 64;

/// Signals of a node.
async fn signals(shared: &ScopePage, node: &str) -> Response {
    // Kept until the response is made: dropping it ends the subscription.
    let (mut pieces, _declared) = match subscribe(shared, node) {
        Ok(subscribed) => subscribed,
        Err(refused) => return refused,
    };
    match tokio::time::timeout(FIRST_PIECE, pieces.recv()).await {
        Ok(Some(piece)) => as_json(&json!(signals_of(&piece))),
        _ => wrong(StatusCode::NOT_FOUND, "no row came of this node"),
    }
}

/// Most signals of a node per request.
const MOST_SIGNALS: usize = 1000;

/// The rows of a node from now on, in blocks.
fn rows(shared: &ScopePage, node: &str, wanted: Option<&str>) -> Response {
    let Some(wanted) = wanted else {
        let why = "signals: received none, expected their names, with commas";
        return wrong(StatusCode::BAD_REQUEST, why);
    };
    let wanted: Vec<_> = wanted.split(',').map(str::to_owned).collect();
    if wanted.len() > MOST_SIGNALS {
        let received = wanted.len();
        let why = format!("signals: received {received}, expected at most {MOST_SIGNALS}");
        return wrong(StatusCode::BAD_REQUEST, why);
    }
    let (pieces, declared) = match subscribe(shared, node) {
        Ok(subscribed) => subscribed,
        Err(refused) => return refused,
    };
    // The subscription lives as long as the stream.
    let state = (pieces, declared, Blocks::of(wanted));
    let blocks = futures_util::stream::unfold(state, |(mut pieces, declared, mut blocks)| async {
        loop {
            let piece = pieces.recv().await?;
            if let Some(block) = blocks.block(&piece) {
                return Some((Bytes::from(block), (pieces, declared, blocks)));
            }
        }
    });
    streamed(blocks)
}

#[expect(
    clippy::result_large_err,
    reason = "a response is what is wanted in either case"
)]
fn subscribe(
    shared: &ScopePage,
    node: &str,
) -> Result<(mpsc::Receiver<Vec<u8>>, Declared), Response> {
    let node =
        NodeName::new(node).map_err(|error| wrong(StatusCode::BAD_REQUEST, error.to_string()))?;
    let (queue, pieces) = mpsc::channel(MOST_PIECES);
    let take = move |_, piece: &[u8]| {
        // A browser that does not keep up misses some.
        let _ = queue.try_send(piece.to_vec());
    };
    let transport: &dyn Transport = &**shared.watcher.transport();
    let declared = transport.subscribe(&node.rows_key(), Box::new(take));
    let declared = declared.map_err(|error| {
        let why = format!("{error:#}");
        wrong(StatusCode::BAD_GATEWAY, why)
    })?;
    Ok((pieces, declared))
}

/// Sends an order, and returns the node's response.
async fn order(shared: &ScopePage, node: &str, body: &str) -> Response {
    // First of all: without commands not even a wrong order gets a different answer.
    let Some(commander) = shared.commander.clone() else {
        let why = "commands are off: start it with --commands";
        let entry = AuditEntry::new(AuditDoor::Page, None, "order", AuditOutcome::Refused);
        // On record at the node whose page it is; the scope itself has none.
        audit::note(&entry.on(node).because(why));
        return wrong(StatusCode::FORBIDDEN, why);
    };
    let node = match NodeName::new(node) {
        Ok(node) => node,
        Err(error) => return wrong(StatusCode::BAD_REQUEST, error.to_string()),
    };
    let order = match CommandOrder::from_json(body.as_bytes()) {
        Ok(order) => order,
        Err(error) => return wrong(StatusCode::BAD_REQUEST, error.to_string()),
    };
    // A node may take seconds to respond, and the page has a single worker thread.
    let sent = tokio::task::spawn_blocking(move || commander.send(&node, &order)).await;
    match sent {
        Ok(Ok(answer)) => whole("application/json", answer.to_json()),
        Ok(Err(error)) => wrong(StatusCode::BAD_GATEWAY, format!("{error:#}")),
        Err(error) => wrong(StatusCode::INTERNAL_SERVER_ERROR, error.to_string()),
    }
}
