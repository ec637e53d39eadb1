//! `/api/session`: a browser sends its token once and has it as a cookie from then on.

use axum::body::{Body, Bytes};
use axum::extract::{Extension, Request, State};
use axum::http::{HeaderMap, HeaderValue, Response, StatusCode, header};
use serde::Deserialize;
use std::time::Instant;

use crate::assets;
use crate::connections::Peer;
use crate::request::{self, Context};

/// Longest request, bytes.
pub(crate) const MAX_BYTES: usize = 1024;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Login {
    token: String,
}

/// `GET`: permissions of the browser.
pub(crate) async fn ask(State(context): State<Context>, request: Request) -> Response<Body> {
    match request::role_of(&context.shared, &request) {
        Ok(role) => {
            let json = serde_json::json!({ "role": role });
            request::as_json(StatusCode::OK, format!("{json}\n").into())
        }
        Err(denied) => request::refuse(denied),
    }
}

/// `POST`: sets the cookie for a token.
pub(crate) async fn begin(
    State(context): State<Context>,
    Extension(Peer(from)): Extension<Peer>,
    headers: HeaderMap,
    body: Bytes,
) -> Response<Body> {
    // A form of another site cannot send this content type without a preflight request.
    if !request::is_json(&headers) {
        return assets::plain(
            StatusCode::UNSUPPORTED_MEDIA_TYPE,
            "send application/json\n",
        );
    }
    let Ok(Login { token }) = serde_json::from_slice(&body) else {
        return assets::plain(StatusCode::BAD_REQUEST, "send {\"token\": TOKEN}\n");
    };
    let access = &context.shared.protection.access;
    match access.role_of_token(&token, from, Instant::now()) {
        Ok(role) => {
            let json = serde_json::json!({ "role": role });
            let answer = request::as_json(StatusCode::OK, format!("{json}\n").into());
            with_cookie(answer, access.cookie_of(&token))
        }
        Err(denied) => request::refuse(denied),
    }
}

/// `DELETE`: removes the cookie.
pub(crate) async fn end(State(context): State<Context>) -> Response<Body> {
    let answer = request::as_json(StatusCode::OK, "{}\n".into());
    with_cookie(answer, context.shared.protection.access.no_cookie())
}

fn with_cookie(mut answer: Response<Body>, cookie: Option<HeaderValue>) -> Response<Body> {
    if let Some(cookie) = cookie {
        answer.headers_mut().insert(header::SET_COOKIE, cookie);
    }
    answer
}
