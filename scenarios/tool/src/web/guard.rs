//! Admission of requests. Another site's page, open in this browser, can reach this one. It must neither read what is
//! shown nor change anything.

use std::net::IpAddr;

use hyper::Method;
use hyper::header::{self, HeaderMap};

use super::token::PageToken;

/// Header of the page's own requests that change anything, with the token. Another site's page cannot send it without a preflight, which
/// is not answered.
const OWN_HEADER: &str = "x-coaxle-page";

/// Refuses a change that another site's page may have sent, as a form needs no preflight; and one without the token of
/// the page, if it has one.
pub(super) fn check_change(
    method: &Method,
    headers: &HeaderMap,
    token: Option<&PageToken>,
) -> Result<(), String> {
    // Reading is protected otherwise: a browser keeps responses from pages of other origins.
    if method != Method::POST {
        return Ok(());
    }
    let Some(received) = headers.get(OWN_HEADER) else {
        return Err(format!("expected the header {OWN_HEADER}"));
    };
    if token.is_some_and(|token| !token.is(received.as_bytes())) {
        return Err(
            "received no token, or another one, expected that of the page: open it at the address with ?token=, which \
             was printed or logged when the page started"
                .to_owned(),
        );
    }
    Ok(())
}

/// Refuses a request whose host is any name but ours: a name owned by others may point here.
pub(super) fn check_host(headers: &HeaderMap) -> Result<(), String> {
    let host = headers
        .get(header::HOST)
        .and_then(|host| host.to_str().ok());
    // HTTP/1.1 requires a host; without one the empty name is refused.
    let host = host.unwrap_or_default();
    let name = without_port(host);
    // An address cannot be rebound: DNS is not asked for it.
    if name == "localhost" || name.parse::<IpAddr>().is_ok() {
        return Ok(());
    }
    Err(format!(
        "host: received {host:?}, expected an address or localhost"
    ))
}

/// `[::1]:80`, `127.0.0.1:80` or `localhost`.
fn without_port(host: &str) -> &str {
    // IPv6 addresses have colons of their own.
    if let Some(rest) = host.strip_prefix('[') {
        return rest.split(']').next().unwrap_or_default();
    }
    host.split(':').next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_ours_and_names_are_not() {
        let check = |host: &str| {
            let mut headers = HeaderMap::new();
            headers.insert(header::HOST, host.parse().unwrap());
            check_host(&headers)
        };
        for host in ["127.0.0.1:7480", "localhost", "[::1]:80", "10.0.0.7"] {
            assert_eq!(check(host), Ok(()), "{host}");
        }
        for host in ["evil.example:7480", "", "127.0.0.1.evil.example"] {
            assert!(check(host).is_err(), "{host}");
        }
    }
}
