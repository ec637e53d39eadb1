//! What the handlers of requests have in common: what they get, who asks, and how they answer.

use crate::access::{Denied, PageRole};
use crate::assets;
use crate::connections::Peer;
use crate::shared::Shared;
use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, Response, StatusCode, header};
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::time::Instant;
use tokio::sync::watch;

/// What each handler gets.
#[derive(Clone)]
pub(crate) struct Context {
    pub(crate) shared: Arc<Shared>,
    /// Becomes true when the bridge stops.
    pub(crate) stopping: watch::Receiver<bool>,
}

/// What the sender of a request may do.
pub(crate) fn role_of(shared: &Shared, request: &Request) -> Result<PageRole, Denied> {
    // Every connection notes where it comes from.
    let from = request.extensions().get::<Peer>();
    let from = from.map_or(IpAddr::V4(Ipv4Addr::UNSPECIFIED), |from| from.0);
    shared
        .protection
        .access
        .role_of(request.headers(), from, Instant::now())
}

/// The answer to a request without permission to view.
pub(crate) fn refuse(denied: Denied) -> Response<Body> {
    match denied {
        Denied::NoToken => assets::plain(
            StatusCode::UNAUTHORIZED,
            "say a token of this page: POST /api/session, or Authorization: Bearer TOKEN\n",
        ),
        Denied::NotThisCamera => assets::plain(
            StatusCode::FORBIDDEN,
            "this token is for another camera, or for none: `sextant keys add NAME --role phone` makes one\n",
        ),
        Denied::TooManyTries => assets::plain(
            StatusCode::TOO_MANY_REQUESTS,
            "too many wrong tokens from this address; wait a minute\n",
        ),
    }
}

/// Whether a request brings JSON.
pub(crate) fn is_json(headers: &HeaderMap) -> bool {
    let kind = headers.get(header::CONTENT_TYPE);
    kind.and_then(|kind| kind.to_str().ok())
        .and_then(|kind| kind.split(';').next())
        .is_some_and(|kind| kind.trim().eq_ignore_ascii_case("application/json"))
}

/// An answer in JSON.
pub(crate) fn as_json(status: StatusCode, json: Body) -> Response<Body> {
    let mut response = Response::new(json);
    *response.status_mut() = status;
    let headers = response.headers_mut();
    headers.insert(
        header::CONTENT_TYPE,
        HeaderValue::from_static("application/json"),
    );
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    response
}
