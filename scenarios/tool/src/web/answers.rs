//! Responses of a page.

use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::Value;

/// Content security policy: the page loads nothing from elsewhere, and no other page frames it.
// `data:` is for the empty icon: without one a browser asks for `/favicon.ico`.
const POLICY: &str = "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; frame-ancestors 'none'";

/// A part of the page, of this kind.
pub(crate) async fn file(kind: &'static str, text: &'static str) -> Response {
    let kind = format!("{kind}; charset=utf-8");
    let headers = [
        (header::CONTENT_TYPE, kind.as_str()),
        (header::CONTENT_SECURITY_POLICY, POLICY),
        // Another version of the tool at this address has another page.
        (header::CACHE_CONTROL, "no-cache"),
    ];
    (headers, text).into_response()
}

pub(crate) fn as_json(value: &Value) -> Response {
    let headers = [(header::CONTENT_TYPE, "application/json")];
    (headers, value.to_string()).into_response()
}

/// A response with the reason of a failure.
pub(crate) fn wrong(status: StatusCode, why: impl Into<String>) -> Response {
    (status, why.into()).into_response()
}
