//! `sextant vrpn` with real sockets: clients that speak the protocol, and some that do not.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::posing_site::{PATIENCE, Server, Site};
use crate::recording::{refused, sextant};
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::time::{Duration, Instant};

const COOKIE: &[u8; 24] = b"vrpn: ver. 07.38  0\0\0\0\0\0";

/// The client's side, after both cookies.
struct Client {
    stream: TcpStream,
    unread: Vec<u8>,
}

#[derive(Debug)]
struct Message {
    sender: i32,
    kind: i32,
    seconds: u32,
    payload: Vec<u8>,
}

impl Client {
    fn greet(mut stream: TcpStream) -> Self {
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut cookie = [0; 24];
        stream.read_exact(&mut cookie).unwrap();
        assert!(cookie.starts_with(b"vrpn: ver. 07."), "{cookie:?}");
        stream.write_all(COOKIE).unwrap();
        let pause = Some(Duration::from_millis(10));
        stream.set_read_timeout(pause).unwrap();
        Self {
            stream,
            unread: Vec::new(),
        }
    }

    /// The next message that is `wanted`, while the site publishes.
    fn next(&mut self, site: &mut Site, wanted: impl Fn(&Message) -> bool) -> Message {
        let deadline = Instant::now() + PATIENCE;
        loop {
            assert!(Instant::now() < deadline, "no such message comes");
            while let Some(message) = self.message() {
                if wanted(&message) {
                    return message;
                }
            }
            site.publish();
            let mut buffer = [0; 4096];
            match self.stream.read(&mut buffer) {
                Ok(0) => panic!("the server has closed the connection"),
                Ok(length) => self.unread.extend(&buffer[..length]),
                Err(cause) => assert_eq!(cause.kind(), ErrorKind::WouldBlock),
            }
        }
    }

    fn message(&mut self) -> Option<Message> {
        let field = |at: usize| Some(self.unread.get(at..at + 4)?.try_into().unwrap());
        let length = u32::from_be_bytes(field(0)?) as usize;
        let end = length.next_multiple_of(8);
        let message = Message {
            seconds: u32::from_be_bytes(field(4)?),
            sender: i32::from_be_bytes(field(12)?),
            kind: i32::from_be_bytes(field(16)?),
            payload: self.unread.get(..end)?[24..length].to_vec(),
        };
        self.unread.drain(..end);
        Some(message)
    }

    fn send(&mut self, sender: i32, kind: i32, payload: &[u8]) {
        let length = (24 + payload.len()) as i32;
        let fields = [length, 0, 0, sender, kind, 0].map(i32::to_be_bytes);
        let mut message = [&fields.concat()[..], payload].concat();
        message.resize(message.len().next_multiple_of(8), 0);
        self.stream.write_all(&message).unwrap();
    }
}

fn described(name: &str) -> Vec<u8> {
    let length = name.len() as u32 + 1;
    [&length.to_be_bytes(), name.as_bytes(), &[0]].concat()
}

/// A client gets the cube's pose, and an answer to its ping.
fn is_served(site: &mut Site, stream: TcpStream) {
    let mut client = Client::greet(stream);
    let describes = |kind: i32, name: &'static str| {
        move |m: &Message| m.kind == kind && m.payload == described(name)
    };
    let pose_kind = client.next(site, describes(-2, "vrpn_Tracker Pos_Quat"));
    let pong = client.next(site, describes(-2, "vrpn_Base pong_message"));
    let cube = client.next(site, describes(-1, "cube"));
    let pose = client.next(site, |m| m.kind == pose_kind.sender);
    assert_eq!((pose.sender, pose.seconds), (cube.sender, 1_800_000_000));
    let numbers = pose.payload[8..].chunks_exact(8);
    let numbers: Vec<f64> = numbers
        .map(|bytes| f64::from_be_bytes(bytes.try_into().unwrap()))
        .collect();
    assert_eq!(numbers, [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0]);
    client.send(5, -1, &described("cube"));
    client.send(6, -2, &described("vrpn_Base ping_message"));
    client.send(5, 6, &[]);
    let answer = client.next(site, |m| m.kind == pong.sender);
    assert_eq!((answer.sender, answer.payload.len()), (cube.sender, 0));
}

#[test]
fn clients_get_poses_whether_they_connect_or_ask_to_be_connected_to() {
    let mut site = Site::open();
    let server = Server::start(&site, &["vrpn"], " at ", ',');
    is_served(&mut site, TcpStream::connect(server.address).unwrap());
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    // The address in the request is another machine's, which must not be connected to.
    let request = format!("192.0.2.1 {port}\0");
    socket.send_to(request.as_bytes(), server.address).unwrap();
    is_served(&mut site, listener.accept().unwrap().0);
    let summary = server.program.interrupt();
    assert_eq!(summary["clients"], 2, "{summary}");
    assert!(summary["sent"].as_u64() >= Some(2), "{summary}");
}

#[test]
fn what_is_no_client_is_turned_away_with_its_first_words() {
    let mut site = Site::open();
    let mut server = Server::start(&site, &["vrpn"], " at ", ',');
    let mut browser = TcpStream::connect(server.address).unwrap();
    browser.set_read_timeout(Some(PATIENCE)).unwrap();
    browser
        .write_all(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
        .unwrap();
    let line = server.line();
    assert!(
        line.contains("turned away") && line.contains("GET / HTTP"),
        "{line}"
    );
    // Its end is that of the connection, or a reset where it had more to say.
    let _ = browser.read_to_end(&mut Vec::new());
    is_served(&mut site, TcpStream::connect(server.address).unwrap());
    let summary = server.program.interrupt();
    assert_eq!(summary["turned_away"], 1, "{summary}");
}

#[test]
fn a_client_that_does_not_read_is_dropped_and_others_are_served() {
    let mut site = Site::open();
    let mut server = Server::start(&site, &["vrpn"], " at ", ',');
    let mut idle = Client::greet(TcpStream::connect(server.address).unwrap());
    // Pings without number, whose answers it never reads.
    idle.next(&mut site, |m| m.payload == described("cube"));
    idle.send(5, -1, &described("cube"));
    idle.send(6, -2, &described("vrpn_Base ping_message"));
    let fields = [24, 0, 0, 5, 6, 0_i32].map(i32::to_be_bytes).concat();
    let pings = fields.repeat(1000);
    let deadline = Instant::now() + PATIENCE;
    while idle.stream.write_all(&pings).is_ok() {
        assert!(Instant::now() < deadline, "it is served for ever");
    }
    let line = server.line();
    assert!(line.contains("does not read"), "{line}");
    is_served(&mut site, TcpStream::connect(server.address).unwrap());
    let summary = server.program.interrupt();
    assert_eq!(summary["slow"], 1, "{summary}");
}

#[test]
fn more_clients_than_can_be_served_are_turned_away() {
    let site = Site::open();
    let server = Server::start(&site, &["vrpn"], " at ", ',');
    let connect = || TcpStream::connect(server.address).unwrap();
    let clients: Vec<Client> = (0..64).map(|_| Client::greet(connect())).collect();
    let mut late = connect();
    late.set_read_timeout(Some(PATIENCE)).unwrap();
    assert_eq!(late.read_to_end(&mut Vec::new()).unwrap_or(0), 0);
    drop(clients);
}

#[test]
fn an_address_in_use_or_without_sense_is_refused() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let taken = taken.local_addr().unwrap().to_string();
    let run = |listen: &str| {
        sextant()
            .args(["vrpn", "--listen", listen])
            .output()
            .unwrap()
    };
    refused(&run(&taken), 4, "name another address or port");
    refused(&run("127.0.0.1:port"), 2, "write HOST:PORT");
}
