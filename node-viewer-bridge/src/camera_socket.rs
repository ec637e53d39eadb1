//! A browser's WebSocket: `GET /ws/camera?name=NAME&key=KEY`.

use crate::access::Denied;
use crate::assets;
use crate::connections::Peer;
use crate::frame::{Frame, frame_of};
use crate::request::Context;
use crate::shared::Shared;
use crate::web_camera::registry::{JoinState, Place, Rejected};
use crate::web_camera::session::{BridgeMessage, KnownOfCamera, MAX_BYTES, Now, Session};
use axum::body::Body;
use axum::extract::ws::{CloseFrame, WebSocket, WebSocketUpgrade, close_code};
use axum::extract::{Extension, State};
use axum::http::{HeaderMap, Response, StatusCode, Uri};
use sextant_process::{ClockQuality, monotonic_ns, now_ns};
use sextant_site_model::CameraId;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;
use tokio::time::{Instant, sleep, sleep_until, timeout};

/// A browser that receives nothing for so long is disconnected, and so is one that sends nothing.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);
const SILENCE: Duration = Duration::from_secs(5);
const REPORT_PERIOD: Duration = Duration::from_secs(1);
/// Close codes after which the browser does not try again: PROTOCOL.md.
const REPLACED: u16 = 4000;
const INVALID_LINK: u16 = 4001;
const NAME_TAKEN: u16 = 4002;
/// Longest key of a device.
const MAX_KEY_BYTES: usize = 64;
/// Longest reason in a close frame, by RFC 6455.
const MAX_REASON_BYTES: usize = 120;

/// `GET /ws/camera`. Browsers do not show scripts why an upgrade is refused, so that most refusals are reasons of a
/// close.
pub(crate) async fn upgrade(
    State(context): State<Context>,
    Extension(Peer(from)): Extension<Peer>,
    uri: Uri,
    headers: HeaderMap,
    socket: WebSocketUpgrade,
) -> Response<Body> {
    let Some((camera, key)) = asked(&uri) else {
        return assets::plain(
            StatusCode::BAD_REQUEST,
            "say ?name=NAME&key=KEY: a camera's name has letters a-z, digits, - and _, at most \
             32; a key of at most 64 letters and digits is chosen by the browser\n",
        );
    };
    let shared = Arc::clone(&context.shared);
    let access = &shared.protection.access;
    let place = match access.check_camera(&headers, from, &camera, std::time::Instant::now()) {
        Ok(()) => match claim(&shared, &camera, &key).await {
            Ok(()) => {
                let now = std::time::Instant::now();
                let place = shared.web_cameras.enter(camera.clone(), &key, now);
                place.map_err(|rejected| match rejected {
                    Rejected::Taken(cause) => (NAME_TAKEN, cause),
                    full @ Rejected::Full => (close_code::POLICY, full.to_string()),
                })
            }
            Err(cause) => {
                return answered(socket, |socket| async move {
                    close(socket, INVALID_LINK, &cause).await;
                });
            }
        },
        Err(Denied::NotThisCamera) => Err((
            NAME_TAKEN,
            format!(
                "this link is not for a camera named {camera}: use the name that it was made for"
            ),
        )),
        Err(Denied::NoToken | Denied::TooManyTries) => {
            return answered(socket, move |socket| {
                close(
                    socket,
                    INVALID_LINK,
                    "this link is not valid (any more): ask for a new one",
                )
            });
        }
    };
    answered(socket, move |socket| async move {
        match place {
            Ok(place) => converse(socket, shared, camera, place, context.stopping).await,
            Err((code, cause)) => close(socket, code, &cause).await,
        }
    })
}

/// Makes the link of a phone with a key this device's own.
async fn claim(shared: &Arc<Shared>, camera: &CameraId, key: &str) -> Result<(), String> {
    let phones = shared.protection.access.phones();
    let Some(token) = phones.and_then(|phones| phones.get(camera)) else {
        return Ok(());
    };
    if shared.phone_claims.knows(camera, token, key) {
        return Ok(());
    }
    let (token, camera, key) = (token.clone(), camera.clone(), key.to_owned());
    let shared = Arc::clone(shared);
    let claim = move || shared.phone_claims.claim(&camera, &token, &key);
    let claimed = tokio::task::spawn_blocking(claim).await;
    claimed.unwrap_or_else(|_| Err("the bridge failed; its log says more".to_owned()))
}

fn answered<F>(
    socket: WebSocketUpgrade,
    handle: impl FnOnce(WebSocket) -> F + Send + 'static,
) -> Response<Body>
where
    F: Future<Output = ()> + Send + 'static,
{
    let socket = socket.max_message_size(MAX_BYTES).max_frame_size(MAX_BYTES);
    socket.on_upgrade(handle)
}

/// The camera's name and the browser's key.
fn asked(uri: &Uri) -> Option<(CameraId, String)> {
    let query = uri.query()?;
    let value = |name: &str| {
        let mut pairs = query.split('&').filter_map(|pair| pair.split_once('='));
        pairs.find_map(|(key, value)| (key == name).then_some(value))
    };
    let key = value("key")?;
    let is_plain = (1..=MAX_KEY_BYTES).contains(&key.len())
        && key.bytes().all(|byte| byte.is_ascii_alphanumeric());
    Some((
        CameraId::new(value("name")?).ok()?,
        is_plain.then(|| key.to_owned())?,
    ))
}

/// How a conversation ends: silently, or with a reason for the browser.
enum End {
    Gone,
    Because(u16, String),
}

impl End {
    fn refused(reason: impl Into<String>) -> Self {
        Self::Because(close_code::POLICY, reason.into())
    }
}

/// What happens next.
enum Event {
    Stopping,
    Silence,
    JoinState,
    Incoming(Option<Result<Frame, axum::Error>>),
    PingDue,
    ReportDue,
}

struct Conversation {
    socket: WebSocket,
    shared: Arc<Shared>,
    camera: CameraId,
    place: Place,
    session: Session,
    heard: Instant,
    report_due: Instant,
}

async fn converse(
    socket: WebSocket,
    shared: Arc<Shared>,
    camera: CameraId,
    place: Place,
    mut stopping: watch::Receiver<bool>,
) {
    let mut conversation = Conversation {
        session: Session::new(camera.clone(), monotonic_ns()),
        socket,
        shared,
        camera,
        place,
        heard: Instant::now(),
        report_due: Instant::now(),
    };
    let end = loop {
        let event = conversation.next(&mut stopping).await;
        if let Err(end) = conversation.handle(event).await {
            break end;
        }
    };
    if let End::Because(code, reason) = end {
        close(conversation.socket, code, &reason).await;
    }
}

impl Conversation {
    async fn next(&mut self, stopping: &mut watch::Receiver<bool>) -> Event {
        let ping_in_ns = self.session.ping_due_ns().saturating_sub(monotonic_ns());
        tokio::select! {
            _ = stopping.wait_for(|stopped| *stopped) => Event::Stopping,
            () = sleep_until(self.heard + SILENCE) => Event::Silence,
            _ = self.place.standing.changed() => Event::JoinState,
            frame = self.socket.recv() => Event::Incoming(frame),
            () = sleep(Duration::from_nanos(ping_in_ns)) => Event::PingDue,
            () = sleep_until(self.report_due) => Event::ReportDue,
        }
    }

    async fn handle(&mut self, event: Event) -> Result<(), End> {
        match event {
            Event::Stopping => Err(End::Because(close_code::AWAY, "the bridge stops".into())),
            Event::Silence => Err(End::refused("nothing was heard for 5 s")),
            Event::JoinState => self.follow_standing().await,
            Event::Incoming(Some(Ok(frame))) => self.take(&frame),
            Event::Incoming(_) => Err(End::Gone),
            Event::PingDue => {
                let ping = self.session.ping(&now());
                say(&mut self.socket, &ping).await
            }
            Event::ReportDue => {
                self.report_due = Instant::now() + REPORT_PERIOD;
                let (n_clients, _) = self.shared.hub.counts();
                let known = {
                    let site = self.shared.mirror();
                    let tags = site.configs().flat_map(|object| &object.tags);
                    let faults = site.statuses().flat_map(|status| &status.faults);
                    let own = faults.filter(|fault| fault.camera() == Some(&self.camera));
                    KnownOfCamera {
                        in_rig: site.camera_config(&self.camera).is_some(),
                        families: tags.map(|tag| tag.family).collect(),
                        faults: own.map(ToString::to_string).collect(),
                    }
                };
                let report = self.session.report(&now(), n_clients > 0, known);
                say(&mut self.socket, &report).await
            }
        }
    }

    async fn follow_standing(&mut self) -> Result<(), End> {
        let standing = self.place.standing.borrow_and_update().clone();
        match standing {
            JoinState::Waiting => Ok(()),
            JoinState::Ended(cause) => Err(End::refused(cause)),
            JoinState::Replaced => Err(End::Because(
                REPLACED,
                "this device has connected again, perhaps in another tab".into(),
            )),
            JoinState::Freed => Err(End::Because(
                INVALID_LINK,
                "this link was freed for another device: open it again to use it here".into(),
            )),
            JoinState::Joined => {
                let joined = BridgeMessage::Joined {
                    camera: &self.camera,
                    site: self.shared.config.site.as_str(),
                };
                say(&mut self.socket, &joined).await
            }
        }
    }

    fn take(&mut self, frame: &Frame) -> Result<(), End> {
        self.heard = Instant::now();
        match frame {
            Frame::Binary(bytes) => {
                if let Some(message) = self.session.handle_bytes(&now(), bytes) {
                    self.shared.web_cameras.send(message, bytes.len());
                }
            }
            Frame::Text(text) => self.session.handle_text(&now(), text),
            _ => {}
        }
        match self.session.is_hopeless() {
            true => Err(End::refused("too many messages were refused")),
            false => Ok(()),
        }
    }
}

fn now() -> Now {
    Now {
        wire_ns: now_ns(),
        monotonic_ns: monotonic_ns(),
        clock: ClockQuality::read(),
    }
}

async fn say(socket: &mut WebSocket, message: &BridgeMessage<'_>) -> Result<(), End> {
    match timeout(WRITE_TIMEOUT, socket.send(frame_of(message))).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(_)) | Err(_) => Err(End::Gone),
    }
}

async fn close(mut socket: WebSocket, code: u16, reason: &str) {
    let reason = sextant_proto::limits::clipped(reason, MAX_REASON_BYTES);
    let farewell = CloseFrame {
        code,
        reason: reason.into(),
    };
    let _ = timeout(WRITE_TIMEOUT, socket.send(Frame::Close(Some(farewell)))).await;
}
