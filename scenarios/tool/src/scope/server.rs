//! Requests of the page, and their responses.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{Path, Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use coaxle_host::client::{Commander, SeenNode, Watcher};
use coaxle_host::network::transport::{Declared, Transport};
use coaxle_node::keys::NodeName;
use coaxle_node::{CommandAnswer, CommandOrder};
use coaxle_os::machine;
use coaxle_report::plotting::AXES_JS;
use serde::Deserialize;
use serde_json::json;
use tokio::sync::mpsc;

use super::stream::{Blocks, signals_of};
use crate::status;
use crate::web::{BASE_CSS, as_json, file, wrong};

/// The page and the routes of its requests; without a commander, commands are refused.
pub(super) fn routes(watcher: Arc<Watcher>, commander: Option<Commander>) -> Router {
    with_state(ScopeState {
        watcher,
        commander: commander.map(Arc::new),
    })
}

#[derive(Clone)]
struct ScopeState {
    watcher: Arc<Watcher>,
    /// Absent where commands are off.
    commander: Option<Arc<Commander>>,
}

fn with_state(state: ScopeState) -> Router {
    Router::new()
        .route("/", get(|| file("text/html", include_str!("page.html"))))
        .route("/base.css", get(|| file("text/css", BASE_CSS)))
        .route(
            "/page.css",
            get(|| file("text/css", include_str!("page.css"))),
        )
        .route(
            "/page.js",
            get(|| file("text/javascript", include_str!("page.js"))),
        )
        .route("/axes.js", get(|| file("text/javascript", AXES_JS)))
        .route(
            "/pyramid.js",
            get(|| file("text/javascript", include_str!("pyramid.js"))),
        )
        .route(
            "/plot.js",
            get(|| file("text/javascript", include_str!("plot.js"))),
        )
        .route("/nodes", get(nodes))
        .route("/signals/{node}", get(signals))
        .route("/rows/{node}", get(rows))
        .route("/orders/{node}", post(order))
        .route("/metrics", get(metrics))
        .with_state(state)
}

/// The nodes with their statuses.
async fn nodes(State(shared): State<ScopeState>) -> Response {
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

async fn metrics(State(shared): State<ScopeState>) -> Response {
    // The version of the text format, by which Prometheus chooses its parser.
    let headers = [(header::CONTENT_TYPE, "text/plain; version=0.0.4")];
    let text = status::metrics(&shared.watcher.seen());
    (headers, text + "\n").into_response()
}

/// Timeout of the first piece: the node learns of the subscription, and makes one.
// Pieces come every 50 ms; the rest is for a subscription to reach the node over routers.
const FIRST_PIECE: Duration = Duration::from_secs(3);
/// Most pieces that wait for a browser: those of three seconds.
// 64 pieces of 50 ms are 3.2 s.
const MOST_PIECES: usize = 64;

/// Signals of a node.
async fn signals(State(shared): State<ScopeState>, Path(node): Path<String>) -> Response {
    // Kept until the response is made: dropping it ends the subscription.
    let (mut pieces, _declared) = match subscribe(&shared, node) {
        Ok(subscribed) => subscribed,
        Err(refused) => return refused,
    };
    match tokio::time::timeout(FIRST_PIECE, pieces.recv()).await {
        Ok(Some(piece)) => as_json(&json!(signals_of(&piece))),
        _ => wrong(StatusCode::NOT_FOUND, "no row came of this node"),
    }
}

#[derive(Deserialize)]
struct Wanted {
    /// Names of signals, with commas.
    signals: String,
}

/// Most signals of a node per request.
const MOST_SIGNALS: usize = 1000;

/// The rows of a node from now on, in blocks.
async fn rows(
    State(shared): State<ScopeState>,
    Path(node): Path<String>,
    Query(wanted): Query<Wanted>,
) -> Response {
    let wanted: Vec<_> = wanted.signals.split(',').map(str::to_owned).collect();
    if wanted.len() > MOST_SIGNALS {
        let received = wanted.len();
        let why = format!("signals: received {received}, expected at most {MOST_SIGNALS}");
        return wrong(StatusCode::BAD_REQUEST, why);
    }
    let (pieces, declared) = match subscribe(&shared, node) {
        Ok(subscribed) => subscribed,
        Err(refused) => return refused,
    };
    // The subscription lives as long as the stream.
    let state = (pieces, declared, Blocks::of(wanted));
    let blocks = futures_util::stream::unfold(state, |(mut pieces, declared, mut blocks)| async {
        loop {
            let piece = pieces.recv().await?;
            if let Some(block) = blocks.block(&piece) {
                let block = Ok::<_, Infallible>(Bytes::from(block));
                return Some((block, (pieces, declared, blocks)));
            }
        }
    });
    let headers = [
        (header::CONTENT_TYPE, "application/octet-stream"),
        // A stream without an end would fill the browser's cache.
        (header::CACHE_CONTROL, "no-store"),
    ];
    (headers, Body::from_stream(blocks)).into_response()
}

#[expect(
    clippy::result_large_err,
    reason = "a response is what is wanted in either case"
)]
fn subscribe(
    shared: &ScopeState,
    node: String,
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
async fn order(
    State(shared): State<ScopeState>,
    Path(node): Path<String>,
    body: String,
) -> Response {
    // First of all: without commands not even a wrong order gets a different answer.
    let Some(commander) = shared.commander else {
        let why = "commands are off: start it with --commands";
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
        Ok(Ok(answer)) => answered(&answer),
        Ok(Err(error)) => wrong(StatusCode::BAD_GATEWAY, format!("{error:#}")),
        Err(error) => wrong(StatusCode::INTERNAL_SERVER_ERROR, error.to_string()),
    }
}

fn answered(answer: &CommandAnswer) -> Response {
    let headers = [(header::CONTENT_TYPE, "application/json")];
    (headers, answer.to_json()).into_response()
}
