//! What one request is answered.

use http_body_util::Full;
use hyper::body::Bytes;
use hyper::header::{self, HeaderMap, HeaderName, HeaderValue};
use hyper::{Method, Request, Response, StatusCode, Uri};

use crate::page::Page;

/// Sent with everything, refusals included.
const ALWAYS: [(HeaderName, &str); 7] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; \
         img-src 'self' blob: data:; media-src 'self' blob:; object-src 'none'; base-uri 'none'; \
         form-action 'none'; \
         frame-ancestors 'none'",
    ),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (header::CACHE_CONTROL, "no-cache"),
];

/// The answer to a request that came in at `port`. The body of a request is not read.
pub(crate) fn answer<B>(page: &Page, port: u16, request: &Request<B>) -> Response<Full<Bytes>> {
    if !is_addressed_to(port, request.uri(), request.headers()) {
        let text = "This server answers to localhost, 127.0.0.1 and [::1] only.\n";
        return refusal(StatusCode::MISDIRECTED_REQUEST, text);
    }
    if !matches!(*request.method(), Method::GET | Method::HEAD) {
        let mut refused = refusal(StatusCode::METHOD_NOT_ALLOWED, "Only GET and HEAD are answered.\n");
        refused.headers_mut().insert(header::ALLOW, HeaderValue::from_static("GET, HEAD"));
        return refused;
    }
    let Some(file) = page.find(request.uri().path()) else {
        return refusal(StatusCode::NOT_FOUND, "There is no such file.\n");
    };
    let known = request.headers().get_all(header::IF_NONE_MATCH).iter().any(|tags| {
        let tags = tags.to_str().unwrap_or_default().split(',');
        tags.map(|tag| tag.trim().trim_start_matches("W/")).any(|tag| tag == file.tag)
    });
    let mut response = match known {
        true => plain(StatusCode::NOT_MODIFIED, Bytes::new()),
        false => plain(StatusCode::OK, Bytes::from_static(file.contents)),
    };
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(file.content_type));
    if let Ok(tag) = HeaderValue::from_str(&file.tag) {
        response.headers_mut().insert(header::ETAG, tag);
    }
    response
}

/// Whether the one who asks means this machine: by the address in the request line, if there is one, and by
/// the one `Host`.
fn is_addressed_to(port: u16, uri: &Uri, headers: &HeaderMap) -> bool {
    let ours = |authority: &str| {
        let host = match authority.strip_suffix(&format!(":{port}")) {
            Some(host) => host,
            None if port == 80 => authority,
            None => return false,
        };
        host.eq_ignore_ascii_case("localhost") || matches!(host, "127.0.0.1" | "[::1]")
    };
    let mut hosts = headers.get_all(header::HOST).iter();
    let host = hosts.next().and_then(|h| h.to_str().ok());
    let line = uri.authority().is_none_or(|authority| ours(authority.as_str()));
    line && hosts.next().is_none() && host.is_some_and(ours)
}

/// A short text for a person who looks; the connection ends with it.
fn refusal(status: StatusCode, text: &'static str) -> Response<Full<Bytes>> {
    let mut response = plain(status, Bytes::from_static(text.as_bytes()));
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("text/plain; charset=utf-8"));
    headers.insert(header::CONNECTION, HeaderValue::from_static("close"));
    response
}

/// A response with what all responses have.
fn plain(status: StatusCode, body: Bytes) -> Response<Full<Bytes>> {
    let mut response = Response::new(Full::new(body));
    *response.status_mut() = status;
    for (name, value) in ALWAYS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}
