//! One client's WebSocket: greets, then writes what its outbox holds, as fast as the client takes it and no faster than
//! it asked for.

use crate::access::PageRole;
use crate::assets;
use crate::frame::frame_of;
use crate::hub::Outbox;
use crate::message::Message as BridgeMessage;
use crate::request::Context;
use crate::shared::Shared;
use axum::body::Body;
use axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade, close_code};
use axum::extract::{Extension, State};
use axum::http::{Response, StatusCode, Uri};
use std::future::poll_fn;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;
use tokio::time::{Instant, sleep_until, timeout};

/// A client that receives nothing for so long is disconnected.
const WRITE_TIMEOUT: Duration = Duration::from_secs(10);
/// Clients have nothing to say; what they send is read and forgotten, up to this size.
const MAX_INCOMING_BYTES: usize = 4096;

/// `GET /ws`.
pub(crate) async fn upgrade(
    State(context): State<Context>,
    Extension(role): Extension<PageRole>,
    uri: Uri,
    socket: WebSocketUpgrade,
) -> Response<Body> {
    let Some(pause) = pause(uri.query().unwrap_or("")) else {
        return assets::plain(
            StatusCode::BAD_REQUEST,
            "max_hz is a number from 1 to 1000\n",
        );
    };
    let Some(seat) = Seat::take(&context.shared) else {
        return assets::plain(StatusCode::SERVICE_UNAVAILABLE, "too many clients\n");
    };
    socket
        .max_message_size(MAX_INCOMING_BYTES)
        .max_frame_size(MAX_INCOMING_BYTES)
        .on_upgrade(move |socket| converse(socket, seat, Terms { pause, role }, context.stopping))
}

/// The least time between two rounds of writing, from `max_hz`; none when that is malformed.
fn pause(query: &str) -> Option<Duration> {
    let Some(text) = query
        .split('&')
        .find_map(|pair| pair.strip_prefix("max_hz="))
    else {
        return Some(Duration::ZERO);
    };
    let hz: f64 = text.parse().ok()?;
    (1.0..=1000.0)
        .contains(&hz)
        .then(|| Duration::from_secs_f64(1.0 / hz))
}

/// A client's place in the hub; left when the connection ends, however it ends.
struct Seat {
    shared: Arc<Shared>,
    outbox: Arc<Outbox>,
}

impl Seat {
    fn take(shared: &Arc<Shared>) -> Option<Self> {
        Some(Self {
            outbox: shared.hub.join()?,
            shared: Arc::clone(shared),
        })
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.shared.hub.leave(&self.outbox);
    }
}

/// What a client asked for, and what it may do.
struct Terms {
    pause: Duration,
    role: PageRole,
}

/// The connection is over, or is to be.
struct Gone;

async fn converse(
    mut socket: WebSocket,
    seat: Seat,
    terms: Terms,
    mut stopping: watch::Receiver<bool>,
) {
    let hello = frame_of(&BridgeMessage::hello(&seat.shared.config.site, terms.role));
    if send(&mut socket, hello).await.is_err() {
        return;
    }
    let mut due = Instant::now();
    loop {
        let round = async {
            sleep_until(due).await;
            poll_fn(|context| seat.outbox.poll_ready(context)).await;
        };
        tokio::select! {
            () = stop(&mut stopping) => return close(socket).await,
            incoming = socket.recv() => match incoming {
                Some(Ok(_)) => {}
                Some(Err(_)) | None => return,
            },
            () = round => {
                due = Instant::now() + terms.pause;
                if empty(&mut socket, &seat.outbox).await.is_err() {
                    return;
                }
            }
        }
    }
}

/// Returns when the bridge stops.
async fn stop(stopping: &mut watch::Receiver<bool>) {
    let _ = stopping.wait_for(|stopped| *stopped).await;
}

/// Writes as many frames as wait now: what comes meanwhile belongs to the next round.
async fn empty(socket: &mut WebSocket, outbox: &Outbox) -> Result<(), Gone> {
    if outbox.is_closed() {
        return Err(Gone);
    }
    for _ in 0..outbox.len() {
        if let Some(frame) = outbox.try_pop() {
            send(socket, frame).await?;
        }
    }
    Ok(())
}

async fn send(socket: &mut WebSocket, frame: Message) -> Result<(), Gone> {
    match timeout(WRITE_TIMEOUT, socket.send(frame)).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(_)) | Err(_) => Err(Gone),
    }
}

async fn close(mut socket: WebSocket) {
    let farewell = CloseFrame {
        code: close_code::AWAY,
        reason: "the bridge stops".into(),
    };
    let _ = socket.send(Message::Close(Some(farewell))).await;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn max_hz_is_a_pause_between_rounds() {
        assert_eq!(pause(""), Some(Duration::ZERO));
        assert_eq!(pause("other=1"), Some(Duration::ZERO));
        assert_eq!(pause("a=b&max_hz=20"), Some(Duration::from_millis(50)));
        for wrong in [
            "max_hz=",
            "max_hz=0",
            "max_hz=-1",
            "max_hz=NaN",
            "max_hz=1e9",
        ] {
            assert_eq!(pause(wrong), None, "{wrong}");
        }
    }
}
