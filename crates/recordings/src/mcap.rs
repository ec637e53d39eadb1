//! Recordings of a site as one MCAP file (<https://mcap.dev/spec>): wire payloads, lossless images, and messages for viewers.
//!
//! - A wire payload has its zenoh key as topic, message encoding `sextant`, and its kind as the name of its schema.
//! - An image has the topic `/camera/<camera>/image`: a PNG in `sensor_msgs/msg/CompressedImage` ([`crate::compressed_image`]).
//! - What Foxglove and Lichtblick show is JSON of Foxglove's schemas, and previews ([`crate::foxglove`]); nothing here reads it back.
//!
//! `log_time` is the arrival at the recorder, `publish_time` the capture time where there is one. Chunks are compressed with LZ4 and complete
//! once [`writer::McapWriter::flush`] returns, so that a killed recorder loses what it got since, and nothing else.

mod bytes;
mod container;
pub mod reader;
pub mod site_recording;
pub mod writer;

/// First and last bytes of every file.
pub const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];
/// Message encoding of wire payloads.
pub const WIRE_ENCODING: &str = "sextant";
/// Name of the metadata record about the recording.
const METADATA: &str = "sextant";
/// Compression of chunks.
const LZ4: &str = "lz4";

/// Kinds of record.
mod opcode {
    pub const HEADER: u8 = 0x01;
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const MESSAGE_INDEX: u8 = 0x07;
    pub const CHUNK_INDEX: u8 = 0x08;
    pub const STATISTICS: u8 = 0x0b;
    pub const METADATA: u8 = 0x0c;
    pub const METADATA_INDEX: u8 = 0x0d;
    pub const DATA_END: u8 = 0x0f;
}

/// What a recording says about itself.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RecordingInfo {
    /// Name of the site, the middle of every key.
    pub site: String,
    /// Version of the program that recorded.
    pub version: String,
}
