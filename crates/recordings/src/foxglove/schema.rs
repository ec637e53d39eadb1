//! Schemas by which viewers know messages: Foxglove's in protobuf, which all of them decode, and ROS's in CDR where
//! Foxglove has none.

use foxglove::Encode;
use sextant_ros2::RosMessage;
use std::borrow::Cow;

/// A schema, and how messages of it are encoded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Schema {
    /// Its name.
    pub name: String,
    /// Encoding of `data`.
    pub encoding: String,
    /// The schema itself.
    pub data: Cow<'static, [u8]>,
    /// Encoding of its messages.
    pub message_encoding: String,
}

/// Of a message of Foxglove: a serialised FileDescriptorSet.
#[must_use]
pub fn protobuf<M: Encode>() -> Schema {
    let schema = M::get_schema();
    let schema = schema.unwrap_or_else(|| ::foxglove::Schema::new("", "", &[][..]));
    Schema {
        name: schema.name,
        encoding: schema.encoding,
        data: schema.data,
        message_encoding: M::get_message_encoding(),
    }
}

/// Of a ROS message: its definition.
#[must_use]
pub fn ros<M: RosMessage>() -> Schema {
    Schema {
        name: M::TYPE_NAME.to_owned(),
        encoding: sextant_ros2::SCHEMA_ENCODING.to_owned(),
        data: sextant_ros2::definition::<M>().into_bytes().into(),
        message_encoding: sextant_ros2::MESSAGE_ENCODING.to_owned(),
    }
}
