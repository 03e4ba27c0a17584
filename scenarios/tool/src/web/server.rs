//! Connections to a page.

use std::convert::Infallible;
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;

use coaxle_host::node::audit;
use coaxle_node::audit::{AuditDoor, AuditEntry, AuditOutcome};
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Request, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpStream;

use super::answers::{Response, wrong};
use super::connections::{Connections, CountedBody, CountedResponse, UnderWay};
use super::guard;
use super::request::WebRequest;
use super::token::PageToken;
use super::write_limit::WriteLimit;

/// Longest time for the head of a request to come, and for a connection to send another one.
// A browser sends a head at once, in one packet. It opens an idle connection again when it needs one.
pub(super) const HEAD_TIMEOUT: Duration = Duration::from_secs(5);
/// Pause after a connection that could not be accepted for lack of something, such as open files.
const PAUSE: Duration = Duration::from_secs(1);

/// Responses of a page to its requests.
pub(crate) trait Routes: Send + Sync + 'static {
    /// Responds to a request that is admitted.
    fn respond(&self, request: WebRequest) -> impl Future<Output = Response> + Send;
}

/// A page and what it takes.
struct ServedPage<R> {
    routes: R,
    token: Option<PageToken>,
}

/// Serves each connection in a task of its own, [`MOST_CONNECTIONS`](super::connections::MOST_CONNECTIONS) at a time.
pub(super) async fn serve(listener: TcpListener, token: Option<PageToken>, routes: impl Routes) {
    let listener = match tokio::net::TcpListener::from_std(listener) {
        Ok(listener) => listener,
        Err(error) => return tracing::error!("the page is gone: {error}"),
    };
    let page = Arc::new(ServedPage { routes, token });
    let mut connections = Connections::default();
    loop {
        match listener.accept().await {
            Ok((stream, from)) if connections.make_room().await => {
                let under_way = UnderWay::default();
                let task = converse(stream, from, Arc::clone(&page), under_way.clone());
                connections.add(tokio::spawn(task), under_way);
            }
            // A response is under way on each of the others.
            Ok((stream, _)) => drop(stream.try_write(FULL)),
            Err(error) if is_of_the_browser(error.kind()) => {}
            Err(error) => {
                tracing::warn!("the page accepts no connection: {error}");
                tokio::time::sleep(PAUSE).await;
            }
        }
    }
}

/// True for connections that ended before they were accepted.
fn is_of_the_browser(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::ConnectionAborted | ErrorKind::ConnectionReset | ErrorKind::ConnectionRefused
    )
}

/// The response to a connection beyond the last one.
const FULL: &[u8] =
    b"HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nContent-Length: 0\r\n\r\n";

async fn converse(
    stream: TcpStream,
    from: SocketAddr,
    page: Arc<ServedPage<impl Routes>>,
    under_way: UnderWay,
) {
    let service = service_fn(|request| {
        let counted = under_way.count();
        respond(request, from, Arc::clone(&page), counted)
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .serve_connection(TokioIo::new(WriteLimit::of(stream)), service);
    if let Err(error) = connection.await {
        tracing::debug!(%error, "a connection to the page ended");
    }
}

async fn respond(
    request: Request<Incoming>,
    from: SocketAddr,
    page: Arc<ServedPage<impl Routes>>,
    counted: CountedResponse,
) -> Result<hyper::Response<CountedBody>, Infallible> {
    let response = response(request, from, &page).await;
    Ok(response.map(|body| CountedBody::of(body, counted)))
}

async fn response(
    request: Request<Incoming>,
    from: SocketAddr,
    page: &ServedPage<impl Routes>,
) -> Response {
    let token = page.token.as_ref();
    let admitted = guard::check_host(request.headers())
        .and_then(|()| guard::check_change(request.method(), request.headers(), token));
    if let Err(why) = admitted {
        note_refusal(&request, from, &why);
        return wrong(StatusCode::FORBIDDEN, why);
    }
    match WebRequest::read(request).await {
        Ok(request) => page.routes.respond(request).await,
        Err(refused) => refused,
    }
}

/// Notes a refused request in the audit of the node whose page it is.
fn note_refusal(request: &Request<Incoming>, from: SocketAddr, why: &str) {
    let action = format!("{} {}", request.method(), request.uri().path());
    let from = from.to_string();
    let entry = AuditEntry::new(AuditDoor::Page, Some(&from), &action, AuditOutcome::Refused);
    audit::note(&entry.because(why));
}
