//! The WebSocket server: a task for each client, which writes what the hub has for it and passes on what it says.

use super::hub::{ClientId, Frame, Hub, MAX_CLIENTS};
use crate::report::{Notice, Reporter};
use futures_util::{SinkExt, StreamExt};
use sextant_recordings::foxglove::websocket::SUBPROTOCOLS;
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpStream;
use tokio::runtime::Runtime;
use tokio::sync::{Notify, Semaphore};
use tokio::time::{Instant, interval, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tokio_tungstenite::tungstenite::http::{HeaderValue, StatusCode};
use tokio_tungstenite::tungstenite::protocol::WebSocketConfig;
use tokio_tungstenite::tungstenite::{Bytes, Message};

/// Time for a client to open its WebSocket.
const GREETING: Duration = Duration::from_secs(5);
/// Time for a client to read a message.
const READING: Duration = Duration::from_secs(10);
/// Between two pings, and the silence after which a client counts as gone.
const PING: Duration = Duration::from_secs(10);
const SILENCE: Duration = Duration::from_secs(30);
/// Longest request of a client.
const MAX_REQUEST_BYTES: usize = 256 << 10;
const PROTOCOL_HEADER: &str = "sec-websocket-protocol";

/// Serves until the runtime ends.
pub fn start(
    listener: TcpListener,
    hub: Arc<Hub>,
    token: Option<String>,
    reporter: Reporter,
) -> io::Result<Runtime> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .thread_name("foxglove")
        .enable_all()
        .build()?;
    let listener = {
        let _entered = runtime.enter();
        tokio::net::TcpListener::from_std(listener)?
    };
    let token = token.map(Arc::from);
    runtime.spawn(accept(listener, hub, token, reporter));
    Ok(runtime)
}

async fn accept(
    listener: tokio::net::TcpListener,
    hub: Arc<Hub>,
    token: Option<Arc<str>>,
    reporter: Reporter,
) {
    // Those who are about to become clients count, too.
    let places = Arc::new(Semaphore::new(MAX_CLIENTS));
    loop {
        let Ok((stream, peer)) = listener.accept().await else {
            // No file descriptors, as a rule: they come back with clients that leave.
            tokio::time::sleep(Duration::from_millis(100)).await;
            continue;
        };
        let Ok(place) = Arc::clone(&places).try_acquire_owned() else {
            turn_away(&hub, &reporter, peer, "there are too many clients");
            continue;
        };
        let (hub, token, reporter) = (Arc::clone(&hub), token.clone(), reporter.clone());
        tokio::spawn(async move {
            serve(stream, peer, &hub, token.as_deref(), &reporter).await;
            drop(place);
        });
    }
}

async fn serve(
    stream: TcpStream,
    peer: SocketAddr,
    hub: &Hub,
    token: Option<&str>,
    reporter: &Reporter,
) {
    let config = WebSocketConfig::default()
        .max_message_size(Some(MAX_REQUEST_BYTES))
        .max_frame_size(Some(MAX_REQUEST_BYTES));
    let _ = stream.set_nodelay(true);
    #[allow(clippy::result_large_err, reason = "the type is tungstenite's")]
    let admit = |request: &Request, response| match token
        .is_none_or(|token| has_token(request, token))
    {
        true => choose_protocol(request, response),
        false => Err(refusal(
            StatusCode::FORBIDDEN,
            "the token of this protected site is wanted: ws://HOST:PORT/?token=TOKEN, as `sextant foxglove` prints it",
        )),
    };
    let handshake = tokio_tungstenite::accept_hdr_async_with_config(stream, admit, Some(config));
    let socket = match timeout(GREETING, handshake).await {
        Ok(Ok(socket)) => socket,
        Ok(Err(cause)) => return turn_away(hub, reporter, peer, &cause.to_string()),
        Err(_) => {
            return turn_away(
                hub,
                reporter,
                peer,
                "it has not opened a WebSocket within 5 s",
            );
        }
    };
    if let Some((id, ready)) = hub.join() {
        converse(socket, hub, id, &ready).await;
        hub.leave(id);
    }
}

fn turn_away(hub: &Hub, reporter: &Reporter, peer: SocketAddr, cause: &str) {
    if hub.turn_away() {
        reporter.report(&Notice::TurnedAway {
            peer,
            cause: format!("{cause}; Foxglove and Lichtblick connect with \"Foxglove WebSocket\""),
        });
    }
}

/// Whether the address that is asked for has the token.
fn has_token(request: &Request, token: &str) -> bool {
    let mut parts = request.uri().query().unwrap_or_default().split('&');
    let given = parts.find_map(|part| part.strip_prefix("token="));
    // Takes the same time wherever they differ.
    given.is_some_and(|given| {
        let pairs = given.bytes().zip(token.bytes());
        given.len() == token.len() && pairs.fold(0, |off, (a, b)| off | (a ^ b)) == 0
    })
}

fn refusal(status: StatusCode, words: &str) -> ErrorResponse {
    let mut refusal = ErrorResponse::new(Some(words.to_owned()));
    *refusal.status_mut() = status;
    refusal
}

#[allow(clippy::result_large_err, reason = "the type is tungstenite's")]
fn choose_protocol(request: &Request, mut response: Response) -> Result<Response, ErrorResponse> {
    let offers = request.headers().get_all(PROTOCOL_HEADER);
    let offers = offers.iter().filter_map(|offer| offer.to_str().ok());
    let offers: Vec<&str> = offers
        .flat_map(|offer| offer.split(','))
        .map(str::trim)
        .collect();
    let chosen = SUBPROTOCOLS.iter().find(|ours| offers.contains(ours));
    let Some(chosen) = chosen else {
        let words = format!("the subprotocol {} is wanted", SUBPROTOCOLS[0]);
        return Err(refusal(StatusCode::BAD_REQUEST, &words));
    };
    let chosen = HeaderValue::from_static(chosen);
    response.headers_mut().insert(PROTOCOL_HEADER, chosen);
    Ok(response)
}

/// Until the client leaves, falls silent or does not read.
async fn converse(mut socket: WebSocketStream<TcpStream>, hub: &Hub, id: ClientId, ready: &Notify) {
    let (mut ping, mut heard) = (interval(PING), Instant::now());
    loop {
        tokio::select! {
            frame = next_frame(hub, id, ready) => {
                let message = match frame {
                    Frame::Text(text) => Message::text(text),
                    Frame::Binary(data) => Message::binary(data),
                };
                if !send(&mut socket, message).await {
                    return;
                }
            }
            message = socket.next() => match message {
                Some(Ok(message)) => {
                    heard = Instant::now();
                    if let Message::Text(text) = message {
                        hub.request(id, &text);
                    }
                }
                _ => return,
            },
            _ = ping.tick() => {
                let is_gone = heard.elapsed() > SILENCE;
                if is_gone || !send(&mut socket, Message::Ping(Bytes::new())).await {
                    return;
                }
            }
        }
    }
}

/// A frame is taken and returned without a wait between, so that none is lost where this is given up.
async fn next_frame(hub: &Hub, id: ClientId, ready: &Notify) -> Frame {
    loop {
        if let Some(frame) = hub.next_frame(id) {
            return frame;
        }
        ready.notified().await;
    }
}

async fn send(socket: &mut WebSocketStream<TcpStream>, message: Message) -> bool {
    matches!(timeout(READING, socket.send(message)).await, Ok(Ok(())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_wanted_whole_and_in_the_query() {
        let asks = |address: &str| {
            let request = Request::builder().uri(address).body(()).unwrap();
            has_token(&request, "secret")
        };
        assert!(asks("/?token=secret") && asks("/?a=b&token=secret"));
        for address in [
            "/",
            "/?token=",
            "/?token=secre",
            "/?token=secret2",
            "/token=secret",
        ] {
            assert!(!asks(address), "{address}");
        }
    }
}
