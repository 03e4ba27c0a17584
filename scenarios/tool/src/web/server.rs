//! Connections to a page.

use std::convert::Infallible;
use std::io::ErrorKind;
use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Request, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpStream;

use super::answers::{Response, wrong};
use super::guard;
use super::request::WebRequest;

/// Pause after a connection that could not be accepted for lack of something, such as open files.
const PAUSE: Duration = Duration::from_secs(1);

/// Responses of a page to its requests.
pub(crate) trait Routes: Send + Sync + 'static {
    /// Responds to a request that is admitted.
    fn respond(&self, request: WebRequest) -> impl Future<Output = Response> + Send;
}

/// Serves each connection in a task of its own.
pub(super) async fn serve(listener: TcpListener, routes: impl Routes) {
    let listener = match tokio::net::TcpListener::from_std(listener) {
        Ok(listener) => listener,
        Err(error) => return tracing::error!("the page is gone: {error}"),
    };
    let routes = Arc::new(routes);
    loop {
        match listener.accept().await {
            Ok((stream, _)) => drop(tokio::spawn(converse(stream, Arc::clone(&routes)))),
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

async fn converse(stream: TcpStream, routes: Arc<impl Routes>) {
    let service = service_fn(|request| respond(request, Arc::clone(&routes)));
    // With a timer a connection that sends no request ends after half a minute.
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .serve_connection(TokioIo::new(stream), service);
    if let Err(error) = connection.await {
        tracing::debug!(%error, "a connection to the page ended");
    }
}

async fn respond(
    request: Request<Incoming>,
    routes: Arc<impl Routes>,
) -> Result<Response, Infallible> {
    let admitted = guard::check_host(request.headers())
        .and_then(|()| guard::check_change(request.method(), request.headers()));
    if let Err(why) = admitted {
        return Ok(wrong(StatusCode::FORBIDDEN, why));
    }
    Ok(match WebRequest::read(request).await {
        Ok(request) => routes.respond(request).await,
        Err(refused) => refused,
    })
}
