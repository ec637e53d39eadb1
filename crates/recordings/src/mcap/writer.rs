//! Writes a recording, chunk by chunk.

use super::container::{Container, MessageHeader, NewChannel};
use super::{METADATA, RecordingInfo, WIRE_ENCODING};
use crate::compressed_image::{self as image, RecordedImage};
use crate::error::RecordingError;
use crate::foxglove::schema::Schema;
use crate::foxglove::{self, ViewerMessage};
use sextant_proto::{AnyMessage, VERSION};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Most channels of a file: a flood of keys must not fill the memory.
const MOST_CHANNELS: usize = 8192;
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
pub struct McapWriter<W> {
    path: PathBuf,
    file: Container<W>,
    /// Numbers of schemas by name.
    schemas: BTreeMap<String, u16>,
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

/// How the messages of a channel are encoded.
#[derive(Clone, Copy)]
struct Encoding<'a> {
    schema: &'a str,
    schema_encoding: &'a str,
    schema_text: &'a [u8],
    message: &'a str,
}

impl<W: Write> McapWriter<W> {
    /// Begins a recording; `path` is named in errors.
    ///
    /// # Errors
    /// An I/O error, as a full disk.
    pub fn begin(file: W, path: &Path, info: &RecordingInfo) -> Result<Self, RecordingError> {
        let library = format!("sextant {}", info.version);
        let about = [
            ("contract", VERSION.to_string()),
            ("site", info.site.clone()),
            ("version", info.version.clone()),
        ];
        let about = about.map(|(key, value)| (key.to_owned(), value)).into();
        let begun = Container::begin(file, &library).and_then(|mut file| {
            file.metadata(METADATA, &about)?;
            file.flush()?;
            Ok(file)
        });
        let file = begun.map_err(|cause| unwritable(path, cause))?;
        Ok(Self {
            path: path.to_owned(),
            file,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            metadata: BTreeMap::from([("contract".to_owned(), VERSION.to_string())]),
            messages: 0,
            dropped: 0,
        })
    }

    /// Writes a payload that arrived under a key, and what viewers show of it. A payload that is no message is dropped and counted.
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
        let kind = format!("{:?}", message.kind());
        let encoding = Encoding {
            schema: &kind,
            schema_encoding: "",
            schema_text: &[],
            message: WIRE_ENCODING,
        };
        self.write(key, encoding, payload, times)?;
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
        let shown = ViewerMessage {
            topic: image::topic(&image.camera),
            schema: Schema::CompressedImage,
            data: image::encode(image),
        };
        self.write_shown(&shown, times)
    }

    fn write_shown(
        &mut self,
        shown: &ViewerMessage,
        times: MessageTimes,
    ) -> Result<(), RecordingError> {
        let schema_text = shown.schema.text();
        let encoding = Encoding {
            schema: shown.schema.name(),
            schema_encoding: shown.schema.encoding(),
            schema_text: schema_text.as_bytes(),
            message: shown.schema.message_encoding(),
        };
        self.write(&shown.topic, encoding, &shown.data, times)
    }

    fn write(
        &mut self,
        topic: &str,
        encoding: Encoding<'_>,
        data: &[u8],
        times: MessageTimes,
    ) -> Result<(), RecordingError> {
        let is_new = !self.channels.contains_key(topic);
        if data.len() > MOST_BYTES || (is_new && self.channels.len() >= MOST_CHANNELS) {
            self.dropped += 1;
            return Ok(());
        }
        if is_new {
            let channel = self.add_channel(topic, encoding);
            self.channels.insert(topic.to_owned(), channel);
        }
        let Some(channel) = self.channels.get_mut(topic) else {
            return Ok(());
        };
        let header = MessageHeader {
            channel: channel.id,
            sequence: channel.next,
            log_ns: times.arrival_ns,
            publish_ns: times.capture_ns,
        };
        channel.next = channel.next.wrapping_add(1);
        let written = self.file.message(header, data);
        written.map_err(|cause| unwritable(&self.path, cause))?;
        self.messages += 1;
        Ok(())
    }

    fn add_channel(&mut self, topic: &str, encoding: Encoding<'_>) -> Channel {
        let schema = match self.schemas.get(encoding.schema) {
            Some(schema) => *schema,
            None => {
                let Encoding {
                    schema,
                    schema_encoding,
                    schema_text,
                    ..
                } = encoding;
                let id = self.file.schema(schema, schema_encoding, schema_text);
                self.schemas.insert(schema.to_owned(), id);
                id
            }
        };
        let id = self.file.channel(&NewChannel {
            schema,
            topic,
            encoding: encoding.message,
            metadata: &self.metadata,
        });
        Channel { id, next: 0 }
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
    pub fn finish(self) -> Result<W, RecordingError> {
        let finished = self.file.finish();
        finished.map_err(|cause| unwritable(&self.path, cause))
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

fn unwritable(path: &Path, source: io::Error) -> RecordingError {
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
