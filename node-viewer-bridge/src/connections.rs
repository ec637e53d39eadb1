//! TCP connections: so many at a time, and each only as long as it does something.
//!
//! Drop rules: while all places are taken, new connections wait in the system's queue. A connection that sends no whole header
//! within [`HEADER_TIMEOUT`], be it the first or a further one, is closed, and so is one that is not done within [`LIFETIME`],
//! whether it sends or reads slowly. A WebSocket gives its place back: the hub counts those, and they have time limits of their
//! own.

use axum::Router;
use axum::extract::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, watch};
use tokio::time::{sleep, timeout};
use tower_service::Service;

/// Connections at a time, WebSockets not counted.
const MAX_CONNECTIONS: u32 = 448;
/// How long a header may take, from the moment it is waited for.
const HEADER_TIMEOUT: Duration = Duration::from_secs(5);
/// How long a connection may live: enough for the page over a slow network.
const LIFETIME: Duration = Duration::from_secs(60);
/// What a connection may send ahead, bytes: a header, and a part of a command.
const READ_BUFFER: usize = 16 * 1024;
/// How long open requests may still take after the wish to stop, and at the end of a connection's life.
const GRACE: Duration = Duration::from_millis(500);
/// The pause after the system refused a connection, as it does without free file descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// All connections of the bridge.
pub(crate) struct Connections {
    places: Arc<Semaphore>,
    stopping: watch::Receiver<bool>,
}

impl Connections {
    /// None yet; they end when `stopping` becomes true.
    pub(crate) fn new(stopping: watch::Receiver<bool>) -> Self {
        Self {
            places: Arc::new(Semaphore::new(MAX_CONNECTIONS as usize)),
            stopping,
        }
    }

    /// Accepts connections and has them served by `router`, until it is dropped.
    pub(crate) async fn accept(&mut self, listener: &TcpListener, router: &Router) {
        while let Ok(place) = Arc::clone(&self.places).acquire_owned().await {
            match listener.accept().await {
                Ok((stream, _)) => {
                    let served = serve(stream, router.clone(), self.stopping.clone(), place);
                    tokio::spawn(served);
                }
                Err(error) => {
                    tracing::warn!(%error, "a connection was not accepted");
                    sleep(ACCEPT_PAUSE).await;
                }
            }
        }
    }

    /// Waits for the open requests, though not for ever.
    pub(crate) async fn end(self) {
        let _ = timeout(GRACE, self.places.acquire_many(MAX_CONNECTIONS)).await;
    }
}

/// Serves one connection until it ends, becomes a WebSocket, or has had its time.
async fn serve(
    stream: TcpStream,
    router: Router,
    mut stopping: watch::Receiver<bool>,
    _place: OwnedSemaphorePermit,
) {
    // Frames are small and want to arrive now; without it they would only wait for acknowledgements.
    let _ = stream.set_nodelay(true);
    let service = service_fn(move |request: Request<Incoming>| router.clone().call(request));
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER_TIMEOUT)
        .max_buf_size(READ_BUFFER)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    let mut connection = pin!(connection);
    tokio::select! {
        // Clients that break off are no news.
        _ = connection.as_mut() => return,
        () = sleep(LIFETIME) => {}
        _ = stopping.wait_for(|stopped| *stopped) => {}
    }
    connection.as_mut().graceful_shutdown();
    let _ = timeout(GRACE, connection).await;
}
