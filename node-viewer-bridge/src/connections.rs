//! TCP connections: so many at a time, and each only as long as it does something.
//!
//! Drop rules: while all places are taken, new connections wait in the system's queue. A connection that sends no whole
//! header within [`HEADER_TIMEOUT`], be it the first or a further one, is closed, and so is one that is not done within
//! [`LIFETIME`], whether it sends or reads slowly. A WebSocket gives its place back: the hub counts those, and they
//! have time limits of their own.

use axum::Router;
use axum::extract::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use std::net::IpAddr;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, watch};
use tokio::time::{sleep, timeout};
use tokio_rustls::TlsAcceptor;
use tower_service::Service;

/// Connections at a time, WebSockets not counted.
const MAX_CONNECTIONS: u32 = 448;
/// How long a header may take, from the moment it is waited for.
const HEADER_TIMEOUT: Duration = Duration::from_secs(5);
/// How long a connection may live: enough for the page over a slow network.
const LIFETIME: Duration = Duration::from_secs(60);
/// What a connection may send ahead, bytes: a header, and a part of a command.
const READ_BUFFER: usize = 16 * 1024;
/// How long open requests may still take after a request to stop, and at the end of a connection's life.
const GRACE: Duration = Duration::from_millis(500);
/// The pause after the system refused a connection, as it does without free file descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// All connections of the bridge.
pub(crate) struct Connections {
    places: Arc<Semaphore>,
    /// None: connections are plain.
    tls: Option<TlsAcceptor>,
    stopping: watch::Receiver<bool>,
}

impl Connections {
    /// None yet; they end when `stopping` becomes true.
    pub(crate) fn new(tls: Option<TlsAcceptor>, stopping: watch::Receiver<bool>) -> Self {
        Self {
            tls,
            places: Arc::new(Semaphore::new(MAX_CONNECTIONS as usize)),
            stopping,
        }
    }

    /// Accepts connections and has them served by `router`, until it is dropped.
    pub(crate) async fn accept(&mut self, listener: &TcpListener, router: &Router) {
        while let Ok(place) = Arc::clone(&self.places).acquire_owned().await {
            match listener.accept().await {
                Ok((stream, from)) => {
                    let client = Client {
                        router: router.clone(),
                        from: from.ip().to_canonical(),
                        stopping: self.stopping.clone(),
                        _place: place,
                    };
                    tokio::spawn(client.greet(stream, self.tls.clone()));
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

/// Where a request comes from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Peer(pub(crate) IpAddr);

/// The other end of a connection.
struct Client {
    router: Router,
    from: IpAddr,
    stopping: watch::Receiver<bool>,
    _place: OwnedSemaphorePermit,
}

impl Client {
    async fn greet(self, stream: TcpStream, tls: Option<TlsAcceptor>) {
        // Frames are small and want to arrive now; without it they would only wait for acknowledgements.
        let _ = stream.set_nodelay(true);
        match tls {
            None => self.serve(stream).await,
            Some(tls) => {
                // Clients that speak something else, or distrust the certificate, are no news.
                if let Ok(Ok(stream)) = timeout(HEADER_TIMEOUT, tls.accept(stream)).await {
                    self.serve(stream).await;
                }
            }
        }
    }

    /// Serves one connection until it ends, becomes a WebSocket, or has had its time.
    async fn serve(mut self, stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static) {
        let (router, from) = (self.router, Peer(self.from));
        let service = service_fn(move |mut request: Request<Incoming>| {
            request.extensions_mut().insert(from);
            router.clone().call(request)
        });
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
            _ = self.stopping.wait_for(|stopped| *stopped) => {}
        }
        connection.as_mut().graceful_shutdown();
        let _ = timeout(GRACE, connection).await;
    }
}
