//! Responses of a page.

use std::convert::Infallible;

use futures_util::{Stream, StreamExt};
use http_body_util::combinators::UnsyncBoxBody;
use http_body_util::{BodyExt, Full, StreamBody};
use hyper::StatusCode;
use hyper::body::{Bytes, Frame};
use hyper::header::{self, HeaderName, HeaderValue};
use serde_json::Value;

/// A response, its body whole or as it comes.
pub(crate) type Response = hyper::Response<UnsyncBoxBody<Bytes, Infallible>>;

/// A document.
pub(crate) const HTML: &str = "text/html; charset=utf-8";
/// A style sheet.
pub(crate) const CSS: &str = "text/css; charset=utf-8";
/// A script.
pub(crate) const JAVASCRIPT: &str = "text/javascript; charset=utf-8";
/// A picture.
pub(crate) const SVG: &str = "image/svg+xml";

/// Content security policy: the page loads nothing from elsewhere, and no other page frames it.
// `data:` is for the empty icon: without one a browser asks for `/favicon.ico`.
const POLICY: &str = "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; frame-ancestors 'none'";

/// A part of the page, of this kind.
pub(crate) fn file(kind: &'static str, text: &'static str) -> Response {
    let response = with(whole(kind, text), header::CONTENT_SECURITY_POLICY, POLICY);
    // Another version of the tool at this address has another page.
    with(response, header::CACHE_CONTROL, "no-cache")
}

pub(crate) fn as_json(value: &Value) -> Response {
    whole("application/json", value.to_string())
}

/// A body of this kind.
pub(crate) fn whole(kind: &'static str, body: impl Into<Bytes>) -> Response {
    let body = Full::new(body.into()).boxed_unsync();
    with(Response::new(body), header::CONTENT_TYPE, kind)
}

/// Blocks of bytes as they come, kept by nobody.
pub(crate) fn streamed(blocks: impl Stream<Item = Bytes> + Send + 'static) -> Response {
    let body = StreamBody::new(blocks.map(|block| Ok(Frame::data(block)))).boxed_unsync();
    let kind = "application/octet-stream";
    let response = with(Response::new(body), header::CONTENT_TYPE, kind);
    with(response, header::CACHE_CONTROL, "no-store")
}

/// A response with the reason of a failure.
pub(crate) fn wrong(status: StatusCode, why: impl Into<String>) -> Response {
    let mut response = whole("text/plain; charset=utf-8", why.into());
    *response.status_mut() = status;
    response
}

/// The response to a request that the page does not have.
pub(crate) fn not_found() -> Response {
    wrong(StatusCode::NOT_FOUND, "")
}

/// The response to methods other than these.
pub(super) fn method_not_allowed(allowed: &'static str) -> Response {
    let response = wrong(StatusCode::METHOD_NOT_ALLOWED, "");
    with(response, header::ALLOW, allowed)
}

fn with(mut response: Response, name: HeaderName, value: &'static str) -> Response {
    let value = HeaderValue::from_static(value);
    response.headers_mut().insert(name, value);
    response
}
