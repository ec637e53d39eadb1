//! `sextant foxglove` with a WebSocket client that speaks the protocol of Foxglove and Lichtblick.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::posing_site::{PATIENCE, Server, Site};
use crate::recording::{sextant, stdout};
use foxglove::Decode;
use foxglove::messages::{FrameTransforms, SceneUpdate, Vector3};
use serde_json::{Value, json};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

type Socket = WebSocket<MaybeTlsStream<TcpStream>>;

fn connect(address: SocketAddr, protocols: &str) -> tungstenite::Result<Socket> {
    let mut request = format!("ws://{address}").into_client_request()?;
    let offer = protocols.parse().unwrap();
    request
        .headers_mut()
        .insert("sec-websocket-protocol", offer);
    let (socket, response) = tungstenite::connect(request)?;
    let chosen = response.headers().get("sec-websocket-protocol");
    assert_eq!(chosen.unwrap(), "foxglove.sdk.v1");
    let MaybeTlsStream::Plain(stream) = socket.get_ref() else {
        panic!("plain")
    };
    stream.set_read_timeout(Some(Duration::from_millis(10)))?;
    Ok(socket)
}

struct Viewer {
    socket: Socket,
}

impl Viewer {
    fn new(address: SocketAddr) -> Self {
        let offer = "foxglove.websocket.v1, foxglove.sdk.v1";
        Self {
            socket: connect(address, offer).unwrap(),
        }
    }

    /// The next thing that `wanted` finds in what comes, while the site publishes.
    fn next<T>(&mut self, site: &mut Site, wanted: impl Fn(&Message) -> Option<T>) -> T {
        let deadline = Instant::now() + PATIENCE;
        loop {
            assert!(Instant::now() < deadline, "nothing of that kind comes");
            site.publish();
            match self.socket.read() {
                Ok(message) => {
                    if let Some(found) = wanted(&message) {
                        return found;
                    }
                }
                Err(tungstenite::Error::Io(_)) => {}
                Err(cause) => panic!("{cause}"),
            }
        }
    }

    fn operation(&mut self, site: &mut Site, op: &str) -> Value {
        self.next(site, |message| {
            let text: Value = serde_json::from_str(message.to_text().ok()?).ok()?;
            (text["op"] == op).then_some(text)
        })
    }

    /// Waits for a topic to be offered.
    fn channel(&mut self, site: &mut Site, topic: &str) -> Value {
        loop {
            let offer = self.operation(site, "advertise");
            let channels = offer["channels"].as_array().unwrap();
            if let Some(channel) = channels.iter().find(|channel| channel["topic"] == topic) {
                return channel.clone();
            }
        }
    }

    fn subscribe(&mut self, id: u32, channel: &Value) {
        let request =
            json!({"op": "subscribe", "subscriptions": [{"id": id, "channelId": channel["id"]}]});
        self.socket
            .send(Message::text(request.to_string()))
            .unwrap();
    }

    /// The next message of a subscription.
    fn data<M: Decode>(&mut self, site: &mut Site, id: u32) -> M {
        self.next(site, |message| match message {
            Message::Binary(bytes) if bytes[..5] == [&[1], &id.to_le_bytes()[..]].concat() => {
                Some(M::decode(&bytes[13..]).ok().unwrap())
            }
            _ => None,
        })
    }
}

#[test]
fn a_viewer_sees_objects_and_what_was_there_before_it() {
    let mut site = Site::open();
    site.announce(&["cube"]);
    let server = Server::start(&site, &["foxglove"], "ws://", ' ');
    let mut viewer = Viewer::new(server.address);
    let info = viewer.operation(&mut site, "serverInfo");
    assert_eq!(
        (&info["name"], &info["capabilities"]),
        (&json!("Sextant lab"), &json!([]))
    );
    let transform = viewer.channel(&mut site, "/object/cube/transform");
    assert_eq!(transform["schemaName"], "foxglove.FrameTransforms");
    assert_eq!(transform["encoding"], "protobuf");
    viewer.subscribe(7, &transform);
    let message: FrameTransforms = viewer.data(&mut site, 7);
    let transform = &message.transforms[0];
    assert_eq!(transform.child_frame_id, "object/cube");
    let (x, y, z) = (1.0, 2.0, 3.0);
    assert_eq!(transform.translation, Some(Vector3 { x, y, z }));
    // The object was announced before anybody was there.
    let mut late = Viewer::new(server.address);
    let tags = late.channel(&mut site, "/object/cube/tags");
    late.subscribe(8, &tags);
    let tags: SceneUpdate = late.data(&mut site, 8);
    let found = (tags.entities.len(), tags.deletions.len());
    assert_eq!(found, (0, 1), "the object has no placed tag: {tags:?}");
    let summary = server.program.interrupt();
    assert_eq!(summary["clients"], 2, "{summary}");
    assert!(summary["sent"].as_u64() >= Some(2), "{summary}");
}

#[test]
fn other_protocols_are_refused_with_a_word() {
    let site = Site::open();
    let mut server = Server::start(&site, &["foxglove"], "ws://", ' ');
    let refused = connect(server.address, "mqtt");
    let Err(tungstenite::Error::Http(answer)) = refused else {
        panic!("{refused:?}")
    };
    assert_eq!(answer.status(), 400);
    let line = server.line();
    assert!(
        line.contains("turned away") && line.contains("Foxglove WebSocket"),
        "{line}"
    );
    let summary = server.program.interrupt();
    assert_eq!(summary["turned_away"], 1, "{summary}");
}

#[test]
fn the_layout_has_the_objects_of_the_site() {
    let mut site = Site::open();
    site.announce(&["cube", "tray"]);
    let output = site
        .command(&["foxglove", "--print-layout"])
        .output()
        .unwrap();
    let layout: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let topics = &layout["configById"]["3D!room"]["topics"];
    assert_eq!(topics["/object/tray/ellipsoid"]["visible"], true);
    assert_eq!(layout["layout"]["first"], "3D!room");
}

#[test]
fn an_address_that_is_none_is_refused() {
    let output = sextant()
        .args(["foxglove", "--listen", "here"])
        .output()
        .unwrap();
    crate::recording::refused(&output, 2, "write HOST:PORT");
}
