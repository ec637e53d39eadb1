//! HTTP: the page, the state, the WebSocket's door; every request passes the guard first.

use crate::access::{Denied, PageRole};
use crate::assets;
use crate::camera_socket;
use crate::changes::edit::{EditRequest, MAX_EDIT_BYTES};
use crate::connections::Connections;
use crate::frame::frame_of;
use crate::hub::Slot;
use crate::last_seconds::LAST_MCAP;
use crate::message::Message;
use crate::metrics::{self, Ailment, BridgeFigures};
use crate::phone_links;
use crate::refusal::{Refusal, RefusalKind};
use crate::request::{Context, as_json, is_json, refuse, role_of};
use crate::session;
use crate::shared::Shared;
use crate::socket;
use crate::webhook::Webhook;
use crate::wizard::{self, Command, UserRequest};
use crate::zones;
use anyhow::Context as _;
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{DefaultBodyLimit, Extension, Request, State};
use axum::http::{HeaderMap, HeaderValue, Response, StatusCode, Uri, header};
use axum::middleware::{self, Next};
use axum::routing::{get, post};
use futures_util::stream;
use sextant_process::{Shutdown, fail_point, monotonic_ns, now_ns, watchdog};
use std::convert::Infallible;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::sync::watch;

/// Threads for commands, which may read files; further commands wait.
const COMMAND_THREADS: usize = 2;
/// Bounds the delay of a shutdown.
const SHUTDOWN_LOOK: Duration = Duration::from_millis(50);
const STATUS_PERIOD: Duration = Duration::from_secs(1);

/// Serves until `shutdown`. One thread is enough: it hands out bytes that others made. It never waits for a file.
pub(crate) fn run(
    shared: &Arc<Shared>,
    listener: TcpListener,
    shutdown: &Shutdown,
) -> anyhow::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .max_blocking_threads(COMMAND_THREADS)
        .build()
        .context("starting the server")?;
    runtime.block_on(serve(Arc::clone(shared), listener, shutdown))
}

async fn serve(
    shared: Arc<Shared>,
    listener: TcpListener,
    shutdown: &Shutdown,
) -> anyhow::Result<()> {
    let (stop, stopping) = watch::channel(false);
    let listener = tokio::net::TcpListener::from_std(listener)?;
    let tls = shared.protection.tls.clone();
    let context = Context {
        shared: Arc::clone(&shared),
        stopping,
    };
    let status = tokio::spawn(tell_status(Arc::clone(&shared)));
    let webhook = tokio::spawn(send_events(Arc::clone(&shared)));
    let mut connections = Connections::new(tls, context.stopping.clone());
    let router = router(context);
    tokio::select! {
        () = requested(&shared, shutdown) => {}
        () = connections.accept(&listener, &router) => {}
    }
    stop.send_replace(true);
    status.abort();
    webhook.abort();
    connections.end().await;
    Ok(())
}

async fn requested(shared: &Shared, shutdown: &Shutdown) {
    while !shutdown.is_requested() {
        if shared.is_network_working() {
            watchdog::feed();
        }
        tokio::time::sleep(SHUTDOWN_LOOK).await;
    }
}

fn router(context: Context) -> Router {
    let known = Router::new()
        .route("/ws", get(socket::upgrade))
        .route("/api/state", get(state))
        .route("/metrics", get(figures))
        .route(
            "/api/phones",
            get(phones)
                .post(phone_command)
                .layer(DefaultBodyLimit::max(phone_links::MAX_COMMAND_BYTES)),
        )
        .route(LAST_MCAP, get(last_seconds))
        .route(
            "/api/wizard",
            post(wizard).layer(DefaultBodyLimit::max(wizard::MAX_COMMAND_BYTES)),
        )
        .route(
            "/api/models",
            post(models).layer(DefaultBodyLimit::max(MAX_EDIT_BYTES)),
        )
        .route(
            "/api/zones",
            post(zones).layer(DefaultBodyLimit::max(zones::MAX_COMMAND_BYTES)),
        )
        .layer(middleware::from_fn_with_state(context.clone(), identify));
    known
        .route("/ws/camera", get(camera_socket::upgrade))
        .route("/camera", get(assets::camera))
        .route(
            "/api/session",
            get(session::ask)
                .post(session::begin)
                .delete(session::end)
                .layer(DefaultBodyLimit::max(session::MAX_BYTES)),
        )
        .route("/healthz", get(health))
        .route("/readyz", get(ready))
        .fallback(get(assets::file))
        .layer(middleware::from_fn_with_state(context.clone(), guard))
        .with_state(context)
}

async fn guard(State(context): State<Context>, request: Request, next: Next) -> Response<Body> {
    if !admitted(&context.shared, request.headers()) {
        return assets::plain(
            StatusCode::FORBIDDEN,
            "This bridge is not known under that name, or another page asked. Use its address, \
             or add the name to `host_names` in viewer.toml.\n",
        );
    }
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    let (sniff, refer) = (
        HeaderValue::from_static("nosniff"),
        HeaderValue::from_static("no-referrer"),
    );
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, sniff);
    headers.insert(header::REFERRER_POLICY, refer);
    response
}

/// Admits requests with permission to view, and attaches their role.
async fn identify(
    State(context): State<Context>,
    mut request: Request,
    next: Next,
) -> Response<Body> {
    match role_of(&context.shared, &request) {
        Ok(PageRole::Camera) => refuse(Denied::NoToken),
        Ok(role) => {
            request.extensions_mut().insert(role);
            next.run(request).await
        }
        Err(denied) => refuse(denied),
    }
}

fn admitted(shared: &Shared, headers: &HeaderMap) -> bool {
    let text = |name| headers.get(name).map(HeaderValue::to_str);
    let origin = text(header::ORIGIN).map(|origin| origin.unwrap_or("null"));
    let host = text(header::HOST).and_then(Result::ok);
    shared.hosts.admits(host, origin)
}

/// The newest of everything. The texts are those that clients share: they are handed to the connection one by one, as
/// fast as it takes them, and not copied before.
async fn state(
    State(context): State<Context>,
    Extension(role): Extension<PageRole>,
) -> Response<Body> {
    let hello = serde_json::to_string(&Message::hello(&context.shared.config.site, role))
        .unwrap_or_default();
    let first = Bytes::from(format!("{{\"messages\":[{hello}"));
    let texts = context.shared.hub.newest_texts().into_iter();
    let others = texts.flat_map(|text| [Bytes::from_static(b",\n"), text.into()]);
    let last = Bytes::from_static(b"]}\n");
    let parts: Vec<Bytes> = std::iter::once(first).chain(others).chain([last]).collect();
    let length: usize = parts.iter().map(Bytes::len).sum();
    let parts = parts.into_iter().map(Ok::<_, Infallible>);
    let mut response = as_json(StatusCode::OK, Body::from_stream(stream::iter(parts)));
    response
        .headers_mut()
        .insert(header::CONTENT_LENGTH, length.into());
    response
}

/// The last half minute as a recording; `?seconds=N` asks for less. Made by the threads of commands, so that few are
/// made at a time.
async fn last_seconds(State(context): State<Context>, uri: Uri) -> Response<Body> {
    let shared = context.shared;
    let seconds = uri.query().and_then(|query| query.strip_prefix("seconds="));
    let seconds: Option<u64> = seconds.and_then(|seconds| seconds.parse().ok());
    let since_ns = seconds.map_or(0, |seconds| {
        now_ns().saturating_sub(seconds.saturating_mul(1_000_000_000))
    });
    let save = move || {
        let site = shared.config.site.as_str();
        (
            shared.last_seconds.save(site, since_ns),
            format!("attachment; filename=\"{site}.mcap\""),
        )
    };
    let Ok((Ok(file), disposition)) = tokio::task::spawn_blocking(save).await else {
        return assets::plain(
            StatusCode::INTERNAL_SERVER_ERROR,
            "the recording failed by a fault of this program; the log says more\n",
        );
    };
    let mut response = Response::new(Body::from(file));
    let headers = response.headers_mut();
    let kind = HeaderValue::from_static("application/octet-stream");
    headers.insert(header::CONTENT_TYPE, kind);
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    if let Ok(disposition) = HeaderValue::from_str(&disposition) {
        headers.insert(header::CONTENT_DISPOSITION, disposition);
    }
    response
}

/// A command to the wizards; its outcome is published as the message `wizard`.
async fn wizard(
    State(context): State<Context>,
    Extension(role): Extension<PageRole>,
    headers: HeaderMap,
    body: Bytes,
) -> Response<Body> {
    let read = move || Ok(UserRequest::Command(Command::parse(&body)?));
    match ask(context.shared, role, &headers, read).await {
        Ok(_) => as_json(StatusCode::ACCEPTED, "{}\n".into()),
        Err(response) => response,
    }
}

/// An edit of the rig or an object. The answer comes when a fusion node has decided on it.
async fn models(
    State(context): State<Context>,
    Extension(role): Extension<PageRole>,
    headers: HeaderMap,
    body: Bytes,
) -> Response<Body> {
    let read = move || Ok(UserRequest::Edit(EditRequest::parse(&body)?));
    match ask(context.shared, role, &headers, read).await {
        Ok(said) => {
            let json = serde_json::json!({ "said": said });
            as_json(StatusCode::OK, format!("{json}\n").into())
        }
        Err(response) => response,
    }
}

/// Has a request of an operator handled by the wizard's thread.
async fn ask(
    shared: Arc<Shared>,
    role: PageRole,
    headers: &HeaderMap,
    read: impl FnOnce() -> Result<UserRequest, Refusal> + Send + 'static,
) -> Result<Vec<String>, Response<Body>> {
    let queue = move || {
        let request = read()?;
        let site = shared.mirror().clone();
        shared.wizard.request(request, site)
    };
    let reply = obey(role, headers, queue).await?;
    match reply.await {
        Ok(reply) => reply.map_err(|refusal| refused(&refusal)),
        Err(_) => Err(refused(&Refusal::not_now("the bridge is stopping"))),
    }
}

/// A change of the zones, published as the message `zones`.
async fn zones(
    State(context): State<Context>,
    Extension(role): Extension<PageRole>,
    headers: HeaderMap,
    body: Bytes,
) -> Response<Body> {
    let shared = context.shared;
    let obey = move || {
        let command = zones::Command::parse(&body)?;
        shared.zones.command(command, &shared.hub)
    };
    answer_command(role, &headers, obey).await
}

/// Obeys a command of an operator, and says no more than that.
async fn answer_command(
    role: PageRole,
    headers: &HeaderMap,
    command: impl FnOnce() -> Result<(), Refusal> + Send + 'static,
) -> Response<Body> {
    match obey(role, headers, command).await {
        Ok(()) => as_json(StatusCode::ACCEPTED, "{}\n".into()),
        Err(response) => response,
    }
}

/// Obeys a command of an operator on a thread that may wait for files.
async fn obey<T: Send + 'static>(
    role: PageRole,
    headers: &HeaderMap,
    command: impl FnOnce() -> Result<T, Refusal> + Send + 'static,
) -> Result<T, Response<Body>> {
    if role < PageRole::Operator {
        return Err(forbidden());
    }
    // No form of a foreign page can send this type without asking first.
    if !is_json(headers) {
        return Err(assets::plain(
            StatusCode::UNSUPPORTED_MEDIA_TYPE,
            "send application/json\n",
        ));
    }
    match tokio::task::spawn_blocking(command).await {
        Ok(result) => result.map_err(|refusal| refused(&refusal)),
        Err(_) => Err(assets::plain(
            StatusCode::INTERNAL_SERVER_ERROR,
            "the command failed by a fault of this program; the log says more\n",
        )),
    }
}

fn forbidden() -> Response<Body> {
    let cause = "This token is for looking only: the operators' may change the site.";
    let json = serde_json::json!({ "field": null, "cause": cause });
    as_json(StatusCode::FORBIDDEN, format!("{json}\n").into())
}

fn refused(refusal: &Refusal) -> Response<Body> {
    let status = match refusal.kind {
        RefusalKind::Wrong => StatusCode::BAD_REQUEST,
        RefusalKind::NotNow => StatusCode::CONFLICT,
    };
    let json = serde_json::json!({ "field": refusal.field, "cause": refusal.cause });
    as_json(status, format!("{json}\n").into())
}

/// Links by which phones become cameras. They have tokens, so that they are the operators'.
async fn phones(
    State(context): State<Context>,
    Extension(role): Extension<PageRole>,
    headers: HeaderMap,
) -> Response<Body> {
    if role < PageRole::Operator {
        return forbidden();
    }
    let Shared {
        config,
        address,
        protection,
        phone_claims,
        ..
    } = &*context.shared;
    let host = headers.get(header::HOST).and_then(|it| it.to_str().ok());
    let (access, is_secure) = (&protection.access, protection.tls.is_some());
    let links = phone_links::links(config, *address, access, is_secure, host, phone_claims);
    let json = serde_json::to_string(&links).unwrap_or_default();
    as_json(StatusCode::OK, format!("{json}\n").into())
}

/// Frees the link of a phone for another device.
async fn phone_command(
    State(context): State<Context>,
    Extension(role): Extension<PageRole>,
    headers: HeaderMap,
    body: Bytes,
) -> Response<Body> {
    let shared = context.shared;
    let obey = move || {
        let phone_links::Command::Free { camera } = phone_links::Command::parse(&body)?;
        shared
            .phone_claims
            .free(&camera)
            .map_err(Refusal::not_now)?;
        shared.web_cameras.free(&camera);
        Ok(())
    };
    answer_command(role, &headers, obey).await
}

/// Health of the site. Causes name cameras and objects, so they require permission to view.
async fn health(State(context): State<Context>, request: Request) -> Response<Body> {
    let shared = &context.shared;
    let ailments = match shared.connected.load(Ordering::Relaxed) {
        true => shared.metrics.ailments(&shared.mirror(), monotonic_ns()),
        false => vec![Ailment::no_network()],
    };
    let (status, word) = match ailments.is_empty() {
        true => (StatusCode::OK, "ok"),
        false => (StatusCode::SERVICE_UNAVAILABLE, "failing"),
    };
    let json = match role_of(shared, &request) {
        Ok(PageRole::Viewer | PageRole::Operator) => {
            serde_json::json!({ "status": word, "causes": ailments })
        }
        Ok(PageRole::Camera) | Err(_) => serde_json::json!({ "status": word }),
    };
    as_json(status, format!("{json}\n").into())
}

/// Whether the bridge itself works: it is on the site's network.
async fn ready(State(context): State<Context>) -> Response<Body> {
    match context.shared.connected.load(Ordering::Relaxed) {
        true => as_json(StatusCode::OK, "{\"status\":\"ok\"}\n".into()),
        false => as_json(
            StatusCode::SERVICE_UNAVAILABLE,
            "{\"status\":\"no network\"}\n".into(),
        ),
    }
}

/// The site in figures, for Prometheus.
async fn figures(State(context): State<Context>) -> Response<Body> {
    let shared = &context.shared;
    let (clients, replaced) = shared.hub.counts();
    let bridge = BridgeFigures {
        is_connected: shared.connected.load(Ordering::Relaxed),
        uptime_s: shared.started.elapsed().as_secs_f64(),
        clients,
        replaced,
        rejected: serde_json::to_value(shared.mirror().rejections()).unwrap_or_default(),
    };
    let text = shared
        .metrics
        .text(&shared.mirror(), &bridge, monotonic_ns());
    let mut response = Response::new(Body::from(text));
    let kind = HeaderValue::from_static(metrics::CONTENT_TYPE);
    response.headers_mut().insert(header::CONTENT_TYPE, kind);
    response
}

async fn send_events(shared: Arc<Shared>) {
    if let Some(webhook) = &shared.webhook {
        webhook.run().await;
    }
}

/// Gives an account of the bridge once a second, which clients take as a heartbeat, and forgets what is old.
async fn tell_status(shared: Arc<Shared>) {
    let mut due = tokio::time::interval(STATUS_PERIOD);
    loop {
        due.tick().await;
        fail_point!("server");
        shared.expire();
        let (clients, replaced) = shared.hub.counts();
        let status = Message::BridgeStatus {
            now_ns: now_ns(),
            uptime_s: shared.started.elapsed().as_secs(),
            network: shared.connected.load(Ordering::Relaxed),
            clients,
            replaced,
            rejected: *shared.mirror().rejections(),
            webhook: shared.webhook.as_ref().map(Webhook::counts),
        };
        // One slot: fails only when other frames fill the hub.
        let _ = shared.hub.publish(&Slot::BridgeStatus, frame_of(&status));
    }
}
