//! Requests of a page, read to their end.

use std::time::Duration;

use http_body_util::{BodyExt, LengthLimitError, Limited};
use hyper::body::Incoming;
use hyper::{Method, Request, StatusCode};

use super::answers::{Response, method_not_allowed, wrong};

/// Greatest body of a request, bytes.
pub(super) const MOST_BODY_BYTES: usize = 2 << 20;
/// Longest time for a body to come.
// 2 MiB at 2 Mbit/s, over a network that is as slow as any that shows a page.
pub(super) const BODY_TIMEOUT: Duration = Duration::from_secs(10);

/// Kind of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verb {
    /// Read something.
    Get,
    /// Change something.
    Post,
}

/// A request.
#[derive(Clone, Debug)]
pub(crate) struct WebRequest {
    pub(crate) verb: Verb,
    /// Decoded parts of the path; those of `/` are one empty one.
    path: Vec<String>,
    query: String,
    pub(crate) body: String,
}

impl WebRequest {
    /// Reads a request; otherwise returns the response that refuses it.
    pub(super) async fn read(request: Request<Incoming>) -> Result<Self, Response> {
        let verb = match *request.method() {
            // The server leaves out the body of a response to HEAD.
            Method::GET | Method::HEAD => Verb::Get,
            Method::POST => Verb::Post,
            _ => return Err(method_not_allowed("GET, HEAD, POST")),
        };
        let path = request.uri().path();
        let parts = path.strip_prefix('/').unwrap_or(path).split('/');
        let path = parts.map(decoded).collect();
        let query = request.uri().query().unwrap_or_default().to_owned();
        let body = Limited::new(request.into_body(), MOST_BODY_BYTES).collect();
        let Ok(body) = tokio::time::timeout(BODY_TIMEOUT, body).await else {
            let why = format!("expected the body within {BODY_TIMEOUT:?}");
            return Err(wrong(StatusCode::REQUEST_TIMEOUT, why));
        };
        let body = body.map_err(|error| {
            if error.is::<LengthLimitError>() {
                let why = format!("expected a body of at most {MOST_BODY_BYTES} bytes");
                return wrong(StatusCode::PAYLOAD_TOO_LARGE, why);
            }
            wrong(StatusCode::BAD_REQUEST, error.to_string())
        })?;
        let body = String::from_utf8(body.to_bytes().into())
            .map_err(|error| wrong(StatusCode::BAD_REQUEST, error.to_string()))?;
        Ok(Self {
            verb,
            path,
            query,
            body,
        })
    }

    /// The parts of the path.
    pub(crate) fn path(&self) -> Vec<&str> {
        self.path.iter().map(String::as_str).collect()
    }

    /// Value of a field of the query.
    pub(crate) fn field(&self, name: &str) -> Option<String> {
        let mut fields = self.query.split('&').filter_map(|of| of.split_once('='));
        let (_, value) = fields.find(|(field, _)| *field == name)?;
        Some(decoded(&value.replace('+', " ")))
    }
}

/// Decodes `%2C` and the like. Bytes that are not UTF-8 become replacement characters, and nothing here has such names.
fn decoded(text: &str) -> String {
    let digit = |byte: u8| char::from(byte).to_digit(16);
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, after @ ..] = rest {
        let escaped = match rest {
            [b'%', high, low, after @ ..] => digit(*high)
                .zip(digit(*low))
                .map(|(high, low)| ((high * 16 + low) as u8, after)),
            _ => None,
        };
        let (byte, after) = escaped.unwrap_or((*first, after));
        bytes.push(byte);
        rest = after;
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_of_a_query_are_decoded() {
        let request = WebRequest {
            verb: Verb::Get,
            path: vec![decoded("caf%C3%A9"), decoded("100%")],
            query: "a=1&signals=belt.1.position%2Csaw%5B1%5D+x&signals=2".to_owned(),
            body: String::new(),
        };
        assert_eq!(request.path(), ["café", "100%"]);
        let signals = request.field("signals");
        assert_eq!(signals.as_deref(), Some("belt.1.position,saw[1] x"));
        assert_eq!(request.field("signal"), None);
    }
}
