//! Writes a recording, chunk by chunk.

use super::{METADATA, RecordingInfo, WIRE_ENCODING};
use crate::compressed_image::{self as image, RecordedImage};
use crate::error::RecordingError;
use crate::foxglove::schema::Schema;
use crate::foxglove::{self, ViewerMessage};
use ::mcap::records::{MessageHeader, Metadata};
use ::mcap::write::NoSeek;
use ::mcap::{Compression, McapError, McapResult, WriteOptions, Writer};
use sextant_proto::{AnyMessage, VERSION};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Most channels of a file: a flood of keys must not fill the memory.
const MOST_CHANNELS: usize = 16384;
/// Longest message.
const MOST_BYTES: usize = 32 << 20;

/// Times of a message, ns since the Unix epoch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MessageTimes {
    /// Arrival at the recorder.
    pub arrival_ns: u64,
    /// Capture, where it is known, else arrival.
    pub capture_ns: u64,
}

/// A file that is being written. What was written since the last [`Self::flush`] is lost if the process is killed.
pub struct McapWriter<W: Write> {
    path: PathBuf,
    file: Writer<NoSeek<W>>,
    channels: BTreeMap<String, Channel>,
    metadata: BTreeMap<String, String>,
    messages: u64,
    dropped: u64,
}

#[derive(Debug, Clone, Copy)]
struct Channel {
    id: u16,
    next: u32,
}

impl<W: Write> McapWriter<W> {
    /// Begins a recording; `path` is named in errors.
    ///
    /// # Errors
    /// An I/O error, as a full disk.
    pub fn begin(file: W, path: &Path, info: &RecordingInfo) -> Result<Self, RecordingError> {
        let about = [
            ("contract", VERSION.to_string()),
            ("site", info.site.clone()),
            ("version", info.version.clone()),
        ];
        let about = Metadata {
            name: METADATA.to_owned(),
            metadata: about.map(|(key, value)| (key.to_owned(), value)).into(),
        };
        // A chunk waits in memory until it is whole, so that one that was not flushed leaves nothing in the file.
        let options = WriteOptions::new()
            .compression(Some(Compression::Lz4))
            .library(format!("sextant {}", info.version))
            .disable_seeking(true);
        let begun = options.create(NoSeek::new(file)).and_then(|mut file| {
            file.write_metadata(&about)?;
            file.flush()?;
            Ok(file)
        });
        let file = begun.map_err(|cause| unwritable(path, cause))?;
        Ok(Self {
            path: path.to_owned(),
            file,
            channels: BTreeMap::new(),
            metadata: BTreeMap::from([("contract".to_owned(), VERSION.to_string())]),
            messages: 0,
            dropped: 0,
        })
    }

    /// Writes a payload that arrived under a key, and what viewers show of it. A payload that is no message is dropped
    /// and counted.
    ///
    /// # Errors
    /// An I/O error.
    pub fn write_payload(
        &mut self,
        key: &str,
        payload: &[u8],
        arrival_ns: u64,
    ) -> Result<(), RecordingError> {
        let Ok(message) = AnyMessage::decode(payload) else {
            self.dropped += 1;
            return Ok(());
        };
        let times = MessageTimes {
            arrival_ns,
            capture_ns: capture_ns(&message).unwrap_or(arrival_ns),
        };
        let schema = || Schema {
            name: format!("{:?}", message.kind()),
            encoding: String::new(),
            data: Cow::default(),
            message_encoding: WIRE_ENCODING.to_owned(),
        };
        self.write(key, schema, payload, times)?;
        for shown in foxglove::messages(&message, arrival_ns) {
            self.write_shown(&shown, times)?;
        }
        Ok(())
    }

    /// Writes an image.
    ///
    /// # Errors
    /// An I/O error.
    pub fn write_image(
        &mut self,
        image: &RecordedImage,
        arrival_ns: u64,
    ) -> Result<(), RecordingError> {
        let times = MessageTimes {
            arrival_ns,
            capture_ns: image.capture_ns,
        };
        let shown = ViewerMessage::ros(image::topic(&image.camera), &image::image_message(image));
        self.write_shown(&shown, times)
    }

    fn write_shown(
        &mut self,
        shown: &ViewerMessage,
        times: MessageTimes,
    ) -> Result<(), RecordingError> {
        self.write(&shown.topic, shown.schema, &shown.data, times)
    }

    fn write(
        &mut self,
        topic: &str,
        schema: impl FnOnce() -> Schema,
        data: &[u8],
        times: MessageTimes,
    ) -> Result<(), RecordingError> {
        let is_new = !self.channels.contains_key(topic);
        if data.len() > MOST_BYTES || (is_new && self.channels.len() >= MOST_CHANNELS) {
            self.dropped += 1;
            return Ok(());
        }
        let written = self.write_message(topic, schema, data, times);
        written.map_err(|cause| unwritable(&self.path, cause))?;
        self.messages += 1;
        Ok(())
    }

    fn write_message(
        &mut self,
        topic: &str,
        schema: impl FnOnce() -> Schema,
        data: &[u8],
        times: MessageTimes,
    ) -> McapResult<()> {
        let channel = match self.channels.get_mut(topic) {
            Some(channel) => channel,
            None => {
                let channel = self.add_channel(topic, &schema())?;
                self.channels.entry(topic.to_owned()).or_insert(channel)
            }
        };
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.next,
            log_time: times.arrival_ns,
            publish_time: times.capture_ns,
        };
        channel.next = channel.next.wrapping_add(1);
        self.file.write_to_known_channel(&header, data)
    }

    fn add_channel(&mut self, topic: &str, schema: &Schema) -> McapResult<Channel> {
        let Schema {
            name,
            encoding,
            data,
            message_encoding,
        } = schema;
        let schema = self.file.add_schema(name, encoding, data)?;
        let id = self
            .file
            .add_channel(schema, topic, message_encoding, &self.metadata)?;
        Ok(Channel { id, next: 0 })
    }

    /// Completes the chunk: what was written until now outlives this process.
    ///
    /// # Errors
    /// An I/O error.
    pub fn flush(&mut self) -> Result<(), RecordingError> {
        let flushed = self.file.flush();
        flushed.map_err(|cause| unwritable(&self.path, cause))
    }

    /// Completes the file with its index and returns what it was written to.
    ///
    /// # Errors
    /// An I/O error.
    pub fn finish(mut self) -> Result<W, RecordingError> {
        let finished = self.file.finish();
        finished.map_err(|cause| unwritable(&self.path, cause))?;
        Ok(self.file.into_inner().into_inner())
    }

    /// Messages written, those for viewers included.
    #[must_use]
    pub fn messages(&self) -> u64 {
        self.messages
    }

    /// Messages that were not written: payloads of another version or damaged, too long, or of too many channels.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }
}

/// The capture time that a message states.
fn capture_ns(message: &AnyMessage) -> Option<u64> {
    match message {
        AnyMessage::Observations(message) => Some(message.capture_ns),
        AnyMessage::Preview(message) => Some(message.capture_ns),
        AnyMessage::DetectionReport(message) => Some(message.capture_ns),
        AnyMessage::ObjectPose(message) => Some(message.capture_ns),
        AnyMessage::ObjectLinks(message) => Some(message.capture_ns),
        AnyMessage::ObjectTruth(message) => Some(message.capture_ns),
        _ => None,
    }
}

pub(super) fn unwritable(path: &Path, cause: McapError) -> RecordingError {
    let source = match cause {
        McapError::Io(source) => source,
        other => io::Error::other(other),
    };
    let remedy = match source.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "free space or record elsewhere; what was written until now can be replayed"
        }
        _ => "check the folder and the disk",
    };
    RecordingError::Unreadable {
        path: path.to_owned(),
        source,
        remedy,
    }
}
