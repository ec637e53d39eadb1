//! Recordings of a site as one MCAP file (<https://mcap.dev/spec>): wire payloads, lossless images, and messages for
//! viewers.
//!
//! - A wire payload has its zenoh key as topic, message encoding `sextant`, and its kind as the name of its schema.
//! - An image has the topic `/camera/<camera>/image`: a PNG in `sensor_msgs/msg/CompressedImage`
//!   ([`crate::compressed_image`]).
//! - What viewers show is protobuf of Foxglove's schemas, and ROS messages ([`crate::foxglove`]); nothing here reads it
//!   back.
//! - [`ros2_bag`]: a recording as a bag of ROS 2.
//!
//! `log_time` is the arrival at the recorder, `publish_time` the capture time where there is one. Chunks are compressed
//! with LZ4 and complete once [`writer::McapWriter::flush`] returns, so that a killed recorder loses what it got since,
//! and nothing else.
//!
//! Records, chunks and indexes are the crate `mcap`'s. Ours is what it has no word for: where a record begins, how long
//! it may be, and what a cut or damaged file lost.

use ::mcap::MAGIC;
use std::fs::File;
use std::io::Read;
use std::path::Path;

pub mod reader;
pub mod ros2_bag;
pub mod site_recording;
pub mod writer;

/// Message encoding of wire payloads.
pub const WIRE_ENCODING: &str = "sextant";
/// Name of the metadata record about the recording.
const METADATA: &str = "sextant";

/// Whether a file is an MCAP file, by its first bytes.
#[must_use]
pub fn is_mcap_file(path: &Path) -> bool {
    let mut first = [0; MAGIC.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut first));
    read.is_ok() && first == *MAGIC
}

/// What a recording says about itself.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RecordingInfo {
    /// Name of the site, the middle of every key.
    pub site: String,
    /// Version of the program that recorded.
    pub version: String,
}
