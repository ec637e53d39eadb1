//! Requests to HTTP servers: plain HTTP, a connection each, redirections not followed.

use axum::body::Body;
use axum::http::{Request, Response, Uri, header, request};
use hyper::body::Incoming;
use hyper::client::conn::http1;
use hyper_util::rt::TokioIo;
use tokio::net::TcpStream;

/// Sends a request to the host of `url`.
pub(crate) async fn send(
    url: &Uri,
    request: request::Builder,
    body: Body,
) -> anyhow::Result<Response<Incoming>> {
    let host = url.host().unwrap_or_default().trim_matches(['[', ']']);
    let stream = TcpStream::connect((host, url.port_u16().unwrap_or(80))).await?;
    let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await?;
    // It ends when the answer has been read: each connection is for one.
    tokio::spawn(connection);
    let authority = url.authority().map_or("", |authority| authority.as_str());
    let request: Request<Body> = request
        .header(header::HOST, authority)
        .header(header::CONNECTION, "close")
        .body(body)?;
    Ok(sender.send_request(request).await?)
}
