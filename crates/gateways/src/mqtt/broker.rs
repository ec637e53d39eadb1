//! A broker's address and the connection to it, by TCP or TLS.

use crate::relay::{self, HostAndPort};
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use sextant_pose_streams::{
    MQTT_END, MQTT_PING, MQTT_PORT, MQTT_TLS_PORT, MqttAnswer, MqttGreeting, MqttReader, Retention,
    mqtt_publish,
};
use std::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Interval of pings.
const PING: Duration = Duration::from_secs(3);

/// Address of an MQTT broker, and how it is trusted.
#[derive(Debug, Clone)]
pub struct Broker {
    server: HostAndPort,
    tls: Option<Arc<ClientConfig>>,
}

/// Trusted authorities under TLS.
#[derive(Debug, Clone, Copy)]
pub enum Tls<'a> {
    /// The authorities of this system.
    System,
    /// Those of a file in PEM.
    File(&'a Path),
}

/// Why a broker cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum BrokerError {
    /// What is no address of a broker.
    #[error("write mqtt://HOST, mqtts://HOST for TLS, or either with :PORT")]
    Address,
    /// Certificates that cannot be read.
    #[error("{0}")]
    Certificates(String),
    /// No connection, or its end.
    #[error("{0}")]
    Connection(#[from] io::Error),
    /// The broker refuses: name, password or version.
    #[error("it refuses: {0}")]
    Refused(String),
    /// The broker has ended the connection.
    #[error("{0}")]
    Ended(String),
    /// Another protocol.
    #[error("it does not speak MQTT; look at the port")]
    NoMqtt,
    /// It does not answer.
    #[error("it does not answer")]
    Silent,
}

impl Broker {
    /// Reads `mqtt://HOST[:PORT]` or `mqtts://HOST[:PORT]`.
    ///
    /// # Errors
    /// An address that is none; certificates that cannot be read.
    pub fn parse(address: &str, trust: Tls<'_>) -> Result<Self, BrokerError> {
        let (rest, usual_port, is_secret) = match address.split_once("://") {
            Some(("mqtt", rest)) => (rest, MQTT_PORT, false),
            Some(("mqtts", rest)) => (rest, MQTT_TLS_PORT, true),
            Some(_) => return Err(BrokerError::Address),
            None => (address, MQTT_PORT, false),
        };
        let server = HostAndPort::parse(rest, usual_port).ok_or(BrokerError::Address)?;
        let tls = is_secret.then(|| client_config(trust)).transpose()?;
        Ok(Self { server, tls })
    }

    /// Whether what is sent can be read on the way.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        self.tls.is_none()
    }

    /// Connects, and waits until the greeting is accepted.
    pub(super) fn connect(&self, greeting: &MqttGreeting) -> Result<Connection, BrokerError> {
        let tcp = self.server.dial()?;
        tcp.set_nodelay(true)?;
        tcp.set_write_timeout(Some(relay::CONNECT_TIMEOUT))?;
        tcp.set_read_timeout(Some(relay::CONNECT_TIMEOUT))?;
        let handle = tcp.try_clone()?;
        let stream: Box<dyn Stream> = match &self.tls {
            None => Box::new(tcp),
            Some(config) => {
                let name = ServerName::try_from(self.server.host().to_owned());
                let name = name.map_err(|_| BrokerError::Address)?;
                let tls = ClientConnection::new(Arc::clone(config), name);
                Box::new(StreamOwned::new(tls.map_err(io::Error::other)?, tcp))
            }
        };
        let (topic, offline) = &greeting.will;
        let now = Instant::now();
        let mut connection = Connection {
            stream,
            last: mqtt_publish(topic, offline.as_bytes(), Retention::Retained),
            reader: MqttReader::default(),
            heard: now,
            ping_due: now + PING,
            look_due: now,
        };
        connection.write(&greeting.to_bytes())?;
        while now.elapsed() < relay::CONNECT_TIMEOUT {
            connection.read()?;
            match connection.reader.next_answer() {
                Ok(Some(MqttAnswer::Accepted)) => {
                    handle.set_read_timeout(Some(relay::READ_TIMEOUT))?;
                    return Ok(connection);
                }
                Ok(Some(MqttAnswer::Refused(cause) | MqttAnswer::Ended(cause))) => {
                    return Err(BrokerError::Refused(cause));
                }
                Ok(Some(MqttAnswer::Alive) | None) => {}
                Err(_) => return Err(BrokerError::NoMqtt),
            }
        }
        Err(BrokerError::Silent)
    }
}

impl fmt::Display for Broker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.server.fmt(f)
    }
}

fn client_config(trust: Tls<'_>) -> Result<Arc<ClientConfig>, BrokerError> {
    let mut roots = RootCertStore::empty();
    match trust {
        Tls::System => {
            let found = rustls_native_certs::load_native_certs();
            roots.add_parsable_certificates(found.certs);
        }
        Tls::File(file) => {
            let unreadable =
                |cause: String| BrokerError::Certificates(format!("{}: {cause}", file.display()));
            let certificates = CertificateDer::pem_file_iter(file);
            for certificate in certificates.map_err(|cause| unreadable(cause.to_string()))? {
                let certificate = certificate.map_err(|cause| unreadable(cause.to_string()))?;
                let added = roots.add(certificate);
                added.map_err(|cause| unreadable(cause.to_string()))?;
            }
        }
    }
    if roots.is_empty() {
        let cause = "no certificate of an authority; name a file in PEM with --ca";
        return Err(BrokerError::Certificates(cause.to_owned()));
    }
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .map_err(|cause| BrokerError::Certificates(cause.to_string()))?;
    let config = config.with_root_certificates(roots);
    Ok(Arc::new(config.with_no_client_auth()))
}

trait Stream: Read + Write + Send {}
impl<T: Read + Write + Send> Stream for T {}

/// A connection whose greeting was accepted.
pub(super) struct Connection {
    stream: Box<dyn Stream>,
    /// What an orderly end says itself: the will.
    last: Vec<u8>,
    reader: MqttReader,
    /// When the broker last said something.
    heard: Instant,
    ping_due: Instant,
    look_due: Instant,
}

impl relay::Connection for Connection {
    type Message = Vec<u8>;
    type Error = BrokerError;

    /// Waits for 5 s at most.
    fn send(&mut self, packet: &Vec<u8>) -> Result<(), BrokerError> {
        self.write(packet)
    }

    fn turn(&mut self) -> Result<(), BrokerError> {
        let now = Instant::now();
        if now >= self.ping_due {
            self.ping_due = now + PING;
            self.write(&MQTT_PING)?;
        }
        if now < self.look_due {
            return Ok(());
        }
        self.look_due = now + relay::POLL_PERIOD;
        self.read()?;
        while let Some(answer) = self.reader.next_answer().map_err(|_| BrokerError::NoMqtt)? {
            if let MqttAnswer::Ended(cause) = answer {
                return Err(BrokerError::Ended(cause));
            }
        }
        match self.heard.elapsed() < relay::SERVER_SILENCE {
            true => Ok(()),
            false => Err(BrokerError::Silent),
        }
    }

    fn end(mut self) -> Result<(), BrokerError> {
        self.write(&self.last.clone())?;
        self.write(&MQTT_END)
    }
}

impl Connection {
    fn write(&mut self, packet: &[u8]) -> Result<(), BrokerError> {
        self.stream.write_all(packet)?;
        Ok(self.stream.flush()?)
    }

    /// Takes what has arrived.
    fn read(&mut self) -> Result<(), BrokerError> {
        let mut buffer = [0; 4096];
        match self.stream.read(&mut buffer) {
            Ok(0) => Err(BrokerError::Ended(
                "it has closed the connection".to_owned(),
            )),
            Ok(length) => {
                self.heard = Instant::now();
                self.reader.take(&buffer[..length]);
                Ok(())
            }
            Err(cause) => match cause.kind() {
                ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => Ok(()),
                _ => Err(cause.into()),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_name_host_port_and_tls() {
        for (text, whole) in [
            ("mqtt://broker.lab", "broker.lab:1883"),
            ("broker.lab", "broker.lab:1883"),
            ("10.0.0.1:2000", "10.0.0.1:2000"),
            ("mqtt://[::1]", "[::1]:1883"),
            ("mqtt://[::1]:99", "[::1]:99"),
        ] {
            let broker = Broker::parse(text, Tls::System).unwrap();
            assert_eq!(
                (broker.to_string().as_str(), broker.is_plain()),
                (whole, true)
            );
        }
        for wrong in [
            "http://broker",
            "mqtt://",
            "mqtt://a:b",
            "mqtt://a:0",
            "mqtt://a/b",
            ":1",
        ] {
            let error = Broker::parse(wrong, Tls::System).unwrap_err();
            assert!(matches!(error, BrokerError::Address), "{wrong}");
        }
        let none = Tls::File(Path::new("/nonexistent.pem"));
        let error = Broker::parse("mqtts://broker", none).unwrap_err();
        assert!(
            error.to_string().starts_with("/nonexistent.pem: "),
            "{error}"
        );
    }
}
