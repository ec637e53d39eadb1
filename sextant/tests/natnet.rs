//! `sextant natnet` with real sockets: clients that ask for frames at their own address, and what is no client.
//! `clients/python/tests/test_natnet.py` has the clients that people use.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::posing_site::{PATIENCE, Server, Site};
use crate::recording::{refused, sextant};
use std::net::UdpSocket;
use std::time::{Duration, Instant};

const CONNECT: u16 = 0;
const REQUEST_MODELS: u16 = 4;
const FRAME: u16 = 7;
const DISCONNECT: u16 = 9;
const KEEP_ALIVE: u16 = 10;

struct Client(UdpSocket);

impl Client {
    fn connect(server: &Server) -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.connect(server.address).unwrap();
        let wait = Some(Duration::from_millis(10));
        socket.set_read_timeout(wait).unwrap();
        Self(socket)
    }

    fn send(&self, kind: u16) {
        let message = [kind, 0].map(u16::to_le_bytes).concat();
        self.0.send(&message).unwrap();
    }

    /// The next message of a kind, while the site publishes.
    fn next(&self, site: &mut Site, kind: u16) -> Vec<u8> {
        let (deadline, mut buffer) = (Instant::now() + PATIENCE, [0; 2048]);
        loop {
            assert!(Instant::now() < deadline, "no message of kind {kind} comes");
            site.publish();
            if let Ok(length) = self.0.recv(&mut buffer)
                && buffer[..2] == kind.to_le_bytes()
            {
                return buffer[..length].to_vec();
            }
        }
    }
}

#[test]
fn clients_get_frames_at_their_own_address_until_they_leave() {
    let mut site = Site::open();
    site.announce(&["cube", "tray"]);
    let arguments = ["natnet", "--unicast", "--protocol", "3.1", "--axes", "y-up"];
    let server = Server::start(&site, &arguments, " at ", ',');
    let clients = [Client::connect(&server), Client::connect(&server)];
    // What is no message changes nothing.
    clients[0].0.send(b"x").unwrap();
    clients[0].0.send(&[0xff; 1000]).unwrap();
    for client in &clients {
        client.send(CONNECT);
        let info = client.next(&mut site, 1);
        assert_eq!((info.len(), info[264..266].to_vec()), (283, vec![3, 1]));
        client.send(KEEP_ALIVE);
        let frame = client.next(&mut site, FRAME);
        let position = [20, 24, 28].map(|at| frame[at + 4..at + 8].to_vec());
        assert_eq!(
            position,
            [1_f32, 3.0, -2.0].map(|x| x.to_le_bytes().to_vec())
        );
    }
    clients[0].send(REQUEST_MODELS);
    let models = clients[0].next(&mut site, 5);
    let names = ["cube", "tray"].map(|name| [name.as_bytes(), &[0]].concat());
    assert_eq!(models[4..8], 2_u32.to_le_bytes());
    for name in names {
        assert!(models.windows(name.len()).any(|part| part == name));
    }
    for client in clients {
        client.send(DISCONNECT);
    }
    let summary = server.program.interrupt();
    assert_eq!(summary["clients"], 2, "{summary}");
    assert_eq!(summary["unrecognized"], 2, "{summary}");
}

#[test]
fn wrong_options_and_an_address_in_use_are_refused() {
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let taken = taken.local_addr().unwrap().to_string();
    let run = |arguments: &[&str]| sextant().arg("natnet").args(arguments).output().unwrap();
    refused(
        &run(&["--listen", &taken]),
        4,
        "name another address or port",
    );
    refused(&run(&["--axes", "unity"]), 2, "use y-up");
    refused(&run(&["--protocol", "2.9"]), 2, "3.0, 3.1 or 4.1");
    refused(
        &run(&["--multicast", "10.0.0.1:1511"]),
        2,
        "239.255.42.99:1511",
    );
}
