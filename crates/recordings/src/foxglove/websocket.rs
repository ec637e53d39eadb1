//! The messages of `foxglove.sdk.v1`, the WebSocket protocol of Foxglove and Lichtblick
//! (github.com/foxglove/ws-protocol, `spec.md`): what a server that only publishes says, and the two requests that it
//! understands. Texts are JSON; data is binary and little-endian.

use super::schema::Schema;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Deserialize;
use serde_json::json;

/// Subprotocols of the WebSocket, the preferred one first. The second is the name that older viewers give to the same
/// messages.
pub const SUBPROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/// The first message. A client that reconnects and finds another `session` forgets what it knew.
#[must_use]
pub fn server_info(name: &str, session: &str) -> String {
    json!({ "op": "serverInfo", "name": name, "capabilities": [], "sessionId": session })
        .to_string()
}

/// A channel for clients to choose from.
#[derive(Debug, Clone, Copy)]
pub struct AdvertisedChannel<'a> {
    /// Its number.
    pub id: u32,
    /// Its topic.
    pub topic: &'a str,
    /// Of its messages.
    pub schema: fn() -> Schema,
}

/// Offers channels. Schemas that are no text are in base64.
#[must_use]
pub fn advertise<'a>(channels: impl IntoIterator<Item = AdvertisedChannel<'a>>) -> String {
    let channels = channels.into_iter().map(|channel| {
        let schema = (channel.schema)();
        let data = match &*schema.encoding {
            "protobuf" => BASE64_STANDARD.encode(&schema.data),
            _ => String::from_utf8_lossy(&schema.data).into_owned(),
        };
        json!({
            "id": channel.id,
            "topic": channel.topic,
            "encoding": schema.message_encoding,
            "schemaName": schema.name,
            "schemaEncoding": schema.encoding,
            "schema": data,
        })
    });
    json!({ "op": "advertise", "channels": channels.collect::<Vec<_>>() }).to_string()
}

/// A message for a subscription: opcode 1, subscription, time (ns since the Unix epoch), payload.
#[must_use]
pub fn message_data(subscription: u32, log_ns: u64, data: &[u8]) -> Vec<u8> {
    const MESSAGE_DATA: u8 = 1;
    let mut frame = Vec::with_capacity(13 + data.len());
    frame.push(MESSAGE_DATA);
    frame.extend(subscription.to_le_bytes());
    frame.extend(log_ns.to_le_bytes());
    frame.extend_from_slice(data);
    frame
}

/// What a client wants.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub enum ClientRequest {
    /// Messages of channels.
    Subscribe {
        /// Each with the number that the client gives it.
        subscriptions: Vec<Subscription>,
    },
    /// No more of them.
    #[serde(rename_all = "camelCase")]
    Unsubscribe {
        /// Numbers that the client gave.
        subscription_ids: Vec<u32>,
    },
    /// Whatever a server without capabilities passes over.
    #[serde(other)]
    Other,
}

/// A wish for the messages of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Subscription {
    /// The client's number of it.
    pub id: u32,
    /// The channel.
    pub channel_id: u32,
}

impl ClientRequest {
    /// Reads a text; `None` for one that is no request.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        serde_json::from_str(text).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foxglove::schema;
    use ::foxglove::messages::FrameTransforms;
    use serde_json::Value;
    use sextant_ros2::messages::CompressedImage;

    /// The examples of the specification.
    #[test]
    fn requests_are_read() {
        let subscribe =
            r#"{"op":"subscribe","subscriptions":[{"id":0,"channelId":3},{"id":1,"channelId":5}]}"#;
        let wanted = [(0, 3), (1, 5)].map(|(id, channel_id)| Subscription { id, channel_id });
        assert_eq!(
            ClientRequest::parse(subscribe),
            Some(ClientRequest::Subscribe {
                subscriptions: wanted.into()
            })
        );
        assert_eq!(
            ClientRequest::parse(r#"{"op":"unsubscribe","subscriptionIds":[0,1]}"#),
            Some(ClientRequest::Unsubscribe {
                subscription_ids: vec![0, 1]
            })
        );
        let other = r#"{"op":"getParameters","parameterNames":[],"id":"request-123"}"#;
        assert_eq!(ClientRequest::parse(other), Some(ClientRequest::Other));
        for wrong in [
            "",
            "[]",
            r#"{"op":"subscribe"}"#,
            r#"{"op":"subscribe","subscriptions":[{"id":-1}]}"#,
        ] {
            assert_eq!(ClientRequest::parse(wrong), None);
        }
    }

    #[test]
    fn a_message_begins_with_its_subscription_and_time() {
        let frame = message_data(30, 1234, b"{}");
        assert_eq!(frame[..5], [1, 30, 0, 0, 0]);
        assert_eq!(frame[5..13], 1234_u64.to_le_bytes());
        assert_eq!(&frame[13..], b"{}");
    }

    #[test]
    fn channels_carry_their_schemas() {
        let channel = |id, topic, schema: fn() -> Schema| AdvertisedChannel { id, topic, schema };
        let offer = advertise([
            channel(1, "/rig", schema::protobuf::<FrameTransforms>),
            channel(2, "/camera/a/preview", schema::ros::<CompressedImage>),
        ]);
        let offer: Value = serde_json::from_str(&offer).unwrap();
        assert_eq!(offer["op"], "advertise");
        let [rig, preview] = [0, 1].map(|n| &offer["channels"][n]);
        assert_eq!(rig["schemaName"], "foxglove.FrameTransforms");
        assert_eq!(
            (&rig["encoding"], &rig["schemaEncoding"]),
            (&json!("protobuf"), &json!("protobuf"))
        );
        let descriptor = BASE64_STANDARD.decode(rig["schema"].as_str().unwrap());
        assert_eq!(
            descriptor.unwrap(),
            *schema::protobuf::<FrameTransforms>().data
        );
        assert_eq!(
            (&preview["encoding"], &preview["schemaEncoding"]),
            (&json!("cdr"), &json!("ros2msg"))
        );
    }
}
